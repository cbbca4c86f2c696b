//! A [`Report`] as text: for a terminal, and its summary in Markdown.

use kugelblitz::plain::plain_document;
use kugelblitz_judge::markup;

use super::answer::{answer, price};
use super::environment::program;
use super::figures::{count, list, plain};
use super::print::{self, WIDTH, markdown_text};
use super::tables::{self, Table};
use super::{AdapterArithmetic, Baseline, CLOUD_SIZE, LIGHT_SIZE, Report, SWEEPS, Settings};

/// The whole report but the pictures and each scene's own figures, at most 110 columns wide.
pub fn terminal(report: &Report) -> String {
    let mut words = vec![answer(report)];
    words.extend(price(report));
    words.extend(report.noise.warning());
    let since = report.baseline.iter().flat_map(Baseline::in_words);
    words.extend(since.map(|words| plain(&words)));
    let mut parts = vec![environment(report)];
    parts.extend(words.iter().map(|words| wrapped(words, "")));
    let mut add = |title: &str, table: Table| {
        if !table.is_empty() {
            parts.push(wrapped(title, "  ") + &print::terminal(&table));
        }
    };
    if let Some(baseline) = &report.baseline {
        tables::since(baseline, report).into_iter().for_each(|(title, table)| add(title, table));
    }
    add("How wrong", tables::class_errors(report));
    add("How fast", tables::class_costs(report));
    add("Many spheres", tables::clouds(report));
    add("Light: wrong shadows, and pixels with wrong bytes", tables::light(report));
    let title = "Scenes: share of wrong ids, and nanoseconds a ray (ids)";
    add(title, tables::overview(report));
    for sweep in &SWEEPS {
        let title = format!("Sweep “{}”: {}; x: {}", sweep.name, sweep.title, sweep.x_label);
        add(&title, tables::sweep(report, sweep));
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
    let measured = measured_on(report);
    let mut text = String::new();
    for (table, [width, height]) in [
        (tables::summary(report), report.settings.size),
        (tables::light(report), LIGHT_SIZE),
        (tables::clouds(report), CLOUD_SIZE),
    ] {
        if !table.is_empty() {
            let table = print::markdown(&table);
            text += &format!("\n{table}\nMeasured at {width} × {height} {measured}\n");
        }
    }
    if let Some(warning) = report.noise.warning() {
        text += &format!("\n{warning}\n");
    }
    if let Some(baseline) = &report.baseline {
        text += &format!("\n{}\n", markdown_text(&baseline.in_words().join(" ")));
        for (_, table) in tables::since(baseline, report) {
            if !table.is_empty() {
                text += &format!("\n{}", print::markdown(&table));
            }
        }
    }
    plain_document(text.trim_start())
}

fn measured_on(Report { environment, .. }: &Report) -> String {
    let adapter = |AdapterArithmetic { facts, .. }: &AdapterArithmetic| {
        format!("{} ({})", facts.name, facts.driver)
    };
    let host = format!("{}, {}", environment.host_cpu, count(environment.n_cores, "core"));
    let machines: Vec<String> =
        environment.adapters.iter().map(adapter).chain([host]).map(|m| markdown_text(&m)).collect();
    let program = program(&environment.version, environment.commit.as_deref());
    format!("on {} by {}, {}.", list(&machines), markdown_text(&program), environment.date)
}

fn environment(report: &Report) -> String {
    let Settings { size: [width, height], samples, seed, rounds, runs, .. } = report.settings;
    let facts = report.environment.named_lines();
    let facts = facts.iter().map(|(what, fact)| wrapped(&plain(&format!("{what}: {fact}")), "  "));
    let settings = format!(
        "{width} × {height} pixels; up to {} of each picture against exact arithmetic (seed {}); \
         {} of {} after a first picture",
        samples,
        seed,
        count(rounds, "round"),
        count(runs, "run"),
    );
    facts.chain([wrapped(&settings, "  ")]).collect()
}

/// Lines of at most a terminal's width; all but the first begin with `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let lines = markup::wrapped(text, WIDTH, "", indent);
    lines.iter().map(|line| format!("{line}\n")).collect()
}
