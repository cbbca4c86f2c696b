//! Time against error: each kernel on each device as a point, one a class of scenes.

use super::{Chart, Panel, Point, is_open, ns_per_ray, wrong_percent};
use crate::figures::{count, typeset};
use crate::order::Series;
use crate::tables::{time, wrong_share};
use crate::{Class, Count, Metric, Of, Report, Row};

/// The plane of time and error.
pub fn plane(report: &Report) -> Chart<'_> {
    let lines = Series::all(report.rows_of(|of| matches!(of, Of::Class { .. })));
    let classes = report.classes();
    let key = |((class, rows), dash): (&(Class, Vec<&Row>), &str)| {
        let rays = count(rows[0].count(Count::Rays) as usize, "ray");
        let mark = if is_open(&rows[0].key.of) { "○" } else { "●" };
        format!("{mark} {dash} {} ({}) and their Pareto front", class.name(), typeset(&rays))
    };
    let panel = Panel {
        title: "rays with a wrong object, %",
        y: wrong_percent,
        steps: classes.iter().map(|(class, _)| front(&lines, *class)).collect(),
    };
    Chart {
        report,
        description: "Time to trace one ray against the share of rays with a wrong object, one \
                      point for each kernel, device and class of scenes",
        key: classes.iter().zip(["───", "─ ─", "···"]).map(key).collect(),
        names: lines.iter().map(|line| line.label(report)).collect(),
        lines,
        panels: vec![panel],
        x: ns_per_ray,
        x_title: "time to trace one ray, ns (bar: least to largest)",
        said: |row, _| {
            let [wrong, ns] = [wrong_share(row).text, time(row, Metric::TraceNsPerRay).whole()]
                .map(|words| typeset(&words));
            format!("{}: {wrong} wrong, {ns} ns a ray", row.key.of.name())
        },
    }
}

/// The Pareto front of a class: from the fastest to the right, and down to each that is less wrong
/// than all faster ones.
fn front(lines: &[Series], class: Class) -> Vec<(usize, Point)> {
    let of_class = |(i, line): (usize, &Series)| {
        let row = line.rows.iter().find(|row| row.key.of == Of::Class { class })?;
        Some((i, (ns_per_ray(row)?[0], wrong_percent(row)?[0])))
    };
    let mut points: Vec<_> = lines.iter().enumerate().filter_map(of_class).collect();
    points.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut corners: Vec<(usize, Point)> = Vec::new();
    for (line, (x, y)) in points {
        let last = corners.last().copied();
        if last.is_none_or(|(_, (_, last_y))| y < last_y) {
            corners.extend(last.map(|(last, (_, last_y))| (last, (x, last_y))));
            corners.push((line, (x, y)));
        }
    }
    corners
}
