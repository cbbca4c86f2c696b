//! Prints a [`Table`] for a terminal, in Markdown, and for a page.

use maud::{Markup, html};

use kugelblitz::words::cut;

use super::figures::{plain, typeset};
use super::plot::theme::kernel_class;
use super::tables::{Cell, Emphasis, Part, Table};

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

/// Text for a terminal. Parts that do not fit stand in further blocks, each with the names.
pub fn terminal(table: &Table) -> String {
    let mut parts = table.parts.iter().map(|part| aligned(table, part));
    let Some(names) = parts.next() else { return String::new() };
    let mut blocks: Vec<Vec<String>> = Vec::new();
    for part in parts {
        let fits =
            |block: &&mut Vec<String>| length(&block[0]) + GAP.len() + length(&part[0]) <= WIDTH;
        match blocks.last_mut().filter(fits) {
            Some(block) => *block = joined(&[block.clone(), part]),
            None => blocks.push(joined(&[names.clone(), part])),
        }
    }
    let texts = blocks.iter().map(|block| with_groups(table, block));
    texts.collect::<Vec<_>>().join("\n")
}

/// The lines of a part, all of one width: its heading, the columns' names, the rows.
fn aligned(table: &Table, part: &Part) -> Vec<String> {
    let to_one_width = |lines: Vec<String>| -> Vec<String> {
        let width = lines.iter().map(|line| length(line)).max().unwrap_or(0);
        let line = |line: &String| match part.first {
            0 => format!("{line:<width$}"),
            _ => format!("{line:>width$}"),
        };
        lines.iter().map(line).collect()
    };
    let column = |(name, i): (&String, usize)| {
        let rows = table.groups.iter().flat_map(|group| &group.rows);
        let cells = rows.map(|row| shortened(&row[i].whole()));
        to_one_width([shortened(name)].into_iter().chain(cells).collect())
    };
    let columns: Vec<Vec<String>> = part.columns.iter().zip(part.first..).map(column).collect();
    to_one_width([shortened(&part.over)].into_iter().chain(joined(&columns)).collect())
}

/// Texts of as many lines, side by side.
fn joined(texts: &[Vec<String>]) -> Vec<String> {
    let n_lines = texts.first().map_or(0, Vec::len);
    let line = |i: usize| texts.iter().map(|text| text[i].as_str()).collect::<Vec<_>>().join(GAP);
    (0..n_lines).map(line).collect()
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
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let columns =
        || table.parts.iter().flat_map(|part| part.columns.iter().map(move |c| (part, c)));
    let names = columns().map(|(part, name)| match part.over.as_str() {
        "" => name.clone(),
        over => format!("{}: {name}", markdown_text(over)),
    });
    let rules = columns().map(|(part, _)| if part.first == 0 { "---" } else { "---:" });
    let head = [line(names.collect()), line(rules.map(str::to_string).collect())].concat();
    let rows = table.groups.iter().flat_map(|group| &group.rows);
    let cells = |row: &Vec<Cell>| row.iter().map(|cell| markdown_text(&cell.whole())).collect();
    head + &rows.map(|row| line(cells(row))).collect::<String>()
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
    let has_overs = table.parts.iter().any(|part| !part.over.is_empty());
    let n_names = table.parts.first().map_or(0, |part| part.columns.len());
    let n_columns: usize = table.parts.iter().map(|part| part.columns.len()).sum();
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        @for part in &table.parts {
                            @if part.over.is_empty() {
                                @for name in &part.columns {
                                    th class=(if part.first == 0 { "name" } else { "" })
                                        rowspan=(1 + usize::from(has_overs)) { (name) }
                                }
                            } @else {
                                th.over colspan=(part.columns.len()) { (with_key(&part.over)) }
                            }
                        }
                    }
                    @if has_overs {
                        tr {
                            @for part in table.parts.iter().filter(|part| !part.over.is_empty()) {
                                @for name in &part.columns { th { (name) } }
                            }
                        }
                    }
                }
                @for group in &table.groups {
                    tbody {
                        @if !group.name.is_empty() {
                            tr { th.group colspan=(n_columns) { (typeset(&group.name)) } }
                        }
                        @for row in &group.rows {
                            tr {
                                @for (i, cell) in row.iter().enumerate() {
                                    (html_cell(cell, i < n_names))
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
        let names = Part { over: String::new(), first: 0, columns: vec!["name".into()] };
        let pairs = (0..6).map(|i| Part {
            over: format!("pair {i}"),
            first: 1 + 2 * i,
            columns: vec!["x".into(); 2],
        });
        let table = Table {
            parts: [names].into_iter().chain(pairs).collect(),
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
