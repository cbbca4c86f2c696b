//! The README and the guide are used: their commands run, their pictures are made again, their links
//! followed.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::ops::Range;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;

use kugelblitz_tests::root;

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

const CHAPTERS: &str = "docs/guide/src";
const PICTURES: &str = "docs/guide/src/images";
const README: &str = "README.md";

/// The paths from the root of what a folder holds.
fn entries(folder: &str) -> Vec<String> {
    let entries = fs::read_dir(root().join(folder)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.map(|name| format!("{folder}/{name}")).collect()
}

/// The chapters, by their paths from the root.
fn chapters() -> Vec<String> {
    let mut all = entries(CHAPTERS);
    all.retain(|path| path.ends_with(".md") && !path.ends_with("/SUMMARY.md"));
    assert!(all.len() >= 8, "{all:?}");
    all
}

/// A text in Markdown.
struct Page {
    /// From the root.
    path: String,
    text: String,
}

impl Page {
    fn read(path: &str) -> Page {
        let text = fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
        Page { path: path.into(), text }
    }

    /// What the text consists of, and where.
    fn events(&self) -> impl Iterator<Item = (Event<'_>, Range<usize>)> {
        Parser::new_ext(&self.text, Options::ENABLE_TABLES).into_offset_iter()
    }

    /// The lines of the blocks that are marked so, with their places in the page, from 0.
    fn lines_of(&self, mark: &str) -> Vec<(usize, String)> {
        let (mut lines, mut is_marked) = (Vec::new(), false);
        for (event, range) in self.events() {
            match event {
                Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(found))) => {
                    is_marked = &*found == mark;
                }
                Event::End(TagEnd::CodeBlock) => is_marked = false,
                Event::Text(text) if is_marked => {
                    let first = self.text[..range.start].matches('\n').count();
                    lines.extend((first..).zip(text.lines().map(str::to_string)));
                }
                _ => {}
            }
        }
        lines
    }

    /// The page's commands, each on the line that it has in the page; the other lines are empty.
    fn script(&self) -> String {
        let mut lines = vec![String::new(); 1 + self.text.lines().count()];
        for (at, command) in self.lines_of("sh") {
            lines[at] = as_installed(&command);
        }
        lines.join("\n")
    }

    /// Where its links and pictures lead.
    fn links(&self) -> Vec<String> {
        let link = |(event, _)| match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                Some(dest_url.into_string())
            }
            _ => None,
        };
        self.events().filter_map(link).collect()
    }
}

/// A line of shell without what builds, which `ci/test.sh` does before it calls this.
fn as_installed(line: &str) -> String {
    match line {
        "ci/test.sh" | "cargo install --path crates/cli" => String::new(),
        _ => line
            .replace("ci/setup.sh && ", "")
            .replace("cargo run --release -p kugelblitz-cli -- ", "kugelblitz "),
    }
}

/// What became of a page's commands.
#[derive(Default)]
struct Outcome {
    faults: Vec<String>,
    /// The pictures of the guide that were made again.
    pictures: BTreeSet<String>,
}

/// Runs a page's commands with the program in the path, in an empty folder. For pages of the guide, it holds a link `scenes`.
fn run(page: &Page) -> Outcome {
    let mut outcome = Outcome::default();
    let place = tempfile::tempdir().unwrap();
    let (folder, script) = (place.path().join("work"), place.path().join("page.sh"));
    fs::create_dir(&folder).unwrap();
    if page.path != README {
        symlink(root().join("scenes"), folder.join("scenes")).unwrap();
    }
    // The first line of a page is none of its commands.
    let line = r#"$LINENO: $(sed -n "${LINENO}p" "$0")"#;
    let report = format!("trap 'echo \"{}:{line}\" >&2' ERR", page.path);
    fs::write(&script, report + &page.script()).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_kugelblitz")).parent().unwrap();
    let output = Command::new("bash")
        .args(["-eEu", "-o", "pipefail"])
        .arg(&script)
        .current_dir(&folder)
        .env("PATH", format!("{}:{}", program.display(), env::var("PATH").unwrap()))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    if !output.status.success() {
        let words = String::from_utf8_lossy(&output.stderr);
        let words =
            words.replace(&format!("{}: line ", script.display()), &format!("{}:", page.path));
        outcome.faults.push(format!("{}: {}\n{words}", page.path, output.status));
        return outcome;
    }
    let printed = [&*output.stdout, &*output.stderr].map(String::from_utf8_lossy).concat();
    for (at, line) in page.lines_of("text") {
        if !printed.lines().any(|printed| printed.contains(&line)) {
            let place = format!("{}:{}", page.path, at + 1);
            outcome.faults.push(format!("{place}: no command prints {line:?}"));
        }
    }
    for entry in fs::read_dir(&folder).unwrap().map(Result::unwrap) {
        if entry.file_type().unwrap().is_file() {
            let name = entry.file_name().into_string().unwrap();
            let shown = root().join(PICTURES).join(&name);
            if let Err(fault) = check(&entry.path(), &shown) {
                outcome.faults.push(format!("{}: {name} {fault}", page.path));
            }
            if shown.exists() {
                outcome.pictures.insert(name);
            }
        }
    }
    outcome
}

/// A file that a page made isn't empty, a PNG can be opened, and what the guide shows is the same.
fn check(made: &Path, shown: &Path) -> Result<(), String> {
    let bytes = fs::read(made).unwrap();
    if bytes.is_empty() {
        return Err("is empty".into());
    }
    let shown = shown.exists().then(|| fs::read(shown).unwrap());
    let is_same = match made.extension().is_some_and(|ending| ending == "png") {
        true => {
            let open = |bytes: &[u8]| image::load_from_memory(bytes).map_err(|e| e.to_string());
            let made = open(&bytes)?;
            shown.is_none_or(|shown| open(&shown).as_ref() == Ok(&made))
        }
        false => shown.is_none_or(|shown| shown == bytes),
    };
    is_same.then_some(()).ok_or_else(|| format!("is not the one in {PICTURES}"))
}

#[test]
fn every_command_works_and_every_picture_is_what_its_command_draws() {
    let paths = chapters().into_iter().chain([README.into()]);
    let pages: Vec<Page> = paths.map(|path| Page::read(&path)).collect();
    let outcomes: Vec<Outcome> = thread::scope(|scope| {
        let running: Vec<_> = pages.iter().map(|page| scope.spawn(|| run(page))).collect();
        running.into_iter().map(|page| page.join().unwrap()).collect()
    });
    let faults: Vec<_> = outcomes.iter().flat_map(|outcome| &outcome.faults).cloned().collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    let n_commands: usize = pages
        .iter()
        .map(|page| page.script().lines().filter(|line| line.starts_with("kugelblitz ")).count())
        .sum();
    assert!(n_commands >= 25, "only {n_commands} commands were run");

    let made: BTreeSet<_> = outcomes.into_iter().flat_map(|outcome| outcome.pictures).collect();
    let shown: BTreeSet<String> = pages
        .iter()
        .flat_map(Page::links)
        .filter_map(|link| Some(link.split_once("images/")?.1.to_string()))
        .collect();
    for path in entries(PICTURES) {
        let name = path.strip_prefix(PICTURES).unwrap().trim_start_matches('/');
        assert!(shown.contains(name), "no page shows {path}");
        assert!(made.contains(name) || OTHERS.contains(&name), "no page's commands make {path}");
    }
}

/// Pictures that no page's commands make: a drawing, data made with scipy (`examples/drum.py`), the window, and the figures with
/// German words, which `ci/answers.sh` draws.
const OTHERS: [&str; 7] = [
    "drum.png",
    "intervals.svg",
    "window.png",
    "figure2-de.svg",
    "figure3-de.svg",
    "figure4-de.svg",
    "figure5-de.svg",
];

#[test]
fn a_command_that_fails_is_found_where_it_stands() {
    let run_text =
        |text: &str| run(&Page { path: "made-up.md".into(), text: text.into() }).faults.join("\n");
    let good = "# A page\n\n```sh\nx=1\nkugelblitz info scenes/figure1.toml\n```\n";
    assert_eq!(run_text(good), "");
    // What one block leaves, the next one finds, and a text may follow a command.
    assert_eq!(
        run_text(&format!("{good}\n```sh\ntest $x = 1\ncat > y <<'END'\nhi\nEND\n```\n")),
        ""
    );
    // Only `sh` is run.
    assert_eq!(run_text(&format!("{good}\n```console\n$ false\n```\n\n    false\n")), "");

    for (wrong, place) in [
        (
            "kugelblitz info scenes/figure9.toml",
            "made-up.md:9: kugelblitz info scenes/figure9.toml",
        ),
        ("true\nkugelblitz chek", "made-up.md:10: kugelblitz chek"),
        ("false | true", "made-up.md:9: false | true"),
        ("cat > x <<'END'\nhi\nEND\n\nfalse", "made-up.md:13: false"),
        ("echo $missing", "made-up.md:9: missing: unbound variable"),
        ("echo (", "made-up.md:9: syntax error"),
        ("> hole.npy", "hole.npy is empty"),
        ("echo no > no.png", "no.png The image format could not be determined"),
        ("echo 12\n```\n```text\n1\n777777", "made-up.md:13: no command prints \"777777\""),
    ] {
        let faults = run_text(&format!("{good}\n```sh\n{wrong}\n```\n"));
        assert!(faults.contains(place), "{wrong}: {faults}");
    }
    let other = "kugelblitz render scenes/figure1.toml -o figure1-lit.png --size 96x54";
    let faults = run_text(&format!("{good}\n```sh\n{other}\n```\n"));
    assert!(faults.contains("is not the one in"), "{faults}");
}

/// Links of a page that lead to no file, or to no heading of it.
fn dead_links(page: &Page) -> Vec<String> {
    let folder = root().join(&page.path).parent().unwrap().to_owned();
    let mut links = page.links();
    links.retain(|link| {
        let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
        let path = folder.join(file);
        let has_heading = || {
            let other = (!file.is_empty()).then(|| fs::read_to_string(&path).unwrap_or_default());
            let text = other.as_ref().unwrap_or(&page.text);
            let headings = text.lines().filter(|line| line.starts_with('#'));
            headings.map(anchor_of).any(|heading| heading == anchor)
        };
        let is_there = (file.is_empty() || path.exists()) && (anchor.is_empty() || has_heading());
        !link.starts_with("https://") && !is_there
    });
    links
}

/// What links call a heading, `two-words` for `## Two words?`.
fn anchor_of(heading: &str) -> String {
    let words = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
    words.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let others = [
        README,
        "CONTRIBUTING.md",
        "CHANGELOG.md",
        "SECURITY.md",
        "ci/README.md",
        "docs/contract.md",
        "docs/releasing.md",
    ];
    let paths = chapters().into_iter().chain(others.map(String::from));
    let pages: Vec<Page> = paths.map(|path| Page::read(&path)).collect();
    assert!(pages.iter().flat_map(Page::links).count() > 100);
    for page in &pages {
        assert_eq!(dead_links(page), [""; 0], "{}", page.path);
    }
    let text = "# It's here\n[a](lib.rs) [b](none.rs) [c](#its-here) [d](#there) [e](https://example.org) ![f](../none.png)\n\
                [g](../README.md#quick-start) [h](../README.md#none) [i](http://example.org)";
    let dead = ["none.rs", "#there", "../none.png", "../README.md#none", "http://example.org"];
    assert_eq!(dead_links(&Page { path: "src/page.md".into(), text: text.into() }), dead);
}

/// The value of a key in a manifest.
fn fact(manifest: &str, key: &str) -> String {
    let text = fs::read_to_string(root().join(manifest)).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix(&format!("{key} = ")));
    line.unwrap_or_else(|| panic!("{manifest} has no {key}")).trim_matches('"').to_owned()
}

#[test]
fn the_public_address_is_the_same_everywhere() {
    let (repository, site) = (fact("Cargo.toml", "repository"), fact("Cargo.toml", "homepage"));
    let listed = Command::new("git")
        .args(["ls-files", "*.md", "*.toml", "*.cff", "*.yml"])
        .current_dir(root())
        .output();
    let files = String::from_utf8(listed.unwrap().stdout).unwrap();
    let (mut n_repository, mut n_site) = (0, 0);
    for file in files.lines().filter(|file| !file.starts_with("docs/report")) {
        let text = fs::read_to_string(root().join(file)).unwrap();
        for (at, _) in text.match_indices("/kugelblitz") {
            let end = at + "/kugelblitz".len();
            let is_outside = |c: char| c.is_whitespace() || "\"'`()<>".contains(c);
            let start = text[..end].rfind(is_outside).map_or(0, |at| at + 1);
            match &text[start..end] {
                address if address.starts_with("https://github.com/") => {
                    assert_eq!(address, repository, "{file}");
                    n_repository += 1;
                }
                address if address.ends_with(".github.io/kugelblitz") => {
                    assert_eq!(address, site, "{file}");
                    n_site += 1;
                }
                _ => {}
            }
        }
    }
    assert!(n_repository > 10 && n_site > 4, "{n_repository} {n_site}");
}

#[test]
fn the_pages_that_open_the_repository_are_short() {
    for (path, limit) in [(README, 120), ("CHANGELOG.md", 60)] {
        let n_lines = Page::read(path).text.lines().count();
        assert!(n_lines <= limit, "{path} has {n_lines} lines, more than {limit}");
    }
    let readme = Page::read(README).text;
    let says = readme.lines().position(|line| line.contains("deterministic")).unwrap();
    assert!(says < 10, "the README begins with what this is");
}
