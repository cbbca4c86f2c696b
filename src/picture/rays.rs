//! Lists of rays from a file, and what they hit into one.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::hit_record::HitRecord;
use crate::error::{Error, Result, wrong_usage};
use crate::npy::Array;
use crate::output::OutputFile;
use crate::plain::Shown;
use crate::query::Hits;
use crate::rays::WorldRay;
use crate::scene::open_input;
use crate::support::control::Control;

/// Origin x, y, z, then direction x, y, z.
const EXPECTED: &str = "a NumPy array of numbers with shape (N, 6)";

/// The path that means standard input.
pub const STDIN: &str = "-";

/// The name of standard input in messages.
const STDIN_IN_WORDS: &str = "standard input";

/// Reads the rays of an `.npy` file: shape (N, 6), floats of up to 64 bits or integers, C or Fortran order, either
/// byte order; [`STDIN`] is standard input. A row is an origin in world units and a direction of any
/// length but zero. `control` counts the bytes and can stop the reading.
///
/// # Errors
/// [`Error::Io`] when the file can't be read. [`Error::Input`] when it has another shape or type,
/// is cut off, or has a row (counted from 0) with a number that is not finite or with a zero
/// direction. [`Error::TooLarge`] when the rays don't fit the memory.
/// [`Error::Interrupted`].
pub fn read_rays(path: &Path, control: &Control) -> Result<Vec<WorldRay>> {
    read(path, control).map_err(|error| control.check().err().unwrap_or(error))
}

fn read(path: &Path, control: &Control) -> Result<Vec<WorldRay>> {
    let is_stdin = path == Path::new(STDIN);
    let input = open_input(path, control).map_err(Error::io(path))?;
    let n_bytes = input.n_bytes();
    let path = if is_stdin { PathBuf::from(STDIN_IN_WORDS) } else { path.to_owned() };
    control.expect_bytes(n_bytes.unwrap_or(0));
    let table = Array::new(input, n_bytes, &path, EXPECTED)?.numbers(|n| n == 6, EXPECTED)?;
    let mut rays = table.rows_of(WorldRay { origin: DVec3::ZERO, direction: DVec3::ZERO })?;
    table.read(&[0, 1, 2, 3, 4, 5].map(|column| (column, column)), |row, column, value| {
        let ray = &mut rays[row];
        match column.checked_sub(3) {
            None => ray.origin[column] = value,
            Some(axis) => ray.direction[axis] = value,
        }
    })?;
    for (row, ray) in rays.iter().enumerate() {
        let problem = if !ray.origin.is_finite() || !ray.direction.is_finite() {
            "has a number that is not finite"
        } else if ray.direction == DVec3::ZERO {
            "has the direction (0, 0, 0), which points nowhere"
        } else {
            continue;
        };
        let message = format!("row {row} (counted from 0) {problem}");
        return Err(Error::Input { path, message });
    }
    Ok(rays)
}

/// Hits as the records that [`write_hits`] writes, one after the other, in this machine's byte order. `hits`
/// must have surfaces and levels.
pub fn hit_records(hits: &Hits) -> Vec<u8> {
    let record = HitRecord { rgb: false, alpha: false, level: true };
    let mut bytes = Vec::new();
    record.append(hits, 0..hits.id.len(), &[], None, &mut bytes);
    bytes
}

/// Writes a structured NumPy array of shape (N,) with the fields `id` (u4; 0 is no hit), `t` (f4;
/// +∞ without a hit), `normal` (3f4, unit, towards the ray; zero without a hit) and, where `hits`
/// has levels, `level` (u1). `control` counts the bytes.
///
/// # Errors
/// [`Error::Io`] and [`Error::Interrupted`]. [`Error::Usage`] when `hits` lacks `t` or `normal`.
pub fn write_hits(file: &mut OutputFile, hits: &Hits, control: &Control) -> Result<()> {
    let n_hits = hits.id.len();
    let level = !hits.level.is_empty();
    if hits.t.len() != n_hits || hits.normal.len() != n_hits || level && hits.level.len() != n_hits
    {
        return wrong_usage(format!(
            "{}: the {n_hits} hits must have `t` and `normal` each, and `level` each or not at all",
            file.path().shown()
        ));
    }
    let record = HitRecord { rgb: false, alpha: false, level };
    let append =
        |hits_at_once, bytes: &mut Vec<u8>| record.append(hits, hits_at_once, &[], None, bytes);
    file.write_rows(record.header(&[n_hits as u64]), n_hits, record.bytes(), append, control)
}
