//! Text of others made fit to be shown: file names, what a file holds, what a driver says.
//!
//! A terminal takes some characters for orders: to colour, to clear, to overwrite a line, to write
//! from right to left. In a name or a cell such an order is not meant.

use std::borrow::Cow;
use std::path::Path;

/// True for a character that steers a terminal: the control characters of ASCII and Unicode (C0, DEL, C1)
/// but line feed and tab, and the marks that turn the direction of writing (Unicode Standard Annex 9,
/// section 2).
pub fn steers(c: char) -> bool {
    (c.is_control() && !matches!(c, '\n' | '\t'))
        || matches!(
            c,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

/// `text` with each character that [`steers`] as Rust writes it in a string: `\u{1b}`, `\r`.
pub fn plain(text: &str) -> Cow<'_, str> {
    replaced(text, |c| c.escape_default().to_string())
}

/// JSON that says the same as `json`, with each character that [`steers`] as JSON writes it in a
/// string: `\u001b`.
pub fn plain_json(json: &str) -> Cow<'_, str> {
    // All of them are in Unicode's first plane, and valid JSON has them in strings alone.
    replaced(json, |c| format!("\\u{:04x}", u32::from(c)))
}

fn replaced(text: &str, escape: impl Fn(char) -> String) -> Cow<'_, str> {
    if !text.chars().any(steers) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len() + 64);
    for c in text.chars() {
        if steers(c) { plain += &escape(c) } else { plain.push(c) }
    }
    Cow::Owned(plain)
}

/// A whole document with a mark in the place of each character that has none in it: those that [`steers`],
/// tabs, and U+FFFE and U+FFFF, which are none to XML.
pub fn plain_document(text: &str) -> String {
    let has_no_place = |c| steers(c) || matches!(c, '\t' | '\u{fffe}' | '\u{ffff}');
    text.chars().map(|c| if has_no_place(c) { '\u{fffd}' } else { c }).collect()
}

/// A path or a name for people.
pub trait Shown {
    /// The text on one line, with each character that [`steers`] and each tab and line break as Rust writes
    /// it in a string: `\n`.
    fn shown(&self) -> String;
}

impl Shown for str {
    fn shown(&self) -> String {
        plain(self).replace('\n', "\\n").replace('\t', "\\t")
    }
}

impl Shown for Path {
    fn shown(&self) -> String {
        self.to_string_lossy().shown()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_one_line() {
        assert_eq!(Path::new("a\nb\tc\rd ü").shown(), "a\\nb\\tc\\rd ü");
    }

    #[test]
    fn what_steers_is_written_out() {
        assert_eq!(plain("a\tb\nü → 球"), "a\tb\nü → 球");
        assert_eq!(plain("\x1b[31m\u{9b}2J\r\u{7f}"), "\\u{1b}[31m\\u{9b}2J\\r\\u{7f}");
        assert_eq!(plain("\u{202e}\u{200f}\u{61c}"), "\\u{202e}\\u{200f}\\u{61c}");
        let all = |(first, last): (char, char)| (first..=last).filter(|&c| steers(c)).count();
        let blocks = [('\0', '\x1f'), ('\x7f', '\u{9f}'), ('\u{202a}', '\u{202e}')];
        assert_eq!(blocks.map(all), [30, 33, 5]);
        assert!(!('\u{a0}'..='\u{60f}').any(steers) && !('\u{2070}'..=char::MAX).any(steers));
    }

    #[test]
    fn json_stays_what_it_was() {
        let text = "\u{9b}\u{7f}\u{2066}\x1b\"\\\n\u{1f600}";
        let json = serde_json::to_string(text).unwrap();
        let escaped = plain_json(&json);
        assert!(!escaped.chars().any(steers));
        assert_eq!(serde_json::from_str::<String>(&escaped).unwrap(), text);
    }
}
