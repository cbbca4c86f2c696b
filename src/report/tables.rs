//! The report's tables, made once for all printers; [`super::print`] has these.

use super::figures::{
    NONE, count, digits, digits_borne, figure, median, percent, quantity, range, typeset, wrong,
};
use super::summary::{Cast, classes, shared_series, xs};
use super::{
    Baseline, Change, Class, ClassResult, Contestant, Distribution, Errors, LightErrors,
    LightResult, LightRow, Report, Row, SceneResult, Spread, Sweep, Verdict, WrongIds,
};

/// Rows of cells under a head.
pub struct Table {
    /// The head: first the names of a row, then its figures.
    pub parts: Vec<Part>,
    /// The rows.
    pub groups: Vec<Group>,
}

/// Neighbouring columns.
pub struct Part {
    /// Stands over them; empty for none.
    pub over: String,
    /// Place of the first one among all columns.
    pub first: usize,
    /// The columns' own names.
    pub columns: Vec<String>,
}

/// Rows that belong together.
pub struct Group {
    /// Their class; empty where there is one group alone.
    pub name: String,
    /// As many cells in each as there are columns.
    pub rows: Vec<Vec<Cell>>,
}

/// A name or a figure.
#[derive(Clone)]
pub struct Cell {
    /// The name, or the figure as [`figure`] writes it.
    pub text: String,
    /// Least and largest value beside a median.
    pub range: Option<[String; 2]>,
    /// How it stands out.
    pub emphasis: Emphasis,
}

/// How a cell stands out.
#[derive(Clone, Copy, PartialEq)]
pub enum Emphasis {
    /// Not at all.
    Plain,
    /// As the name of a kernel.
    Kernel,
    /// As a count of wrong ids that is not 0.
    Wrong,
    /// As a count of wrong ids that is 0, or of nothing.
    Right,
}

impl Table {
    fn new(names: &[&str], parts: &[Columns], groups: Vec<Group>) -> Table {
        let mut first = 0;
        let part = |(over, names): &Columns| {
            let columns = names.iter().map(|name| name.to_string()).collect();
            let part = Part { over: over.to_string(), first, columns };
            first += names.len();
            part
        };
        Table { parts: [("", names)].iter().chain(parts).map(part).collect(), groups }
    }

    pub fn is_empty(&self) -> bool {
        self.groups.iter().all(|group| group.rows.is_empty())
    }
}

/// Columns side by side, under one heading.
type Columns<'a> = (&'a str, &'a [&'a str]);

const NAMES: &[&str] = &["kernel", "device"];
const QUANTILES: &[&str] = &["median", "99.9 %", "largest"];
const FAULTS: Columns = ("wrong ids", &["share", "false hit", "false miss", "another"]);
const T_ULP: Columns = ("error of t, ulp", QUANTILES);
const STAGES: Columns = ("decided in", &["f32", "f64", "exact"]);

/// The classes: how wrong.
pub fn class_errors(report: &Report, cast: &Cast) -> Table {
    let row = |result: &ClassResult| {
        let errors = &result.errors;
        let [.., normal] = quantiles(&errors.normal_degrees);
        let t = quantiles(&errors.t_ulp);
        [&names(&result.contestant, cast)[..], &faults(errors), &t, &[normal]].concat()
    };
    let parts = [FAULTS, T_ULP, ("normal, °", &["largest"])];
    Table::new(NAMES, &parts, by_class(report, row))
}

/// The classes: how fast, and which stage decided.
pub fn class_costs(report: &Report, cast: &Cast) -> Table {
    let row = |result: &ClassResult| {
        let times = [&result.trace_ns_per_ray, &result.surface_ns_per_ray].map(time);
        [&names(&result.contestant, cast)[..], &times, &decided(&result.errors)].concat()
    };
    let times: Columns = ("time, ns a ray", &["ids", "with t and normals"]);
    Table::new(NAMES, &[times, STAGES], by_class(report, row))
}

/// The classes in a few columns.
pub fn summary(report: &Report, cast: &Cast) -> Table {
    let row = |result: &ClassResult| {
        let [_, t, _] = quantiles(&result.errors.t_ulp);
        let figures = [wrong_share(&result.errors), t, time(&result.trace_ns_per_ray)];
        [&[cell(result.class.name())], &names(&result.contestant, cast)[..], &figures].concat()
    };
    let figures =
        ["rays with a wrong object", "error of `t`, 99.9 %, ulp", "ns a ray (least–most)"];
    let rows = report.classes.iter().map(row).collect();
    Table::new(&["scenes", "kernel", "device"], &[("", &figures)], one_group(rows))
}

/// Many spheres.
pub fn clouds(report: &Report, cast: &Cast) -> Table {
    let rows = report.clouds.iter().map(|cloud| {
        let [_, f64, exact] = decided(&cloud.errors);
        vec![
            cell(typeset(&format!("{:e}", cloud.n_spheres))),
            cell(cast.short(&cloud.contestant.device)),
            time(&cloud.picture_ms),
            time(&cloud.build_ms),
            f64,
            exact,
            wrong_share(&cloud.errors),
        ]
    });
    let figures =
        ["ms a picture (least–most)", "building, ms", "decided in f64", "exactly", "wrong ids"];
    Table::new(&["spheres", "device"], &[("", &figures)], one_group(rows.collect()))
}

/// Times that changed by more than noise since an earlier report.
pub fn changes(baseline: &Baseline, cast: &Cast) -> Table {
    let row = |change: &Change| {
        let (mark, emphasis) = match change.verdict {
            Verdict::Slower => ("▲ slower", Emphasis::Wrong),
            _ => ("▼ faster", Emphasis::Plain),
        };
        let [kernel, device] = names(&change.contestant, cast);
        let n_digits = digits_borne(&change.before).min(digits_borne(&change.now));
        let ratio = format!("× {}", digits(change.ratio, n_digits));
        let figures = [time(&change.before), time(&change.now), cell(ratio)];
        let mark = Cell { emphasis, ..cell(mark) };
        [&[cell(&change.of), kernel, device, cell(change.what)], &figures[..], &[mark]].concat()
    };
    let columns = ["before", "now", "change", ""];
    let rows = baseline.beyond_noise().map(row).collect();
    Table::new(&["of", "kernel", "device", "time"], &[("", &columns)], one_group(rows))
}

/// Numbers of wrong ids that changed since an earlier report.
pub fn changed_ids(baseline: &Baseline, cast: &Cast) -> Table {
    let row = |wrong: &WrongIds| {
        let [kernel, device] = names(&wrong.contestant, cast);
        let n = [wrong.rays, wrong.before, wrong.now].map(|n| cell(n.to_string()));
        [&[cell(&wrong.of), kernel, device][..], &n].concat()
    };
    let columns = ["rays compared", "wrong before", "wrong now"];
    let rows = baseline.wrong_ids.iter().map(row).collect();
    Table::new(&["scene", "kernel", "device"], &[("", &columns)], one_group(rows))
}

/// Lit scenes: wrong shadows and bytes of each kernel with each epsilon.
pub fn light(report: &Report, cast: &Cast) -> Table {
    let rows = || report.light.iter().flat_map(|result| &result.rows);
    let mut columns: Vec<(&str, Vec<Option<f64>>)> = Vec::new();
    for kernel in &cast.kernels {
        let mut epsilons: Vec<Option<f64>> = Vec::new();
        for row in rows().filter(|row| row.contestant.kernel == *kernel) {
            if !epsilons.contains(&row.epsilon) {
                epsilons.push(row.epsilon);
            }
        }
        columns.push((*kernel, epsilons));
    }
    columns.retain(|(_, epsilons)| !epsilons.is_empty());
    let counted: [(&str, Counted); 2] = [
        ("shadows", |errors| (errors.wrong_shadows(), errors.verdicts)),
        ("bytes", |errors| (errors.wrong_bytes, errors.pixels)),
    ];
    let row = |result: &LightResult, (what, counted): (&str, Counted)| {
        let share = |kernel: &str, epsilon: Option<f64>| {
            let mut rows = result.rows.iter();
            let is_of = |row: &&LightRow| row.contestant.kernel == kernel && row.epsilon == epsilon;
            rows.find(is_of).map_or(cell(NONE), |row| share_of(counted(&row.errors)))
        };
        let of_kernel = |(kernel, epsilons): &(&str, Vec<Option<f64>>)| -> Vec<Cell> {
            epsilons.iter().map(|epsilon| share(kernel, *epsilon)).collect()
        };
        let names = vec![cell(&result.scene), cell(what)];
        [names, columns.iter().flat_map(of_kernel).collect()].concat()
    };
    let rows = report.light.iter().flat_map(|result| counted.map(|counted| row(result, counted)));
    let names: Vec<Vec<String>> = columns
        .iter()
        .map(|(_, epsilons)| epsilons.iter().map(|epsilon| with_epsilon(*epsilon)).collect())
        .collect();
    let names: Vec<Vec<&str>> =
        names.iter().map(|names| names.iter().map(String::as_str).collect()).collect();
    let parts: Vec<Columns> =
        columns.iter().zip(&names).map(|((kernel, _), names)| (*kernel, &names[..])).collect();
    Table::new(&["lit scene", "wrong"], &parts, one_group(rows.collect()))
}

/// Wrong ones of a sort, and how many there are of it.
type Counted = fn(&LightErrors) -> (u64, u64);

/// `ε = 10⁻³`
pub fn with_epsilon(epsilon: Option<f64>) -> String {
    match epsilon {
        None | Some(0.0) => "no ε".to_string(),
        Some(epsilon) => format!("ε = {}", typeset(&format!("{epsilon:e}"))),
    }
}

/// A share of wrong ones, `0` of none.
fn share_of((wrong, of): (u64, u64)) -> Cell {
    match (wrong, of) {
        (_, 0) => cell(NONE),
        (0, _) => Cell { emphasis: Emphasis::Right, ..cell("0") },
        _ => Cell { emphasis: Emphasis::Wrong, ..cell(percent(wrong, of)) },
    }
}

/// All scenes: who was wrong, and the time of ids.
pub fn overview(report: &Report, cast: &Cast) -> Table {
    let rows_of = |scene: &SceneResult| -> Vec<Vec<Cell>> {
        let row = |device: &&str| {
            let find = |kernel: &&str| {
                let is_of = |row: &&Row| {
                    row.contestant.kernel == *kernel && row.contestant.device == *device
                };
                overview_cells(scene.rows.iter().find(is_of))
            };
            let names = vec![cell(&scene.name), cell(cast.short(device))];
            [names, cast.kernels.iter().flat_map(find).collect()].concat()
        };
        let is_of = |device: &&&str| scene.rows.iter().any(|row| row.contestant.device == **device);
        cast.devices.iter().filter(is_of).map(row).collect()
    };
    let group = |class| Group {
        name: Class::name(class).into(),
        rows: report.scenes.iter().filter(|s| s.class == class).flat_map(rows_of).collect(),
    };
    let parts: Vec<Columns> =
        cast.kernels.iter().map(|kernel| (*kernel, &["wrong", "ns/ray"][..])).collect();
    Table::new(&["scene", "device"], &parts, classes(report).into_iter().map(group).collect())
}

fn overview_cells(row: Option<&Row>) -> [Cell; 2] {
    let Some(Row { errors, cost, .. }) = row else { return [cell(NONE), cell(NONE)] };
    [share_of((errors.wrong_ids(), errors.rays)), time_alone(&cost.trace_ns_per_ray)]
}

/// All figures of one scene: errors, more errors, costs.
pub fn scene(scene: &SceneResult, cast: &Cast) -> [Table; 3] {
    let table = |parts: &[Columns], cells: fn(&Row) -> Vec<Cell>| {
        let row = |row: &Row| [&names(&row.contestant, cast)[..], &cells(row)].concat();
        Table::new(NAMES, parts, one_group(scene.rows.iter().map(row).collect()))
    };
    let errors = table(&[("", &["rays compared"]), FAULTS, T_ULP], |row| {
        let rays = cell(row.errors.rays.to_string());
        [&[rays], &faults(&row.errors)[..], &quantiles(&row.errors.t_ulp)].concat()
    });
    let parts =
        [("error of t, relative", QUANTILES), ("error of the normal, °", QUANTILES), STAGES];
    let more_errors = table(&parts, |row| {
        let Errors { t_relative, normal_degrees, .. } = &row.errors;
        [quantiles(t_relative), quantiles(normal_degrees), decided(&row.errors)].concat()
    });
    let parts = [
        ("time, ns a ray", &["ids", "with t and normals", "device's clock"][..]),
        ("time, ms", &["read-back", "compiling", "first picture"]),
        ("", &["bytes on the device"]),
    ];
    let costs = table(&parts, |row| {
        let cost = &row.cost;
        vec![
            time(&cost.trace_ns_per_ray),
            time(&cost.surface_ns_per_ray),
            time(&cost.device_ns_per_ray.unwrap_or_default()),
            time(&cost.readback_ms),
            time(&cost.compile_ms),
            time(&cost.first_picture_ms),
            cell(cost.bytes_device.to_string()),
        ]
    });
    [errors, more_errors, costs]
}

/// All numbers of a sweep: a row an x, and columns for each line.
pub fn sweep(sweep: &Sweep, cast: &Cast) -> Table {
    let lines = shared_series(sweep);
    let points = || sweep.series.iter().flat_map(|series| &series.points);
    let has_errors = points().any(|point| point.errors.is_some());
    let has_times = points().any(|point| point.trace_ns_per_ray.is_some());
    let row = |x: f64| {
        let mut cells = vec![cell(quantity(x))];
        for line in &lines {
            let point = line.series.points.iter().find(|point| point.x == x);
            if has_errors {
                let errors = point.and_then(|point| point.errors.clone()).unwrap_or_default();
                let [_, t, _] = quantiles(&errors.t_ulp);
                cells.extend([wrong_share(&errors), t]);
            }
            if has_times {
                let spread = point.and_then(|point| point.trace_ns_per_ray);
                cells.push(time(&spread.unwrap_or_default()));
            }
        }
        cells
    };
    let names: &[&str] = match (has_errors, has_times) {
        (true, true) => &["wrong ids", "t, 99.9 %, ulp", "ns a ray"],
        (true, false) => &["wrong ids", "t, 99.9 %, ulp"],
        (false, _) => &["ns a ray"],
    };
    let labels: Vec<String> = lines.iter().map(|line| line.label(cast)).collect();
    let parts: Vec<Columns> = labels.iter().map(|label| (label.as_str(), names)).collect();
    Table::new(&[sweep.x_label], &parts, one_group(xs(sweep).into_iter().map(row).collect()))
}

/// One group a class, under its name.
fn by_class(report: &Report, row: impl Fn(&ClassResult) -> Vec<Cell>) -> Vec<Group> {
    let group = |class| {
        let results = || report.classes.iter().filter(move |result| result.class == class);
        let n_scenes = results().map(|result| result.n_scenes).max().unwrap_or(0);
        let n_rays = results().map(|result| result.errors.rays).max().unwrap_or(0);
        let n_scenes = count(n_scenes, "scene");
        Group {
            name: format!("{}: {n_scenes}, {n_rays} rays compared", class.name()),
            rows: results().map(&row).collect(),
        }
    };
    classes(report).into_iter().map(group).collect()
}

fn one_group(rows: Vec<Vec<Cell>>) -> Vec<Group> {
    vec![Group { name: String::new(), rows }]
}

fn cell(text: impl Into<String>) -> Cell {
    Cell { text: text.into(), range: None, emphasis: Emphasis::Plain }
}

/// Kernel and device.
fn names(contestant: &Contestant, cast: &Cast) -> [Cell; 2] {
    let kernel = Cell { emphasis: Emphasis::Kernel, ..cell(&contestant.kernel) };
    [kernel, cell(cast.short(&contestant.device))]
}

fn wrong_share(errors: &Errors) -> Cell {
    let emphasis = if errors.wrong_ids() > 0 { Emphasis::Wrong } else { Emphasis::Right };
    Cell { emphasis, ..cell(wrong(errors)) }
}

/// The share of wrong ids and the counts of each sort.
fn faults(errors: &Errors) -> [Cell; 4] {
    let [false_hits, false_misses, wrong_object] =
        [errors.false_hits, errors.false_misses, errors.wrong_object].map(|n| cell(n.to_string()));
    [wrong_share(errors), false_hits, false_misses, wrong_object]
}

/// Median, 99.9 % and largest.
fn quantiles(of: &Option<Distribution>) -> [Cell; 3] {
    match of {
        Some(of) => [of.median, of.p999, of.max].map(|x| cell(figure(x))),
        None => [NONE; 3].map(cell),
    }
}

/// The shares of rays that f32, f64 and exact arithmetic decided.
fn decided(errors: &Errors) -> [Cell; 3] {
    let stages = errors.stages;
    [stages.f32, stages.f64, stages.exact].map(|part| match part {
        0 if stages.total() > 0 => cell("0"),
        _ => cell(percent(part, stages.total())),
    })
}

/// Median alone.
fn time_alone(spread: &Spread) -> Cell {
    Cell { range: None, ..time(spread) }
}

/// Median with its range.
fn time(spread: &Spread) -> Cell {
    match spread.n {
        0 => cell(NONE),
        1 => cell(median(spread)),
        _ => Cell { range: Some(range(spread)), ..cell(median(spread)) },
    }
}
