//! Which colours stand for which numbers of a cloud.

use super::{Color, ColorMap};

/// How the numbers of a column became the colours of a cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Coloring {
    /// The column, as its file names it.
    pub column: String,
    /// The map.
    pub map: ColorMap,
    /// The numbers that have the first and the last colour of the map; what lies beyond has them too.
    pub range: [f64; 2],
    /// The colour of spheres without a number.
    pub missing_color: Color,
    /// How many spheres have no number.
    pub n_missing: usize,
}

impl Coloring {
    /// The colour of spheres without a number, where nobody says another: magenta, which no map has.
    pub const MISSING_COLOR: Color = Color([1.0, 0.0, 1.0]);

    /// Makes colours of the numbers that are all parts of these. `range` is that of the numbers where none
    /// is given, and of no numbers 0; `None` where all that there are is not finite.
    pub(super) fn paint(
        column: String,
        map: ColorMap,
        range: Option<[f64; 2]>,
        missing_color: Color,
        colors: &mut [Color],
    ) -> Option<Coloring> {
        // From the least to the largest that is finite.
        let of_numbers = || {
            let numbers = colors.iter().map(|color| color.0[0]);
            let range = numbers.filter(|number| number.is_finite()).fold(None, |range, number| {
                let [low, high] = range.unwrap_or([number; 2]);
                Some([low.min(number), high.max(number)])
            });
            range.or(colors.is_empty().then_some([0.0; 2]))
        };
        let range = range.or_else(of_numbers)?;
        let palette = map.colors();
        let mut n_missing = 0;
        for color in colors {
            let number = color.0[0];
            *color = if number.is_nan() {
                missing_color
            } else {
                palette[Coloring::place(range, number)]
            };
            n_missing += usize::from(number.is_nan());
        }
        Some(Coloring { column, map, range, missing_color, n_missing })
    }

    /// The place in the map of a number that is not NaN.
    fn place(range: [f64; 2], number: f64) -> usize {
        let [low, high] = range;
        if low == high {
            return match number.total_cmp(&low) {
                std::cmp::Ordering::Less => 0,
                std::cmp::Ordering::Equal => ColorMap::LEN / 2,
                std::cmp::Ordering::Greater => ColorMap::LEN - 1,
            };
        }
        // Halves, as the difference of two large numbers may be infinite.
        let share = (0.5 * number - 0.5 * low) / (0.5 * high - 0.5 * low);
        // As a cast takes them, negative numbers are 0.
        ((share * ColorMap::LEN as f64) as usize).min(ColorMap::LEN - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_place() {
        let place = |range, number| Coloring::place(range, number);
        let range = [-1.0, 1.0];
        assert_eq!([-9.0, -1.0, 0.0, 1.0, 9.0].map(|x| place(range, x)), [0, 0, 128, 255, 255]);
        assert_eq!([f64::INFINITY, -f64::INFINITY].map(|x| place(range, x)), [255, 0]);
        // A step lower than a colour's beginning is the colour before.
        assert_eq!([0.25, 0.25f64.next_down()].map(|x| place([0.0, 1.0], x)), [64, 63]);
        assert_eq!(
            [-f64::MAX, 0.0, f64::MAX].map(|x| place([-f64::MAX, f64::MAX], x)),
            [0, 128, 255]
        );
        assert_eq!([4.0, 5.0, 6.0].map(|x| place([5.0, 5.0], x)), [0, 128, 255]);
    }
}
