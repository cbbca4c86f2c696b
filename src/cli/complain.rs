//! Errors, as the user sees them on standard error.

use std::fmt;
use std::io::ErrorKind;

use kugelblitz::Error;
use kugelblitz::output::OutputFile;
use kugelblitz::scene::SceneError;
use miette::{Diagnostic, LabeledSpan, MietteHandlerOpts, NamedSource, Report, SourceCode};

use super::output::STDOUT;

/// Prints what went wrong: a scene error with its place in the file, all else as one line.
pub fn complain(error: &Error) {
    match error {
        Error::Scene(error) => complain_about_scene(error),
        // Nobody reads any more (`… | head`), so nobody misses anything.
        Error::Io { path, source }
            if [OutputFile::STDOUT, STDOUT].iter().any(|name| path.as_os_str() == *name)
                && source.kind() == ErrorKind::BrokenPipe => {}
        _ => eprintln!("error: {}", printable(&error.to_string())),
    }
}

fn complain_about_scene(error: &SceneError) {
    // Lines are not broken: a path that is cut in two can't be copied.
    let hook = miette::set_hook(Box::new(|_| {
        Box::new(MietteHandlerOpts::new().terminal_links(false).wrap_lines(false).build())
    }));
    let report = Report::new(Excerpt::new(error));
    match hook {
        Ok(()) => eprintln!("{report:?}"),
        Err(_) => eprintln!("error: {report}\nhelp: {}", error.help),
    }
}

/// A scene error with what miette shows of its file.
#[derive(Debug)]
struct Excerpt {
    title: String,
    help: String,
    source: Option<NamedSource<String>>,
    label: LabeledSpan,
}

impl Excerpt {
    fn new(error: &SceneError) -> Excerpt {
        let has_place = error.line > 0;
        Excerpt {
            title: printable(&error.to_string()),
            help: printable(&error.help),
            source: has_place.then(|| {
                NamedSource::new(error.path.display().to_string(), printable(&error.text))
            }),
            label: LabeledSpan::new(Some("here".into()), error.span.start, error.span.len()),
        }
    }
}

/// `text` without what would steer the terminal. Every byte keeps its place.
fn printable(text: &str) -> String {
    let keep = |c: char| !c.is_ascii_control() || matches!(c, '\n' | '\r' | '\t');
    text.chars().map(|c| if keep(c) { c } else { '?' }).collect()
}

impl fmt::Display for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.title)
    }
}

impl std::error::Error for Excerpt {}

impl Diagnostic for Excerpt {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(&self.help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.source.as_ref()?;
        Some(Box::new(std::iter::once(self.label.clone())))
    }
}
