//! A [`Report`] in Markdown.

use kugelblitz::plain::plain_document;

use super::Report;
use super::table::{Table, facts, name, tables};

/// Returns a section for each table, then the facts about machine and settings.
pub fn markdown(report: &Report) -> String {
    let mut text: String = tables(report).iter().map(section).collect();
    text += "### Measured on\n\n";
    for (what, fact) in facts(report) {
        text += &format!("- {what}: {}\n", escaped(&fact));
    }
    for missing in &report.missing {
        let [what, why] = [&missing.what, &missing.why].map(|text| escaped(&name(text)));
        text += &format!("- Not measured: {what}: {why}\n");
    }
    plain_document(&text)
}

fn section(table: &Table) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let heads = table.columns.iter().map(|column| match column.over.as_str() {
        "" => escaped(&column.name),
        over => format!("{}: {}", escaped(over), escaped(&column.name)),
    });
    let rules = (0..table.columns.len()).map(|at| if at < table.n_names { "---" } else { "---:" });
    let rows = table.rows.iter().map(|row| line(row.iter().map(|cell| escaped(cell)).collect()));
    format!(
        "### {}\n\n{}{}{}\n{}\n\n",
        table.title,
        line(heads.collect()),
        line(rules.map(str::to_string).collect()),
        rows.collect::<String>(),
        table.note
    )
}

/// Escapes a text for Markdown.
fn escaped(text: &str) -> String {
    let escaped = |c: char| match c {
        '<' => "&lt;".to_string(),
        '&' => "&amp;".to_string(),
        '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' => format!("\\{c}"),
        _ => c.to_string(),
    };
    text.chars().map(escaped).collect()
}
