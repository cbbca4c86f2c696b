//! The ranges of linear values that sRGB bytes and 16-bit numbers stand for.

use std::sync::LazyLock;

use rayon::prelude::*;

use super::linear_from_srgb;

/// The linear values at which sRGB numbers of 8 or of 16 bits end: between `b − 1` and `b` lies
/// `linear_from_srgb((b − ½)/largest)` as f64, `largest` being 255 or 65535. A value on an edge
/// belongs to the number above it, one outside `0..=1` to the number next to it.
///
/// ```
/// # use kugelblitz::scene::Edges;
/// let edges = Edges::srgb8();
/// assert_eq!(edges.number(0.5), 188);
/// let (low, high) = edges.range(188);
/// assert_eq!((edges.number(low), edges.number(high)), (188, 189));
/// assert_eq!((edges.number(-1.0), edges.number(7.0)), (0, 255));
/// ```
#[derive(Debug)]
pub struct Edges {
    /// `above[b]` is the end of the range of `b`. The last one is NaN, which no value reaches.
    above: Vec<f64>,
    /// The number at the beginning of each of equal parts of `0..1`, and at 1. No part has more
    /// than one edge.
    index: Vec<u16>,
}

impl Edges {
    /// Those of bytes.
    pub fn srgb8() -> &'static Edges {
        static SRGB8: LazyLock<Edges> = LazyLock::new(|| Edges::new(255, 1 << 12));
        &SRGB8
    }

    /// Those of 16-bit numbers.
    pub fn srgb16() -> &'static Edges {
        static SRGB16: LazyLock<Edges> = LazyLock::new(|| Edges::new(65535, 1 << 20));
        &SRGB16
    }

    /// `n_parts` is a power of two, so that the part of a value is found without rounding.
    fn new(largest: u16, n_parts: usize) -> Edges {
        let edge = |number: u16| linear_from_srgb((f64::from(number) - 0.5) / f64::from(largest));
        let mut above: Vec<f64> = (1..=largest).into_par_iter().map(edge).collect();
        let mut index = Vec::with_capacity(n_parts + 1);
        for (number, edge) in (0..).zip(&above) {
            // The first part that begins at the edge or above it.
            index.resize((edge * n_parts as f64).ceil() as usize, number);
        }
        index.resize(n_parts + 1, largest);
        above.push(f64::NAN);
        Edges { above, index }
    }

    /// The number whose range holds a linear value; 0 for NaN.
    #[inline]
    pub fn number(&self, linear: f64) -> u16 {
        let n_parts = self.index.len() - 1;
        // Negative values and NaN come to the first part.
        let part = (linear * n_parts as f64) as usize;
        let first = self.index[part.min(n_parts)];
        first + u16::from(self.above[usize::from(first)] <= linear)
    }

    /// The ends of a number's range: it holds the linear values from the first to below the
    /// second. The ends of all are infinite. A number beyond the largest has the range of that.
    pub fn range(&self, number: u16) -> (f64, f64) {
        let largest = self.above.len() - 1;
        let number = usize::from(number).min(largest);
        let low = if number == 0 { f64::NEG_INFINITY } else { self.above[number - 1] };
        let high = if number == largest { f64::INFINITY } else { self.above[number] };
        (low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::srgb_from_linear;

    fn both() -> [(&'static Edges, u16); 2] {
        [(Edges::srgb8(), 255), (Edges::srgb16(), 65535)]
    }

    /// As [`Edges::number`], by bisection over all ranges.
    fn bisected(edges: &Edges, linear: f64) -> u16 {
        edges.above.partition_point(|&edge| edge <= linear) as u16
    }

    #[test]
    fn every_edge_and_its_neighbours_are_found_as_by_bisection() {
        for (edges, largest) in both() {
            assert_eq!(edges.above.len(), usize::from(largest) + 1);
            assert!(edges.above[..usize::from(largest)].is_sorted_by(|a, b| a < b));
            for number in 1..=largest {
                let (edge, _) = edges.range(number);
                assert_eq!(edges.number(edge), number);
                assert_eq!(edges.number(edge.next_down()), number - 1);
                for linear in [edge.next_down(), edge, edge.next_up()] {
                    assert_eq!(edges.number(linear), bisected(edges, linear), "{linear:e}");
                }
            }
            for part in 0..edges.index.len() {
                let linear = part as f64 / (edges.index.len() - 1) as f64;
                for linear in [linear.next_down(), linear, linear.next_up()] {
                    assert_eq!(edges.number(linear), bisected(edges, linear), "{linear:e}");
                }
            }
        }
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
            assert!(edges.index.windows(2).all(|two| two[1] - two[0] <= 1));
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
        let sum = |edges: &Edges| {
            let bits = edges.above.iter().filter(|edge| !edge.is_nan()).map(|edge| edge.to_bits());
            bits.fold(0u64, |sum, bits| sum.rotate_left(5).wrapping_mul(31).wrapping_add(bits))
        };
        let sums = both().map(|(edges, _)| sum(edges));
        assert_eq!(sums, [0x9893_db0a_b979_276b, 0x8ed9_daf8_9553_3c57], "{sums:x?}");
    }
}
