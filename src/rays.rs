//! Lists of rays from a file, and what they hit into one.

use std::io::Write;
use std::path::Path;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::npy::{self, FloatTable, Record};
use crate::picture::OutputFile;
use crate::trace::{Hits, Ray};

/// Columns of a file of rays: origin x, y, z, then direction x, y, z.
const N_COLUMNS: usize = 6;

/// The path that means standard input.
pub const STDIN: &str = npy::STDIN;

/// Reads the rays of an `.npy` file: shape (N, 6), float64 or float32, C or Fortran order, either
/// byte order; [`STDIN`] is standard input. A row is an origin in world units and a direction of any
/// length but zero.
///
/// # Errors
/// [`Error::Io`] when the file can't be read. [`Error::Input`] when it has another shape or type,
/// is cut off, or has a row (counted from 0) with a number that is not finite or with a zero
/// direction. [`Error::TooLarge`] when the rays don't fit the memory.
pub fn read_rays(path: &Path) -> Result<Vec<Ray>> {
    let table = FloatTable::open(path, &[N_COLUMNS as u64])?;
    let mut rays = table.rows_of(Ray { origin: DVec3::ZERO, direction: DVec3::ZERO })?;
    let path = table.path().to_owned();
    table.read(|row, column, value| {
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

/// Hits that are encoded at once; keeps the memory small.
const HITS_AT_ONCE: usize = 1 << 16;

/// Writes a structured NumPy array of shape (N,) with the fields `id` (u4; 0 is no hit), `t` (f4;
/// +∞ without a hit), `normal` (3f4, unit, towards the ray; zero without a hit) and, where `hits`
/// has levels, `level` (u1). `-` is standard output.
///
/// # Errors
/// [`Error::Io`]; the old file is then as it was. [`Error::Usage`] when `hits` lacks `t` or
/// `normal`.
pub fn write_hits(path: &Path, hits: &Hits) -> Result<()> {
    let n_hits = hits.id.len();
    let level = !hits.level.is_empty();
    if hits.t.len() != n_hits || hits.normal.len() != n_hits || level && hits.level.len() != n_hits
    {
        return Err(Error::Usage(format!(
            "{}: the {n_hits} hits must have `t` and `normal` each, and `level` each or not at all",
            path.display()
        )));
    }
    let record = Record { rgb: false, level };
    let mut file = OutputFile::create(path, false)?;
    let mut bytes = Vec::new();
    record.write_header(&[n_hits as u64], &mut bytes).map_err(Error::io(path))?;
    let mut start = 0;
    loop {
        file.write_all(&bytes).map_err(Error::io(path))?;
        if start == n_hits {
            return file.commit();
        }
        bytes.clear();
        let end = n_hits.min(start + HITS_AT_ONCE);
        record.append(hits, start..end, &[], &mut bytes);
        start = end;
    }
}
