//! Time against error: each kernel on each device as a point, one a class of scenes.

use maud::html;

use super::marks::{DASHES, Entry, legend, line, marker, polyline, svg, x_labels};
use super::panel::{Axis, LEFT, Line, Mark, Panel, RIGHT, Value, WIDTH};
use super::scale::{Scale, percent_label, typeset};
use super::theme::kernel_class;
use crate::report::figures::{count, plain_document, spread, wrong};
use crate::report::summary::{Cast, classes, time_of};
use crate::report::{Class, ClassResult, Contestant, Report};

const RADIUS: f64 = 5.5;

/// The plane as an SVG file.
pub fn plane(report: &Report) -> String {
    let cast = Cast::of(report);
    let lines = lines(report, &cast);
    let (legend, legend_height) = legend(&entries(report, &cast), (LEFT, RIGHT), 8.0);
    // Where nobody was wrong: what could be seen goes from one ray to all.
    let n_rays = report.classes.iter().map(|row| row.errors.rays).max().unwrap_or(1).max(1);
    let axis = Axis {
        title: "rays with a wrong object",
        zero: "none",
        fallback: (1.0 / n_rays as f64, 1.0),
        label: percent_label,
        height: 320.0,
        radius: RADIUS,
    };
    let times = report.classes.iter().map(|row| row.trace_ns_per_ray);
    let x = Scale::log(times.flat_map(|time| [time.min, time.median, time.max]), (LEFT, RIGHT));
    let panel = Panel::new(axis, lines, x.clone(), 8.0 + legend_height + 34.0);
    let body = html! {
        (legend)
        (panel.draw())
        @for (i, class) in classes(report).into_iter().enumerate() {
            g.soft stroke-width="1.5" { (polyline(&front(&panel, class), DASHES[i % DASHES.len()])) }
        }
        (x_labels(&x, panel.bottom(), "time to trace one ray, ns (bar: least to largest)"))
    };
    let description = "Time to trace one ray against the share of rays with a wrong object, one \
                       point for each kernel, device and class of scenes";
    plain_document(&svg(WIDTH, (panel.bottom() + 54.0).ceil(), description, &body))
}

/// One line a kernel and device, with a mark for each class, the most often wrong first.
fn lines(report: &Report, cast: &Cast) -> Vec<Line> {
    let mut contestants: Vec<&Contestant> = Vec::new();
    for row in &report.classes {
        if !contestants.contains(&&row.contestant) {
            contestants.push(&row.contestant);
        }
    }
    let line = |contestant: &Contestant| {
        let own = |row: &&ClassResult| row.contestant == *contestant && row.errors.rays > 0;
        let mut rows: Vec<&ClassResult> = report.classes.iter().filter(own).collect();
        rows.sort_by(|a, b| b.errors.wrong_share().total_cmp(&a.errors.wrong_share()));
        Line {
            name: cast.label(contestant),
            color: kernel_class(&contestant.kernel),
            device: cast.device_index(&contestant.device),
            dash: None,
            marks: rows.into_iter().map(mark).collect(),
        }
    };
    contestants.into_iter().map(line).collect()
}

fn mark(row: &ClassResult) -> Option<Mark> {
    let time = &row.trace_ns_per_ray;
    let title = format!(
        "{}: {} wrong, {} ns a ray",
        row.class.name(),
        typeset(&wrong(&row.errors)),
        typeset(&spread(time))
    );
    Some(Mark {
        x: time_of(time)?,
        y: Value::of(row.errors.wrong_share())?,
        x_range: Some((time.min, time.max)),
        y_range: None,
        class: row.class,
        title,
    })
}

/// The Pareto front of a class: from the fastest to the right, and down to each that is less wrong
/// than all faster ones.
fn front(panel: &Panel, class: Class) -> Vec<(f64, f64)> {
    let mut places = Vec::new();
    for (i, line) in panel.lines.iter().enumerate() {
        let of_class = line.marks.iter().flatten().filter(|mark| mark.class == class);
        places.extend(of_class.map(|mark| (panel.place(i, mark), mark.y)));
    }
    places.sort_by(|((a_x, a_y), _), ((b_x, b_y), _)| a_x.total_cmp(b_x).then(b_y.total_cmp(a_y)));
    let mut corners: Vec<(f64, f64)> = Vec::new();
    for ((x, y), value) in places {
        match corners.last() {
            Some((_, last_y)) if y <= *last_y => continue,
            Some((_, last_y)) => corners.extend([(x, *last_y), (x, y)]),
            None => corners.push((x, y)),
        }
        // Nothing is less wrong than never.
        if value == Value::Zero {
            break;
        }
    }
    corners
}

/// What colours, shapes and fillings mean.
fn entries(report: &Report, cast: &Cast) -> Vec<Entry> {
    let mut entries = Vec::new();
    for kernel in &cast.kernels {
        let sample = html! {
            g class=(kernel_class(kernel)) stroke-width="6" { (line((-11.0, 0.0), (11.0, 0.0))) }
        };
        entries.push(Entry { sample_px: 22.0, sample, words: kernel.to_string() });
    }
    for (i, device) in cast.devices.iter().enumerate() {
        let sample = html! { g.soft { (marker(i, Class::Lecture, (0.0, 0.0), RADIUS)) } };
        entries.push(Entry { sample_px: 14.0, sample, words: cast.short(device).to_string() });
    }
    for (i, class) in classes(report).into_iter().enumerate() {
        let sample = html! {
            g.soft {
                g stroke-width="1.5" stroke-dasharray=(DASHES[i % DASHES.len()]) { (line((-20.0, 0.0), (20.0, 0.0))) }
                (marker(0, class, (0.0, 0.0), RADIUS))
            }
        };
        let rays =
            report.classes.iter().find(|row| row.class == class).map_or(0, |row| row.errors.rays);
        let rays = typeset(&count(rays as usize, "ray"));
        let words = format!("{} ({rays}) and their Pareto front", class.name());
        entries.push(Entry { sample_px: 40.0, sample, words });
    }
    entries
}
