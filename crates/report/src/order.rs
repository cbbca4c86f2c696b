//! Who took part, in the order in which the report first names them, and which devices agree.

use super::figures::{list, short_name};
use super::{Class, Metric, Of, Report, Row, RowKey, Sweep};

/// Adds what is not there yet.
pub fn add<T: PartialEq>(known: &mut Vec<T>, new: T) {
    if !known.contains(&new) {
        known.push(new);
    }
}

impl Report {
    /// The kernels, in the order in which the rows first name them.
    pub(super) fn kernels(&self) -> Vec<&str> {
        self.named(|key| &key.kernel)
    }

    /// The devices, in the same order.
    pub(super) fn devices(&self) -> Vec<&str> {
        self.named(|key| &key.device)
    }

    fn named(&self, name: fn(&RowKey) -> &String) -> Vec<&str> {
        let mut names = Vec::new();
        self.rows.iter().for_each(|row| add(&mut names, name(&row.key).as_str()));
        names
    }

    /// The device's short name, if no other device has the same.
    pub(super) fn short<'b>(&self, device: &'b str) -> &'b str {
        let short = short_name(device);
        let alike = self.devices().into_iter().filter(|other| short_name(other) == short);
        if alike.count() > 1 { device } else { short }
    }

    /// The place of a device in the order.
    pub(super) fn device_index(&self, device: &str) -> usize {
        let devices = self.devices();
        devices.iter().position(|known| *known == device).unwrap_or(devices.len())
    }

    /// `certified, CPU`
    pub(super) fn label(&self, key: &RowKey) -> String {
        format!("{}, {}", key.kernel, self.short(&key.device))
    }

    /// The rows of some things.
    pub(super) fn rows_of(&self, is: impl Fn(&Of) -> bool) -> Vec<&Row> {
        self.rows.iter().filter(|row| is(&row.key.of)).collect()
    }

    /// The classes that have results, each with its rows.
    pub(super) fn classes(&self) -> Vec<(Class, Vec<&Row>)> {
        let classes = [Class::Lecture, Class::Hard, Class::Lit, Class::Given];
        let rows = |class| self.rows_of(|of| *of == Of::Class { class });
        classes
            .map(|class| (class, rows(class)))
            .into_iter()
            .filter(|(_, rows)| !rows.is_empty())
            .collect()
    }

    /// The rows of a sweep, in ascending order.
    pub(super) fn rows_along(&self, swept: &Sweep) -> Vec<&Row> {
        let mut rows =
            self.rows_of(|of| matches!(of, Of::Sweep { sweep, .. } if sweep == swept.name));
        rows.sort_by(|a, b| a.x().total_cmp(&b.x()));
        rows
    }
}

impl Row {
    /// The quantity that a sweep sweeps; 0 of anything else.
    pub(super) fn x(&self) -> f64 {
        if let Of::Sweep { x, .. } = self.key.of { x } else { 0.0 }
    }
}

/// A kernel's rows on a device, for each device on which they are the same.
pub struct Series<'a> {
    pub rows: Vec<&'a Row>,
    devices: Vec<&'a str>,
}

impl<'a> Series<'a> {
    /// The rows of each kernel on each device.
    pub fn each(rows: &[&'a Row]) -> Vec<Series<'a>> {
        let mut lines: Vec<Series> = Vec::new();
        for row in rows {
            let RowKey { kernel, device, .. } = &row.key;
            let is_own =
                |line: &&mut Series| (&line.key().kernel, &line.key().device) == (kernel, device);
            match lines.iter_mut().find(is_own) {
                Some(line) => line.rows.push(row),
                None => lines.push(Series { rows: vec![row], devices: vec![device] }),
            }
        }
        lines
    }

    /// The lines of some rows. Devices whose errors are the same to the last bit share one; times are
    /// never taken for the same.
    pub fn shared(rows: &[&'a Row]) -> Vec<Series<'a>> {
        let mut lines: Vec<Series> = Vec::new();
        for line in Series::each(rows) {
            match lines.iter_mut().find(|other| other.is_alike(&line)) {
                Some(other) => other.devices.extend(line.devices),
                None => lines.push(line),
            }
        }
        lines
    }

    /// What its first row is of.
    pub fn key(&self) -> &'a RowKey {
        &self.rows[0].key
    }

    fn is_alike(&self, other: &Series) -> bool {
        let same = |(a, b): (&&Row, &&Row)| {
            let is_timed = a.number(Metric::TraceNsPerRay).is_some();
            (a.x(), &a.numbers, &a.counts) == (b.x(), &b.numbers, &b.counts) && !is_timed
        };
        self.key().kernel == other.key().kernel
            && self.rows.len() == other.rows.len()
            && self.rows.iter().zip(&other.rows).all(same)
    }

    /// How many devices share the line.
    pub fn n_devices(&self) -> usize {
        self.devices.len()
    }

    /// `certified, llvmpipe and CPU`
    pub fn label(&self, report: &Report) -> String {
        let devices: Vec<_> =
            self.devices.iter().map(|device| report.short(device).into()).collect();
        format!("{}, {}", self.key().kernel, list(&devices))
    }
}
