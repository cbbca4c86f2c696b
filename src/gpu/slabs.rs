//! A ray in f32 and the boxes of the tree, with room for the arithmetic of any device.
//!
//! With the unit `ε` of [`crate::bounds`], a slab `(c − o)·(1/d)` has these relative errors: ½ of the
//! direction, which the host rounds, 2½ of the inverse, and 1 each of its widening, the difference and
//! the product. That is `6ε` and something of second order: [`SLAB`]. Of the origin, ½ is left out with
//! its low part, and 1 is lost where the slack is added, both of its largest component: [`ASIDE`].
//!
//! A direction below [`FLAT`] counts as that, as long as one is needed to divide by. Up to the end of the tree, at `t ≤ 2⁴²` as
//! boxes and origins are within [`REACH`] and the largest component is at least `1/√3`, it moves by less than
//! `2⁻³⁸`. That, and what underflows, is in the slack's least part, `2⁻³⁷`; half of it would do for all
//! that a test finds. So a flat ray within a slab leaves it at `2⁻³⁸·2⁸⁰ = 2⁴²` at the earliest. No slab reaches
//! `2⁴¹·2⁸⁰·2 = 2¹²²`, so that none overflows.
//!
//! # Ways to lights
//! A shadow ray's `t` counts in lengths of its way. The distance between the true and the computed way at `t` is at most `1 − t`
//! times the error of the start and `t` times the error of the end: [`ShadowRay::beside`] and the boxes contain it. A sun's has no end; its
//! direction is rounded by the host, as above. Points and errors beyond [`REACH`] are not looked at: [`is_near`]. So no slab reaches
//! `2⁴²·2⁸⁰ = 2¹²²` here either.

use crate::bvh::REACH;
use crate::num::fields::fields;
use crate::num::{Float as _, Ray, Real, V3};
use crate::shape::ShadowRay;

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
pub struct SlabInterval<R> {
    /// It is not there before.
    pub enter: V3<R>,
    /// Nor after.
    pub leave: V3<R>,
}

fields! { SlabInterval { enter: vec, leave: vec } }

impl<R: Real> Slabs<R> {
    /// Makes the slabs of a ray that may lie `beside` the true one, at least by [`LEAST_SLACK`].
    #[inline(always)]
    pub fn new(ray: &Ray<R>, beside: R) -> Slabs<R> {
        let slack = largest(ray.origin.abs()) * R::lit(ASIDE * R::One::UNIT) + beside;
        Slabs::along(ray.origin, ray.direction, slack)
    }

    /// Makes the slabs of a way to a light; they mean nothing where it is not [near](is_near).
    #[inline(always)]
    pub fn to_light(ray: &ShadowRay<R>) -> Slabs<R> {
        let (zero, least) = (R::lit(0.0), R::lit(f64::from(LEAST_SLACK)));
        let has_slabs = is_near(ray);
        let of_start = largest(ray.start.abs()) * R::lit(ASIDE * R::One::UNIT);
        let room = of_start + (ray.beside() + least);
        let slack = R::select(has_slabs, room, zero);
        let start = V3::select(has_slabs, ray.start, V3([zero; 3]));
        Slabs::along(start, ray.way, slack)
    }

    #[inline(always)]
    fn along(origin: V3<R>, direction: V3<R>, slack: R) -> Slabs<R> {
        let goes_down = is_negative(direction);
        let steep = direction.abs().max(V3([R::lit(FLAT); 3]));
        let way = select(goes_down, -steep, steep);
        let aside = select(goes_down, V3([-slack; 3]), V3([slack; 3]));
        let inverse = inverse(way);
        Slabs {
            near_origin: origin + aside,
            far_origin: origin - aside,
            near_inverse: inverse * R::splat(R::One::down(1.0 - SLAB * R::One::UNIT)),
            far_inverse: inverse * R::splat(R::One::up(1.0 + SLAB * R::One::UNIT)),
        }
    }

    /// When the ray is between the sides of a box.
    #[inline(always)]
    pub fn between(&self, low: V3<R>, high: V3<R>) -> SlabInterval<R> {
        let goes_down = is_negative(self.near_inverse);
        let near_side = select(goes_down, high, low);
        let far_side = select(goes_down, low, high);
        SlabInterval {
            enter: (near_side - self.near_origin).times(self.near_inverse),
            leave: (far_side - self.far_origin).times(self.far_inverse),
        }
    }
}

impl<R: Real> SlabInterval<R> {
    /// Whether the ray may meet the box at `0 ≤ t ≤ t_max`.
    #[inline(always)]
    pub fn is_within(&self, t_max: R) -> R::Mask {
        let V3([x, y, z]) = self.leave;
        let first = largest(self.enter).max(R::lit(0.0));
        let last = x.min(y).min(z).min(t_max);
        first.le(last)
    }
}

/// Whether a way to a light starts and ends, as far as it is known, where f32 has slabs for it.
#[inline(always)]
pub fn is_near<R: Real>(ray: &ShadowRay<R>) -> R::Mask {
    let reach = R::lit(REACH);
    largest(ray.start.abs()).lt(reach) & ray.beside().lt(reach)
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

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::num::{round_down, round_up};
    use crate::shape::shadow::{Aim, BEND_IN_BOXES, Origin};

    fn power(rng: &mut ChaCha8Rng, least: f64, most: f64) -> f64 {
        rng.random_range(least..most).exp2()
    }

    fn vector(rng: &mut ChaCha8Rng, size: f64) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| rng.random_range(-size..size)))
    }

    fn is_met(slabs: &Slabs<f32>, box_: [V3<f32>; 2], last: f32) -> bool {
        let [low, high] = box_;
        slabs.between(low, high).is_within(last)
    }

    /// A shadow ray meets the box around each point of the true way, whatever the error of its start, because the box is wider by the
    /// error of a far light. Without room for the error of the start, some are lost.
    #[test]
    fn ways_to_lights_meet_what_is_on_them() {
        let mut rng = ChaCha8Rng::seed_from_u64(51);
        let (mut n_lost, mut n_lost_by_boxes, mut n_far) = (0, 0, 0);
        for case in 0..60_000 {
            let size = power(&mut rng, -30.0, 30.0);
            let far = if case % 3 == 0 { power(&mut rng, 0.0, 18.0) } else { 1.0 };
            let (start, light) = (vector(&mut rng, size), vector(&mut rng, size * far));
            let off = size * power(&mut rng, if far > 1.0 { -40.0 } else { -23.0 }, -6.0);
            let (origin, way) = match case % 2 {
                0 => (Origin::Point(light), light - start),
                _ => (Origin::Sun(-light), light),
            };
            let found = V3((start + vector(&mut rng, off / 1.8)).to_array().map(|x| x as f32));
            let ray = ShadowRay::new(&Aim::<f32>::new(origin), found, off as f32);
            if !is_near(&ray) {
                continue;
            }
            let at = start + way * rng.random_range(0.0..1.0_f64).min(size / way.length());
            let box_about = |units: f64| {
                let room = DVec3::splat(1.01 * units * f32::UNIT * at.length());
                let (low, high) = (at - room, at + room);
                [V3(low.to_array().map(round_down)), V3(high.to_array().map(round_up))]
            };
            let (slabs, box_) = (Slabs::to_light(&ray), box_about(BEND_IN_BOXES));
            assert!(
                is_met(&slabs, box_, ray.last),
                "{start:?} {origin:?} {found:?} {off:e} {at:?}"
            );
            let exact = Slabs::along(found, ray.way, LEAST_SLACK);
            n_lost += u32::from(!is_met(&exact, box_, ray.last));
            n_lost_by_boxes += u32::from(!is_met(&slabs, box_about(0.0), ray.last));
            n_far += u32::from(far > 1.0);
        }
        println!("{n_lost} lost without the error of the start, {n_lost_by_boxes} in narrow boxes");
        assert!(n_lost > 1000 && n_far > 10_000, "{n_lost}, {n_far}");
    }

    /// Neither of ways that are near nor of others is a number infinite.
    #[test]
    fn ways_to_lights_have_finite_slabs() {
        let mut rng = ChaCha8Rng::seed_from_u64(52);
        let mut n_near = 0;
        for _ in 0..20_000 {
            let [near, far] = [50.0, 60.0].map(|most| power(&mut rng, -60.0, most));
            let start = vector(&mut rng, far);
            let light = vector(&mut rng, near);
            let error = power(&mut rng, -80.0, 61.0) as f32;
            let origin = match rng.random_range(0..2) {
                0 => Origin::Point(light),
                _ => Origin::Sun(crate::num::ScaledInteger::new(light).rounded()),
            };
            let start = V3(start.to_array().map(|x| x as f32));
            let ray = ShadowRay::new(&Aim::<f32>::new(origin), start, error);
            let slabs = Slabs::to_light(&ray);
            let reach = REACH as f32;
            let SlabInterval { enter, leave } = slabs.between(V3([-reach; 3]), V3([reach; 3]));
            let Slabs { near_origin, far_origin, near_inverse, far_inverse } = slabs;
            let all = [near_origin, far_origin, near_inverse, far_inverse, enter, leave];
            assert!(all.iter().all(|v| v.0.iter().all(|x| x.is_finite())), "{slabs:?} {ray:?}");
            n_near += u32::from(is_near(&ray));
        }
        assert!((2000..18_000).contains(&n_near), "{n_near}");
    }
}
