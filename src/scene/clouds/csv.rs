//! Clouds as comma-separated values.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use csv::{ByteRecord, Error, ErrorKind, Position, Reader, ReaderBuilder};

use super::watched::Watched;
use super::{Reading, Template};
use crate::scene::places::{Stop, quoted};
use crate::scene::{Color, Sphere};

const HELP: &str = "the first line names the columns: x, y, z, and optionally r, and red, green, \
                    blue (linear, 0 to 1), in any order and among others, with commas between them";

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 18;

/// Longest line, bytes, also one with line breaks between quotes: a file that is no text may have
/// none. What is read at once may let a longer one pass.
const MAX_LINE_BYTES: u64 = 1 << 20;

/// Reads the spheres of a `.csv` file, in the order of its lines.
pub(super) fn read(cloud: &mut Reading) -> Result<(), Stop> {
    let (mut file, n_bytes) = cloud.open()?;
    // All lines but the header; where the last one has no line break, the header's counts.
    let n_at_most = n_bytes.map(|_| file.count_line_breaks()).transpose();
    let n_at_most = n_at_most.map_err(|error| cloud.failed(&error))?;
    let mut reader = ReaderBuilder::new().buffer_capacity(BUFFER_BYTES).from_reader(file);
    let allow = |reader: &Reader<Watched>| {
        reader.get_ref().allow(MAX_LINE_BYTES + BUFFER_BYTES as u64);
    };
    allow(&reader);
    if let Err(error) = reader.byte_headers() {
        return Err(stop(cloud, &error, &reader));
    }
    let header = reader.byte_headers().map_err(|error| cloud.wrong(error, HELP))?;
    let columns = Columns::find(header).map_err(|found| cloud.wrong(found, HELP))?;
    let template = cloud.template(columns.radius.is_some(), columns.color.is_some())?;
    if let Some(n) = n_at_most {
        cloud.reserve(n, template.color)?;
    }

    let path = cloud.source.path.clone();
    let mut record = ByteRecord::new();
    loop {
        allow(&reader);
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => return Ok(()),
            Err(error) => return Err(stop(cloud, &error, &reader)),
        }
        let place = || line_of(&path, record.position());
        let sphere = columns.sphere(&record, &template).map_err(|found| {
            let message = format!("{}: {found}", place());
            cloud.wrong(message, "write numbers like 1.5 or 2e-3, with a point")
        })?;
        cloud.push(sphere, place)?;
    }
}

/// Where each value stands in a line.
#[derive(Debug, PartialEq)]
struct Columns {
    center: [usize; 3],
    radius: Option<usize>,
    color: Option<[usize; 3]>,
}

impl Columns {
    /// Finds the columns by name, in either case; other columns are not looked at.
    fn find(header: &ByteRecord) -> Result<Columns, String> {
        let names: Vec<String> = header
            .iter()
            .map(|name| String::from_utf8_lossy(name).trim().to_ascii_lowercase())
            .collect();
        let find = |name: &str| {
            let mut places = (0..names.len()).filter(|&column| names[column] == name);
            match (places.next(), places.next()) {
                (_, Some(_)) => Err(format!("the header names the column `{name}` twice")),
                (place, None) => Ok(place),
            }
        };
        let require = |name: &str| {
            find(name)?.ok_or_else(|| {
                let found = names.join(", ");
                format!("the header has no column `{name}`, only {:?}", quoted(&found))
            })
        };
        let all = |three: [&str; 3]| -> Result<[usize; 3], String> {
            Ok([require(three[0])?, require(three[1])?, require(three[2])?])
        };
        const COLOR: [&str; 3] = ["red", "green", "blue"];
        let has_color = names.iter().any(|name| COLOR.contains(&name.as_str()));
        Ok(Columns {
            center: all(["x", "y", "z"])?,
            radius: find("r")?,
            color: has_color.then(|| all(COLOR)).transpose()?,
        })
    }

    /// The sphere of a line; `template` has what the columns lack.
    fn sphere(&self, record: &ByteRecord, template: &Template) -> Result<(Sphere, Color), String> {
        let number = |column: usize| {
            let field = record.get(column).unwrap_or_default();
            let text = std::str::from_utf8(field).ok().map(str::trim);
            text.and_then(|text| text.parse::<f64>().ok()).ok_or_else(|| {
                let found = String::from_utf8_lossy(field);
                format!("{:?} is not a number", quoted(&found))
            })
        };
        let Template { mut sphere, color } = *template;
        let mut color = color.unwrap_or_default();
        for (axis, &column) in self.center.iter().enumerate() {
            sphere.center[axis] = number(column)?;
        }
        if let Some(column) = self.radius {
            sphere.radius = number(column)?;
        }
        for (channel, &column) in self.color.iter().flatten().enumerate() {
            color.0[channel] = number(column)?;
        }
        Ok((sphere, color))
    }
}

fn stop(cloud: &Reading, error: &Error, reader: &Reader<Watched>) -> Stop {
    match error.kind() {
        ErrorKind::Io(_) if reader.get_ref().is_used_up() => {
            let (line, most) = (reader.position().line(), MAX_LINE_BYTES >> 20);
            cloud.wrong(format!("line {line}: the line is longer than {most} MiB"), HELP)
        }
        ErrorKind::Io(error) => cloud.failed(error),
        ErrorKind::UnequalLengths { pos, expected_len, len } => cloud.wrong(
            format!(
                "{}: {len} values, but the header names {expected_len} columns",
                line_of(&cloud.source.path, pos.as_ref())
            ),
            "each line has a value for each column, and a point, no comma, in its numbers",
        ),
        _ => cloud.wrong(error, HELP),
    }
}

/// Where a record stands. The library counts the line breaks that it has gone through, and lines
/// that end in `\r\n` or are empty leave some to be skipped before the record.
fn line_of(path: &Path, position: Option<&Position>) -> String {
    let Some(position) = position else { return "a line".into() };
    let skipped = || -> io::Result<u64> {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(position.byte()))?;
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
    let n_skipped = if path.is_file() { skipped().unwrap_or(0) } else { 0 };
    format!("line {}", position.line() + n_skipped)
}
