//! Errors, as the user sees them on standard error.

use std::fmt::{self, Write};
use std::io::ErrorKind;

use kugelblitz::Error;
use kugelblitz::error::SceneError;
use kugelblitz::output::OutputFile;
use kugelblitz::plain::{plain, steers};
use miette::{
    Diagnostic, LabeledSpan, MietteError, MietteHandlerOpts, MietteSpanContents, Report,
    SourceCode, SourceSpan, SpanContents,
};

use super::excerpt::Excerpt;
use super::output::{STDOUT, talk, talk_in_colour};

/// Prints what went wrong: a scene error with its place in the file, all else as one line.
pub fn complain(error: &Error) {
    match error {
        Error::Scene(error) => complain_about_scene(error),
        // Nobody reads any more (`… | head`), so nobody misses anything.
        Error::Io { path, source }
            if [OutputFile::STDOUT, STDOUT].iter().any(|name| path.as_os_str() == *name)
                && source.kind() == ErrorKind::BrokenPipe => {}
        _ => talk(&format!("error: {error}")),
    }
}

/// Prints what clap found in the command line: that it is wrong, or that it asks for help or the
/// version. Returns the exit code.
pub fn complain_about_usage(error: &clap::Error) -> u8 {
    let is_foreign = |argument: std::ffi::OsString| argument.to_string_lossy().contains(steers);
    let printed = if error.use_stderr() && std::env::args_os().any(is_foreign) {
        // It quotes arguments between its own colours, so all colours go.
        talk(error.render().to_string().trim_end());
        Ok(())
    } else {
        error.print()
    };
    match printed {
        Err(failure) if !error.use_stderr() => {
            let failure = Error::io(STDOUT)(failure);
            complain(&failure);
            failure.exit_code()
        }
        _ => error.exit_code() as u8,
    }
}

fn complain_about_scene(error: &SceneError) {
    // Lines are not broken: a path that is cut in two can't be copied.
    let hook = miette::set_hook(Box::new(|_| {
        Box::new(MietteHandlerOpts::new().terminal_links(false).wrap_lines(false).build())
    }));
    let mut text = String::new();
    let written = write!(text, "{:?}", Report::new(Finding::new(error)));
    match (hook, written) {
        (Ok(()), Ok(())) => talk_in_colour(&text),
        _ => talk(&format!("error: {error}\nhelp: {}", error.help)),
    }
}

/// A scene error with what miette shows of its file. Nothing in it steers a terminal: miette puts
/// its colours around it.
#[derive(Debug)]
struct Finding {
    title: String,
    help: String,
    shown: Option<Shown>,
}

/// The lines around a place.
#[derive(Debug)]
struct Shown {
    path: String,
    excerpt: Excerpt,
    /// Of the place, as editors count, from 1.
    line: usize,
    column: usize,
}

impl Finding {
    fn new(error: &SceneError) -> Finding {
        Finding {
            title: plain(&error.to_string()).into_owned(),
            help: plain(&error.help).into_owned(),
            shown: (error.line > 0).then(|| Shown {
                path: plain(&error.path.display().to_string()).into_owned(),
                excerpt: Excerpt::new(&error.text, error.span.clone()),
                line: error.line,
                column: error.column,
            }),
        }
    }
}

impl SourceCode for Shown {
    /// The whole excerpt, whatever is asked for. Without lines around it, miette wants to know where
    /// the place itself is, and with them, where the excerpt begins.
    fn read_span<'a>(
        &'a self,
        _: &SourceSpan,
        n_lines_before: usize,
        _: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let Excerpt { text, has_line_before, .. } = &self.excerpt;
        let (line, column) = match n_lines_before {
            0 => (self.line, self.column),
            _ => (self.line - usize::from(*has_line_before), 1),
        };
        let whole = SourceSpan::from(0..text.len());
        Ok(Box::new(MietteSpanContents::new_named(
            self.path.clone(),
            text.as_bytes(),
            whole,
            line - 1,
            column - 1,
            text.lines().count(),
        )))
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.title)
    }
}

impl std::error::Error for Finding {}

impl Diagnostic for Finding {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(&self.help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.shown.as_ref().map(|shown| shown as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.shown.as_ref()?.excerpt.span.clone();
        let label = LabeledSpan::new(Some("here".into()), span.start, span.len());
        Some(Box::new(std::iter::once(label)))
    }
}
