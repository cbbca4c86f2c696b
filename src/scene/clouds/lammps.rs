//! Clouds of atoms or grains as LAMMPS dumps them: text with a line of column names.

use super::Reading;
use super::text::{Head, Lines, TextFormat};
use crate::scene::places::{Stop, quoted};

const HELP: &str = "a LAMMPS dump in text has for each step the lines ITEM: TIMESTEP, ITEM: NUMBER OF \
                    ATOMS, ITEM: BOX BOUNDS and ITEM: ATOMS with the names of columns, x, y and z \
                    among them";

pub(super) const FORMAT: TextFormat = TextFormat {
    help: HELP,
    row_help: HELP,
    empty: "the file has no ITEM: ATOMS",
    has_frames: true,
    head,
};

fn head(lines: &mut Lines, cloud: &Reading) -> Result<Option<Head>, Stop> {
    let (mut n_rows, mut bounds, mut is_begun) = (None, None, false);
    loop {
        let Some(line) = lines.text(cloud)? else {
            return match is_begun {
                true => Err(cloud.wrong("the file ends within the lines before its atoms", HELP)),
                false => Ok(None),
            };
        };
        if line.is_empty() && !is_begun {
            continue;
        }
        let wrong = |found: &str, line: &str, number: u64| {
            cloud.wrong(format!("line {number}: {:?} {found}", quoted(line)), HELP)
        };
        let Some(item) = line.strip_prefix("ITEM:").map(str::trim) else {
            return Err(wrong("stands where ITEM: is expected", &line, lines.n_read));
        };
        is_begun = true;
        if item == "NUMBER OF ATOMS" {
            let count = lines.text(cloud)?.unwrap_or_default();
            n_rows = Some(lines.n_atoms(cloud, &count)?);
        } else if let Some(kind) = item.strip_prefix("BOX BOUNDS") {
            let mut all = [[0.0; 2]; 3];
            for ends in &mut all {
                let line = lines.text(cloud)?.unwrap_or_default();
                let words = line.split_ascii_whitespace();
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let [low, high, ..] = numbers[..] else {
                    return Err(wrong("has no two ends", &line, lines.n_read));
                };
                *ends = [low, high];
            }
            let is_cuboid = !kind.contains("xy") && !kind.contains("abc");
            bounds = is_cuboid.then_some(all);
        } else if let Some(names) = item.strip_prefix("ATOMS") {
            let mut names: Vec<_> = names.split_ascii_whitespace().map(String::from).collect();
            if n_rows.is_none() || names.is_empty() {
                return Err(wrong("lacks a number of atoms, or columns", &line, lines.n_read));
            }
            let scale = scaled(cloud, &mut names, bounds)?;
            let (what, note) = ("ITEM: ATOMS".into(), Some("its box is left out"));
            return Ok(Some(Head { n_rows, names, what, separator: b' ', scale, note }));
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
