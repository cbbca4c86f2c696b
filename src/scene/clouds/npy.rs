//! Clouds in NumPy's format: tables of floats, and structured arrays.

use super::columns::{Header, Layout};
use super::{Reading, Template};
use crate::error::Error;
use crate::npy::{Array, Cell};
use crate::scene::places::Stop;

/// Columns of a table that need no names: x, y, z; with r; with r and linear red, green, blue.
const COLUMNS: [u64; 3] = [3, 4, 7];
const NAMES: [&str; 7] = ["x", "y", "z", "r", "red", "green", "blue"];

const HELP: &str = "numpy.save writes such a file from an array with the columns x, y, z; or x, y, z, r; \
                    or x, y, z, r, red, green, blue; or from a structured array with fields of these \
                    names. `columns = { radius = 3 }` tells of others, by their names or places from 0";

/// Reads the spheres of an `.npy` file, in the order of its rows.
pub(super) fn read(cloud: &mut Reading) -> Result<(), Stop> {
    cloud.refuse_frame()?;
    let (file, n_bytes) = cloud.open()?;
    let path = cloud.source.path.clone();
    let array = Array::new(file, n_bytes, &path, "a NumPy array of numbers")
        .map_err(|error| stop(cloud, error))?;
    let is_structured = array.header.is_structured;
    let table = cloud.source.table;
    let has_names = table.color_by.is_some() || !table.columns.is_empty();
    let (any, known) = ([3..=u64::from(u16::MAX)], COLUMNS.map(|n| n..=n));
    let allowed = if has_names { &any[..] } else { &known };
    let rows = if is_structured { array.records() } else { array.floats(allowed) };
    let rows = rows.map_err(|error| stop(cloud, error))?;

    let n = rows.cells.len();
    // Of more columns than need no names, none is a radius or a colour.
    let n_named = if COLUMNS.contains(&(n as u64)) { n } else { 3 };
    let by_place = |i: usize| NAMES[..n_named].get(i).map_or(i.to_string(), |name| (*name).into());
    let (what, names): (_, Vec<String>) = match is_structured {
        true => ("the structured array", rows.cells.iter().map(Cell::name).collect()),
        false => ("the array", (0..n).map(by_place).collect()),
    };
    let header = Header { names: &names, what, help: HELP, has_elements: false, has_places: true };
    let layout = Layout::find(cloud, &header)?;
    if layout.element.is_some() {
        return Err(cloud.wrong("arrays have no elements", "remove `element` from `columns`"));
    }
    let Template { sphere, color } = cloud.template(&layout)?;
    let is_byte = |column: &usize| rows.cells[*column].is_byte();
    cloud.colors.are_bytes = layout.color.is_some_and(|color| color.iter().all(is_byte));
    let targets = targets(&layout, n);
    let wanted: Vec<usize> = (0..n).filter(|&i| !targets[i].is_empty()).collect();
    if let Some(&column) = wanted.iter().find(|&&column| rows.cells[column].kind.is_none()) {
        let (name, of_type) = (&names[column], &rows.cells[column].type_name);
        return Err(cloud.wrong(
            format!("the field {name:?} has the type {of_type}"),
            "fields of numbers are read: floats of up to 64 bits, integers and bool",
        ));
    }

    cloud.reserve(rows.n_rows, color)?;
    let first = cloud.spheres.len();
    let (spheres, colors) = cloud.spheres.extend_equal(rows.n_rows, sphere, color);
    // A value and not a row at a time: in Fortran order, a column comes first.
    let read = rows.read(&wanted, |row, column, value| {
        for target in &targets[column] {
            match *target {
                Target::Center(axis) => spheres[row].center[axis] = value,
                Target::Radius(factor) => spheres[row].radius = factor * value,
                Target::Color(part) => colors[row].0[part] = value,
            }
        }
    });
    read.map_err(|error| stop(cloud, error))?;
    for i in first..cloud.spheres.len() {
        let (sphere, color) = (cloud.spheres[i], cloud.spheres.color(i).unwrap_or_default());
        cloud.check(sphere, color, || format!("row {} (counted from 0)", i - first))?;
    }
    Ok(())
}

/// What a number becomes.
#[derive(Clone, Copy)]
enum Target {
    Center(usize),
    /// The radius, when it is multiplied by this.
    Radius(f64),
    /// A channel of the colour, or a part of what the sphere is coloured by.
    Color(usize),
}

/// What the numbers of each of `n` columns become.
fn targets(layout: &Layout, n: usize) -> Vec<Vec<Target>> {
    let mut targets = vec![Vec::new(); n];
    for (axis, &column) in layout.center.iter().enumerate() {
        targets[column].push(Target::Center(axis));
    }
    if let Some(column) = layout.radius {
        targets[column].push(Target::Radius(layout.radius_factor));
    }
    let colors = layout.color.iter().flatten().enumerate();
    for (part, &column) in colors.chain(layout.color_by.iter().enumerate()) {
        targets[column].push(Target::Color(part));
    }
    targets
}

fn stop(cloud: &Reading, error: Error) -> Stop {
    match error {
        Error::Input { message, .. } => cloud.wrong(message, HELP),
        Error::Io { source, .. } => cloud.failed(&source),
        other => other.into(),
    }
}
