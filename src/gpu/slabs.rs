//! A ray in f32 and the boxes of the tree, with room for the arithmetic of any device.
//!
//! With the unit `ε` of [`crate::guard`], a slab `(c − o)·(1/d)` has these relative errors: ½ of the
//! direction, which the host rounds, 2½ of the inverse, and 1 each of its widening, the difference and
//! the product. That is `6ε` and something of second order: [`SLAB`]. Of the origin, ½ is left out with
//! its low part, and 1 is lost where the slack is added, both of its largest component: [`ASIDE`].
//!
//! A direction below [`FLAT`] counts as that, as long as one is needed to divide by. Up to the end of the tree, at `t ≤ 2⁴²` as
//! boxes and origins are within [`REACH`] and the largest component is at least `1/√3`, it moves by less than
//! `2⁻³⁸`. That, and what underflows, is in the slack's least part, `2⁻³⁷`; half of it would do for all
//! that a test finds. So a flat ray within a slab leaves it at `2⁻³⁸·2⁸⁰ = 2⁴²` at the earliest. No slab reaches
//! `2⁴¹·2⁸⁰·2 = 2¹²²`, so that none overflows.

use crate::num::fields::fields;
use crate::num::{Float as _, Ray, Real, V3};

#[cfg(doc)]
use crate::bvh::REACH;

/// Relative room of a slab, in units `ε`.
pub const SLAB: f64 = 6.5;

/// How far a ray may lie beside the true one, in units `ε` of its origin's largest component.
pub const ASIDE: f64 = 1.75;

/// Components of a direction below this count as this. No test sees it halved: slabs then reach `2¹²³`, and none overflows.
pub const FLAT: f64 = 1.0 / (1u128 << 80) as f64;

/// The least slack. No test sees it halved: it is still what a ray moves along a flat axis.
pub const LEAST_SLACK: f32 = 1.0 / (1u64 << 37) as f32;

/// A ray along all axes. What it enters first is a box's low side, or its high side where it goes down.
#[derive(Clone, Copy, Debug)]
pub struct Slabs<R> {
    /// The origin, moved by the slack to meet near sides sooner.
    pub near_origin: V3<R>,
    /// The origin, moved by the slack to meet far sides later.
    pub far_origin: V3<R>,
    /// `1/direction`, nearer to 0.
    pub near_inverse: V3<R>,
    /// `1/direction`, farther from 0.
    pub far_inverse: V3<R>,
}

fields! { Slabs { near_origin: vec, far_origin: vec, near_inverse: vec, far_inverse: vec } }

/// Bounds of the `t` between which a ray is between the sides of a box, along each axis.
#[derive(Clone, Copy, Debug)]
pub struct Stretch<R> {
    /// It is not there before.
    pub enter: V3<R>,
    /// Nor after.
    pub leave: V3<R>,
}

fields! { Stretch { enter: vec, leave: vec } }

impl<R: Real> Slabs<R> {
    /// Makes the slabs of a ray that may lie `beside` the true one, at least by [`LEAST_SLACK`].
    #[inline(always)]
    pub fn new(ray: &Ray<R>, beside: R) -> Slabs<R> {
        let Ray { origin, direction, .. } = ray;
        let slack = largest(origin.abs()) * R::lit(ASIDE * R::One::UNIT) + beside;
        let goes_down = is_negative(*direction);
        let steep = direction.abs().max(V3([R::lit(FLAT); 3]));
        let way = select(goes_down, -steep, steep);
        let aside = select(goes_down, V3([-slack; 3]), V3([slack; 3]));
        let inverse = inverse(way);
        Slabs {
            near_origin: *origin + aside,
            far_origin: *origin - aside,
            near_inverse: inverse * R::splat(R::One::down(1.0 - SLAB * R::One::UNIT)),
            far_inverse: inverse * R::splat(R::One::up(1.0 + SLAB * R::One::UNIT)),
        }
    }

    /// When the ray is between the sides of a box.
    #[inline(always)]
    pub fn between(&self, low: V3<R>, high: V3<R>) -> Stretch<R> {
        let goes_down = is_negative(self.near_inverse);
        let near_side = select(goes_down, high, low);
        let far_side = select(goes_down, low, high);
        Stretch {
            enter: (near_side - self.near_origin).times(self.near_inverse),
            leave: (far_side - self.far_origin).times(self.far_inverse),
        }
    }
}

impl<R: Real> Stretch<R> {
    /// Whether the ray may meet the box at `0 ≤ t ≤ t_max`.
    #[inline(always)]
    pub fn is_within(&self, t_max: R) -> R::Mask {
        let V3([x, y, z]) = self.leave;
        let first = largest(self.enter).max(R::lit(0.0));
        let last = x.min(y).min(z).min(t_max);
        first.le(last)
    }
}

/// The largest of three numbers.
#[inline(always)]
#[track_caller]
fn largest<R: Real>(V3([x, y, z]): V3<R>) -> R {
    x.max(y).max(z)
}

/// Component by component.
#[inline(always)]
#[track_caller]
fn is_negative<R: Real>(V3([x, y, z]): V3<R>) -> [R::Mask; 3] {
    let zero = R::lit(0.0);
    [x.lt(zero), y.lt(zero), z.lt(zero)]
}

/// Component by component.
#[inline(always)]
#[track_caller]
fn inverse<R: Real>(V3([x, y, z]): V3<R>) -> V3<R> {
    let one = R::lit(1.0);
    V3([one / x, one / y, one / z])
}

/// Component by component.
#[inline(always)]
#[track_caller]
fn select<R: Real>(mask: [R::Mask; 3], V3([a, b, c]): V3<R>, V3([x, y, z]): V3<R>) -> V3<R> {
    V3([R::select(mask[0], a, x), R::select(mask[1], b, y), R::select(mask[2], c, z)])
}
