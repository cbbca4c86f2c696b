//! Clouds of atoms or grains as LAMMPS dumps them: text with a line of column names.

use super::CloudFile;
use super::text::{Head, Lines, TextFormat};
use crate::error::Result;

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

fn head(lines: &mut Lines) -> Result<Option<Head>> {
    let (mut n_rows, mut bounds, mut is_begun) = (None, None, false);
    loop {
        let Some(line) = lines.text()? else {
            if is_begun {
                let found = "the file ends within the lines before its atoms";
                return Err(lines.source.wrong(found, HELP));
            }
            return Ok(None);
        };
        if line.is_empty() && !is_begun {
            continue;
        }
        let Some(item) = line.strip_prefix("ITEM:").map(str::trim) else {
            return Err(lines.wrong(&line, "stands where ITEM: is expected"));
        };
        is_begun = true;
        if item == "NUMBER OF ATOMS" {
            let count = lines.text()?.unwrap_or_default();
            n_rows = Some(lines.n_atoms(&count)?);
        } else if let Some(kind) = item.strip_prefix("BOX BOUNDS") {
            let mut all = [[0.0; 2]; 3];
            for ends in &mut all {
                let line = lines.text()?.unwrap_or_default();
                let words = line.split_ascii_whitespace();
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let [low, high, ..] = numbers[..] else {
                    return Err(lines.wrong(&line, "has no two ends"));
                };
                *ends = [low, high];
            }
            let is_cuboid = !kind.contains("xy") && !kind.contains("abc");
            bounds = is_cuboid.then_some(all);
        } else if let Some(names) = item.strip_prefix("ATOMS") {
            let mut names: Vec<_> = names.split_ascii_whitespace().map(String::from).collect();
            let Some(n_rows) = n_rows.filter(|_| !names.is_empty()) else {
                return Err(lines.wrong(&line, "lacks a number of atoms, or columns"));
            };
            let scaled = scaled(lines.source, &mut names, bounds)?;
            let (what, note) = ("ITEM: ATOMS".into(), Some("its box is left out"));
            return Ok(Some(Head { n_rows, names, what, separator: b' ', scaled, note }));
        } else {
            // The time, the units: a line.
            lines.next()?;
        }
    }
}

/// Calls scaled coordinates `x`, `y` and `z` where there are no others, and tells what they are scaled by.
fn scaled(
    source: &CloudFile,
    names: &mut [String],
    bounds: Option<[[f64; 2]; 3]>,
) -> Result<Vec<(usize, [f64; 2])>> {
    let place = |name: &str| names.iter().position(|other| other == name);
    let find = |three: [&str; 3]| -> Option<Vec<usize>> { three.into_iter().map(place).collect() };
    let found = find(["xs", "ys", "zs"]).or_else(|| find(["xsu", "ysu", "zsu"]));
    let is_there = |name: &&str| place(name).is_some();
    let Some(columns) = found.filter(|_| !["x", "xu"].iter().any(is_there)) else {
        return Ok(Vec::new());
    };
    let Some(bounds) = bounds else {
        return Err(source.wrong(
            "its coordinates are scaled by a box that is no cuboid",
            "dump x y z, or xu yu zu, in place of xs ys zs",
        ));
    };
    for (&column, name) in columns.iter().zip(["x", "y", "z"]) {
        names[column] = name.into();
    }
    Ok(columns.into_iter().zip(bounds).collect())
}
