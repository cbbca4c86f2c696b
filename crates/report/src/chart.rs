//! Draws charts on logarithmic axes as SVG.

use kugelblitz_judge::markup::document;
use maud::{Markup, PreEscaped, html};

use super::plots::{Chart, Series};
use super::table::number;
use super::theme::plot_css;

/// Width and height of a chart, px.
const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 350.0;

/// Edges of the plotted area, px.
const LEFT: f64 = 64.0;
const RIGHT: f64 = 580.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = 296.0;

/// Marks of the devices, as paths around a point, and dashes of their lines.
const DEVICES: [(&str, &str); 3] = [
    ("m-4.5,0a4.5,4.5 0 1 0 9,0a4.5,4.5 0 1 0-9,0z", "none"),
    ("m-4,-4h8v8h-8z", "6 4"),
    ("m0,-5l5,9h-10z", "2 3"),
];

/// Returns the mapping of values to pixels, and the ticks with their labels. Zero has the start of the axis
/// for itself, and infinity its end.
fn axis(
    values: impl Iterator<Item = f64>,
    [from, to]: [f64; 2],
) -> (impl Fn(f64) -> f64, Vec<(f64, String)>) {
    let logs: Vec<f64> = values.map(f64::log10).collect();
    let finite = || logs.iter().copied().filter(|log| log.is_finite());
    let has_zero = logs.contains(&f64::NEG_INFINITY);
    let first = finite().reduce(f64::min).unwrap_or(0.0).floor();
    let low = first - f64::from(has_zero);
    let high = finite().reduce(f64::max).unwrap_or(0.0).ceil().max(first + 1.0);
    let span = high - low;
    let px = move |x: f64| {
        let share = ((x.log10() - low) / span).clamp(0.0, 1.0);
        (from + share * (to - from)).round()
    };
    let step = if span > 3.0 { 3 * (span / 8.0).ceil() as usize } else { 1 };
    let decades = first as i32..=high as i32;
    let values =
        decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|factor| factor * 10f64.powi(decade)));
    let values = values.step_by(step).filter(|x| x.log10() <= high).chain(has_zero.then_some(0.0));
    let ticks = values.map(|x| (px(x), number(x))).collect();
    (px, ticks)
}

fn draw(Chart { title, x_label, series, .. }: &Chart) -> Markup {
    let values = |axis: usize| {
        series.iter().flat_map(|line| &line.points).flat_map(move |point| point[axis])
    };
    let (x_px, x_ticks) = axis(values(0), [LEFT, RIGHT]);
    let (y_px, y_ticks) = axis(values(1), [BOTTOM, TOP]);
    html! {
        text.ink.title x="10" y="30" { (title) }
        text.soft x=(LEFT) y=(BOTTOM + 42.0) { (x_label) }
        @for (x, label) in x_ticks {
            path.grid.line d=(format!("M{x},{BOTTOM}V{TOP}")) {}
            text.soft.middle x=(x) y=(BOTTOM + 18.0) { (label) }
        }
        @for (y, label) in y_ticks {
            path.grid.line d=(format!("M{LEFT},{y}H{RIGHT}")) {}
            text.soft.end x=(LEFT - 8.0) y=(y + 4.0) { (label) }
        }
        @for (i, Series { name, class, device, points }) in series.iter().enumerate() {
            @let places = points.iter().map(|[x, y]| (x.map(&x_px), y.map(&y_px)));
            @let line: Vec<_> = places.clone().map(|([x, ..], [y, ..])| format!("{x},{y}")).collect();
            @let (mark, dashes) = DEVICES[device % 3];
            @let (x, y) = (RIGHT + 24.0, TOP + 16.0 * i as f64);
            text.ink x=(x + 14.0) y=(y + 4.5) { (name) }
            g class=(class) {
                path d=(format!("M{x},{y}{mark}")) {}
                path.line d=(format!("M{}", line.join("L"))) stroke-dasharray=(dashes) {}
                @for (([x, x_min, x_max], [y, y_min, y_max]), [a, b]) in places.zip(points) {
                    g {
                        title { (name) ": " (number(a[0])) ", " (number(b[0])) }
                        path.line d=(format!("M{x_min},{y}H{x_max}M{x},{y_min}V{y_max}")) {}
                        path d=(format!("M{x},{y}{mark}")) {}
                    }
                }
            }
        }
    }
}

/// Returns charts one below the other, as a document or a part of a page.
pub fn svg(charts: &[&Chart]) -> String {
    let size = format!("0 0 {WIDTH} {}", HEIGHT * charts.len() as f64);
    let markup = html! {
        svg.plot xmlns="http://www.w3.org/2000/svg" viewBox=(size) {
            style { (PreEscaped(plot_css())) }
            rect.paper width="100%" height="100%" {}
            @for (i, chart) in charts.iter().enumerate() {
                g transform=(format!("translate(0,{})", HEIGHT * i as f64)) { (draw(chart)) }
            }
        }
    };
    document(&markup.into_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        for (values, expected) in [
            (&[7.0, 80.0][..], "1 2 5 10 20 50 100"),
            (&[2e-5, 0.4], "1e-5 0.0001 0.001 0.01 0.1 1"),
            (&[0.0, 2e-5, 0.4], "1e-5 0.0001 0.001 0.01 0.1 1 0"),
            (&[1.0, 1e15, f64::INFINITY], "1 100 10000 1e6 1e8 1e10 1e12 1e14"),
            (&[1.0], "1 2 5 10"),
            (&[0.0], "1 2 5 10 0"),
            (&[], "1 2 5 10"),
        ] {
            let (_, ticks) = axis(values.iter().copied(), [0.0, 100.0]);
            assert!(ticks.iter().all(|(px, _)| (0.0..=100.0).contains(px)), "{ticks:?}");
            let labels: Vec<String> = ticks.into_iter().map(|(_, label)| label).collect();
            assert_eq!(labels.join(" "), expected, "{values:?}");
        }
    }

    #[test]
    fn equal_ratios_have_equal_distances_and_ends_stay_inside() {
        let (px, _) = axis([0.0, 1.0, 100.0].into_iter(), [300.0, 0.0]);
        let px = [0.0, 0.1, 1.0, 10.0, 100.0, f64::INFINITY].map(px);
        assert_eq!(px, [300.0, 300.0, 200.0, 100.0, 0.0, 0.0]);
    }
}
