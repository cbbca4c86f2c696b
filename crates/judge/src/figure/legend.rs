//! The legend of clouds that are coloured by a column.

use kugelblitz::plain::plain;
use kugelblitz::scene::{ColorMap, Coloring, hex};

use super::words::{multiple, number, round_step};
use crate::markup::{document, escaped};

/// An SVG picture of a bar of colour for each of these colourings, with the columns' names and numbers; `None` where there is
/// none. Those that are alike share a bar.
pub fn legend_svg<'a>(all: impl IntoIterator<Item = &'a Coloring>) -> Option<String> {
    let mut colorings: Vec<Coloring> = Vec::new();
    for coloring in all {
        let is_alike = |other: &&mut Coloring| {
            **other == Coloring { n_missing: other.n_missing, ..coloring.clone() }
        };
        match colorings.iter_mut().find(is_alike) {
            Some(other) => other.n_missing += coloring.n_missing,
            None => colorings.push(coloring.clone()),
        }
    }
    if colorings.is_empty() {
        return None;
    }
    let mut left = MARGIN;
    let mut bars = String::new();
    for (bar, coloring) in colorings.iter().enumerate() {
        let (drawn, width) = draw(bar, left, coloring);
        bars += &drawn;
        left += width + 2.0 * MARGIN;
    }
    let width = left - MARGIN;
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{HEIGHT}\" \
         viewBox=\"0 0 {width} {HEIGHT}\" font-family=\"system-ui, 'DejaVu Sans', sans-serif\" \
         font-size=\"{FONT}\"><rect width=\"{width}\" height=\"{HEIGHT}\" fill=\"#ffffff\"></rect>{bars}</svg>"
    );
    Some(document(&svg) + "\n")
}

/// Around all and between bars, px.
const MARGIN: f64 = 16.0;
/// Size of the letters, px.
const FONT: f64 = 14.0;
/// A wide letter's width, px: what a line of text takes at most.
const LETTER: f64 = 0.66 * FONT;
const BAR_WIDTH: f64 = 22.0;
/// A pixel a colour.
const BAR_HEIGHT: f64 = ColorMap::LEN as f64;
const BAR_TOP: f64 = MARGIN + 24.0;
const MISSING_TOP: f64 = BAR_TOP + BAR_HEIGHT + 14.0;
const HEIGHT: f64 = MISSING_TOP + BAR_WIDTH + MARGIN;

/// Draws one bar and gives its width.
fn draw(bar: usize, left: f64, coloring: &Coloring) -> (String, f64) {
    const NO_VALUE: &str = "no value";
    let title = plain(&coloring.column).replace(['\n', '\t'], " ");
    let (ticks, misses) = (ticks(coloring.range), coloring.n_missing > 0);
    let words = ticks.iter().map(|(_, label)| label.as_str()).chain(misses.then_some(NO_VALUE));
    let n_letters = words.map(|word| word.chars().count()).max().unwrap_or(0);
    let text_left = left + BAR_WIDTH + 10.0;
    let text = |x: f64, y: &str, words: &str| {
        format!("<text x=\"{x}\" y=\"{y}\">{}</text>", escaped(words))
    };
    let label = |y: f64, words: &str| text(text_left, &tenths(y + 5.0), words);
    let swatch = |top: f64, height: f64, fill: &str| {
        format!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{BAR_WIDTH}\" height=\"{height}\" fill=\"{fill}\" \
             stroke=\"#000000\" stroke-width=\"0.5\"></rect>"
        )
    };
    let stop = |(i, color): (usize, [u8; 3])| {
        let (place, color) = ((i as f64 + 0.5) / ColorMap::LEN as f64, hex(color));
        format!("<stop offset=\"{place}\" stop-color=\"{color}\"></stop>")
    };
    let stops: String = coloring.map.srgb8().into_iter().enumerate().map(stop).collect();
    let mut drawn = text(left, &(MARGIN + 10.0).to_string(), &title);
    drawn += &format!(
        "<linearGradient id=\"map{bar}\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">{stops}</linearGradient>"
    );
    drawn += &swatch(BAR_TOP, BAR_HEIGHT, &format!("url(#map{bar})"));
    if misses {
        drawn += &swatch(MISSING_TOP, BAR_WIDTH, &hex(coloring.missing_color.to_srgb8()));
        drawn += &label(MISSING_TOP + BAR_WIDTH / 2.0, NO_VALUE);
    }
    let place = |share: f64| BAR_TOP + BAR_HEIGHT * (1.0 - share);
    drawn.extend(ticks.iter().map(|(share, words)| label(place(*share), words)));
    let (from, to) = (left + BAR_WIDTH, left + BAR_WIDTH + 5.0);
    drawn.extend(ticks.iter().map(|(share, _)| {
        let y = tenths(place(*share));
        format!("<path d=\"M{from} {y}H{to}\" stroke=\"#000000\" stroke-width=\"1\"></path>")
    }));
    let below = text_left - left + n_letters as f64 * LETTER;
    let width = (title.chars().count() as f64 * LETTER).max(below).ceil();
    (drawn, width)
}

/// To a tenth of a pixel.
fn tenths(x: f64) -> String {
    format!("{x:.1}")
}

/// Round numbers within a range, each with its share of the way through it; the two ends where there
/// are none.
fn ticks([low, high]: [f64; 2]) -> Vec<(f64, String)> {
    /// Least and most steps between ticks.
    const STEPS: [f64; 2] = [3.2, 8.0];
    if low == high {
        return vec![(0.5, number(low))];
    }
    // Their difference may be infinite.
    let half = 0.5 * high - 0.5 * low;
    let share = |number: f64| (0.5 * number - 0.5 * low) / half;
    let step = round_step(half / (0.5 * STEPS[0]));
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    // Steps that a number can't be told from the next at.
    if !(1.0..=STEPS[1] + 1.0).contains(&(last - first)) || first.abs().max(last.abs()) > 1e9 {
        return vec![(0.0, number(low)), (1.0, number(high))];
    }
    let places = (first as i32..=last as i32).map(|i| multiple(step, i));
    places.map(|place| (share(place), number(place))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        ticks([low, high]).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        assert_eq!(labels(0.0, 2.5), ["0", "0.5", "1", "1.5", "2", "2.5"]);
        assert_eq!(labels(0.013, 0.98), ["0.2", "0.4", "0.6", "0.8"]);
        assert_eq!(labels(-3.0, 3.0), ["−3", "−2", "−1", "0", "1", "2", "3"]);
        assert_eq!(labels(0.0, 1e-7), ["0", "2e−8", "4e−8", "6e−8", "8e−8", "1e−7"]);
        assert_eq!(
            labels(1000.0, 1001.0),
            ["1000", "1000.2", "1000.4", "1000.6", "1000.8", "1001"]
        );
        assert_eq!(labels(-1e300, 1.5e300).len(), 6);
        assert_eq!(labels(7.0, 7.0), ["7"]);
        for (low, high) in [
            (1.0, 1.0 + f64::EPSILON),
            (-f64::MAX, f64::MAX),
            (0.0, 5e-324),
            (-1e-310, 1e-310),
            (1e15, 1e15 + 1.0),
        ] {
            let ticks = ticks([low, high]);
            assert!(ticks.len() > 1, "{low} {high}: {ticks:?}");
            assert!(
                ticks.iter().all(|(share, _)| (-1e-9..=1.0 + 1e-9).contains(share)),
                "{ticks:?}"
            );
        }
    }
}
