//! What the program says: to a screen that foreign text must not steer, and to a reader who may be gone.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};

use kugelblitz_tests::{npy, npy_of_rays, root};

use crate::program::{ends, finish, in_folder, material};

/// Commands, their exit codes, and whether they print on standard output.
const ENDINGS: [(&str, i32, bool); 3] = [
    ("info scenes/figure1.toml", 0, true),
    ("render scenes/figure1.toml -o - --format ppm --device cpu", 0, true),
    ("render scenes/figure1.toml -o a.png --kernel magic", 2, false),
];

/// A full disk behind standard error, a reader that is gone, no standard error at all: the exit code says the same. Data that
/// can't be written are a failure; of a reader that is gone (`… | head`) nothing is said.
#[test]
fn unwritable_streams_end_as_they_must() {
    let folder = material();
    let full = || File::options().write(true).open("/dev/full").unwrap();
    let gone = || std::io::pipe().unwrap().1;
    for (line, code, prints) in ENDINGS {
        let command = || in_folder(&folder, line);
        let mut shell = Command::new("sh");
        let program = env!("CARGO_BIN_EXE_kugelblitz");
        shell.args(["-c", "exec \"$0\" \"$@\" 2>&-", program]).args(line.split(' '));
        shell.current_dir(&folder).stdout(Stdio::null()).stdin(Stdio::null());
        let [mut onto_full, mut to_nobody] = [command(), command()];
        onto_full.stderr(full());
        to_nobody.stderr(gone());
        for command in [onto_full, to_nobody, shell] {
            ends(command, code);
        }
        if prints {
            let [mut onto_full, mut to_nobody] = [command(), command()];
            onto_full.stdout(full());
            to_nobody.stdout(gone());
            assert_eq!(ends(to_nobody, 1).stderr, "", "{line}");
            let said = ends(onto_full, 1).stderr;
            let is_told = said.starts_with("error: standard output: No space");
            assert!(is_told && said.lines().count() == 1, "{line}: {said}");
        }
    }
}

/// What writes elements makes a document of them by `markup.rs`, which takes out what no parser takes.
#[test]
fn markup_is_written_one_way() {
    for (name, text) in sources() {
        let (code, _) = text.split_once("#[cfg(test)]").unwrap_or((&text, ""));
        let writes =
            code.contains("<svg") || code.contains("xmlns=") || code.contains(".into_string()");
        assert!(!writes || code.contains("document(&"), "{name}");
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

/// A line break in a name can't make a line of its own.
const LINES: &str = "a\nerror:all-is-lost\t";

/// Files in which `{h}` is foreign text, `{q}` the same in TOML's quotes, where the control characters of ASCII are escapes, and
/// `{r}` what TOML lets stand as it is. What is numbered is wrong.
const FILES: [(&str, &str); 37] = [
    ("{h}.toml", "# {r}\n{camera}{ball}{floor}"),
    ("{h}-no.npy", "{h}"),
    ("{h}-no.png", "no picture"),
    ("right.toml", "{cloud}{q}-3.npy\""),
    ("{h}0.toml", "{h} = 1\n"),
    ("{h}1.toml", "background = {h}\n"),
    ("{h}2.toml", "# {h}\n"),
    ("{h}3.toml", "{r}\n"),
    ("{h}4.toml", "# {r}\nfoo = 1 # {r}\n# {r}\n"),
    ("{h}5.toml", "\"{q}\" = 1\n"),
    ("{h}6.toml", "[\"{q}\"]\n"),
    ("{h}7.toml", "[camera]\n\"{q}\" = 1\n"),
    ("{h}8.toml", "background = \"{q}\"\n"),
    ("{h}9.toml", "background = \"{r}\"\n"),
    ("{h}10.toml", "background = 7 # {r}\r\n"),
    ("{h}11.toml", "\"{q}\" = 1\n\"{q}\" = 2\n"),
    ("{h}12.toml", "{cloud}{q}.ply\""),
    ("{h}13.toml", "{cloud}{q}-missing.npy\""),
    ("{h}14.toml", "{cloud}{q}-no.npy\""),
    ("{h}15.toml", "{cloud}{q}0.csv\""),
    ("{h}16.toml", "{cloud}{q}1.csv\""),
    ("{h}17.toml", "{cloud}{q}2.csv\""),
    ("{h}18.toml", "{cloud}{q}3.csv\""),
    ("{h}19.toml", "[[spheres]]\nfile = \"{q}4.xyz\""),
    ("{h}20.toml", "[[spheres]]\nfile = \"{q}5.xyz\""),
    ("{h}21.toml", "{cloud}{q}7.csv\""),
    ("{h}22.toml", "[[light]]\nposition = \"{q}\"\n"),
    ("{h}23.toml", "{data}{q}7.csv\"\ncolumns = { z = \"{q} \" }\n"),
    ("{h}7.csv", "x,y,\"{h}\",\"diameter {h}\"\n1,2,3,4\n"),
    ("{h}24.toml", "{data}{q}7.csv\"\ncolumns = { z = \"{q}\" }\n"),
    ("{h}0.csv", "{h},y,z\n1,2,3\n"),
    ("{h}1.csv", "x,y,{r}\n1,2,3\n"),
    ("{h}2.csv", "x,y,z\n1,2,\"{h}\"\n"),
    ("{h}3.csv", "x,y,z\n1,2,3,{r}\n"),
    ("{h}4.xyz", "{h}\n\nC 0 0 0\n"),
    ("{h}5.xyz", "1\n{h}\nC 0 0 {r}\n"),
    ("{h}6.xyz", "2\n{h}\nC 0 0 0\n"),
];

/// Every route on which foreign text reaches standard output or standard error, and how it ends.
const ROUTES: [(&str, i32); 47] = [
    ("info {h}.toml", 0),
    ("info {h}.toml --json", 0),
    ("info right.toml", 0),
    ("info right.toml --json", 0),
    ("info a {h}.csv", 2),
    ("info {h}", 3),
    ("info {h}-no.npy", 3),
    ("explain {h}.toml --pixel 640,360 --device cpu", 0),
    ("explain {h}.toml --pixel 640,360 --device cpu --latex", 0),
    ("explain {h}.toml --pixel 640,360 --device cpu --json", 0),
    ("verify {h}.toml --size 16x9 --device cpu", 0),
    ("render {h}.toml -o {h}.png --size 16x9 --device cpu", 0),
    ("render {h}.toml -o {h}.png --size 16x9 --device cpu --json", 0),
    ("render {h}.toml -o {h}-%.png --size 9x5 --device cpu --turntable 2", 0),
    ("render {h}.toml -o {h}.toml --format png", 2),
    ("render {h}.toml -o {h}", 2),
    ("render {h}.toml -o {h}/a.png", 1),
    ("render {h} -o {h}.png", 3),
    ("render {h}1.csv -o {h}.png", 3),
    ("render {h}.toml -o {h}.png --device {h}", 4),
    ("render {h}.toml -o {h}.png --kernel {h}", 2),
    ("render {h}.toml -o {h}.png --size {h}", 2),
    ("render {h}.toml -o {h}.png {h}", 2),
    ("render {h}.toml {h} -o", 2),
    ("info {h}.png", 0),
    ("info {h}-no.png", 1),
    ("compare {h}.png {h}.png", 0),
    ("figure 4 {h}.toml -o {h}.svg", 0),
    ("export pov {h}.toml", 0),
    ("export pov {h}.toml -o {h}.pov", 0),
    ("export tachyon {h}.toml -o {h}.dat --json", 0),
    ("report {h}.toml --rounds 1 --size 16x9 --device cpu -o {h}.html", 0),
    ("report {h}.toml --rounds 1 --size 16x9 --device cpu --json", 0),
    ("report {h}", 3),
    ("report {h}.toml -o {h}.toml", 2),
    ("generate --count 2 -o {h}-out.npy", 0),
    ("generate --count 2 -o {h}-out.npy --json", 0),
    ("generate --count 2 -o {h}.toml", 2),
    ("trace {h}.toml --rays {h}-6.npy -o {h}-hits.npy --device cpu", 0),
    ("trace {h}.toml --rays {h}-3.npy -o {h}-hits.npy --device cpu", 1),
    ("trace {h}.toml --rays {h}-no.npy -o {h}-hits.npy --device cpu", 1),
    ("trace {h}.toml --rays {h}-missing.npy -o {h}-hits.npy --device cpu", 1),
    ("trace {h}.toml --rays {h}-6.npy -o {h}.csv --device cpu", 2),
    ("{h}", 2),
    ("man {h}", 2),
    ("completions {h}", 2),
    ("generate {h}", 2),
];

/// Each route with names that steer and with names of several lines; on demand with the program's own colours.
#[test]
fn nothing_foreign_steers_the_terminal() {
    for foreign in [HOSTILE, LINES] {
        let quoted: String = foreign
            .chars()
            .map(|c| if c.is_ascii_control() { format!("\\u{:04X}", c as u32) } else { c.into() })
            .collect();
        let raw: String = foreign.chars().filter(|c| !c.is_ascii_control()).collect();
        let filled = |text: &str| {
            [
                ("{camera}", "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n"),
                ("{ball}", "[[sphere]]\nname = \"{q}\"\ncenter = [0, 0, 0]\nradius = 1\ncolor = \"red\"\n"),
                ("{floor}", "[[plane]]\nname = \"{q}\"\npoint = [0, -1, 0]\nnormal = [0, 1, 0]\ncolor = \"red\"\n"),
                ("{cloud}", "[[spheres]]\nradius = 1\ncolor = \"red\"\nfile = \""),
                ("{data}", "[[spheres]]\ncolor = \"red\"\nfile = \""),
                ("{h}", foreign),
                ("{q}", &quoted),
                ("{r}", &raw),
            ]
            .iter()
            .fold(text.to_owned(), |text, (place, what)| text.replace(place, what))
        };
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(filled(name)), bytes);
        let mut routes: Vec<(String, i32)> =
            ROUTES.iter().map(|(line, code)| (filled(line), *code)).collect();
        for (name, text) in FILES {
            write(name, filled(text).as_bytes()).unwrap();
            if name.ends_with('l') && name.contains(|c: char| c.is_ascii_digit()) {
                routes.push((filled(&format!("info {name}")), 3));
            }
        }
        write("{h}-6.npy", &npy_of_rays(&[[0.0, 0.0, 5.0, 0.0, 0.0, -1.0]])).unwrap();
        write("{h}-3.npy", &npy(&[vec![0.0; 3]], "<f8", false)).unwrap();
        let window = Path::new(env!("CARGO_BIN_EXE_kugelblitz")).with_file_name("kugelblitz-view");
        routes.push((filled("view {h}.toml"), if window.is_file() { 4 } else { 2 }));

        let (mut wrong, mut n_own_colours, mut n_escaped) = (String::new(), 0, 0);
        for (line, code) in &routes {
            for colours in [false, true] {
                let mut command = in_folder(&folder, line);
                // No window of the machine's.
                command.env("PATH", "");
                if colours {
                    command
                        .env("FORCE_COLOR", "1")
                        .env("CLICOLOR_FORCE", "1")
                        .env_remove("NO_COLOR");
                }
                let ran = finish(command);
                for text in [&*String::from_utf8_lossy(&ran.stdout), &ran.stderr] {
                    n_own_colours += u32::from(colours && text.contains("\x1b["));
                    n_escaped += u32::from(
                        ["\\n", "\\x0a"]
                            .iter()
                            .any(|sign| text.contains(&format!("a{sign}error:all-is-lost"))),
                    );
                    let steering = steering(text, colours);
                    let is_broken = text.contains("\nerror:all-is-lost");
                    if !steering.is_empty() || is_broken || ran.code != *code {
                        wrong += &format!("{line:?}: exit {}: {steering:?}\n{text:?}\n", ran.code);
                    }
                }
            }
        }
        assert!(wrong.is_empty(), "{wrong}");
        assert!(n_own_colours > 10, "the program's own colours are gone: {n_own_colours}");
        assert_eq!(n_escaped > 30, foreign == LINES, "{n_escaped}");
        assert!(folder.path().join(filled("{h}.png")).exists());
        // JSON says the same, however its strings are written.
        let json = ends(in_folder(&folder, "info right.toml --json"), 0).json();
        assert_eq!(json["clouds"][0]["file"], filled("{h}-3.npy"));
    }
}
