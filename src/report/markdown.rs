//! The summary of a [`Report`] in Markdown.

use std::fmt::Write;

use super::Report;
use super::figures::{count, list, plain, plain_document, spread, t_p999, wrong};
use super::summary::Cast;

/// The classes in a short table, with what they were measured on.
pub fn table(report: &Report) -> String {
    let cast = Cast::of(report);
    let mut text = String::from(
        "| scenes | kernel | device | rays with a wrong object | error of `t`, 99.9 %, ulp | ns a \
         ray (least–most) |\n| --- | --- | --- | ---: | ---: | ---: |\n",
    );
    for row in &report.classes {
        let cells = [
            row.class.name().to_string(),
            markdown_text(&row.contestant.kernel),
            markdown_text(cast.short(&row.contestant.device)),
            wrong(&row.errors),
            t_p999(&row.errors),
            spread(&row.trace_ns_per_ray),
        ];
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    let Report { evidence, effort, .. } = report;
    let drivers: Vec<String> = evidence
        .adapters
        .iter()
        .map(|adapter| {
            let facts = &adapter.facts;
            markdown_text(&format!("{} ({})", facts.name, facts.driver))
        })
        .chain([markdown_text(&format!(
            "{}, {}",
            evidence.host_cpu,
            count(evidence.n_cores, "core")
        ))])
        .collect();
    let [width, height] = effort.size;
    let commit = evidence.commit.as_ref().map(|commit| format!(", commit {commit}"));
    let _ = writeln!(
        text,
        "\nMeasured at {width} × {height} on {} by Kugelblitz {}{}, {}.",
        list(&drivers),
        evidence.version,
        markdown_text(&commit.unwrap_or_default()),
        evidence.date
    );
    plain_document(&text)
}

/// Text that Markdown shows as it is.
fn markdown_text(text: &str) -> String {
    let escaped = |c: char| match c {
        '<' => "&lt;".to_string(),
        '&' => "&amp;".to_string(),
        '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' => format!("\\{c}"),
        _ => c.to_string(),
    };
    plain(text).chars().map(escaped).collect()
}
