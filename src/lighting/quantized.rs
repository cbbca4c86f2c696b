//! Means → the numbers of a picture.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use super::mean::ExactMean;
use crate::exact::{lowest, nearest_f32, real};
use crate::num::Lanes;
use crate::scene::{Linear, QuantizationTable};
use crate::shape::Bounds;

/// A channel of a pixel as a picture has it.
pub trait QuantizedPixels: Copy + Default + PartialEq + Send + Sync {
    /// That of a mean.
    fn of(mean: f64) -> Self;

    /// That of an exact mean, searched from a guess.
    fn of_exact(mean: &ExactMean, channel: usize, guess: f64) -> Self;

    /// That of a byte, where it is one.
    fn of_byte(_: u8) -> Self {
        Self::default()
    }

    /// The numbers of means side by side between lower and upper bounds, and whether they are known.
    #[inline(always)]
    fn of_lanes<F: Linear, const N: usize>(
        low: Lanes<F, N>,
        high: Lanes<F, N>,
    ) -> ([Self; N], [bool; N]) {
        let (mut numbers, mut are_known) = ([Self::default(); N], [false; N]);
        for lane in 0..N {
            let [low, high] = [low.0[lane], high.0[lane]].map(F::to_f64);
            let known = between(Bounds { low, high });
            (numbers[lane], are_known[lane]) = (known.unwrap_or_default(), known.is_some());
        }
        (numbers, are_known)
    }
}

/// The number that all means within bounds have, if they do have one. Infinite bounds are those of a sum that f64 does not
/// have, and prove nothing.
#[inline(always)]
fn between<C: QuantizedPixels>(Bounds { low, high }: Bounds<f64>) -> Option<C> {
    let number = C::of(low);
    (high < f64::INFINITY && number == C::of(high)).then_some(number)
}

/// The colour that all means within bounds have, if they do have one.
pub fn pixel_between<C: QuantizedPixels>(bounds: &[Bounds<f64>; 3]) -> Option<[C; 3]> {
    let [red, green, blue] = bounds.map(between);
    Some([red?, green?, blue?])
}

/// The colour of an exact mean, searched from a guess.
pub fn exact_pixel<C: QuantizedPixels>(mean: &ExactMean, guess: [f64; 3]) -> [C; 3] {
    std::array::from_fn(|channel| C::of_exact(mean, channel, guess[channel]))
}

/// The code up to `most` whose range holds a channel, searched from a guess. What is on an edge goes up.
fn exact_code(
    mean: &ExactMean,
    channel: usize,
    guess: f64,
    edges: &QuantizationTable,
    most: u16,
) -> u16 {
    // The last range has no end.
    let is_below_end = |code: u64| {
        let end = real(edges.range(code as u16).1);
        end.is_none_or(|end| mean.compare(channel, &end).is_lt())
    };
    lowest(edges.number(guess).into(), most.into(), is_below_end) as u16
}

impl QuantizedPixels for u8 {
    fn of(mean: f64) -> u8 {
        QuantizationTable::srgb8().number(mean) as u8
    }

    fn of_exact(mean: &ExactMean, channel: usize, guess: f64) -> u8 {
        exact_code(mean, channel, guess, QuantizationTable::srgb8(), 255) as u8
    }

    fn of_byte(byte: u8) -> u8 {
        byte
    }

    #[inline(always)]
    fn of_lanes<F: Linear, const N: usize>(
        low: Lanes<F, N>,
        high: Lanes<F, N>,
    ) -> ([u8; N], [bool; N]) {
        QuantizationTable::bytes(low, high)
    }
}

impl QuantizedPixels for u16 {
    #[inline(always)]
    fn of(mean: f64) -> u16 {
        QuantizationTable::srgb16().number(mean)
    }

    fn of_exact(mean: &ExactMean, channel: usize, guess: f64) -> u16 {
        exact_code(mean, channel, guess, QuantizationTable::srgb16(), u16::MAX)
    }

    #[inline(always)]
    fn of_lanes<F: Linear, const N: usize>(
        low: Lanes<F, N>,
        high: Lanes<F, N>,
    ) -> ([u16; N], [bool; N]) {
        QuantizationTable::srgb16().numbers(&low.each(F::to_f64).0, &high.each(F::to_f64).0)
    }
}

impl QuantizedPixels for f32 {
    #[inline(always)]
    fn of(mean: f64) -> f32 {
        mean as f32
    }

    fn of_exact(mean: &ExactMean, channel: usize, guess: f64) -> f32 {
        nearest_f32(guess as f32, |x| mean.compare(channel, x))
    }
}
