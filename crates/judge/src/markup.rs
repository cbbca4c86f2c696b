//! The one way of markup into a document, SVG or HTML: what no parser takes can't be written. And text in lines.
//!
//! What markup has for itself is [`escaped`] in names and texts of others. What has no place in a document at all, escaped
//! or not, [`document`] takes out.

use kugelblitz::plain::plain_document;

/// A class with its colour on a light and on a dark page.
pub type ThemeColor = (&'static str, &'static str, &'static str);

/// Style sheets with the colours of classes, which `write` makes rules of, on light pages and on dark ones.
pub fn for_light_and_dark(
    shades: &[ThemeColor],
    write: impl Fn(&str, &str) -> String,
    all: impl Fn(String) -> String,
) -> String {
    let light = all(shades.iter().map(|(class, light, _)| write(class, light)).collect());
    let dark = all(shades.iter().map(|(class, _, dark)| write(class, dark)).collect());
    format!("{light}@media screen and (prefers-color-scheme:dark){{{dark}}}")
}

/// A text as it stands in an element or in an attribute.
pub fn escaped(text: &str) -> String {
    let [amp, less, greater, quote] = ["&amp;", "&lt;", "&gt;", "&quot;"];
    text.replace('&', amp).replace('<', less).replace('>', greater).replace('"', quote)
}

/// The text of a whole document.
pub fn document(markup: &str) -> String {
    plain_document(markup)
}

/// The words of a text in lines of at most `width` columns: the first one begins with `first`, the others with `then`.
pub fn wrapped(text: &str, width: usize, first: &str, then: &str) -> Vec<String> {
    let columns = |text: &str| text.chars().count();
    let mut words = text.split_whitespace();
    let mut lines = vec![first.to_owned() + words.next().unwrap_or_default()];
    for word in words {
        match lines.last_mut() {
            Some(line) if columns(line) + 1 + columns(word) <= width => {
                *line += &format!(" {word}");
            }
            _ => lines.push(then.to_owned() + word),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_leaves_a_document_that_parses() {
        for first in (0..=0x10_ffffu32).step_by(0x400) {
            let foreign: String =
                (first..first + 0x400).filter_map(char::from_u32).collect::<String>() + "]]>&<\"'";
            let foreign = escaped(&foreign);
            let text = document(&format!("<a title=\"{foreign}\">{foreign}</a>"));
            let parsed = roxmltree::Document::parse(&text);
            let parsed = parsed.unwrap_or_else(|error| panic!("from {first:#x}: {error}"));
            assert!(parsed.root_element().text().unwrap().ends_with("]]>&<\"'"), "{first:#x}");
        }
    }
}
