//! Prints a [`Table`] for a terminal, in Markdown, and for a page.

use std::borrow::Borrow;

use maud::{Markup, html};

use kugelblitz::words::cut;

use super::figures::{joined, plain, typeset};
use super::plot::theme::kernel_class;
use super::tables::{Cell, Column, Emphasis, Table};

/// Columns of a terminal that a table takes at most.
pub const WIDTH: usize = 110;

/// A longer cell is cut to so many characters; no figure has as many.
const CELL_WIDTH: usize = 27;

const GAP: &str = "  ";

impl Cell {
    /// `12.3 (11.9–14.0)`
    pub fn whole(&self) -> String {
        match &self.range {
            Some([min, max]) => format!("{} ({min}–{max})", self.text),
            None => self.text.clone(),
        }
    }
}

/// Text for a terminal. What does not fit stands in further blocks, each with the names.
pub fn terminal(table: &Table) -> String {
    let mut n_before = 0;
    let mut parts = table.columns.chunk_by(Column::is_beside).map(|columns| {
        let lines = |(column, i): (&Column, usize)| {
            let rows = table.groups.iter().flat_map(|group| &group.rows);
            to_one_width(column, &column.name, rows.map(|row| shortened(&row[i].whole())))
        };
        let lines: Vec<_> = columns.iter().zip(n_before..).map(lines).collect();
        n_before += columns.len();
        to_one_width(&columns[0], &columns[0].over, side_by_side(&lines))
    });
    let Some(names) = parts.next() else { return String::new() };
    let mut blocks: Vec<Vec<String>> = Vec::new();
    for part in parts {
        let fits =
            |block: &&mut Vec<String>| length(&block[0]) + GAP.len() + length(&part[0]) <= WIDTH;
        match blocks.last_mut().filter(fits) {
            Some(block) => *block = side_by_side(&[std::mem::take(block), part]),
            None => blocks.push(side_by_side(&[names.clone(), part])),
        }
    }
    joined(blocks.iter().map(|block| with_groups(table, block)), "\n")
}

/// A head and the lines below it, filled up.
fn to_one_width(
    column: &Column,
    head: &str,
    lines: impl IntoIterator<Item = String>,
) -> Vec<String> {
    let lines: Vec<String> = [shortened(head)].into_iter().chain(lines).collect();
    let width = lines.iter().map(|line| length(line)).max().unwrap_or(0);
    let line = |line: &String| {
        if column.is_name { format!("{line:<width$}") } else { format!("{line:>width$}") }
    };
    lines.iter().map(line).collect()
}

/// Texts of as many lines, side by side.
fn side_by_side(texts: &[Vec<String>]) -> Vec<String> {
    let line = |i: usize| joined(texts.iter().map(|text| text[i].as_str()), GAP);
    (0..texts[0].len()).map(line).collect()
}

/// Two lines of head, if the first is not empty, and the rows, each group under its name.
fn with_groups(table: &Table, lines: &[String]) -> String {
    let mut lines = lines.iter().map(|line| format!("{}\n", line.trim_end()));
    let mut text: String = lines.by_ref().take(2).filter(|line| line != "\n").collect();
    for group in &table.groups {
        if !group.name.is_empty() {
            text += &format!("{}\n", plain(&group.name));
        }
        text.extend(lines.by_ref().take(group.rows.len()));
    }
    text
}

fn length(text: &str) -> usize {
    text.chars().count()
}

fn shortened(text: &str) -> String {
    cut(&plain(text), CELL_WIDTH).into_owned()
}

/// A table in Markdown.
pub fn markdown(table: &Table) -> String {
    let names = table.columns.iter().map(|Column { over, name, .. }| match over.as_str() {
        "" => name.clone(),
        over => format!("{}: {name}", markdown_text(over)),
    });
    let rules = table.columns.iter().map(|column| if column.is_name { "---" } else { "---:" });
    let head = markdown_line(names) + &markdown_line(rules);
    let rows = table.groups.iter().flat_map(|group| &group.rows);
    let line = |row: &Vec<Cell>| markdown_line(row.iter().map(|cell| markdown_text(&cell.whole())));
    head + &rows.map(line).collect::<String>()
}

fn markdown_line(cells: impl Iterator<Item: Borrow<str>>) -> String {
    format!("| {} |\n", joined(cells, " | "))
}

/// Text that Markdown shows as it is.
pub fn markdown_text(text: &str) -> String {
    let escaped = |c: char| match c {
        '<' => "&lt;".to_string(),
        '&' => "&amp;".to_string(),
        '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' => format!("\\{c}"),
        _ => c.to_string(),
    };
    plain(text).chars().map(escaped).collect()
}

/// A table for a page, scrolled where it is wider.
pub fn html(table: &Table) -> Markup {
    let has_overs = table.columns.iter().any(|column| !column.over.is_empty());
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        @for part in table.columns.chunk_by(Column::is_beside) {
                            @if part[0].over.is_empty() {
                                @for Column { name, is_name, .. } in part {
                                    th class=(if *is_name { "name" } else { "" })
                                        rowspan=(1 + usize::from(has_overs)) { (name) }
                                }
                            } @else {
                                th.over colspan=(part.len()) { (with_key(&part[0].over)) }
                            }
                        }
                    }
                    @if has_overs {
                        tr {
                            @for column in table.columns.iter().filter(|column| !column.over.is_empty()) {
                                th { (column.name) }
                            }
                        }
                    }
                }
                @for group in &table.groups {
                    tbody {
                        @if !group.name.is_empty() {
                            tr { th.group colspan=(table.columns.len()) { (typeset(&group.name)) } }
                        }
                        @for row in &group.rows {
                            tr {
                                @for (column, cell) in table.columns.iter().zip(row) {
                                    (html_cell(cell, column.is_name))
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn html_cell(cell: &Cell, is_name: bool) -> Markup {
    let class = match cell.emphasis {
        _ if is_name => "name",
        Emphasis::Wrong => "some",
        Emphasis::Right => "none",
        Emphasis::Plain | Emphasis::Kernel => "",
    };
    html! {
        td class=(class) {
            @if cell.emphasis == Emphasis::Kernel { (with_key(&cell.text)) } @else { (typeset(&cell.text)) }
            @if let Some([min, max]) = &cell.range {
                span.range { " (" (typeset(min)) "–" (typeset(max)) ")" }
            }
        }
    }
}

/// A text that begins with a kernel's name, with the kernel's colour before it.
fn with_key(text: &str) -> Markup {
    let class = kernel_class(text.split(',').next().unwrap_or(text));
    html! { @if class != "other" { span.key.(class) {} } (text) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::Group;

    #[test]
    fn columns_stand_below_each_other_and_break_where_they_must() {
        let cell = |text: &str| Cell { text: text.into(), range: None, emphasis: Emphasis::Plain };
        let row = |name: &str, figure: &str| [vec![cell(name)], vec![cell(figure); 12]].concat();
        let rows = vec![row("a", "1.5"), row(&"long ".repeat(10), "123456789")];
        let names = Column { over: String::new(), name: "name".into(), is_name: true };
        let pairs = (0..12).map(|i| Column {
            over: format!("pair {}", i / 2),
            name: "x".into(),
            is_name: false,
        });
        let table = Table {
            columns: [names].into_iter().chain(pairs).collect(),
            groups: vec![Group { name: "all".into(), rows }],
        };
        let text = terminal(&table);
        assert!(text.lines().all(|line| length(line) <= WIDTH), "{text}");
        let blocks: Vec<Vec<&str>> =
            text.split("\n\n").map(|block| block.lines().collect()).collect();
        assert!(blocks.len() == 2 && blocks.iter().all(|block| block.len() == 5), "{text}");
        assert!(blocks.iter().all(|block| block[3].starts_with("a ")), "{text}");
        assert_eq!(text.matches("1.5").count(), 12);
        assert_eq!(length(blocks[0][1]), length(blocks[0][4]), "{text}");
        // What belongs together is not torn apart.
        assert_eq!((0..6).map(|i| text.matches(&format!("pair {i}")).count()).max(), Some(1));
    }
}
