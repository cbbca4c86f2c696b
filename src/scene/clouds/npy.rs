//! Clouds in NumPy's format.

use super::{Reading, Template, problem_of};
use crate::error::Error;
use crate::npy::FloatTable;
use crate::scene::places::Stop;

/// Columns: x, y, z; with r; with r and linear red, green, blue.
const COLUMNS: [u64; 3] = [3, 4, 7];

/// Reads the spheres of an `.npy` file, in the order of its rows.
pub(super) fn read(cloud: &mut Reading) -> Result<(), Stop> {
    let (file, n_bytes) = cloud.open()?;
    let table = FloatTable::new(file, n_bytes, &cloud.source.path, &COLUMNS)
        .map_err(|error| stop(cloud, error))?;
    let Template { sphere, color } = cloud.template(table.n_columns >= 4, table.n_columns == 7)?;
    let first = cloud.spheres.len();
    cloud.reserve(table.n_rows, color)?;
    let (spheres, colors) = cloud.spheres.extend_equal(table.n_rows, sphere, color);
    // A value and not a row at a time: in Fortran order, a column comes first.
    let read = table.read(|row, column, value| match column {
        0..3 => spheres[row].center[column] = value,
        3 => spheres[row].radius = value,
        _ => colors[row].0[column - 4] = value,
    });
    read.map_err(|error| stop(cloud, error))?;
    let colors = cloud.spheres.colors().skip(first);
    for (row, (sphere, color)) in cloud.spheres[first..].iter().zip(colors).enumerate() {
        if let Some(problem) = problem_of(sphere, color, cloud.eye) {
            return Err(cloud.wrong_row(format!("row {row} (counted from 0)"), problem));
        }
    }
    Ok(())
}

fn stop(cloud: &Reading, error: Error) -> Stop {
    match error {
        Error::Input { message, .. } => cloud.wrong(
            message,
            "numpy.save writes such a file from an array with the columns x, y, z; or x, y, z, r; \
             or x, y, z, r, red, green, blue",
        ),
        Error::Io { source, .. } => cloud.failed(&source),
        other => other.into(),
    }
}
