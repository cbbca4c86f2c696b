//! Clouds as values between commas, semicolons, tabs or spaces.

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use csv::{ByteRecord, Error, ErrorKind, Position, Reader, ReaderBuilder};

use super::Reading;
use super::columns::{Header, Layout};
use super::text::TextRows;
use super::watched::Watched;
use crate::input::MAX_LINE_BYTES;
use crate::scene::places::Stop;

const HELP: &str = "the first line names the columns: x, y, z, and optionally r or radius, and red, \
                    green, blue (linear, 0 to 1, or 0 to 255), in any order and among others, with \
                    commas, semicolons, tabs or spaces between them; what has other names is told by \
                    `columns = { x = \"px\" }`";

/// Advice on a number.
const NUMBER: &str = "write numbers like 1.5 or 2e-3, with a point";

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 18;

/// Most bytes between two places where a row ends. The longest line, also one with line breaks between
/// quotes, and what is read at once, which may let a longer one pass.
const MAX_ROW_BYTES: u64 = MAX_LINE_BYTES + BUFFER_BYTES as u64;

/// A file whose beginning has been read already.
type Input<'c> = io::Chain<Cursor<Vec<u8>>, Watched<'c>>;

/// Reads the spheres of a `.csv` file, in the order of its lines.
pub(super) fn read(cloud: &mut Reading) -> Result<(), Stop> {
    cloud.refuse_frame()?;
    let (mut file, n_bytes) = cloud.open()?;
    // All lines but the header; where the last one has no line break, the header's counts.
    let n_at_most = n_bytes.map(|_| file.count_line_breaks(MAX_ROW_BYTES)).transpose();
    let n_at_most = n_at_most.map_err(|error| cloud.failed(&error))?;
    let (head, bytes) = Head::read(cloud, &mut file)?;
    let mut names = head.names(&bytes).map_err(|error| cloud.wrong(error, HELP))?;
    let separator = head.separator;
    let mut beginning = Cursor::new(bytes);
    beginning.set_position(head.rows as u64);
    let mut reader = ReaderBuilder::new()
        .buffer_capacity(BUFFER_BYTES)
        .has_headers(false)
        .delimiter(separator)
        // Rows that are too short or long get their message here, with the header's columns.
        .flexible(true)
        .from_reader(beginning.chain(file));
    let allow = |reader: &Reader<Input>| {
        reader.get_ref().get_ref().1.allow(MAX_ROW_BYTES);
    };
    if separator == b' ' {
        names = without_units(names);
    }
    let header = Header {
        names: &names,
        what: "the header",
        help: HELP,
        has_elements: false,
        has_places: false,
    };
    let layout = Layout::find(cloud, &header)?;
    let template = cloud.template(&layout)?;
    if let Some(n) = n_at_most {
        cloud.reserve(n, template.color)?;
    }
    let rows = TextRows::new(layout, template, separator != b',');

    let place = Place { path: cloud.source.path.clone(), head };
    let mut record = ByteRecord::new();
    let mut words = Vec::new();
    loop {
        allow(&reader);
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => return Err(stop(cloud, &error, &reader, &place)),
        }
        let line = || place.line_of(record.position());
        let n_cells = match separator {
            // Several spaces are one.
            b' ' => {
                words.clear();
                words.extend((0..record.len()).filter(|&i| !record[i].trim_ascii().is_empty()));
                words.len()
            }
            _ => record.len(),
        };
        if n_cells != names.len() {
            if n_cells == 0 {
                continue;
            }
            let n_names = names.len();
            return Err(cloud.wrong(
                format!("{}: {n_cells} values, but the header names {n_names} columns", line()),
                "each line has a value for each column, and a point, no comma, in its numbers",
            ));
        }
        let sphere = match separator {
            b' ' => rows.sphere(|column| record.get(*words.get(column)?)),
            _ => rows.sphere(|column| record.get(column)),
        };
        let sphere = sphere.map_err(|(found, help)| {
            cloud.wrong(format!("{}: {found}", line()), help.unwrap_or(NUMBER))
        })?;
        cloud.push(sphere, line)?;
    }
    if rows.has_commas.get() {
        cloud.note("commas in its numbers are read as decimal points");
    }
    Ok(())
}

/// The beginning of a file: where the names of the columns and the first row stand.
struct Head {
    /// The bytes of the line with the names.
    names: Range<usize>,
    /// Where the rows begin.
    rows: usize,
    /// Line breaks before them.
    n_lines: u64,
    separator: u8,
}

impl Head {
    /// Reads until the names are whole, and gives all that was read.
    fn read(cloud: &Reading, file: &mut Watched) -> Result<(Head, Vec<u8>), Stop> {
        let mut bytes = Vec::new();
        loop {
            let n_before = bytes.len();
            let read = file.by_ref().take(BUFFER_BYTES as u64).read_to_end(&mut bytes);
            read.map_err(|error| cloud.failed(&error))?;
            let is_all = bytes.len() == n_before;
            if let Some(head) = Head::find(&bytes, is_all) {
                return Ok((head, bytes));
            }
            if bytes.len() as u64 > MAX_LINE_BYTES {
                return Err(too_long(cloud, 1));
            }
        }
    }

    /// Finds the names in the first line that is not empty: one that begins with `#`, if only such
    /// lines stand before numbers, as NumPy writes it. `None` where more must be read.
    fn find(bytes: &[u8], is_all: bool) -> Option<Head> {
        const MARK: &[u8] = b"\xef\xbb\xbf";
        let mut at = if bytes.starts_with(MARK) { MARK.len() } else { 0 };
        let mut n_lines = 0;
        let mut comment = None;
        loop {
            let end = bytes[at..].iter().position(|&byte| byte == b'\n').map(|n| at + n);
            let (end, next) = match end {
                Some(end) => (end, end + 1),
                None if is_all => (bytes.len(), bytes.len()),
                None => return None,
            };
            let line = bytes[at..end].trim_ascii();
            if line.starts_with(b"#") {
                comment = Some(at..end);
            } else if !line.is_empty() || next == bytes.len() {
                let is_row = is_number_first(line);
                return Some(match comment {
                    // The comment's line has the names, and this is the first row.
                    Some(mut names) if is_row || line.is_empty() => {
                        let is_mark = |byte: &&u8| matches!(**byte, b'#' | b' ' | b'\t');
                        names.start += bytes[names.clone()].iter().take_while(is_mark).count();
                        let separator = separator_of(&bytes[names.clone()], line);
                        Head { names, rows: at, n_lines, separator }
                    }
                    _ => {
                        let separator = separator_of(line, b"");
                        Head { names: at..end, rows: next, n_lines: n_lines + 1, separator }
                    }
                });
            }
            n_lines += 1;
            at = next;
        }
    }

    fn names(&self, bytes: &[u8]) -> Result<Vec<String>, Error> {
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .delimiter(self.separator)
            .from_reader(&bytes[self.names.clone()]);
        let mut record = ByteRecord::new();
        reader.read_byte_record(&mut record)?;
        let names = record.iter().map(|name| String::from_utf8_lossy(name).trim().to_owned());
        let is_word = |name: &String| self.separator != b' ' || !name.is_empty();
        Ok(names.filter(is_word).collect())
    }
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

/// Names without words in brackets, which are units where spaces separate.
fn without_units(names: Vec<String>) -> Vec<String> {
    let is_unit = |name: &String| {
        (name.starts_with('[') && name.ends_with(']'))
            || (name.starts_with('(') && name.ends_with(')'))
    };
    names.into_iter().filter(|name| !is_unit(name)).collect()
}

fn too_long(cloud: &Reading, line: u64) -> Stop {
    let most = MAX_LINE_BYTES >> 20;
    cloud.wrong(format!("line {line}: the line is longer than {most} MiB"), HELP)
}

fn stop(cloud: &Reading, error: &Error, reader: &Reader<Input>, place: &Place) -> Stop {
    match error.kind() {
        ErrorKind::Io(_) if reader.get_ref().get_ref().1.is_used_up() => {
            too_long(cloud, place.head.n_lines + reader.position().line())
        }
        ErrorKind::Io(error) => cloud.failed(error),
        _ => cloud.wrong(error, HELP),
    }
}

/// Where rows stand in a file.
struct Place {
    path: PathBuf,
    head: Head,
}

impl Place {
    /// The line of a record. The library counts the line breaks that it has gone through, and lines
    /// that end in `\r\n` or are empty leave some to be skipped before the record.
    fn line_of(&self, position: Option<&Position>) -> String {
        let Some(position) = position else { return "a line".into() };
        let start = self.head.rows as u64 + position.byte();
        let skipped = |path: &Path| -> io::Result<u64> {
            let mut file = File::open(path)?;
            file.seek(SeekFrom::Start(start))?;
            let mut n_breaks = 0;
            for byte in BufReader::new(file).bytes() {
                match byte? {
                    b'\n' => n_breaks += 1,
                    b'\r' => {}
                    _ => break,
                }
            }
            Ok(n_breaks)
        };
        // What comes through a pipe can't be read again.
        let n_skipped = if self.path.is_file() { skipped(&self.path).unwrap_or(0) } else { 0 };
        format!("line {}", self.head.n_lines + position.line() + n_skipped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(text: &str) -> (Vec<String>, u8, String, u64) {
        let head = Head::find(text.as_bytes(), true).unwrap();
        let names = without_units(head.names(text.as_bytes()).unwrap());
        (names, head.separator, text[head.rows..].to_owned(), head.n_lines)
    }

    #[test]
    fn headers_are_found_as_people_write_them() {
        for (text, separator, names) in [
            ("x,y,z\n1,2,3", b',', "x|y|z"),
            ("x [m],y [m]\n", b',', "x [m]|y [m]"),
            ("x [m] y [m]\n", b' ', "x|y"),
            ("  x   y\n", b' ', "x|y"),
            ("x;y, raw;z\n", b';', "x|y, raw|z"),
            ("\"a,b\"\tc\n", b'\t', "a,b|c"),
            ("\u{feff}x;y", b';', "x|y"),
            ("# made by hand\n# x y\n1 2\n", b' ', "x|y"),
            ("#x,y\n1,2\n", b',', "x|y"),
            ("# a comment\nx,y\n1,2\n", b',', "x|y"),
            ("\n\n# x, y\n", b',', "x|y"),
            ("x\n1", b',', "x"),
            ("", b',', ""),
        ] {
            let (found, found_separator, ..) = head(text);
            assert_eq!((found.join("|").as_str(), found_separator), (names, separator), "{text:?}");
        }
        let (.., rows, n_lines) = head("\r\n# x y\r\n1 2\r\n");
        assert_eq!((rows.as_str(), n_lines), ("1 2\r\n", 2));
        let (.., rows, n_lines) = head("\n# a\nx\n1");
        assert_eq!((rows.as_str(), n_lines), ("1", 3));
        assert!(Head::find(b"x,y", false).is_none());
    }
}
