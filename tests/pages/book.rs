//! The guide as a book of mdBook: it is built without a warning, and its links lead somewhere.

use std::fmt::{Debug, Write};
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

use kugelblitz_tests::{build_folder, root};
use mdbook_driver::MDBook;
use tracing::field::{Field, Visit};
use tracing::{Level, Metadata, Subscriber, span};

/// What mdBook warns of.
#[derive(Clone, Default)]
struct Warnings(Arc<Mutex<Vec<String>>>);

impl Subscriber for Warnings {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::WARN
    }

    fn event(&self, event: &tracing::Event<'_>) {
        let mut words = Words::default();
        event.record(&mut words);
        self.0.lock().unwrap().push(words.0);
    }

    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}
    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}
    fn enter(&self, _: &span::Id) {}
    fn exit(&self, _: &span::Id) {}
}

#[derive(Default)]
struct Words(String);

impl Visit for Words {
    fn record_debug(&mut self, _: &Field, value: &dyn Debug) {
        write!(self.0, "{value:?} ").unwrap();
    }
}

/// Builds a book and gives what is wrong with it.
fn build(book: &Path, into: &Path) -> Vec<String> {
    let warnings = Warnings::default();
    let result = tracing::subscriber::with_default(warnings.clone(), || {
        let mut book = MDBook::load(book)?;
        book.config.build.build_dir = into.into();
        book.build()
    });
    let mut faults = warnings.0.lock().unwrap().clone();
    faults.extend(result.err().map(|error| format!("{error:#}")));
    faults
}

/// The guide, built once for all tests.
fn guide() -> &'static Path {
    static GUIDE: OnceLock<PathBuf> = OnceLock::new();
    GUIDE.get_or_init(|| {
        let into = build_folder().join("guide");
        assert_eq!(build(&root().join("docs/guide"), &into), [""; 0]);
        into
    })
}

#[test]
fn the_book_is_built_without_a_warning_and_has_all_chapters() {
    for entry in fs::read_dir(root().join("docs/guide/src")).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if let Some(name) = name.strip_suffix(".md").filter(|name| *name != "SUMMARY") {
            let page = guide().join(name).with_extension("html");
            assert!(page.is_file(), "SUMMARY.md lacks {name}.md");
        }
    }
}

#[test]
fn a_book_that_is_wrong_is_noticed() {
    let place = tempfile::tempdir().unwrap();
    let faults = |summary: &str, chapter: &str| {
        let source = place.path().join("src");
        fs::create_dir_all(&source).unwrap();
        fs::copy(root().join("docs/guide/book.toml"), place.path().join("book.toml")).unwrap();
        fs::write(source.join("SUMMARY.md"), summary).unwrap();
        fs::write(source.join("one.md"), chapter).unwrap();
        build(place.path(), &place.path().join("book"))
    };
    assert_eq!(faults("- [One](one.md)\n", "# One\n"), [""; 0]);
    assert_ne!(faults("- [One](one.md)\n- [Two](two.md)\n", "# One\n"), [""; 0]);
    assert_ne!(faults("- [One](one.md)\n", "# One\n\n{{#include two.md}}\n"), [""; 0]);
    assert_ne!(faults("- [One](one.md)\n", "# One\n\n<b>open\n"), [""; 0]);
}

/// A path without `.` and `..`; what leads out of it stays in front.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        match part {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => drop(plain.pop()),
            part => plain.push(part),
        }
        plain
    })
}

/// Of the links of an HTML page of the guide, those that lead nowhere. `place` is its path in the book.
fn dead_links<'a>(html: &'a str, place: &str) -> Vec<&'a str> {
    let links =
        ["href=\"", "src=\""].into_iter().flat_map(|attribute| html.split(attribute).skip(1));
    let links = links.map(|rest| rest.split('"').next().unwrap());
    links.filter(|link| !leads_somewhere(link, html, Path::new(place))).collect()
}

fn leads_somewhere(link: &str, html: &str, place: &Path) -> bool {
    let is_elsewhere = ["https://", "data:"].iter().any(|start| link.starts_with(start));
    let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
    // Seen from docs/guide/book, where mdBook puts the book.
    let path = plain(&Path::new("docs/guide/book").join(place).parent().unwrap().join(path));
    let file = match path.strip_prefix("docs/guide/book") {
        Ok(inside) => guide().join(inside),
        Err(_) => root().join(&path),
    };
    let has_anchor = |text: &str| anchor.is_empty() || text.contains(&format!("id=\"{anchor}\""));
    let is_here = match link.starts_with('#') {
        true => has_anchor(html),
        false => fs::read_to_string(&file).map_or(file.is_file(), |text| has_anchor(&text)),
    };
    is_elsewhere || is_here
}

#[test]
fn every_link_leads_somewhere() {
    let mut n_links = 0;
    for entry in fs::read_dir(guide()).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        // The page for what is missing is seen from anywhere.
        if name.ends_with(".html") && name != "404.html" {
            let html = fs::read_to_string(entry.path()).unwrap();
            assert_eq!(dead_links(&html, &name), [""; 0], "{name}");
            n_links += html.matches("href=\"").count();
        }
    }
    assert!(n_links > 100, "{n_links}");
}

#[test]
fn a_dead_link_is_found() {
    let html = r##"<h1 id="one"></h1> <img src="images/none.png"> <a href="#one"></a> <a href="#two"></a>
        <a href="index.html"></a> <a href="none.html"></a> <a href="index.html#none"></a>
        <a href="../../../src/lib.rs"></a> <a href="../../../src/none.rs"></a>
        <a href="https://example.org"></a> <a href="http://example.org"></a>"##;
    let dead = [
        "#two",
        "none.html",
        "index.html#none",
        "../../../src/none.rs",
        "http://example.org",
        "images/none.png",
    ];
    assert_eq!(dead_links(html, "one.html"), dead);
}
