//! Atoms or grains as LAMMPS dumps them: text with a line of column names.

use glam::DVec3;

use super::CloudFile;
use super::text::{Cell, Head, Lines, TextFormat};
use crate::error::Result;

const HELP: &str = "a LAMMPS dump in text has for each step the lines ITEM: TIMESTEP, ITEM: NUMBER OF ATOMS, ITEM: BOX BOUNDS \
                    and ITEM: ATOMS with the names of columns, x, y and z among them";

pub(super) const FORMAT: TextFormat = TextFormat {
    help: HELP,
    row_help: HELP,
    empty: "the file has no ITEM: ATOMS",
    is_table: false,
    head,
};

/// Box of a step: its corner, and its edges.
#[derive(Clone, Copy)]
struct BoxBounds {
    origin: DVec3,
    edges: [DVec3; 3],
    /// Whether the first edge is along x and the second in the x-y plane.
    is_restricted: bool,
}

fn head(lines: &mut Lines) -> Result<Option<Head>> {
    let (mut n_rows, mut bounds, mut is_begun) = (None, None, false);
    loop {
        let Some(line) = lines.text()? else {
            if is_begun {
                let message = "the file ends in the lines before its atoms";
                return Err(lines.source.wrong(message, HELP).into());
            }
            return Ok(None);
        };
        if line.is_empty() && !is_begun {
            continue;
        }
        let Some(item) = line.strip_prefix("ITEM:").map(str::trim) else {
            return Err(lines.wrong(&line, "expected ITEM:").into());
        };
        is_begun = true;
        if item == "NUMBER OF ATOMS" {
            let count = lines.text()?.unwrap_or_default();
            n_rows = Some(lines.n_atoms(&count)?);
        } else if let Some(kind) = item.strip_prefix("BOX BOUNDS") {
            bounds = Some(read_bounds(lines, kind)?);
        } else if let Some(names) = item.strip_prefix("ATOMS") {
            let mut names: Vec<_> = names.split_ascii_whitespace().map(String::from).collect();
            let Some(n_rows) = n_rows.filter(|_| !names.is_empty()) else {
                return Err(lines
                    .wrong(&line, "expected a number of atoms before it, and columns")
                    .into());
            };
            let cell = coordinates(lines.source, &mut names, bounds)?;
            return Ok(Some(Head {
                n_rows,
                names,
                what: "ITEM: ATOMS".into(),
                separator: b' ',
                has_places: false,
                header_line: None,
                cell,
                notes: vec!["the box is not drawn".into()],
            }));
        } else {
            // The time, the units: a line.
            lines.next()?;
        }
    }
}

/// Reads the three lines of a box. LAMMPS' manual has the formulas: "Howto triclinic" for restricted boxes, whose lines have the
/// bounds of the tilted box and the tilt factors xy, xz, yz; "dump" for general ones (`abc origin`), whose lines have the edges a,
/// b, c and the coordinates of the origin.
fn read_bounds(lines: &mut Lines, kind: &str) -> Result<BoxBounds> {
    let is_general = kind.contains("abc");
    let is_tilted = kind.contains("xy");
    let n = if is_general {
        4
    } else if is_tilted {
        3
    } else {
        2
    };
    let mut rows = [[0.0; 4]; 3];
    for row in &mut rows {
        let line = lines.text()?.unwrap_or_default();
        let words = line.split_ascii_whitespace();
        let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
        let Some(numbers) = numbers.get(..n) else {
            return Err(lines.wrong(&line, &format!("expected {n} numbers of the box")).into());
        };
        row[..n].copy_from_slice(numbers);
    }
    if is_general {
        let edges = rows.map(|[x, y, z, _]| DVec3::new(x, y, z));
        let origin = DVec3::from_array(rows.map(|[.., origin]| origin));
        return Ok(BoxBounds { origin, edges, is_restricted: false });
    }
    let [[x_low, x_high, xy, _], [y_low, y_high, xz, _], [z_low, z_high, yz, _]] = rows;
    let [least, most] = [f64::min as fn(f64, f64) -> f64, f64::max]
        .map(|choose| choose(choose(0.0, xy), choose(xz, xy + xz)));
    let (x_low, x_high) = (x_low - least, x_high - most);
    let (y_low, y_high) = (y_low - yz.min(0.0), y_high - yz.max(0.0));
    Ok(BoxBounds {
        origin: DVec3::new(x_low, y_low, z_low),
        edges: [
            DVec3::X * (x_high - x_low),
            DVec3::new(xy, y_high - y_low, 0.0),
            DVec3::new(xz, yz, z_high - z_low),
        ],
        is_restricted: true,
    })
}

/// Renames the columns of each coordinate to x, y and z: `x`, else `xu` (unwrapped), else `xs` or `xsu` (relative to the box),
/// and returns the box if some are relative to it.
fn coordinates(
    source: &CloudFile,
    names: &mut [String],
    bounds: Option<BoxBounds>,
) -> Result<Option<Cell>> {
    let mut columns = [None; 3];
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let place = |ending: &str| {
            let name = format!("{name}{ending}");
            names.iter().position(|other| *other == name)
        };
        if place("").is_some() {
            continue;
        }
        let scaled = || place("s").or_else(|| place("su"));
        if let Some(column) = place("u").or_else(scaled) {
            columns[axis] = scaled().filter(|scaled| *scaled == column);
            names[column] = name.into();
        }
    }
    if columns == [None; 3] {
        return Ok(None);
    }
    let is_mixed = columns.contains(&None);
    match bounds {
        Some(BoxBounds { origin, edges, is_restricted }) if is_restricted || !is_mixed => {
            Ok(Some(Cell { origin, edges, columns }))
        }
        Some(_) => Err(source
            .wrong(
                "scaled and unscaled coordinates together are not supported in a general triclinic box",
                "dump x y z, or xs ys zs",
            )
            .into()),
        None => Err(source
            .wrong("scaled coordinates (xs ys zs) need ITEM: BOX BOUNDS, which is missing", "dump x y z instead")
            .into()),
    }
}
