//! Data as programs write them, in `tests/data/programs`: spheres, colours and notes, or the error with advice that works.
//!
//! Advice is tested by following it: the settings of a hint become keys of the cloud, and the same file must then be readable.

mod boxes;
mod cases;
mod foreign;
mod tables;

use std::cell::RefCell;
use std::fs;
use std::path::Path;

use kugelblitz::Control;
use kugelblitz::error::{Error, Hint, SceneError, Setting, SettingValue};
use kugelblitz::scene::schema::{CloudKeys, read_value, table};
use kugelblitz::scene::{Color, Composed, Scene, SceneOverrides, compose_scene, hex};
use kugelblitz_tests::folder::Folder;
use kugelblitz_tests::root;
use toml::{Table, Value};

use cases::{Cure, READABLE, REFUSED, Readable, Refused};

/// Keys of a cloud, as TOML.
#[derive(Clone, Debug, Default, PartialEq)]
struct Keys(Table);

impl Keys {
    fn new(toml: &str) -> Keys {
        Keys(toml.parse().expect("keys of a cloud"))
    }

    fn overrides(&self) -> SceneOverrides {
        let inline = Value::Table(self.0.clone()).to_string();
        let cloud = read_value("spheres", &inline, table::<CloudKeys>).expect("keys of a cloud");
        SceneOverrides { cloud, ..SceneOverrides::default() }
    }

    /// Makes a setting. The columns that are already named stay.
    fn set(&mut self, setting: &Setting) {
        let value = setting.value.as_ref().expect("a setting with a value").to_string();
        let value = Keys::new(&format!("value = {value}")).0.remove("value").expect("a value");
        match (self.0.get_mut(setting.key), value) {
            (Some(Value::Table(old)), Value::Table(new)) => old.extend(new),
            (_, value) => drop(self.0.insert(setting.key.into(), value)),
        }
    }
}

/// Reads a file as bare data, without any scene file.
fn read(path: &Path, keys: &Keys) -> kugelblitz::Result<Composed> {
    compose_scene(path, &keys.overrides(), &Control::default())
}

fn folder() -> std::path::PathBuf {
    root().join("tests/data/programs")
}

/// Returns all files of programs, with the keys of each case: name, keys and content.
pub fn files_with_keys() -> Vec<(&'static str, SceneOverrides, Vec<u8>)> {
    let readable = READABLE.iter().map(|case| (case.file, case.keys));
    let refused = REFUSED.iter().map(|case| (case.file, case.keys));
    let dumps = boxes::DUMPS.into_iter().map(|file| (file, ""));
    let all = readable.chain(refused).chain(dumps);
    let content = |file| fs::read(folder().join(file)).expect("a file");
    all.map(|(file, keys)| (file, Keys::new(keys).overrides(), content(file))).collect()
}

/// Returns the spheres as text: x, y, z, radius and the sRGB bytes of the colour.
fn spheres_of(scene: &Scene) -> Vec<String> {
    let colors = scene.spheres.colors();
    let spheres = scene.spheres.iter().zip(colors).map(|(sphere, color)| {
        let [x, y, z] = sphere.center.to_array();
        format!("{x} {y} {z} {} {}", sphere.radius, hex(color.to_srgb8()))
    });
    spheres.collect()
}

/// Returns the first difference between spheres as text and the spheres of a scene: numbers bit for bit, colours as sRGB bytes.
fn difference(expected: &[&str], scene: &Scene) -> Option<String> {
    let parsed = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        let [x, y, z, radius, color] = words[..] else { panic!("x y z radius color: {line}") };
        let bits = [x, y, z, radius].map(|word| word.parse::<f64>().expect("a number").to_bits());
        (bits, Color::parse(color).expect("a colour").to_srgb8())
    };
    let colors = scene.spheres.colors();
    let found = scene.spheres.iter().zip(colors).map(|(sphere, color)| {
        let [x, y, z] = sphere.center.to_array();
        ([x, y, z, sphere.radius].map(f64::to_bits), color.to_srgb8())
    });
    let is_same = found.eq(expected.iter().map(|line| parsed(line)));
    (!is_same).then(|| format!("expected {expected:#?}, found {:#?}", spheres_of(scene)))
}

/// Returns the notes without the paths before them.
fn notes_of(composed: &Composed, path: &Path) -> Vec<String> {
    let notes = composed.notes.iter().chain(&composed.scene.notes);
    let before = format!("{}: ", path.display());
    notes.map(|note| note.worded(Setting::to_string).replace(&before, "")).collect()
}

/// Returns the error of a scene, which data files have.
fn refusal(error: Error) -> Box<SceneError> {
    match error {
        Error::Scene(error) => error,
        other => panic!("expected an error about data, found {other}"),
    }
}

/// Returns the place of an error: line, row, column and key, each if it is known.
fn place_of(error: &SceneError) -> String {
    let subject = &error.subject;
    let parts = [
        subject.line.map(|line| format!("line {line}")),
        subject.row.map(|row| format!("row {row}")),
        subject.column.as_ref().map(|column| format!("column {column}")),
        subject.key.map(|key| format!("key {key}")),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Stands for a setting in the text of a hint.
const MARK: &str = "\u{1}";

/// Returns the alternatives that a hint offers: settings joined by "and" belong together.
fn alternatives(hint: &Hint) -> Vec<Vec<(Setting, bool)>> {
    let settings = RefCell::new(Vec::new());
    let text = hint.worded(|setting| {
        settings.borrow_mut().push(setting.clone());
        MARK.into()
    });
    let mut all: Vec<Vec<(Setting, bool)>> = Vec::new();
    for (before, setting) in text.split(MARK).zip(settings.into_inner()) {
        let is_removed = before.ends_with("remove ");
        match all.last_mut() {
            Some(last) if before == " and " => last.push((setting, is_removed)),
            _ => all.push(vec![(setting, is_removed)]),
        }
    }
    all
}

/// Returns the keys after one alternative of a hint was followed.
fn followed(keys: &Keys, alternative: &[(Setting, bool)]) -> Keys {
    let mut keys = keys.clone();
    for (setting, is_removed) in alternative {
        if *is_removed {
            assert!(keys.0.remove(setting.key).is_some(), "`{}` was not given", setting.key);
        } else {
            keys.set(setting);
        }
    }
    keys
}

/// Whether a setting is an example with a name to be filled in.
fn has_blank((setting, _): &(Setting, bool)) -> bool {
    let is_blank = |value: &SettingValue| *value == SettingValue::Text("NAME".into());
    match &setting.value {
        Some(SettingValue::Table(entries)) => entries.iter().any(|(_, value)| is_blank(value)),
        Some(value) => is_blank(value),
        None => false,
    }
}

#[test]
fn files_of_programs_are_read() {
    let mut failures = Vec::new();
    for Readable { file, keys, spheres, notes } in READABLE {
        let path = folder().join(file);
        let case = format!("{file} with `{keys}`");
        match read(&path, &Keys::new(keys)) {
            Err(error) => failures.push(format!("{case}: {error}")),
            Ok(composed) => {
                failures.extend(
                    difference(spheres, &composed.scene).map(|text| format!("{case}: {text}")),
                );
                let found = notes_of(&composed, &path);
                if found != *notes {
                    failures
                        .push(format!("{case}: expected the notes {notes:#?}, found {found:#?}"));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn refused_files_are_readable_once_the_advice_is_followed() {
    let mut failures = Vec::new();
    for case in REFUSED {
        let name = format!("{} with `{}`", case.file, case.keys);
        if let Err(text) = std::panic::catch_unwind(|| check_refusal(case)) {
            let text = text.downcast::<String>().map_or("panic".into(), |text| *text);
            failures.push(format!("{name}: {text}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

fn check_refusal(case: &Refused) {
    let Refused { file, keys, place, value, message, hint, cure } = case;
    let path = folder().join(file);
    let keys = Keys::new(keys);
    let error = refusal(read(&path, &keys).expect_err("the file is refused"));
    let found = [&place_of(&error), error.value.as_deref().unwrap_or(""), &error.message];
    let before = format!("{}/", folder().display());
    let found = [found[0], found[1], found[2], &error.hint.to_string().replace(&before, "")];
    assert_eq!(found, [*place, *value, *message, *hint]);
    assert_eq!(error.path, path);
    assert!(error.subject.file.as_ref().is_none_or(|file| *file == path));
    let all = alternatives(&error.hint);
    let differs = |scene: &Scene, expected: &[&str]| {
        if let Some(text) = difference(expected, scene) {
            panic!("after the advice: {text}");
        }
    };
    match cure {
        Cure::Settings(expected) => {
            let filled = all.iter().filter(|settings| !settings.iter().any(has_blank));
            let mut readings = filled.map(|settings| {
                let keys = followed(&keys, settings);
                let composed = read(&path, &keys)
                    .unwrap_or_else(|error| panic!("after the advice {settings:?}: {error}"));
                composed.scene
            });
            differs(&readings.next().expect("a setting"), expected);
            readings.for_each(|scene| assert!(!scene.spheres.is_empty()));
        }
        Cure::Steps(choices, expected) => {
            let (mut keys, mut hint) = (keys, error.hint.clone());
            for (step, choice) in choices.iter().enumerate() {
                keys = followed(&keys, &alternatives(&hint)[*choice]);
                match read(&path, &keys) {
                    Ok(composed) => {
                        assert_eq!(step + 1, choices.len(), "fewer steps are enough");
                        differs(&composed.scene, expected);
                    }
                    Err(error) => {
                        assert!(step + 1 < choices.len(), "after all steps: {error}");
                        hint = refusal(error).hint.clone();
                    }
                }
            }
        }
        Cure::Edit(old, new, expected) => {
            assert!(all.is_empty(), "the hint has settings: {all:?}");
            let text = fs::read_to_string(&path).expect("a text");
            assert!(text.contains(old), "{text}");
            let folder = Folder::default();
            folder.write(file, text.replace(old, new));
            let composed = read(&folder.path(file), &keys);
            differs(&composed.unwrap_or_else(|error| panic!("edited: {error}")).scene, expected);
        }
        Cure::Unknown => {}
        Cure::Elsewhere => assert!(all.is_empty(), "the hint has settings: {all:?}"),
    }
}

/// Names under which data come: of other formats, of scenes, with numbers after them, and without an ending.
const NAMES: [&str; 7] =
    ["data", "data.toml", "data.csv", "data.npy", "data.dump.1000", "data.gz", "Data (copy).BIN"];

#[test]
fn a_files_name_does_not_matter() {
    let folder = Folder::default();
    for Readable { file, keys, spheres, .. } in READABLE {
        // Points without a header are coordinates only in a file `.xyz`.
        if *file == "lidar.xyz" {
            continue;
        }
        let bytes = fs::read(self::folder().join(file)).expect("a file");
        for name in NAMES {
            folder.write(name, &bytes);
            let composed = read(&folder.path(name), &Keys::new(keys))
                .unwrap_or_else(|error| panic!("{file} as {name}: {error}"));
            let found = difference(spheres, &composed.scene);
            assert!(found.is_none(), "{file} as {name}: {}", found.unwrap_or_default());
        }
    }
}

/// Spoils each number and each colour of each sphere, one at a time.
#[test]
fn a_wrong_sphere_is_noticed() {
    let mut n_spoiled = 0;
    for Readable { file, keys, spheres, .. } in READABLE {
        let Composed { scene, .. } = read(&folder().join(file), &Keys::new(keys)).expect(file);
        assert_eq!(difference(spheres, &scene), None);
        for (at, line) in spheres.iter().enumerate() {
            let words: Vec<&str> = line.split(' ').collect();
            for place in 0..words.len() {
                let mut wrong: Vec<String> = words.iter().map(|word| (*word).into()).collect();
                wrong[place] = match wrong[place].parse::<f64>() {
                    Ok(number) => number.next_up().to_string(),
                    Err(_) => {
                        let mut bytes = Color::parse(words[place]).expect("a colour").to_srgb8();
                        bytes[at % 3] ^= 1;
                        hex(bytes)
                    }
                };
                let wrong = wrong.join(" ");
                let mut lines = spheres.to_vec();
                lines[at] = &wrong;
                assert!(difference(&lines, &scene).is_some(), "{file}: {wrong} instead of {line}");
                n_spoiled += 1;
            }
        }
        assert!(difference(&spheres[1..], &scene).is_some(), "{file}: a sphere more");
        let repeated = [spheres, &spheres[..1]].concat();
        assert!(difference(&repeated, &scene).is_some(), "{file}: a sphere less");
    }
    assert!(n_spoiled > 500, "{n_spoiled}");
}

/// Makes wrong settings of a hint: they must not pass as advice that works.
#[test]
fn wrong_advice_is_noticed() {
    let path = folder().join("twod.csv");
    let works =
        |setting: Setting| read(&path, &followed(&Keys::default(), &[(setting, false)])).is_ok();
    assert!(works(Setting::column("z", SettingValue::Number("0.0".into()))));
    assert!(!works(Setting::column("z", SettingValue::Number("9".into()))));
    assert!(!works(Setting::column_named("z", "NAME")));
    assert!(!works(Setting::number("frame", 0.0)));
    let settings =
        [Setting::named("radius"), Setting::no_column("radius"), Setting::text("color", "red")];
    let hint = Hint::new("remove {}, or give {} and {}", settings);
    let shape: Vec<Vec<bool>> = alternatives(&hint)
        .iter()
        .map(|settings| settings.iter().map(|(_, is_removed)| *is_removed).collect())
        .collect();
    assert_eq!(shape, [vec![true], vec![false, false]]);
}

#[cfg(unix)]
#[test]
fn frames_of_a_pipe_count_from_the_first_one() {
    let folder = Folder::default();
    let text = fs::read(self::folder().join("trajectory.xyz")).expect("a file");
    let through_pipe = |name: &str, keys: &str| {
        let pipe = folder.path(name);
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
        assert!(made.success());
        let (to, text) = (pipe.clone(), text.clone());
        let writer = std::thread::spawn(move || fs::write(to, text));
        let read = read(&pipe, &Keys::new(keys));
        // A reader that refuses the pipe may close it before all is written.
        let _ = writer.join().expect("a writer");
        read
    };
    let composed = through_pipe("a", "frame = 1").expect("frame 1");
    assert_eq!(difference(&["1 0 0 1.5 #ff0d0d", "1 1 0 1.2 #ffffff"], &composed.scene), None);
    let error = refusal(through_pipe("b", "frame = -1").expect_err("frame -1"));
    assert_eq!(error.message, "frames can be counted from the last one only in a regular file");
    let keys = followed(&Keys::new("frame = -1"), &alternatives(&error.hint)[0]);
    let composed = through_pipe("c", &keys.0.to_string()).expect("the advice works");
    assert_eq!(difference(&["0 0 0 1.5 #ff0d0d", "0 1 0 1.2 #ffffff"], &composed.scene), None);
}

/// Every file of the folder is a case of a test.
#[test]
fn no_file_is_left_out() {
    let mut used: Vec<&str> = READABLE.iter().map(|case| case.file).collect();
    used.extend(REFUSED.iter().map(|case| case.file));
    used.extend(foreign::FOREIGN.iter().map(|(file, ..)| *file));
    used.extend(boxes::DUMPS);
    for entry in fs::read_dir(folder()).expect("the folder") {
        let name = entry.expect("an entry").file_name().into_string().expect("a name");
        assert!(used.contains(&&name[..]), "{name} is in no test");
    }
}
