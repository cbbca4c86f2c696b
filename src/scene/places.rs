//! Places of errors in a scene file: bytes of the text to line and column.

use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::error::{ErrorSubject, Hint, SceneError};
use crate::words::cut;

impl SceneError {
    /// An error in a text that is still being read: the span is enough, [`SceneError::in_text`] finds the place.
    pub(super) fn new(
        span: Range<usize>,
        message: impl Into<String>,
        hint: impl Into<Hint>,
    ) -> Box<SceneError> {
        Box::new(SceneError {
            path: PathBuf::new(),
            text: String::new(),
            span,
            line: 0,
            column: 0,
            subject: ErrorSubject::default(),
            value: None,
            message: message.into(),
            hint: hint.into(),
        })
    }

    /// The error with its place in `text`.
    pub(super) fn in_text(self, text: &str, path: &Path) -> Box<SceneError> {
        let start = char_start(text, self.span.start);
        let mut end = self.span.end.clamp(start, text.len());
        while !text.is_char_boundary(end) {
            end += 1;
        }
        let (line, column) = line_and_column(text, start);
        let (path, text, span) = (path.to_owned(), text.to_owned(), start..end);
        Box::new(SceneError { path, text, span, line, column, ..self })
    }

    /// An error about the file as a whole, which has no place in its text.
    pub(super) fn whole_file(
        path: &Path,
        message: impl Into<String>,
        hint: impl Into<Hint>,
    ) -> Box<SceneError> {
        Box::new(SceneError { path: path.to_owned(), ..*SceneError::new(0..0, message, hint) })
    }
}

/// The part of a key or a value that a message quotes, however much of it there is in the file.
pub(super) fn quoted(text: &str) -> Cow<'_, str> {
    cut(text, 60)
}

/// The start of the character that `byte` lies in, or the end of the text.
pub(super) fn char_start(text: &str, byte: usize) -> usize {
    let mut start = byte.min(text.len());
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    start
}

/// Line and column (characters), both from 1, of a byte of `text` at a character boundary.
fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..byte];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let line = before.bytes().filter(|&b| b == b'\n').count() + 1;
    // Editors do not show a byte order mark, so it takes up no column.
    let in_line = before[line_start..].trim_start_matches('\u{feff}');
    (line, in_line.chars().count() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_characters_from_one() {
        let text = "\u{feff}aé\r\n\nπx";
        let at = |pattern| line_and_column(text, text.find(pattern).unwrap());
        assert_eq!(line_and_column(text, 0), (1, 1));
        assert_eq!(at("a"), (1, 1));
        assert_eq!(at("é"), (1, 2));
        assert_eq!(at("\n\n"), (1, 4));
        assert_eq!(at("π"), (3, 1));
        assert_eq!(at("x"), (3, 2));
        assert_eq!(line_and_column(text, text.len()), (3, 3));
        assert_eq!(line_and_column("", 0), (1, 1));
    }

    #[test]
    fn spans_are_cut_to_characters_of_the_text() {
        let error = SceneError::new(1..99, "m", "h").in_text("é", Path::new("p"));
        assert_eq!(error.span, 0..2);
        assert_eq!(error.to_string(), "p:1:1: m");
        let error = SceneError::new(7..9, "m", "h").in_text("éa", Path::new("p"));
        assert_eq!((error.span, error.column), (3..3, 3));
    }
}
