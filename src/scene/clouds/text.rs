//! Data in text: a head that names the columns, then rows of cells, each of them a sphere.

use std::borrow::Cow;
use std::io::{BufRead, BufReader, Read};
use std::ops::Range;

use glam::DVec3;

use super::columns::{ColumnLayout, Header, Part, put};
use super::elements::{self, element};
use super::numbers::Numbers;
use super::{CloudFile, Reading, RowError, RowPlace};
use crate::error::{Error, Hint, Message, Result, SceneError, Setting};
use crate::input::MAX_LINE_BYTES;
use crate::scene::decode::Input;
use crate::scene::places::quoted;
use crate::scene::schema::Section;
use crate::scene::{Color, Sphere};
use crate::words::count;

/// A format of text files.
pub(super) struct TextFormat {
    /// How such a file is written.
    pub help: &'static str,
    /// How a row of it is written.
    pub row_help: &'static str,
    /// The problem of a file without content.
    pub empty: &'static str,
    /// Whether the file is a table: one frame of any number of rows, in which cells may be quoted, and lines may be empty or
    /// comments. Otherwise, it has frames of a known number of atoms.
    pub is_table: bool,
    /// Reads the lines before the rows of the next frame; `None` at the end of the file.
    pub head: fn(&mut Lines) -> Result<Option<Head>>,
}

/// The lines before the rows of a frame.
pub(super) struct Head {
    /// Number of rows, at most for tables, exactly for frames, and the line that has it.
    pub n_rows: (usize, u64),
    /// Names of the columns.
    pub names: Vec<String>,
    /// What has these names: `the header`, for one.
    pub what: String,
    /// Separator of cells; a space means white space of any length.
    pub separator: u8,
    /// Whether columns are numbered from 0 because they have no names.
    pub has_places: bool,
    /// The line of the header, if lines of text follow it.
    pub header_line: Option<u64>,
    /// The box, for coordinates that are given relative to it.
    pub cell: Option<Cell>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// The box of a simulation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Corner of the box.
    pub origin: DVec3,
    /// Edges of the box.
    pub edges: [DVec3; 3],
    /// Places of the columns that are relative to the box, from 0 to 1.
    pub columns: [Option<usize>; 3],
}

impl Cell {
    /// Converts the coordinates marked in `is_scaled`, which are relative to the box. Unless all are, the box must be a
    /// restricted one: the first edge along x, the second one in the x-y plane.
    pub fn unscale(&self, position: DVec3, is_scaled: [bool; 3]) -> DVec3 {
        let [a, b, c] = self.edges;
        // Relative coordinates from z on: for a restricted box, each depends only on those after it.
        let offset = position - self.origin;
        let scaled_z = if is_scaled[2] { position.z } else { offset.z / c.z };
        // Without tilt, a box may have no height.
        let tilt = if c.y == 0.0 { 0.0 } else { scaled_z * c.y };
        let scaled_y = if is_scaled[1] { position.y } else { (offset.y - tilt) / b.y };
        let scaled_x = position.x;
        let sum = |axis: usize| {
            // Edges that are axes are added alone, so that a box without tilt rounds as one without angles.
            let along = [scaled_x * a[axis], scaled_y * b[axis], scaled_z * c[axis]];
            let terms = [a, b, c].map(|edge| edge[axis] != 0.0);
            let parts = along.into_iter().zip(terms).filter(|(_, is_there)| *is_there);
            self.origin[axis] + parts.map(|(part, _)| part).sum::<f64>()
        };
        DVec3::from_array(std::array::from_fn(|axis| {
            if is_scaled[axis] { sum(axis) } else { position[axis] }
        }))
    }
}

/// Reads the spheres of one frame, in the order of its lines.
pub(super) fn read<'r>(
    cloud: &mut Reading<'_, 'r>,
    input: Input<'r>,
    format: &TextFormat,
) -> Result<ColumnLayout> {
    let source = cloud.source;
    if format.is_table {
        source.refuse_frame()?;
    } else {
        source.refuse_header()?;
    }
    let mut lines = Lines::new(source, input, format);
    let frame = match u32::try_from(source.frame()) {
        Ok(frame) => frame,
        Err(_) => {
            let frame = frame_from_start(&mut lines, format)?;
            lines = Lines::new(source, source.open()?, format);
            frame
        }
    };
    let mut n_before = 0;
    let head = loop {
        let Some(head) = (format.head)(&mut lines)? else {
            return Err(match frame {
                0 => source.wrong(format.empty, format.help).into(),
                _ => source.no_such_frame(n_before),
            });
        };
        if n_before == frame {
            break head;
        }
        head.skip_rows(&mut lines)?;
        n_before += 1;
    };
    head.notes.iter().for_each(|note| cloud.note(note.as_str()));

    let names = &head.names;
    let header = Header {
        names,
        what: &head.what,
        help: format.help,
        has_elements: !format.is_table,
        has_places: head.has_places,
    };
    let mut notes = Vec::new();
    let mut layout = ColumnLayout::find(source, &header, &mut notes)?;
    notes.into_iter().for_each(|note| cloud.note(note));
    if let Some(column) = layout.element
        && let Some(label) = lines.peek_cell(&head, column)?
        && !elements::is_label_of_elements(&label)
    {
        layout.element = None;
        cloud.note(format!(
            "\"{}\" and the other labels are read as types, not as elements",
            quoted(&label)
        ));
    }
    let sphere = cloud.template(&layout)?;
    let mut rows = Rows::new(layout, sphere, &head, format.row_help, cloud);

    // Two empty lines separate blocks, as gnuplot has them.
    let (mut n_empty, mut has_blocks) = (0, false);
    for n_read in 0..head.n_rows.0 {
        let Some(line) = lines.row(head.separator, format.is_table)? else {
            if !format.is_table {
                return Err(head.cut_off(source, n_read));
            }
            break;
        };
        if format.is_table && lines.is_empty_or_comment() {
            n_empty = if lines.is_empty() { n_empty + 1 } else { n_empty };
            continue;
        }
        has_blocks |= n_empty > 1 && !cloud.spheres.is_empty();
        n_empty = 0;
        let fault = |fault: RowError| Error::from(source.wrong_row(RowPlace::Line(line), fault));
        rows.check_length(&lines, format.is_table).map_err(fault)?;
        let read = rows.sphere(&lines, line).map_err(|problem| {
            let is_text_below_header = cloud.spheres.is_empty() && head.header_line.is_some();
            let hint = head.header_line.filter(|_| is_text_below_header).map(|line| {
                let setting = Setting::number("header", line as f64);
                let text = format!(
                    "line {line} looks like the header, with more text below it; skip that with "
                );
                Hint::new("{}", [setting]).after(text)
            });
            fault(RowError { hint: hint.unwrap_or(problem.hint), ..problem })
        })?;
        cloud.push(read, RowPlace::Line(line))?;
    }
    rows.notes().into_iter().for_each(|note| cloud.note(note));
    if has_blocks {
        cloud.note("empty lines separate blocks of rows, which are drawn together");
    }
    if !format.is_table && source.keys.frame.is_none() {
        let (n_more, end) = count_frames(&mut lines, format)?;
        let n_frames = 1 + n_more;
        match end {
            End::Whole => {}
            End::Cut => cloud.note("the last frame is cut off, and not counted"),
            End::Invalid(mut error) => {
                if n_more == 0 {
                    let (n_rows, line) = head.n_rows;
                    error.message = format!(
                        "expected the end of the file or another frame after the {n_rows} atoms that line {line} gives"
                    );
                    error.hint = "correct the number of atoms in that line".into();
                }
                return Err(error.into());
            }
        }
        if n_frames > 1 && head.n_rows.0 == 0 {
            let message = format!("frame 0 of {n_frames} has no atoms");
            let hint = Hint::new(
                "choose another frame, for example the last one: {}",
                [Setting::number("frame", -1.0)],
            );
            return Err(source.wrong(message, hint).into());
        }
        if n_frames > 1 {
            let text = format!("frame 0 of {}", count(n_frames as usize, "frame"));
            let setting = Setting::number("frame", -1.0);
            let hint = Hint::new("choose another one, for example the last one with {}", [setting]);
            cloud.note(Message::new(text, hint));
        }
    }
    Ok(rows.layout)
}

/// Counts all frames, and returns the one that the scene counts from the last whole one.
fn frame_from_start(lines: &mut Lines, format: &TextFormat) -> Result<u32> {
    let source = lines.source;
    if !lines.is_regular {
        let hint = Hint::new(
            "count from the first frame, for example {}",
            [Setting::number("frame", 0.0)],
        );
        let message = "frames can be counted from the last one only in a regular file";
        return Err(source.wrong_at(source.keys.span("frame"), message, hint).into());
    }
    let (n_frames, end) = count_frames(lines, format)?;
    if let End::Invalid(error) = end {
        return Err(error.into());
    }
    let from_start = i64::from(n_frames) + i64::from(source.frame());
    u32::try_from(from_start).map_err(|_| source.no_such_frame(n_frames))
}

/// The end of the frames of a file.
enum End {
    /// Every frame is whole.
    Whole,
    /// The last frame is cut off: a simulation may still be writing it.
    Cut,
    /// Something else follows the last whole frame.
    Invalid(Box<SceneError>),
}

/// Counts the whole frames that follow.
fn count_frames(lines: &mut Lines, format: &TextFormat) -> Result<(u32, End)> {
    let mut n_frames = 0;
    loop {
        let head = (format.head)(lines);
        let next = head.and_then(|head| head.map(|head| head.skip_rows(lines)).transpose());
        match next {
            Ok(None) => return Ok((n_frames, End::Whole)),
            Ok(Some(())) => n_frames += 1,
            Err(Error::Scene(error)) => {
                let end = if lines.has_ended { End::Cut } else { End::Invalid(error) };
                return Ok((n_frames, end));
            }
            Err(error) => return Err(error),
        }
    }
}

impl Head {
    fn skip_rows(&self, lines: &mut Lines) -> Result<()> {
        for n_read in 0..self.n_rows.0 {
            if lines.next()?.is_none() {
                return Err(self.cut_off(lines.source, n_read));
            }
        }
        Ok(())
    }

    fn cut_off(&self, source: &CloudFile, n_read: usize) -> Error {
        let (n_rows, line) = self.n_rows;
        let message = format!(
            "expected {n_rows} atoms, as line {line} gives, found {n_read} before the end of the file"
        );
        source
            .wrong(message, "the file may be truncated; copy it again, or correct that line")
            .into()
    }
}

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 18;

/// The lines of a file, one at a time.
pub(super) struct Lines<'a, 'r> {
    pub source: &'a CloudFile<'a, 'r>,
    reader: BufReader<Input<'r>>,
    /// Whether the file can be opened again.
    is_regular: bool,
    line: Vec<u8>,
    /// Whether `line` is still to be read.
    is_next: bool,
    /// Whether the end of the file was reached.
    has_ended: bool,
    /// Number of the current line, from 1.
    pub n_read: u64,
    /// Places of the cells of the current row.
    cells: Vec<Range<usize>>,
    help: &'static str,
}

impl<'a, 'r> Lines<'a, 'r> {
    fn new(source: &'a CloudFile<'a, 'r>, input: Input<'r>, format: &TextFormat) -> Lines<'a, 'r> {
        let is_regular = input.is_regular();
        let reader = BufReader::with_capacity(BUFFER_BYTES, input);
        Lines {
            source,
            reader,
            is_regular,
            line: Vec::new(),
            is_next: false,
            has_ended: false,
            n_read: 0,
            cells: Vec::new(),
            help: format.help,
        }
    }

    /// Reads the next line; `None` at the end.
    pub fn next(&mut self) -> Result<Option<&[u8]>> {
        if !std::mem::take(&mut self.is_next) {
            self.line.clear();
            if !self.read_on()? {
                return Ok(None);
            }
        }
        Ok(Some(&self.line))
    }

    /// Reads the next line as text, without white space around it.
    pub fn text(&mut self) -> Result<Option<String>> {
        Ok(self.next()?.map(|line| text_of(line).trim().to_owned()))
    }

    /// Returns the current line as text, without its line end.
    pub fn whole_text(&self) -> String {
        text_of(&self.line).trim_end_matches(['\n', '\r']).to_owned()
    }

    /// Makes this the next line, instead of the current one.
    pub fn put_back(&mut self, line: Vec<u8>) {
        (self.line, self.is_next) = (line, true);
    }

    /// Makes the current line the next one again, with the white space around it.
    pub fn repeat(&mut self) {
        self.is_next = true;
    }

    /// Returns a cell of the next row, which stays the next one; `None` if there is no such cell.
    fn peek_cell(&mut self, head: &Head, column: usize) -> Result<Option<String>> {
        if head.n_rows.0 == 0 || self.row(head.separator, false)?.is_none() {
            return Ok(None);
        }
        let label = self.cells.get(column).map(|_| text_of(self.cell(column)).into_owned());
        self.is_next = true;
        Ok(label)
    }

    /// Appends a line to the current one; `false` at the end of the file.
    fn read_on(&mut self) -> Result<bool> {
        let n_before = self.line.len();
        let n_left = MAX_LINE_BYTES - n_before as u64;
        let read = (&mut self.reader).take(n_left).read_until(b'\n', &mut self.line);
        read.map_err(|error| self.source.failed(&error))?;
        self.n_read += 1;
        if self.line.len() as u64 == MAX_LINE_BYTES {
            let message = format!("the line is longer than {} MiB", MAX_LINE_BYTES >> 20);
            return Err(self.source.wrong(message, self.help).at_line(self.n_read).into());
        }
        self.has_ended |= self.line.len() == n_before;
        Ok(self.line.len() > n_before)
    }

    /// Reads a row, and returns the number of its first line; `None` at the end. If cells may be quoted, one that begins with
    /// a quote ends with one, possibly lines later.
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
                // Two quotes in a row are one within a cell.
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
                let error = self
                    .source
                    .wrong("a quote is opened, but not closed", "close it, or remove it");
                return Err(error.at_line(number).into());
            }
        }
        if !has_words || start < at {
            self.cells.push(start..at);
        }
        Ok(Some(number))
    }

    /// Whether the current line is empty.
    pub fn is_empty(&self) -> bool {
        self.line.trim_ascii().is_empty()
    }

    /// Whether the current line is empty or a comment.
    pub fn is_empty_or_comment(&self) -> bool {
        let line = self.line.trim_ascii();
        line.is_empty() && self.cells.len() <= 1 || is_comment(line)
    }

    /// Returns the number of cells of the current row.
    pub fn n_cells(&self) -> usize {
        self.cells.len()
    }

    /// Returns the cells of the current row as text; two quotes within quotes are one.
    pub fn cells(&self) -> Vec<String> {
        let text = |place: &Range<usize>| {
            let cell = self.line[place.clone()].trim_ascii();
            let text = text_of(unquoted(cell));
            let is_quoted = cell.starts_with(b"\"");
            let text = if is_quoted { text.replace("\"\"", "\"") } else { text.into_owned() };
            text.trim().to_owned()
        };
        self.cells.iter().map(text).collect()
    }

    /// Returns a cell of the current row, without quotes and white space around it; empty if there is none.
    fn cell(&self, column: usize) -> &[u8] {
        let place = self.cells.get(column);
        place.map_or(&[], |place| unquoted(self.line[place.clone()].trim_ascii()))
    }

    /// Whether a cell of the current row is quoted.
    fn is_quoted(&self, column: usize) -> bool {
        let place = self.cells.get(column);
        place.is_some_and(|place| self.line[place.clone()].trim_ascii().starts_with(b"\""))
    }

    /// Reads the number of atoms from the current line, which is `text`.
    pub fn n_atoms(&self, text: &str) -> Result<(usize, u64)> {
        let n_atoms = text.parse().map_err(|_| self.wrong(text, "expected a number of atoms"))?;
        Ok((n_atoms, self.n_read))
    }

    /// The error of the current line, which is `text`.
    pub fn wrong(&self, text: &str, expected: &str) -> Box<SceneError> {
        let found = quoted(text);
        let error = self.source.wrong(format!("{expected}, found {found:?}"), self.help);
        error.at_line(self.n_read).with_value(found)
    }
}

/// Returns bytes as text: UTF-8, or else Latin-1, as spreadsheets write it.
pub(super) fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().copied().map(char::from).collect::<String>().into(),
    }
}

/// Whether a line of a table, without white space around it, is a comment. One that begins with a colour is not.
pub(super) fn is_comment(line: &[u8]) -> bool {
    if !line.starts_with(b"#") && !line.starts_with(b"//") {
        return false;
    }
    let first = line.split(|byte| b",;\t ".contains(byte)).next().unwrap_or_default();
    std::str::from_utf8(first).ok().and_then(Color::parse).is_none()
}

/// Returns a cell without the quotes around it.
fn unquoted(cell: &[u8]) -> &[u8] {
    let quoted = cell.strip_prefix(b"\"").and_then(|cell| cell.strip_suffix(b"\""));
    quoted.unwrap_or(cell)
}

/// Words for a missing number, in lower case, besides `nan`.
const MISSING: [&str; 7] = ["", "na", "n/a", "null", "none", "-", "ø"];

/// Makes spheres of rows of cells.
struct Rows<'h> {
    layout: ColumnLayout,
    /// Sphere with the values that are the same for all rows.
    template: Sphere,
    head: &'h Head,
    numbers: Numbers,
    /// Coordinates that are relative to the box.
    is_scaled: [bool; 3],
    /// Whether rows without a coordinate or a radius are left out.
    skips_missing: bool,
    /// Whether the element gives the radius, the colour.
    of_element: [bool; 2],
    /// Note of the first label that may be an atom of a protein.
    atom_note: Option<Message>,
    /// How a row is written.
    help: &'static str,
}

impl<'h> Rows<'h> {
    fn new(
        layout: ColumnLayout,
        template: Sphere,
        head: &'h Head,
        help: &'static str,
        cloud: &Reading,
    ) -> Rows<'h> {
        let mut is_scaled = [false; 3];
        for (column, part, _) in &layout.parts {
            if let (Part::Center(axis), Some(cell)) = (part, &head.cell) {
                is_scaled[*axis] = cell.columns[*axis] == Some(*column);
            }
        }
        Rows {
            layout,
            template,
            head,
            numbers: Numbers::new(head.separator),
            is_scaled,
            skips_missing: cloud.skips_missing(),
            of_element: cloud.of_element,
            atom_note: None,
            help,
        }
    }

    /// Refuses a row with too few or too many cells.
    fn check_length(&self, lines: &Lines, is_table: bool) -> Result<(), RowError> {
        let (n_cells, n_names) = (lines.n_cells(), self.head.names.len());
        // Rows may end in a separator.
        let is_open_ended = n_cells == n_names + 1 && lines.cell(n_names).is_empty();
        if n_cells >= n_names && (!is_table || n_cells == n_names || is_open_ended) {
            return Ok(());
        }
        let found = match lines.line.trim_ascii().is_empty() {
            true => "an empty line".into(),
            false => n_cells.to_string(),
        };
        let message = format!("expected {n_names} values, one for each column, found {found}");
        let hint = match is_table {
            true => "write a value for each column; begin a line that is not a row with #",
            false => self.help,
        };
        Err(RowError::new(message, hint))
    }

    /// Reads the sphere of a row, and its colour as the file has it: numbers on any scale, or those that a colour map is applied
    /// to.
    fn sphere(&mut self, lines: &Lines, line: u64) -> Result<(Sphere, FileColor), RowError> {
        let (mut sphere, mut color) = (self.template, FileColor::default());
        for &(column, part, factor) in &self.layout.parts {
            let cell = lines.cell(column);
            if let Part::WholeColor { may_be_packed } = part {
                let found = whole_color(cell, may_be_packed);
                color = found.ok_or_else(|| self.no_color(column, cell))?;
                continue;
            }
            let may_have_comma = || self.head.separator != b',' || lines.is_quoted(column);
            let number = self.numbers.read(cell, may_have_comma, line)?;
            let may_be_missing = match part {
                Part::Scalar(_) => true,
                Part::Center(_) | Part::Radius | Part::Diameter => self.skips_missing,
                _ => false,
            };
            let number =
                number.or_else(|| (may_be_missing && is_missing(cell)).then_some(f64::NAN));
            let number = number.ok_or_else(|| self.no_number(column, part, lines))?;
            let number = factor.apply(number);
            if part == Part::Alpha {
                color.alpha = number;
            } else {
                put(part, number, &mut sphere, &mut color.color);
            }
        }
        if let Some(cell) = &self.head.cell
            && self.is_scaled.contains(&true)
        {
            sphere.center = cell.unscale(sphere.center, self.is_scaled);
            for &(column, part, _) in &self.layout.parts {
                let axis = cell.columns.iter().position(|scaled| *scaled == Some(column));
                if let (Part::Scalar(component), Some(axis)) = (part, axis) {
                    color.color.0[component] = sphere.center[axis];
                }
            }
        }
        if let Some(column) = self.layout.element
            && self.of_element.contains(&true)
        {
            self.apply_element(column, lines, line, &mut sphere, &mut color)?;
        }
        Ok((sphere, color))
    }

    fn apply_element(
        &mut self,
        column: usize,
        lines: &Lines,
        line: u64,
        sphere: &mut Sphere,
        color: &mut FileColor,
    ) -> Result<(), RowError> {
        let symbol = text_of(lines.cell(column));
        let [gives_radius, gives_color] = self.of_element;
        let element = element(&symbol).ok_or_else(|| {
            let what = if gives_radius { "radius" } else { "colour" };
            let message =
                format!("the label {:?} is no element with a known {what}", quoted(&symbol));
            let hint = Hint::new(
                "to draw all labels alike, give {}; or give {} and {}",
                [
                    Setting::no_column("element"),
                    Setting::number("radius", 1.0),
                    Setting::text("color", "steelblue"),
                ],
            );
            RowError::new(message, hint).with_value(symbol.as_ref())
        })?;
        if gives_radius {
            sphere.radius = element.radius;
        }
        if gives_color {
            color.color = element.color;
        }
        if self.atom_note.is_none()
            && let Some((name, atom)) = elements::also_an_atom_name(&symbol)
        {
            let text =
                format!("`{}` in line {line} is read as the element {name}", quoted(&symbol));
            let hint = format!("if it is {atom} of a protein, draw all labels alike with {{}}");
            self.atom_note =
                Some(Message::new(text, Hint::new(&hint, [Setting::no_column("element")])));
        }
        Ok(())
    }

    fn no_number(&self, column: usize, part: Part, lines: &Lines) -> RowError {
        let cell = lines.cell(column);
        let text = text_of(cell);
        let found = quoted(&text);
        let is_word = found.chars().any(char::is_alphabetic);
        let hint = match part {
            Part::Scalar(_) if is_word => {
                let is_number = |place: usize| {
                    let number = Numbers::new(b';').read(lines.cell(place), || true, 0);
                    number.is_ok_and(|number| number.is_some())
                };
                let mut unused =
                    self.head.names.iter().enumerate().filter(|(place, name)| {
                        self.layout.unused.contains(name) && is_number(*place)
                    });
                let other = unused.next().map_or("x", |(_, name)| name);
                let setting = Setting::text("color_by", other);
                Hint::new(
                    "colour maps need numbers; name a column of numbers, for example {}",
                    [setting],
                )
            }
            Part::Center(_) | Part::Radius | Part::Diameter
                if is_missing(cell) || found == "nan" =>
            {
                Hint::new("leave out such rows with {}", [Setting::text("missing", "skip")])
            }
            _ => self.help.into(),
        };
        let message = match part {
            Part::Scalar(_) if is_word => {
                format!("expected numbers, found words such as {found:?}")
            }
            _ => format!("expected a number, found {found:?}"),
        };
        self.fault_in(column, message, hint, &found)
    }

    fn no_color(&self, column: usize, cell: &[u8]) -> RowError {
        let text = String::from_utf8_lossy(cell);
        let found = quoted(&text);
        let name = self.head.names[column].as_str();
        let settings = [Setting::text("color_by", name), Setting::no_column("color")];
        let hint = if text.parse::<f64>().is_ok() {
            Hint::new(
                "if its numbers are not colours, apply a colour map with {}, or ignore them with {}",
                settings,
            )
        } else {
            let [_, ignored] = settings;
            Hint::new(
                "write \"#rrggbb\" or a CSS name in each row, or ignore the column with {}",
                [ignored],
            )
        };
        self.fault_in(column, format!("expected a colour, found {found:?}"), hint, &found)
    }

    fn fault_in(&self, column: usize, message: String, hint: Hint, value: &str) -> RowError {
        let name = self.head.names.get(column).filter(|_| !self.head.has_places);
        RowError { column: name.cloned(), ..RowError::new(message, hint) }.with_value(value)
    }

    /// Returns the notes of the rows.
    fn notes(&mut self) -> Vec<Message> {
        let numbers = self.numbers.note().map(Message::from);
        numbers.into_iter().chain(self.atom_note.take()).collect()
    }
}

/// A colour as a file has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FileColor {
    /// Components on any scale.
    pub color: Color,
    /// Alpha on the same scale; NaN if there is none.
    pub alpha: f64,
    /// Whether the components are bytes.
    pub is_bytes: bool,
}

impl Default for FileColor {
    fn default() -> FileColor {
        FileColor { color: Color::default(), alpha: f64::NAN, is_bytes: false }
    }
}

impl FileColor {
    /// Returns the colour of three bytes, packed as `0xrrggbb`; a byte above is left out, as PCL does.
    pub fn packed(bits: u32) -> FileColor {
        let [_, red, green, blue] = bits.to_be_bytes();
        let color = Color([red, green, blue].map(f64::from));
        FileColor { color, is_bytes: true, ..FileColor::default() }
    }

    /// Returns the colour whose packed bytes are the bits of a float. These floats are below 10⁻³⁷; `None` for any other one.
    pub fn packed_in_float(float: f32) -> Option<FileColor> {
        (float.to_bits() <= 0xff_ffff).then(|| FileColor::packed(float.to_bits()))
    }
}

/// Reads `#rrggbb` or a CSS name; if `may_be_packed`, also a number with packed bytes: a whole number, or, as PCL writes it, the
/// float with these bits.
fn whole_color(cell: &[u8], may_be_packed: bool) -> Option<FileColor> {
    let text = std::str::from_utf8(cell).ok()?;
    if let Some(color) = Color::parse(text) {
        let color = Color(color.to_srgb8().map(f64::from));
        return Some(FileColor { color, is_bytes: true, ..FileColor::default() });
    }
    if !may_be_packed {
        return None;
    }
    if let Ok(bits) = text.parse::<u32>() {
        return Some(FileColor::packed(bits));
    }
    text.parse().ok().and_then(FileColor::packed_in_float)
}

fn is_missing(cell: &[u8]) -> bool {
    MISSING.contains(&&String::from_utf8_lossy(cell).trim().to_lowercase()[..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_colors_are_read() {
        let bytes = |text: &str| whole_color(text.as_bytes(), true).map(|found| found.color.0);
        assert_eq!(bytes("#ff0080"), Some([255.0, 0.0, 128.0]));
        assert_eq!(bytes("red"), Some([255.0, 0.0, 0.0]));
        assert_eq!(bytes("16711935"), Some([255.0, 0.0, 255.0]));
        let float = f32::from_bits(0x00ff_8000);
        assert_eq!(bytes(&format!("{float:e}")), Some([255.0, 128.0, 0.0]));
        for wrong in ["", "sand", "0.5", "1.0", "-1", "nan", "4.2108e+06", "-0.0"] {
            assert_eq!(bytes(wrong), None, "{wrong}");
        }
        assert!(whole_color(b"7", false).is_none());
    }

    #[test]
    fn positions_in_tilted_boxes() {
        let cell = Cell {
            origin: DVec3::new(1.0, 2.0, 3.0),
            edges: [DVec3::X * 4.0, DVec3::new(1.0, 5.0, 0.0), DVec3::new(-2.0, 0.5, 6.0)],
            columns: [None; 3],
        };
        let scaled = DVec3::new(0.25, 0.5, 0.75);
        // x = xlo + xs·lx + ys·xy + zs·xz, and so on.
        let position = DVec3::new(1.0 + 1.0 + 0.5 - 1.5, 2.0 + 2.5 + 0.375, 3.0 + 4.5);
        for bits in 0..8 {
            let is_scaled = [0, 1, 2].map(|axis| bits >> axis & 1 == 1);
            let given = DVec3::from_array(std::array::from_fn(|axis| {
                if is_scaled[axis] { scaled[axis] } else { position[axis] }
            }));
            assert_eq!(cell.unscale(given, is_scaled), position, "{is_scaled:?}");
        }
        let flat = Cell { edges: [DVec3::X * 4.0, DVec3::new(1.0, 5.0, 0.0), DVec3::ZERO], ..cell };
        let given = DVec3::new(0.25, 4.5, 3.0);
        assert_eq!(flat.unscale(given, [true, false, false]), DVec3::new(2.5, 4.5, 3.0));
    }
}
