//! Errors, as the user sees them on standard error.

use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;

use crate::args::Cli;
use crate::head::failed_in_json;
use crate::output::{STDOUT, talk, talk_in_colour};
use anstream::{AutoStream, ColorChoice};
use clap::Parser;
use codespan_reporting::diagnostic::{Diagnostic, Label};
use codespan_reporting::files::{self, Files};
use codespan_reporting::term::termcolor::Buffer;
use codespan_reporting::term::{Config, emit_to_write_style};
use kugelblitz::Error;
use kugelblitz::error::SceneError;
use kugelblitz::plain::{Shown as _, plain};

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
pub fn complain_about_usage(error: clap::Error) -> u8 {
    // It quotes arguments, which are read once more as they are shown.
    let shown = std::env::args_os().map(|argument| Path::new(&argument).shown());
    let error = Cli::try_parse_from(shown).err().unwrap_or(error);
    match error.print() {
        Err(failure) if !error.use_stderr() => {
            let failure = Error::io(STDOUT)(failure);
            complain(&failure, false);
            failure.exit_code()
        }
        _ if error.use_stderr() => {
            let rendered = error.render().to_string();
            let (message, _) = rendered.split_once("\n\n").unwrap_or((&rendered, ""));
            let usage = Error::Usage(message.trim().trim_start_matches("error: ").to_string());
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
    /// Line of the place, as editors count, from 1.
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

/// Columns of a line that are shown.
const COLUMNS: usize = 200;

/// Columns of them from the place on, where the line is cut at both ends.
const COLUMNS_BEHIND: usize = 120;

/// Stands for the rest of a line.
const CUT: char = '…';

/// The line of a place, with the lines before and behind it, none longer than some [`COLUMNS`] and
/// with nothing in them that steers a terminal.
#[derive(Debug, Default, PartialEq)]
pub struct Excerpt {
    /// The lines.
    pub text: String,
    /// Bytes of `text` that the place is.
    pub span: Range<usize>,
    /// True where there is a line before that of the place.
    pub has_line_before: bool,
}

impl Excerpt {
    /// The excerpt around `span`, bytes of `text` between character boundaries. Of a span of several
    /// lines, the first one counts. Takes time in proportion to these lines.
    pub fn new(text: &str, span: Range<usize>) -> Excerpt {
        let line_start = text[..span.start].rfind('\n').map_or(0, |newline| newline + 1);
        let line_end = text[span.start..].find('\n').map_or(text.len(), |n| span.start + n);
        let mut excerpt = Excerpt::default();
        if let Some(before) = text[..line_start].lines().next_back() {
            excerpt.push("", before, 0);
            excerpt.text.push('\n');
            excerpt.has_line_before = true;
        }
        let (before, behind) = (&text[line_start..span.start], &text[span.start..line_end]);
        let place = excerpt.push(before, without_return(behind), span.len());
        if place.start == excerpt.text.len() {
            // The end of a line is a place, but nothing to put a mark under.
            excerpt.text.push(' ');
        }
        excerpt.span = place;
        if let Some(behind) = text.get(line_end + 1..) {
            excerpt.text.push('\n');
            excerpt.push("", behind.lines().next().unwrap_or_default(), 0);
        }
        excerpt
    }

    /// Adds a line with a place in it: what is before it, and what begins with its `n_bytes`. Gives the
    /// bytes of `text` that the place then is.
    fn push(&mut self, before: &str, behind: &str, n_bytes: usize) -> Range<usize> {
        let n_before = before.chars().rev().take(COLUMNS).count();
        let n_behind = behind.chars().take(COLUMNS).count();
        let n_behind = n_behind.min(COLUMNS_BEHIND.max(COLUMNS - n_before));
        let n_before = n_before.min(COLUMNS - n_behind);

        let start = before.char_indices().rev().take(n_before).last();
        let start = start.map_or(before.len(), |(byte, _)| byte);
        if start > 0 {
            self.text.push(CUT);
        }
        self.text += &plain(&before[start..]);
        let end = behind.char_indices().nth(n_behind).map_or(behind.len(), |(byte, _)| byte);
        let (place, rest) = behind[..end].split_at(n_bytes.min(end));
        let place_start = self.text.len();
        self.text += &plain(place);
        let place = place_start..self.text.len();
        self.text += &plain(rest);
        if end < behind.len() {
            self.text.push(CUT);
        }
        place
    }
}

/// A line without the `\r` that ends it in files from Windows.
fn without_return(line: &str) -> &str {
    line.strip_suffix('\r').unwrap_or(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `text` has the place between `‹` and `›`, and so has what is expected.
    fn check(text: &str, expected: &str) {
        let place = |text: &str| {
            let start = text.find('‹').unwrap();
            (text.replace(['‹', '›'], ""), start..text.find('›').unwrap() - '‹'.len_utf8())
        };
        let (text, span) = place(text);
        let (expected, expected_span) = place(expected);
        let excerpt = Excerpt::new(&text, span);
        assert_eq!((excerpt.text, excerpt.span), (expected, expected_span));
    }

    #[test]
    fn short_lines_stay_whole() {
        check("‹a›b", "‹a›b");
        check("1\n2\n3 ‹x› y\n4\n5\n", "2\n3 ‹x› y\n4");
        check("1\r\n‹é›\r\n3\r\n", "1\n‹é›\n3");
        check("‹›", "‹› ");
        check("a\n‹›", "a\n‹› ");
        check("a‹›\r\nb", "a‹› \nb");
        check("a‹\r\n›b", "a‹› \nb");
        check("‹[1,\n2,\n3]›\n4", "‹[1,›\n2,");
        let line = "0123456789".repeat(20);
        let marked = format!("{}‹{}›{}", &line[..150], &line[150..160], &line[160..]);
        check(&marked, &marked);
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let x = |n: usize| "x".repeat(n);
        check(&format!("‹{}›", x(201)), &format!("‹{}›…", x(200)));
        check(&format!("{}‹y›{}", x(500), x(500)), &format!("…{}‹y›{}…", x(80), x(119)));
        check(&format!("{}‹y›", x(500)), &format!("…{}‹y›", x(199)));
        check(&format!("{}‹y›{}", x(20), x(500)), &format!("{}‹y›{}…", x(20), x(179)));
        check(
            &format!("{}‹{}›", x(500), "é".repeat(500)),
            &format!("…{}‹{}›…", x(80), "é".repeat(120)),
        );
        check(&format!("{}\n‹y›\n{}", x(500), x(500)), &format!("{}…\n‹y›\n{}…", x(200), x(200)));
    }

    #[test]
    fn what_steers_moves_the_place_along() {
        check("\u{9b}‹\u{202e}›\r \x1b", "\\u{9b}‹\\u{202e}›\\r \\u{1b}");
    }
}
