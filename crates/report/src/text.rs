//! A [`Report`] as text for a terminal.

use kugelblitz_judge::markup::wrapped;

use super::Report;
use super::table::{Table, facts, name, tables};

/// Columns of a terminal that text takes at most.
const WIDTH: usize = 110;

/// Returns facts, tables, and everything that was not measured.
pub fn terminal(report: &Report) -> String {
    let mut text = String::new();
    let mut add = |line: &str| {
        wrapped(line, WIDTH, "", "  ").iter().for_each(|line| text += &format!("{line}\n"));
    };
    facts(report).iter().for_each(|(what, fact)| add(&format!("{what}: {fact}")));
    for missing in &report.missing {
        add(&name(&format!("Not measured: {}: {}", missing.what, missing.why)));
    }
    let tables = tables(report);
    text + &tables
        .iter()
        .map(|table| format!("\n{}\n{}", table.title, aligned(table)))
        .collect::<String>()
}

/// Returns the lines of a table, names to the left and figures to the right.
fn aligned(table: &Table) -> String {
    let heads = [
        table.columns.iter().map(|column| &column.over).collect::<Vec<_>>(),
        table.columns.iter().map(|column| &column.name).collect(),
    ];
    let rows = table.rows.iter().map(|row| row.iter().collect());
    let lines: Vec<Vec<&String>> = heads.into_iter().chain(rows).collect();
    let length = |line: &Vec<&String>, at: usize| line[at].chars().count();
    let width = |at| lines.iter().map(|line| length(line, at)).max().unwrap_or(0);
    let widths: Vec<usize> = (0..table.columns.len()).map(width).collect();
    let cell = |(at, text): (usize, &&String)| match widths[at] {
        width if at < table.n_names => format!("{text:<width$}"),
        width => format!("{text:>width$}"),
    };
    let line = |line: &Vec<&String>| {
        let cells: Vec<String> = line.iter().enumerate().map(cell).collect();
        format!("{}\n", cells.join("  ").trim_end())
    };
    lines.iter().map(line).filter(|line| line != "\n").collect()
}
