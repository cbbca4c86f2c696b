//! Marks over an axis, with a strip below it for zero and one above it for infinity, and the names
//! of what is drawn at its right.

use maud::{Markup, html};

use super::marks::{band, line, marker, polyline, text, x_grid, y_axis};
use super::scale::Scale;
use crate::report::Class;

pub const WIDTH: f64 = 860.0;
pub const LEFT: f64 = 84.0;
/// The names stand to the right of it.
pub const RIGHT: f64 = WIDTH - 190.0;

/// A strip has a lane for each line with something in it, so that marks and names have room.
const LANE: f64 = 17.0;

/// Between the axis and a strip.
const GAP: f64 = 12.0;

/// Least distance of two names, px.
const NAME_PX: f64 = 15.0;

/// A number as an axis of logarithms has it.
#[derive(Clone, Copy, PartialEq)]
pub enum Value {
    /// Below the axis.
    Zero,
    /// On the axis.
    Number(f64),
    /// Above the axis.
    Infinite,
}

impl Value {
    /// `None` for what is no size of anything.
    pub fn of(x: f64) -> Option<Value> {
        match x {
            _ if x.is_nan() || x < 0.0 => None,
            0.0 => Some(Value::Zero),
            f64::INFINITY => Some(Value::Infinite),
            _ => Some(Value::Number(x)),
        }
    }

    fn number(self) -> Option<f64> {
        match self {
            Value::Number(number) => Some(number),
            _ => None,
        }
    }
}

/// What is drawn at a place.
pub struct Mark {
    pub x: f64,
    pub y: Value,
    /// Drawn as a bar: where repeated measurements went, along x or along y.
    pub x_range: Option<(f64, f64)>,
    pub y_range: Option<(f64, f64)>,
    /// How it is filled.
    pub class: Class,
    /// Shown to who points at it.
    pub title: String,
}

/// Marks of one colour and shape.
pub struct Line {
    pub name: String,
    /// The class of its colour.
    pub color: &'static str,
    /// Place of its device in the order of devices, for the shape.
    pub device: usize,
    /// `None` where the marks are not joined.
    pub dash: Option<&'static str>,
    /// In order; `None` for a gap.
    pub marks: Vec<Option<Mark>>,
}

impl Line {
    fn drawn(&self) -> impl Iterator<Item = &Mark> {
        self.marks.iter().flatten()
    }
}

/// What an axis shows.
pub struct Axis {
    pub title: &'static str,
    /// What stands beside the strip of zeros.
    pub zero: &'static str,
    /// The axis without any number.
    pub fallback: (f64, f64),
    pub label: fn(f64) -> String,
    /// Height in px, and the radius of its marks.
    pub height: f64,
    pub radius: f64,
}

/// A panel with its lines, laid out.
pub struct Panel {
    axis: Axis,
    pub lines: Vec<Line>,
    x: Scale,
    y: Scale,
    top: f64,
    above: Strip,
    below: Strip,
}

/// The lines that have a lane, and where the first one begins.
struct Strip {
    top: f64,
    lines: Vec<usize>,
}

impl Strip {
    fn new(top: f64, lines: &[Line], value: Value) -> Strip {
        let has = |i: &usize| lines[*i].drawn().any(|mark| mark.y == value);
        Strip { top, lines: (0..lines.len()).filter(has).collect() }
    }

    fn height(&self) -> f64 {
        self.lines.len() as f64 * LANE
    }

    fn gap(&self) -> f64 {
        if self.lines.is_empty() { 0.0 } else { GAP }
    }

    fn lane(&self, line: usize) -> f64 {
        let lane = self.lines.iter().position(|other| *other == line).unwrap_or(0);
        self.top + (lane as f64 + 0.5) * LANE
    }

    fn draw(&self, label: &str) -> Markup {
        html! { @if !self.lines.is_empty() { (band(LEFT, RIGHT, self.top, self.height(), label)) } }
    }
}

impl Panel {
    /// A panel from `top`.
    pub fn new(axis: Axis, lines: Vec<Line>, x: Scale, top: f64) -> Panel {
        let above = Strip::new(top, &lines, Value::Infinite);
        let mut below = Strip::new(top, &lines, Value::Zero);
        let axis_top = top + above.height() + above.gap();
        below.top = axis_top + axis.height + below.gap();
        let marks = || lines.iter().flat_map(Line::drawn);
        let ranges = marks().filter_map(|mark| mark.y_range).flat_map(|(low, high)| [low, high]);
        let mut numbers: Vec<f64> =
            marks().filter_map(|mark| mark.y.number()).chain(ranges).collect();
        if numbers.is_empty() {
            numbers.extend(<[f64; 2]>::from(axis.fallback));
        }
        let y = Scale::log(numbers, (axis_top + axis.height, axis_top));
        Panel { axis, lines, x, y, top, above, below }
    }

    /// Where it ends.
    pub fn bottom(&self) -> f64 {
        self.below.top + self.below.height()
    }

    /// Where a mark of a line is.
    pub fn place(&self, line: usize, mark: &Mark) -> (f64, f64) {
        let y = match mark.y {
            Value::Number(number) => self.y.px(number),
            Value::Zero => self.below.lane(line),
            Value::Infinite => self.above.lane(line),
        };
        (self.x.px(mark.x), y)
    }

    pub fn draw(&self) -> Markup {
        html! {
            (text(LEFT - 62.0, self.top - 12.0, "start", "ink", self.axis.title))
            (self.above.draw("∞"))
            (self.below.draw(self.axis.zero))
            (x_grid(&self.x, self.top, self.bottom()))
            (y_axis(&self.y, (LEFT, RIGHT), self.axis.label))
            @for (i, line) in self.lines.iter().enumerate() {
                g class=(line.color) stroke-width="2" {
                    @if let Some(dash) = line.dash { (self.curve(i, dash)) }
                    g opacity="0.6" { @for mark in line.drawn() { (self.bars(i, mark)) } }
                }
            }
            @for (i, line) in self.lines.iter().enumerate() {
                g class=(line.color) {
                    @for mark in line.drawn() {
                        g {
                            title { (line.name) ", " (mark.title) }
                            (marker(line.device, mark.class, self.place(i, mark), self.axis.radius))
                        }
                    }
                }
            }
            (self.names())
        }
    }

    /// The line through the marks, with its gaps.
    fn curve(&self, line: usize, dash: &str) -> Markup {
        html! {
            @for run in self.lines[line].marks.split(Option::is_none) {
                @let through: Vec<_> =
                    run.iter().flatten().map(|mark| self.place(line, mark)).collect();
                (polyline(&through, dash))
            }
        }
    }

    fn bars(&self, line: usize, mark: &Mark) -> Markup {
        let (x, y) = self.place(line, mark);
        let is_drawn = |(low, high): &(f64, f64)| *low > 0.0 && high.is_finite() && high > low;
        html! {
            @if let Some((low, high)) = mark.x_range.filter(is_drawn) {
                (self::line((self.x.px(low), y), (self.x.px(high), y)))
            }
            @if let Some((low, high)) = mark.y_range.filter(is_drawn) {
                (self::line((x, self.y.px(low)), (x, self.y.px(high))))
            }
        }
    }

    /// The lines' names at their last marks, moved apart where they would touch.
    fn names(&self) -> Markup {
        let last = |(i, line): (usize, &Line)| Some((i, self.place(i, line.drawn().last()?)));
        let mut ends: Vec<_> = self.lines.iter().enumerate().filter_map(last).collect();
        ends.sort_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
        let mut ys: Vec<f64> = ends.iter().map(|(_, (_, y))| *y).collect();
        for i in 1..ys.len() {
            ys[i] = ys[i].max(ys[i - 1] + NAME_PX);
        }
        // What was pushed out at the bottom goes back up.
        let mut lowest = self.bottom() + 4.0;
        for y in ys.iter_mut().rev() {
            *y = y.min(lowest);
            lowest = *y - NAME_PX;
        }
        html! {
            @for ((i, (end_x, end_y)), y) in ends.iter().zip(&ys) {
                @let line = &self.lines[*i];
                g class=(line.color) opacity="0.5" {
                    (self::line((end_x + 7.0, *end_y), (RIGHT + 12.0, *y)))
                }
                (text(RIGHT + 16.0, y + 4.5, "start", "ink", &line.name))
            }
        }
    }
}
