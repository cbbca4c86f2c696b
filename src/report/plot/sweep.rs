//! A sweep: error or time against one quantity, one line a kernel and device.

use maud::html;

use super::marks::{DASHES, Entry, legend, line, marker, svg, x_labels};
use super::panel::{self, Axis, LEFT, Mark, Panel, RIGHT, Value, WIDTH};
use super::scale::{Scale, percent_label, tick_label, typeset};
use super::theme::kernel_class;
use crate::report::figures::{figure, list, plain_document, quantity};
use crate::report::summary::{Cast, Line, lines, time_of};
use crate::report::{Class, Report, Sweep, SweepPoint};

const RADIUS: f64 = 3.0;

/// A value, and the range in which it was measured.
type Measured = (Value, Option<(f64, f64)>);

/// What a panel shows.
struct Quantity {
    title: &'static str,
    zero: &'static str,
    fallback: (f64, f64),
    label: fn(f64) -> String,
    of: fn(&SweepPoint) -> Option<Measured>,
}

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        title: "rays with a wrong object",
        zero: "none",
        fallback: (1e-4, 1.0),
        label: percent_label,
        of: |point| {
            let errors = point.errors.as_ref().filter(|errors| errors.rays > 0)?;
            Some((Value::of(errors.wrong_share())?, None))
        },
    },
    Quantity {
        title: "error of t that 99.9 % of the rays with the right object do not exceed, ulp",
        zero: "0",
        fallback: (0.1, 10.0),
        label: tick_label,
        of: |point| Some((Value::of(point.errors.as_ref()?.t_ulp?.p999)?, None)),
    },
    Quantity {
        title: "time to trace one ray, ns (bar: least to largest)",
        zero: "0",
        fallback: (1.0, 100.0),
        label: tick_label,
        of: |point| {
            let time = point.trace_ns_per_ray.as_ref()?;
            Some((Value::Number(time_of(time)?), Some((time.min, time.max))))
        },
    },
];

/// A sweep as an SVG file.
pub fn sweep(report: &Report, sweep: &Sweep) -> String {
    let cast = Cast::of(report);
    let lines = lines(sweep);
    let points = || sweep.series.iter().flat_map(|series| &series.points);
    let shown = |quantity: &Quantity| points().any(|point| (quantity.of)(point).is_some());
    let quantities: Vec<Quantity> = QUANTITIES.into_iter().filter(shown).collect();
    let xs: Vec<f64> = points().map(|point| point.x).filter(|x| x.is_finite()).collect();
    let x = Scale::of_quantity(&xs, (LEFT, RIGHT));
    let (legend, legend_height) = legend(&entries(&lines, &cast), (LEFT, WIDTH - 16.0), 8.0);
    let height = if quantities.len() == 1 { 320.0 } else { 200.0 };
    let mut bottom = 8.0 + legend_height;
    let mut panels = Vec::new();
    for Quantity { title, zero, fallback, label, of } in quantities {
        let axis = Axis { title, zero, fallback, label, height, radius: RADIUS };
        let drawn = lines.iter().map(|line| drawn(line, &cast, of)).collect();
        let panel = Panel::new(axis, drawn, x.clone(), bottom + 34.0);
        bottom = panel.bottom();
        panels.push(panel);
    }
    let body = html! {
        (legend)
        @for panel in &panels { (panel.draw()) }
        @if !panels.is_empty() { (x_labels(&x, bottom, sweep.x_label)) }
    };
    plain_document(&svg(WIDTH, (bottom + 54.0).ceil(), sweep.title, &body))
}

fn drawn(line: &Line, cast: &Cast, of: fn(&SweepPoint) -> Option<Measured>) -> panel::Line {
    let mark = |point: &SweepPoint| {
        let (y, y_range) = of(point)?;
        let words = match y {
            Value::Zero => "0".to_string(),
            Value::Infinite => "∞".to_string(),
            Value::Number(number) => typeset(&figure(number)),
        };
        let title = format!("{}: {words}", typeset(&quantity(point.x)));
        Some(Mark { x: point.x, y, x_range: None, y_range, class: Class::Lecture, title })
    };
    let points = line.series.points.iter().filter(|point| point.x.is_finite());
    let is_on_all = line.alike.len() + 1 == cast.devices.len();
    let kernel = &line.series.contestant.kernel;
    panel::Line {
        name: if is_on_all { kernel.clone() } else { line.label(cast) },
        color: kernel_class(kernel),
        device: device(line, cast),
        dash: Some(DASHES[device(line, cast) % DASHES.len()]),
        marks: points.map(mark).collect(),
    }
}

fn device(line: &Line, cast: &Cast) -> usize {
    cast.device_index(&line.series.contestant.device)
}

/// Colours are named at the lines; here is what dashes mean, and which devices are alike.
fn entries(lines: &[Line], cast: &Cast) -> Vec<Entry> {
    let mut shown: Vec<&Line> = Vec::new();
    for line in lines {
        if !shown.iter().any(|other| other.devices(cast) == line.devices(cast)) {
            shown.push(line);
        }
    }
    let entry = |own: &Line| {
        let device = device(own, cast);
        let sample = html! {
            g.soft {
                g stroke-width="2" stroke-dasharray=(DASHES[device % DASHES.len()]) { (line((-18.0, 0.0), (18.0, 0.0))) }
                (marker(device, Class::Lecture, (0.0, 0.0), RADIUS))
            }
        };
        let names = list(&own.devices(cast));
        let words = match own.alike.is_empty() {
            true => names,
            false => format!("{names}: the same to the last bit"),
        };
        Entry { sample_px: 36.0, sample, words }
    };
    shown.into_iter().map(entry).collect()
}
