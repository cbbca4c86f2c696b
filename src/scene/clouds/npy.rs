//! Clouds in NumPy's format: tables of floats, and structured arrays.

use super::columns::{Header, Layout, Part, RED, put};
use super::{CloudFile, Reading};
use crate::error::{Error, Result};
use crate::npy::{self, Array, Cell};
use crate::scene::Color;

/// Columns of a table that need no names: x, y, z; with r; with r and linear red, green, blue.
const COLUMNS: [u64; 3] = [3, 4, 7];
const NAMES: [&str; 7] = ["x", "y", "z", "r", "red", "green", "blue"];

const UNNAMED: &str = "a NumPy array of float64 or float32 with shape (N, 3) or (N, 4) or (N, 7)";
const NAMED: &str = "a NumPy array of float64 or float32 with shape (N, 3) or more columns";

const HELP: &str = "numpy.save writes such a file from an array with the columns x, y, z; or x, y, z, r; \
                    or x, y, z, r, red, green, blue; or from a structured array with fields of these \
                    names. `columns = { radius = 3 }` tells of others, by their names or places from 0";

/// Reads the spheres of an `.npy` file, in the order of its rows.
pub(super) fn read(cloud: &mut Reading) -> Result<Layout> {
    let source = cloud.source;
    source.refuse_frame()?;
    let has_names = source.keys.color_by.is_some() || source.keys.columns.is_some();
    let open = || {
        let (file, n_bytes) = source.open()?;
        let array = Array::new(file, n_bytes, &source.path, "a NumPy array of numbers")?;
        match (array.header.is_structured, has_names) {
            (true, _) => array.records(),
            (false, true) => array.floats(|n| (3..=u64::from(u16::MAX)).contains(&n), NAMED),
            (false, false) => array.floats(|n| COLUMNS.contains(&n), UNNAMED),
        }
    };
    let array = open().map_err(|error| of_file(source, error))?;
    let npy::Header { cells, is_structured, .. } = &array.header;

    let n = cells.len();
    // Of more columns than need no names, none is a radius or a colour.
    let n_named = if COLUMNS.contains(&(n as u64)) { n } else { 3 };
    let by_place = |i: usize| NAMES[..n_named].get(i).map_or(i.to_string(), |name| (*name).into());
    let (what, names): (_, Vec<String>) = if *is_structured {
        ("the structured array", cells.iter().map(Cell::name).collect())
    } else {
        ("the array", (0..n).map(by_place).collect())
    };
    let header = Header { names: &names, what, help: HELP, has_elements: false, has_places: true };
    let layout = Layout::find(source, &header)?;
    if layout.element.is_some() {
        return Err(source.wrong("arrays have no elements", "remove `element` from `columns`"));
    }
    let sphere = cloud.template(&layout)?;
    if let Some(colors) = &mut cloud.file_colors {
        let is_byte = |(column, part): &(usize, Part)| *part < RED || cells[*column].is_byte();
        colors.are_bytes = layout.parts.iter().all(is_byte);
    }
    let is_no_number = |(column, _): &&(usize, Part)| cells[*column].kind.is_none();
    if let Some(&(column, _)) = layout.parts.iter().find(is_no_number) {
        let (name, of_type) = (&names[column], &cells[column].type_name);
        return Err(source.wrong(
            format!("the field {name:?} has the type {of_type}"),
            "fields of numbers are read: floats of up to 64 bits, integers and bool",
        ));
    }

    let n_rows = array.n_rows();
    cloud.reserve(n_rows)?;
    let n_colors = if cloud.color.is_none() { n_rows } else { 0 };
    cloud.spheres.resize(n_rows, sphere);
    cloud.colors.resize(n_colors, Color::default());
    let (spheres, colors) = (&mut cloud.spheres, &mut cloud.colors);
    // A value and not a row at a time: in Fortran order, a column comes first.
    let read = array.read(&layout.parts, |row, part, value| {
        let color = colors.get_mut(row);
        put(part, value, &mut spheres[row], color.unwrap_or(&mut Color::default()));
    });
    read.map_err(|error| of_file(source, error))?;
    for row in 0..n_rows {
        let color = cloud.colors.get(row).copied().unwrap_or_default();
        cloud.check(cloud.spheres[row], color, || format!("row {row} (counted from 0)"))?;
    }
    Ok(layout)
}

fn of_file(file: &CloudFile, error: Error) -> Error {
    match error {
        Error::Input { message, .. } => file.wrong(message, HELP),
        Error::Io { source, .. } => file.failed(&source),
        other => other,
    }
}
