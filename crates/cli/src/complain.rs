//! Errors, as the user sees them on standard error.

use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;

use crate::excerpt::Excerpt;
use crate::head::failed_in_json;
use crate::output::{STDOUT, talk, talk_in_colour};
use anstream::{AutoStream, ColorChoice};
use codespan_reporting::diagnostic::{Diagnostic, Label};
use codespan_reporting::files::{self, Files};
use codespan_reporting::term::termcolor::Buffer;
use codespan_reporting::term::{Config, emit_to_write_style};
use kugelblitz::Error;
use kugelblitz::error::SceneError;
use kugelblitz::plain::{Shown as _, plain, steers};

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
    let is_plain = AutoStream::choice(&std::io::stderr()) == ColorChoice::Never;
    let mut drawn = if is_plain { Buffer::no_color() } else { Buffer::ansi() };
    match draw(error, &mut drawn) {
        Ok(()) => talk_in_colour(String::from_utf8_lossy(drawn.as_slice()).trim_end()),
        Err(_) => talk(&format!("error: {error}\nhelp: {}", error.help)),
    }
}

/// A scene error with its lines of the file. Nothing in it steers a terminal but colours of the drawing's own.
fn draw(error: &SceneError, drawn: &mut Buffer) -> Result<(), files::Error> {
    let excerpt = match error.line {
        0 => Excerpt::default(),
        _ => Excerpt::new(&error.text, error.span.clone()),
    };
    let place = (error.line > 0).then(|| Label::primary((), excerpt.span.clone()));
    let finding = Diagnostic::error()
        .with_message(plain(&error.to_string()))
        .with_labels_iter(place)
        .with_note(plain(&format!("help: {}", error.help)));
    let config = Config { before_label_lines: 1, after_label_lines: 1, ..Config::default() };
    let path = error.path.shown();
    let shown = Shown { path, excerpt, line: error.line, column: error.column };
    emit_to_write_style(drawn, &config, &shown, &finding)
}

/// The lines around a place.
struct Shown {
    path: String,
    excerpt: Excerpt,
    /// Of the place, as editors count, from 1.
    line: usize,
    column: usize,
}

impl<'a> Files<'a> for Shown {
    type FileId = ();
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, _: ()) -> Result<&'a str, files::Error> {
        Ok(&self.path)
    }

    fn source(&'a self, _: ()) -> Result<&'a str, files::Error> {
        Ok(&self.excerpt.text)
    }

    fn line_index(&'a self, _: (), byte: usize) -> Result<usize, files::Error> {
        Ok(self.excerpt.text.bytes().take(byte).filter(|&b| b == b'\n').count())
    }

    fn line_number(&'a self, _: (), index: usize) -> Result<usize, files::Error> {
        Ok(self.line + index - usize::from(self.excerpt.has_line_before))
    }

    fn column_number(&'a self, _: (), _: usize, _: usize) -> Result<usize, files::Error> {
        Ok(self.column)
    }

    fn line_range(&'a self, _: (), index: usize) -> Result<Range<usize>, files::Error> {
        let lines = || self.excerpt.text.split_inclusive('\n').map(str::len);
        let start: usize = lines().take(index).sum();
        let none = files::Error::LineTooLarge { given: index, max: lines().count() };
        lines().nth(index).map(|n_bytes| start..start + n_bytes).ok_or(none)
    }
}
