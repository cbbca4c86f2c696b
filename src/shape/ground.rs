//! Large spheres, for shadow rays that start near their surface: the ground under a scene.
//!
//! Distances from the center are as large as the radius, and f32 cannot compute the height of a point from them. The
//! *power* of a point, `|p − c|² − r²`, has that information: it is positive outside, and its square root is the length of a tangent
//! from the point. It is computed without cancellation from the power `k` of the reference point:
//! `|p − c|² − r² = k − p·(2c − p) = k − p·(c + l)` with `l = c − p`.
//!
//! # Occlusion
//! Let `C` and `Q` be the powers of the start and of the light. Along the shadow ray `p + s·w` the power is
//! `f(s) = C(1 − s) + Qs − |w|²s(1 − s)`.
//! - One of `C` and `Q` is negative, and the other positive: the ray crosses the surface. Both are negative: it does not, because a ball
//!   is convex.
//! - Both are positive: `f(s)/(s(1 − s)) = C/s + Q/(1 − s) − |w|²`, and the least value of the first two terms is `(√C + √Q)²`, by the
//!   inequality of Cauchy and Schwarz. The sphere does not occlude exactly if `√C + √Q > |w|`. For a light on the sphere,
//!   `Q = 0`.
//! - A sun: `f(s) = C − 2s·l·w + s²|w|²`. From outside, the sphere does not occlude exactly if `√C > l·w/|w|`. From inside it does.
//!
//! # Bounds
//! The errors of the offsets `c` and `l`, of their sum, and of the dot product are `2·ε|c|`, `ε|l|`, `ε(|c| + |l|)`, and `3ε` of the product
//! of the lengths: `6ε|p|(|c| + |l|)` together. The difference is rounded, by `ε|C|`. A point with an error of `e` changes the power by
//! at most `2e|l| + e²`. The light is computed as `p + w`, with the error of the end of the way and one rounding. A length has an error of
//! `8ε`, with its root, and a difference of lengths has one rounding more: [`OF_LENGTHS`].

use glam::DVec3;

use super::shadow::{Occlusion, ShadowRay};
use super::{Record as _, is_near_surface, record};
use crate::bounds::{ROOM, length_bound};
use crate::num::{Float, Real, V3};
use crate::scene::Sphere;

/// Factor of the lengths in the error of their differences, in units. Halving it is not covered by a test: the errors of powers are larger.
const OF_LENGTHS: f64 = 12.0;

/// Least radius: no power underflows by more than the least error. Halving it is not covered by a test: the range may be smaller.
const SMALLEST: f64 = 1.0 / (1u64 << 20) as f64;

/// Factor of `|p|(|c| + |l|)` in the error of a power, in units.
pub(super) const OF_POWER: f64 = 6.0;

record! {
    /// A large sphere with the reference point close to its surface, for shadow rays.
    GroundOccluder {
        /// From the reference point.
        center: vec near,
        /// The power of the reference point.
        k: num near,
        /// Error of `k`.
        k_error: num up,
        /// Length of `center`, or a little more.
        length: num up,
    }
}

impl<F: Float> GroundOccluder<F> {
    /// Returns the record of a sphere, if the reference point is close to its surface and all numbers are in the range of `F`.
    pub fn new(sphere: &Sphere, reference: DVec3) -> Option<GroundOccluder<F>> {
        let (center, r) = (sphere.center - reference, sphere.radius.abs());
        let length = length_bound(center);
        if !(is_near_surface(length, r, length) && SMALLEST < r && length.max(r) < F::LARGEST_ROOT)
        {
            return None;
        }
        let (k, error) = super::sphere::k_of(center, sphere, reference);
        // Rounded once.
        let k_error = error + ROOM * F::UNIT * k.abs() + F::TINY;
        let met = GroundOccluder { center: V3(center.to_array()), k, k_error, length };
        (k.abs() < f64::MAX).then(|| met.round())
    }
}

impl<R: Real> GroundOccluder<R> {
    /// Returns the power of a point with this error, and the error of the power.
    #[inline(always)]
    pub(super) fn power(&self, point: V3<R>, error: R, unit: R) -> (R, R) {
        let l = self.center - point;
        // Below that squares underflow.
        let least = R::lit(1.0 / R::One::LARGEST_ROOT);
        let (distance, away) = (l.dot(l).sqrt(), point.dot(point).sqrt().max(least));
        let power = self.k - point.dot(self.center + l);
        let rounding = R::lit(OF_POWER) * away * (self.length + distance) + power.abs();
        let moved = error * (distance + distance + error);
        (power, self.k_error + R::lit(ROOM) * (unit * rounding + moved))
    }

    /// Returns whether the sphere occludes a light for a shadow ray that does not start on it. `side` is the side of a light that is
    /// close to it ([`super::Contact`]).
    #[inline(always)]
    pub fn occlude(&self, ray: &ShadowRay<R>, side: Option<R>) -> Occlusion<R> {
        let (lit, zero, one, unit) = (R::lit, R::lit(0.0), R::lit(1.0), ray.unit);
        let is_point = zero.lt(ray.from_point);
        let (start, start_error) = self.power(ray.start, ray.error, unit);
        let light = ray.start + ray.way;
        let light_error = ray.end_error + unit * light.dot(light).sqrt();
        let (end, end_error) = self.power(light, light_error, unit);
        let [start_outside, start_inside] = [start - start_error, -start - start_error];
        let end_outside = R::select(is_point, end - end_error, one);
        let end_inside = R::select(is_point, -end - end_error, -one);
        let (end_outside, end_inside, not_inside, not_outside) = match side {
            None => (end_outside, end_inside, end_outside, end_inside),
            Some(side) => {
                let half = lit(0.5);
                (side - half, -side - half, side + half, half - side)
            }
        };
        let root = |power: R| power.max(zero).sqrt();
        let [start_low, start_high] = [root(start_outside), root(start + start_error)];
        let [mut end_low, mut end_high] = [root(end - end_error), root(end + end_error)];
        if let Some(side) = side {
            let is_on = side.abs().le(zero);
            end_low = R::select(is_on, zero, end_low);
            end_high = R::select(is_on, zero, end_high);
        }
        // Bounds of the least length of a tangent from the start with which the sphere does not occlude.
        let l = self.center - ray.start;
        let offset_error = ray.error + unit * (self.length + l.dot(l).sqrt());
        let (along, along_error) = ray.along(l, offset_error);
        let off = ray.error + ray.end_error;
        let low = R::select(is_point, ray.length - off - end_high, along - along_error);
        let high = R::select(is_point, ray.length + off - end_low, along + along_error);
        let width = lit(OF_LENGTHS) * unit * (ray.length + start_high + end_high);
        // Computed numbers come first: if one is NaN, then so is the minimum.
        let over = (start_low - high - width).min(start_outside).min(not_inside);
        let through = (low - start_high - width).min(start_outside).min(not_inside);
        let crossed = start_inside.min(end_outside).max(start_outside.min(end_inside));
        Occlusion { clear: over.max(start_inside.min(not_outside)), blocked: through.max(crossed) }
    }
}
