//! Errors, as the user sees them on standard error.

use std::io::ErrorKind;
use std::path::Path;

use kugelblitz::Error;
use kugelblitz::error::SceneError;
use kugelblitz::plain::{Shown as _, plain, steers};
use miette::{
    LabeledSpan, MietteDiagnostic, MietteError, MietteHandlerOpts, MietteSpanContents, Report,
    SourceCode, SourceSpan, SpanContents,
};

use super::excerpt::Excerpt;
use super::head::failed_in_json;
use super::output::{STDOUT, talk, talk_in_colour};

/// Prints what went wrong: a scene error with its place in the file, all else as one line. `writes`
/// says whether the command has output files.
pub fn complain(error: &Error, writes: bool) {
    match error {
        Error::Scene(error) => complain_about_scene(error),
        Error::Interrupted if writes => talk("error: interrupted; no output file was changed"),
        // Nobody reads any more (`… | head`), so nobody misses anything.
        Error::Io { path, source }
            if path.as_os_str() == STDOUT && source.kind() == ErrorKind::BrokenPipe => {}
        _ => talk(&format!("error: {error}")),
    }
}

/// Prints what clap found in the command line: that it is wrong, or that it asks for help or the
/// version. Returns the exit code.
pub fn complain_about_usage(error: &clap::Error) -> u8 {
    let is_odd = |c: char| steers(c) || matches!(c, '\n' | '\t');
    let arguments = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    let foreign: Vec<String> = arguments.filter(|argument| argument.contains(is_odd)).collect();
    let printed = if error.use_stderr() && !foreign.is_empty() {
        // It quotes arguments, or their values, between its own colours, so all colours go.
        let mut words = error.render().to_string();
        for argument in &foreign {
            let value = argument.split_once('=').map(|(_, value)| value);
            for quoted in value.into_iter().chain([argument.as_str()]) {
                words = words.replace(quoted, &Path::new(quoted).shown());
            }
        }
        talk(words.trim_end());
        Ok(())
    } else {
        error.print()
    };
    match printed {
        Err(failure) if !error.use_stderr() => {
            let failure = Error::io(STDOUT)(failure);
            complain(&failure, false);
            failure.exit_code()
        }
        _ if error.use_stderr() => {
            let rendered = error.render().to_string();
            let (message, _) = rendered.split_once("\n\n").unwrap_or((&rendered, ""));
            let message = message.trim().trim_start_matches("error: ").to_string();
            let usage = Error::Usage(message);
            failed_in_json(&usage);
            usage.exit_code()
        }
        _ => error.exit_code() as u8,
    }
}

fn complain_about_scene(error: &SceneError) {
    // Lines are not broken: a path that is cut in two can't be copied.
    let hook = miette::set_hook(Box::new(|_| {
        Box::new(MietteHandlerOpts::new().terminal_links(false).wrap_lines(false).build())
    }));
    match hook {
        Ok(()) => talk_in_colour(&format!("{:?}", finding(error))),
        Err(_) => talk(&format!("error: {error}\nhelp: {}", error.help)),
    }
}

/// A scene error with its lines of the file. Nothing in it steers a terminal: miette puts its colours
/// around it.
fn finding(error: &SceneError) -> Report {
    let finding = MietteDiagnostic::new(plain(&error.to_string())).with_help(plain(&error.help));
    if error.line == 0 {
        return Report::new(finding);
    }
    let excerpt = Excerpt::new(&error.text, error.span.clone());
    let place = LabeledSpan::new_with_span(Some("here".into()), excerpt.span.clone());
    let path = error.path.shown();
    let shown = Shown { path, excerpt, line: error.line, column: error.column };
    Report::new(finding.with_label(place)).with_source_code(shown)
}

/// The lines around a place.
struct Shown {
    path: String,
    excerpt: Excerpt,
    /// Of the place, as editors count, from 1.
    line: usize,
    column: usize,
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
