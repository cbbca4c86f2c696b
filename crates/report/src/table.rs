//! Tables of a report, for all renderers.

use kugelblitz::plain::plain_document;
use kugelblitz::words::{NONE, count, digits, percent};

use super::{ErrorQuantiles, KernelOnDevice, RayErrors, Report, Settings, TimeSpread};

/// Titles of the tables with charts.
pub const SUMMARY: &str = "Speed against error";
pub const DISTANCE: &str = "Error against distance";
pub const SPHERES: &str = "Time against number of spheres";
pub const SHADOWS: &str = "Shadows with and without an epsilon";

/// Notes of other tables.
const ERRORS: &str = "Share of rays with a wrong object, and error of t that 99.9 % of the others do not exceed, in f32 steps.";
const TIMES: &str =
    "Median with its range. Tracing finds the visible object of each pixel, without the read-back.";
const BUILDS: &str = "Median with its range, milliseconds.";

/// Rows of cells with a head.
pub struct Table {
    /// Title.
    pub title: &'static str,
    /// Meaning of the figures.
    pub note: &'static str,
    /// Heads of the columns.
    pub columns: Vec<Column>,
    /// Number of columns that name a row.
    pub n_names: usize,
    /// Cells of each row, as many as there are columns.
    pub rows: Vec<Vec<String>>,
}

/// Head of a column.
pub struct Column {
    /// Heading over several columns; empty for none.
    pub over: String,
    /// Name of the column.
    pub name: String,
}

/// Names of a row without its kernel, the kernel, and its figures.
type TableLine = (Vec<String>, &'static str, Vec<String>);

/// Returns all tables that have rows.
pub fn tables(report: &Report) -> Vec<Table> {
    let device = |of: &KernelOnDevice| report.short(&of.device);
    let classes = report.classes.iter().map(|row| {
        let names = vec![row.class.name().into(), device(&row.of)];
        let figures = [wrong(&row.errors), p999(row.errors.t_ulp), time(&row.ns_per_ray)];
        [names, vec![row.of.kernel.into()], figures.to_vec()].concat()
    });
    let scene_errors = report.rays.iter().map(|row| {
        let names = vec![name(&row.scene), device(&row.of)];
        (names, row.of.kernel, vec![wrong(&row.errors), p999(row.errors.t_ulp)])
    });
    let scene_times = report.rays.iter().map(|row| {
        (vec![name(&row.scene), device(&row.of)], row.of.kernel, vec![time(&row.ns_per_ray)])
    });
    let distance = report.distance.iter().map(|row| {
        let names = vec![number(row.distance), device(&row.of)];
        (names, row.of.kernel, vec![wrong(&row.errors), p999(row.errors.t_ulp)])
    });
    let spheres = report.spheres.iter().map(|row| {
        let names = vec![row.spheres.to_string(), device(&row.of)];
        (names, row.of.kernel, vec![time(&row.ns_per_ray)])
    });
    let builds = report.spheres.iter().filter(|row| row.build_ms.max > 0.0).map(|row| {
        let names = vec![row.spheres.to_string(), device(&row.of)];
        (names, row.of.kernel, vec![time(&row.build_ms)])
    });
    let shadows = report.shadows.iter().map(|row| {
        let epsilon = row.epsilon.filter(|epsilon| *epsilon > 0.0);
        let names = vec![name(&row.scene), epsilon.map_or("none".into(), number)];
        let shares = [row.false_shadows, row.leaks].map(|n| share(n, row.shadow_rays));
        (names, row.kernel, shares.to_vec())
    });
    let columns = ["scenes", "device", "kernel", "wrong rays", "error of t, ulp", "ns per ray"];
    let mut tables = vec![
        Table {
            title: SUMMARY,
            note: "Share of rays with a wrong object; error of t that 99.9 % of the rays do not exceed, in f32 steps, in \
                   the worst scene; time per ray with its range, as geometric means over the scenes.",
            columns: columns.map(|name| Column { over: String::new(), name: name.into() }).into(),
            n_names: 3,
            rows: classes.collect(),
        },
        by_kernel(
            "Error by scene",
            ERRORS,
            ["scene", "device"],
            &["wrong", "t, ulp"],
            scene_errors,
        ),
        by_kernel("Time by scene", TIMES, ["scene", "device"], &["ns per ray"], scene_times),
        by_kernel(
            DISTANCE,
            "A sphere of radius 1; half of the rays pass close to its silhouette. Distance of the centre from the camera.",
            ["distance", "device"],
            &["wrong", "t, ulp"],
            distance,
        ),
        by_kernel(
            SPHERES,
            "Uniform in a cube, all in view. Only certified has a hierarchy; the other kernels test each ray against \
             each sphere.",
            ["spheres", "device"],
            &["ns per ray"],
            spheres,
        ),
        by_kernel("Building the hierarchy", BUILDS, ["spheres", "device"], &["ms"], builds),
        by_kernel(
            SHADOWS,
            "Shares of pixels times lights: acne is a light that is left out although nothing occludes it, a leak a \
             light that is counted although it is occluded. ε is the distance from the surface at which shadow rays \
             start, in units of the scene; certified has none.",
            ["scene", "ε"],
            &["acne", "leaks"],
            shadows,
        ),
    ];
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// Returns a table with a column for each kernel and figure. If neighbouring rows differ only in their second name, such as the
/// device, they share a row.
fn by_kernel(
    title: &'static str,
    note: &'static str,
    names: [&'static str; 2],
    figures: &[&'static str],
    lines: impl Iterator<Item = TableLine>,
) -> Table {
    let (mut kernels, mut rows) = (Vec::new(), Vec::<(Vec<String>, Vec<Vec<String>>)>::new());
    for (names, kernel, cells) in lines {
        let at = kernels.iter().position(|known| *known == kernel).unwrap_or(kernels.len());
        if at == kernels.len() {
            kernels.push(kernel);
        }
        let known = rows.iter().position(|(known, _)| *known == names).unwrap_or(rows.len());
        if known == rows.len() {
            rows.push((names, Vec::new()));
        }
        let row = &mut rows[known].1;
        row.resize(row.len().max(at), vec![NONE.to_string(); figures.len()]);
        row.push(cells);
    }
    let named = names.map(|name| Column { over: String::new(), name: name.into() });
    let of_kernel = kernels.iter().flat_map(|kernel| {
        figures.iter().map(|figure| Column { over: (*kernel).into(), name: (*figure).into() })
    });
    let mut table = Table {
        title,
        note,
        columns: named.into_iter().chain(of_kernel).collect(),
        n_names: names.len(),
        rows: Vec::new(),
    };
    for (mut names, mut cells) in rows {
        cells.resize(kernels.len(), vec![NONE.to_string(); figures.len()]);
        names.extend(cells.concat());
        match table.rows.last_mut() {
            Some(last) if last[0] == names[0] && last[2..] == names[2..] => {
                last[1] = format!("{}, {}", last[1], names[1]);
            }
            _ => table.rows.push(names),
        }
    }
    table
}

/// Returns machine, program and settings with their names.
pub fn facts(report: &Report) -> Vec<(&'static str, String)> {
    let Settings { size: [width, height], samples, seed, rounds, runs, .. } = report.settings;
    let mut facts = report.environment.facts();
    facts.push(("Pictures", format!("{width} × {height} pixels")));
    facts.push((
        "Errors",
        format!("against exact arithmetic, up to {samples} pixels of each picture (seed {seed})"),
    ));
    let (runs, rounds) = (count(rounds * runs, "run"), count(rounds, "round"));
    facts.push(("Times", format!("median of {runs} in {rounds} (minimum–maximum)")));
    facts.into_iter().map(|(what, fact)| (what, name(&fact))).collect()
}

impl Report {
    /// Returns the name of a device without its parentheses, if it is unique.
    pub(crate) fn short(&self, device: &str) -> String {
        let short = |device: &str| device.split(" (").next().unwrap_or_default().to_string();
        let adapters = self.environment.adapters.iter().map(|adapter| &adapter.facts.name);
        let alike = adapters.filter(|other| short(other) == short(device)).count();
        name(&if alike > 1 { device.into() } else { short(device) })
    }
}

/// Returns a name that cannot break a line, a terminal or a document.
pub fn name(text: &str) -> String {
    plain_document(text).replace('\n', "\u{fffd}")
}

/// Returns a number with all digits if they are few, otherwise with three.
pub fn number(x: f64) -> String {
    let exact = [x.to_string(), format!("{x:e}")];
    exact.into_iter().find(|text| text.len() <= 6).unwrap_or_else(|| digits(x, 3))
}

/// Returns a time with its range, `12.3 (11.9–14.0)`.
pub fn time(time: &TimeSpread) -> String {
    let [median, min, max] = [time.median, time.min, time.max].map(|x| digits(x, 3));
    format!("{median} ({min}–{max})")
}

fn p999(errors: Option<ErrorQuantiles>) -> String {
    errors.map_or(NONE.into(), |errors| digits(errors.p999, 3))
}

fn share(n: u64, of: u64) -> String {
    if n == 0 && of > 0 { "0".into() } else { percent(n, of) }
}

/// Returns the share of rays with a wrong object.
pub fn wrong(errors: &RayErrors) -> String {
    share(errors.wrong(), errors.compared)
}
