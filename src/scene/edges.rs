//! The ranges of linear values that sRGB bytes and 16-bit numbers stand for.

#![allow(clippy::needless_range_loop, reason = "the places of several arrays go side by side")]

use std::sync::LazyLock;

use super::linear_from_srgb;
use crate::num::round_up;
use crate::num::{Float, Lanes, Mask, Real};

/// The linear values at which sRGB numbers of 8 or of 16 bits end: between `b − 1` and `b` lies
/// `linear_from_srgb((b − ½)/largest)` as f64, `largest` being 255 or 65535. A value on an edge
/// belongs to the number above it, one outside `0..=1` to the number next to it.
///
/// ```
/// # use kugelblitz::scene::QuantizationTable;
/// let edges = QuantizationTable::srgb8();
/// assert_eq!(edges.number(0.5), 188);
/// let (low, high) = edges.range(188);
/// assert_eq!((edges.number(low), edges.number(high)), (188, 189));
/// assert_eq!((edges.number(-1.0), edges.number(7.0)), (0, 255));
/// ```
#[derive(Debug)]
pub struct QuantizationTable {
    /// The end of the range of each number, infinity for the last one and one more.
    ends: Vec<f64>,
    /// The number half a part before the beginning of each of equal parts of `0..1`, and before 1. Half a part
    /// farther on either side, there is at most one edge.
    nearest: Vec<u16>,
}

/// [`QuantizationTable::nearest`] and [`QuantizationTable::ends`] of bytes, in tables with a place for each number that a place in them
/// can be made of.
#[derive(Debug)]
pub struct OfBytes {
    nearest: [u8; 2 * BYTE_PARTS],
    ends: [f64; 512],
    /// Rounded up: a number of f32 is below an end where it is below this.
    narrow_ends: [f32; 512],
}

static BYTES: LazyLock<OfBytes> = LazyLock::new(|| {
    let QuantizationTable { ends, nearest } = QuantizationTable::srgb8();
    let end = |at: usize| ends.get(at).copied().unwrap_or(f64::INFINITY);
    OfBytes {
        nearest: std::array::from_fn(|part| nearest.get(part).map_or(0, |&number| number as u8)),
        ends: std::array::from_fn(end),
        narrow_ends: std::array::from_fn(|at| round_up(end(at))),
    }
});

/// Most ends of ranges that are looked at for bytes that are close together.
const CLOSE: usize = 8;

/// Parts of `0..1` for bytes.
const BYTE_PARTS: usize = 1 << 12;

/// Linear values in f32 or f64.
pub trait Linear: Float {
    /// From here to twice as much there are whole numbers alone.
    const WHOLE: f64;
    /// The last bits of one of these.
    fn last_bits(self) -> usize;
    /// The ends of the ranges of bytes.
    fn ends(of_bytes: &OfBytes) -> &[Self; 512];
}

impl Linear for f32 {
    const WHOLE: f64 = (1u32 << 23) as f64;

    #[inline(always)]
    fn last_bits(self) -> usize {
        self.to_bits() as usize
    }

    #[inline(always)]
    fn ends(of_bytes: &OfBytes) -> &[f32; 512] {
        &of_bytes.narrow_ends
    }
}

impl Linear for f64 {
    const WHOLE: f64 = (1u64 << 52) as f64;

    #[inline(always)]
    fn last_bits(self) -> usize {
        self.to_bits() as u32 as usize
    }

    #[inline(always)]
    fn ends(of_bytes: &OfBytes) -> &[f64; 512] {
        &of_bytes.ends
    }
}

impl QuantizationTable {
    /// The edges between sRGB bytes.
    pub fn srgb8() -> &'static QuantizationTable {
        static SRGB8: LazyLock<QuantizationTable> =
            LazyLock::new(|| QuantizationTable::new(255, BYTE_PARTS));
        &SRGB8
    }

    /// The edges between 16-bit sRGB numbers.
    pub fn srgb16() -> &'static QuantizationTable {
        static SRGB16: LazyLock<QuantizationTable> =
            LazyLock::new(|| QuantizationTable::new(65535, 1 << 20));
        &SRGB16
    }

    /// `n_parts` is a power of two, so that the part of a value is found without rounding.
    fn new(largest: u16, n_parts: usize) -> QuantizationTable {
        let edge = |number: u16| linear_from_srgb((f64::from(number) - 0.5) / f64::from(largest));
        // Not side by side: a worker that waits for others takes up work that may wait for these edges.
        let mut ends: Vec<f64> = (1..=largest).map(edge).collect();
        let mut nearest = Vec::with_capacity(n_parts + 1);
        for (number, edge) in (0..largest).zip(&ends) {
            // The first part that begins half a part behind the edge or later.
            nearest.resize((edge * n_parts as f64 + 0.5).ceil() as usize, number);
        }
        nearest.resize(n_parts + 1, largest);
        ends.extend([f64::INFINITY; 2]);
        QuantizationTable { ends, nearest }
    }

    /// The number whose range holds a linear value; 0 for NaN.
    #[inline]
    pub fn number(&self, linear: f64) -> u16 {
        self.numbers(&[linear.clamp(0.0, 1.0)], &[0.0]).0[0]
    }

    /// The numbers of linear values side by side, and whether the values in `high` have the same ones. These are
    /// not below the values in `low`, or no numbers.
    #[inline(always)]
    pub(crate) fn numbers<const N: usize>(
        &self,
        low: &[f64; N],
        high: &[f64; N],
    ) -> ([u16; N], [bool; N]) {
        let QuantizationTable { nearest, ends, .. } = self;
        let parts = places((nearest.len() - 1) as f64, low);
        let (mut numbers, mut are_same) = ([0; N], [false; N]);
        for at in 0..N {
            let first = nearest[parts[at].last_bits()];
            let number = first + u16::from(ends[usize::from(first)] <= low[at]);
            numbers[at] = number;
            are_same[at] = high[at] < ends[usize::from(number)];
        }
        (numbers, are_same)
    }

    /// [`QuantizationTable::numbers`] of bytes; quicker where they are close together.
    #[inline(always)]
    pub(crate) fn bytes<F: Linear, const N: usize>(
        low: Lanes<F, N>,
        high: Lanes<F, N>,
    ) -> ([u8; N], [bool; N]) {
        let of_bytes = &*BYTES;
        let (nearest, ends) = (&of_bytes.nearest, F::ends(of_bytes));
        let (mut bytes, mut are_same) = ([0; N], [false; N]);
        let [part] = places(F::near(BYTE_PARTS as f64), &[low.0[N / 2]]);
        let middle = usize::from(nearest[part.last_bits() % (2 * BYTE_PARTS)]);
        for n_ends in [2, CLOSE] {
            // The first of the bytes that are looked at, and where they end.
            let first = middle.saturating_sub(n_ends / 2);
            let below = first.checked_sub(1).map_or(F::near(f64::NEG_INFINITY), |at| ends[at]);
            let (below, last) = (Lanes::splat(below), Lanes::splat(ends[first + n_ends]));
            if (!(below.le(low) & high.lt(last))).any() {
                continue;
            }
            let (zero, one) = (Lanes::lit(0.0), Lanes::lit(1.0));
            let (mut byte, mut byte_of_high) = (zero, zero);
            for &end in &ends[first..first + n_ends] {
                let end = Lanes::splat(end);
                byte = byte + Lanes::select(end.le(low), one, zero);
                byte_of_high = byte_of_high + Lanes::select(end.le(high), one, zero);
            }
            let number = byte + Lanes::lit(first as f64 + F::WHOLE);
            for lane in 0..N {
                bytes[lane] = number.0[lane].last_bits() as u8;
                are_same[lane] = byte_of_high.0[lane].le(byte.0[lane]);
            }
            return (bytes, are_same);
        }
        let parts = places(F::near(BYTE_PARTS as f64), &low.0);
        for at in 0..N {
            let first = usize::from(nearest[parts[at].last_bits() % (2 * BYTE_PARTS)]);
            let number = first + usize::from(ends[first].le(low.0[at]));
            bytes[at] = number as u8;
            are_same[at] = high.0[at].lt(ends[number]);
        }
        (bytes, are_same)
    }

    /// The ends of a number's range: it holds the linear values from the first to below the
    /// second. The ends of all are infinite. A number beyond the largest has the range of that.
    pub fn range(&self, number: u16) -> (f64, f64) {
        let number = usize::from(number).min(self.ends.len() - 2);
        (
            number.checked_sub(1).map_or(f64::NEG_INFINITY, |below| self.ends[below]),
            self.ends[number],
        )
    }
}

/// The place of the nearest of so many parts, in the last bits of each number.
#[inline(always)]
fn places<F: Linear, const N: usize>(n_parts: F, linear: &[F; N]) -> [F; N] {
    let mut places = [F::default(); N];
    for at in 0..N {
        // What is no number is in the first part.
        let part = F::default().max(linear[at] * n_parts);
        // The sum is rounded to a whole number.
        places[at] = n_parts.min(part) + F::near(F::WHOLE);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::srgb_from_linear;

    fn both() -> [(&'static QuantizationTable, u16); 2] {
        [(QuantizationTable::srgb8(), 255), (QuantizationTable::srgb16(), 65535)]
    }

    /// The number that [`QuantizationTable::number`] gives, by bisection over all ranges.
    fn bisected(edges: &QuantizationTable, linear: f64) -> u16 {
        edges.ends.partition_point(|&edge| edge <= linear) as u16
    }

    #[test]
    fn every_edge_and_its_neighbours_are_found_as_by_bisection() {
        for (edges, largest) in both() {
            assert_eq!(edges.ends.len(), usize::from(largest) + 2);
            assert!(edges.ends[..=usize::from(largest)].is_sorted_by(|a, b| a < b));
            for number in 1..=largest {
                let (edge, _) = edges.range(number);
                assert_eq!(edges.number(edge), number);
                assert_eq!(edges.number(edge.next_down()), number - 1);
                for linear in [edge.next_down(), edge, edge.next_up()] {
                    assert_eq!(edges.number(linear), bisected(edges, linear), "{linear:e}");
                }
            }
            for part in 0..2 * edges.nearest.len() - 1 {
                let linear = 0.5 * part as f64 / (edges.nearest.len() - 1) as f64;
                for linear in [linear.next_down(), linear, linear.next_up()] {
                    assert_eq!(edges.number(linear), bisected(edges, linear), "{linear:e}");
                }
            }
        }
    }

    #[test]
    fn numbers_side_by_side_are_those_of_each() {
        for (edges, largest) in both() {
            let mut ends = vec![-1.0, -0.0, 0.0, 1e-300, 0.5, 1.0, 7.0, 1e300];
            for number in (1..=largest).step_by(1 + usize::from(largest) / 500) {
                let (edge, _) = edges.range(number);
                ends.extend([edge.next_down(), edge, edge.next_up()]);
            }
            for part in (0..edges.nearest.len()).step_by(1 + edges.nearest.len() / 5000) {
                let middle = (part as f64 + 0.5) / (edges.nearest.len() - 1) as f64;
                ends.extend([middle.next_down(), middle, middle.next_up()]);
            }
            ends.sort_by(f64::total_cmp);
            for n_on in 0..5 {
                for (low, high) in ends.iter().zip(&ends[n_on..]) {
                    let ([number], [is_same]) = edges.numbers(&[*low], &[*high]);
                    assert_eq!(number, edges.number(*low));
                    assert_eq!(is_same, edges.number(*high) == number, "{low:e} {high:e}");
                    if largest == 255 {
                        let of_bytes = QuantizationTable::bytes(Lanes([*low]), Lanes([*high]));
                        assert_eq!(of_bytes, ([number as u8], [is_same]), "{low:e} {high:e}");
                    }
                }
            }
            for nothing in [f64::NAN, f64::INFINITY] {
                assert_eq!(edges.numbers(&[0.0], &[nothing]).1, [false]);
                assert_eq!(edges.numbers(&[nothing], &[nothing]).1, [false]);
                assert_eq!(QuantizationTable::bytes(Lanes([nothing]), Lanes([nothing])).1, [false]);
            }
        }
    }

    /// Values side by side, in steps that are far below a byte's range, about as large, and larger.
    fn look_at_close_bytes<F: Linear>() {
        let edges = QuantizationTable::srgb8();
        for first in 0..2000 {
            let first = (f64::from(first) - 20.0) / 1900.0;
            for step in [0.0, 1e-5, 3e-4, 2e-3, 0.05] {
                for width in [0.0, 1e-6, 1e-3] {
                    let low = Lanes::<F, 16>(std::array::from_fn(|lane| {
                        F::near(first + step * (lane % 5) as f64)
                    }));
                    let high = low + Lanes::lit(width);
                    let (bytes, are_same) = QuantizationTable::bytes(low, high);
                    for lane in 0..16 {
                        let [low, high] = [low, high].map(|some| some.0[lane].to_f64());
                        let is_same = edges.number(high) == edges.number(low);
                        assert_eq!(are_same[lane], is_same, "{low:e} {high:e}");
                        if is_same {
                            assert_eq!(u16::from(bytes[lane]), edges.number(low), "{low:e}");
                        }
                    }
                }
            }
        }
        // What is no number has no byte.
        let nothing = Lanes::<F, 16>::lit(f64::NAN);
        assert_eq!(QuantizationTable::bytes(nothing, nothing).1, [false; 16]);
        assert_eq!(QuantizationTable::bytes(Lanes::lit(0.0), nothing).1, [false; 16]);
    }

    #[test]
    fn bytes_that_are_close_are_those_of_each() {
        look_at_close_bytes::<f32>();
        look_at_close_bytes::<f64>();
    }

    #[test]
    fn what_is_outside_belongs_to_the_number_next_to_it() {
        for (edges, largest) in both() {
            for (linear, number) in [
                (f64::NEG_INFINITY, 0),
                (-1e-300, 0),
                (-0.0, 0),
                (5e-324, 0),
                (f64::NAN, 0),
                (1.0, largest),
                (1e300, largest),
                (f64::INFINITY, largest),
            ] {
                assert_eq!(edges.number(linear), number, "{linear:e}");
            }
            assert_eq!(edges.range(0).0, f64::NEG_INFINITY);
            assert_eq!(edges.range(largest).1, f64::INFINITY);
            assert_eq!(edges.range(u16::MAX), edges.range(largest));
        }
    }

    #[test]
    fn a_part_has_at_most_one_edge() {
        for (edges, _) in both() {
            for (part, &first) in edges.nearest.iter().enumerate() {
                let n_parts = (edges.nearest.len() - 1) as f64;
                let ends = [-0.5, 0.5].map(|end| bisected(edges, (part as f64 + end) / n_parts));
                assert!(ends[0] == first && ends[1] - first <= 1, "{part}: {first} {ends:?}");
            }
        }
    }

    /// The transfer function back and forth ends in the middle of the number's range, so edges lie
    /// where rounding to the nearest number has them.
    #[test]
    fn edges_lie_halfway() {
        for (edges, largest) in both() {
            for number in 1..=largest {
                let encoded = srgb_from_linear(edges.range(number).0) * f64::from(largest);
                assert!((encoded - (f64::from(number) - 0.5)).abs() < 1e-4, "{number}: {encoded}");
            }
        }
    }

    /// A sum over the bits of all edges, as it came out on x86-64 Linux: another power function
    /// would give other pictures.
    #[test]
    fn edges_are_the_same_everywhere() {
        let sum = |edges: &QuantizationTable| {
            let bits = edges.ends.iter().filter(|edge| edge.is_finite()).map(|edge| edge.to_bits());
            bits.fold(0u64, |sum, bits| sum.rotate_left(5).wrapping_mul(31).wrapping_add(bits))
        };
        let sums = both().map(|(edges, _)| sum(edges));
        assert_eq!(sums, [0x9893_db0a_b979_276b, 0x8ed9_daf8_9553_3c57], "{sums:x?}");
    }
}
