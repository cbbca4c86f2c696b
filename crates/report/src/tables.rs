//! The report's tables: what each shows is data; [`table`] makes them all, and
//! [`super::print`] prints them.

use super::Count::{
    BytesDevice, Exact, F32, F64, FalseHits, FalseMisses, Pixels, Rays, Scenes, Verdicts,
    WrongBytes, WrongObject,
};
use super::Metric::{
    BuildMs, CompileMs, DeviceNsPerRay, FirstPictureMs, NormalDegrees, PictureMs, ReadbackMs,
    SurfaceNsPerRay, TRelative, TUlp, TraceNsPerRay,
};
use super::figures::{
    NONE, count, digits, digits_borne, figure, median, percent, quantity, range, typeset, wrong,
};
use super::order::{Series, add};
use super::{
    Baseline, Change, Class, Count, Metric, Of, Report, Row, RowKey, Spread, Sweep, TimeVerdict,
    WrongIds,
};

/// Rows of cells under a head.
pub struct Table {
    /// The head: first the names of a row, then its figures.
    pub parts: Vec<Part>,
    /// The rows.
    pub groups: Vec<Group<Vec<Cell>>>,
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
pub struct Group<R> {
    /// Their class; empty where there is one group alone.
    pub name: String,
    /// The rows; in a table as many cells in each as there are columns.
    pub rows: Vec<R>,
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
    /// As a count of wrong ids that is 0, or of nothing.
    Right,
}

impl Table {
    /// A table whose head has these columns, the first of them names, under what stands over them.
    fn new(head: Vec<(&str, Vec<String>)>, groups: Vec<Group<Vec<Cell>>>) -> Table {
        let mut n_columns = 0;
        let part = |(over, columns): (&str, Vec<String>)| {
            let first = n_columns;
            n_columns += columns.len();
            Part { over: over.to_string(), first, columns }
        };
        Table { parts: head.into_iter().map(part).collect(), groups }
    }

    /// A table in one group, whose head has names and figures with nothing over them.
    fn of_changes<const N: usize>(head: [[&str; N]; 2], rows: Vec<Vec<Cell>>) -> Table {
        let columns = |names: [&str; N]| ("", names.map(String::from).to_vec());
        Table::new(head.map(columns).to_vec(), one_group(rows))
    }

    pub fn is_empty(&self) -> bool {
        self.groups.iter().all(|group| group.rows.is_empty())
    }
}

/// Columns side by side, with their names.
type Columns<'a> = &'a [(&'a str, Figure)];

/// Columns of figures under a heading, which may be empty.
type Under<'a> = (&'a str, Columns<'a>);

/// What a cell shows of a row.
#[derive(Clone, Copy)]
enum Figure {
    /// The thing that was measured.
    Subject,
    Kernel,
    Device,
    Epsilon,
    /// The quantity that is swept.
    X,
    Counted(Count),
    /// The share of wrong ids, or `0 of N`.
    Wrong,
    /// The share of wrong ids, without the number of rays.
    WrongShare,
    WrongShadows,
    WrongPixels,
    /// The share of rays that a stage decided.
    Decided(Count),
    /// The median of errors.
    Median(Metric),
    P999(Metric),
    Largest(Metric),
    /// A median with its range.
    Time(Metric),
    /// The median alone.
    TimeAlone(Metric),
}

use Figure::*;

impl Figure {
    fn of(self, row: &Row, report: &Report) -> Cell {
        let error = |metric, part: fn(Spread) -> f64| {
            cell(row.number(metric).map_or(NONE.into(), |errors| figure(part(errors))))
        };
        let time = |metric| row.number(metric).map_or(cell(NONE), |times| spread(&times));
        let share = |wrong, of| share_of(wrong, row.count(of));
        match self {
            Subject => cell(row.key.of.name()),
            Kernel => kernel(&row.key),
            Device => device(&row.key, report),
            Epsilon => cell(with_epsilon(row.key.epsilon)),
            X => cell(quantity(row.x())),
            Counted(count) => cell(row.count(count).to_string()),
            Wrong => wrong_share(row),
            WrongShare => share(row.wrong_ids(), Rays),
            WrongShadows => share(row.wrong_shadows(), Verdicts),
            WrongPixels => share(row.count(WrongBytes), Pixels),
            Decided(stage) => decided(row, row.count(stage)),
            Median(metric) => error(metric, |errors| errors.median),
            P999(metric) => error(metric, |errors| errors.p999),
            Largest(metric) => error(metric, |errors| errors.max),
            Time(metric) => time(metric),
            TimeAlone(metric) => Cell { range: None, ..time(metric) },
        }
    }
}

/// The rows of `groups`: columns that name a row, and columns of figures. Rows of the same names stand in one line
/// where they differ in what is `across`, which is over their columns.
fn table(
    report: &Report,
    groups: Vec<Group<&Row>>,
    names: Columns,
    across: Option<Figure>,
    columns: &[Under],
) -> Table {
    let over = |row: &Row| across.map_or_else(String::new, |across| across.of(row, report).text);
    let mut overs: Vec<String> = Vec::new();
    groups.iter().flat_map(|group| &group.rows).for_each(|row| add(&mut overs, over(row)));
    let cells = |rows: Vec<&Row>| -> Vec<Vec<Cell>> {
        let mut lines: Vec<(Vec<Cell>, Vec<&Row>)> = Vec::new();
        for row in rows {
            let own: Vec<Cell> = names.iter().map(|(_, name)| name.of(row, report)).collect();
            match lines.iter_mut().find(|line| across.is_some() && line.0 == own) {
                Some((_, rows)) => rows.push(row),
                None => lines.push((own, vec![row])),
            }
        }
        let with_figures = |(mut line, rows): (Vec<Cell>, Vec<&Row>)| {
            for wanted in &overs {
                let row = rows.iter().find(|row| over(row) == *wanted);
                let figures = columns.iter().flat_map(|(_, columns)| *columns);
                line.extend(figures.map(|(_, f)| row.map_or(cell(NONE), |row| f.of(row, report))));
            }
            line
        };
        lines.into_iter().map(with_figures).collect()
    };
    let mut head = vec![("", names)];
    for over in &overs {
        for &(own, columns) in columns {
            head.push((if over.is_empty() { own } else { over.as_str() }, columns));
        }
    }
    let titles = |columns: Columns| columns.iter().map(|(name, _)| name.to_string()).collect();
    let head = head.into_iter().map(|(over, columns)| (over, titles(columns))).collect();
    let group = |Group { name, rows }| Group { name, rows: cells(rows) };
    Table::new(head, groups.into_iter().map(group).collect())
}

const CONFIG: Columns = &[("kernel", Kernel), ("device", Device)];
const FAULTS: Under = (
    "wrong ids",
    &[
        ("share", Wrong),
        ("false hit", Counted(FalseHits)),
        ("false miss", Counted(FalseMisses)),
        ("another", Counted(WrongObject)),
    ],
);
const T_ULP: Under = ("error of t, ulp", &quantiles(TUlp));
const T_RELATIVE: Under = ("error of t, relative", &quantiles(TRelative));
const NORMAL: Under = ("error of the normal, °", &quantiles(NormalDegrees));
const STAGES: Under =
    ("decided in", &[("f32", Decided(F32)), ("f64", Decided(F64)), ("exact", Decided(Exact))]);

/// The columns of an error.
const fn quantiles(metric: Metric) -> [(&'static str, Figure); 3] {
    [("median", Median(metric)), ("99.9 %", P999(metric)), ("largest", Largest(metric))]
}

/// The classes: how wrong.
pub fn class_errors(report: &Report) -> Table {
    let normal: Under = ("normal, °", &[("largest", Largest(NormalDegrees))]);
    table(report, by_class(report), CONFIG, None, &[FAULTS, T_ULP, normal])
}

/// The classes: how fast, and which stage decided.
pub fn class_costs(report: &Report) -> Table {
    let times: Columns =
        &[("ids", Time(TraceNsPerRay)), ("with t and normals", Time(SurfaceNsPerRay))];
    table(report, by_class(report), CONFIG, None, &[("time, ns a ray", times), STAGES])
}

/// The classes in a few columns.
pub fn summary(report: &Report) -> Table {
    let figures: Columns = &[
        ("rays with a wrong object", Wrong),
        ("error of `t`, 99.9 %, ulp", P999(TUlp)),
        ("ns a ray (least–most)", Time(TraceNsPerRay)),
    ];
    let names = &[("scenes", Subject), ("kernel", Kernel), ("device", Device)];
    let rows = report.classes().into_iter().flat_map(|(_, rows)| rows).collect();
    table(report, one_group(rows), names, None, &[("", figures)])
}

/// Many spheres.
pub fn clouds(report: &Report) -> Table {
    let figures: Columns = &[
        ("ms a picture (least–most)", Time(PictureMs)),
        ("building, ms", Time(BuildMs)),
        ("decided in f64", Decided(F64)),
        ("exactly", Decided(Exact)),
        ("wrong ids", Wrong),
    ];
    let names = &[("cloud", Subject), ("device", Device)];
    let rows = report.rows_of(|of| matches!(of, Of::Cloud { .. }));
    table(report, one_group(rows), names, None, &[("", figures)])
}

/// Lit scenes: wrong shadows and bytes of each kernel with each epsilon.
pub fn light(report: &Report) -> Table {
    let wrong: Columns = &[("shadows", WrongShadows), ("bytes", WrongPixels)];
    let names = &[("lit scene", Subject), ("", Epsilon)];
    let rows = report.rows_of(|of| matches!(of, Of::Light { .. }));
    table(report, one_group(rows), names, Some(Kernel), &[("", wrong)])
}

/// All scenes: who was wrong, and the time of ids.
pub fn overview(report: &Report) -> Table {
    let figures: Columns = &[("wrong", WrongShare), ("ns/ray", TimeAlone(TraceNsPerRay))];
    let names = &[("scene", Subject), ("device", Device)];
    let group = |(class, _): (Class, _)| {
        let is_own = |of: &Of| matches!(of, Of::Scene { class: own, .. } if *own == class);
        Group { name: class.name().into(), rows: report.rows_of(is_own) }
    };
    let groups = report.classes().into_iter().map(group).collect();
    table(report, groups, names, Some(Kernel), &[("", figures)])
}

/// All figures of one scene: errors, more errors, costs.
pub fn scene(report: &Report, name: &str) -> [Table; 3] {
    let rays: Under = ("", &[("rays compared", Counted(Rays))]);
    let per_ray: Under = (
        "time, ns a ray",
        &[
            ("ids", Time(TraceNsPerRay)),
            ("with t and normals", Time(SurfaceNsPerRay)),
            ("device's clock", Time(DeviceNsPerRay)),
        ],
    );
    let times: Under = (
        "time, ms",
        &[
            ("read-back", Time(ReadbackMs)),
            ("compiling", Time(CompileMs)),
            ("first picture", Time(FirstPictureMs)),
        ],
    );
    let bytes: Under = ("", &[("bytes on the device", Counted(BytesDevice))]);
    let own = report.rows_of(|of| matches!(of, Of::Scene { scene, .. } if scene == name));
    [[rays, FAULTS, T_ULP], [T_RELATIVE, NORMAL, STAGES], [per_ray, times, bytes]]
        .map(|columns| table(report, one_group(own.clone()), CONFIG, None, &columns))
}

/// All numbers of a sweep: a row an x, and columns for each line.
pub fn sweep(report: &Report, sweep: &Sweep) -> Table {
    let rows = report.rows_along(sweep);
    let figures: Columns = if rows.iter().any(|row| row.number(TraceNsPerRay).is_some()) {
        &[("ns a ray", Time(TraceNsPerRay))]
    } else {
        &[("wrong ids", Wrong), ("t, 99.9 %, ulp", P999(TUlp))]
    };
    // A line is named after all of its devices.
    let of_line = |line: Series| -> Vec<Row> {
        let kernel = line.label(report);
        let key = |row: &Row| RowKey { kernel: kernel.clone(), ..row.key.clone() };
        line.rows.into_iter().map(|row| Row { key: key(row), ..row.clone() }).collect()
    };
    let lines: Vec<Row> = Series::shared(&rows).into_iter().flat_map(of_line).collect();
    let named = one_group(lines.iter().collect());
    let names = &[(sweep.x_label, X)];
    table(report, named, names, Some(Kernel), &[("", figures)])
}

/// All that changed since an earlier report, with its title.
pub fn since(baseline: &Baseline, report: &Report) -> [(&'static str, Table); 2] {
    [
        ("Changes beyond noise", changes(baseline, report)),
        ("Wrong ids that changed", changed_ids(baseline, report)),
    ]
}

/// Times that changed by more than noise.
fn changes(baseline: &Baseline, report: &Report) -> Table {
    let row = |change: &Change| {
        let Change { key, metric, before, now, ratio, verdict } = change;
        let n_digits = digits_borne(before).min(digits_borne(now));
        let (mark, emphasis) = match verdict {
            TimeVerdict::Slower => ("▲ slower", Emphasis::Wrong),
            _ => ("▼ faster", Emphasis::Plain),
        };
        let ratio = cell(format!("× {}", digits(*ratio, n_digits)));
        let figures = [spread(before), spread(now), ratio, Cell { emphasis, ..cell(mark) }];
        let names = [cell(key.of.name()), kernel(key), device(key, report), cell(metric.name())];
        [names, figures].concat()
    };
    let head = [["of", "kernel", "device", "time"], ["before", "now", "change", ""]];
    Table::of_changes(head, baseline.beyond_noise().map(row).collect())
}

/// Numbers of wrong ids that changed.
fn changed_ids(baseline: &Baseline, report: &Report) -> Table {
    let row = |WrongIds { key, rays, before, now }: &WrongIds| {
        let names = [cell(key.of.name()), kernel(key), device(key, report)];
        [names, [rays, before, now].map(|n| cell(n.to_string()))].concat()
    };
    let head = [["of", "kernel", "device"], ["rays compared", "wrong before", "wrong now"]];
    Table::of_changes(head, baseline.wrong_ids.iter().map(row).collect())
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

/// One group a class, under its name.
fn by_class(report: &Report) -> Vec<Group<&Row>> {
    let mut groups = Vec::new();
    for (class, rows) in report.classes() {
        let most = |of| rows.iter().map(|row| row.count(of)).max().unwrap_or(0);
        let n_scenes = count(most(Scenes) as usize, "scene");
        let name = format!("{}: {n_scenes}, {} rays compared", class.name(), most(Rays));
        groups.push(Group { name, rows });
    }
    groups
}

fn one_group<R>(rows: Vec<R>) -> Vec<Group<R>> {
    vec![Group { name: String::new(), rows }]
}

fn cell(text: impl Into<String>) -> Cell {
    Cell { text: text.into(), range: None, emphasis: Emphasis::Plain }
}

fn kernel(key: &RowKey) -> Cell {
    Cell { emphasis: Emphasis::Kernel, ..cell(&key.kernel) }
}

fn device(key: &RowKey, report: &Report) -> Cell {
    cell(report.short(&key.device))
}

/// `ε = 10⁻³`
pub fn with_epsilon(epsilon: Option<f64>) -> String {
    match epsilon {
        None | Some(0.0) => "no ε".to_string(),
        Some(epsilon) => format!("ε = {}", typeset(&format!("{epsilon:e}"))),
    }
}

/// A share of wrong ones, `0` of none.
fn share_of(wrong: u64, of: u64) -> Cell {
    match (wrong, of) {
        (_, 0) => cell(NONE),
        (0, _) => Cell { emphasis: Emphasis::Right, ..cell("0") },
        _ => Cell { emphasis: Emphasis::Wrong, ..cell(percent(wrong, of)) },
    }
}

/// The share of wrong ids, or `0 of N`.
fn wrong_share(row: &Row) -> Cell {
    let emphasis = if row.wrong_ids() > 0 { Emphasis::Wrong } else { Emphasis::Right };
    Cell { emphasis, ..cell(wrong(row)) }
}

/// The share of rays that a stage decided.
fn decided(row: &Row, part: u64) -> Cell {
    let all = [F32, F64, Exact].map(|stage| row.count(stage)).iter().sum();
    cell(if part == 0 && all > 0 { "0".into() } else { percent(part, all) })
}

/// Median with its range.
pub fn spread(of: &Spread) -> Cell {
    let range = (of.n > 1).then(|| range(of));
    Cell { range, ..cell(median(of)) }
}
