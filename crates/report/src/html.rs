//! A [`Report`] as one HTML page without scripts and other files.

use kugelblitz_judge::markup::document;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::chart::svg;
use super::plots::{Chart, charts};
use super::table::{Table, facts, tables};
use super::{Report, theme};

/// Style of the page, with the colours of the plots.
const STYLE: &str = include_str!("page.css");

/// The page may load only its own style.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

/// Returns the page.
pub fn html(report: &Report) -> String {
    let charts = charts(report);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { "Kugelblitz: speed against error" }
                link rel="icon" href="data:,";
                style { (PreEscaped(theme::css_variables())) (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Kugelblitz: speed against error" }
                dl { @for (what, fact) in facts(report) { dt { (what) } dd { (fact) } } }
                main { @for table in &tables(report) { (section(table, &charts)) } }
                @if !report.missing.is_empty() {
                    h2 { "Not measured" }
                    ul { @for missing in &report.missing { li { (missing.what) ": " (missing.why) } } }
                }
            }
        }
    };
    document(&page.into_string())
}

/// Returns a table below its charts.
fn section(table: &Table, charts: &[Chart]) -> Markup {
    let class = |at: usize| (at < table.n_names).then_some("name");
    html! {
        section {
            h2 { (table.title) }
            p { (table.note) }
            @for chart in charts.iter().filter(|chart| chart.section == table.title) {
                div.wide { (PreEscaped(svg(&[chart]))) }
            }
            div.wide {
                table {
                    thead {
                        tr {
                            @for (at, column) in table.columns.iter().enumerate() {
                                th class=[class(at)] {
                                    @if !column.over.is_empty() { (column.over) br; }
                                    (column.name)
                                }
                            }
                        }
                    }
                    tbody {
                        @for row in &table.rows {
                            tr { @for (at, cell) in row.iter().enumerate() { td class=[class(at)] { (cell) } } }
                        }
                    }
                }
            }
        }
    }
}
