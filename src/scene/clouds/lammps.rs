//! Clouds of atoms or grains as LAMMPS dumps them: text with a line of column names.

use super::Reading;
use super::columns::{Header, Layout};
use super::lines::Lines;
use super::text::TextRows;
use super::xyz::cells_of;
use crate::scene::places::{Stop, quoted};

const HELP: &str = "a LAMMPS dump in text has for each step the lines ITEM: TIMESTEP, ITEM: NUMBER OF \
                    ATOMS, ITEM: BOX BOUNDS and ITEM: ATOMS with the names of columns, x, y and z \
                    among them";

/// Bytes of the shortest number and the space or line break behind it.
const MIN_CELL_BYTES: u64 = 2;

/// What stands before a frame's rows.
struct Frame {
    n_atoms: usize,
    /// Low and high end of the box along each axis, where it is a cuboid.
    bounds: Option<[[f64; 2]; 3]>,
    /// Names of the columns.
    names: Vec<String>,
}

/// Reads the atoms of one frame of a dump, in the order of its lines.
pub(super) fn read(cloud: &mut Reading) -> Result<(), Stop> {
    let (file, n_bytes) = cloud.open()?;
    let mut lines = Lines::new(file, HELP);
    for frame in 0..cloud.frame() {
        let Some(Frame { n_atoms, .. }) = head(&mut lines, cloud)? else {
            return Err(cloud.no_such_frame(frame));
        };
        for n_read in 0..n_atoms {
            if lines.next(cloud)?.is_none() {
                return Err(cut_off(cloud, n_atoms, n_read));
            }
        }
    }
    let Some(Frame { n_atoms, bounds, mut names }) = head(&mut lines, cloud)? else {
        return Err(match cloud.frame() {
            0 => cloud.wrong("the file has no ITEM: ATOMS", HELP),
            frame => cloud.no_such_frame(frame),
        });
    };
    let box_of_scaled = scaled(cloud, &mut names, bounds)?;
    let header = Header {
        names: &names,
        what: "ITEM: ATOMS",
        help: HELP,
        has_elements: true,
        has_places: false,
    };
    let layout = Layout::find(cloud, &header)?;
    let template = cloud.template(&layout)?;
    // A wrong number must not ask for more than a file of this length can have.
    let n_at_most = n_bytes.map_or(0, |n| n / (names.len() as u64 * MIN_CELL_BYTES));
    let n_at_most = usize::try_from(n_at_most).unwrap_or(usize::MAX);
    cloud.reserve(n_atoms.min(n_at_most), template.color)?;
    let rows = TextRows::new(layout, template, false);

    let mut cells = Vec::new();
    for n_read in 0..n_atoms {
        // Counted from 1.
        let number = lines.n_read + 1;
        let place = || format!("line {number}");
        let Some(line) = lines.next(cloud)? else {
            return Err(cut_off(cloud, n_atoms, n_read));
        };
        cells_of(line, names.len(), &mut cells);
        if cells.len() < names.len() {
            let (n, n_names) = (cells.len(), names.len());
            let found = format!("{n} values, but ITEM: ATOMS names {n_names} columns");
            return Err(cloud.wrong(format!("{}: {found}", place()), HELP));
        }
        let cell = |column: usize| line.as_bytes().get(cells.get(column)?.clone());
        let (mut sphere, mut color) = rows.sphere(cell).map_err(|(found, help)| {
            cloud.wrong(format!("{}: {found}", place()), help.unwrap_or(HELP))
        })?;
        if let Some(bounds) = box_of_scaled {
            for (axis, [low, high]) in bounds.into_iter().enumerate() {
                sphere.center[axis] = low + sphere.center[axis] * (high - low);
            }
            for (part, column) in rows.layout.color_by.iter().enumerate() {
                if let Some(axis) = rows.layout.center.iter().position(|c| c == column) {
                    color.0[part] = sphere.center[axis];
                }
            }
        }
        cloud.push((sphere, color), place)?;
    }
    if cloud.source.table.frame.is_none() && head(&mut lines, cloud)?.is_some() {
        return Err(cloud.wrong(
            "the file has several frames",
            "choose one by `frame = 0` (the first), or save one",
        ));
    }
    cloud.note("its box is left out");
    Ok(())
}

/// What stands before the rows of the next frame; `None` at the end of the file.
fn head(lines: &mut Lines, cloud: &Reading) -> Result<Option<Frame>, Stop> {
    let (mut n_atoms, mut bounds) = (None, None);
    let mut is_begun = false;
    loop {
        let Some(line) = lines.next(cloud)? else {
            return match is_begun {
                true => Err(cloud.wrong("the file ends within the lines before its atoms", HELP)),
                false => Ok(None),
            };
        };
        let line = line.trim().to_owned();
        if line.is_empty() && !is_begun {
            continue;
        }
        let wrong = |found: &str, number: u64| {
            cloud.wrong(format!("line {number}: {:?} {found}", quoted(&line)), HELP)
        };
        let Some(item) = line.strip_prefix("ITEM:").map(str::trim) else {
            return Err(wrong("stands where ITEM: is expected", lines.n_read));
        };
        is_begun = true;
        if item == "NUMBER OF ATOMS" {
            let count = lines.next(cloud)?.unwrap_or_default().trim().to_owned();
            let message =
                || format!("line {}: {:?} is not a number of atoms", lines.n_read, quoted(&count));
            n_atoms = Some(count.parse().map_err(|_| cloud.wrong(message(), HELP))?);
        } else if let Some(kind) = item.strip_prefix("BOX BOUNDS") {
            let mut all = [[0.0; 2]; 3];
            for ends in &mut all {
                let line = lines.next(cloud)?.unwrap_or_default().to_owned();
                let numbers: Vec<f64> =
                    line.split_ascii_whitespace().map_while(|word| word.parse().ok()).collect();
                let [low, high, ..] = numbers[..] else {
                    let message =
                        format!("line {}: {:?} has no two ends", lines.n_read, quoted(line.trim()));
                    return Err(cloud.wrong(message, HELP));
                };
                *ends = [low, high];
            }
            let is_cuboid = !kind.contains("xy") && !kind.contains("abc");
            bounds = is_cuboid.then_some(all);
        } else if let Some(names) = item.strip_prefix("ATOMS") {
            let names: Vec<String> = names.split_ascii_whitespace().map(String::from).collect();
            let (Some(n_atoms), false) = (n_atoms, names.is_empty()) else {
                return Err(wrong("lacks a number of atoms, or columns", lines.n_read));
            };
            return Ok(Some(Frame { n_atoms, bounds, names }));
        } else {
            // The time, the units: a line.
            lines.next(cloud)?;
        }
    }
}

/// Calls scaled coordinates `x`, `y` and `z` where there are no others, and gives the box that they are
/// scaled by.
fn scaled(
    cloud: &Reading,
    names: &mut [String],
    bounds: Option<[[f64; 2]; 3]>,
) -> Result<Option<[[f64; 2]; 3]>, Stop> {
    let place = |name: &str| names.iter().position(|other| other == name);
    let others = ["x", "xu"];
    if others.into_iter().any(|name| place(name).is_some()) {
        return Ok(None);
    }
    let find = |three: [&str; 3]| -> Option<Vec<usize>> { three.into_iter().map(place).collect() };
    let found = find(["xs", "ys", "zs"]).or_else(|| find(["xsu", "ysu", "zsu"]));
    let Some(columns) = found else { return Ok(None) };
    let Some(bounds) = bounds else {
        return Err(cloud.wrong(
            "its coordinates are scaled by a box that is no cuboid",
            "dump x y z, or xu yu zu, in place of xs ys zs",
        ));
    };
    for (column, name) in columns.into_iter().zip(["x", "y", "z"]) {
        names[column] = name.into();
    }
    Ok(Some(bounds))
}

fn cut_off(cloud: &Reading, n_atoms: usize, n_read: usize) -> Stop {
    cloud.wrong(
        format!("the file tells of {n_atoms} atoms, but ends after {n_read}"),
        "is the file cut off?",
    )
}
