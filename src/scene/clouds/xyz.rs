//! Clouds of atoms in the chemists' XYZ format.

use std::io::{BufRead, BufReader, Read};

use glam::DVec3;

use super::Reading;
use super::elements::{Element, Elements};
use super::watched::Watched;
use crate::scene::Sphere;
use crate::scene::places::{Stop, quoted};

const HELP: &str = "the first line of an .xyz file is the number of atoms, the second a comment, \
                    and each further line an atom: its element, x, y and z in ångström";

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 18;

/// Longest line, bytes: a file that is no text may have none.
const MAX_LINE_BYTES: u64 = 1 << 16;

/// Bytes of the shortest line of an atom, `C 0 0 0`; a line break may be missing at the end.
const MIN_ATOM_BYTES: u64 = 7;

/// Reads the atoms of an `.xyz` file, in the order of its lines. What stands behind an atom's
/// coordinates is not looked at.
pub(super) fn read(cloud: &mut Reading) -> Result<(), Stop> {
    let (file, n_bytes) = cloud.open()?;
    let template = cloud.template(true, true)?;
    let elements = Elements::new();
    let mut lines = Lines::new(file);

    let count = lines.next(cloud)?.map(str::trim).unwrap_or_default();
    let n_atoms: usize = count.parse().map_err(|_| {
        let message = format!("line 1: {:?} is not a number of atoms", quoted(count));
        cloud.wrong(message, HELP)
    })?;
    // A wrong number must not ask for more than a file of this length can have.
    let n_at_most = n_bytes.map_or(0, |n| n / MIN_ATOM_BYTES);
    cloud.reserve(n_atoms.min(usize::try_from(n_at_most).unwrap_or(usize::MAX)))?;
    lines.next(cloud)?;

    for n_read in 0..n_atoms {
        // Counted from 1, after the number and the comment.
        let place = format_args!("line {}", n_read + 3);
        let Some(line) = lines.next(cloud)? else {
            return Err(cloud.wrong(
                format!("line 1 tells of {n_atoms} atoms, but the file ends after {n_read}"),
                "is the file cut off? if not, correct its first line",
            ));
        };
        let (symbol, center) =
            atom(line).map_err(|found| cloud.wrong(format!("{place}: {found}"), HELP))?;
        let Some(Element { radius, color }) = elements.get(symbol) else {
            return Err(cloud.wrong(
                format!("{place}: no radius is known of an element {:?}", quoted(symbol)),
                "an atom begins with its symbol in the periodic table, e.g. C, N or Fe; spheres of \
                 other kinds go into a .csv or .npy file with their radius",
            ));
        };
        cloud.push(Sphere { center, radius, color, ..template.clone() }, || place)?;
    }
    while let Some(line) = lines.next(cloud)? {
        if !line.trim().is_empty() {
            return Err(cloud.wrong(
                format!("the file goes on behind the {n_atoms} atoms that line 1 tells of"),
                "correct the first line; of several steps of a simulation, save one",
            ));
        }
    }
    Ok(())
}

/// The element's symbol and the centre.
fn atom(line: &str) -> Result<(&str, DVec3), String> {
    let mut words = line.split_ascii_whitespace();
    let symbol = words.next().ok_or("the line is empty")?;
    let mut center = DVec3::ZERO;
    for axis in 0..3 {
        let word = words.next().ok_or("there are not three coordinates")?;
        center[axis] = word.parse().map_err(|_| format!("{:?} is not a number", quoted(word)))?;
    }
    Ok((symbol, center))
}

/// The lines of a file, one at a time.
struct Lines<'c> {
    reader: BufReader<Watched<'c>>,
    line: Vec<u8>,
    n_read: u64,
}

impl<'c> Lines<'c> {
    fn new(file: Watched<'c>) -> Lines<'c> {
        Lines { reader: BufReader::with_capacity(BUFFER_BYTES, file), line: Vec::new(), n_read: 0 }
    }

    fn next(&mut self, cloud: &Reading) -> Result<Option<&str>, Stop> {
        self.line.clear();
        self.n_read += 1;
        let n = (&mut self.reader)
            .take(MAX_LINE_BYTES)
            .read_until(b'\n', &mut self.line)
            .map_err(|error| cloud.failed(&error))?;
        let wrong = |what: &str| cloud.wrong(format!("line {}: {what}", self.n_read), HELP);
        match n {
            0 => Ok(None),
            _ if n as u64 == MAX_LINE_BYTES => {
                Err(wrong(&format!("the line is longer than {} KiB", MAX_LINE_BYTES >> 10)))
            }
            _ => std::str::from_utf8(&self.line)
                .map(Some)
                .map_err(|_| wrong("the line is not UTF-8 text")),
        }
    }
}
