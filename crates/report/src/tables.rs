//! The report's tables: what each row shows is a line of named cells; [`table`] makes them all, and
//! [`super::print`] prints them.

use super::Count::*;
use super::Metric::*;
use super::figures::{
    NONE, count, digits, digits_borne, figure, percent, quantity, rounded, typeset,
};
use super::order::{Series, grouped};
use super::{
    Baseline, Change, Class, Count, Metric, Of, Report, Row, RowKey, Spread, Sweep, TimeVerdict,
    WrongIds,
};

/// Rows of cells under a head.
pub struct Table {
    /// The head: first the names of a row, then its figures.
    pub columns: Vec<Column>,
    /// The rows.
    pub groups: Vec<Group>,
}

/// The head of a column.
#[derive(Clone, PartialEq)]
pub struct Column {
    /// Stands over it and its neighbours; empty for none.
    pub over: String,
    /// The column's own name.
    pub name: String,
    /// True where it names the rows.
    pub is_name: bool,
}

impl Column {
    /// True of neighbours that stand under one heading.
    pub fn is_beside(&self, other: &Column) -> bool {
        (self.is_name, &self.over) == (other.is_name, &other.over)
    }
}

/// Rows that belong together.
pub struct Group {
    /// Their class; empty where there is one group alone.
    pub name: String,
    /// As many cells in each as there are columns.
    pub rows: Vec<Vec<Cell>>,
}

/// A name or a figure.
#[derive(Clone, PartialEq)]
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
    /// As a count of wrong ids that is 0.
    Right,
}

impl Table {
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }
}

/// What a table shows of a thing: names first, then figures.
type Line = Vec<(Column, Cell)>;

/// Lines with the same names stand in one row, with the columns of each.
fn table(groups: Vec<(String, Vec<Line>)>) -> Table {
    let all = groups.iter().flat_map(|(_, lines)| lines).flatten();
    let columns = grouped(all, |(column, _)| column.clone());
    let columns: Vec<Column> = columns.into_iter().map(|(column, _)| column).collect();
    let names = |line: &Line| -> Line {
        line.iter().filter(|(column, _)| column.is_name).cloned().collect()
    };
    let row = |(_, lines): (_, Vec<Line>)| -> Vec<Cell> {
        let shown = |column: &Column| {
            let own = lines.iter().flatten().find(|(own, _)| own == column);
            own.map_or(cell(NONE), |(_, cell)| cell.clone())
        };
        columns.iter().map(shown).collect()
    };
    let groups = groups.into_iter().map(|(name, lines)| Group {
        name,
        rows: grouped(lines, names).into_iter().map(row).collect(),
    });
    Table { groups: groups.collect(), columns }
}

/// A table in one group.
fn plain<R>(rows: impl IntoIterator<Item = R>, line: impl Fn(R) -> Line) -> Table {
    table(vec![(String::new(), rows.into_iter().map(line).collect())])
}

/// A table with a group a class, each under its name.
fn by_class(report: &Report, line: impl Fn(&Row) -> Line) -> Table {
    let group = |(class, rows): (Class, Vec<&Row>)| {
        let most = |of| rows.iter().map(|row| row.count(of)).max().unwrap_or(0);
        let n_scenes = count(most(Scenes) as usize, "scene");
        let name = format!("{}: {n_scenes}, {} rays compared", class.name(), most(Rays));
        (name, rows.into_iter().map(&line).collect())
    };
    table(report.classes().into_iter().map(group).collect())
}

fn name(name: &str, cell: Cell) -> (Column, Cell) {
    (Column { over: String::new(), name: name.into(), is_name: true }, cell)
}

/// Figures under a heading, which may be empty.
fn under<const N: usize>(over: &str, figures: [(&str, Cell); N]) -> Line {
    let column = |name: &str| Column { over: over.into(), name: name.into(), is_name: false };
    figures.into_iter().map(|(name, cell)| (column(name), cell)).collect()
}

fn thing(title: &str, key: &RowKey) -> (Column, Cell) {
    name(title, cell(key.of.name()))
}

fn device(key: &RowKey, report: &Report) -> (Column, Cell) {
    name("device", cell(report.short(&key.device)))
}

fn config(key: &RowKey, report: &Report) -> Line {
    let kernel = Cell { emphasis: Emphasis::Kernel, ..cell(&key.kernel) };
    vec![name("kernel", kernel), device(key, report)]
}

fn faults(row: &Row) -> Line {
    let figures = [
        ("share", wrong_share(row)),
        ("false hit", cell(row.count(FalseHits))),
        ("false miss", cell(row.count(FalseMisses))),
        ("another", cell(row.count(WrongObject))),
    ];
    under("wrong ids", figures)
}

fn quantiles(row: &Row, over: &str, metric: Metric) -> Line {
    let figures = [
        ("median", error(row, metric, |errors| errors.median)),
        ("99.9 %", error(row, metric, |errors| errors.p999)),
        ("largest", error(row, metric, |errors| errors.max)),
    ];
    under(over, figures)
}

fn stages(row: &Row) -> Line {
    let stages = [("f32", F32), ("f64", F64), ("exact", Exact)];
    under("decided in", stages.map(|(name, stage)| (name, decided(row, stage))))
}

fn times<const N: usize>(row: &Row, over: &str, metrics: [(&str, Metric); N]) -> Line {
    under(over, metrics.map(|(name, metric)| (name, time(row, metric))))
}

/// The classes: how wrong.
pub fn class_errors(report: &Report) -> Table {
    by_class(report, |row| {
        let normal = [("largest", error(row, NormalDegrees, |errors| errors.max))];
        let t = quantiles(row, "error of t, ulp", TUlp);
        [config(&row.key, report), faults(row), t, under("normal, °", normal)].concat()
    })
}

/// The classes: how fast, and which stage decided.
pub fn class_costs(report: &Report) -> Table {
    by_class(report, |row| {
        let metrics = [("ids", TraceNsPerRay), ("with t and normals", SurfaceNsPerRay)];
        let times = times(row, "time, ns a ray", metrics);
        [config(&row.key, report), times, stages(row)].concat()
    })
}

/// The classes in a few columns.
pub fn summary(report: &Report) -> Table {
    plain(report.classes().into_iter().flat_map(|(_, rows)| rows), |row| {
        let figures = [
            ("rays with a wrong object", wrong_share(row)),
            ("error of `t`, 99.9 %, ulp", error(row, TUlp, |errors| errors.p999)),
            ("ns a ray (least–most)", time(row, TraceNsPerRay)),
        ];
        [vec![thing("scenes", &row.key)], config(&row.key, report), under("", figures)].concat()
    })
}

/// Many spheres.
pub fn clouds(report: &Report) -> Table {
    plain(report.rows_of(|of| matches!(of, Of::Cloud { .. })), |row| {
        let names = vec![thing("cloud", &row.key), device(&row.key, report)];
        let figures = [
            ("ms a picture (least–most)", time(row, PictureMs)),
            ("building, ms", time(row, BuildMs)),
            ("decided in f64", decided(row, F64)),
            ("exactly", decided(row, Exact)),
            ("wrong ids", wrong_share(row)),
        ];
        [names, under("", figures)].concat()
    })
}

/// Lit scenes: wrong shadows and bytes of each kernel with each epsilon.
pub fn light(report: &Report) -> Table {
    plain(report.rows_of(|of| matches!(of, Of::Light { .. })), |row| {
        let epsilon = cell(with_epsilon(row.key.epsilon));
        let wrong = [
            ("shadows", share(row.wrong_shadows(), row.count(Verdicts))),
            ("bytes", share(row.count(WrongBytes), row.count(Pixels))),
        ];
        let names = vec![thing("lit scene", &row.key), name("", epsilon)];
        [names, under(&row.key.kernel, wrong)].concat()
    })
}

/// All scenes: who was wrong, and the time of ids.
pub fn overview(report: &Report) -> Table {
    let line = |row: &Row| {
        let names = vec![thing("scene", &row.key), device(&row.key, report)];
        let time = Cell { range: None, ..time(row, TraceNsPerRay) };
        let figures = [("wrong", share(row.wrong_ids(), row.count(Rays))), ("ns/ray", time)];
        [names, under(&row.key.kernel, figures)].concat()
    };
    let group = |(class, _): (Class, _)| {
        let is_own = |of: &Of| matches!(of, Of::Scene { class: own, .. } if *own == class);
        (class.name().into(), report.rows_of(is_own).into_iter().map(line).collect())
    };
    table(report.classes().into_iter().map(group).collect())
}

/// All figures of one scene: errors, more errors, costs.
pub fn scene(report: &Report, scene: &str) -> [Table; 3] {
    let parts: [fn(&Row) -> [Line; 3]; 3] = [
        |row| {
            let rays = [("rays compared", cell(row.count(Rays)))];
            [under("", rays), faults(row), quantiles(row, "error of t, ulp", TUlp)]
        },
        |row| {
            let t = quantiles(row, "error of t, relative", TRelative);
            [t, quantiles(row, "error of the normal, °", NormalDegrees), stages(row)]
        },
        |row| {
            let per_ray = [
                ("ids", TraceNsPerRay),
                ("with t and normals", SurfaceNsPerRay),
                ("device's clock", DeviceNsPerRay),
            ];
            let per_picture = [
                ("read-back", ReadbackMs),
                ("compiling", CompileMs),
                ("first picture", FirstPictureMs),
            ];
            let bytes = [("bytes on the device", cell(row.count(BytesDevice)))];
            let times_of_rays = times(row, "time, ns a ray", per_ray);
            [times_of_rays, times(row, "time, ms", per_picture), under("", bytes)]
        },
    ];
    parts.map(|part| {
        let own = report.rows_of(|of| matches!(of, Of::Scene { scene: own, .. } if own == scene));
        plain(own, |row| [config(&row.key, report), part(row).concat()].concat())
    })
}

/// All numbers of a sweep: a row an x, and columns for each line.
pub fn sweep(report: &Report, sweep: &Sweep) -> Table {
    let rows = report.rows_along(sweep);
    let is_timed = rows.iter().any(|row| row.number(TraceNsPerRay).is_some());
    let series = Series::all(rows);
    // A line is named after all of its devices.
    let lines =
        series.iter().flat_map(|line| line.rows.iter().map(move |row| (line.label(report), *row)));
    plain(lines, |(label, row)| {
        let x = vec![name(sweep.x_label, cell(quantity(row.x())))];
        let t = error(row, TUlp, |errors| errors.p999);
        let figures = match is_timed {
            true => under(&label, [("ns a ray", time(row, TraceNsPerRay))]),
            false => under(&label, [("wrong ids", wrong_share(row)), ("t, 99.9 %, ulp", t)]),
        };
        [x, figures].concat()
    })
}

/// All that changed since an earlier report, with its title.
pub fn since(baseline: &Baseline, report: &Report) -> [(&'static str, Table); 2] {
    let names = |key: &RowKey| [vec![thing("of", key)], config(key, report)].concat();
    let change = |change: &Change| {
        let Change { key, metric, before, now, ratio, verdict } = change;
        let n_digits = digits_borne(before).min(digits_borne(now));
        let (mark, emphasis) = match verdict {
            TimeVerdict::Slower => ("▲ slower", Emphasis::Wrong),
            _ => ("▼ faster", Emphasis::Plain),
        };
        let figures = [
            ("before", spread(before)),
            ("now", spread(now)),
            ("change", cell(format!("× {}", digits(*ratio, n_digits)))),
            ("", Cell { emphasis, ..cell(mark) }),
        ];
        [names(key), vec![name("time", cell(metric.name()))], under("", figures)].concat()
    };
    let changed_ids = |WrongIds { key, rays, before, now }: &WrongIds| {
        let figures = [("rays compared", rays), ("wrong before", before), ("wrong now", now)];
        let figures = figures.map(|(name, n)| (name, cell(n)));
        [names(key), under("", figures)].concat()
    };
    let is_beyond =
        |change: &&Change| matches!(change.verdict, TimeVerdict::Faster | TimeVerdict::Slower);
    [
        ("Changes beyond noise", plain(baseline.times.iter().filter(is_beyond), change)),
        ("Wrong ids that changed", plain(&baseline.wrong_ids, changed_ids)),
    ]
}

impl Of {
    /// The thing in a table.
    pub(super) fn name(&self) -> String {
        match self {
            Of::Scene { scene, .. } | Of::Light { scene } => scene.clone(),
            Of::Class { class } => class.name().into(),
            Of::Sweep { sweep, x } => format!("{sweep} {}", quantity(*x)),
            Of::Cloud { spheres } => typeset(&format!("{spheres:e} spheres")),
        }
    }
}

impl Metric {
    /// A time with its unit.
    fn name(self) -> &'static str {
        match self {
            SurfaceNsPerRay => "with t and normals, ns a ray",
            PictureMs => "a picture, ms",
            _ => "ids, ns a ray",
        }
    }
}

fn cell(text: impl ToString) -> Cell {
    Cell { text: text.to_string(), range: None, emphasis: Emphasis::Plain }
}

/// `ε = 10⁻³`
pub fn with_epsilon(epsilon: Option<f64>) -> String {
    match epsilon {
        None | Some(0.0) => "no ε".to_string(),
        Some(epsilon) => format!("ε = {}", typeset(&format!("{epsilon:e}"))),
    }
}

/// A share of those that are wrong, `0` where none is.
fn share(wrong: u64, of: u64) -> Cell {
    match (wrong, of) {
        (_, 0) => cell(NONE),
        (0, _) => Cell { emphasis: Emphasis::Right, ..cell("0") },
        _ => Cell { emphasis: Emphasis::Wrong, ..cell(percent(wrong, of)) },
    }
}

/// The share of wrong ids, or `0 of N`.
pub fn wrong_share(row: &Row) -> Cell {
    let rays = row.count(Rays);
    let mut cell = share(row.wrong_ids(), rays);
    if cell.emphasis == Emphasis::Right {
        cell.text = format!("0 of {rays}");
    }
    cell
}

/// The share of rays that a stage decided.
fn decided(row: &Row, stage: Count) -> Cell {
    let all = [F32, F64, Exact].map(|stage| row.count(stage)).iter().sum();
    cell(share(row.count(stage), all).text)
}

/// A part of the errors' spread.
fn error(row: &Row, metric: Metric, part: fn(Spread) -> f64) -> Cell {
    cell(row.number(metric).map_or(NONE.into(), |errors| figure(part(errors))))
}

/// A time, the median with its range.
pub fn time(row: &Row, metric: Metric) -> Cell {
    row.number(metric).map_or(cell(NONE), |times| spread(&times))
}

/// The median with least and largest value beside it, all in the digits that the median bears.
pub fn spread(of: &Spread) -> Cell {
    let n_digits = digits_borne(of);
    let [median, min, max] = [of.median, of.min, of.max].map(|x| rounded(x, n_digits));
    Cell { range: (of.n > 1).then_some([min, max]), ..cell(median) }
}
