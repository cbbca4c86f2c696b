//! What the guide says of scenes, options, tables and the laws of the lecture is so.

use std::collections::BTreeSet;
use std::path::Path;

use kugelblitz::num::V3;
use kugelblitz::scene::{Samples, Sky, Sphere, parse_scene};
use kugelblitz_judge::show::{Entry, Show};
use kugelblitz_tests::text_of;

use crate::calculator;
use crate::program;

fn chapter(name: &str) -> String {
    text_of(&format!("docs/guide/src/{name}.md"))
}

/// The cells of a page's table whose head begins with one of these.
fn table<'a>(page: &'a str, heads: &[&str]) -> Vec<Vec<&'a str>> {
    let is_head = |line: &&str| heads.iter().any(|head| line.starts_with(&format!("| {head} |")));
    let rows: Vec<_> = page
        .lines()
        .skip_while(|line| !is_head(line))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect())
        .collect();
    assert!(rows.len() > 2, "the page has no table that begins with {heads:?}");
    rows
}

/// `x` of "`x`".
fn code(cell: &str) -> &str {
    cell.strip_prefix('`').and_then(|rest| rest.split_once('`')).expect("code").0
}

fn run(arguments: &[&str]) -> String {
    program::run(arguments, 0).text().to_owned()
}

/// Lines that are said to be defaults change nothing, and limits are those of the library.
#[test]
fn scenes_are_as_explained() {
    let parse = |text: &str| {
        parse_scene(text, Path::new("guide")).unwrap_or_else(|error| panic!("{error}\n{text}"))
    };
    let (first, light, devices) = (chapter("first-picture"), chapter("light"), chapter("devices"));
    let ball = first.split_once("<<'END'\n").unwrap().1.split_once("END\n").unwrap().0;
    let block = |page: &str| {
        let (_, rest) = page.split_once("\n```toml\n").expect("a scene");
        rest.split_once("```").expect("its end").0.to_owned()
    };
    let [camera, lit] = [&first, &light].map(|page| block(page));
    assert!(parse(&camera).camera.is_some());
    for (text, key) in [(ball, "up "), (&lit, "shadows "), (&lit, "directions ")] {
        assert!(text.contains(&format!("\n{key}")), "{key}");
        let lines: Vec<_> = text.lines().filter(|line| !line.starts_with(key)).collect();
        assert_eq!(parse(&lines.join("\n")), parse(text), "{key}");
    }
    for page in [&first, &light] {
        assert!(page.contains(&format!("at most {0} × {0}", Samples::MOST)));
    }
    assert!(light.contains(&format!("at most {}", Sky::MAX_DIRECTIONS)));
    assert!(devices.contains(&format!("{} bytes of memory", size_of::<Sphere>())));
}

#[test]
fn commands_options_and_exit_codes_are_those_of_the_program() {
    let (introduction, help) = (chapter("introduction"), run(&["--help"]));
    let commands: BTreeSet<&str> = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .map_while(|line| line.split_whitespace().next())
        .filter(|command| *command != "help")
        .collect();
    let listed = table(&introduction, &["command"]);
    let listed: BTreeSet<&str> =
        listed.iter().map(|row| code(row[0]).split(' ').next().unwrap()).collect();
    assert_eq!(listed, commands);
    for row in table(&chapter("commands"), &["exit code"]) {
        let line = format!("{:>3}  {}", row[0], row[1]);
        assert!(help.contains(&line), "{line}\n{help}");
    }
    let certificate = chapter("certificate");
    let kernels: Vec<&str> =
        table(&certificate, &["kernel"]).iter().map(|row| code(row[0])).collect();
    let help = run(&["render", "--help"]);
    assert!(help.contains(&kernels.join(", ")), "{help}");
    let options =
        introduction.split("Common options:").nth(1).unwrap().split_once("\n\n").unwrap().0;
    let options: Vec<_> = options.split('`').filter(|word| word.starts_with('-')).collect();
    assert!(options.len() >= 7, "{options:?}");
    for option in options {
        let option = option.split(' ').next().unwrap();
        assert!(help.contains(option), "{option}\n{help}");
    }
}

#[test]
fn the_guide_has_every_mode_of_show() {
    let guide = chapter("window");
    for show in Show::ALL {
        assert!(guide.contains(&format!("\n| `{show}` | ")), "{show}");
    }
    for entry in Entry::all(Show::Discriminant, None).iter().take(3) {
        assert!(guide.contains(&entry.meaning), "{}", entry.meaning);
    }
}

/// Whether all sides of an equation are equal; those of a `≠` must differ.
fn holds(equation: &str) -> bool {
    let value = |side: &str| calculator::value(side).unwrap_or_else(|| panic!("{side}"));
    let sides: Vec<_> = equation
        .split(" ≠ ")
        .map(|side| side.split(" = ").map(value).collect::<Vec<_>>())
        .collect();
    let equal = sides.iter().all(|side| side.iter().all(|one| *one == side[0]));
    equal && sides.windows(2).all(|pair| pair[0][0] != pair[1][0])
}

#[test]
fn the_laws_of_the_scalar_product_hold() {
    for name in ["lecture", "lecture-de"] {
        let page = chapter(name);
        let rows = table(&page, &["law", "Gesetz"]);
        assert_eq!(rows.len(), 5);
        for row in rows {
            assert!(holds(row[2]), "{row:?}");
        }
    }
    assert!(!holds("(1, 2, 3) • (4, −5, 6) = 13"), "a wrong number is seen");
    assert!(!holds("2·(1, 2, 3) ≠ (2, 4, 6)"), "and a wrong ≠");

    // With the program's own function: exact in whole numbers, and the law that f32 breaks.
    let v = |x, y, z| V3([x, y, z]);
    let (a, b, c) = (v(1.0, 2.0, 3.0), v(4.0, -5.0, 6.0), v(7.0, 8.0, -9.0));
    assert_eq!([a.dot(b), b.dot(a), b.dot(c), a.dot(c)], [12.0, 12.0, -66.0, -4.0]);
    assert_eq!(a.dot(b + c), a.dot(b) + a.dot(c));
    let (a, b, c): (_, V3<f32>, _) = (v(1.0, 1.0, 1.0), v(1e8, 1.0, 0.0), v(-1e8, 0.0, 0.0));
    assert_eq!((a.dot(b + c), a.dot(b) + a.dot(c)), (1.0, 0.0));
}
