//! The charts of a [`Report`].

use kugelblitz::words::list;

use super::chart;
use super::table::{DISTANCE, SHADOWS, SPHERES, SUMMARY};
use super::{
    ClassRow, DistanceRow, KernelOnDevice, RayErrors, Report, SceneClass, SpheresRow, TimeSpread,
};

/// A chart on logarithmic axes.
pub struct Chart {
    /// Title of the table with the same figures.
    pub section: &'static str,
    /// Quantity of the vertical axis.
    pub title: String,
    /// Quantity of the horizontal axis.
    pub x_label: &'static str,
    /// Lines with marks.
    pub series: Vec<Series>,
}

/// A line with marks.
pub struct Series {
    /// Text in the legend.
    pub name: String,
    /// Class of the colour.
    pub class: &'static str,
    /// Index of the device, which selects mark and dashes.
    pub device: usize,
    /// Coordinates of each mark.
    pub points: Vec<PlotPoint>,
}

/// Median, minimum and maximum of both coordinates.
type PlotPoint = [[f64; 3]; 2];

const TIME: &str = "time per ray, ns (bar: minimum to maximum)";

/// Returns all charts in one SVG document.
pub fn svg(report: &Report) -> String {
    chart::svg(&charts(report).iter().collect::<Vec<_>>())
}

/// Returns all charts that have a mark.
pub(crate) fn charts(report: &Report) -> Vec<Chart> {
    let mut charts = Vec::new();
    for class in SceneClass::TRACED {
        for (quantity, y) in ERRORS {
            let rows = report.classes.iter().filter(|row| row.class == class);
            let point = |row: &ClassRow| {
                Some((row.of.clone(), [time(&row.ns_per_ray), [y(&row.errors)?; 3]]))
            };
            charts.push(Chart {
                section: SUMMARY,
                title: format!("{}: {quantity}", class.name()),
                x_label: TIME,
                series: series(report, rows.filter_map(point)),
            });
        }
    }
    for (quantity, y) in ERRORS {
        let point =
            |row: &DistanceRow| Some((row.of.clone(), [[row.distance; 3], [y(&row.errors)?; 3]]));
        charts.push(Chart {
            section: DISTANCE,
            title: quantity.into(),
            x_label: "distance of the sphere's centre from the camera, radii",
            series: series(report, report.distance.iter().filter_map(point)),
        });
    }
    let spheres =
        |row: &SpheresRow| (row.of.clone(), [[row.spheres as f64; 3], time(&row.ns_per_ray)]);
    charts.push(Chart {
        section: SPHERES,
        title: TIME.into(),
        x_label: "spheres",
        series: series(report, report.spheres.iter().map(spheres)),
    });
    charts.push(Chart {
        section: SHADOWS,
        title: "all scenes: wrong shadows, % of pixels times lights".into(),
        x_label: "ε, units of the scene",
        series: series(report, shadows(report)),
    });
    charts.retain(|chart| !chart.series.is_empty());
    charts
}

/// A quantity of errors with its name.
type ErrorQuantity = (&'static str, fn(&RayErrors) -> Option<f64>);

const ERRORS: [ErrorQuantity; 2] = [
    ("rays with a wrong object, %", |errors| Some(errors.wrong_percent())),
    ("error of t that 99.9 % of the rays do not exceed, f32 steps", |errors| {
        Some(errors.t_ulp?.p999)
    }),
];

/// Returns the share of wrong shadows of all scenes for each kernel and epsilon.
fn shadows(report: &Report) -> impl Iterator<Item = (KernelOnDevice, PlotPoint)> {
    let mut sums: Vec<(&'static str, f64, [u64; 2])> = Vec::new();
    for row in &report.shadows {
        let epsilon = row.epsilon.unwrap_or(0.0);
        let counts = [row.false_shadows + row.leaks, row.shadow_rays];
        let known = sums.iter_mut().find(|sum| (sum.0, sum.1) == (row.kernel, epsilon));
        match known {
            Some((.., sum)) => [0, 1].into_iter().for_each(|i| sum[i] += counts[i]),
            None => sums.push((row.kernel, epsilon, counts)),
        }
    }
    sums.into_iter().map(|(kernel, epsilon, [wrong, all])| {
        let percent = 100.0 * wrong as f64 / all.max(1) as f64;
        (KernelOnDevice { kernel, device: String::new() }, [[epsilon; 3], [percent; 3]])
    })
}

/// Returns a line for each kernel and device. Devices with equal points share one.
fn series(
    report: &Report,
    points: impl Iterator<Item = (KernelOnDevice, PlotPoint)>,
) -> Vec<Series> {
    let mut lines: Vec<(KernelOnDevice, Vec<PlotPoint>)> = Vec::new();
    for (of, point) in points {
        match lines.iter_mut().find(|(known, _)| *known == of) {
            Some((_, points)) => points.push(point),
            None => lines.push((of, vec![point])),
        }
    }
    let mut devices: Vec<String> = Vec::new();
    let mut all: Vec<(Vec<String>, Series)> = Vec::new();
    for (KernelOnDevice { kernel, device }, points) in lines {
        let short = report.short(&device);
        let index = devices.iter().position(|known| *known == device).unwrap_or(devices.len());
        if index == devices.len() {
            devices.push(device);
        }
        match all.iter_mut().find(|(_, line)| line.class == kernel && line.points == points) {
            Some((names, _)) => names.push(short),
            None => {
                let series = Series { name: String::new(), class: kernel, device: index, points };
                all.push((vec![short], series));
            }
        }
    }
    let named = |(devices, series): (Vec<String>, Series)| match list(&devices) {
        none if none.is_empty() => Series { name: series.class.into(), ..series },
        devices => Series { name: format!("{}, {devices}", series.class), ..series },
    };
    all.into_iter().map(named).collect()
}

fn time(time: &TimeSpread) -> [f64; 3] {
    [time.median, time.min, time.max]
}
