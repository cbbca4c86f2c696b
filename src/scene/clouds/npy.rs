//! Clouds in NumPy's format: tables of floats, and structured arrays.

use std::io::Read;

use super::columns::{Header, Layout};
use super::{Reading, Template, problem_of, wrong_color};
use crate::error::Error;
use crate::npy::{Array, Cell, FloatTable, Records};
use crate::scene::Color;
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
    let first = cloud.spheres.len();
    match array.is_structured() {
        false => {
            let table = cloud.source.table;
            let has_names = table.color_by.is_some() || !table.columns.is_empty();
            let any = [3..=u64::from(u16::MAX)];
            let known = COLUMNS.map(|n| n..=n);
            let allowed = if has_names { &any[..] } else { &known };
            let floats = array.floats(allowed).map_err(|error| stop(cloud, error))?;
            read_floats(cloud, floats)?;
        }
        true => {
            let records = array.records().map_err(|error| stop(cloud, error))?;
            read_records(cloud, records)?;
        }
    }
    check(cloud, first)
}

fn read_floats<R: Read>(cloud: &mut Reading, table: FloatTable<R>) -> Result<(), Stop> {
    let n = table.n_columns;
    // More than those that need no names: no radius, no colours.
    let n_named = if COLUMNS.contains(&(n as u64)) { n } else { 3 };
    let names = NAMES[..n_named].iter().map(|name| name.to_string());
    let names: Vec<String> = names.chain((n_named..n).map(|i| i.to_string())).collect();
    let layout = layout(cloud, &names, "the array")?;
    let template = cloud.template(&layout)?;
    let targets = targets(&layout, n);
    read_into(cloud, table.n_rows, template, &targets, Source::Floats(table))
}

fn read_records<R: Read>(cloud: &mut Reading, records: Records<R>) -> Result<(), Stop> {
    let names: Vec<String> = records.cells.iter().map(Cell::name).collect();
    let layout = layout(cloud, &names, "the structured array")?;
    let template = cloud.template(&layout)?;
    let is_byte = |column: &usize| records.cells[*column].is_byte();
    cloud.colors.are_bytes = layout.color.is_some_and(|color| color.iter().all(is_byte));
    let targets = targets(&layout, names.len());
    let wanted: Vec<usize> = (0..names.len()).filter(|&i| !targets[i].is_empty()).collect();
    if let Some(&column) = wanted.iter().find(|&&column| records.cells[column].kind.is_none()) {
        let (name, of_type) = (&names[column], &records.cells[column].type_name);
        let message = format!("the field {name:?} has the type {of_type}");
        return Err(cloud.wrong(
            message,
            "fields of numbers are read: floats of up to 64 bits, integers and bool",
        ));
    }
    read_into(cloud, records.n_rows, template, &targets, Source::Records(records, wanted))
}

fn layout(cloud: &Reading, names: &[String], what: &str) -> Result<Layout, Stop> {
    let header = Header { names, what, help: HELP, has_elements: false, has_places: true };
    let layout = Layout::find(cloud, &header)?;
    match layout.element {
        None => Ok(layout),
        Some(_) => Err(cloud.wrong("arrays have no elements", "remove `element` from `columns`")),
    }
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

/// An array whose numbers are still to be read.
enum Source<R: Read> {
    Floats(FloatTable<R>),
    /// The cells that are wanted.
    Records(Records<R>, Vec<usize>),
}

/// Adds `n` spheres of the template, and puts the numbers of the array where they belong.
fn read_into<R: Read>(
    cloud: &mut Reading,
    n: usize,
    Template { sphere, color }: Template,
    targets: &[Vec<Target>],
    source: Source<R>,
) -> Result<(), Stop> {
    cloud.reserve(n, color)?;
    let (spheres, colors) = cloud.spheres.extend_equal(n, sphere, color);
    let put = |row: usize, column: usize, value: f64| {
        for target in &targets[column] {
            match *target {
                Target::Center(axis) => spheres[row].center[axis] = value,
                Target::Radius(factor) => spheres[row].radius = factor * value,
                Target::Color(part) => colors[row].0[part] = value,
            }
        }
    };
    let read = match source {
        // A value and not a row at a time: in Fortran order, a column comes first.
        Source::Floats(table) => table.read(put),
        Source::Records(records, wanted) => records.read(&wanted, put),
    };
    read.map_err(|error| stop(cloud, error))
}

/// Checks the spheres from the index `first` on.
fn check(cloud: &mut Reading, first: usize) -> Result<(), Stop> {
    let place = |row: usize| format!("row {row} (counted from 0)");
    let colors = cloud.spheres.colors().skip(first);
    for (row, (sphere, color)) in cloud.spheres[first..].iter().zip(colors).enumerate() {
        if let Some(problem) = problem_of(sphere, Color::BLACK, cloud.eye) {
            return Err(cloud.wrong_row(place(row), problem));
        }
        if cloud.colors.is_from_file && !cloud.colors.see(color, || place(row)) {
            return Err(cloud.wrong_row(place(row), wrong_color(color)));
        }
    }
    Ok(())
}

fn stop(cloud: &Reading, error: Error) -> Stop {
    match error {
        Error::Input { message, .. } => cloud.wrong(message, HELP),
        Error::Io { source, .. } => cloud.failed(&source),
        other => other.into(),
    }
}
