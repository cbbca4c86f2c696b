//! The files of a crate import each other one way: no circle goes through two folders, and none
//! through `gpu/`.
//!
//! A folder is what lies below one name of a crate's `src/`: `scene/`, or `error.rs` alone. A name that a
//! `mod.rs` passes on counts for the file that it comes from. Modules of tests don't count.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::Path;

use kugelblitz_tests::root;

/// Folders that have no circle inside, either.
const WITHOUT_ANY: [&str; 1] = ["gpu"];

/// A module's names from the root on; `crate` has none.
type Module = Vec<String>;

/// The imports of each file, by their paths below `src/`.
type Imports = BTreeMap<String, BTreeSet<String>>;

struct Sources {
    /// Path and text of each module's file.
    files: BTreeMap<Module, (String, String)>,
    /// The full paths of the names that a module passes on from modules below it.
    passed_on: BTreeMap<(Module, String), Module>,
}

impl Sources {
    fn new<'a>(files: impl IntoIterator<Item = (&'a str, &'a str)>) -> Sources {
        let files = files.into_iter().map(|(path, text)| {
            (module_of(path), (path.to_string(), without_comments_and_tests(text)))
        });
        let mut sources = Sources { files: files.collect(), passed_on: BTreeMap::new() };
        let mut passed_on = BTreeMap::new();
        for (module, (_, text)) in &sources.files {
            for (start, _) in text.match_indices("use ").filter(|&(at, _)| is_public_use(text, at))
            {
                for (name, path) in tree(&text[start + "use ".len()..]) {
                    if sources.is_below(module, &path[0]) {
                        let full = [module.clone(), path].concat();
                        passed_on.insert((module.clone(), name), full);
                    }
                }
            }
        }
        sources.passed_on = passed_on;
        sources
    }

    fn is_below(&self, module: &Module, name: &str) -> bool {
        self.files.contains_key(&[module.as_slice(), &[name.to_string()]].concat())
    }

    fn imports(&self) -> Imports {
        let of_module = |(module, (path, text)): (&Module, &(String, String))| {
            let mut found = BTreeSet::new();
            for start in starts_of_names(text) {
                let name = name_at(&text[start..]);
                let is_start = matches!(name, "crate" | "kugelblitz" | "super" | "self")
                    || self.is_below(module, name);
                let is_passed_on = text[..start].ends_with("use ")
                    && is_public_use(text, start - "use ".len())
                    && self.is_below(module, name);
                if is_start && !is_passed_on && text[start + name.len()..].starts_with("::") {
                    for (_, path) in tree(&text[start..]) {
                        found.extend(self.file_of(module, &path));
                    }
                }
            }
            found.remove(path);
            (path.clone(), found)
        };
        // The root only says which modules there are.
        self.files.iter().filter(|(module, _)| !module.is_empty()).map(of_module).collect()
    }

    /// The file that a path written in `module` leads to.
    fn file_of(&self, module: &Module, path: &[String]) -> Option<String> {
        let mut at = module.clone();
        let mut rest = path.iter().peekable();
        match path.first().map(String::as_str) {
            Some("crate" | "kugelblitz") => {
                at.clear();
                rest.next();
            }
            Some("self") => drop(rest.next()),
            _ => {
                while rest.next_if(|name| *name == "super").is_some() {
                    at.pop();
                }
            }
        }
        while let Some(name) = rest.next() {
            if self.is_below(&at, name) {
                at.push(name.clone());
            } else if let Some(full) = self.passed_on.get(&(at.clone(), name.clone())) {
                let full: Module = full.iter().chain(rest).cloned().collect();
                return self.file_of(&Module::new(), &full);
            } else {
                break;
            }
        }
        self.files.get(&at).map(|(path, _)| path.clone())
    }
}

fn module_of(path: &str) -> Module {
    let mut names: Module = path.trim_end_matches(".rs").split('/').map(String::from).collect();
    if matches!(names.last().map(String::as_str), Some("mod" | "lib")) {
        names.pop();
    }
    names
}

fn without_comments_and_tests(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.flat_map(|line| [line, "\n"]).collect()
}

/// Whether the `use` at this place is a `pub use` or a `pub(…) use`.
fn is_public_use(text: &str, at: usize) -> bool {
    let line = &text[text[..at].rfind('\n').map_or(0, |end| end + 1)..at];
    line.trim_start().starts_with("pub")
}

fn is_of_name(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

fn name_at(text: &str) -> &str {
    &text[..text.find(|letter| !is_of_name(letter)).unwrap_or(text.len())]
}

/// Where names begin that are not a later part of a path.
fn starts_of_names(text: &str) -> impl Iterator<Item = usize> {
    text.char_indices().map(|(at, _)| at).filter(|&at| {
        let before = text[..at].chars().next_back();
        !name_at(&text[at..]).is_empty()
            && !before.is_some_and(is_of_name)
            && !text[..at].ends_with("::")
    })
}

/// The names that a path or a tree of paths gives, each with its full path.
fn tree(text: &str) -> Vec<(String, Module)> {
    let mut all = Vec::new();
    read_tree(text, &[], &mut all);
    all
}

/// Reads one path or one tree, and gives what follows.
fn read_tree<'a>(text: &'a str, before: &[String], all: &mut Vec<(String, Module)>) -> &'a str {
    let text = text.trim_start();
    let name = name_at(text);
    let rest = &text[name.len()..];
    let mut path = before.to_vec();
    if !name.is_empty() && (name != "self" || before.is_empty()) {
        path.push(name.to_string());
    }
    let Some(below) = rest.strip_prefix("::").map(str::trim_start) else {
        let alias = rest.trim_start().strip_prefix("as ").map(str::trim_start);
        let known_as = alias.map_or(path.last().cloned(), |rest| Some(name_at(rest).to_string()));
        if let Some(known_as) = known_as {
            all.push((known_as, path));
        }
        return alias.map_or(rest, |rest| &rest[name_at(rest).len()..]);
    };
    let Some(mut rest) = below.strip_prefix('{') else {
        let is_name = below.starts_with(is_of_name);
        return if is_name { read_tree(below, &path, all) } else { read_tree("", &path, all) };
    };
    while !rest.trim_start().starts_with('}') && !rest.trim_start().is_empty() {
        let after = read_tree(rest, &path, all).trim_start();
        rest = after.strip_prefix([',', ';', ')']).unwrap_or(after);
    }
    rest.trim_start().strip_prefix('}').unwrap_or(rest)
}

fn folder(path: &str) -> &str {
    path.split('/').next().unwrap_or_default().trim_end_matches(".rs")
}

/// The shortest way from one file to another.
fn way<'a>(imports: &'a Imports, from: &'a str, to: &str) -> Option<Vec<&'a str>> {
    let mut came_from = BTreeMap::from([(from, from)]);
    let mut next = VecDeque::from([from]);
    while let Some(at) = next.pop_front() {
        if at == to {
            let mut way = vec![at];
            while way.last() != Some(&from) {
                way.push(came_from[way[way.len() - 1]]);
            }
            way.reverse();
            return Some(way);
        }
        for import in imports.get(at).into_iter().flatten() {
            came_from.entry(import).or_insert_with(|| {
                next.push_back(import);
                at
            });
        }
    }
    None
}

/// The circles that are not allowed, each as the way around it.
fn circles(imports: &Imports) -> BTreeSet<String> {
    let all = imports.iter().flat_map(|(file, found)| found.iter().map(move |to| (file, to)));
    let counts = |(from, to): &(&String, &String)| {
        folder(from) != folder(to) || WITHOUT_ANY.contains(&folder(from))
    };
    let circle = |(from, to): (&String, &String)| {
        let mut way = way(imports, to, from)?;
        let first = way.iter().enumerate().min_by_key(|(_, file)| **file)?.0;
        way.rotate_left(first);
        way.push(way[0]);
        Some(way.join(" → "))
    };
    all.filter(counts).filter_map(circle).collect()
}

fn read_all(folder: &Path, src: &Path, files: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            read_all(&path, src, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = path.strip_prefix(src).expect("a path below src").to_string_lossy();
            let text = fs::read_to_string(&path).expect("a source");
            files.push((name.replace('\\', "/"), text));
        }
    }
}

fn imports_below(src: &str) -> Imports {
    let src = root().join(src);
    let mut files = Vec::new();
    read_all(&src, &src, &mut files);
    Sources::new(files.iter().map(|(path, text)| (path.as_str(), text.as_str()))).imports()
}

#[test]
fn no_circle_of_imports() {
    for (src, n_files, n_least) in [("src", 100, 400), ("crates/judge/src", 30, 60)] {
        let imports = imports_below(src);
        let n_imports: usize = imports.values().map(BTreeSet::len).sum();
        assert!(
            imports.len() > n_files && n_imports > n_least,
            "{src}: {} files, {n_imports}",
            imports.len()
        );
        let found: Vec<_> = circles(&imports).into_iter().collect();
        assert!(found.is_empty(), "{src}: {} circles:\n{}", found.len(), found.join("\n"));
    }
}

fn circles_of<const N: usize>(files: [(&str, &str); N]) -> Vec<String> {
    circles(&Sources::new(files).imports()).into_iter().collect()
}

#[test]
fn circles_are_found() {
    let two = [("a.rs", "use crate::b::{C, D};\n"), ("b/mod.rs", "pub use crate::a::E as F;\n")];
    assert_eq!(circles_of(two), ["a.rs → b/mod.rs → a.rs"]);
    let three = [
        ("a.rs", "fn f() { let x = kugelblitz::b::X; }"),
        ("b/mod.rs", "mod c;\npub(crate) use c::{X as Y, self};\npub use c::X;\n"),
        ("b/c.rs", "use std::fmt;\nuse super::{\n    d::{Z},\n};\n"),
        ("b/d.rs", "use super::super::a;\n"),
    ];
    assert_eq!(circles_of(three), ["a.rs → b/c.rs → b/d.rs → a.rs"]);
    let inside = [("gpu/a.rs", "use super::b::C;"), ("gpu/b.rs", "fn f(d: super::a::D) {}")];
    assert_eq!(circles_of(inside), ["gpu/a.rs → gpu/b.rs → gpu/a.rs"]);
    let below = [("gpu/a.rs", "mod b;\nuse b::C;"), ("gpu/a/b.rs", "use super::D;")];
    assert_eq!(circles_of(below), ["gpu/a.rs → gpu/a/b.rs → gpu/a.rs"]);
}

#[test]
fn other_imports_are_no_circles() {
    let passed_on = [
        ("a/mod.rs", "mod b;\nmod c;\npub use b::B;\npub use c::C;\n"),
        ("a/b.rs", "use crate::d::D;"),
        ("a/c.rs", ""),
        ("d.rs", "use crate::a::C;"),
    ];
    assert!(circles_of(passed_on).is_empty());
    let told = [
        ("a.rs", "//! [`crate::b`]\nuse std::crate_b;\n"),
        ("b.rs", "use crate::a;\n#[cfg(test)]\nmod tests {\n    use crate::c;\n}\n"),
        ("c.rs", "use crate::{a, b};"),
    ];
    assert!(circles_of(told).is_empty());
    let one_folder = [("a/b.rs", "use super::c;"), ("a/c.rs", "use super::b;")];
    assert!(circles_of(one_folder).is_empty());
}
