//! A [`Report`] as tables for a terminal.

use std::fmt::Write;

use super::answer::{answer, price};
use super::figures::{
    NONE, count, distribution, figure, list, percent, plain, plain_document, quantity, spread,
    stages, t_p999, wrong,
};
use super::grid::Grid;
use super::summary::{Cast, Line, classes, lines, surface_ns_per_ray, xs};
use super::{Class, Errors, PeerResult, Report, SceneResult, Sweep, SweepPoint};

/// The whole report but the pictures, at most 110 columns wide.
pub fn table(report: &Report) -> String {
    let cast = Cast::of(report);
    let mut parts = vec![evidence(report), wrapped(&answer(report), "")];
    parts.extend(price(report).map(|price| wrapped(&price, "")));
    for class in classes(report) {
        parts.push(class_errors(report, &cast, class));
        parts.push(class_costs(report, &cast, class));
    }
    if !report.scenes.is_empty() {
        parts.push(scenes(&report.scenes, &cast));
    }
    for sweep in report.sweeps.iter().filter(|sweep| !sweep.series.is_empty()) {
        parts.push(sweep_tables(sweep, &cast));
    }
    if !report.peers.is_empty() {
        parts.push(peers(&report.peers));
    }
    if !report.missing.is_empty() {
        let lines = report.missing.iter().map(|missing| {
            wrapped(&format!("- {}: {}", plain(&missing.what), plain(&missing.why)), "  ")
        });
        parts.push(format!("Not measured\n{}", lines.collect::<String>()));
    }
    plain_document(&parts.join("\n"))
}

fn evidence(report: &Report) -> String {
    let Report { evidence, effort, .. } = report;
    let [width, height] = effort.size;
    let commit = evidence.commit.as_ref().map(|commit| format!(", commit {commit}"));
    let mut text = format!(
        "Kugelblitz {}{}, {}: speed against error\n",
        evidence.version,
        plain(&commit.unwrap_or_default()),
        evidence.date
    );
    for adapter in &evidence.adapters {
        let facts = &adapter.facts;
        let line = format!("  {} ({}): {}", facts.name, facts.driver, facts.kind);
        text += &wrapped(&plain(&line), "    ");
        let _ = writeln!(text, "    f32: {}", adapter.arithmetic_f32);
        match &adapter.arithmetic_f64 {
            Some(arithmetic) => {
                let _ = writeln!(text, "    f64: {arithmetic}");
            }
            None => text += "    f64: none\n",
        }
    }
    let host = format!(
        "  CPU: {}, {}, {}",
        evidence.host_cpu,
        count(evidence.n_cores, "core"),
        evidence.system
    );
    text += &wrapped(&plain(&host), "    ");
    let effort = format!(
        "  {width} × {height} pixels; up to {} of each picture against exact arithmetic (seed {}); \
         {} of {} after a first picture",
        effort.samples,
        effort.seed,
        count(effort.rounds, "round"),
        count(effort.runs, "run"),
    );
    text += &wrapped(&effort, "  ");
    text
}

/// Lines of at most a terminal's width; all but the first begin with `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let leading = text.len() - text.trim_start().len();
    let mut lines = vec![text[..leading].to_string()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        let line = &mut lines[last];
        let is_empty = line.trim().is_empty();
        if !is_empty && line.chars().count() + 1 + word.chars().count() > super::grid::WIDTH {
            lines.push(format!("{indent}{word}"));
        } else {
            *line += if is_empty { "" } else { " " };
            *line += word;
        }
    }
    lines.iter().map(|line| format!("{line}\n")).collect()
}

fn owned<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_string).to_vec()
}

fn class_rows(report: &Report, class: Class) -> impl Iterator<Item = &super::ClassResult> {
    report.classes.iter().filter(move |row| row.class == class)
}

fn class_errors(report: &Report, cast: &Cast, class: Class) -> String {
    let first = class_rows(report, class).next();
    let title = format!(
        "{}: errors ({}, {} rays)\n",
        capital(class.name()),
        count(first.map_or(0, |row| row.n_scenes), "scene"),
        first.map_or(0, |row| row.errors.rays)
    );
    let rows = class_rows(report, class).map(|row| {
        let errors = &row.errors;
        let [median, p999, max] = distribution(errors.t_ulp.as_ref());
        let [_, _, normal] = distribution(errors.normal_degrees.as_ref());
        let mut cells =
            vec![row.contestant.kernel.clone(), cast.short(&row.contestant.device).to_string()];
        cells.push(wrong(errors));
        cells.extend(fault_counts(errors));
        cells.extend([median, p999, max, normal]);
        cells
    });
    let head = vec![
        owned(["", "", "wrong", "false", "false", "wrong", "t error,", "ulp", "", "normal"]),
        owned([
            "kernel", "device", "ids", "hits", "misses", "object", "median", "99.9 %", "max",
            "max, °",
        ]),
    ];
    title + &Grid { head, n_names: 2, rows: rows.collect() }.text()
}

fn fault_counts(errors: &Errors) -> [String; 3] {
    [errors.false_hits, errors.false_misses, errors.wrong_object].map(|n| n.to_string())
}

fn class_costs(report: &Report, cast: &Cast, class: Class) -> String {
    let title = format!(
        "{}: nanoseconds a ray, median (least–most), and who decided\n",
        capital(class.name())
    );
    let rows = class_rows(report, class).map(|row| {
        let mut cells =
            vec![row.contestant.kernel.clone(), cast.short(&row.contestant.device).to_string()];
        let surface = surface_ns_per_ray(report, row);
        cells.push(spread(&row.trace_ns_per_ray));
        cells.push(surface.as_ref().map_or(NONE.to_string(), spread));
        cells.extend(stages(&row.errors));
        cells
    });
    let head =
        vec![owned(["kernel", "device", "ids", "with t and normals", "f32", "f64", "exact"])];
    title + &Grid { head, n_names: 2, rows: rows.collect() }.text()
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map(|first| first.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

fn scenes(scenes: &[SceneResult], cast: &Cast) -> String {
    let mut head = vec![owned(["", ""]), owned(["scene", "device"])];
    for kernel in &cast.kernels {
        head[0].extend([String::new(), kernel.to_string()]);
        head[1].extend(owned(["wrong", "ns/ray"]));
    }
    let mut rows = Vec::new();
    for scene in scenes {
        for device in &cast.devices {
            let mut cells = vec![scene.name.clone(), cast.short(device).to_string()];
            for kernel in &cast.kernels {
                let row = scene.rows.iter().find(|row| {
                    row.contestant.kernel == **kernel && row.contestant.device == **device
                });
                cells.extend(match row {
                    Some(row) => {
                        [short_share(&row.errors), figure(row.cost.trace_ns_per_ray.median)]
                    }
                    None => [NONE.to_string(), NONE.to_string()],
                });
            }
            if cells[2..].iter().any(|cell| cell != NONE) {
                rows.push(cells);
            }
        }
    }
    let title = "Scenes: share of wrong ids, and nanoseconds a ray (ids)\n";
    title.to_string() + &Grid { head, n_names: 2, rows }.text()
}

/// The share of wrong ids, `0` for none.
fn short_share(errors: &Errors) -> String {
    match (errors.rays, errors.wrong_ids()) {
        (0, _) => NONE.to_string(),
        (_, 0) => "0".to_string(),
        (rays, wrong) => percent(wrong, rays),
    }
}

fn sweep_tables(sweep: &Sweep, cast: &Cast) -> String {
    let lines = lines(sweep);
    let all_devices: Vec<String> =
        cast.devices.iter().map(|device| cast.short(device).to_string()).collect();
    let is_shared = lines.iter().all(|line| line.devices(cast) == all_devices);
    let note = match is_shared && all_devices.len() > 1 {
        true => format!(" (the same to the last bit on {})", list(&all_devices)),
        false => String::new(),
    };
    let grid = |cell: fn(&SweepPoint) -> Option<String>| {
        sweep_grid(sweep, &lines, |line| (!is_shared).then(|| line.devices(cast)), cell)
    };
    let has = |test: fn(&SweepPoint) -> bool| {
        sweep.series.iter().flat_map(|series| &series.points).any(test)
    };
    let mut text = wrapped(&format!("Sweep “{}”: {}", sweep.name, sweep.title), "  ");
    text += &wrapped(&format!("x: {}", sweep.x_label), "  ");
    if has(|point| point.errors.is_some()) {
        let _ = writeln!(text, "Share of wrong ids{note}");
        text += &grid(|point| point.errors.as_ref().map(short_share));
        let _ = writeln!(text, "Error of t, 99.9 %, ulp{note}");
        text += &grid(|point| point.errors.as_ref().map(t_p999));
    }
    if has(|point| point.trace_ns_per_ray.is_some()) {
        text += "Nanoseconds a ray (ids)\n";
        text += &grid(|point| point.trace_ns_per_ray.as_ref().map(|time| figure(time.median)));
    }
    text
}

fn sweep_grid(
    sweep: &Sweep,
    lines: &[Line],
    devices: impl Fn(&Line) -> Option<Vec<String>>,
    cell: fn(&SweepPoint) -> Option<String>,
) -> String {
    let kernels = lines.iter().map(|line| line.series.contestant.kernel.clone());
    let mut head = vec![["x".to_string()].into_iter().chain(kernels).collect::<Vec<_>>()];
    let devices: Vec<String> =
        lines.iter().filter_map(|line| Some(devices(line)?.join(" = "))).collect();
    if !devices.is_empty() {
        head.push([String::new()].into_iter().chain(devices).collect());
    }
    let rows = xs(sweep).into_iter().map(|x| {
        let mut cells = vec![quantity(x)];
        cells.extend(lines.iter().map(|line| {
            let point = line.series.points.iter().find(|point| point.x == x);
            point.and_then(cell).unwrap_or(NONE.to_string())
        }));
        cells
    });
    Grid { head, n_names: 1, rows: rows.collect() }.text()
}

fn peers(peers: &[PeerResult]) -> String {
    let head = vec![
        owned(["", "", "", "wrong", "false", "false", "wrong", "", "process,"]),
        owned(["peer", "scene", "threads", "ids", "hits", "misses", "object", "ns/ray", "ms"]),
    ];
    let rows = peers.iter().map(|result| {
        let mut cells = vec![result.peer.clone(), result.scene.clone()];
        cells.extend([result.n_threads.to_string(), wrong(&result.errors)]);
        cells.extend(fault_counts(&result.errors));
        let time = result.trace_ns_per_ray.map(|time| figure(time.median));
        cells.push(time.unwrap_or(NONE.to_string()));
        cells.push(figure(result.process_ms.median));
        cells
    });
    let title = "Other renderers: nanoseconds a ray by their own clocks, and the whole process";
    format!("{title}\n{}", Grid { head, n_names: 2, rows: rows.collect() }.text())
}
