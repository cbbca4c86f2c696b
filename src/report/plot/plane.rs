//! Time against error: each kernel on each device as a point, one a class of scenes.

use super::chart::{Chart, Line, Mark, Panel, Point};
use super::theme::kernel_class;
use crate::report::figures::{count, typeset, with_range, wrong};
use crate::report::summary::{Cast, classes, time_of};
use crate::report::{Class, ClassResult, Report};

/// The plane as an SVG file.
pub fn plane(report: &Report) -> String {
    chart(report).svg()
}

/// True where the plane has a point.
pub fn has_plane(report: &Report) -> bool {
    !chart(report).is_empty()
}

fn chart(report: &Report) -> Chart<'static> {
    let cast = Cast::of(report);
    let rows = by_contestant(report);
    let classes = classes(report);
    let key = |(class, dash): (&Class, &str)| {
        let of_class = report.classes.iter().find(|row| row.class == *class);
        let rays = count(of_class.map_or(0, |row| row.errors.rays) as usize, "ray");
        let mark = if is_open(*class) { "○" } else { "●" };
        format!("{mark} {dash} {} ({}) and their Pareto front", class.name(), typeset(&rays))
    };
    let panel = Panel {
        title: "rays with a wrong object, %",
        height: 320.0,
        lines: rows.iter().map(|rows| line(rows, &cast)).collect(),
        is_joined: false,
        steps: classes.iter().map(|class| front(&rows, *class)).collect(),
    };
    Chart {
        description: "Time to trace one ray against the share of rays with a wrong object, one \
                      point for each kernel, device and class of scenes",
        key: classes.iter().zip(["───", "─ ─", "···"]).map(key).collect(),
        panels: vec![panel],
        x_title: "time to trace one ray, ns (bar: least to largest)",
    }
}

/// The rows of each kernel and device.
fn by_contestant(report: &Report) -> Vec<Vec<&ClassResult>> {
    let mut groups: Vec<Vec<&ClassResult>> = Vec::new();
    for row in &report.classes {
        match groups.iter_mut().find(|rows| rows[0].contestant == row.contestant) {
            Some(rows) => rows.push(row),
            None => groups.push(vec![row]),
        }
    }
    groups
}

fn line(rows: &[&ClassResult], cast: &Cast) -> Line {
    let contestant = &rows[0].contestant;
    Line {
        name: cast.label(contestant),
        color: kernel_class(&contestant.kernel),
        device: cast.device_index(&contestant.device),
        marks: rows.iter().map(|row| mark(row)).collect(),
    }
}

fn is_open(class: Class) -> bool {
    class == Class::Hard
}

/// Nanoseconds and percent.
fn point(row: &ClassResult) -> Option<Point> {
    let time = time_of(&row.trace_ns_per_ray)?;
    (row.errors.rays > 0).then(|| (time, 100.0 * row.errors.wrong_share()))
}

fn mark(row: &ClassResult) -> Option<Mark> {
    let at = point(row)?;
    let time = &row.trace_ns_per_ray;
    let (class, wrong, ns) = (row.class.name(), wrong(&row.errors), with_range(time));
    Some(Mark {
        at,
        range: [(time.min, at.1), (time.max, at.1)],
        is_open: is_open(row.class),
        title: format!("{class}: {} wrong, {} ns a ray", typeset(&wrong), typeset(&ns)),
    })
}

/// The Pareto front of a class: from the fastest to the right, and down to each that is less wrong
/// than all faster ones.
fn front(rows: &[Vec<&ClassResult>], class: Class) -> Vec<(usize, Point)> {
    let of_class = |(line, rows): (usize, &Vec<&ClassResult>)| {
        let row = rows.iter().find(|row| row.class == class)?;
        Some((line, point(row)?))
    };
    let mut points: Vec<(usize, Point)> = rows.iter().enumerate().filter_map(of_class).collect();
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
