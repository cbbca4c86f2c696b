//! What the README and the guide say of scenes, options and tables is so.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use glam::DVec3;
use kugelblitz::scene::{Color, Light, Projection, Samples, Sky, Source, Sphere, parse_scene};
use kugelblitz_tests::{root, text_of};

static README: LazyLock<String> = LazyLock::new(|| text_of("README.md"));
static INTRODUCTION: LazyLock<String> = LazyLock::new(|| text_of("docs/guide/src/introduction.md"));
static FIRST_PICTURE: LazyLock<String> =
    LazyLock::new(|| text_of("docs/guide/src/first-picture.md"));
static LIGHT: LazyLock<String> = LazyLock::new(|| text_of("docs/guide/src/light.md"));
static DEVICES: LazyLock<String> = LazyLock::new(|| text_of("docs/guide/src/devices.md"));
static CERTIFICATE: LazyLock<String> = LazyLock::new(|| text_of("docs/guide/src/certificate.md"));

/// The texts of a page's fenced blocks of a language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("\n```{language}\n");
    let blocks: Vec<_> = page
        .split(&fence)
        .skip(1)
        .map(|rest| rest.split_once("```").expect("a closed block").0)
        .collect();
    assert!(!blocks.is_empty(), "the page has no {language} block");
    blocks
}

/// The cells of a page's table whose head begins with `first`.
fn table<'a>(page: &'a str, first: &str) -> Vec<Vec<&'a str>> {
    let head = format!("| {first} |");
    let rows: Vec<_> = page
        .lines()
        .skip_while(|line| !line.starts_with(&head))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect())
        .collect();
    assert!(!rows.is_empty(), "the page has no table that begins with {first}");
    rows
}

/// `x` of "`x`".
fn code(cell: &str) -> &str {
    cell.strip_prefix('`').and_then(|rest| rest.split_once('`')).expect("code").0
}

/// What a command of the program prints.
fn run(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_kugelblitz")).args(arguments).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {}\n{stderr}", output.status);
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn the_first_command_ends_with_a_picture_and_the_second_is_ci() {
    let [first, second, ..] = blocks(&README, "sh")[..] else { panic!("two commands") };
    let draws = "cargo run --release -- render scenes/lit/figure1.toml --device gpu -o figure1.png";
    assert_eq!(first, format!("ci/setup.sh && {draws}\n"));
    assert_eq!(second, "ci/test.sh\n");
    for script in
        ["ci/setup.sh", "ci/test.sh", "ci/drivers.sh", "ci/python.sh", "ci/report.sh", ".ci/run"]
    {
        let mode = fs::metadata(root().join(script)).expect(script).permissions().mode();
        assert_eq!(mode & 0o111, 0o111, "{script} can't be executed");
        let checked = Command::new("bash").arg("-n").arg(root().join(script)).status().unwrap();
        assert!(checked.success(), "{script}");
    }
}

#[test]
fn the_scene_is_as_explained() {
    let parse =
        |text: &str| parse_scene(text, Path::new("guide")).unwrap_or_else(|e| panic!("{e}"));
    let text = FIRST_PICTURE.split_once("<<'END'\n").unwrap().1.split_once("END\n").unwrap().0;
    let scene = parse(text);
    assert_eq!((scene.spheres.len(), scene.planes.len()), (2, 1));
    assert_eq!(scene.name(1), Some("red giant"));
    assert_eq!(scene.background, Color::from_hex("#20242c").unwrap());
    let without = |key: &str| {
        let lines: Vec<_> = text.lines().filter(|line| !line.starts_with(key)).collect();
        parse(&lines.join("\n"))
    };
    assert_eq!(without("up ").camera, scene.camera, "the default up");
    let projection = without("fov").camera.unwrap().projection;
    assert_eq!(projection, Projection::Perspective { fov_degrees: 45.0 });
    assert_eq!(without("background").background, Color::BLACK);
    let camera = parse(blocks(&FIRST_PICTURE, "toml")[0]).camera.unwrap();
    assert_eq!(camera.projection, Projection::Orthographic { height: 3.0 });
    assert!(FIRST_PICTURE.contains(&format!("at most {0} × {0}", Samples::MOST)));

    let picture = image::open(root().join("docs/guide/src/images/balls.png")).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (640, 360));
    let at = |x, y| picture.get_pixel(x, y).0;
    assert_eq!(at(320, 180), [0xd6, 0x27, 0x28], "the red giant in the middle");
    assert_eq!(at(402, 213), scene.spheres.color(1).unwrap().to_srgb8(), "object 2 before it");
    assert_eq!(at(5, 355), [0x8c, 0x8c, 0x8c], "the floor");
    assert_eq!(at(5, 5), [0x20, 0x24, 0x2c], "the background");
}

/// The lines with a default change nothing, and the sky's suns are those of the rule.
#[test]
fn lights_are_as_explained() {
    let text = blocks(&LIGHT, "toml")[0];
    let parse = |text: &str| parse_scene(text, Path::new("guide")).unwrap();
    let scene = parse(text);
    let [lamp, sun] = &scene.lights[..] else { panic!("a lamp and a sun") };
    assert_eq!(lamp.source, Source::Point(DVec3::new(4.0, 6.0, 3.0)));
    assert_eq!(sun.source, Source::Sun(DVec3::new(-1.0, -2.0, -1.0)));
    let defaults = Light { color: Color([1.0; 3]), intensity: 1.0, shadows: true, ..*sun };
    assert_eq!(*sun, defaults);
    assert_eq!((scene.ambient, scene.samples), (Some(Color([0.05; 3])), Some(Samples::nearest(2))));
    for key in ["shadows ", "directions "] {
        let lines: Vec<_> = text.lines().filter(|line| !line.starts_with(key)).collect();
        assert_eq!(parse(&lines.join("\n")), scene, "{key}");
    }
    assert_eq!(parse(&text.replace("[4.0, 6.0, 3.0]", "\"eye\"")).lights[0].source, Source::Eye);
    assert!(LIGHT.contains(&format!("at most {}", Sky::MAX_DIRECTIONS)));
    assert!(LIGHT.contains(&format!("at most {0} × {0}", Samples::MOST)));

    let number = |name: &str| {
        let digits = LIGHT.split(&format!("{name} = ")).nth(1).unwrap();
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
fn a_sphere_takes_as_many_bytes_as_is_said() {
    assert!(DEVICES.contains(&format!("{} bytes of memory", size_of::<Sphere>())));
}

/// The guide shows the report's three tables, and they are of the same run as the report's page.
#[test]
fn the_reports_tables_are_the_reports() {
    let read = |name: &str| fs::read_to_string(root().join("docs/report").join(name)).unwrap();
    let (tables, page) = (read("lavapipe.md"), read("lavapipe.html"));
    for (head, least) in [("scenes", 8), ("lit scene", 18), ("spheres", 3)] {
        assert!(table(&tables, head).len() >= least, "{head}\n{tables}");
    }
    for count in ["10⁴", "10⁵", "10⁶"] {
        assert!(tables.contains(&format!("\n| {count} | CPU |")), "{count}: {tables}");
    }
    let made: Vec<_> = tables.split("by Kugelblitz ").skip(1).collect();
    assert_eq!(made.len(), 3);
    for made in made {
        let date =
            made.lines().next().unwrap().trim_end_matches('.').rsplit_once(", ").expect("when").1;
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
    let help = run(&["--help"]);
    let commands: BTreeSet<&str> = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .map_while(|line| line.split_whitespace().next())
        .filter(|command| *command != "help")
        .collect();
    let listed = table(&INTRODUCTION, "command");
    let listed: BTreeSet<&str> =
        listed.iter().map(|row| code(row[0]).split(' ').next().unwrap()).collect();
    assert_eq!(listed, commands);
    let of_scripts = fs::read_to_string(root().join("docs/guide/src/commands.md")).unwrap();
    for row in table(&of_scripts, "exit code") {
        let line = format!("{:>3}  {}", row[0], row[1]);
        assert!(help.contains(&line), "{line}\n{help}");
    }
    let kernels: Vec<String> =
        table(&CERTIFICATE, "kernel").iter().map(|row| code(row[0]).into()).collect();
    let help = run(&["render", "--help"]);
    assert!(help.contains(&format!("[possible values: {}]", kernels.join(", "))), "{help}");
    let options =
        INTRODUCTION.split("Common options:").nth(1).unwrap().split_once("\n\n").unwrap().0;
    let options: Vec<_> = options.split('`').filter(|word| word.starts_with('-')).collect();
    assert!(options.len() >= 7, "{options:?}");
    for option in options {
        let option = option.split(' ').next().unwrap();
        assert!(help.contains(option), "{option}\n{help}");
    }
}
