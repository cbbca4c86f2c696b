//! What the program says on paper: the JSON that `docs/json.md` describes, failures in it, the manual
//! pages.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::time::Duration;

use kugelblitz::scene::parse_scene;
use kugelblitz_tests::made_report::whole_report;
use kugelblitz_tests::{gpu, npy, root, text_of};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::program::{Ran, ends, finish, program, run, scene_file};

// The JSON and its description.

/// What says of each field of --json.
static DESCRIPTION: LazyLock<String> = LazyLock::new(|| text_of("docs/json.md"));

/// The head of every summary.
const HEAD: &[&str] = &["head"];

/// Commands with --json that print no summary.
const WITHOUT_SUMMARY: [&str; 1] = ["view"];

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

/// A scene in which a ray can tie, and one whose light is hidden; and rays.
fn material(folder: &TempDir) {
    let tie = r##"
        [camera]
        position = [0, 0, 5]
        look_at = [0, 0, 0]
        [[sphere]]
        center = [0, 0, 0]
        radius = 1
        color = "red"
        [[sphere]]
        center = [0, 0, 0]
        radius = 1
        color = "#0f0"
        [[sphere]]
        center = [9, 0, 0]
        radius = 1
        color = "blue"
        [[sphere]]
        center = [0, 0, 3]
        radius = 0.1
        color = "white"
        [[plane]]
        point = [0, 0, -9]
        normal = [0, 0, 1]
        color = "#888888"
        [[light]]
        position = [0, 0, -5]
        [[light]]
        position = [3, 0.2, 8]
        [sky]
        intensity = 0.5
        directions = 8
    "##;
    fs::write(folder.path().join("tie.toml"), tie).unwrap();
    fs::write(folder.path().join("wrong.toml"), "[camera]\nlookat = [0, 0, 0]\n").unwrap();
    let rays = [vec![0.0, 0.0, 0.0, 1.6, 0.3, -12.0], vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0]];
    fs::write(folder.path().join("rays.npy"), npy(&rays, "<f8", false)).unwrap();
    symlink(root().join("scenes"), folder.path().join("scenes")).unwrap();
}

fn in_folder(folder: &TempDir, line: &str) -> Command {
    let mut command = program(&line.split_whitespace().collect::<Vec<_>>());
    command.current_dir(folder);
    command
}

/// Lines whose summaries have, taken together, all that is described.
const LINES: [&str; 30] = [
    "render scenes/lit/figure1.toml -o a.png --size 32x18 --device cpu --repeat 1",
    "render scenes/figure1.toml -o a.exr --size 32x18 --device gpu --certificates",
    "verify scenes/lit/figure1.toml --size 16x9 --device gpu --all-kernels",
    "verify scenes/figure1.toml --size 16x9 --device cpu",
    "check scenes/lit/figure1.toml",
    "check cloud.toml",
    "trace scenes/figure2.toml --rays rays.npy -o hits.npy",
    "explain tie.toml --pixel 64,36 --size 128x72",
    "explain tie.toml --pixel 70,40 --size 128x72",
    "explain tie.toml --pixel 38,37 --size 128x72",
    "explain tie.toml --ray 0,0,8,0,0,1",
    "explain tie.toml --ray 0,0.9,5,0,0,-1",
    "explain scenes/lit/figure1.toml --pixel 30,20 --size 64x36",
    "explain scenes/figure5.toml --ray 0,0,0,0,0,-1 --device cpu",
    "export pov scenes/lit/figure1.toml -o a.pov",
    "generate cloud --count 10 -o b.npy --scene b.toml",
    "probe",
    "digest scenes/lit/figure1.toml --size 16x9 --device gpu",
    "render scenes/figure2.toml -o shown.png --size 32x18 --device cpu --show id",
    "render scenes/figure5.toml -o d.png --size 321x181 --device cpu --show discriminant",
    "render scenes/lit/figure1.toml -o film.png --size 16x9 --turntable 2",
    "render scenes/lit/figure1.toml -o film.png --size 16x9 --turntable 2 --resume",
    "figure 4 -o figure4.svg",
    "info a.exr",
    "info hits.npy",
    "compare a.png a.png",
    "judge scenes/figure1.toml --against a.exr",
    "judge scenes/figure2.toml --against hits.npy --rays rays.npy",
    "report scenes/lit/figure1.toml --size 16x9 --rounds 1 -o before.json",
    "report scenes/lit/figure1.toml --size 16x9 --rounds 1 --baseline before.json",
];

#[test]
fn every_field_of_json_is_described_and_every_described_one_is_there() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    material(&folder);
    ends(in_folder(&folder, "generate cloud --count 3000 -o cloud.npy --scene cloud.toml"), 0);
    let mut described = Described::new(&DESCRIPTION);
    let mut commands_seen = BTreeSet::new();
    for line in LINES {
        let json = ends(in_folder(&folder, &format!("{line} --json -q")), 0).json();
        let command = json["command"].as_str().unwrap().to_string();
        assert!(line.starts_with(&command), "{line}: {command}");
        let section = if line.contains("--turntable") { "film" } else { &command };
        described.object(section, "", HEAD, &json);
        commands_seen.insert(command);
    }
    let report = serde_json::to_value(whole_report()).unwrap();
    described.object("report", "", &[], &report);

    // Failures, alone and beside what the command found.
    for line in
        ["compare a.png shown.png --json", "judge scenes/figure2.toml --against a.exr --json"]
    {
        let failed = ends(in_folder(&folder, line), 6).json();
        let command = failed["command"].as_str().unwrap().to_string();
        described.object(&command, "", &["head", "failure"], &failed);
    }
    let failed = ends(in_folder(&folder, "check wrong.toml --json"), 3).json();
    described.object("failure", "", HEAD, &failed);
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
        "device": "cpu", "size": [16, 9], "samples": 1, "objects": {"spheres": 1, "planes": 0},
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

// Failures.

/// One JSON object on standard output, with the exit code and the words of standard error.
#[track_caller]
fn assert_failure(ran: &Ran, code: i32) {
    let json = ran.json();
    assert_eq!((ran.code, &json["code"]), (code, &code.into()), "{json}");
    let error = json["error"].as_str().unwrap();
    let first = error.lines().next().unwrap();
    assert!(!first.is_empty() && ran.stderr.contains(first), "{first:?}\n{}", ran.stderr);
    let schema = if json["command"] == "report" { 2 } else { 1 };
    assert_eq!(json["schema"], schema);
}

#[test]
fn every_failure_is_told_in_json() {
    let folder = tempfile::tempdir().unwrap();
    material(&folder);
    for (line, code) in [
        ("render scenes/figure1.toml -o no/such/folder.png --device cpu", 1),
        ("report scenes/figure1.toml --baseline tie.toml --device cpu", 1),
        ("render scenes/figure1.toml", 2),
        ("render scenes/figure1.toml -o a.jpg", 2),
        ("render scenes/figure1.toml -o a.png --kernel magic", 2),
        ("rendr", 2),
        ("check missing.toml", 3),
        ("render wrong.toml -o a.png", 3),
        ("render scenes/figure1.toml -o a.png --device nothing-like-it", 4),
        ("render scenes/figure1.toml -o a.png --size 99999x9", 7),
    ] {
        let ran = finish(in_folder(&folder, &format!("{line} --json")));
        assert_failure(&ran, code);
        let json = ran.json();
        let command = line.split(' ').next().filter(|word| *word != "rendr");
        assert_eq!(json["command"].as_str(), command, "{json}");
        assert_eq!(json["place"].is_object(), code == 3, "{json}");
        assert_eq!(finish(in_folder(&folder, line)).stdout, b"", "{line}");
    }
    let place = ends(in_folder(&folder, "check wrong.toml --json"), 3).json()["place"].clone();
    assert_eq!((&place["line"], &place["column"]), (&2.into(), &1.into()));
    assert!(place["help"].as_str().unwrap().contains("did you mean `look_at`?"), "{place}");
    // Help and version are no failures.
    assert!(run(&["render", "--json", "--help"], 0).text().contains("Usage"));
}

/// `verify` has no output file, so none is spoken of.
#[test]
fn an_interrupted_verify_does_not_speak_of_output_files() {
    let scene = scene_file("figure1");
    let args = ["verify", &scene, "--size", "16000x16000", "--samples", "100000000", "--json"];
    let child = program(&[&args[..], &["--device", "cpu"]].concat()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let pid = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), stderr.as_str()), (Some(130), "error: interrupted\n"));
    // Work that did not end by itself says nothing there.
    if !output.stdout.is_empty() {
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((&json["code"], &json["error"]), (&130.into(), &"interrupted".into()));
    }
}

#[test]
fn the_version_tells_commit_and_features() {
    let short = run(&["-V"], 0).text().to_string();
    assert_eq!(short, format!("kugelblitz {}\n", env!("CARGO_PKG_VERSION")));
    let long = run(&["--version"], 0).text().to_string();
    let lines: Vec<&str> = long.lines().collect();
    assert_eq!(lines[0], short.trim());
    let commit = lines[1].strip_prefix("commit ").expect("a commit");
    let is_hash = commit.len() == 12 && commit.bytes().all(|byte| byte.is_ascii_hexdigit());
    let is_checked_out = root().join(".git").exists();
    match std::env::var("KUGELBLITZ_COMMIT") {
        Ok(told) => assert_eq!(commit, told),
        Err(_) => assert!(if is_checked_out { is_hash } else { commit == "unknown" }, "{long}"),
    }
    let features = lines[2].strip_prefix("features ").expect("features");
    assert_eq!(features.contains("view"), cfg!(feature = "view"), "{long}");
    assert!(features.starts_with("gpu"), "{long}");
}

// Manual pages.

/// Roff as it is read, roughly.
fn plain_roff(page: &str) -> String {
    page.replace("\\-", "-").replace("\\fB", "").replace("\\fI", "").replace("\\fR", "")
}

fn pages(folder: &TempDir) -> BTreeMap<String, String> {
    ends(in_folder(folder, "man --dir man/pages"), 0);
    let entries = fs::read_dir(folder.path().join("man/pages")).unwrap();
    let page = |entry: Result<fs::DirEntry, std::io::Error>| {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        (name, plain_roff(&fs::read_to_string(entry.path()).unwrap()))
    };
    entries.map(page).collect()
}

#[test]
fn every_command_has_a_manual_page_with_all_sections() {
    let folder = tempfile::tempdir().unwrap();
    let pages = pages(&folder);
    let mut expected: BTreeSet<String> =
        ["kugelblitz.1", "kugelblitz-scene.5"].map(String::from).into();
    for words in commands() {
        for n in 1..=words.len() {
            expected.insert(format!("kugelblitz-{}.1", words[..n].join("-")));
        }
    }
    assert_eq!(pages.keys().cloned().collect::<BTreeSet<_>>(), expected);
    for (name, page) in pages.iter().filter(|(name, _)| name.ends_with(".1")) {
        let mut sections = vec!["NAME", "SYNOPSIS", "EXIT STATUS", "SEE ALSO"];
        if name != "kugelblitz-generate.1" {
            sections.push("EXAMPLES");
        }
        for section in sections {
            let head = format!("\n.SH {section}\n");
            let quoted = format!("\n.SH \"{section}\"\n");
            assert!(
                page.contains(&head) || page.contains(&quoted),
                "{name} lacks {section}: {page}"
            );
        }
        assert!(page.starts_with(".ie") && page.contains(".TH"), "{name}");
        assert!(page.contains("130  interrupted"), "{name}");
    }
    for variable in ["RAYON_NUM_THREADS", "WGPU_ADAPTER_NAME"] {
        assert!(pages["kugelblitz.1"].contains(variable), "{variable}");
    }
    // One page is the same as among all.
    let one = plain_roff(run(&["man", "generate", "cloud"], 0).text());
    assert_eq!(one, pages["kugelblitz-generate-cloud.1"]);
    assert_eq!(plain_roff(run(&["man", "scene"], 0).text()), pages["kugelblitz-scene.5"]);
    let ran = run(&["man", "rendr"], 2);
    assert!(ran.stderr.contains("did you mean `render`?"), "{}", ran.stderr);
    run(&["man", "render", "--dir", "x"], 2);
}

#[test]
fn the_examples_of_the_manual_pages_run() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    material(&folder);
    for picture in ["figure1.toml -o figure1.png", "figure2.toml -o figure2.exr"] {
        ends(in_folder(&folder, &format!("render scenes/{picture} --size 32x18 -q")), 0);
    }
    let bin = Path::new(env!("CARGO_BIN_EXE_kugelblitz")).parent().unwrap();
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let mut n_lines = 0;
    for (name, page) in pages(&folder).iter().filter(|(name, _)| name.ends_with(".1")) {
        let examples = page.split_once("\n.SH EXAMPLES\n").map_or("", |(_, rest)| rest);
        let blocks = examples.split("\n.nf\n").skip(1);
        let blocks = blocks.map(|rest| rest.split("\n.fi").next().unwrap());
        for line in blocks.flat_map(str::lines).filter(|line| !line.contains("kugelblitz view")) {
            let mut shell = Command::new("sh");
            shell.args(["-e", "-c", line]).current_dir(&folder).env("PATH", &path);
            let output = shell.stdin(Stdio::null()).output().unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{name}: {line}\n{stderr}");
            n_lines += 1;
        }
    }
    assert!(n_lines >= 17, "{n_lines} lines");
}

/// What the program knows of a table, from its own words upon a key that is none.
fn known_keys(header: &str) -> Vec<String> {
    let text = match header {
        "" => "zzz = 1\n".to_string(),
        _ => format!("{header}\nzzz = 1\n"),
    };
    match parse_scene(&text, "a.toml".as_ref()) {
        Err(kugelblitz::Error::Scene(error)) => {
            let keys = error.help.split_once("known keys here: ").map_or("", |(_, keys)| keys);
            keys.split(", ").filter(|key| !key.is_empty()).map(str::to_string).collect()
        }
        other => panic!("{header}: {other:?}"),
    }
}

#[test]
fn the_page_about_scenes_has_every_key() {
    let page = plain_roff(run(&["man", "scene"], 0).text());
    let mut headers = vec![String::new()];
    for key in known_keys("") {
        let is_table = [format!("[{key}]"), format!("[[{key}]]")];
        headers.extend(is_table.into_iter().filter(|header| !known_keys(header).is_empty()));
    }
    assert!(headers.len() >= 8, "{headers:?}");
    for header in headers {
        let title = if header.is_empty() { "TOP OF THE FILE" } else { &header };
        let titled =
            page.split("\n.SH ").find(|section| section.trim_matches('"').starts_with(title));
        let section = titled.unwrap_or_else(|| panic!("no section {title}"));
        for key in known_keys(&header) {
            let is_table = header.is_empty() && page.contains(&format!("[{key}]"));
            let is_there = section.contains(&format!("\n{key} = "));
            assert!(is_table || is_there, "`{key}` is not in the section {title}: {section}");
        }
    }
    let example = page.split("\n.nf\n").nth(1).unwrap().split("\n.fi").next().unwrap();
    let scene = parse_scene(example, "example.toml".as_ref()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((scene.spheres.len(), scene.planes.len(), scene.lights.len()), (1, 1, 1));
}
