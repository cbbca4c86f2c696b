//! What the program says: to a screen that foreign text must not steer, to a reader who may be
//! gone, and about a line that may be long.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use kugelblitz_tests::{npy, root};
use tempfile::TempDir;

fn scene(name: &str) -> String {
    format!("{}/scenes/{name}.toml", root().display())
}

/// The program on a system whose texts are UTF-8, so that markers are drawn as lines.
fn program(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_kugelblitz"));
    in_plain_surrounding(&mut command).args(args);
    command
}

fn in_plain_surrounding(command: &mut Command) -> &mut Command {
    command
        .env_remove("WGPU_ADAPTER_NAME")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .env("LC_ALL", "C.UTF-8")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
}

#[track_caller]
fn finish(command: &mut Command) -> (i32, Output) {
    let output = command.output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(!stderr.contains("panicked"), "{command:?}\n{stderr}");
    let code = output.status.code();
    (code.unwrap_or_else(|| panic!("{command:?}: {}\n{stderr}", output.status)), output)
}

fn file(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

/// A scene with the word `oops` as a radius, at this column of its only line.
fn long_line(column: usize, behind: usize) -> String {
    const BALL: &str = "{ center = [0, 0, 0], radius = 1, color = [1, 1, 1] }, ";
    let start = "sphere = [ ";
    let wrong = "{ center = [0, 0, 0], color = [1, 1, 1], radius = ";
    let mut text = start.to_owned();
    while text.len() + BALL.len() + wrong.len() < column {
        text += BALL;
    }
    text += &" ".repeat(column - 1 - text.len() - wrong.len());
    text += wrong;
    text += "\"oops\" }, ";
    while text.len() < column + behind {
        text += BALL;
    }
    text + "]\n"
}

/// The formatting machinery counts in 16 bits, and nobody reads a line of 10 MB.
#[test]
fn a_place_in_a_long_line_is_shown_in_a_window() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "long.toml");
    for (column, behind) in
        [(100, 0), (300, 1000), (70_000, 0), (70_000, 70_000), (500, 10_000_000), (10_000_000, 500)]
    {
        let text = long_line(column, behind);
        fs::write(&path, format!("# first\n{text}# last {}\n", "x".repeat(100_000))).unwrap();
        let start = Instant::now();
        let (code, output) = finish(&mut program(&["check", &path]));
        let took = start.elapsed();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(code, 3, "{column}");
        assert!(stderr.len() < 4000, "{column}: {} bytes", stderr.len());
        // Quadratic work would take hours.
        assert!(took < Duration::from_secs(60), "{column}: {took:?}");
        assert_eq!(stderr.matches(&format!("long.toml:2:{column}")).count(), 2, "{stderr}");

        let lines: Vec<&str> = stderr.lines().collect();
        let at = lines.iter().position(|line| line.contains("\"oops\"")).expect(&stderr);
        assert!(lines[at].trim_start().starts_with("2 │"), "{stderr}");
        assert!(lines[at].chars().count() < 220, "{stderr}");
        assert_eq!(lines[at].contains("│ …"), column > 200, "{stderr}");
        assert_eq!(lines[at].ends_with('…'), behind > 0, "{stderr}");
        assert!(lines[at - 1].ends_with("1 │ # first"), "{stderr}");
        assert!(
            lines
                .iter()
                .any(|line| line.trim_start().starts_with("3 │ # last") && line.ends_with('…'))
        );
        let column_of = |line: &str, what: char| line.chars().position(|c| c == what);
        let marker = lines[at + 1];
        assert_eq!(column_of(marker, '^'), column_of(lines[at], '"'), "{stderr}");
        assert_eq!(marker.matches('^').count(), "\"oops\"".len(), "{stderr}");
    }
}

/// What ends in each of these ways, with and without a word on standard error.
fn endings(folder: &TempDir) -> Vec<(Vec<String>, i32)> {
    let at = |name: &str| file(folder, name);
    fs::write(at("wrong.toml"), "[camera]\nfoo = 1\n").unwrap();
    fs::write(at("lonely.toml"), "background = \"#123456\"\n").unwrap();
    let (figure, out) = (scene("figure1"), at("a.png"));
    let small = ["--size", "16x9", "--device", "cpu"];
    let render = |scene: &str, more: &[&str]| {
        let start = ["render", scene, "-o", &out];
        [&start[..], &small, more].concat().into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>();
    vec![
        (render(&figure, &[]), 0),
        (render(&figure, &["-v"]), 0),
        (render(&figure, &["--json", "--repeat", "1"]), 0),
        (words(&["--help"]), 0),
        (words(&["check", &figure]), 0),
        (words(&["render", &figure, "-o", &at("missing/a.png")]), 1),
        (words(&["render", &figure, "-o", "/dev/full", "--format", "ppm", "--device", "cpu"]), 1),
        (words(&["rendr"]), 2),
        (render(&figure, &["--kernel", "magic"]), 2),
        (words(&["render", &figure, "-o", &at("a.jpg")]), 2),
        (render(&at("wrong.toml"), &[]), 3),
        (render(&at("lonely.toml"), &[]), 3),
        (words(&["report", &at("wrong.toml"), "--device", "cpu"]), 3),
        (words(&["render", &figure, "-o", &out, "--device", "no such adapter"]), 4),
        (words(&["render", &figure, "-o", &out, "--size", "99999x9"]), 7),
    ]
}

/// A full disk behind it, a reader that is gone, no standard error at all: the exit code says the
/// same.
#[test]
fn an_unwritable_standard_error_changes_no_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    for (args, code) in endings(&folder) {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let full = || File::options().write(true).open("/dev/full").unwrap();
        assert_eq!(finish(program(&args).stderr(full())).0, code, "full: {args:?}");
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_eq!(finish(program(&args).stderr(writer)).0, code, "no reader: {args:?}");
        let mut shell = Command::new("sh");
        let closed = "exec \"$0\" \"$@\" 2>&-";
        in_plain_surrounding(&mut shell).args(["-c", closed, env!("CARGO_BIN_EXE_kugelblitz")]);
        assert_eq!(finish(shell.args(&args)).0, code, "closed: {args:?}");
    }
}

/// Data that can't be written is a failure; of a reader that is gone (`… | head`) nothing is said.
#[test]
fn an_unwritable_standard_output_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let figure = scene("figure1");
    let rays = file(&folder, "rays.npy");
    fs::write(&rays, npy(&[vec![0.0, 1.0, 6.0, 0.0, 0.0, -1.0]], "<f8", false)).unwrap();
    let cases: [&[&str]; 12] = [
        &["render", &figure, "-o", "-", "--format", "ppm", "--device", "cpu"],
        &["render", &figure, "-o", "-", "--format", "exr", "--device", "cpu"],
        &["trace", &figure, "--rays", &rays, "-o", "-", "--device", "cpu"],
        &["check", &figure],
        &["check", &figure, "--json"],
        &["verify", &figure, "--size", "16x9", "--device", "cpu"],
        &["explain", &figure, "--pixel", "1,1", "--device", "cpu"],
        &["export", "pov", &figure],
        &["man"],
        &["completions", "bash"],
        &["--help"],
        &["--version"],
    ];
    for args in cases {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let (code, output) = finish(program(args).stdout(writer));
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!((code, stderr.as_str()), (1, ""), "{args:?}");
        let full = File::options().write(true).open("/dev/full").unwrap();
        let (code, output) = finish(program(args).stdout(full));
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(code, 1, "{args:?}: {stderr}");
        let said = stderr.starts_with("error: standard output: No space");
        assert!(said && stderr.lines().count() == 1, "{args:?}: {stderr}");
    }
}

/// A line break in a name can't make a line of its own.
#[test]
fn a_path_stays_on_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let name = |ending: &str| file(&folder, &format!("a\nerror: all is lost\t{ending}"));
    let figure = name(".toml");
    fs::copy(scene("figure1"), &figure).unwrap();
    fs::write(name(".csv"), "x,y\n1,2\n").unwrap();
    fs::write(name("-no.png"), "no picture").unwrap();
    let small = ["--size", "9x5", "--device", "cpu"];
    let (png, missing, csv, no) = (name(".png"), name("-missing"), name(".csv"), name("-no.png"));
    let (svg, pov, frames) = (name(".svg"), name(".pov"), name("-%.png"));
    let routes: [(&[&str], i32); 17] = [
        (&["export", "pov", &figure, "-o", &pov], 0),
        (&[&["render", &figure, "-o", &frames, "--turntable", "2"][..], &small].concat(), 0),
        (&["check", "a", &csv], 2),
        (&["render", &figure, &format!("--size={missing}")], 2),
        (&[&["render", &figure, "-o", &png][..], &small].concat(), 0),
        (&["check", &figure], 0),
        (&["info", &png], 0),
        (&["compare", &png, &png], 0),
        (&[&["verify", &figure][..], &small].concat(), 0),
        (&["figure", "3", &figure, "-o", &svg], 0),
        (&["check", &missing], 3),
        (&["render", &csv, "-o", &png], 3),
        (&["info", &no], 1),
        (&["trace", &figure, "--rays", &no, "-o", "a.npy"], 1),
        (&["render", &figure, "-o", &figure, "--format", "png"], 2),
        (&["render", &figure, "-o", &missing], 2),
        (&["render", &figure, "-o", &format!("{missing}/a.png")], 1),
    ];
    for (args, code) in routes {
        let (found, output) = finish(&mut program(args));
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert_eq!(found, code, "{args:?}: {said:?}");
        let is_shown = said.iter().any(|text| {
            ["\\n", "\\x0a"].iter().any(|sign| text.contains(&format!("a{sign}error: all is lost")))
        });
        assert!(is_shown && !said.concat().contains("\nerror: all"), "{args:?}: {said:?}");
    }
}

/// Paths for people go through `Shown`, for nobody looks at each of them in a name with a line break. What is
/// for machines is listed here.
#[test]
fn paths_are_shown_one_way() {
    let raw = [
        ("crates/cli/src/compare.rs", 1),
        ("crates/cli/src/film.rs", 1),
        ("crates/cli/src/head.rs", 1),
        ("crates/cli/src/judge.rs", 1),
        ("crates/cli/src/report.rs", 1),
        ("crates/view/src/recent.rs", 1),
        ("src/cost.rs", 1),
        ("src/picture/read/mod.rs", 1),
    ];
    let found: Vec<(String, usize)> = sources()
        .into_iter()
        .map(|(name, text)| (name, text.matches(".display()").count()))
        .filter(|(_, n)| *n > 0)
        .collect();
    let found: Vec<(&str, usize)> = found.iter().map(|(name, n)| (name.as_str(), *n)).collect();
    assert_eq!(found, raw);
}

/// Markup becomes a text in `markup.rs`, which takes out what no parser takes, and is written by maud.
#[test]
fn markup_is_written_one_way() {
    for (name, text) in sources() {
        let (code, _) = text.split_once("#[cfg(test)]").unwrap_or((&text, ""));
        let writes = code.contains("use maud::") && code.contains(".into_string()");
        assert_eq!(writes, name == "crates/judge/src/markup.rs", "{name}");
        assert!(!code.contains("<svg") && !code.contains("xmlns=\\"), "{name}");
    }
}

/// The files of the library, its fronts and the program, by their paths from the root, with their texts.
fn sources() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let crates = fs::read_dir(root().join("crates")).unwrap();
    let mut folders: Vec<_> = crates.map(|entry| entry.unwrap().path().join("src")).collect();
    folders.push(root().join("src"));
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let name = path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
                found.push((name, fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[cfg(not(feature = "view"))]
#[test]
fn a_program_without_a_window_says_how_to_build_one() {
    let (code, output) = finish(&mut program(&["view", &scene("figure1")]));
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!((code, stderr.lines().count()), (2, 1), "{stderr}");
    assert!(stderr.contains("`cargo build --release --features view`"), "{stderr}");
}

#[cfg(feature = "view")]
#[test]
fn a_missing_display_is_one_clear_line() {
    let figure = scene("figure1");
    let ways: [(&[(&str, &str)], &str); 3] = [
        (&[], "nor DISPLAY is set"),
        (&[("DISPLAY", ":12345")], ":12345"),
        (&[("WAYLAND_DISPLAY", "nobody-there")], "nobody-there"),
    ];
    for (variables, says) in ways {
        let mut command = program(&["view", &figure]);
        let (code, output) = finish(command.envs(variables.iter().copied()));
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((code, stderr.lines().count()), (4, 1), "{stderr}");
        assert!(stderr.starts_with("error: there is no display to open a window on"), "{stderr}");
        assert!(stderr.contains(says) && stderr.contains("kugelblitz render"), "{stderr}");
        assert!(!stderr.contains(".rs"), "{stderr}");
    }
}

/// What would rename the terminal, clear it, colour it, turn the direction of writing and overwrite
/// its line: ESC, C1, bidirectional marks, and a lone CR, but nothing that a file's name can't hold.
const HOSTILE: &str = "a\x1b]0;t\x07\x1b[97;41m\u{9b}2J\u{85}\u{202e}\u{202a}\u{2066}\u{2069}\u{200e}\u{200f}\u{61c}\x7f\x08\rz";

/// The characters of `text` that steer a terminal; SGR codes (colours) are let through on demand.
fn steering(text: &str, colours: bool) -> Vec<char> {
    let mut rest = String::new();
    let mut parts = text.split("\x1b[");
    rest += parts.next().unwrap_or_default();
    for part in parts {
        let end = part.find(|c: char| !c.is_ascii_digit() && c != ';');
        match end {
            Some(end) if colours && part[end..].starts_with('m') && &part[..end] != "97;41" => {
                rest += &part[end + 1..];
            }
            _ => {
                rest.push('\x1b');
                rest += part;
            }
        }
    }
    let is_bidi = |c| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}' | '\u{61c}');
    rest.chars().filter(|&c| (c.is_control() && !matches!(c, '\n' | '\t')) || is_bidi(c)).collect()
}

#[test]
fn the_test_of_foreign_text_sees_it() {
    assert_eq!(steering("a\n\tb", false), []);
    assert_eq!(steering("\x1b[31;1mred\x1b[0m", true), []);
    assert_eq!(steering("\x1b[31mred", false), ['\x1b']);
    for colours in [false, true] {
        assert_eq!(steering(HOSTILE, colours).len(), 15, "{:?}", steering(HOSTILE, colours));
    }
}

/// Every route on which foreign text reaches standard output or standard error, and one the
/// program's own colours.
#[test]
fn nothing_foreign_steers_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| file(&folder, name);
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).unwrap();
        at(name)
    };
    // In TOML's quotes, the control characters of ASCII are written as escapes.
    let quoted: String = HOSTILE
        .chars()
        .map(|c| if c.is_ascii_control() { format!("\\u{:04X}", c as u32) } else { c.into() })
        .collect();
    // What TOML lets stand as it is.
    let raw: String = HOSTILE.chars().filter(|c| !c.is_ascii_control()).collect();
    let camera = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n";
    let ball = |name: &str| {
        format!(
            "[[sphere]]\nname = \"{name}\"\ncenter = [0, 0, 0]\nradius = 1\ncolor = \"#ffffff\"\n"
        )
    };
    let floor = format!(
        "[[plane]]\nname = \"{quoted}\"\npoint = [0, -1, 0]\nnormal = [0, 1, 0]\ncolor = \"#888888\"\n"
    );
    let good =
        write(&format!("{HOSTILE}.toml"), &format!("# {raw}\n{camera}{}{floor}", ball(&quoted)));
    let rays = [vec![0.0, 0.0, 5.0, 0.0, 0.0, -1.0]];
    fs::write(folder.path().join(format!("{HOSTILE}.npy")), npy(&rays, "<f8", false)).unwrap();
    let points = [vec![0.0, 0.0, 0.0]];
    fs::write(folder.path().join(format!("{HOSTILE}-3.npy")), npy(&points, "<f8", false)).unwrap();
    let no_npy = write(&format!("{HOSTILE}-no.npy"), HOSTILE);
    let hostile = |ending: &str| at(&format!("{HOSTILE}{ending}"));
    let (png, html) = (hostile(".png"), hostile(".html"));
    let (npy_out, hits) = (hostile("-out.npy"), hostile("-hits.npy"));
    let small = ["--size", "16x9", "--device", "cpu"];

    let mut routes: Vec<(Vec<&str>, i32)> = vec![
        (vec!["check", &good], 0),
        (vec!["check", &good, "--json"], 0),
        (vec!["explain", &good, "--pixel", "640,360", "--device", "cpu"], 0),
        (vec!["explain", &good, "--pixel", "640,360", "--device", "cpu", "--latex"], 0),
        (vec!["explain", &good, "--pixel", "640,360", "--device", "cpu", "--json"], 0),
        ([&["verify", &good][..], &small].concat(), 0),
        ([&["render", &good, "-o", &png][..], &small].concat(), 0),
        ([&["render", &good, "-o", &png, "--json"][..], &small].concat(), 0),
        (vec!["export", "pov", &good], 0),
        (vec!["export", "tachyon", &good, "-o", &png], 0),
        (vec!["export", "tachyon", &good, "-o", &png, "--json"], 0),
        ([&["report", &good, "--rounds", "1", "-o", &html][..], &small].concat(), 0),
        ([&["report", &good, "--rounds", "1", "--json"][..], &small].concat(), 0),
        (vec!["generate", "cloud", "--count", "2", "-o", &npy_out], 0),
        (vec!["generate", "cloud", "--count", "2", "-o", &npy_out, "--json"], 0),
        (vec!["generate", "cloud", "--count", "2", "-o", &good], 2),
        (vec!["render", &good, "-o", &good], 2),
        (vec!["render", HOSTILE, "-o", &png], 3),
        (vec!["report", HOSTILE], 3),
        (vec!["report", &good, "-o", &good], 2),
        (vec!["check", HOSTILE], 3),
        (vec!["check", &no_npy], 3),
        (vec!["render", &good, "-o", &png, "--device", HOSTILE], 4),
        (vec!["render", &good, "-o", &png, "--kernel", HOSTILE], 2),
        (vec!["render", &good, "-o", &png, "--size", HOSTILE], 2),
        (vec!["render", &good, "-o", &png, HOSTILE], 2),
        (vec!["render", &good, HOSTILE, "-o"], 2),
        (vec![HOSTILE], 2),
        (vec!["man", HOSTILE], 2),
        (vec!["completions", HOSTILE], 2),
        (vec!["generate", HOSTILE], 2),
    ];
    let in_rays = hostile(".npy");
    let three_columns = hostile("-3.npy");
    let missing = hostile("-missing.npy");
    let csv = hostile(".csv");
    for (rays, out, code) in [
        (&in_rays, &hits, 0),
        (&three_columns, &hits, 1),
        (&no_npy, &hits, 1),
        (&missing, &hits, 1),
        (&in_rays, &csv, 2),
    ] {
        routes.push((vec!["trace", &good, "--rays", rays, "-o", out, "--device", "cpu"], code));
    }
    routes.push((vec!["view", &good], if cfg!(feature = "view") { 4 } else { 2 }));

    // Scenes and clouds that are wrong, each under a name of its own.
    let cloud =
        |file: &str| format!("[[spheres]]\nfile = \"{file}\"\nradius = 1\ncolor = \"#ffffff\"\n");
    let mut wrong = vec![
        format!("{HOSTILE} = 1\n"),
        format!("background = {HOSTILE}\n"),
        format!("# {HOSTILE}\n"),
        format!("{raw}\n"),
        format!("# {raw}\nfoo = 1 # {raw}\n# {raw}\n"),
        format!("\"{quoted}\" = 1\n"),
        format!("[\"{quoted}\"]\n"),
        format!("[camera]\n\"{quoted}\" = 1\n"),
        format!("background = \"{quoted}\"\n"),
        format!("background = \"{raw}\"\n"),
        format!("background = 7 # {raw}\r\n"),
        format!("\"{quoted}\" = 1\n\"{quoted}\" = 2\n"),
        cloud(&format!("{quoted}.ply")),
        cloud(&format!("{quoted}-missing.npy")),
        cloud(&format!("{quoted}-no.npy")),
    ];
    for (i, cell) in [
        format!("{HOSTILE},y,z\n1,2,3\n"),
        format!("x,y,{raw}\n1,2,3\n"),
        format!("x,y,z\n1,2,\"{HOSTILE}\"\n"),
        format!("x,y,z\n1,2,3,{raw}\n"),
    ]
    .iter()
    .enumerate()
    {
        write(&format!("{HOSTILE}{i}.csv"), cell);
        wrong.push(cloud(&format!("{quoted}{i}.csv")));
    }
    for (i, atoms) in [
        format!("{HOSTILE}\n\nC 0 0 0\n"),
        format!("1\n{HOSTILE}\n{HOSTILE} 0 0 0\n"),
        format!("1\n{HOSTILE}\nC 0 0 {raw}\n"),
        format!("2\n{HOSTILE}\nC 0 0 0\n"),
    ]
    .iter()
    .enumerate()
    {
        write(&format!("{HOSTILE}{i}.xyz"), atoms);
        wrong.push(format!("[[spheres]]\nfile = \"{quoted}{i}.xyz\"\n"));
    }
    let wrong: Vec<String> = wrong
        .iter()
        .enumerate()
        .map(|(i, text)| write(&format!("{HOSTILE}{i}.toml"), text))
        .collect();
    routes.extend(wrong.iter().map(|path| (vec!["check", path.as_str()], 3)));
    // A cloud that is right, with its file's name.
    let right = write("right.toml", &cloud(&format!("{quoted}-3.npy")));
    routes.push((vec!["check", &right], 0));
    routes.push((vec!["check", &right, "--json"], 0));

    let mut wrongs = String::new();
    let mut n_own_colours = 0;
    for (args, code) in &routes {
        for colours in [false, true] {
            let mut command = program(args);
            if colours {
                command.env("FORCE_COLOR", "1").env("CLICOLOR_FORCE", "1").env_remove("NO_COLOR");
            }
            let (found, output) = finish(&mut command);
            for (stream, bytes) in [("stdout", &output.stdout), ("stderr", &output.stderr)] {
                let text = String::from_utf8_lossy(bytes);
                n_own_colours += u32::from(colours && text.contains("\x1b["));
                let steering = steering(&text, colours);
                if !steering.is_empty() || found != *code {
                    wrongs +=
                        &format!("{args:?}: exit {found}, {stream}: {steering:?}\n{text:?}\n");
                }
            }
        }
    }
    assert!(wrongs.is_empty(), "{wrongs}");
    assert!(n_own_colours > 10, "the program's own colours are gone: {n_own_colours}");
    assert!(Path::new(&png).exists());
}

/// JSON says the same, however its strings are written.
#[test]
fn json_keeps_what_it_escapes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("{HOSTILE}.npy"));
    fs::write(&path, npy(&[vec![0.0, 0.0, 0.0]], "<f8", false)).unwrap();
    let quoted = serde_json::to_string(path.to_str().unwrap()).unwrap().replace('\x7f', "\\u007f");
    let toml = file(&folder, "right.toml");
    fs::write(&toml, format!("[[spheres]]\nfile = {quoted}\nradius = 1\ncolor = \"#ffffff\"\n"))
        .unwrap();
    let (code, output) = finish(&mut program(&["check", &toml, "--json"]));
    assert_eq!(code, 0, "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(steering(&String::from_utf8(output.stdout.clone()).unwrap(), false), []);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["clouds"][0]["file"], path.to_str().unwrap());
}
