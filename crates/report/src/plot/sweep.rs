//! A sweep: error or time against one quantity, one line a kernel and device.

use super::{AxisValue, Chart, Panel, ns_per_ray, wrong_percent};
use crate::figures::{figure, quantity, typeset};
use crate::order::Series;
use crate::{Metric, Report, Sweep};

const QUANTITIES: [(&str, AxisValue); 3] = [
    ("rays with a wrong object, %", wrong_percent),
    ("error of t that 99.9 % of the rays with the right object do not exceed, ulp", |row| {
        Some([row.number(Metric::TUlp)?.p999; 3])
    }),
    ("time to trace one ray, ns (bar: least to largest)", ns_per_ray),
];

/// A sweep, with a panel for each quantity that it has.
pub fn sweep<'a>(report: &'a Report, sweep: &Sweep) -> Chart<'a> {
    let rows = report.rows_along(sweep);
    let mut quantities = QUANTITIES.to_vec();
    quantities.retain(|(_, y)| rows.iter().any(|row| y(row).is_some()));
    let lines = Series::all(rows);
    let panel = |(title, y)| Panel { title, y, steps: Vec::new() };
    let name = |line: &Series| {
        let is_on_all = line.devices.len() == report.devices().len();
        if is_on_all { line.rows[0].key.kernel.clone() } else { line.label(report) }
    };
    let is_shared = lines.iter().any(|line| line.devices.len() > 1);
    let key = "Devices on one line are the same to the last bit; without a device: on all devices.";
    Chart {
        report,
        description: sweep.title,
        key: is_shared.then(|| key.to_string()).into_iter().collect(),
        names: lines.iter().map(name).collect(),
        lines,
        panels: quantities.into_iter().map(panel).collect(),
        x: |row| Some([row.x(); 3]),
        x_title: sweep.x_label,
        said: |row, y| format!("{}: {}", typeset(&quantity(row.x())), typeset(&figure(y))),
    }
}
