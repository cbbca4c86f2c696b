//! The guide as a book of mdBook: it is built without a warning.

use std::fmt::{Debug, Write};
use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};

use kugelblitz_tests::{build_folder, root};
use mdbook_driver::MDBook;
use tracing::field::{Field, Visit};
use tracing::{Metadata, Stage, Subscriber, span};

/// What mdBook warns of.
#[derive(Clone, Default)]
struct Warnings(Arc<Mutex<Vec<String>>>);

impl Subscriber for Warnings {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Stage::WARN
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

#[test]
fn the_book_is_built_without_a_warning_and_has_all_chapters() {
    let guide = build_folder().join("guide");
    assert_eq!(build(&root().join("docs/guide"), &guide), [""; 0]);
    for entry in fs::read_dir(root().join("docs/guide/src")).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if let Some(name) = name.strip_suffix(".md").filter(|name| *name != "SUMMARY") {
            let page = guide.join(name).with_extension("html");
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
