//! A sweep: error or time against one quantity, one line a kernel and device.

use super::chart::{Chart, Line, Mark, Panel, Point};
use super::theme::kernel_class;
use crate::report::figures::{figure, quantity, typeset};
use crate::report::summary::{Cast, SharedSeries, shared_series, time_of};
use crate::report::{Report, Sweep, SweepPoint};

/// A value, and the least and largest where it was measured repeatedly.
type Measured = [f64; 3];

/// A panel's title and what it shows.
type Quantity = (&'static str, fn(&SweepPoint) -> Option<Measured>);

const QUANTITIES: [Quantity; 3] = [
    ("rays with a wrong object, %", |point| {
        let errors = point.errors.as_ref().filter(|errors| errors.rays > 0)?;
        Some([100.0 * errors.wrong_share(); 3])
    }),
    ("error of t that 99.9 % of the rays with the right object do not exceed, ulp", |point| {
        Some([point.errors.as_ref()?.t_ulp?.p999; 3])
    }),
    ("time to trace one ray, ns (bar: least to largest)", |point| {
        let time = point.trace_ns_per_ray.as_ref()?;
        Some([time_of(time)?, time.min, time.max])
    }),
];

/// A sweep as an SVG file.
pub fn sweep(report: &Report, sweep: &Sweep) -> String {
    chart(report, sweep).svg()
}

/// True where the sweep has a point.
pub fn has_sweep(report: &Report, sweep: &Sweep) -> bool {
    !chart(report, sweep).is_empty()
}

fn chart(report: &Report, sweep: &Sweep) -> Chart<'static> {
    let cast = Cast::of(report);
    let lines = shared_series(sweep);
    let points = || sweep.series.iter().flat_map(|series| &series.points);
    let mut quantities = QUANTITIES.to_vec();
    quantities.retain(|(_, of)| points().any(|point| of(point).is_some()));
    let height = if quantities.len() == 1 { 320.0 } else { 200.0 };
    let panel = |(title, of)| Panel {
        title,
        height,
        lines: lines.iter().map(|own| line(own, &cast, of)).collect(),
        is_joined: true,
        steps: Vec::new(),
    };
    let is_shared = lines.iter().any(|line| !line.alike.is_empty());
    let key = "Devices on one line are the same to the last bit; without a device: on all devices.";
    Chart {
        description: sweep.title,
        key: is_shared.then(|| key.to_string()).into_iter().collect(),
        panels: quantities.into_iter().map(panel).collect(),
        x_title: sweep.x_label,
    }
}

fn line(own: &SharedSeries, cast: &Cast, of: fn(&SweepPoint) -> Option<Measured>) -> Line {
    let mark = |point: &SweepPoint| {
        let [y, min, max] = of(point).filter(|[y, ..]| *y >= 0.0)?;
        let place = |y: f64| -> Point { (point.x, y) };
        let title = format!("{}: {}", typeset(&quantity(point.x)), typeset(&figure(y)));
        Some(Mark { at: place(y), range: [min, max].map(place), is_open: false, title })
    };
    let points = own.series.points.iter().filter(|point| point.x > 0.0 && point.x.is_finite());
    let is_on_all = own.alike.len() + 1 == cast.devices.len();
    let contestant = &own.series.contestant;
    Line {
        name: if is_on_all { contestant.kernel.clone() } else { own.label(cast) },
        color: kernel_class(&contestant.kernel),
        device: cast.device_index(&contestant.device),
        marks: points.map(mark).collect(),
    }
}
