//! Clouds of atoms in the chemists' XYZ format, plain and extended.

use std::ops::Range;

use super::Reading;
use super::columns::{Header, Layout};
use super::lines::Lines;
use super::text::TextRows;
use crate::scene::places::{Stop, quoted};

const HELP: &str = "the first line of an .xyz file is the number of atoms, the second a comment, \
                    and each further line an atom: its element, x, y and z in ångström; in the \
                    second, Properties= may say other columns";

/// Columns of a file that doesn't say them.
const PLAIN: [&str; 4] = ["element", "x", "y", "z"];

/// Bytes of the shortest number and the space or line break behind it.
const MIN_CELL_BYTES: u64 = 2;

/// Reads the atoms of one frame of an `.xyz` file, in the order of its lines. In a file that doesn't
/// say its columns, what stands behind an atom's coordinates is not looked at.
pub(super) fn read(cloud: &mut Reading) -> Result<(), Stop> {
    let (file, n_bytes) = cloud.open()?;
    let mut lines = Lines::new(file, HELP);

    for frame in 0..cloud.frame() {
        let Some(n_atoms) = count(&mut lines, cloud)? else {
            return Err(cloud.no_such_frame(frame));
        };
        let first_line = lines.n_read;
        // The comment, too.
        for n_read in 0..=n_atoms {
            if lines.next(cloud)?.is_none() {
                return Err(cut_off(cloud, first_line, n_atoms, n_read.saturating_sub(1)));
            }
        }
    }
    let n_atoms = match count(&mut lines, cloud)? {
        Some(n_atoms) => n_atoms,
        None if cloud.frame() > 0 => return Err(cloud.no_such_frame(cloud.frame())),
        None => return Err(no_count(cloud, &lines, "")),
    };
    let first_line = lines.n_read;

    let comment = lines.next(cloud)?.unwrap_or_default().to_owned();
    let has_box = value_of(&comment, "lattice").is_some();
    let (names, is_plain) = match value_of(&comment, "properties") {
        Some(properties) => match names_of(properties) {
            Some(names) => (names, false),
            None => {
                let properties = quoted(properties).into_owned();
                let message = format!("line {}: Properties={properties:?}", lines.n_read);
                let help = "Properties= lists a name, a type and a number of columns for each, e.g. \
                            Properties=species:S:1:pos:R:3:radius:R:1";
                return Err(cloud.wrong(message, help));
            }
        },
        None => (PLAIN.map(String::from).to_vec(), true),
    };
    let what = format!("Properties= in line {}", lines.n_read);
    let header = Header {
        names: &names,
        what: if is_plain { "a plain .xyz file" } else { &what },
        help: HELP,
        has_elements: true,
        has_places: false,
    };
    let layout = Layout::find(cloud, &header)?;
    let template = cloud.template(&layout)?;
    // A wrong number must not ask for more than a file of this length can have.
    let n_at_most = n_bytes.map_or(0, |n| n / (names.len() as u64 * MIN_CELL_BYTES - 1));
    let n_at_most = usize::try_from(n_at_most).unwrap_or(usize::MAX);
    cloud.reserve(n_atoms.min(n_at_most), template.color)?;
    let rows = TextRows::new(layout, template, true);

    let mut cells = Vec::new();
    for n_read in 0..n_atoms {
        // Counted from 1.
        let number = lines.n_read + 1;
        let place = || format!("line {number}");
        let Some(line) = lines.next(cloud)? else {
            return Err(cut_off(cloud, first_line, n_atoms, n_read));
        };
        cells_of(line, names.len(), &mut cells);
        if cells.len() < names.len() {
            let found = match cells.len() {
                0 => "the line is empty".into(),
                _ if is_plain => "there are not three coordinates".into(),
                n => format!("{n} values, but {what} names {} columns", names.len()),
            };
            return Err(cloud.wrong(format!("{}: {found}", place()), HELP));
        }
        let cell = |column: usize| line.as_bytes().get(cells.get(column)?.clone());
        let sphere = rows.sphere(cell).map_err(|(found, help)| {
            cloud.wrong(format!("{}: {found}", place()), help.unwrap_or(HELP))
        })?;
        cloud.push(sphere, place)?;
    }
    if cloud.source.table.frame.is_none() {
        while let Some(line) = lines.next(cloud)? {
            if !line.trim().is_empty() {
                return Err(cloud.wrong(
                    format!("the file goes on behind the {n_atoms} atoms that line {first_line} tells of"),
                    "correct that line; of several steps of a simulation, choose one by `frame = 0` \
                     (the first), or save one",
                ));
            }
        }
    }
    if has_box {
        cloud.note("its box (Lattice) is left out");
    }
    Ok(())
}

/// The number of atoms that a frame begins with; `None` at the end of the file.
fn count(lines: &mut Lines, cloud: &Reading) -> Result<Option<usize>, Stop> {
    loop {
        let Some(line) = lines.next(cloud)? else { return Ok(None) };
        let count = line.trim().to_owned();
        match count.parse() {
            Ok(n_atoms) => return Ok(Some(n_atoms)),
            // Empty lines between frames and at the end.
            Err(_) if count.is_empty() && lines.n_read > 1 => {}
            Err(_) => return Err(no_count(cloud, lines, &count)),
        }
    }
}

fn no_count(cloud: &Reading, lines: &Lines, found: &str) -> Stop {
    let place = lines.n_read;
    cloud.wrong(format!("line {place}: {:?} is not a number of atoms", quoted(found)), HELP)
}

fn cut_off(cloud: &Reading, first_line: u64, n_atoms: usize, n_read: usize) -> Stop {
    cloud.wrong(
        format!("line {first_line} tells of {n_atoms} atoms, but the file ends after {n_read}"),
        "is the file cut off? if not, correct that line",
    )
}

/// The value of a key in a comment, `key=value` or `key="a value"`; the key in lower case.
fn value_of<'c>(comment: &'c str, key: &str) -> Option<&'c str> {
    let lower = comment.to_ascii_lowercase();
    let is_word_end = |text: &str| text.is_empty() || text.ends_with(char::is_whitespace);
    let (at, _) = lower.match_indices(key).find(|(at, _)| {
        is_word_end(&lower[..*at]) && lower[at + key.len()..].trim_start().starts_with('=')
    })?;
    let value = comment[at + key.len()..].trim_start().strip_prefix('=')?.trim_start();
    match value.chars().next()? {
        quote @ ('"' | '\'') => value[1..].split(quote).next(),
        _ => value.split_whitespace().next(),
    }
}

/// Most columns of an atom.
const MOST_COLUMNS: usize = 4096;

/// The names of the columns that `Properties=` lists: for each a name, a type and a number of columns.
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

/// Where the first `n` words of a line are.
pub(super) fn cells_of(line: &str, n: usize, cells: &mut Vec<Range<usize>>) {
    cells.clear();
    cells.extend(line.split_ascii_whitespace().take(n).map(|word| {
        let start = word.as_ptr().addr() - line.as_ptr().addr();
        start..start + word.len()
    }));
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

    #[test]
    fn words_are_where_they_are() {
        let mut cells = Vec::new();
        for line in ["", "  ", "a", " a\tbc \r\n", "é b"] {
            cells_of(line, 9, &mut cells);
            let words: Vec<&str> = cells.iter().map(|cell| &line[cell.clone()]).collect();
            assert_eq!(words, line.split_ascii_whitespace().collect::<Vec<_>>());
        }
        cells_of("a b c", 2, &mut cells);
        assert_eq!(cells, [0..1, 2..3]);
    }
}
