//! A [`Report`] as text: for a terminal, and its summary in Markdown.

use std::fmt::Write;

use super::answer::{answer, price};
use super::figures::{count, list, plain};
use super::print::{self, WIDTH, markdown_text};
use super::summary::Cast;
use super::tables::{self, Table};
use super::{AdapterEvidence, Baseline, Report};
use crate::plain::plain_document;

/// The whole report but the pictures and each scene's own figures, at most 110 columns wide.
pub fn terminal(report: &Report) -> String {
    let cast = Cast::of(report);
    let mut parts = vec![evidence(report), wrapped(&answer(report), "")];
    parts.extend(price(report).map(|price| wrapped(&price, "")));
    parts.extend(report.noise.warning().map(|warning| wrapped(&warning, "")));
    let words = report.baseline.iter().flat_map(Baseline::in_words);
    parts.extend(words.map(|words| wrapped(&plain(&words), "")));
    let mut add = |title: &str, table: Table| {
        if !table.is_empty() {
            parts.push(wrapped(title, "  ") + &print::terminal(&table));
        }
    };
    if let Some(baseline) = &report.baseline {
        add("Changes beyond noise", tables::changes(baseline, &cast));
        add("Wrong ids that changed", tables::changed_ids(baseline, &cast));
    }
    add("How wrong", tables::class_errors(report, &cast));
    add("How fast", tables::class_costs(report, &cast));
    add("Many spheres", tables::clouds(report, &cast));
    add("Light: wrong shadows, and pixels with wrong bytes", tables::light(report, &cast));
    let title = "Scenes: share of wrong ids, and nanoseconds a ray (ids)";
    add(title, tables::overview(report, &cast));
    for sweep in &report.sweeps {
        let title = format!("Sweep “{}”: {}; x: {}", sweep.name, sweep.title, sweep.x_label);
        add(&title, tables::sweep(sweep, &cast));
    }
    if !report.missing.is_empty() {
        let lines = report.missing.iter().map(|missing| {
            wrapped(&format!("- {}: {}", plain(&missing.what), plain(&missing.why)), "  ")
        });
        parts.push(format!("Not measured\n{}", lines.collect::<String>()));
    }
    plain_document(&parts.join("\n"))
}

/// The classes in a short table, light in another, many spheres in a third, each with what it was measured
/// on; then what changed since an earlier report.
pub fn markdown(report: &Report) -> String {
    let cast = Cast::of(report);
    let measured = measured_on(report);
    let [width, height] = report.effort.size;
    let classes = print::markdown(&tables::summary(report, &cast));
    let mut text = format!("{classes}\nMeasured at {width} × {height} {measured}\n");
    if let Some(warning) = report.noise.warning() {
        let _ = write!(text, "\n{warning}\n");
    }
    if !report.light.is_empty() {
        let [width, height] = super::LIGHT_SIZE;
        let light = print::markdown(&tables::light(report, &cast));
        let _ = write!(text, "\n{light}\nMeasured at {width} × {height} {measured}\n");
    }
    if !report.clouds.is_empty() {
        let [width, height] = super::CLOUD_SIZE;
        let clouds = print::markdown(&tables::clouds(report, &cast));
        let _ = write!(text, "\n{clouds}\nMeasured at {width} × {height} {measured}\n");
    }
    if let Some(baseline) = &report.baseline {
        let _ = write!(text, "\n{}\n", markdown_text(&baseline.in_words().join(" ")));
        for table in [tables::changes(baseline, &cast), tables::changed_ids(baseline, &cast)] {
            if !table.is_empty() {
                let _ = write!(text, "\n{}", print::markdown(&table));
            }
        }
    }
    plain_document(&text)
}

fn measured_on(Report { evidence, .. }: &Report) -> String {
    let adapter = |AdapterEvidence { facts, .. }: &AdapterEvidence| {
        format!("{} ({})", facts.name, facts.driver)
    };
    let host = format!("{}, {}", evidence.host_cpu, count(evidence.n_cores, "core"));
    let machines: Vec<String> =
        evidence.adapters.iter().map(adapter).chain([host]).map(|m| markdown_text(&m)).collect();
    let commit = evidence.commit.as_ref().map(|commit| format!(", commit {commit}"));
    format!(
        "on {} by Kugelblitz {}{}, {}.",
        list(&machines),
        evidence.version,
        markdown_text(&commit.unwrap_or_default()),
        evidence.date
    )
}

fn evidence(report: &Report) -> String {
    let Report { evidence, effort, .. } = report;
    let [width, height] = effort.size;
    let facts = evidence.named_lines();
    let facts = facts.iter().map(|(what, fact)| wrapped(&plain(&format!("{what}: {fact}")), "  "));
    let effort = format!(
        "{width} × {height} pixels; up to {} of each picture against exact arithmetic (seed {}); \
         {} of {} after a first picture",
        effort.samples,
        effort.seed,
        count(effort.rounds, "round"),
        count(effort.runs, "run"),
    );
    facts.chain([wrapped(&effort, "  ")]).collect()
}

/// Lines of at most a terminal's width; all but the first begin with `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let leading = text.len() - text.trim_start().len();
    let mut lines = vec![text[..leading].to_string()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        let line = &mut lines[last];
        let is_empty = line.trim().is_empty();
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines.push(format!("{indent}{word}"));
        } else {
            *line += if is_empty { "" } else { " " };
            *line += word;
        }
    }
    lines.iter().map(|line| format!("{line}\n")).collect()
}
