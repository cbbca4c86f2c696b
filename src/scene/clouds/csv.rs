//! Clouds as values between commas, semicolons, tabs or spaces.

use super::text::{Head, Lines, TextFormat};
use crate::error::Result;

pub(super) const FORMAT: TextFormat = TextFormat {
    help: "the first line names the columns: x, y, z, and optionally r or radius, and red, green, blue \
           (linear, 0 to 1, or 0 to 255), in any order and among others, with commas, semicolons, tabs \
           or spaces between them; what has other names is told by `columns = { x = \"px\" }`",
    row_help: "each line has a value for each column, like 1.5 or 2e-3, with a point and no comma",
    empty: "the file is empty",
    has_frames: false,
    head,
};

/// Reads the names in the first line that is not empty: one that begins with `#`, if only such lines
/// stand before numbers, as NumPy writes it.
fn head(lines: &mut Lines) -> Result<Option<Head>> {
    const MARK: &[u8] = b"\xef\xbb\xbf";
    let mut comment = None;
    let line = loop {
        let Some(line) = lines.next()? else {
            if comment.is_none() {
                return Ok(None);
            }
            break Vec::new();
        };
        let line = line.strip_prefix(MARK).unwrap_or(line).trim_ascii().to_vec();
        if line.starts_with(b"#") {
            comment = Some(line);
        } else if !line.is_empty() {
            break line;
        }
    };
    let is_row = line.is_empty() || is_number_first(&line);
    let (header, first_row) = match comment.filter(|_| is_row) {
        Some(comment) => {
            let n = comment.iter().take_while(|byte| b"# \t".contains(byte)).count();
            (comment[n..].to_vec(), Some(line))
        }
        None => (line, None),
    };
    let separator = separator_of(&header, first_row.as_deref().unwrap_or_default());
    lines.put_back(header);
    lines.row(separator, first_row.is_none())?;
    let mut names = lines.cells();
    if separator == b' ' {
        names.retain(|name| !is_unit(name));
    }
    if let Some(row) = first_row {
        lines.put_back(row);
    }
    let (what, scaled) = ("the header".into(), Vec::new());
    Ok(Some(Head { n_rows: (usize::MAX, 0), names, what, separator, scaled, note: None }))
}

/// What stands between the names of a header; where that can't be seen, between the first row's values.
fn separator_of(header: &[u8], row: &[u8]) -> u8 {
    let count = |line: &[u8], separator: u8| {
        let mut is_quoted = false;
        let is_free = |byte: &&u8| {
            is_quoted ^= **byte == b'"';
            **byte == separator && !is_quoted
        };
        line.iter().filter(is_free).count()
    };
    for line in [header, row] {
        let is_there = |separator: &u8| count(line, *separator) > 0;
        if let Some(separator) = [b'\t', b';', b','].into_iter().find(is_there) {
            return separator;
        }
        if count(line.trim_ascii(), b' ') > 0 {
            return b' ';
        }
    }
    b','
}

fn is_number_first(line: &[u8]) -> bool {
    let word = line.split(|byte| b",;\t \"".contains(byte)).find(|word| !word.is_empty());
    let word = word.and_then(|word| std::str::from_utf8(word).ok());
    word.is_some_and(|word| word.parse::<f64>().is_ok())
}

/// True for a word in brackets, which is a unit where spaces separate.
fn is_unit(name: &str) -> bool {
    let is_between = |open, close| name.starts_with(open) && name.ends_with(close);
    is_between('[', ']') || is_between('(', ')')
}
