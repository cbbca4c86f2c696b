//! Prints a [`Table`] for a terminal, in Markdown, and for a page.

use maud::{Markup, html};

use super::figures::{plain, typeset};
use super::plot::theme::kernel_class;
use super::tables::{Cell, Column, Emphasis, Table};

/// Columns of a terminal that a table takes at most.
pub const WIDTH: usize = 110;

/// A cell is cut to this many characters; no figure has as many.
const CELL_WIDTH: usize = 28;

const GAP: &str = "  ";

/// Neighbouring columns under the same heading.
struct Part<'a> {
    over: &'a str,
    columns: Vec<usize>,
}

fn parts(columns: &[Column]) -> Vec<Part<'_>> {
    let mut parts: Vec<Part> = Vec::new();
    for (i, column) in columns.iter().enumerate() {
        match parts.last_mut() {
            Some(part) if part.over == column.over && !part.over.is_empty() => part.columns.push(i),
            _ => parts.push(Part { over: &column.over, columns: vec![i] }),
        }
    }
    parts
}

impl Cell {
    /// `12.3 (11.9–14.0)`
    fn whole(&self) -> String {
        match &self.range {
            Some([min, max]) => format!("{} ({min}–{max})", self.text),
            None => self.text.clone(),
        }
    }
}

/// Text for a terminal. Columns that do not fit stand in further blocks, each with the names.
pub fn terminal(table: &Table) -> String {
    let all_rows = || table.groups.iter().flat_map(|group| &group.rows);
    let mut widths: Vec<usize> = (0..table.columns.len())
        .map(|i| {
            let cells = all_rows().map(|row| length(&shortened(&row[i].whole())));
            cells.chain([length(&shortened(&table.columns[i].name))]).max().unwrap_or(0)
        })
        .collect();
    let parts = parts(&table.columns);
    for part in &parts {
        let missing = length(&shortened(part.over)).saturating_sub(part_width(part, &widths));
        widths[part.columns[part.columns.len() - 1]] += missing;
    }
    let (names, figures) = parts.split_at(table.n_names.min(parts.len()));
    let width = |parts: &[&Part]| -> usize {
        parts.iter().map(|part| part_width(part, &widths) + GAP.len()).sum()
    };
    let names: Vec<&Part> = names.iter().collect();
    let (mut blocks, mut block) = (Vec::new(), names.clone());
    for part in figures {
        if block.len() > names.len() && width(&block) + part_width(part, &widths) > WIDTH {
            blocks.push(std::mem::replace(&mut block, names.clone()));
        }
        block.push(part);
    }
    blocks.push(block);
    let texts = blocks.iter().map(|block| terminal_block(table, block, &widths));
    texts.collect::<Vec<_>>().join("\n")
}

fn terminal_block(table: &Table, block: &[&Part], widths: &[usize]) -> String {
    let columns: Vec<usize> = block.iter().flat_map(|part| part.columns.clone()).collect();
    let line = |texts: Vec<String>| format!("{}\n", texts.join(GAP).trim_end());
    let padded = |i: usize, text: &str| {
        let text = shortened(text);
        let blank = " ".repeat(widths[i].saturating_sub(length(&text)));
        if i < table.n_names { text + &blank } else { blank + &text }
    };
    let mut text = String::new();
    if block.iter().any(|part| !part.over.is_empty()) {
        let over = |part: &&Part| {
            let over = shortened(part.over);
            let blank = " ".repeat(part_width(part, widths).saturating_sub(length(&over)));
            if part.columns[0] < table.n_names { over + &blank } else { blank + &over }
        };
        text += &line(block.iter().map(over).collect());
    }
    text += &line(columns.iter().map(|&i| padded(i, &table.columns[i].name)).collect());
    for group in &table.groups {
        if !group.name.is_empty() {
            text += &format!("{}\n", plain(&group.name));
        }
        for row in &group.rows {
            text += &line(columns.iter().map(|&i| padded(i, &row[i].whole())).collect());
        }
    }
    text
}

fn part_width(part: &Part, widths: &[usize]) -> usize {
    let of_columns: usize = part.columns.iter().map(|&i| widths[i]).sum();
    of_columns + GAP.len() * (part.columns.len() - 1)
}

fn length(text: &str) -> usize {
    text.chars().count()
}

fn shortened(text: &str) -> String {
    let text = plain(text);
    match length(&text) > CELL_WIDTH {
        true => text.chars().take(CELL_WIDTH - 1).chain(['…']).collect(),
        false => text,
    }
}

/// A table in Markdown.
pub fn markdown(table: &Table) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let names = table.columns.iter().map(|column| match column.over.as_str() {
        "" => column.name.clone(),
        over => format!("{over}: {}", column.name),
    });
    let rules = (0..table.columns.len()).map(|i| if i < table.n_names { "---" } else { "---:" });
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
    let parts = parts(&table.columns);
    let has_overs = parts.iter().any(|part| !part.over.is_empty());
    let class = |i: usize| if i < table.n_names { "name" } else { "" };
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        @for part in &parts {
                            @let first = part.columns[0];
                            @if part.over.is_empty() {
                                th class=(class(first)) rowspan=(1 + usize::from(has_overs)) {
                                    (table.columns[first].name)
                                }
                            } @else {
                                th.over colspan=(part.columns.len()) { (with_key(part.over)) }
                            }
                        }
                    }
                    @if has_overs {
                        tr {
                            @for column in table.columns.iter().filter(|c| !c.over.is_empty()) {
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
                                @for (i, cell) in row.iter().enumerate() {
                                    (html_cell(cell, i < table.n_names))
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
    use crate::report::tables::Group;

    #[test]
    fn columns_stand_below_each_other_and_break_where_they_must() {
        let cell = |text: &str| Cell { text: text.into(), range: None, emphasis: Emphasis::Plain };
        let row = |name: &str, figure: &str| [vec![cell(name)], vec![cell(figure); 12]].concat();
        let rows = vec![row("a", "1.5"), row(&"long ".repeat(10), "123456789")];
        let pairs = (0..12).map(|i| Column { over: format!("pair {}", i / 2), name: "x".into() });
        let names = Column { over: String::new(), name: "name".into() };
        let table = Table {
            n_names: 1,
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
