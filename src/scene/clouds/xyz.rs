//! Atoms in the chemists' XYZ format, plain and extended.

use super::text::{Head, Lines, TextFormat};
use crate::error::Result;
use crate::scene::places::quoted;

const HELP: &str = "the first line of an .xyz file is the number of atoms, the second a comment, and each further line an atom: \
                    its element, x, y and z in ångström; in the second, Properties= may name other columns";

/// Cells after the coordinates are not read in a file without `Properties=`.
pub(super) const FORMAT: TextFormat = TextFormat {
    help: HELP,
    row_help: HELP,
    empty: "expected a number of atoms in the first line, found nothing",
    is_table: false,
    head,
};

/// Columns of a file without `Properties=`.
const PLAIN: [&str; 4] = ["element", "x", "y", "z"];

fn head(lines: &mut Lines) -> Result<Option<Head>> {
    // Empty lines stand between frames and at the end.
    let count = loop {
        match lines.text()? {
            None => return Ok(None),
            Some(count) if count.is_empty() && lines.n_read > 1 => {}
            Some(count) => break count,
        }
    };
    let n_rows = lines.n_atoms(&count)?;
    let comment = lines.text()?.unwrap_or_default();
    let line = lines.n_read;
    let (names, what) = match value_of(&comment, "properties") {
        None => (PLAIN.map(String::from).to_vec(), "a plain .xyz file".into()),
        Some(properties) => {
            let names = names_of(properties).ok_or_else(|| {
                let message = format!("expected columns in Properties=, found {:?}", quoted(properties));
                let help = "Properties= lists a name, a type and a number of columns for each, for example \
                            Properties=species:S:1:pos:R:3:radius:R:1";
                lines.source.wrong(message, help).at_line(line)
            })?;
            (names, format!("Properties= in line {line}"))
        }
    };
    let notes = value_of(&comment, "lattice").map(|_| "the box (Lattice) is not drawn".into());
    Ok(Some(Head {
        n_rows,
        names,
        what,
        separator: b' ',
        has_places: false,
        header_line: None,
        cell: None,
        notes: notes.into_iter().collect(),
    }))
}

/// Returns the value of a key in a comment, `key=value` or `key="a value"`; the key in lower case.
fn value_of<'c>(comment: &'c str, key: &str) -> Option<&'c str> {
    let lower = comment.to_ascii_lowercase();
    let value = lower.match_indices(key).find_map(|(at, _)| {
        let is_word = at == 0 || lower[..at].ends_with(char::is_whitespace);
        comment[at + key.len()..].trim_start().strip_prefix('=').filter(|_| is_word)
    });
    let value = value?.trim_start();
    match value.chars().next()? {
        quote @ ('"' | '\'') => value[1..].split(quote).next(),
        _ => value.split_whitespace().next(),
    }
}

/// Largest number of columns of an atom.
const MOST_COLUMNS: usize = 4096;

/// Returns the names of the columns that `Properties=` lists: for each a name, a type and a number of columns.
fn names_of(properties: &str) -> Option<Vec<String>> {
    let words: Vec<&str> = properties.trim().split(':').collect();
    let mut names = Vec::new();
    for property in words.chunks(3) {
        let [name, _, n] = property else { return None };
        let n: usize = n.parse().ok().filter(|n| (1..=MOST_COLUMNS - names.len()).contains(n))?;
        match n {
            1 => names.push((*name).to_owned()),
            n => names.extend((0..n).map(|i| format!("{name}:{i}"))),
        }
    }
    Some(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_have_values() {
        let comment = "energy=-1 Lattice=\"5 0 0 0 5 0 0 0 5\" properties = species:S:1:pos:R:3 x";
        assert_eq!(value_of(comment, "lattice"), Some("5 0 0 0 5 0 0 0 5"));
        assert_eq!(value_of(comment, "properties"), Some("species:S:1:pos:R:3"));
        assert_eq!(value_of("sublattice=1 lattice", "lattice"), None);
        assert_eq!(value_of("Lattice=", "lattice"), None);
    }

    #[test]
    fn properties_name_columns() {
        let names = |text| names_of(text).map(|names| names.join(" "));
        let known = "species pos:0 pos:1 pos:2 radius";
        assert_eq!(names("species:S:1:pos:R:3:radius:R:1").as_deref(), Some(known));
        for wrong in ["", "pos", "pos:R", "pos:R:0", "pos:R:x", "a:R:1:pos", "a:R:99999999999"] {
            assert_eq!(names(wrong), None, "{wrong}");
        }
        assert_eq!(names_of("a:R:4000:b:R:97"), None);
    }
}
