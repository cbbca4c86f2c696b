//! The exact arithmetic, and nothing else: which object a ray sees, decided in real numbers.
//!
//! A scene means what exact real arithmetic on its f64 numbers says (contract §1). Every f64 is
//! dyadic (`m·2^e`), dyadic numbers are closed under `+ − ×`, and every question about a hit is
//! the sign of a polynomial in them, or of a sum of a polynomial and square roots of such, which
//! clear by squaring ([`QuadraticSurd`]). So nothing here depends on a tolerance, a working precision or a
//! rounding mode: approximations appear only as first guesses that an exact comparison confirms.
//!
//! [`ExactRay`] is a ray, [`nearest`] the visible one of several [objects](crate::scene::Object), and
//! [`ExactHit`] what is seen there, with `t` and the normal correctly rounded.

mod ball;
mod double_double;
mod enclosure;
mod light;
mod number;
mod rational;
mod ray;
mod shape;
mod surd;

use std::cmp::Ordering;

pub use ball::Ball;
pub(crate) use double_double::DoubleDoubleRay;
pub use enclosure::Enclosure;
pub use light::{ExactBeam, ExactCosine, ExactPoint};
pub use number::{Dyadic, exact, integer, real, signum};
pub use rational::{Rational, dyadic_root};
pub use ray::{ExactPixels, ExactRay, ExactRays};
pub(crate) use shape::unit_f32;
pub use shape::{
    PlaneNumbers, Side, SphereNumbers, plane_numbers, signum_of_discriminant, sphere_numbers,
};
pub use surd::QuadraticSurd;
pub(crate) use surd::{lowest, nearest_f32};

use crate::scene::Object;

/// The hit of one object: the smallest root `t > 0`, however large, and the side that the ray meets there.
///
/// A sphere of radius 0 and a plane with a zero normal are hit by no ray; a negative radius stands for its magnitude. (Scene
/// files allow none of these.)
pub fn visible_hit<'a>(ray: &ExactRay, id: u32, object: Object<'a>) -> Option<ExactHit<'a>> {
    if signum(ray.norm_squared()) == 0 {
        return None;
    }
    let (root, side) = object.exact().visible_root(ray)?;
    Some(ExactHit { id, object, root, side })
}

/// The object that a ray sees: the smallest `t > 0`, and of equal ones the lowest id, in whatever
/// order the objects come.
///
/// A `t` that rounds beyond the largest f32 (`t ≥ 2^128 − 2^103`) is no hit: the results of every
/// kernel are f32. It needs to be looked at once only: all the others are at least as far.
pub fn nearest<'a>(
    ray: &ExactRay,
    objects: impl IntoIterator<Item = (u32, Object<'a>)>,
) -> Option<ExactHit<'a>> {
    nearest_in(ray, objects, 0)
}

/// [`nearest`] for results that are `t` times `2^exponent`.
pub(crate) fn nearest_in<'a>(
    ray: &ExactRay,
    objects: impl IntoIterator<Item = (u32, Object<'a>)>,
    exponent: i32,
) -> Option<ExactHit<'a>> {
    let overflow = number::f32_overflow() * number::power_of_two(-(exponent as isize));
    let hits = objects.into_iter().filter_map(|(id, object)| visible_hit(ray, id, object));
    let best = hits.min_by(|a, b| a.root.cmp(&b.root).then(a.id.cmp(&b.id)));
    best.filter(|hit| hit.root.cmp_real(&overflow) == Ordering::Less)
}

/// The exact hit of a ray.
#[derive(Clone, Debug)]
pub struct ExactHit<'a> {
    /// Object id.
    pub id: u32,
    /// The object that is hit.
    pub object: Object<'a>,
    /// The ray parameter `t`.
    pub root: QuadraticSurd,
    /// The side of the surface that the ray meets.
    pub side: Side,
}

impl ExactHit<'_> {
    /// `t`, correctly rounded (nearest, ties to even); a `t` that rounds to 0 gives the smallest
    /// subnormal, `2^-149`, so that `t > 0` stays true.
    pub fn t_f32(&self) -> f32 {
        self.t_f32_in(0)
    }

    /// [`ExactHit::t_f32`] of `t` times `2^exponent`.
    pub(crate) fn t_f32_in(&self, exponent: i32) -> f32 {
        let root = self.root.times_power_of_two(exponent as isize);
        root.to_f32().max(f32::from_bits(1))
    }

    /// `t`, correctly rounded; at least the smallest subnormal.
    pub fn t_f64(&self) -> f64 {
        self.root.to_f64().max(f64::from_bits(1))
    }

    /// The unit normal that faces the ray, each component exactly and so without any bound to
    /// prove. `None` where it can't be: a number that is not
    /// finite, a radius or normal of 0.
    pub fn normal(&self, ray: &ExactRay) -> Option<[QuadraticSurd; 3]> {
        let outward = self.object.exact().outward_normal(ray, &self.root)?;
        Some(match self.side {
            Side::Front => outward,
            Side::Back => outward.map(QuadraticSurd::negated),
        })
    }

    /// [`ExactHit::normal`] with each component correctly rounded; zero where there is none.
    pub fn normal_f32(&self, ray: &ExactRay) -> [f32; 3] {
        match self.normal(ray) {
            Some(normal) => normal.map(|component| component.to_f32()),
            None => [0.0; 3],
        }
    }
}
