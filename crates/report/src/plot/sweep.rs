//! A sweep: error or time against one quantity, one line a kernel and device.

use super::chart::{self, AxisValue, Chart, ChartLine, Panel};
use crate::figures::{figure, quantity, typeset};
use crate::order::Series;
use crate::{Metric, Report, Row, Sweep};

const QUANTITIES: [(&str, AxisValue); 3] = [
    ("rays with a wrong object, %", chart::wrong),
    ("error of t that 99.9 % of the rays with the right object do not exceed, ulp", |row| {
        Some([row.number(Metric::TUlp)?.p999; 3])
    }),
    ("time to trace one ray, ns (bar: least to largest)", chart::time),
];

/// A sweep's panels.
pub fn chart(report: &Report, sweep: &Sweep) -> Chart<'static> {
    let rows = report.rows_along(sweep);
    let series = Series::shared(&rows);
    let mut quantities = QUANTITIES.to_vec();
    quantities.retain(|(_, of)| rows.iter().any(|row| of(row).is_some()));
    let height = if quantities.len() == 1 { 320.0 } else { 200.0 };
    let panel = |(title, of): (_, AxisValue)| {
        let line = |own: &Series| {
            let is_on_all = own.n_devices() == report.devices().len();
            let name = if is_on_all { own.key().kernel.clone() } else { own.label(report) };
            ChartLine::new(report, own, name, [|row| Some([row.x(); 3]), of], |row: &Row| {
                let [y, ..] = of(row).unwrap_or_default();
                format!("{}: {}", typeset(&quantity(row.x())), typeset(&figure(y)))
            })
        };
        let lines = series.iter().map(line).collect();
        Panel { title, height, lines, is_joined: true, steps: Vec::new() }
    };
    let is_shared = series.iter().any(|line| line.n_devices() > 1);
    let key = "Devices on one line are the same to the last bit; without a device: on all devices.";
    Chart {
        description: sweep.title,
        key: is_shared.then(|| key.to_string()).into_iter().collect(),
        panels: quantities.into_iter().map(panel).collect(),
        x_title: sweep.x_label,
    }
}
