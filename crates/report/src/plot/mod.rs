//! A [`Report`] as SVG pictures: charts on logarithmic axes, panels one below the other on one horizontal axis,
//! each with a strip below it for zero and one above it for infinity. The names of the lines stand at their ends.
//!
//! They need nothing beside themselves and fit light and dark pages: `prefers-color-scheme` chooses
//! the colours. All numbers in them are also in the tables.

mod plane;
mod scale;
mod sweep;
pub(super) mod theme;

pub use plane::plane;
pub use sweep::sweep;

use kugelblitz_judge::markup::{document, escaped};

use crate::figures::{quantity, typeset};
use crate::order::Series;
use crate::{Class, Count, Of, Report, Row};

use scale::Scale;
use theme::kernel_class;

/// Width of a chart, px.
const WIDTH: f64 = 860.0;

/// The ends of the horizontal axis, px. The names of the lines stand to the right of it.
const LEFT: f64 = 84.0;
const RIGHT: f64 = 670.0;

/// Where words above a panel begin, px.
const MARGIN: f64 = 22.0;

/// A line of words, px.
const ROW: f64 = 22.0;

/// Most numbers along an axis.
const MOST_TICKS: usize = 9;

/// A strip has a lane for each line with something in it, so that marks and names have room.
const LANE: f64 = 17.0;

/// Between an axis and a strip.
const GAP: f64 = 12.0;

/// Least distance of two names, px.
const NAME: f64 = 15.0;

/// Size of a mark, px.
const RADIUS: f64 = 4.0;

/// Dashes of lines: one a device, or one a class.
const DASHES: [&str; 4] = ["none", "6 4", "2 3.5", "9 3 2 3"];

/// A place: in numbers, where x is positive and y is that, 0 or infinite; or in pixels.
type Point = (f64, f64);

/// What an axis shows of a row: a value, and the least and largest where it was measured repeatedly.
type AxisValue = fn(&Row) -> Option<[f64; 3]>;

/// The share of rays with a wrong object, percent.
fn wrong_percent(row: &Row) -> Option<[f64; 3]> {
    (row.count(Count::Rays) > 0).then(|| [100.0 * row.wrong_share(); 3])
}

/// The time of ids, nanoseconds a ray.
fn ns_per_ray(row: &Row) -> Option<[f64; 3]> {
    let time = row.time()?;
    Some([time.median, time.min, time.max])
}

/// True of what marks are outlines of.
fn is_open(of: &Of) -> bool {
    *of == Of::Class { class: Class::Hard }
}

/// One quantity of all lines.
struct Panel {
    title: &'static str,
    y: AxisValue,
    /// Steps past marks, each of whose corners is on the height of a line's marks. Without any, lines join
    /// their marks.
    steps: Vec<Vec<(usize, Point)>>,
}

/// A whole picture, which stands alone or in a page.
pub struct Chart<'a> {
    report: &'a Report,
    description: &'static str,
    /// Lines of words above the panels.
    key: Vec<String>,
    /// The lines of each panel: a colour a kernel, a shape and dashes a device.
    lines: Vec<Series<'a>>,
    /// A name for each line.
    names: Vec<String>,
    panels: Vec<Panel>,
    x: AxisValue,
    x_title: &'static str,
    /// What is shown to who points at a mark of a row, with its place on the vertical axis.
    said: fn(&Row, f64) -> String,
}

/// A row in a panel.
struct Mark<'a> {
    /// The index of the line.
    line: usize,
    /// The index in the line.
    index: usize,
    row: &'a Row,
    /// The place, and the ends of a bar: where repeated measurements went.
    places: [Point; 3],
}

impl Mark<'_> {
    fn color(&self) -> &'static str {
        kernel_class(&self.row.key.kernel)
    }
}

impl<'a> Chart<'a> {
    /// The marks of a panel, line by line: one of each row of which both quantities have a place.
    fn marks(&self, panel: &Panel) -> Vec<Mark<'a>> {
        let mut marks = Vec::new();
        for (line, series) in self.lines.iter().enumerate() {
            for (index, row) in series.rows.iter().enumerate() {
                let Some((x, y)) = (self.x)(row).zip((panel.y)(row)) else { continue };
                if x[0] > 0.0 && x[0].is_finite() && y[0] >= 0.0 {
                    let places = [0, 1, 2].map(|i| (x[i], y[i]));
                    marks.push(Mark { line, index, row, places });
                }
            }
        }
        marks
    }

    /// True where there is nothing to show.
    pub fn is_empty(&self) -> bool {
        self.panels.iter().all(|panel| self.marks(panel).is_empty())
    }

    /// The picture as an SVG file.
    pub fn svg(&self) -> String {
        let marks = self.panels.iter().flat_map(|panel| self.marks(panel));
        let x = Scale::new(marks.flat_map(|mark| mark.places).map(|(x, _)| x), (LEFT, RIGHT));
        let mut svg = String::new();
        for (i, words) in self.key.iter().enumerate() {
            svg += &text(LEFT, 8.0 + ROW * (i as f64 + 0.7), "start", "ink", words);
        }
        let above = 8.0 + ROW * self.key.len() as f64;
        let mut bottom = above;
        for panel in self.panels.iter().filter(|panel| !self.marks(panel).is_empty()) {
            let layout = Layout::new(self, panel, &x, bottom + 34.0);
            bottom = layout.bottom;
            svg += &layout.draw();
        }
        if bottom > above {
            for tick in x.ticks(MOST_TICKS) {
                svg += &text(x.px(tick), bottom + 18.0, "middle", "soft", &label(tick));
            }
            svg += &text((LEFT + RIGHT) / 2.0, bottom + 40.0, "middle", "ink", self.x_title);
        }
        let (height, description, css) = (bottom + 54.0, escaped(self.description), theme::css());
        // What a mark says is shown where the mouse is over it, not over words beside it.
        document(&format!(
            "<svg class=\"plot\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
             width=\"{WIDTH}\" height=\"{height}\" role=\"img\" aria-label=\"{description}\"><style>\
             .plot{{font:13px system-ui,'Segoe UI',Roboto,'DejaVu Sans',sans-serif}}\
             .plot text,.plot line,.plot polyline{{pointer-events:none}}{css}</style>\
             <rect class=\"paper\" width=\"{WIDTH}\" height=\"{height}\" fill=\"currentColor\"></rect>{svg}</svg>"
        ))
    }
}

/// Where all of a panel is.
struct Layout<'a> {
    chart: &'a Chart<'a>,
    panel: &'a Panel,
    marks: Vec<Mark<'a>>,
    x: &'a Scale,
    /// `None` where all that is drawn stands in a strip.
    y: Option<Scale>,
    top: f64,
    bottom: f64,
    /// The lines with a lane in the strip of infinity, which begins at the top.
    above: Vec<usize>,
    /// The lines with a lane in the strip of zero, which ends at the bottom.
    below: Vec<usize>,
}

impl<'a> Layout<'a> {
    fn new(chart: &'a Chart<'a>, panel: &'a Panel, x: &'a Scale, top: f64) -> Layout<'a> {
        let marks = chart.marks(panel);
        let lines_at = |y: f64| {
            let own = marks.iter().filter(|mark| mark.places[0].1 == y);
            let mut lines: Vec<usize> = own.map(|mark| mark.line).collect();
            lines.dedup();
            lines
        };
        let (above, below) = (lines_at(f64::INFINITY), lines_at(0.0));
        let strip = |lines: &[usize]| match lines.len() {
            0 => 0.0,
            n => n as f64 * LANE + GAP,
        };
        let ys = marks.iter().flat_map(|mark| mark.places).map(|(_, y)| y);
        let ys: Vec<f64> = ys.filter(|y| *y > 0.0 && y.is_finite()).collect();
        let axis_top = top + strip(&above);
        // Several panels are lower than one alone.
        let height = match chart.panels.len() {
            _ if ys.is_empty() => 0.0,
            1 => 320.0,
            _ => 200.0,
        };
        let axis_bottom = axis_top + height;
        let y = (!ys.is_empty()).then(|| Scale::new(ys, (axis_bottom, axis_top)));
        let bottom = axis_bottom + strip(&below);
        Layout { chart, panel, marks, x, y, top, bottom, above, below }
    }

    /// Where a point on a line is.
    fn place(&self, line: usize, (x, y): Point) -> Point {
        let lane = |lines: &[usize]| {
            let lane = lines.iter().position(|other| *other == line).unwrap_or(0);
            (lane as f64 + 0.5) * LANE
        };
        let y = match y {
            0.0 => self.below_top() + lane(&self.below),
            f64::INFINITY => self.top + lane(&self.above),
            _ => self.y.as_ref().map_or(self.top, |scale| scale.px(y)),
        };
        (self.x.px(x), y)
    }

    /// Where a mark and the ends of its bar are.
    fn places(&self, mark: &Mark) -> [Point; 3] {
        mark.places.map(|point| self.place(mark.line, point))
    }

    /// The marks of each line that has any.
    fn lines(&self) -> impl Iterator<Item = &[Mark<'a>]> {
        self.marks.chunk_by(|a, b| a.line == b.line)
    }

    /// The place of a mark's device in the order of devices.
    fn device(&self, mark: &Mark) -> usize {
        self.chart.report.device_index(&mark.row.key.device)
    }

    fn below_top(&self) -> f64 {
        self.bottom - self.below.len() as f64 * LANE
    }

    fn draw(&self) -> String {
        let Layout { chart, panel, x, top, bottom, .. } = self;
        let mut svg = text(MARGIN, top - 12.0, "start", "ink", panel.title);
        svg += &strip(*top, &self.above, "∞");
        svg += &strip(self.below_top(), &self.below, "0");
        for x in x.ticks(MOST_TICKS).into_iter().map(|tick| x.px(tick)) {
            svg += &in_class("grid", "", &straight((x, *top), (x, *bottom)));
        }
        svg += &in_class("soft", "", &straight((LEFT, *bottom), (RIGHT, *bottom)));
        if let Some(scale) = &self.y {
            for tick in scale.ticks(MOST_TICKS) {
                let y = scale.px(tick);
                svg += &in_class("grid", "", &straight((LEFT, y), (RIGHT, y)));
                svg += &text(LEFT - 8.0, y + 4.5, "end", "soft", &label(tick));
            }
        }
        for marks in self.lines() {
            let curve = if panel.steps.is_empty() { self.curve(marks) } else { String::new() };
            let places = marks.iter().map(|mark| self.places(mark));
            let ranges = places.filter(|[_, from, to]| from != to);
            let ranges: String = ranges.map(|[_, from, to]| straight(from, to)).collect();
            let drawn = format!("{curve}<g opacity=\"0.6\">{ranges}</g>");
            svg += &in_class(marks[0].color(), " stroke-width=\"2\"", &drawn);
        }
        for mark in &self.marks {
            let title = (chart.said)(mark.row, mark.places[0].1);
            let said = escaped(&format!("{}, {title}", chart.names[mark.line]));
            let [place, ..] = self.places(mark);
            let marker = marker(self.device(mark), is_open(&mark.row.key.of), place);
            svg += &in_class(mark.color(), "", &format!("<title>{said}</title>{marker}"));
        }
        for (steps, dash) in panel.steps.iter().zip(DASHES) {
            let through = steps.iter().map(|(line, point)| self.place(*line, *point));
            svg += &in_class("soft", " stroke-width=\"1.5\"", &polyline(through, dash));
        }
        svg + &self.names()
    }

    /// The line through its marks, with a gap where a row has none.
    fn curve(&self, marks: &[Mark]) -> String {
        let dash = DASHES[self.device(&marks[0]) % DASHES.len()];
        let runs = marks.chunk_by(|a, b| a.index + 1 == b.index);
        runs.map(|run| polyline(run.iter().map(|mark| self.places(mark)[0]), dash)).collect()
    }

    /// The lines' names at their last marks, moved apart where they would touch.
    fn names(&self) -> String {
        let last = self.lines().filter_map(<[Mark]>::last);
        let ends = last.map(|mark| (mark, self.places(mark)[0]));
        let mut ends: Vec<_> = ends.map(|(mark, end)| (mark, end, end.1)).collect();
        ends.sort_by(|a, b| a.2.total_cmp(&b.2));
        let mut highest = f64::NEG_INFINITY;
        for (.., y) in &mut ends {
            *y = y.max(highest);
            highest = *y + NAME;
        }
        // What was pushed out at the bottom goes back up.
        let mut lowest = self.bottom + 4.0;
        for (.., y) in ends.iter_mut().rev() {
            *y = y.min(lowest);
            lowest = *y - NAME;
        }
        let name = |&(mark, (end_x, end_y), y): &(&Mark, Point, f64)| {
            let lead = straight((end_x + 7.0, end_y), (RIGHT + 12.0, y));
            in_class(mark.color(), " opacity=\"0.5\"", &lead)
                + &text(RIGHT + 16.0, y + 4.5, "start", "ink", &self.chart.names[mark.line])
        };
        ends.iter().map(name).collect()
    }
}

/// A number beside an axis.
fn label(tick: f64) -> String {
    typeset(&quantity(tick))
}

/// A coordinate in tenths of a pixel.
fn c(px: f64) -> f64 {
    (10.0 * px).round() / 10.0
}

/// Elements of a class, whose group has further attributes.
fn in_class(class: &str, attributes: &str, drawn: &str) -> String {
    format!("<g class=\"{class}\"{attributes}>{drawn}</g>")
}

/// A strip beside the axis, for what has no place on it.
fn strip(top: f64, lines: &[usize], label: &str) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let (y, width, height) = (c(top), RIGHT - LEFT, lines.len() as f64 * LANE);
    let label = text(LEFT - 8.0, top + height / 2.0 + 4.5, "end", "soft", label);
    format!(
        "<rect class=\"band\" x=\"{LEFT}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
         fill=\"currentColor\"></rect>{label}"
    )
}

/// A text; `anchor` is `start`, `middle` or `end`.
fn text(x: f64, y: f64, anchor: &str, class: &str, words: &str) -> String {
    let (x, y, words) = (c(x), c(y), escaped(words));
    format!(
        "<text class=\"{class}\" x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" fill=\"currentColor\">{words}</text>"
    )
}

fn straight((x1, y1): Point, (x2, y2): Point) -> String {
    let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(c);
    format!("<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" stroke=\"currentColor\"></line>")
}

fn polyline(through: impl Iterator<Item = Point>, dash: &str) -> String {
    let points: Vec<String> = through.map(|(x, y)| format!("{},{}", c(x), c(y))).collect();
    if points.len() < 2 {
        return String::new();
    }
    let points = points.join(" ");
    format!(
        "<polyline points=\"{points}\" fill=\"none\" stroke=\"currentColor\" stroke-linejoin=\"round\" \
         stroke-dasharray=\"{dash}\"></polyline>"
    )
}

/// A marker in the current colour, with a rim of paper: one shape a device.
fn marker(device: usize, is_open: bool, (x, y): Point) -> String {
    let (r, side) = (RADIUS, 2.0 * RADIUS);
    let [left, right, top, bottom, x, y] = [x - r, x + r, y - r, y + r, x, y].map(c);
    let shape = |fill: &str| match device {
        0 => format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" fill=\"{fill}\"></circle>"),
        1 => format!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{side}\" height=\"{side}\" fill=\"{fill}\"></rect>"
        ),
        _ => format!(
            "<polygon fill=\"{fill}\" points=\"{x},{top} {right},{bottom} {left},{bottom}\"></polygon>"
        ),
    };
    let rim =
        in_class("paper", " stroke=\"currentColor\" stroke-width=\"5\"", &shape("currentColor"));
    let own = shape(if is_open { "none" } else { "currentColor" });
    format!("{rim}<g stroke=\"currentColor\" stroke-width=\"2\">{own}</g>")
}
