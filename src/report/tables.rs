//! The report's tables, made once for all printers; [`super::print`] has these.

use super::figures::{
    NONE, count, distribution, figure, percent, quantity, stages, t_p999, typeset, wrong,
};
use super::summary::{Cast, classes, lines, xs};
use super::{
    ClassResult, Contestant, Distribution, Errors, Report, Row, SceneResult, Spread, Sweep,
};

/// Rows of cells under a head.
pub struct Table {
    /// Columns at the left that hold names; the others hold figures.
    pub n_names: usize,
    /// The head.
    pub columns: Vec<Column>,
    /// The rows.
    pub groups: Vec<Group>,
}

/// The head of a column.
#[derive(Clone, PartialEq)]
pub struct Column {
    /// Stands over all neighbours that have the same; empty for none.
    pub over: String,
    /// The column's own name.
    pub name: String,
}

/// Rows that belong together.
pub struct Group {
    /// What they have in common; empty where there is one group alone.
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
    /// How it may be marked.
    pub mark: Mark,
}

/// How a cell may be marked.
#[derive(Clone, Copy, PartialEq)]
pub enum Mark {
    /// Not at all.
    Plain,
    /// As the name of a kernel.
    Kernel,
    /// As a count of wrong ids that is not 0.
    Wrong,
    /// As a count of wrong ids that is 0, or of nothing.
    Right,
}

/// Columns side by side, under one heading.
type Columns = (&'static str, &'static [&'static str]);

const NAMES: Columns = ("", &["kernel", "device"]);
const FAULTS: Columns = ("wrong ids", &["share", "false hit", "false miss", "another"]);
const T_ULP: Columns = ("error of t, ulp", &["median", "99.9 %", "largest"]);
const STAGES: Columns = ("decided in", &["f32", "f64", "exact"]);

/// The classes: how wrong.
pub fn class_errors(report: &Report, cast: &Cast) -> Table {
    let row = |result: &ClassResult| {
        let errors = &result.errors;
        let [.., normal] = distribution(errors.normal_degrees.as_ref());
        let normal = vec![plain(normal)];
        let t = quantiles(errors.t_ulp.as_ref());
        [names(&result.contestant, cast), faults(errors), t, normal].concat()
    };
    Table {
        n_names: 2,
        columns: columns(&[NAMES, FAULTS, T_ULP, ("normal, °", &["largest"])]),
        groups: by_class(report, row),
    }
}

/// The classes: how fast, and which stage decided.
pub fn class_costs(report: &Report, cast: &Cast) -> Table {
    let row = |result: &ClassResult| {
        let times = [&result.trace_ns_per_ray, &result.surface_ns_per_ray];
        let times = times.map(|spread| time(Some(spread))).to_vec();
        [names(&result.contestant, cast), times, decided(&result.errors)].concat()
    };
    let times: Columns = ("time, ns a ray", &["ids", "with t and normals"]);
    Table { n_names: 2, columns: columns(&[NAMES, times, STAGES]), groups: by_class(report, row) }
}

/// The classes in a few columns.
pub fn summary(report: &Report, cast: &Cast) -> Table {
    let row = |result: &ClassResult| {
        let class = plain(result.class.name());
        let figures = [
            wrong_share(&result.errors),
            plain(t_p999(&result.errors)),
            time(Some(&result.trace_ns_per_ray)),
        ];
        [vec![class], names(&result.contestant, cast), figures.to_vec()].concat()
    };
    Table {
        n_names: 3,
        columns: columns(&[(
            "",
            &[
                "scenes",
                "kernel",
                "device",
                "rays with a wrong object",
                "error of `t`, 99.9 %, ulp",
                "ns a ray (least–most)",
            ],
        )]),
        groups: vec![Group { name: String::new(), rows: report.classes.iter().map(row).collect() }],
    }
}

/// Many spheres.
pub fn clouds(report: &Report, cast: &Cast) -> Table {
    let rows = report.clouds.iter().map(|cloud| {
        let [_, f64, exact] = stages(&cloud.errors);
        vec![
            plain(typeset(&format!("{:e}", cloud.n_spheres))),
            plain(cast.short(&cloud.contestant.device)),
            time(Some(&cloud.picture_ms)),
            time(Some(&cloud.build_ms)),
            plain(f64),
            plain(exact),
            wrong_share(&cloud.errors),
        ]
    });
    Table {
        n_names: 2,
        columns: columns(&[(
            "",
            &[
                "spheres",
                "device",
                "ms a picture (least–most)",
                "building, ms",
                "decided in f64",
                "exactly",
                "wrong ids",
            ],
        )]),
        groups: vec![Group { name: String::new(), rows: rows.collect() }],
    }
}

/// All scenes: who was wrong, and the time of ids.
pub fn overview(report: &Report, cast: &Cast) -> Table {
    let mut head = columns(&[("", &["scene", "device"])]);
    for kernel in &cast.kernels {
        head.extend(
            ["wrong", "ns/ray"].map(|name| Column { over: kernel.to_string(), name: name.into() }),
        );
    }
    let rows_of = |scene: &SceneResult| -> Vec<Vec<Cell>> {
        let has_rows =
            |device: &&&str| scene.rows.iter().any(|row| row.contestant.device == **device);
        let row = |device: &&str| {
            let names = vec![plain(&scene.name), plain(cast.short(device))];
            let of_kernel = |kernel: &&str| overview_cells(find(scene, kernel, device));
            [names, cast.kernels.iter().flat_map(of_kernel).collect()].concat()
        };
        cast.devices.iter().filter(has_rows).map(row).collect()
    };
    let groups = classes(report).into_iter().map(|class| Group {
        name: class.name().into(),
        rows: report.scenes.iter().filter(|s| s.class == class).flat_map(rows_of).collect(),
    });
    Table { n_names: 2, columns: head, groups: groups.collect() }
}

fn find<'a>(scene: &'a SceneResult, kernel: &str, device: &str) -> Option<&'a Row> {
    let of = |row: &&Row| row.contestant.kernel == kernel && row.contestant.device == device;
    scene.rows.iter().find(of)
}

fn overview_cells(row: Option<&Row>) -> [Cell; 2] {
    let Some(Row { errors, cost, .. }) = row else { return [plain(NONE), plain(NONE)] };
    let share = match (errors.rays, errors.wrong_ids()) {
        (0, _) => NONE.to_string(),
        (_, 0) => "0".to_string(),
        (rays, wrong) => percent(wrong, rays),
    };
    [Cell { text: share, ..wrong_share(errors) }, plain(figure(cost.trace_ns_per_ray.median))]
}

/// All figures of one scene: errors, more errors, costs.
pub fn scene(scene: &SceneResult, cast: &Cast) -> [Table; 3] {
    let table = |parts: &[Columns], cells: fn(&Row) -> Vec<Cell>| {
        let row = |row: &Row| [names(&row.contestant, cast), cells(row)].concat();
        let rows = scene.rows.iter().map(row).collect();
        Table {
            n_names: 2,
            columns: columns(parts),
            groups: vec![Group { name: String::new(), rows }],
        }
    };
    let quantile_names = T_ULP.1;
    let errors = table(&[NAMES, ("", &["rays compared"]), FAULTS, T_ULP], |row| {
        let errors = &row.errors;
        let rays = vec![plain(errors.rays.to_string())];
        [rays, faults(errors), quantiles(errors.t_ulp.as_ref())].concat()
    });
    let parts = [
        NAMES,
        ("error of t, relative", quantile_names),
        ("error of the normal, °", quantile_names),
        STAGES,
    ];
    let more_errors = table(&parts, |row| {
        let errors = &row.errors;
        let t = quantiles(errors.t_relative.as_ref());
        [t, quantiles(errors.normal_degrees.as_ref()), decided(errors)].concat()
    });
    let parts = [
        NAMES,
        ("time, ns a ray", &["ids", "with t and normals", "device's clock"][..]),
        ("time, ms", &["read-back", "compiling", "first picture"]),
        ("", &["bytes on the device"]),
    ];
    let costs = table(&parts, |row| {
        let cost = &row.cost;
        vec![
            time(Some(&cost.trace_ns_per_ray)),
            time(Some(&cost.surface_ns_per_ray)),
            time(cost.device_ns_per_ray.as_ref()),
            time(Some(&cost.readback_ms)),
            time(Some(&cost.compile_ms)),
            time(Some(&cost.first_picture_ms)),
            plain(cost.bytes_device.to_string()),
        ]
    });
    [errors, more_errors, costs]
}

/// All numbers of a sweep: a row an x, and columns for each line.
pub fn sweep(sweep: &Sweep, cast: &Cast) -> Table {
    let lines = lines(sweep);
    let points = || sweep.series.iter().flat_map(|series| &series.points);
    let has_errors = points().any(|point| point.errors.is_some());
    let has_times = points().any(|point| point.trace_ns_per_ray.is_some());
    let mut head = vec![Column { over: String::new(), name: sweep.x_label.into() }];
    for line in &lines {
        let over = line.label(cast);
        let errors = ["wrong ids", "t, 99.9 %, ulp"].into_iter().filter(|_| has_errors);
        let times = ["ns a ray"].into_iter().filter(|_| has_times);
        let names = errors.chain(times);
        head.extend(names.map(|name| Column { over: over.clone(), name: name.into() }));
    }
    let rows = xs(sweep).into_iter().map(|x| {
        let mut cells = vec![plain(quantity(x))];
        for line in &lines {
            let point = line.series.points.iter().find(|point| point.x == x);
            if has_errors {
                let errors = point.and_then(|point| point.errors.as_ref());
                cells.push(errors.map_or(plain(NONE), wrong_share));
                cells.push(errors.map_or(plain(NONE), |errors| plain(t_p999(errors))));
            }
            if has_times {
                cells.push(time(point.and_then(|point| point.trace_ns_per_ray.as_ref())));
            }
        }
        cells
    });
    Table {
        n_names: 1,
        columns: head,
        groups: vec![Group { name: String::new(), rows: rows.collect() }],
    }
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

fn columns(parts: &[Columns]) -> Vec<Column> {
    let of_part = |(over, names): &Columns| {
        let column = |name: &&str| Column { over: over.to_string(), name: name.to_string() };
        names.iter().map(column).collect::<Vec<_>>()
    };
    parts.iter().flat_map(of_part).collect()
}

fn plain(text: impl Into<String>) -> Cell {
    Cell { text: text.into(), range: None, mark: Mark::Plain }
}

/// Kernel and device.
fn names(contestant: &Contestant, cast: &Cast) -> Vec<Cell> {
    let kernel = Cell { mark: Mark::Kernel, ..plain(&contestant.kernel) };
    vec![kernel, plain(cast.short(&contestant.device))]
}

fn wrong_share(errors: &Errors) -> Cell {
    let mark = if errors.wrong_ids() > 0 { Mark::Wrong } else { Mark::Right };
    Cell { mark, ..plain(wrong(errors)) }
}

/// The share of wrong ids and the counts of each sort.
fn faults(errors: &Errors) -> Vec<Cell> {
    let counts = [errors.false_hits, errors.false_misses, errors.wrong_object];
    let counts = counts.map(|n| plain(n.to_string()));
    [vec![wrong_share(errors)], counts.to_vec()].concat()
}

fn quantiles(of: Option<&Distribution>) -> Vec<Cell> {
    distribution(of).map(plain).to_vec()
}

fn decided(errors: &Errors) -> Vec<Cell> {
    stages(errors).map(plain).to_vec()
}

/// Median with its range.
fn time(spread: Option<&Spread>) -> Cell {
    match spread {
        Some(spread) if spread.n > 0 => {
            let range = (spread.n > 1).then(|| [spread.min, spread.max].map(figure));
            Cell { range, ..plain(figure(spread.median)) }
        }
        _ => plain(NONE),
    }
}
