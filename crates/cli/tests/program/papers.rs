//! The JSON of all commands is what `docs/json.md` describes.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::sync::LazyLock;

use kugelblitz_tests::made_report::report;
use kugelblitz_tests::{gpu, npy, text_of};
use serde_json::{Value, json};

use crate::program::{ends, in_folder, material, run};

/// What says of each field of --json.
static DESCRIPTION: LazyLock<String> = LazyLock::new(|| text_of("docs/json.md"));

/// The head of every summary.
const HEAD: &[&str] = &["head"];

/// Commands with --json that print no summary.
const WITHOUT_SUMMARY: [&str; 3] = ["view", "completions", "man"];

/// Fields that need another machine: one with a device that fails.
const ELSEWHERE: [(&str, &str); 1] = [("probe", "adapters[].failure")];

struct Field {
    path: String,
    kind: String,
    is_optional: bool,
}

/// The tables of the description by their headings, and what was found of them and beyond them.
struct Described {
    sections: BTreeMap<String, Vec<Field>>,
    seen: BTreeSet<(String, String)>,
    wrong: Vec<String>,
}

/// What holds the path: `a[]` of `a[].b`, nothing of `a`.
fn parent(path: &str) -> &str {
    path.rsplit_once('.').map_or("", |(parent, _)| parent)
}

impl Described {
    fn new(text: &str) -> Described {
        let mut sections: BTreeMap<String, Vec<Field>> = BTreeMap::new();
        let mut section = String::new();
        for line in text.lines() {
            if line.starts_with('#') {
                section = line.trim_start_matches('#').trim().to_string();
            }
            let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
            if let [path, kind, stable, meaning] = cells[..]
                && let Some(path) = path.strip_prefix('`')
            {
                assert!(["yes", "no"].contains(&stable) && !meaning.is_empty(), "{line}");
                let kind = kind.strip_suffix(", optional");
                let is_optional = kind.is_some();
                let kind = kind.unwrap_or(cells[1]).to_string();
                let path = path.trim_end_matches('`').to_string();
                sections.entry(section.clone()).or_default().push(Field {
                    path,
                    kind,
                    is_optional,
                });
            }
        }
        Described { sections, seen: BTreeSet::new(), wrong: Vec::new() }
    }

    fn kind(&self, section: &str, path: &str) -> Option<String> {
        let field = self.sections.get(section)?.iter().find(|field| field.path == path)?;
        Some(field.kind.clone())
    }

    /// Looks at an object that is at `prefix` of a section and has the fields of these shapes too.
    fn object(&mut self, section: &str, prefix: &str, shapes: &[&str], value: &Value) {
        let Some(map) = value.as_object() else {
            return self.wrong.push(format!("{section}: `{prefix}` is no object: {value}"));
        };
        for (key, value) in map {
            let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            let own = self.kind(section, &path).map(|kind| (section, path.as_str(), kind));
            let shared = || {
                shapes.iter().find_map(|shape| Some((*shape, key.as_str(), self.kind(shape, key)?)))
            };
            match own.or_else(shared) {
                Some((section, path, kind)) => {
                    self.seen.insert((section.to_string(), path.to_string()));
                    self.value(section, path, &kind, value);
                }
                None => self.wrong.push(format!("{section}: `{path}` is not described")),
            }
        }
        let own = [(section, prefix)].into_iter().chain(shapes.iter().map(|shape| (*shape, "")));
        for (section, prefix) in own {
            for field in self.sections.get(section).into_iter().flatten() {
                let key = field.path.rsplit('.').next().unwrap_or_default();
                let is_here = parent(&field.path) == prefix && !map.contains_key(key);
                if is_here && !field.is_optional {
                    self.wrong.push(format!("{section}: `{}` is missing", field.path));
                }
            }
        }
    }

    fn value(&mut self, section: &str, path: &str, kind: &str, value: &Value) {
        let (kind, whole_may_be_null) = match kind.strip_suffix(", or null") {
            Some(kind) => (kind, true),
            None => (kind, false),
        };
        if whole_may_be_null && value.is_null() {
            return;
        }
        let (plain, may_be_null) = match kind.strip_suffix(" or null") {
            Some(plain) => (plain, true),
            None => (kind, false),
        };
        if let Some(of) = plain.strip_prefix("list of ") {
            let of = if may_be_null { format!("{of} or null") } else { of.to_string() };
            match value.as_array() {
                Some(values) => {
                    let element = format!("{path}[]");
                    values.iter().for_each(|value| self.value(section, &element, &of, value));
                }
                None => self.wrong.push(format!("{section}: `{path}` is no list: {value}")),
            }
            return;
        }
        let is_right = match plain {
            _ if value.is_null() => may_be_null,
            "text" => value.is_string(),
            "integer" => value.is_u64() || value.is_i64(),
            "number" => value.is_number(),
            "boolean" => value.is_boolean(),
            "map of text" => {
                value.as_object().is_some_and(|map| map.values().all(Value::is_string))
            }
            "object" => {
                self.object(section, path, &[], value);
                true
            }
            shape => {
                let name = shape.trim_start_matches('[').split(']').next().unwrap_or_default();
                assert!(self.sections.contains_key(name), "{section}: `{path}`: no shape {shape}");
                self.object(section, path, &[name], value);
                true
            }
        };
        if !is_right {
            self.wrong.push(format!("{section}: `{path}` is not {kind}: {value}"));
        }
    }

    /// Fields that were in no output.
    fn unseen(&self) -> Vec<(&str, &str)> {
        let all = self.sections.iter();
        let all =
            all.flat_map(|(name, of)| of.iter().map(move |field| (name.as_str(), &*field.path)));
        let is_unseen = |(section, path): &(&str, &str)| {
            !self.seen.contains(&(section.to_string(), path.to_string()))
                && !ELSEWHERE.contains(&(*section, *path))
        };
        all.filter(is_unseen).collect()
    }
}

/// The commands and, below `generate`, their commands.
fn commands() -> Vec<Vec<String>> {
    let below = |words: &[&str]| -> Vec<String> {
        let help = run(&[words, &["--help"]].concat(), 0).text().to_string();
        let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
        // Words that go on in the next line are farther in.
        let lines = lines.take_while(|line| !line.is_empty());
        let names = lines.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
        names.filter(|name| !["", "help"].contains(name)).map(str::to_string).collect()
    };
    let mut commands = Vec::new();
    for name in below(&[]) {
        let deeper = below(&[name.as_str()]);
        commands.extend(deeper.iter().map(|deeper| vec![name.clone(), deeper.clone()]));
        if deeper.is_empty() {
            commands.push(vec![name]);
        }
    }
    commands
}

/// Lines whose summaries have, taken together, all that is described.
const LINES: [&str; 32] = [
    "render scenes/lit/figure1.toml -o a.png --size 32x18 --device cpu --repeat 1",
    "render scenes/figure1.toml -o a.exr --size 32x18 --device gpu --certificates",
    "verify scenes/lit/figure1.toml --size 16x9 --device gpu --all-kernels",
    "verify scenes/figure1.toml --size 16x9 --device cpu",
    "info scenes/lit/figure1.toml",
    "info cloud.toml",
    "trace scenes/figure2.toml --rays rays.npy -o hits.npy",
    "explain tie.toml --pixel 64,36 --size 128x72",
    "explain tie.toml --pixel 70,40 --size 128x72",
    "explain tie.toml --pixel 38,37 --size 128x72",
    "explain tie.toml --ray 0,0,8,0,0,1",
    "explain tie.toml --ray 0,0.9,5,0,0,-1",
    "explain scenes/lit/figure1.toml --pixel 30,20 --size 64x36",
    "explain scenes/figure5.toml --ray 0,0,0,0,0,-1 --device cpu",
    "export pov scenes/lit/figure1.toml -o a.pov",
    "generate --count 10 -o b.npy --scene b.toml",
    "probe",
    "digest scenes/lit/figure1.toml --size 16x9 --device gpu --write kept.txt",
    "digest --check kept.txt",
    "new first.toml",
    "render scenes/figure2.toml -o shown.png --size 32x18 --device cpu --show id",
    "render scenes/figure5.toml -o d.png --size 321x181 --device cpu --show discriminant",
    "render scenes/lit/figure1.toml -o film.png --size 16x9 --turntable 2",
    "render scenes/lit/figure1.toml -o film.png --size 16x9 --turntable 2 --resume",
    "figure 4 -o figure4.svg",
    "figure 5 -o figure5.svg",
    "info a.exr",
    "info hits.npy",
    "compare a.png a.png",
    "compare a.exr scenes/figure1.toml",
    "compare hits.npy scenes/figure2.toml --rays rays.npy",
    "report scenes/lit/figure1.toml --size 16x9 --rounds 1",
];

#[test]
fn every_field_of_json_is_described_and_every_described_one_is_there() {
    gpu();
    let folder = material();
    ends(in_folder(&folder, "generate --count 3000 -o cloud.npy --scene cloud.toml"), 0);
    let mut described = Described::new(&DESCRIPTION);
    let mut commands_seen = BTreeSet::new();
    for line in LINES {
        let json = ends(in_folder(&folder, &format!("{line} --json -q")), 0).json();
        let command = json["command"].as_str().unwrap().to_string();
        assert!(line.starts_with(&command), "{line}: {command}");
        let section = match line {
            _ if line.contains("--turntable") => "film",
            _ if line.contains("--check") => "digests",
            _ if line.starts_with("info") && line.ends_with(".toml") => "cost",
            _ => &command,
        };
        described.object(section, "", HEAD, &json);
        commands_seen.insert(command);
    }
    let report = serde_json::to_value(report()).unwrap();
    described.object("report", "", &[], &report);

    // Failures, alone and beside what the command found.
    let turned = "render scenes/figure1.toml -o turned.npy --size 32x18 --device cpu --up=-y";
    ends(in_folder(&folder, turned), 0);
    for line in [
        "compare a.png shown.png --json",
        "compare a.exr scenes/figure2.toml --json",
        "compare turned.npy scenes/figure1.toml --json",
    ] {
        let failed = ends(in_folder(&folder, line), 6).json();
        let command = failed["command"].as_str().unwrap().to_string();
        described.object(&command, "", &["head", "failure"], &failed);
    }
    let failed = ends(in_folder(&folder, "info wrong.toml --json"), 3).json();
    described.object("failure", "", HEAD, &failed);
    // Errors in data: in a line, and in a row.
    fs::write(folder.path().join("wrong.csv"), "x,y,z,r\n0,0,zero,1\n").unwrap();
    let rows = npy(&[vec![0.0, 0.0, f64::NAN, 1.0]], "<f8", false);
    fs::write(folder.path().join("wrong.npy"), rows).unwrap();
    for name in ["wrong.csv", "wrong.npy"] {
        let failed = ends(in_folder(&folder, &format!("info {name} --json")), 3).json();
        described.object("failure", "", HEAD, &failed);
    }
    let mut without_driver = in_folder(&folder, "probe --json");
    without_driver.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
    let found = ends(without_driver, 4).json();
    described.object("probe", "", &["head", "failure"], &found);

    assert_eq!(described.wrong, [""; 0], "docs/json.md and the program differ");
    let unseen = described.unseen();
    assert!(unseen.is_empty(), "described in docs/json.md and in no output: {unseen:#?}");
    for words in commands() {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let help = run(&[&words[..], &["--help"]].concat(), 0);
        let is_exempt = WITHOUT_SUMMARY.contains(&words[0]);
        if help.text().contains("--json") && !is_exempt {
            assert!(commands_seen.contains(words[0]), "the JSON of {words:?} is not looked at");
        }
    }
}

/// Spoils a summary.
type Change = fn(&mut Value);

#[test]
fn a_field_that_is_not_as_described_is_noticed() {
    let json = json!({"schema": 1, "version": "0.1.0", "command": "digest", "adapter": null,
        "scene": "a.toml", "device": "cpu", "size": [16, 9], "samples": 1, "objects": {"spheres": 1, "planes": 0},
        "digest": "kb2:"});
    let wrong = |change: Change, text: &str| {
        let (mut described, mut json) = (Described::new(text), json.clone());
        change(&mut json);
        described.object("digest", "", HEAD, &json);
        described.wrong
    };
    assert_eq!(wrong(|_| {}, &DESCRIPTION), [""; 0]);
    let changes: [(Change, &str); 7] = [
        (|json| json["colour"] = 1.into(), "`colour` is not described"),
        (|json| json["objects"]["cones"] = 1.into(), "`objects.cones` is not described"),
        (|json| drop(json.as_object_mut().unwrap().remove("size")), "`size` is missing"),
        (
            |json| drop(json["objects"].as_object_mut().unwrap().remove("planes")),
            "`planes` is missing",
        ),
        (|json| json["samples"] = "1".into(), "`samples` is not integer"),
        (|json| json["size"][1] = 9.5.into(), "`size[]` is not integer"),
        (|json| json["device"] = Value::Null, "`device` is not text"),
    ];
    for (change, expected) in changes {
        let found = wrong(change, &DESCRIPTION);
        assert!(found.len() == 1 && found[0].contains(expected), "{expected}: {found:?}");
    }
    let shorter = DESCRIPTION.replace("| `digest` | text |", "| digest | text |");
    assert!(wrong(|_| {}, &shorter)[0].contains("`digest` is not described"));
    let longer = Described::new(&DESCRIPTION);
    assert!(longer.unseen().len() > 300, "{}", longer.unseen().len());
}
