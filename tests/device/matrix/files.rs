//! Scenes of the repository, and small ones in which something certain was wrong once.

use glam::DVec3;
use kugelblitz_tests::{root, text_of};
use toml::{Table, Value};

use super::{Case, USUAL};

/// Cases whose numbers were broken promises: a name, a size, a scene's text, and rays.
const PROMISES: &str = "tests/data/promises.toml";

const FOLDERS: [&str; 5] =
    ["scenes", "scenes/hard", "scenes/lit", "scenes/lit/hard", "tests/data/ends"];

fn promises() -> Vec<Table> {
    let table: Table = text_of(PROMISES).parse().expect("cases");
    let cases = table["case"].as_array().expect("cases");
    cases.iter().map(|case| case.as_table().expect("a case").clone()).collect()
}

/// All files but those of clouds, which the oracle does not read, and all promises.
pub fn names() -> Vec<String> {
    let mut names = Vec::new();
    for folder in FOLDERS {
        let entries = std::fs::read_dir(root().join(folder)).expect("a folder of scenes");
        let files = entries.map(|entry| entry.expect("a file").file_name());
        let files = files.map(|file| format!("{folder}/{}", file.display()));
        let is_scene =
            |file: &String| file.ends_with(".toml") && !text_of(file).contains("[[spheres]]");
        names.extend(files.filter(is_scene));
    }
    names.sort();
    names.extend(promises().iter().map(|case| text(case, "name")));
    names
}

fn text(case: &Table, key: &str) -> String {
    case[key].as_str().unwrap_or_else(|| panic!("{key}")).to_string()
}

fn vector(value: &Value) -> DVec3 {
    let number = |i: usize| value[i].as_float().expect("a float");
    DVec3::new(number(0), number(1), number(2))
}

/// The file or promise of this name, by which its failures are replayed.
pub fn case(name: &str) -> Case {
    match promises().iter().find(|case| text(case, "name") == name) {
        None => {
            let size = [2 * USUAL[0] + 1, USUAL[1] + 6];
            Case::new("files", name.to_string(), text_of(name), size, &[], 0)
        }
        Some(case) => {
            let size = [0, 1].map(|i| case["size"][i].as_integer().expect("a size") as u32);
            let rays = case["rays"].as_array().expect("rays").iter();
            let rays: Vec<_> = rays.map(|ray| [vector(&ray[0]), vector(&ray[1])]).collect();
            Case::new("promises", name.to_string(), text(case, "scene"), size, &rays, 0)
        }
    }
}
