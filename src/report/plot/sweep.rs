//! A sweep: error or time against one quantity, one line a kernel and device.

use maud::{Markup, html};

use super::marks::{
    DASHES, Entry, Shape, band, c, legend, line, marker, svg, text, x_grid, x_labels, y_axis,
};
use super::scale::{Scale, tick_label, typeset};
use super::theme::kernel_class;
use crate::report::figures::{figure, list, plain_document, quantity};
use crate::report::summary::{Cast, Line, lines, time_of};
use crate::report::{Class, Report, Sweep, SweepPoint};

const WIDTH: f64 = 860.0;
const LEFT: f64 = 84.0;
/// The names of the lines stand to the right of it.
const RIGHT: f64 = WIDTH - 190.0;
/// Of the axis of one of two panels, and of a panel alone.
const PLOT_HEIGHT: [f64; 2] = [200.0, 320.0];
const LANE: f64 = 15.0;
const RADIUS: f64 = 3.0;
/// Least distance of two names, px.
const NAME_PX: f64 = 15.0;

/// A number that is drawn.
#[derive(Clone, Copy, PartialEq)]
enum Value {
    /// Below the axis.
    Zero,
    /// On the axis; with its range, where there is one.
    Number(f64, Option<(f64, f64)>),
    /// Above the axis.
    Infinite,
}

impl Value {
    fn of(x: f64) -> Option<Value> {
        match x {
            _ if x.is_nan() || x < 0.0 => None,
            0.0 => Some(Value::Zero),
            f64::INFINITY => Some(Value::Infinite),
            _ => Some(Value::Number(x, None)),
        }
    }
}

/// What a panel shows.
struct Quantity {
    title: &'static str,
    /// What stands beside the band of zeros.
    zero: &'static str,
    /// The axis without any number.
    fallback: (f64, f64),
    of: fn(&SweepPoint) -> Option<Value>,
    label: fn(f64) -> String,
}

const WRONG_SHARE: Quantity = Quantity {
    title: "rays with a wrong object",
    zero: "none",
    fallback: (1e-4, 1.0),
    of: |point| {
        let errors = point.errors.as_ref().filter(|errors| errors.rays > 0)?;
        Value::of(errors.wrong_share())
    },
    label: |share| format!("{} %", tick_label(100.0 * share)),
};

const T_ERROR: Quantity = Quantity {
    title: "error of t that 99.9 % of the rays with the right object do not exceed, ulp",
    zero: "0",
    fallback: (0.1, 10.0),
    of: |point| Value::of(point.errors.as_ref()?.t_ulp?.p999),
    label: tick_label,
};

const TIME: Quantity = Quantity {
    title: "time to trace one ray, ns (bar: least to largest)",
    zero: "0",
    fallback: (1.0, 100.0),
    of: |point| {
        let time = point.trace_ns_per_ray.as_ref()?;
        Some(Value::Number(time_of(time)?, Some((time.min, time.max))))
    },
    label: tick_label,
};

/// A sweep as an SVG file.
pub fn sweep(report: &Report, sweep: &Sweep) -> String {
    let cast = Cast::of(report);
    let lines = lines(sweep);
    let points = || sweep.series.iter().flat_map(|series| &series.points);
    let quantities: Vec<&Quantity> = [&WRONG_SHARE, &T_ERROR, &TIME]
        .into_iter()
        .filter(|quantity| points().any(|point| (quantity.of)(point).is_some()))
        .collect();
    let xs: Vec<f64> = points().map(|point| point.x).filter(|x| x.is_finite()).collect();
    let x = Scale::of_quantity(&xs, (LEFT, RIGHT));
    let (legend, legend_height) = legend(&entries(&lines, &cast), LEFT, 8.0, WIDTH - 16.0);
    let mut top = 8.0 + legend_height;
    let mut panels = Vec::new();
    for (i, quantity) in quantities.iter().enumerate() {
        let is_last = i + 1 == quantities.len();
        let height = PLOT_HEIGHT[usize::from(quantities.len() == 1)];
        let (panel, bottom) = panel(quantity, &lines, &cast, &x, (top + 34.0, height));
        panels.push(html! {
            (x_grid(&x, top + 34.0, bottom))
            (panel)
            @if is_last { (x_labels(&x, bottom, sweep.x_label)) }
        });
        top = bottom + if is_last { 54.0 } else { 14.0 };
    }
    let body = html! { (legend) @for panel in &panels { (panel) } };
    plain_document(&svg(WIDTH, top.ceil(), sweep.title, &body))
}

/// A point of a line: the quantity, and what is drawn there. `None` where there is nothing.
type Sample = Option<(f64, Value)>;

/// One panel from `top` with an axis of that height, and where it ends.
fn panel(
    quantity: &Quantity,
    lines: &[Line],
    cast: &Cast,
    x: &Scale,
    (top, axis_height): (f64, f64),
) -> (Markup, f64) {
    let samples: Vec<Vec<Sample>> = lines
        .iter()
        .map(|line| {
            let points = line.series.points.iter().filter(|point| point.x.is_finite());
            points.map(|point| Some((point.x, (quantity.of)(point)?))).collect()
        })
        .collect();
    let frame = Frame::new(quantity, &samples, top, axis_height);
    let panel = html! {
        (text(LEFT - 62.0, top - 12.0, "start", "ink", quantity.title))
        (frame.above.draw("∞"))
        (frame.below.draw(quantity.zero))
        (y_axis(&frame.y, LEFT, RIGHT, quantity.label))
        @for (i, line) in lines.iter().enumerate() {
            @let place = |(at, value)| (x.px(at), frame.place(i, value));
            (curve(line, cast, &samples[i], place))
            (dots(line, cast, &samples[i], place, &frame.y))
        }
        (names(lines, cast, &ends(&samples, x, &frame), frame.below.bottom()))
    };
    (panel, frame.below.bottom())
}

/// A strip beside the axis, with a lane for each line that has something there.
struct Strip {
    top: f64,
    lines: Vec<usize>,
}

impl Strip {
    /// The lines that have `value` somewhere.
    fn lines(samples: &[Vec<Sample>], value: Value) -> Vec<usize> {
        let has = |sample: &Sample| sample.is_some_and(|(_, other)| other == value);
        (0..samples.len()).filter(|line| samples[*line].iter().any(has)).collect()
    }

    /// Between the strip and the axis.
    fn gap(lines: &[usize]) -> f64 {
        if lines.is_empty() { 0.0 } else { 12.0 }
    }

    fn bottom(&self) -> f64 {
        self.top + self.lines.len() as f64 * LANE
    }

    fn lane(&self, line: usize) -> f64 {
        let lane = self.lines.iter().position(|other| *other == line).unwrap_or(0);
        self.top + (lane as f64 + 0.5) * LANE
    }

    fn draw(&self, label: &str) -> Markup {
        html! {
            @if !self.lines.is_empty() {
                (band(LEFT, self.top, RIGHT, self.bottom() - self.top, label))
            }
        }
    }
}

/// The strips and the axis between them.
struct Frame {
    above: Strip,
    y: Scale,
    below: Strip,
}

impl Frame {
    fn new(quantity: &Quantity, samples: &[Vec<Sample>], top: f64, axis_height: f64) -> Frame {
        let above = Strip { top, lines: Strip::lines(samples, Value::Infinite) };
        let below = Strip::lines(samples, Value::Zero);
        let axis_top = above.bottom() + Strip::gap(&above.lines);
        let axis_bottom = axis_top + axis_height;
        Frame {
            above,
            y: y_scale(quantity, samples, (axis_bottom, axis_top)),
            below: Strip { top: axis_bottom + Strip::gap(&below), lines: below },
        }
    }

    fn place(&self, line: usize, value: Value) -> f64 {
        match value {
            Value::Number(number, _) => self.y.px(number),
            Value::Zero => self.below.lane(line),
            Value::Infinite => self.above.lane(line),
        }
    }
}

/// Where each line ends; `None` where nothing is drawn of it.
fn ends(samples: &[Vec<Sample>], x: &Scale, frame: &Frame) -> Vec<Option<(f64, f64)>> {
    let end = |(i, own): (usize, &Vec<Sample>)| {
        let (at, value) = own.iter().rev().find_map(|sample| *sample)?;
        Some((x.px(at), frame.place(i, value)))
    };
    samples.iter().enumerate().map(end).collect()
}

fn y_scale(quantity: &Quantity, samples: &[Vec<Sample>], px: (f64, f64)) -> Scale {
    let mut numbers = Vec::new();
    for (_, value) in samples.iter().flatten().flatten() {
        if let Value::Number(number, range) = value {
            numbers.push(*number);
            numbers.extend(range.iter().flat_map(|(low, high)| [*low, *high]));
        }
    }
    if numbers.is_empty() {
        numbers.extend(<[f64; 2]>::from(quantity.fallback));
    }
    Scale::log(numbers, px)
}

fn dash(line: &Line, cast: &Cast) -> &'static str {
    DASHES[cast.device_index(&line.series.contestant.device) % DASHES.len()]
}

/// The line through the points, with gaps where there are none.
fn curve(
    line: &Line,
    cast: &Cast,
    samples: &[Sample],
    place: impl Fn((f64, Value)) -> (f64, f64),
) -> Markup {
    let point = |sample: &(f64, Value)| {
        let (x, y) = place(*sample);
        format!("{},{}", c(x), c(y))
    };
    html! {
        @for run in samples.split(Option::is_none) {
            @let points: Vec<String> = run.iter().flatten().map(point).collect();
            @if points.len() > 1 {
                polyline class=(kernel_class(&line.series.contestant.kernel))
                    points=(points.join(" ")) fill="none" stroke="currentColor" stroke-width="2"
                    stroke-linejoin="round" stroke-dasharray=(dash(line, cast)) {}
            }
        }
    }
}

fn dots(
    line: &Line,
    cast: &Cast,
    samples: &[Sample],
    place: impl Fn((f64, Value)) -> (f64, f64),
    y: &Scale,
) -> Markup {
    let shape = Shape::of_device(cast.device_index(&line.series.contestant.device));
    let label = line.label(cast);
    html! {
        g class=(kernel_class(&line.series.contestant.kernel)) {
            @for (at, value) in samples.iter().flatten() {
                @let (x, own_y) = place((*at, *value));
                @if let Value::Number(_, Some((low, high))) = value {
                    @if *low > 0.0 && high.is_finite() && high > low {
                        g stroke-width="2" opacity="0.6" {
                            (self::line(x, y.px(*low), x, y.px(*high)))
                        }
                    }
                }
                g {
                    title { (label) ", " (typeset(&quantity(*at))) ": " (words(*value)) }
                    (marker(shape, Class::Lecture, x, own_y, RADIUS))
                }
            }
        }
    }
}

fn words(value: Value) -> String {
    match value {
        Value::Zero => "0".to_string(),
        Value::Infinite => "∞".to_string(),
        Value::Number(number, _) => typeset(&figure(number)),
    }
}

/// The lines' names at their ends, moved apart where they would touch.
fn names(lines: &[Line], cast: &Cast, ends: &[Option<(f64, f64)>], bottom: f64) -> Markup {
    // Where the name stands, where the line ends.
    let mut ends: Vec<(f64, f64, f64, &Line)> = ends
        .iter()
        .zip(lines)
        .filter_map(|(end, line)| end.map(|(x, y)| (y, x, y, line)))
        .collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    for i in 1..ends.len() {
        ends[i].0 = ends[i].0.max(ends[i - 1].0 + NAME_PX);
    }
    // What was pushed out at the bottom goes back up.
    let mut lowest = bottom + 4.0;
    for end in ends.iter_mut().rev() {
        end.0 = end.0.min(lowest);
        lowest = end.0 - NAME_PX;
    }
    let is_shared = |line: &Line| line.alike.len() + 1 == cast.devices.len();
    html! {
        @for (y, end_x, end_y, line) in &ends {
            g class=(kernel_class(&line.series.contestant.kernel)) opacity="0.7" { (self::line(end_x + 6.0, *end_y, RIGHT + 12.0, *y)) }
            @let label = match is_shared(line) {
                true => line.series.contestant.kernel.clone(),
                false => line.label(cast),
            };
            (text(RIGHT + 16.0, y + 4.5, "start", "ink", &label))
        }
    }
}

/// Colours are named at the lines; here is what dashes mean, and which devices are alike.
fn entries(lines: &[Line], cast: &Cast) -> Vec<Entry> {
    let mut shown: Vec<&Line> = Vec::new();
    for line in lines {
        if !shown.iter().any(|other| other.devices(cast) == line.devices(cast)) {
            shown.push(line);
        }
    }
    shown
        .into_iter()
        .map(|line| {
            let shape = Shape::of_device(cast.device_index(&line.series.contestant.device));
            let dash = dash(line, cast);
            let words = match line.alike.is_empty() {
                true => list(&line.devices(cast)),
                false => format!("{}: the same to the last bit", list(&line.devices(cast))),
            };
            Entry {
                sample_px: 36.0,
                sample: Box::new(move |x, y| {
                    html! {
                        g.soft {
                            g stroke-width="2" stroke-dasharray=(dash) { (self::line(x - 18.0, y, x + 18.0, y)) }
                            (marker(shape, Class::Lecture, x, y, RADIUS))
                        }
                    }
                }),
                words,
            }
        })
        .collect()
}
