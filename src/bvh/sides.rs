//! The boxes of spheres. They are wide enough that whatever rounds around them, no sphere is lost.
//!
//! Coordinates are relative to the tree's reference point. A sphere at `L` with radius `r` gets the box
//! `[L_k − r − δ_k, L_k + r + δ_k]` with `δ_k = 2⁻⁴⁵(|L_k| + r)`, rounded outward to f32; a node gets
//! the union, which is exact.
//!
//! # What is needed of the margin
//! Of `L_k`, of `L_k − r` and of the margin's subtraction there are roundings of `½·2⁻⁵²`, and one is in reserve, each of up
//! to `|L_k| + r`. Together `2⁻⁵¹(|L_k| + r)`, `NEED`. What rounds in the ray itself is in the bounds of a
//! [`Beam`](super::Beam), and what rounds in the slabs is in its constants.
//!
//! The margin is `2⁶` times that: hidden in f32's own outward rounding, it costs nothing, and half of it
//! is seen by no test of a ray. A test looks at the need itself.

use glam::DVec3;

use crate::num::{round_down, round_up};

/// Lower and upper corner.
pub type Sides = [[f32; 3]; 2];

/// What rounds around a box, of `|L_k| + r`.
#[cfg(test)]
const NEED: f64 = 1.0 / (1u64 << 51) as f64;

/// The margin of a box, of `|L_k| + r`: `2⁶` times the need, so that no test sees it halved.
const MARGIN: f64 = 1.0 / (1u64 << 45) as f64;

/// The sides of a box around the sphere at `l` from the reference point.
pub fn of_sphere(l: DVec3, radius: f64) -> Sides {
    let r = radius.abs();
    let margin = (l.abs() + r) * MARGIN;
    [(l - r - margin).to_array().map(round_down), (l + r + margin).to_array().map(round_up)]
}

/// Around both.
pub fn union([a, b]: Sides, [c, d]: Sides) -> Sides {
    [std::array::from_fn(|k| a[k].min(c[k])), std::array::from_fn(|k| b[k].max(d[k]))]
}

/// Around nothing.
pub const NOTHING: Sides = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::random::SplitMix;

    /// What a two-sum gives: a difference and what it lost, exactly (Knuth).
    fn difference(a: f64, b: f64) -> (f64, f64) {
        let s = a - b;
        let part = s - a;
        (s, (a - (s - part)) - (b + part))
    }

    /// The lower side of a slab without any margin, in the steps of `of_sphere`, and one more: how far
    /// it is above the exact one, as part of what is needed.
    #[test]
    fn the_need_of_a_margin() {
        let mut random = SplitMix::new(1103);
        let mut number = || {
            let mantissa = match random.unit() {
                u if u < 0.5 => 1.0 + (16.0 * random.unit()).floor() * f64::EPSILON,
                _ => 1.0 + random.unit(),
            };
            let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            sign * mantissa * 2f64.powf((6.0 * random.unit() - 3.0).round())
        };
        let mut worst = 0.0;
        for _ in 0..2_000_000 {
            let (center, reference, r) = (number(), number(), number().abs());
            let ((l, lost_l), tiny) = (difference(center, reference), number() * f64::EPSILON);
            let (low, lost_low) = difference(l, r);
            let (low, lost_margin) = difference(low, tiny);
            let (_, lost_slack) = difference(low, tiny);
            let lost = lost_l + lost_low + lost_margin + lost_slack;
            worst = f64::max(worst, lost.abs() / (NEED * (l.abs() + r)));
        }
        println!("{worst:.4} of what is said to be needed");
        assert!(worst <= 1.0 && worst > 0.5, "{worst}");
    }
}
