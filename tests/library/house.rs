//! The folders of `src/` import each other one way. A folder is what lies below one name of `src/`: `scene/`, or `error.rs`
//! alone. Modules of tests don't count. And names: no two public types of the libraries share one, and each comment on an item
//! names its subject.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use kugelblitz_tests::root;

/// Files that import against the way, and what: each tells of facts that another folder has.
const DECLARED: [(&str, &str); 2] =
    [("prepare/first_stage.rs", "visibility"), ("rays/camera.rs", "scene")];

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

/// The sources of a library, by their paths below its folder.
fn sources_in(folder: &str) -> BTreeMap<String, String> {
    let src = root().join(folder);
    let (mut folders, mut sources) = (vec![src.clone()], BTreeMap::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            let below = path.strip_prefix(&src).expect("a path below the folder");
            let name = below.to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".rs") && !name.contains("tests") {
                sources.insert(name, fs::read_to_string(&path).expect("a source"));
            }
        }
    }
    sources
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
    let mut sources = sources_in("src");
    sources.remove("lib.rs");
    let mut imports: Imports =
        sources.into_iter().map(|(path, text)| (path, names_in(&text))).collect();
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

/// Sources of all crates.
const CRATES: [&str; 6] = [
    "src",
    "crates/cli/src",
    "crates/judge/src",
    "crates/report/src",
    "crates/view/src",
    "python/src",
];

/// Returns the name of the type that a line declares, public or private. An indented line may be an associated type.
fn type_in(line: &str) -> Option<&str> {
    let item = line.trim_start();
    let is_indented = item.len() < line.len();
    let item = match item.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
        Some(rest) => rest.strip_prefix(' ')?,
        None => item,
    };
    if is_indented && item.starts_with("type ") {
        return None;
    }
    let kinds = ["struct ", "enum ", "trait ", "type ", "union "];
    let rest = kinds.iter().find_map(|kind| item.strip_prefix(kind))?;
    let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    (!name.is_empty()).then_some(name)
}

/// Types that are declared in several places.
fn shared_names(sources: &BTreeMap<String, String>) -> Vec<String> {
    let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    // A file for Windows has the names of its twin.
    for (path, text) in sources.iter().filter(|(path, _)| !path.ends_with("_windows.rs")) {
        let (code, _) = text.split_once("#[cfg(test)]").unwrap_or((text, ""));
        for name in code.lines().filter_map(type_in) {
            places.entry(name).or_default().push(path);
        }
    }
    places.retain(|_, places| places.len() > 1);
    places.iter().map(|(name, places)| format!("{name}: {}", places.join(", "))).collect()
}

/// Comments on items whose first line begins with what only the item itself explains.
fn comments_without_subject(path: &str, text: &str) -> Vec<String> {
    let comment = |line: &str| {
        let line = line.trim_start();
        let text = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))?;
        Some(text.trim_start().to_owned())
    };
    let lines: Vec<Option<String>> = text.lines().map(comment).collect();
    let begins = |at: &usize| at.checked_sub(1).is_none_or(|before| lines[before].is_none());
    let has_none = |text: &String| {
        ["Of ", "Those ", "Its ", "The same", "As [`"].iter().any(|start| text.starts_with(start))
    };
    (0..lines.len())
        .filter(begins)
        .filter(|&at| lines[at].as_ref().is_some_and(has_none))
        .map(|at| format!("{path}:{}", at + 1))
        .collect()
}

#[test]
fn public_types_and_comments_have_names_of_their_own() {
    let of_library = |folder| {
        let sources = sources_in(folder).into_iter();
        sources.map(move |(path, text)| (format!("{folder}/{path}"), text))
    };
    let sources: BTreeMap<String, String> = CRATES.into_iter().flat_map(of_library).collect();
    assert!(sources.len() > 200, "{} files", sources.len());
    assert_eq!(shared_names(&sources), [""; 0]);
    let comments = sources.iter().flat_map(|(path, text)| comments_without_subject(path, text));
    assert_eq!(comments.collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn shared_names_and_comments_without_subject_are_found() {
    let sources = [
        ("a.rs", "pub struct A<T>(T);\npub(crate) enum B {}\n    type C = u8;\n"),
        ("b.rs", "    enum A {}\ntype C = u8;\n#[cfg(test)]\nstruct B;\n"),
    ];
    let sources = sources.map(|(path, text)| (path.to_owned(), text.to_owned()));
    assert_eq!(shared_names(&sources.into()), ["A: a.rs, b.rs"]);
    let text = "//! Offsets.\n\n/// Of a ray.\nx\n    /// A ray.\n    /// Its origin.\ny\n/// The same [`X`].\nz\n";
    assert_eq!(comments_without_subject("a.rs", text), ["a.rs:3", "a.rs:8"]);
}
