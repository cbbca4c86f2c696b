//! Who took part, in the order in which the report first names them, and which devices agree.

use super::figures::{list, short_name};
use super::{Class, Metric, Of, Report, Row, RowKey, Sweep};

/// What has the same key together, in the order in which the keys come first.
pub fn grouped<T, K: PartialEq>(
    items: impl IntoIterator<Item = T>,
    key: impl Fn(&T) -> K,
) -> Vec<(K, Vec<T>)> {
    let mut groups: Vec<(K, Vec<T>)> = Vec::new();
    for item in items {
        let own = key(&item);
        match groups.iter_mut().find(|(known, _)| *known == own) {
            Some((_, items)) => items.push(item),
            None => groups.push((own, vec![item])),
        }
    }
    groups
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
        let groups = grouped(&self.rows, |row| name(&row.key).as_str());
        groups.into_iter().map(|(name, _)| name).collect()
    }

    /// The device's short name, if no other device has the same.
    pub(super) fn short<'b>(&self, device: &'b str) -> &'b str {
        let short = short_name(device);
        let alike = self.devices().into_iter().filter(|other| short_name(other) == short);
        if alike.count() > 1 { device } else { short }
    }

    /// The place of a device in the order.
    pub(super) fn device_index(&self, device: &str) -> usize {
        self.devices().iter().position(|known| *known == device).unwrap_or(0)
    }

    /// The rows of some things.
    pub(super) fn rows_of(&self, is: impl Fn(&Of) -> bool) -> Vec<&Row> {
        self.rows.iter().filter(|row| is(&row.key.of)).collect()
    }

    /// The classes that have results, each with its rows.
    pub(super) fn classes(&self) -> Vec<(Class, Vec<&Row>)> {
        let rows = |class| (class, self.rows_of(|of| *of == Of::Class { class }));
        Class::ALL.into_iter().map(rows).filter(|(_, rows)| !rows.is_empty()).collect()
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
    pub devices: Vec<&'a str>,
}

impl<'a> Series<'a> {
    /// The lines of some rows, one a kernel and device. Devices whose errors are the same to the last bit share
    /// one; times are never taken for the same.
    pub fn all(rows: Vec<&'a Row>) -> Vec<Series<'a>> {
        let lines = grouped(rows, |row| (&row.key.kernel, &row.key.device));
        let errors = |row: &&'a Row| (row.x(), &row.numbers, &row.counts);
        let is_timed = |row: &&Row| row.number(Metric::TraceNsPerRay).is_some();
        let key = |((kernel, device), rows): &((&'a String, &'a String), Vec<&'a Row>)| {
            let of_device = rows.iter().any(is_timed).then_some(*device);
            (*kernel, of_device, rows.iter().map(errors).collect::<Vec<_>>())
        };
        let together = |(_, lines): (_, Vec<((_, &'a String), Vec<_>)>)| Series {
            devices: lines.iter().map(|((_, device), _)| device.as_str()).collect(),
            rows: lines[0].1.clone(),
        };
        grouped(lines, key).into_iter().map(together).collect()
    }

    /// `certified, llvmpipe and CPU`
    pub fn label(&self, report: &Report) -> String {
        let devices: Vec<_> =
            self.devices.iter().map(|device| report.short(device).into()).collect();
        format!("{}, {}", self.rows[0].key.kernel, list(&devices))
    }
}
