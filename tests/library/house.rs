//! The folders of `src/` import each other one way. A folder is what lies below one name of `src/`: `scene/`, or `error.rs`
//! alone. Modules of tests don't count.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use kugelblitz_tests::root;

/// Files that import against the way, and what: each tells of facts that another folder has.
const DECLARED: [(&str, &str); 4] = [
    ("exact/mod.rs", "shape"),
    ("npy.rs", "trace"),
    ("prepare/first_stage.rs", "engine"),
    ("rays/camera.rs", "scene"),
];

/// The folders that each file of the library names, by its path below `src/`.
type Imports = BTreeMap<String, BTreeSet<String>>;

fn folder(path: &str) -> &str {
    path.split('/').next().unwrap_or_default().trim_end_matches(".rs")
}

/// The first names of the paths from the root on: `a` of `crate::a::{B, c}`.
fn names_in(text: &str) -> BTreeSet<String> {
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let lines = text.lines().filter_map(|line| line.split("//").next());
    let paths = lines.flat_map(|line| line.split("crate::").skip(1));
    paths
        .map(|path| {
            assert!(!path.starts_with('{'), "each folder has a `use` of its own: {path}");
            let is_name = |letter: &char| letter.is_alphanumeric() || *letter == '_';
            path.chars().take_while(is_name).collect()
        })
        .collect()
}

fn read_all(folder: &Path, src: &Path, imports: &mut Imports) {
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        let name = path.strip_prefix(src).expect("a path below src").to_string_lossy().into_owned();
        if path.is_dir() {
            read_all(&path, src, imports);
        } else if name.ends_with(".rs") && name != "lib.rs" && !name.contains("tests") {
            imports.insert(name, names_in(&fs::read_to_string(&path).expect("a source")));
        }
    }
}

/// What is left of the imports between folders when those who import nothing that is left are taken away again and again.
fn circles(imports: &Imports) -> Vec<String> {
    let folders: BTreeSet<&str> = imports.keys().map(|file| folder(file)).collect();
    let mut left: BTreeSet<(&str, &str, &str)> = BTreeSet::new();
    for (file, names) in imports {
        let others =
            names.iter().filter(|name| folders.contains(&***name) && *name != folder(file));
        left.extend(others.map(|name| (folder(file), &**name, &**file)));
    }
    loop {
        let importers: BTreeSet<&str> = left.iter().map(|(from, ..)| *from).collect();
        let imported: BTreeSet<&str> = left.iter().map(|(_, to, _)| *to).collect();
        let n_before = left.len();
        left.retain(|(from, to, _)| importers.contains(to) && imported.contains(from));
        if left.len() == n_before {
            return left.iter().map(|(_, to, file)| format!("{file} imports {to}")).collect();
        }
    }
}

#[test]
fn no_circle_of_imports() {
    let src = root().join("src");
    let mut imports = Imports::new();
    read_all(&src, &src, &mut imports);
    let n_imports: usize = imports.values().map(BTreeSet::len).sum();
    assert!(imports.len() > 100 && n_imports > 400, "{} files, {n_imports}", imports.len());
    for (from, to) in DECLARED {
        let is_there = imports.get_mut(from).is_some_and(|found| found.remove(to));
        assert!(is_there, "{from} no longer imports {to}: take it off the list");
    }
    let found = circles(&imports);
    assert!(found.is_empty(), "in circles:\n{}", found.join("\n"));
}

#[test]
fn circles_are_found() {
    let of = |files: &[(&str, &str)]| {
        circles(&files.iter().map(|(file, text)| (file.to_string(), names_in(text))).collect())
    };
    let a = ("a.rs", "//! [`crate::c`]\nuse crate::b::{C, D};\n");
    assert_eq!(of(&[a, ("b/c.rs", "use std::fmt;\n"), ("c.rs", "use crate::a;")]), [""; 0]);
    let b = ("b/mod.rs", "pub use crate::e;\nuse crate::c::{d::E, a};\n");
    let c = ("c.rs", "fn f() { let x = crate::a::X; }");
    let circle = ["a.rs imports b", "b/mod.rs imports c", "c.rs imports a"];
    assert_eq!(of(&[a, b, c, ("d.rs", "use crate::a;")]), circle);
    let of_tests = ("b.rs", "#[cfg(test)]\nmod tests {\n    use crate::a;\n}\n");
    assert_eq!(of(&[a, of_tests]), [""; 0]);
}
