//! A sweep: error or time against one quantity, one line a kernel and device.

use super::chart::{Chart, ChartLine, Mark, Panel, Point};
use super::theme::kernel_class;
use crate::figures::{figure, quantity, typeset};
use crate::order::Series;
use crate::{Count, Metric, Report, Row, Spread, Sweep};

/// A value, and the least and largest where it was measured repeatedly.
type Measured = [f64; 3];

/// A panel's title and what it shows.
type Quantity = (&'static str, fn(&Row) -> Option<Measured>);

const QUANTITIES: [Quantity; 3] = [
    ("rays with a wrong object, %", |row| {
        (row.count(Count::Rays) > 0).then(|| [100.0 * row.wrong_share(); 3])
    }),
    ("error of t that 99.9 % of the rays with the right object do not exceed, ulp", |row| {
        Some([row.number(Metric::TUlp)?.p999; 3])
    }),
    ("time to trace one ray, ns (bar: least to largest)", |row| {
        let time = row.number(Metric::TraceNsPerRay).filter(Spread::is_drawable)?;
        Some([time.median, time.min, time.max])
    }),
];

/// A sweep's panels.
pub fn chart(report: &Report, sweep: &Sweep) -> Chart<'static> {
    let rows = report.rows_along(sweep);
    let lines = Series::shared(&rows);
    let mut quantities = QUANTITIES.to_vec();
    quantities.retain(|(_, of)| rows.iter().any(|row| of(row).is_some()));
    let height = if quantities.len() == 1 { 320.0 } else { 200.0 };
    let panel = |(title, of)| Panel {
        title,
        height,
        lines: lines.iter().map(|own| line(own, report, of)).collect(),
        is_joined: true,
        steps: Vec::new(),
    };
    let is_shared = lines.iter().any(|line| line.n_devices() > 1);
    let key = "Devices on one line are the same to the last bit; without a device: on all devices.";
    Chart {
        description: sweep.title,
        key: is_shared.then(|| key.to_string()).into_iter().collect(),
        panels: quantities.into_iter().map(panel).collect(),
        x_title: sweep.x_label,
    }
}

fn line(own: &Series, report: &Report, of: fn(&Row) -> Option<Measured>) -> ChartLine {
    let mark = |row: &&Row| {
        let [y, min, max] = of(row).filter(|[y, ..]| *y >= 0.0)?;
        let place = |y: f64| -> Point { (row.x(), y) };
        let title = format!("{}: {}", typeset(&quantity(row.x())), typeset(&figure(y)));
        Some(Mark { at: place(y), range: [min, max].map(place), is_open: false, title })
    };
    let rows = own.rows.iter().filter(|row| row.x() > 0.0 && row.x().is_finite());
    let is_on_all = own.n_devices() == report.devices().len();
    ChartLine {
        name: if is_on_all { own.key().kernel.clone() } else { own.label(report) },
        color: kernel_class(&own.key().kernel),
        device: report.device_index(&own.key().device),
        marks: rows.map(mark).collect(),
    }
}
