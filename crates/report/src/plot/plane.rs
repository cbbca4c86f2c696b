//! Time against error: each kernel on each device as a point, one a class of scenes.

use super::chart::{Chart, ChartLine, Mark, Panel, Point};
use super::theme::kernel_class;
use crate::figures::{count, typeset, wrong};
use crate::order::Series;
use crate::tables::spread;
use crate::{Class, Count, Metric, Of, Report, Row, Spread};

/// The plane.
pub fn chart(report: &Report) -> Chart<'static> {
    let lines = Series::each(&report.rows_of(|of| matches!(of, Of::Class { .. })));
    let classes = report.classes();
    let key = |((class, rows), dash): (&(Class, Vec<&Row>), &str)| {
        let rays = count(rows[0].count(Count::Rays) as usize, "ray");
        let mark = if is_open(*class) { "○" } else { "●" };
        format!("{mark} {dash} {} ({}) and their Pareto front", class.name(), typeset(&rays))
    };
    let line = |line: &Series| ChartLine {
        name: report.label(line.key()),
        color: kernel_class(&line.key().kernel),
        device: report.device_index(&line.key().device),
        marks: line.rows.iter().map(|row| mark(row)).collect(),
    };
    let panel = Panel {
        title: "rays with a wrong object, %",
        height: 320.0,
        lines: lines.iter().map(line).collect(),
        is_joined: false,
        steps: classes.iter().map(|(class, _)| front(&lines, *class)).collect(),
    };
    Chart {
        description: "Time to trace one ray against the share of rays with a wrong object, one \
                      point for each kernel, device and class of scenes",
        key: classes.iter().zip(["───", "─ ─", "···"]).map(key).collect(),
        panels: vec![panel],
        x_title: "time to trace one ray, ns (bar: least to largest)",
    }
}

fn is_open(class: Class) -> bool {
    class == Class::Hard
}

/// Nanoseconds and percent.
fn point(row: &Row) -> Option<Point> {
    let time = row.number(Metric::TraceNsPerRay).filter(Spread::is_drawable)?;
    (row.count(Count::Rays) > 0).then(|| (time.median, 100.0 * row.wrong_share()))
}

fn mark(row: &Row) -> Option<Mark> {
    let (at, time) = (point(row)?, row.number(Metric::TraceNsPerRay)?);
    let Of::Class { class } = row.key.of else { return None };
    let (wrong, ns) = (wrong(row), spread(&time).whole());
    Some(Mark {
        at,
        range: [(time.min, at.1), (time.max, at.1)],
        is_open: is_open(class),
        title: format!("{}: {} wrong, {} ns a ray", class.name(), typeset(&wrong), typeset(&ns)),
    })
}

/// The Pareto front of a class: from the fastest to the right, and down to each that is less wrong
/// than all faster ones.
fn front(lines: &[Series], class: Class) -> Vec<(usize, Point)> {
    let of_class = |(i, line): (usize, &Series)| {
        let row = line.rows.iter().find(|row| row.key.of == Of::Class { class })?;
        Some((i, point(row)?))
    };
    let mut points: Vec<(usize, Point)> = lines.iter().enumerate().filter_map(of_class).collect();
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
