//! The pieces of a plot: markers, texts, axes.

use maud::{Markup, html};

use super::scale::{Scale, tick_label};
use super::theme;
use crate::report::Class;

/// Size of most text, px.
pub const TEXT_PX: f64 = 13.0;

/// Dashes of lines: one a device, or one a class.
pub const DASHES: [&str; 4] = ["none", "6 4", "2 3.5", "9 3 2 3"];

/// How wide a text of [`TEXT_PX`] is, px: a guess from the average of common sans-serif fonts.
pub fn text_width(text: &str) -> f64 {
    0.56 * TEXT_PX * text.chars().count() as f64
}

/// A coordinate in tenths of a pixel.
pub fn c(px: f64) -> f64 {
    (10.0 * px).round() / 10.0
}

/// Shape of a marker: one a device.
#[derive(Clone, Copy, PartialEq)]
pub enum Shape {
    Circle,
    Square,
    Triangle,
    /// For other renderers.
    Diamond,
}

impl Shape {
    /// The shape of the device at this place in the order.
    pub fn of_device(index: usize) -> Shape {
        [Shape::Circle, Shape::Square, Shape::Triangle][index.min(2)]
    }
}

/// How a marker is filled: one way a class.
fn is_filled(class: Class) -> bool {
    class == Class::Lecture
}

/// A marker of `radius` px in the current colour.
pub fn marker(shape: Shape, class: Class, x: f64, y: f64, radius: f64) -> Markup {
    let fill = |class| if is_filled(class) { "currentColor" } else { "none" };
    let path = |points: &[(f64, f64)]| {
        let point = |(dx, dy): &(f64, f64)| format!("{},{}", c(x + dx), c(y + dy));
        points.iter().map(point).collect::<Vec<_>>().join(" ")
    };
    let r = radius;
    let body = |class: Class, paper: bool| {
        let fill = if paper { "currentColor" } else { fill(class) };
        html! {
            @match shape {
                Shape::Circle => circle cx=(c(x)) cy=(c(y)) r=(r) fill=(fill) {},
                Shape::Square => rect x=(c(x - 0.9 * r)) y=(c(y - 0.9 * r)) width=(1.8 * r) height=(1.8 * r) fill=(fill) {},
                Shape::Triangle => polygon points=(path(&[(0.0, -1.15 * r), (1.1 * r, 0.8 * r), (-1.1 * r, 0.8 * r)])) fill=(fill) {},
                Shape::Diamond => polygon points=(path(&[(0.0, -1.3 * r), (1.3 * r, 0.0), (0.0, 1.3 * r), (-1.3 * r, 0.0)])) fill=(fill) {},
            }
        }
    };
    html! {
        g.paper stroke="currentColor" stroke-width="5" { (body(Class::Lecture, true)) }
        g stroke="currentColor" stroke-width="2" { (body(class, false)) }
        @if class == Class::Given {
            circle cx=(c(x)) cy=(c(y)) r=(c(0.35 * r)) fill="currentColor" {}
        }
    }
}

/// A text; `anchor` is `start`, `middle` or `end`.
pub fn text(x: f64, y: f64, anchor: &str, class: &str, words: &str) -> Markup {
    html! {
        text class=(class) x=(c(x)) y=(c(y)) text-anchor=(anchor) fill="currentColor" { (words) }
    }
}

/// A straight line in the current colour.
pub fn line(x1: f64, y1: f64, x2: f64, y2: f64) -> Markup {
    html! { line x1=(c(x1)) y1=(c(y1)) x2=(c(x2)) y2=(c(y2)) stroke="currentColor" {} }
}

/// The grid of a horizontal axis from `top` to `y`.
pub fn x_grid(scale: &Scale, top: f64, y: f64) -> Markup {
    let (left, right) = scale.ends();
    html! {
        g.grid {
            @for tick in scale.ticks() { (line(scale.px(tick), top, scale.px(tick), y)) }
        }
        g.soft { (line(left, y, right, y)) }
    }
}

/// The numbers of a horizontal axis below `y`, and what it shows.
pub fn x_labels(scale: &Scale, y: f64, title: &str) -> Markup {
    let (left, right) = scale.ends();
    html! {
        @for tick in scale.ticks() {
            (text(scale.px(tick), y + 18.0, "middle", "soft", &tick_label(tick)))
        }
        (text((left + right) / 2.0, y + 40.0, "middle", "ink", title))
    }
}

/// The vertical axis at `x` with its grid up to `right`; `label` writes a tick.
pub fn y_axis(scale: &Scale, x: f64, right: f64, label: impl Fn(f64) -> String) -> Markup {
    html! {
        g.grid {
            @for tick in scale.ticks() { (line(x, scale.px(tick), right, scale.px(tick))) }
        }
        @for tick in scale.ticks() {
            (text(x - 8.0, scale.px(tick) + 4.5, "end", "soft", &label(tick)))
        }
    }
}

/// A strip beside the axis, for what has no place on it.
pub fn band(x: f64, top: f64, right: f64, height: f64, label: &str) -> Markup {
    html! {
        rect.band x=(c(x)) y=(c(top)) width=(c(right - x)) height=(c(height)) fill="currentColor" {}
        (text(x - 8.0, top + height / 2.0 + 4.5, "end", "soft", label))
    }
}

/// One entry of a legend: a sample of this width, and words.
pub struct Entry {
    pub sample_px: f64,
    /// Draws the sample about a point.
    pub sample: Box<dyn Fn(f64, f64) -> Markup>,
    pub words: String,
}

/// Entries side by side in rows, from `x` to `right`; gives the height, too.
pub fn legend(entries: &[Entry], x: f64, top: f64, right: f64) -> (Markup, f64) {
    const ROW_PX: f64 = 22.0;
    let (mut at_x, mut at_y) = (x, top + ROW_PX / 2.0);
    let mut drawn = Vec::new();
    for entry in entries {
        let width = entry.sample_px + 8.0 + text_width(&entry.words) + 18.0;
        if at_x > x && at_x + width > right {
            (at_x, at_y) = (x, at_y + ROW_PX);
        }
        let words_x = at_x + entry.sample_px + 8.0;
        drawn.push(html! {
            ((entry.sample)(at_x + entry.sample_px / 2.0, at_y))
            (text(words_x, at_y + 4.5, "start", "ink", &entry.words))
        });
        at_x += width;
    }
    let height = if drawn.is_empty() { 0.0 } else { at_y + ROW_PX / 2.0 - top };
    (html! { @for entry in &drawn { (entry) } }, height)
}

/// A whole picture, which stands alone or in a page.
pub fn svg(width: f64, height: f64, description: &str, body: &Markup) -> String {
    let fixed = ".plot{font:13px system-ui,'Segoe UI',Roboto,'DejaVu Sans',sans-serif}\
                 .plot .halo{stroke-width:3.5px;stroke-linejoin:round;paint-order:stroke}";
    let style = format!("{fixed}{}", theme::css());
    html! {
        svg.plot xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}"))
            width=(width) height=(height) role="img" aria-label=(description) {
            style { (maud::PreEscaped(style)) }
            rect.paper width=(width) height=(height) fill="currentColor" {}
            (body)
        }
    }
    .into_string()
}
