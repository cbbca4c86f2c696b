//! The figures put together: who took part, and which devices agree.

use super::figures::{list, short_name};
use super::{Class, Contestant, Report, Series, Spread, Sweep};

/// Kernels and devices, in the order in which the report first names them.
pub struct Cast<'a> {
    pub kernels: Vec<&'a str>,
    pub devices: Vec<&'a str>,
}

impl<'a> Cast<'a> {
    pub fn of(report: &'a Report) -> Cast<'a> {
        let rows = report.scenes.iter().flat_map(|scene| &scene.rows).map(|row| &row.contestant);
        let classes = report.classes.iter().map(|class| &class.contestant);
        let sweeps = report.sweeps.iter().flat_map(|sweep| &sweep.series).map(|s| &s.contestant);
        let clouds = report.clouds.iter().map(|cloud| &cloud.contestant);
        let light = report.light.iter().flat_map(|scene| &scene.rows).map(|row| &row.contestant);
        let pictures = report.pictures.iter().map(|picture| &picture.contestant);
        let mut cast = Cast { kernels: Vec::new(), devices: Vec::new() };
        for contestant in
            rows.chain(classes).chain(clouds).chain(sweeps).chain(light).chain(pictures)
        {
            add(&mut cast.kernels, &contestant.kernel);
            add(&mut cast.devices, &contestant.device);
        }
        cast
    }

    /// The device's short name, if no other device has the same.
    pub fn short(&self, device: &'a str) -> &'a str {
        let short = short_name(device);
        let alike = self.devices.iter().filter(|other| short_name(other) == short).count();
        if alike > 1 { device } else { short }
    }

    /// The place of a device in the order.
    pub fn device_index(&self, device: &str) -> usize {
        self.devices.iter().position(|known| *known == device).unwrap_or(self.devices.len())
    }

    /// `certified, CPU`
    pub fn label(&self, contestant: &'a Contestant) -> String {
        format!("{}, {}", contestant.kernel, self.short(&contestant.device))
    }
}

fn add<'a>(names: &mut Vec<&'a str>, name: &'a str) {
    if !names.contains(&name) {
        names.push(name);
    }
}

/// The classes that have results, in order.
pub fn classes(report: &Report) -> Vec<Class> {
    let mut classes: Vec<Class> = report.classes.iter().map(|result| result.class).collect();
    classes.sort();
    classes.dedup();
    classes
}

/// A time that can be drawn: positive and finite.
pub fn time_of(spread: &Spread) -> Option<f64> {
    (spread.median > 0.0 && spread.median.is_finite()).then_some(spread.median)
}

/// All places of a sweep, ascending.
pub fn xs(sweep: &Sweep) -> Vec<f64> {
    let points = sweep.series.iter().flat_map(|series| &series.points);
    let mut xs: Vec<f64> = points.map(|point| point.x).collect();
    xs.sort_by(f64::total_cmp);
    xs.dedup();
    xs
}

/// A series of a sweep, for all devices on which it is the same.
pub struct SharedSeries<'a> {
    pub series: &'a Series,
    /// Other devices whose errors are the same at every point.
    pub alike: Vec<&'a str>,
}

impl<'a> SharedSeries<'a> {
    /// `certified, llvmpipe and CPU`
    pub fn label(&self, cast: &Cast<'a>) -> String {
        format!("{}, {}", self.series.contestant.kernel, list(&self.devices(cast)))
    }

    /// The short names of its devices.
    pub fn devices(&self, cast: &Cast<'a>) -> Vec<String> {
        let own = self.series.contestant.device.as_str();
        [own].iter().chain(&self.alike).map(|device| cast.short(device).to_string()).collect()
    }
}

/// The series of a sweep. Devices whose errors are the same to the last bit share one; times are
/// never taken for the same.
pub fn shared_series(sweep: &Sweep) -> Vec<SharedSeries<'_>> {
    let mut lines: Vec<SharedSeries> = Vec::new();
    for series in &sweep.series {
        match lines.iter_mut().find(|line| is_alike(line.series, series)) {
            Some(line) => line.alike.push(&series.contestant.device),
            None => lines.push(SharedSeries { series, alike: Vec::new() }),
        }
    }
    lines
}

fn is_alike(a: &Series, b: &Series) -> bool {
    a.contestant.kernel == b.contestant.kernel
        && a.points.len() == b.points.len()
        && a.points.iter().zip(&b.points).all(|(p, q)| {
            p.x == q.x
                && p.errors.is_some()
                && p.errors == q.errors
                && p.trace_ns_per_ray.is_none()
                && q.trace_ns_per_ray.is_none()
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Errors, SweepPoint};

    #[test]
    fn alike_to_the_last_bit_alone() {
        let series = |device: &str, wrong_object, time: Option<Spread>| Series {
            contestant: Contestant { kernel: "stable".into(), device: device.into() },
            points: vec![SweepPoint {
                x: 1.0,
                errors: Some(Errors { rays: 10, wrong_object, ..Errors::default() }),
                trace_ns_per_ray: time,
            }],
        };
        let sweep = |series: [Series; 2]| Sweep {
            name: "distance",
            title: "",
            x_label: "",
            series: series.into(),
        };
        assert_eq!(shared_series(&sweep([series("a", 1, None), series("b", 1, None)])).len(), 1);
        assert_eq!(shared_series(&sweep([series("a", 1, None), series("b", 2, None)])).len(), 2);
        let time = Some(Spread::default());
        assert_eq!(shared_series(&sweep([series("a", 1, time), series("b", 1, time)])).len(), 2);
    }
}
