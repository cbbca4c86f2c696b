//! The pieces of a plot: markers, texts, axes.

use maud::{Markup, html};

use super::scale::{Scale, tick_label};
use super::theme;
use crate::report::Class;

/// Dashes of lines: one a device, or one a class.
pub const DASHES: [&str; 4] = ["none", "6 4", "2 3.5", "9 3 2 3"];

/// A coordinate in tenths of a pixel.
fn c(px: f64) -> f64 {
    (10.0 * px).round() / 10.0
}

/// Points as the attribute `points` has them.
pub fn points(points: &[(f64, f64)]) -> String {
    let point = |(x, y): &(f64, f64)| format!("{},{}", c(*x), c(*y));
    points.iter().map(point).collect::<Vec<_>>().join(" ")
}

/// A marker in the current colour: one shape a device, filled in one way a class.
pub fn marker(device: usize, class: Class, (x, y): (f64, f64), r: f64) -> Markup {
    let shape = |fill: &str| {
        let triangle = [(x, y - 1.15 * r), (x + 1.1 * r, y + 0.8 * r), (x - 1.1 * r, y + 0.8 * r)];
        html! {
            @match device {
                0 => circle cx=(c(x)) cy=(c(y)) r=(r) fill=(fill) {},
                1 => rect x=(c(x - 0.9 * r)) y=(c(y - 0.9 * r)) width=(1.8 * r) height=(1.8 * r)
                    fill=(fill) {},
                _ => polygon points=(points(&triangle)) fill=(fill) {},
            }
        }
    };
    html! {
        g.paper stroke="currentColor" stroke-width="5" { (shape("currentColor")) }
        g stroke="currentColor" stroke-width="2" {
            (shape(if class == Class::Lecture { "currentColor" } else { "none" }))
        }
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
pub fn line((x1, y1): (f64, f64), (x2, y2): (f64, f64)) -> Markup {
    html! { line x1=(c(x1)) y1=(c(y1)) x2=(c(x2)) y2=(c(y2)) stroke="currentColor" {} }
}

/// A line through several points, in the current colour.
pub fn polyline(through: &[(f64, f64)], dash: &str) -> Markup {
    html! {
        @if through.len() > 1 {
            polyline points=(points(through)) fill="none" stroke="currentColor"
                stroke-linejoin="round" stroke-dasharray=(dash) {}
        }
    }
}

/// The grid of a horizontal axis from `top` to `y`.
pub fn x_grid(scale: &Scale, top: f64, y: f64) -> Markup {
    let (left, right) = scale.ends();
    html! {
        g.grid {
            @for x in scale.ticks().into_iter().map(|tick| scale.px(tick)) { (line((x, top), (x, y))) }
        }
        g.soft { (line((left, y), (right, y))) }
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

/// The vertical axis at `left` with its grid up to `right`; `label` writes a tick.
pub fn y_axis(scale: &Scale, (left, right): (f64, f64), label: fn(f64) -> String) -> Markup {
    html! {
        @for tick in scale.ticks() {
            @let y = scale.px(tick);
            g.grid { (line((left, y), (right, y))) }
            (text(left - 8.0, y + 4.5, "end", "soft", &label(tick)))
        }
    }
}

/// A strip beside the axis, for what has no place on it.
pub fn band(left: f64, right: f64, top: f64, height: f64, label: &str) -> Markup {
    html! {
        rect.band x=(c(left)) y=(c(top)) width=(c(right - left)) height=(c(height))
            fill="currentColor" {}
        (text(left - 8.0, top + height / 2.0 + 4.5, "end", "soft", label))
    }
}

/// One entry of a legend: a sample of this width drawn about the origin, and words.
pub struct Entry {
    pub sample_px: f64,
    pub sample: Markup,
    pub words: String,
}

/// Entries side by side in rows, from `left` to `right`; gives the height, too.
pub fn legend(entries: &[Entry], (left, right): (f64, f64), top: f64) -> (Markup, f64) {
    const ROW_PX: f64 = 22.0;
    // A guess from the average of common sans-serif fonts.
    const LETTER_PX: f64 = 7.3;
    let (mut x, mut y) = (left, top + ROW_PX / 2.0);
    let mut drawn = Vec::new();
    for Entry { sample_px, sample, words } in entries {
        let width = sample_px + 8.0 + LETTER_PX * words.chars().count() as f64 + 18.0;
        if x > left && x + width > right {
            (x, y) = (left, y + ROW_PX);
        }
        let middle = format!("translate({},{})", c(x + sample_px / 2.0), c(y));
        drawn.push(html! {
            g transform=(middle) { (sample) }
            (text(x + sample_px + 8.0, y + 4.5, "start", "ink", words))
        });
        x += width;
    }
    let height = if drawn.is_empty() { 0.0 } else { y + ROW_PX / 2.0 - top };
    (html! { @for entry in &drawn { (entry) } }, height)
}

/// A whole picture, which stands alone or in a page.
pub fn svg(width: f64, height: f64, description: &str, body: &Markup) -> String {
    let fixed = ".plot{font:13px system-ui,'Segoe UI',Roboto,'DejaVu Sans',sans-serif}";
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
