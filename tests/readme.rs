//! The README is run: its commands, its scene, its example, its tables.

mod common;

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use glam::DVec3;
use kugelblitz::picture::Format;
use kugelblitz::scene::{Color, Light, Projection, Scene, Sky, Source, Sphere, parse_scene};
use tempfile::TempDir;

use common::npy;

const README: &str = include_str!("../README.md");
const CRATE_DOCS: &str = include_str!("../src/lib.rs");
const CARGO_RUN: &str = "cargo run --release -- ";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The texts of the fenced blocks of a language.
fn blocks(language: &str) -> Vec<&'static str> {
    let fence = format!("\n```{language}\n");
    let blocks: Vec<_> = README
        .split(&fence)
        .skip(1)
        .map(|rest| rest.split_once("```").expect("a closed block").0)
        .collect();
    assert!(!blocks.is_empty(), "the README has no {language} block");
    blocks
}

/// The cells of the table whose head begins with `first`.
fn table(first: &str) -> Vec<Vec<&'static str>> {
    let head = format!("| {first} |");
    let rows: Vec<_> = README
        .lines()
        .skip_while(|line| !line.starts_with(&head))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect())
        .collect();
    assert!(!rows.is_empty(), "the README has no table that begins with {first}");
    rows
}

/// `x` of "`x`".
fn code(cell: &str) -> &str {
    cell.strip_prefix('`').and_then(|rest| rest.split_once('`')).expect("code").0
}

/// Runs a line of shell in `folder`, with the program in the path.
fn shell(line: &str, folder: &Path) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_kugelblitz")).parent().unwrap();
    let path = format!("{}:{}", program.display(), env::var("PATH").unwrap());
    Command::new("sh")
        .args(["-e", "-c", line])
        .current_dir(folder)
        .env("PATH", path)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn run(line: &str, folder: &Path) -> String {
    let output = shell(line, folder);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {}\n{stderr}", output.status);
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A folder with what the README's lines find in the repository, and a file of rays.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::create_dir(path.join("docs")).unwrap();
    for below in ["scenes", "scenes/clouds", "scenes/lit"] {
        fs::create_dir_all(path.join(below)).unwrap();
        for entry in fs::read_dir(root().join(below)).unwrap() {
            let from = entry.unwrap().path();
            if !from.is_dir() {
                fs::copy(&from, path.join(below).join(from.file_name().unwrap())).unwrap();
            }
        }
    }
    let rays = [vec![0.0, 0.0, 0.0, 1.6, 0.3, -12.0], vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0]];
    fs::write(path.join("rays.npy"), npy(&rays, "<f8", false)).unwrap();
    folder
}

/// All lines of shell in the README.
fn shell_lines() -> impl Iterator<Item = &'static str> {
    blocks("sh").into_iter().flat_map(str::lines)
}

#[test]
fn every_command_does_what_it_says() {
    let folder = folder();
    let mut n_lines = 0;
    for line in shell_lines() {
        // What installs and what builds is for ci/test.sh, which runs before this and calls this.
        let line = line.strip_prefix("ci/setup.sh && ").unwrap_or(line);
        if line == "ci/test.sh" {
            continue;
        }
        let line = line.replace(CARGO_RUN, "kugelblitz ");
        assert!(line.starts_with("kugelblitz "), "what should the test do with: {line}");
        let stdout = run(&line, folder.path());
        if line.ends_with("--json") {
            serde_json::from_str::<serde_json::Value>(&stdout).expect(&line);
        }
        // Each file that a line names is there afterwards.
        let files = line.split_whitespace().filter(|word| {
            let path = Path::new(word);
            path.extension().is_some_and(|ending| ending != "toml")
        });
        for file in files {
            let path = folder.path().join(file);
            let bytes = fs::read(&path).unwrap_or_else(|error| panic!("{line}: {file}: {error}"));
            assert!(!bytes.is_empty(), "{line}: {file}");
            if Format::from_path(&path).is_ok_and(|format| format == Format::Png) {
                image::load_from_memory(&bytes).unwrap_or_else(|error| panic!("{line}: {error}"));
            }
        }
        n_lines += 1;
    }
    assert!(n_lines >= 10, "only {n_lines} lines were run");
}

#[test]
fn the_first_command_ends_with_a_picture_and_the_second_is_ci() {
    assert!(shell_lines().any(|line| line
        == format!("ci/setup.sh && {CARGO_RUN}render scenes/figure1.toml -o figure1.png")));
    assert!(shell_lines().any(|line| line == "ci/test.sh"));
    for script in ["ci/setup.sh", "ci/test.sh", "ci/report.sh", ".ci/run"] {
        let mode = fs::metadata(root().join(script)).expect(script).permissions().mode();
        assert_eq!(mode & 0o111, 0o111, "{script} can't be executed");
        run(&format!("bash -n {script}"), root());
    }
}

#[test]
fn the_picture_is_the_one_that_its_command_draws() {
    let folder = folder();
    let line = shell_lines().find(|line| line.contains("-o docs/")).expect("a line that draws it");
    run(line, folder.path());
    let open = |root: &Path| image::open(root.join("docs/figure1.png")).unwrap().into_rgb8();
    assert!(open(folder.path()) == open(root()), "docs/figure1.png is out of date; run: {line}");
}

#[test]
fn the_scene_is_as_explained() {
    let [text, orthographic, light, _] = blocks("toml")[..] else {
        panic!("a scene, a camera, lights, a cloud")
    };
    let scene = parse_scene(text, Path::new("README.md")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((scene.spheres.len(), scene.planes.len()), (2, 1));
    assert_eq!(scene.name(1), Some("red giant"));
    assert_eq!(scene.background, Color::from_hex("#20242c").unwrap());
    let without = |key: &str| {
        let lines: Vec<_> = text.lines().filter(|line| !line.starts_with(key)).collect();
        parse_scene(&lines.join("\n"), Path::new("README.md")).unwrap()
    };
    assert_eq!(without("up ").camera, scene.camera, "the default up");
    let projection = without("fov").camera.unwrap().projection;
    assert_eq!(projection, Projection::Perspective { fov_degrees: 45.0 });
    assert_eq!(without("background").background, Color::BLACK);
    let camera = parse_scene(orthographic, Path::new("README.md")).unwrap().camera.unwrap();
    assert_eq!(camera.projection, Projection::Orthographic { height: 3.0 });

    assert_lights_are_as_explained(light);

    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("readme.toml"), text).unwrap();
    run("kugelblitz render readme.toml -o readme.png --device cpu", folder.path());
    let picture = image::open(folder.path().join("readme.png")).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (640, 360));
    let at = |x, y| picture.get_pixel(x, y).0;
    assert_eq!(at(320, 180), [0xd6, 0x27, 0x28], "the red giant in the middle");
    assert_eq!(at(402, 213), scene.spheres.color(1).unwrap().to_srgb8(), "object 2 before it");
    assert_eq!(at(5, 355), [0x8c, 0x8c, 0x8c], "the floor");
    assert_eq!(at(5, 5), [0x20, 0x24, 0x2c], "the background");
}

/// The lines with a default change nothing, and the sky's suns are those of the rule.
fn assert_lights_are_as_explained(text: &str) {
    let parse = |text: &str| parse_scene(text, Path::new("README.md")).unwrap();
    let scene = parse(text);
    let [lamp, sun] = &scene.lights[..] else { panic!("a lamp and a sun") };
    assert_eq!(lamp.source, Source::Point(DVec3::new(4.0, 6.0, 3.0)));
    assert_eq!(sun.source, Source::Sun(DVec3::new(-1.0, -2.0, -1.0)));
    let defaults = Light { color: Color([1.0; 3]), intensity: 1.0, shadows: true, ..*sun };
    assert_eq!(*sun, defaults);
    assert_eq!((scene.ambient, scene.samples), (Some(Color([0.05; 3])), Some(2)));
    for key in ["shadows ", "directions "] {
        let lines: Vec<_> = text.lines().filter(|line| !line.starts_with(key)).collect();
        assert_eq!(parse(&lines.join("\n")), scene, "{key}");
    }
    assert_eq!(parse(&text.replace("[4.0, 6.0, 3.0]", "\"eye\"")).lights[0].source, Source::Eye);
    assert!(README.contains(&format!("at most {}", Sky::MAX_DIRECTIONS)));
    assert!(README.contains(&format!("at most {0} × {0}", Scene::MAX_SAMPLES)));

    let number = |name: &str| {
        let digits = README.split(&format!("{name} = ")).nth(1).unwrap();
        let end = digits.find(char::is_whitespace).unwrap();
        digits[..end].replace('−', "-").parse::<f64>().unwrap()
    };
    let (turn_cos, turn_sin) = (number("where C"), number("and S"));
    let sky = scene.sky.unwrap();
    let n = f64::from(sky.directions);
    let (mut cos, mut sin) = (1.0, 0.0);
    for (i, sun) in (0..).zip(sky.suns()) {
        let y = 1.0 - f64::from(2 * i + 1) / n;
        let s = (1.0 - y * y).sqrt();
        assert_eq!(sun, -DVec3::new(s * cos, y, s * sin), "{i}");
        (cos, sin) = (cos * turn_cos - sin * turn_sin, cos * turn_sin + sin * turn_cos);
    }
}

#[test]
fn the_cloud_is_as_explained() {
    let [text, _, _, cloud] = blocks("toml")[..] else {
        panic!("a scene, a camera, lights, a cloud")
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("readme.toml");
    fs::write(folder.path().join("cloud.npy"), npy(&vec![vec![1.0; 3]; 5], "<f4", false)).unwrap();
    let scene = parse_scene(&format!("{text}\n{cloud}"), &path).unwrap();
    assert_eq!((scene.spheres.len(), scene.planes.len()), (2 + 5, 1));
    assert_eq!(scene.clouds[0].first_id, 3);
    assert_eq!(scene.spheres[2].radius, 0.01);
    assert_eq!(scene.spheres.color(6), Color::from_hex("#1f77b4"));
    // Each ending of the table is known: what is wrong is the file that isn't there.
    for row in table("file") {
        let name = format!("missing{}", code(row[0]));
        let error = parse_scene(&cloud.replace("cloud.npy", &name), &path).unwrap_err();
        assert!(error.to_string().contains("cannot read the cloud"), "{error}");
    }
    assert!(README.contains(&format!("{} bytes of memory", size_of::<Sphere>())));
}

#[test]
fn the_example_is_the_doc_test() {
    let [example] = blocks("rust")[..] else { panic!("one example") };
    let docs: Vec<_> = CRATE_DOCS
        .lines()
        .map_while(|line| line.strip_prefix("//!"))
        .map(|line| line.strip_prefix(' ').unwrap_or(line))
        .collect();
    let docs = docs.join("\n");
    let tested = docs.split("```\n").nth(1).expect("a doc test");
    assert_eq!(example, tested);
}

/// What stands between two marks of the README.
fn marked(what: &str) -> &'static str {
    let begin = format!("<!-- begin of {what}, made by ci/report.sh -->");
    let rest = README.split_once(&begin).expect("the first mark").1;
    rest.split_once(&format!("<!-- end of {what} -->")).expect("the second mark").0.trim()
}

/// Nothing between the marks is typed by hand: it is the three tables that `ci/report.sh` wrote.
#[test]
fn the_reports_tables_are_the_reports() {
    let written = fs::read_to_string(root().join("docs/report/lavapipe.md")).unwrap();
    let shown = [marked("the report"), marked("light"), marked("many spheres")];
    assert_eq!(shown.join("\n\n"), written.trim());
    for (text, head, least) in
        [(shown[0], "| scenes |", 8), (shown[1], "| lit scene |", 18), (shown[2], "| spheres |", 3)]
    {
        assert!(text.starts_with(head), "{text}");
        assert!(text.lines().filter(|line| line.starts_with("| ")).count() >= 2 + least, "{text}");
    }
    for count in ["10⁴", "10⁵", "10⁶"] {
        assert!(shown[2].contains(&format!("\n| {count} | CPU |")), "{count}: {}", shown[2]);
    }
    let page = fs::read_to_string(root().join("docs/report/lavapipe.html")).unwrap();
    for text in shown {
        let made = text.lines().last().unwrap().rsplit_once("Kugelblitz ").expect("by whom").1;
        let date = made.trim_end_matches('.').rsplit_once(", ").expect("when").1;
        assert!(page.contains(date), "page and table are of different runs: {date}");
    }
}

/// The steps that ci/README.md explains are those of ci/test.sh, in their order.
#[test]
fn the_steps_of_ci_are_explained() {
    let read = |name| fs::read_to_string(root().join("ci").join(name)).unwrap();
    let (script, readme) = (read("test.sh"), read("README.md"));
    let steps: Vec<&str> = script.lines().filter_map(|line| line.strip_prefix("step ")).collect();
    let table = readme.split_once("## `test.sh`").expect("the section").1;
    let rows = table.lines().skip_while(|line| !line.starts_with("| ---")).skip(1);
    let rows = rows.take_while(|line| line.starts_with('|'));
    let explained: Vec<&str> =
        rows.filter_map(|row| row.strip_prefix("| `")?.split('`').next()).collect();
    assert_eq!(explained.len(), steps.len(), "{explained:#?} for {steps:#?}");
    for (explained, step) in explained.iter().zip(&steps) {
        let words = explained.split_whitespace().filter(|word| *word != "…");
        let missing: Vec<_> = words.filter(|word| !step.contains(word)).collect();
        assert!(missing.is_empty(), "`{explained}` for `{step}`: {missing:?}");
    }
}

#[test]
fn commands_options_and_exit_codes_are_those_of_the_program() {
    let help = run("kugelblitz --help", root());
    let commands: BTreeSet<&str> = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .map_while(|line| line.split_whitespace().next())
        .filter(|command| *command != "help")
        .collect();
    let listed = table("command");
    let listed: BTreeSet<&str> =
        listed.iter().map(|row| code(row[0]).split(' ').next().unwrap()).collect();
    assert_eq!(listed, commands);
    for row in table("exit code") {
        let line = format!("{:>3}  {}", row[0], row[1]);
        assert!(help.contains(&line), "{line}\n{help}");
    }
    let kernels: Vec<String> = table("kernel").iter().map(|row| code(row[0]).into()).collect();
    let help = run("kugelblitz render --help", root());
    assert!(help.contains(&format!("[possible values: {}]", kernels.join(", "))), "{help}");
    let options = README.split("Common options:").nth(1).unwrap().split_once("\n\n").unwrap().0;
    let options: Vec<_> = options.split('`').filter(|word| word.starts_with('-')).collect();
    assert!(options.len() >= 7, "{options:?}");
    for option in options {
        let option = option.split(' ').next().unwrap();
        assert!(help.contains(option), "{option}\n{help}");
    }
}

#[test]
fn formulas_and_links_lead_somewhere() {
    let mut n_links = 0;
    for link in README.split("](").skip(1).map(|rest| rest.split_once(')').unwrap().0) {
        assert!(link.starts_with("https://") || root().join(link).is_file(), "{link}");
        n_links += 1;
    }
    assert!(n_links > 30);
    let rows: Vec<_> = table("section");
    let rows: Vec<_> = rows.iter().filter(|row| row.len() >= 4).collect();
    assert!(rows.len() >= 12, "{rows:?}");
    for row in rows {
        let function = code(row[2]);
        let cells = row[3..].iter().map(|cell| cell.trim_matches(['|', ' ']));
        let files: Vec<_> = cells.filter(|cell| !cell.is_empty()).collect();
        assert!(!files.is_empty(), "{function} is nowhere");
        for cell in files {
            let file = cell.strip_prefix('[').and_then(|rest| rest.split(']').next()).expect(cell);
            let text = fs::read_to_string(root().join(code(file))).unwrap();
            let defined = ["(", "<"].map(|after| format!("fn {function}{after}"));
            assert!(defined.iter().any(|fn_| text.contains(fn_)), "{function} in {file}");
        }
    }
}
