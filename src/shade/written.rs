//! Means → the numbers of a picture.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use super::mean::ExactMean;
use crate::num::{Lanes, V3};
use crate::scene::{Edges, Linear};

/// Bounds of a number.
#[derive(Clone, Copy, Debug, Default)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// A number that is known.
    pub fn of(number: f64) -> Interval {
        Interval { low: number, high: number }
    }
}

/// A pixel's colour as a picture has it.
pub trait Written: Copy + Default + Send + Sync {
    /// The one that all means within these bounds have, if they do have one; none for infinite bounds.
    fn of_bounds(bounds: &[Interval; 3]) -> Option<Self>;
    /// Whether they are bytes, which f32 is good enough for.
    const IS_BYTES: bool = false;
    /// The same of means side by side, with lower and upper bounds, and whether they do.
    #[inline(always)]
    fn of_lanes<F: Linear, const N: usize>(
        low: &V3<Lanes<F, N>>,
        high: &V3<Lanes<F, N>>,
        out: &mut [Self; N],
    ) -> [bool; N] {
        let mut are_known = [false; N];
        for lane in 0..N {
            let bounds = std::array::from_fn(|channel| Interval {
                low: low.0[channel].0[lane].to_f64(),
                high: high.0[channel].0[lane].to_f64(),
            });
            let known = Self::of_bounds(&bounds);
            (out[lane], are_known[lane]) = (known.unwrap_or_default(), known.is_some());
        }
        are_known
    }
    /// That of bytes as devices give them, `r | g << 8 | b << 16`, where it is of such.
    fn of_code(_: u32) -> Self {
        Self::default()
    }
    /// That of an exact mean, searched from its bounds.
    fn of_exact(mean: &ExactMean, bounds: &[Interval; 3]) -> Self;
    /// That of a mean in a kernel's numbers.
    fn of_plain(mean: [f64; 3]) -> Self;
}

#[inline(always)]
fn code(edges: &Edges, bounds: &Interval) -> Option<u16> {
    let number = edges.number(bounds.low);
    (bounds.high < edges.range(number).1).then_some(number)
}

#[inline(always)]
fn codes(edges: &Edges, [red, green, blue]: &[Interval; 3]) -> Option<[u16; 3]> {
    Some([code(edges, red)?, code(edges, green)?, code(edges, blue)?])
}

fn exact_codes(mean: &ExactMean, edges: &Edges, most: u16, bounds: &[Interval; 3]) -> [u16; 3] {
    std::array::from_fn(|channel| {
        let guess = edges.number(bounds[channel].low);
        mean.code(channel, guess, most, |code| edges.range(code).0)
    })
}

impl Written for [u8; 3] {
    const IS_BYTES: bool = true;

    #[inline(always)]
    fn of_bounds(bounds: &[Interval; 3]) -> Option<Self> {
        codes(Edges::srgb8(), bounds).map(|codes| codes.map(|code| code as u8))
    }

    #[inline(always)]
    fn of_lanes<F: Linear, const N: usize>(
        low: &V3<Lanes<F, N>>,
        high: &V3<Lanes<F, N>>,
        out: &mut [Self; N],
    ) -> [bool; N] {
        let mut are_known = [true; N];
        for channel in 0..3 {
            let (bytes, are_same) = Edges::bytes(low.0[channel], high.0[channel]);
            for lane in 0..N {
                out[lane][channel] = bytes[lane];
                are_known[lane] &= are_same[lane];
            }
        }
        are_known
    }

    fn of_code(code: u32) -> Self {
        [code as u8, (code >> 8) as u8, (code >> 16) as u8]
    }

    fn of_exact(mean: &ExactMean, bounds: &[Interval; 3]) -> Self {
        exact_codes(mean, Edges::srgb8(), 255, bounds).map(|code| code as u8)
    }

    fn of_plain(mean: [f64; 3]) -> Self {
        mean.map(|part| Edges::srgb8().number(part) as u8)
    }
}

impl Written for [u16; 3] {
    #[inline(always)]
    fn of_bounds(bounds: &[Interval; 3]) -> Option<Self> {
        codes(Edges::srgb16(), bounds)
    }

    #[inline(always)]
    fn of_lanes<F: Linear, const N: usize>(
        low: &V3<Lanes<F, N>>,
        high: &V3<Lanes<F, N>>,
        out: &mut [Self; N],
    ) -> [bool; N] {
        let (edges, mut are_known) = (Edges::srgb16(), [true; N]);
        for channel in 0..3 {
            let (mut lows, mut highs) = ([0.0; N], [0.0; N]);
            for lane in 0..N {
                lows[lane] = low.0[channel].0[lane].to_f64();
                highs[lane] = high.0[channel].0[lane].to_f64();
            }
            let (numbers, are_same) = edges.numbers(&lows, &highs);
            for lane in 0..N {
                out[lane][channel] = numbers[lane];
                are_known[lane] &= are_same[lane];
            }
        }
        are_known
    }

    fn of_exact(mean: &ExactMean, bounds: &[Interval; 3]) -> Self {
        exact_codes(mean, Edges::srgb16(), u16::MAX, bounds)
    }

    fn of_plain(mean: [f64; 3]) -> Self {
        mean.map(|part| Edges::srgb16().number(part))
    }
}

impl Written for [f32; 3] {
    #[inline(always)]
    fn of_bounds(bounds: &[Interval; 3]) -> Option<Self> {
        let low = bounds.map(|b| b.low as f32);
        // Infinite bounds are those of a sum that f64 does not have, and prove nothing.
        let are_finite = bounds.iter().all(|b| b.high < f64::INFINITY);
        (are_finite && low == bounds.map(|b| b.high as f32)).then_some(low)
    }

    fn of_exact(mean: &ExactMean, bounds: &[Interval; 3]) -> Self {
        std::array::from_fn(|channel| mean.nearest_f32(channel, bounds[channel].low as f32))
    }

    fn of_plain(mean: [f64; 3]) -> Self {
        mean.map(|part| part as f32)
    }
}
