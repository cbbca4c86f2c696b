//! Time against error: each kernel on each device as a point, one a class of scenes.

use super::chart::{self, Chart, ChartLine, Panel, Point, is_open};
use crate::figures::{count, typeset};
use crate::order::Series;
use crate::tables::{time, wrong_share};
use crate::{Class, Count, Metric, Of, Report, Row};

/// The plane.
pub fn chart(report: &Report) -> Chart<'static> {
    let series = Series::each(&report.rows_of(|of| matches!(of, Of::Class { .. })));
    let classes = report.classes();
    let key = |((class, rows), dash): (&(Class, Vec<&Row>), &str)| {
        let rays = count(rows[0].count(Count::Rays) as usize, "ray");
        let mark = if is_open(&rows[0].key.of) { "○" } else { "●" };
        format!("{mark} {dash} {} ({}) and their Pareto front", class.name(), typeset(&rays))
    };
    let title = |row: &Row| {
        let [wrong, ns] = [wrong_share(row).text, time(row, Metric::TraceNsPerRay).whole()]
            .map(|words| typeset(&words));
        format!("{}: {wrong} wrong, {ns} ns a ray", row.key.of.name())
    };
    let line = |own: &Series| {
        ChartLine::new(report, own, own.label(report), [chart::time, chart::wrong], title)
    };
    let lines: Vec<ChartLine> = series.iter().map(line).collect();
    let panel = Panel {
        title: "rays with a wrong object, %",
        height: 320.0,
        is_joined: false,
        steps: classes.iter().map(|(class, _)| front(&series, &lines, *class)).collect(),
        lines,
    };
    Chart {
        description: "Time to trace one ray against the share of rays with a wrong object, one \
                      point for each kernel, device and class of scenes",
        key: classes.iter().zip(["───", "─ ─", "···"]).map(key).collect(),
        panels: vec![panel],
        x_title: "time to trace one ray, ns (bar: least to largest)",
    }
}

/// The Pareto front of a class: from the fastest to the right, and down to each that is less wrong
/// than all faster ones.
fn front(series: &[Series], lines: &[ChartLine], class: Class) -> Vec<(usize, Point)> {
    let of_class = |(i, (series, line)): (usize, (&Series, &ChartLine))| {
        let at = series.rows.iter().position(|row| row.key.of == Of::Class { class })?;
        Some((i, line.marks[at].as_ref()?.places[0]))
    };
    let mut points: Vec<_> = series.iter().zip(lines).enumerate().filter_map(of_class).collect();
    points.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut corners: Vec<(usize, Point)> = Vec::new();
    for (line, (x, y)) in points {
        match corners.last() {
            Some((_, (_, last_y))) if y >= *last_y => {}
            Some(&(last, (_, last_y))) => corners.extend([(last, (x, last_y)), (line, (x, y))]),
            None => corners.push((line, (x, y))),
        }
    }
    corners
}
