//! Tables of text: cells between commas, semicolons, tabs or spaces, below a header.

use super::columns::have_center;
use super::numbers::{is_number, n_numbers};
use super::text::{Head, Lines, TextFormat, is_comment};
use super::units::{Unit, name_and_unit};
use crate::error::{Hint, Result, Setting, SettingValue};
use crate::scene::places::quoted;
use crate::scene::schema::{ColumnChoice, ColumnKeys, Section};
use crate::scene::sniff::DataFormat;

pub(super) const FORMAT: TextFormat = TextFormat {
    help: "the first line names the columns: x, y, z, and optionally r or radius, and red, green, blue (0 to 1, or 0 to 255) or \
           color (\"#rrggbb\"), with commas, semicolons, tabs or spaces between them",
    row_help: "write a value for each column, numbers as 1.5 or 2e-3",
    empty: "the file is empty",
    is_table: true,
    head,
};

/// Lines in which a header, or the first row below it, is looked for.
const MAX_LINES_OF_TEXT: usize = 20;

/// A line that names columns.
struct HeaderLine {
    line: u64,
    separator: u8,
    names: Vec<String>,
    /// Whether the names are quoted.
    is_quoted: bool,
}

/// Finds the header: the line that the scene chooses; else the first line that is neither empty nor a comment; else, if that is
/// a row of numbers, the last comment that names columns.
fn head(lines: &mut Lines) -> Result<Option<Head>> {
    let source = lines.source;
    let chosen = source.keys.header.map(u64::from);
    let mut separator = None;
    let mut comments: Vec<HeaderLine> = Vec::new();
    let first = loop {
        let Some(text) = lines.text()? else { break None };
        let line = lines.n_read;
        if chosen.is_some_and(|chosen| line < chosen) {
            continue;
        }
        if let Some(mark) = excel_separator(&text) {
            separator = Some(mark);
        } else if chosen.is_some() {
            let header = HeaderLine::new(line, &text, separator);
            return with_rows(lines, header, None).map(Some);
        } else if is_comment(text.as_bytes()) {
            comments.push(HeaderLine::new(line, &text, separator));
        } else if !text.is_empty() {
            break Some(lines.whole_text());
        }
    };
    if let Some(chosen) = chosen {
        let message = format!("the file has no line {chosen}, which `header` names");
        let hint = Hint::new(
            "give a number up to {}",
            [Setting::number("header", lines.n_read.saturating_sub(1) as f64)],
        );
        return Err(source.wrong_at(source.keys.span("header"), message, hint).into());
    }
    let names_center = names_center(source.keys.columns.as_ref());
    let named = comments.iter().rposition(|comment| have_center(&comment.names));
    let comment = match named {
        Some(at) => Some(comments.swap_remove(at)),
        None => comments.pop(),
    };
    let Some(mut first) = first else {
        return comment.map(|comment| with_rows(lines, comment, None)).transpose();
    };
    // Rows below a comment that names columns may begin with a label.
    if is_number_first(&first) || named.is_some() && n_numbers(&first) > 2 {
        // CloudCompare and programs in Fortran write the number of points above the rows.
        if first.trim().bytes().all(|byte| byte.is_ascii_digit())
            && let Some(row) = next_row(lines)?
        {
            first = row;
        }
        // A comment of other words is no header.
        let names_chosen = |comment: &HeaderLine| {
            let columns = source.keys.columns.as_ref();
            names_center && columns.is_some_and(|columns| has_chosen(columns, &comment.names))
        };
        return match comment.filter(|comment| named.is_some() || names_chosen(comment)) {
            Some(comment) => with_rows(lines, comment, Some(first)),
            None => without_header(lines, &first, separator),
        }
        .map(Some);
    }
    // A name in quotes may have line breaks.
    let line = lines.n_read;
    let header_separator = separator.unwrap_or_else(|| separator_of(&first));
    let is_quoted = first.starts_with('"');
    lines.repeat();
    lines.row(header_separator, true)?;
    let names = with_units(lines.cells(), header_separator);
    let header = HeaderLine { line, separator: header_separator, names, is_quoted };
    if !have_center(&header.names) && !names_center {
        refuse_lines_above_header(lines, &header, separator)?;
    }
    with_rows(lines, header, None).map(Some)
}

impl HeaderLine {
    fn new(line: u64, text: &str, separator: Option<u8>) -> HeaderLine {
        let marks: &[char] =
            if text.starts_with("//") { &['/', ' ', '\t'] } else { &['#', ' ', '\t'] };
        let is_marked = is_comment(text.as_bytes());
        let text = if is_marked { text.trim_start_matches(marks) } else { text };
        // yade writes `#format x_y_z_r`.
        if let Some(names) = text.strip_prefix("format ").filter(|_| is_marked) {
            let names = names.trim().split('_').map(String::from).collect();
            return HeaderLine { line, separator: b' ', names, is_quoted: false };
        }
        let separator = separator.unwrap_or_else(|| separator_of(text));
        let names = with_units(cells_of(text, separator), separator);
        HeaderLine { line, separator, names, is_quoted: text.starts_with('"') }
    }
}

/// Refuses a file with other lines above the header; the error names the header's line.
fn refuse_lines_above_header(
    lines: &mut Lines,
    first: &HeaderLine,
    separator: Option<u8>,
) -> Result<()> {
    let mut skipped = Vec::new();
    for _ in 0..MAX_LINES_OF_TEXT {
        let Some(text) = lines.text()? else { break };
        let below = HeaderLine::new(lines.n_read, &text, separator);
        if have_center(&below.names) {
            let message =
                format!("expected names of columns, found {:?}", quoted(&first.names.join(", ")));
            let hint = Hint::new("{}", [Setting::number("header", below.line as f64)])
                .after(format!("line {} looks like the header; use it with ", below.line));
            return Err(lines.source.wrong(message, hint).at_line(first.line).into());
        }
        let is_row = n_numbers(&text) > 2;
        skipped.push(text);
        if is_row {
            break;
        }
    }
    // There is no better header, so the missing column is the error.
    lines.put_back(skipped.pop().unwrap_or_default().into_bytes());
    Ok(())
}

/// Returns the head of a table with this header. `first` is the first row, if it was read.
fn with_rows(lines: &mut Lines, header: HeaderLine, first: Option<String>) -> Result<Head> {
    let HeaderLine { line, separator, mut names, is_quoted } = header;
    let is_chosen = lines.source.keys.header.is_some();
    let mut notes = Vec::new();
    let mut first = match first {
        Some(first) => Some(first),
        None => next_row(lines)?,
    };
    let (mut n_skipped, mut has_units) = (0, false);
    while let Some(text) = &first {
        let units = cells_of(text, separator);
        let is_units = !has_units && units.len() <= names.len() && are_units(&units);
        if is_units {
            for (name, unit) in names.iter_mut().zip(&units).filter(|(_, unit)| !unit.is_empty()) {
                *name = format!("{name} [{}]", unit.trim_matches(['[', ']', '(', ')']));
            }
            has_units = true;
        } else if !is_chosen || n_numbers(text) > 2 || n_skipped == MAX_LINES_OF_TEXT {
            break;
        } else {
            n_skipped += 1;
        }
        first = next_row(lines)?;
    }
    if n_skipped > 0 {
        notes.push(format!("the lines of text below the header, line {line}, are skipped"));
    }
    let mut row_separator = separator;
    let mut is_text = false;
    if let Some(first) = first {
        let fits = |n_cells: usize| n_cells == names.len() || n_cells == names.len() + 1;
        if !fits(cells_of(&first, separator).len()) && is_number_first(&first) {
            row_separator = separator_of(&first);
        }
        let cells = cells_of(&first, row_separator);
        let has_last = cells.last().is_some_and(|cell| !cell.is_empty());
        let has_row_names = is_quoted && first.starts_with('"');
        if cells.len() == names.len() + 1 && has_last && has_row_names {
            // R writes row names, in quotes as all names, without a header.
            names.insert(0, String::new());
        } else if cells.len() + 1 == names.len() && names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        is_text = n_numbers(&first) == 0;
        lines.repeat();
    }
    let header_line = (is_text && !is_chosen).then_some(line);
    Ok(Head {
        n_rows: (usize::MAX, 0),
        names,
        what: "the header".into(),
        separator: row_separator,
        has_places: false,
        header_line,
        cell: None,
        notes,
    })
}

/// Returns the head of a table whose first line is a row: columns are named by their places, and in a file `.xyz`, the first three
/// are the coordinates.
fn without_header(lines: &mut Lines, first: &str, separator: Option<u8>) -> Result<Head> {
    let source = lines.source;
    let separator = separator.unwrap_or_else(|| separator_of(first));
    let n = cells_of(first, separator).len();
    let mut names: Vec<String> = (0..n).map(|place| place.to_string()).collect();
    let mut notes = Vec::new();
    let is_points = DataFormat::of_name(&source.path) == Some(DataFormat::Xyz) && n > 2;
    if !names_center(source.keys.columns.as_ref()) {
        if !is_points {
            let places = |z: &str, radius: Option<&str>| {
                let coordinates =
                    [("x", Some("0")), ("y", Some("1")), ("z", Some(z)), ("radius", radius)];
                let entry = |(part, place): (&'static str, Option<&str>)| {
                    Some((part, SettingValue::Number(place?.into())))
                };
                let entries = coordinates.into_iter().filter_map(entry).collect();
                Setting { key: "columns", value: Some(SettingValue::Table(entries)) }
            };
            let hint = match n {
                0..=2 => {
                    Hint::new("name columns by their place, from 0: {}", [places("0.0", None)])
                }
                3 => Hint::new("name columns by their place, from 0: {}", [places("2", None)]),
                _ => Hint::new(
                    "name columns by their place, from 0: {}; or {} if the fourth is the radius",
                    [places("2", None), places("2", Some("3"))],
                ),
            };
            let message = format!(
                "the table has no line with names of columns, and begins with {:?}",
                quoted(first.trim())
            );
            return Err(source.wrong(message, hint).at_line(lines.n_read).into());
        }
        for (name, axis) in names.iter_mut().zip(["x", "y", "z"]) {
            *name = axis.into();
        }
        let rest = if n > 3 { "; the others are not used" } else { "" };
        notes.push(format!(
            "no number of atoms in the first line: read as a table of x, y, z{rest}"
        ));
    }
    lines.repeat();
    Ok(Head {
        n_rows: (usize::MAX, 0),
        names,
        what: "the table".into(),
        separator,
        has_places: true,
        header_line: None,
        cell: None,
        notes,
    })
}

/// Whether the coordinates that the scene names are among these names.
fn has_chosen(columns: &ColumnKeys, names: &[String]) -> bool {
    let has =
        |name: &str| names.iter().any(|other| name_and_unit(other).0 == name_and_unit(name).0);
    let ColumnKeys { x, y, z, .. } = columns;
    [x, y, z].into_iter().flatten().all(|choice| match choice {
        ColumnChoice::Named(name) => has(name),
        _ => true,
    })
}

/// Whether the scene names a column for a coordinate.
fn names_center(columns: Option<&ColumnKeys>) -> bool {
    columns.is_some_and(|ColumnKeys { x, y, z, .. }| x.is_some() || y.is_some() || z.is_some())
}

/// Reads the next line that is neither empty nor a comment, with the white space around its cells: tabs separate cells.
fn next_row(lines: &mut Lines) -> Result<Option<String>> {
    while let Some(text) = lines.text()? {
        if !text.is_empty() && !is_comment(text.as_bytes()) {
            return Ok(Some(lines.whole_text()));
        }
    }
    Ok(None)
}

/// Reads Excel's line `sep=;`, which names the separator.
fn excel_separator(text: &str) -> Option<u8> {
    let text = text.trim_matches('"');
    let mark =
        text.get(..4).filter(|start| start.eq_ignore_ascii_case("sep=")).map(|_| &text[4..])?;
    match mark.as_bytes() {
        [] => Some(b'\t'),
        &[mark] => Some(mark),
        _ => None,
    }
}

/// Splits a line into cells, without quotes.
fn cells_of(text: &str, separator: u8) -> Vec<String> {
    if separator == b' ' {
        return text.split_whitespace().map(|word| word.trim_matches('"').to_owned()).collect();
    }
    let mut is_quoted = false;
    let cells = text.split(|c: char| {
        is_quoted ^= c == '"';
        c == char::from(separator) && !is_quoted
    });
    cells.map(|cell| cell.trim().trim_matches('"').trim().to_owned()).collect()
}

/// Appends words in brackets, which are units, to the names before them.
fn with_units(cells: Vec<String>, separator: u8) -> Vec<String> {
    if separator != b' ' {
        return cells;
    }
    let mut names: Vec<String> = Vec::new();
    for cell in cells {
        match names.last_mut() {
            Some(name) if is_bracketed(&cell) => *name = format!("{name} {cell}"),
            _ => names.push(cell),
        }
    }
    names
}

fn is_bracketed(cell: &str) -> bool {
    let is_between = |open, close| cell.starts_with(open) && cell.ends_with(close);
    is_between('[', ']') || is_between('(', ')')
}

/// Whether the cells of a line are units, or empty.
fn are_units(cells: &[String]) -> bool {
    let is_unit = |cell: &&String| is_bracketed(cell) || Unit::parse(cell).is_some();
    let mut filled = cells.iter().filter(|cell| !cell.is_empty()).peekable();
    filled.peek().is_some() && filled.all(|cell| is_unit(&cell))
}

/// Returns what separates the cells of a line.
fn separator_of(line: &str) -> u8 {
    let mut counts = [0; 4];
    let marks = [b'\t', b';', b',', b' '];
    let mut is_quoted = false;
    for byte in line.trim().bytes() {
        is_quoted ^= byte == b'"';
        if let Some(place) = marks.iter().position(|mark| *mark == byte && !is_quoted) {
            counts[place] += 1;
        }
    }
    let found = marks.into_iter().zip(counts).find(|(_, count)| *count > 0);
    found.map_or(b',', |(mark, _)| mark)
}

fn is_number_first(line: &str) -> bool {
    let word = line.split([',', ';', '\t', ' ', '"']).find(|word| !word.is_empty());
    word.is_some_and(is_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_are_seen() {
        for (line, separator) in [
            ("x,y,z", b','),
            ("x;y;z", b';'),
            ("1,5;2;3", b';'),
            ("x\ty\tz", b'\t'),
            ("x y z", b' '),
            ("\"x, y\" z", b' '),
            ("x", b','),
        ] {
            assert_eq!(separator_of(line), separator, "{line}");
        }
        assert_eq!(excel_separator("sep=;"), Some(b';'));
        assert_eq!(excel_separator("SEP=,"), Some(b','));
        assert_eq!(excel_separator("sep=;;"), None);
        assert_eq!(excel_separator("separate"), None);
    }

    #[test]
    fn units_belong_to_the_name_before_them() {
        let names = with_units(cells_of("x [m] y (m) z [m] r", b' '), b' ');
        assert_eq!(names, ["x [m]", "y (m)", "z [m]", "r"]);
        let units = |text: &str| are_units(&cells_of(text, b','));
        assert!(units("[m],[m],[m]") && units("m,m,,mm") && units(",(micron),(quality)"));
        assert!(!units("") && !units(",,") && !units("1,m") && !units("sand,m"));
    }
}
