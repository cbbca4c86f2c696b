//! Clouds in text: a head that names columns, then rows of cells, each of them a sphere.

use std::io::{BufRead, BufReader, Read};
use std::ops::Range;

use super::columns::{Header, Layout, RED, put};
use super::elements::element;
use super::{CloudFile, Problem, Reading, Watched};
use crate::error::{Error, Result};
use crate::input::MAX_LINE_BYTES;
use crate::scene::places::quoted;
use crate::scene::{Color, Sphere};

/// A kind of text file.
pub(super) struct TextFormat {
    /// How such a file is written.
    pub help: &'static str,
    /// How a row of it is written.
    pub row_help: &'static str,
    /// What is wrong with a file that nothing begins in.
    pub empty: &'static str,
    /// True for frames of atoms, each with a number of rows, whose element tells what lacks; false for
    /// one table of any length, in which cells may stand in quotes.
    pub has_frames: bool,
    /// Reads what stands before the rows of the next frame; `None` at the end of the file.
    pub head: fn(&mut Lines) -> Result<Option<Head>>,
}

/// What stands before the rows of a frame.
pub(super) struct Head {
    /// How many rows there are at most, of frames exactly, and the line that says so.
    pub n_rows: (usize, u64),
    /// Names of the columns.
    pub names: Vec<String>,
    /// What has these names: `the header`, for one.
    pub what: String,
    /// What stands between cells; a space means white space of any length.
    pub separator: u8,
    /// Columns of numbers that go from 0 to 1 from one end of a box to the other, and these ends.
    pub scaled: Vec<(usize, [f64; 2])>,
    /// What its reader may want to know.
    pub note: Option<&'static str>,
}

/// Reads the spheres of one frame, in the order of its lines.
pub(super) fn read(cloud: &mut Reading, format: &TextFormat) -> Result<Layout> {
    let &TextFormat { help, row_help, has_frames, .. } = format;
    let source = cloud.source;
    if !has_frames {
        source.refuse_frame()?;
    }
    let mut lines = Lines::new(source, help)?;

    let mut n_before = 0;
    let head = loop {
        let Some(head) = (format.head)(&mut lines)? else {
            return Err(match source.frame() {
                0 => source.wrong(format.empty, help),
                _ => source.no_such_frame(n_before),
            });
        };
        if n_before == source.frame() {
            break head;
        }
        for n_read in 0..head.n_rows.0 {
            if lines.next()?.is_none() {
                return Err(head.cut_off(source, n_read));
            }
        }
        n_before += 1;
    };

    let names = &head.names;
    let header =
        Header { names, what: &head.what, help, has_elements: has_frames, has_places: false };
    let layout = Layout::find(source, &header)?;
    let sphere = cloud.template(&layout)?;
    let mut rows = Rows { layout, sphere, head: &head, has_commas: false, help: row_help };

    for n_read in 0..head.n_rows.0 {
        let Some(number) = lines.row(head.separator, !has_frames)? else {
            if has_frames {
                return Err(head.cut_off(source, n_read));
            }
            break;
        };
        let place = || format!("line {number}");
        let n_cells = lines.cells.len();
        let is_empty = lines.line.trim_ascii().is_empty();
        if is_empty && !has_frames && n_cells <= 1 {
            continue;
        }
        if n_cells < names.len() || (!has_frames && n_cells > names.len()) {
            let found = if is_empty {
                "the line is empty".into()
            } else {
                format!("{n_cells} values, but {} has {} columns", head.what, names.len())
            };
            return Err(source.wrong_row(place(), (found, row_help)));
        }
        cloud.push(
            rows.sphere(&lines).map_err(|problem| source.wrong_row(place(), problem))?,
            place,
        )?;
    }
    if rows.has_commas {
        cloud.note("commas in its numbers are read as decimal points");
    }
    if let Some(note) = head.note {
        cloud.note(note);
    }
    if has_frames && source.keys.frame.is_none() {
        let (n_rows, line) = head.n_rows;
        while let Some(rest) = lines.next()? {
            if !rest.trim_ascii().is_empty() {
                return Err(source.wrong(
                    format!(
                        "the file goes on behind the {n_rows} atoms that line {line} tells of"
                    ),
                    "correct that line; of several steps of a simulation, choose one by `frame = 0` \
                     (the first), or save one",
                ));
            }
        }
    }
    Ok(rows.layout)
}

impl Head {
    fn cut_off(&self, source: &CloudFile, n_read: usize) -> Error {
        let (n_rows, line) = self.n_rows;
        source.wrong(
            format!("line {line} tells of {n_rows} atoms, but the file ends after {n_read}"),
            "is the file cut off? if not, correct that line",
        )
    }
}

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 18;

/// The lines of a file, one at a time.
pub(super) struct Lines<'c> {
    pub source: &'c CloudFile<'c>,
    reader: BufReader<Watched<'c>>,
    line: Vec<u8>,
    /// True where `line` is still to be read.
    is_next: bool,
    /// Lines read so far, the present one included: its number, counted from 1.
    pub n_read: u64,
    /// Where the cells of the present row are.
    cells: Vec<Range<usize>>,
    help: &'static str,
}

impl<'c> Lines<'c> {
    fn new(source: &'c CloudFile<'c>, help: &'static str) -> Result<Lines<'c>> {
        let reader = BufReader::with_capacity(BUFFER_BYTES, source.open()?.0);
        let (line, cells, is_next) = Default::default();
        Ok(Lines { source, reader, line, is_next, n_read: 0, cells, help })
    }

    /// The next line, or `None` at the end.
    pub fn next(&mut self) -> Result<Option<&[u8]>> {
        if !std::mem::take(&mut self.is_next) {
            self.line.clear();
            if !self.read_on()? {
                return Ok(None);
            }
        }
        Ok(Some(&self.line))
    }

    /// The next line as text, without white space around it.
    pub fn text(&mut self) -> Result<Option<String>> {
        Ok(self.next()?.map(|line| String::from_utf8_lossy(line).trim().to_owned()))
    }

    /// Makes this the next line, in place of the present one.
    pub fn put_back(&mut self, line: Vec<u8>) {
        (self.line, self.is_next) = (line, true);
    }

    /// Adds a line to the present one; false at the end of the file.
    fn read_on(&mut self) -> Result<bool> {
        let n_before = self.line.len();
        let n_left = MAX_LINE_BYTES - n_before as u64;
        let read = (&mut self.reader).take(n_left).read_until(b'\n', &mut self.line);
        read.map_err(|error| self.source.failed(&error))?;
        self.n_read += 1;
        if self.line.len() as u64 == MAX_LINE_BYTES {
            let (line, most) = (self.n_read, MAX_LINE_BYTES >> 20);
            let found = format!("line {line}: the line is longer than {most} MiB");
            return Err(self.source.wrong(found, self.help));
        }
        Ok(self.line.len() > n_before)
    }

    /// Reads a row, and gives the number of its first line; `None` at the end. A cell that begins with a
    /// quote ends with one, lines later maybe, where there may be quotes.
    pub fn row(&mut self, separator: u8, has_quotes: bool) -> Result<Option<u64>> {
        if self.next()?.is_none() {
            return Ok(None);
        }
        let number = self.n_read;
        let has_words = separator == b' ';
        let separates = |byte: u8| byte == separator || (has_words && byte.is_ascii_whitespace());
        self.cells.clear();
        let (mut at, mut start, mut is_quoted) = (0, 0, false);
        loop {
            while let Some(&byte) = self.line.get(at) {
                // Two of them in a row are one within the quotes.
                let may_be_quote = is_quoted || at == start || self.line[at - 1] == b'"';
                if has_quotes && byte == b'"' && may_be_quote {
                    is_quoted = !is_quoted;
                } else if !is_quoted && separates(byte) {
                    if !has_words || start < at {
                        self.cells.push(start..at);
                    }
                    start = at + 1;
                }
                at += 1;
            }
            if !is_quoted {
                break;
            }
            if !self.read_on()? {
                let found = format!("line {number}: a quote is opened, and not closed behind it");
                return Err(self.source.wrong(found, "close it, or leave it out"));
            }
        }
        if !has_words || start < at {
            self.cells.push(start..at);
        }
        Ok(Some(number))
    }

    /// The cells of the present row as text; two quotes within quotes are one.
    pub fn cells(&self) -> Vec<String> {
        let text = |place: &Range<usize>| {
            let cell = self.line[place.clone()].trim_ascii();
            let text = String::from_utf8_lossy(unquoted(cell));
            let is_quoted = cell.starts_with(b"\"");
            let text = if is_quoted { text.replace("\"\"", "\"") } else { text.into_owned() };
            text.trim().to_owned()
        };
        self.cells.iter().map(text).collect()
    }

    /// A cell of the present row, without quotes and white space around it; nothing where it lacks.
    fn cell(&self, column: usize) -> &[u8] {
        let place = self.cells.get(column);
        place.map_or(&[], |place| unquoted(self.line[place.clone()].trim_ascii()))
    }

    /// The number of atoms that the present line tells, as `text`.
    pub fn n_atoms(&self, text: &str) -> Result<(usize, u64)> {
        let n_atoms = text.parse().map_err(|_| self.wrong(text, "is not a number of atoms"))?;
        Ok((n_atoms, self.n_read))
    }

    /// Something in the present line, which is `text`, is wrong.
    pub fn wrong(&self, text: &str, found: &str) -> Error {
        let found = format!("line {}: {:?} {found}", self.n_read, quoted(text));
        self.source.wrong(found, self.help)
    }
}

/// A cell without the quotes around it.
fn unquoted(cell: &[u8]) -> &[u8] {
    let quoted = cell.strip_prefix(b"\"").and_then(|cell| cell.strip_suffix(b"\""));
    quoted.unwrap_or(cell)
}

/// Words for a number that is missing, in lower case, besides `nan`.
const MISSING: [&str; 6] = ["", "na", "n/a", "null", "none", "-"];

/// Makes spheres of rows of cells.
struct Rows<'h> {
    layout: Layout,
    /// What each is but for what its row says.
    sphere: Sphere,
    head: &'h Head,
    /// True once a comma stood in a number.
    has_commas: bool,
    /// How a row is written.
    help: &'static str,
}

impl Rows<'_> {
    /// The sphere of a row, and its colour as the file has it: numbers of whatever scale, or what
    /// it is coloured by.
    fn sphere(&mut self, lines: &Lines) -> Result<(Sphere, Color), Problem> {
        let (mut sphere, mut color) = (self.sphere, Color::default());
        for &(column, part) in &self.layout.parts {
            let cell = lines.cell(column);
            let is_nan = || part >= RED && !self.layout.has_colors && is_missing(cell);
            let number = number(cell, self.head.separator != b',', &mut self.has_commas);
            let number = number.or_else(|| is_nan().then_some(f64::NAN));
            let mut number = number.ok_or_else(|| {
                let found = format!("{:?} is not a number", quoted(&String::from_utf8_lossy(cell)));
                (found, self.help)
            })?;
            if let Some((_, [low, high])) = self.head.scaled.iter().find(|(of, _)| *of == column) {
                number = low + number * (high - low);
            }
            put(part, number, &mut sphere, &mut color);
        }
        if let Some((column, [gives_radius, gives_color])) = self.layout.element {
            let symbol = String::from_utf8_lossy(lines.cell(column));
            let element = element(&symbol).ok_or_else(|| {
                let what = if gives_radius { "radius" } else { "colour" };
                let found = format!("no {what} is known of an element {:?}", quoted(&symbol));
                (found, UNKNOWN_ELEMENT)
            })?;
            if gives_radius {
                sphere.radius = element.radius;
            }
            if gives_color {
                color = element.color;
            }
        }
        Ok((sphere, color))
    }
}

/// Reads a number. Where no comma stands between cells, one may stand in it for its point.
fn number(cell: &[u8], may_have_comma: bool, has_commas: &mut bool) -> Option<f64> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    text.parse().ok().or_else(|| {
        let is_decimal = may_have_comma && !text.contains('.');
        let number = is_decimal.then(|| text.replacen(',', ".", 1).parse().ok()).flatten();
        *has_commas |= number.is_some();
        number
    })
}

fn is_missing(cell: &[u8]) -> bool {
    MISSING.contains(&&String::from_utf8_lossy(cell).trim().to_lowercase()[..])
}

const UNKNOWN_ELEMENT: &str = "an atom begins with its symbol in the periodic table, e.g. C, N or Fe; \
     spheres of other kinds have columns for their radius and colour (a .csv or .npy file, or \
     Properties= in .xyz), or `radius`, `color` and `columns = { element = false }` in the scene";
