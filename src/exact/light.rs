//! Light on a point that a ray sees: which side it falls on, what is in its way, and how steep it
//! falls, in exact numbers.
//!
//! A hit point is `p = o + t·d` with `t = (B ± √D)/A`: every coordinate is `x + y·√D` with dyadic
//! `x` and `y`, over a common denominator, and so is every polynomial in them. Its sign comes from
//! those of `x`, `y` and `x² − y²D`.

use std::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;

use super::enclosure::Enclosure;
use super::number::{Dyadic, integer, magnitude, power_of_two, real, real3, signum};
use super::rational::{Rational, dyadic_root};
use super::surd::sign_of_sum;
use super::{ExactHit, ExactRay, Side};
use crate::scene::Object;

/// `x + y·√D`, with a radicand `D` that all numbers of one point share.
#[derive(Clone, Debug)]
pub(super) struct Surd<'a> {
    x: Dyadic,
    y: Dyadic,
    radicand: &'a Dyadic,
}

impl<'a> Surd<'a> {
    fn new(x: Dyadic, y: Dyadic, radicand: &'a Dyadic) -> Surd<'a> {
        Surd { x, y, radicand }
    }

    pub(super) fn signum(&self) -> i32 {
        let square = &self.y * &self.y * self.radicand;
        let sign = if signum(&square) == 0 { 0 } else { signum(&self.y) };
        sign_of_sum(&self.x, sign, &square)
    }

    fn scaled(&self, by: &Dyadic) -> Surd<'a> {
        Surd::new(&self.x * by, &self.y * by, self.radicand)
    }

    /// The number, where it has no root.
    fn rational(&self) -> Option<&Dyadic> {
        (signum(&self.y) == 0 || signum(self.radicand) == 0).then_some(&self.x)
    }

    /// Bounds of a number that is at least 0, some units of the last of `n_bits/2` bits apart or nearer. Parts of different signs
    /// may cancel any number of bits, those of `x + y·√D = (x² − y²D)/(x − y·√D)` none.
    pub(super) fn enclose(&self, n_bits: usize) -> Enclosure {
        let root = Enclosure::of(self.radicand).sqrt(n_bits);
        let (near, far) = (&self.y * &root.low, &self.y * &root.high);
        let (low, high) = if near < far { (near, far) } else { (far, near) };
        let sum = Enclosure::between(&self.x + low, &self.x + high);
        let half = power_of_two(-(n_bits as isize / 2));
        let cancels = signum(&self.x) * signum(&self.y) < 0;
        if !cancels || &sum.high - &sum.low <= &sum.low * &half {
            return sum.to_bits(n_bits);
        }
        let (x, y) = (magnitude(&self.x), magnitude(&self.y));
        let apart = magnitude(&(&x * &x - &y * &y * self.radicand));
        let sum = Enclosure::of(&x).plus(&root.times(&Enclosure::of(&y), n_bits));
        Enclosure::of(&apart).over(&sum, n_bits).unwrap_or_else(|| Enclosure::of(&Dyadic::zero()))
    }
}

impl<'a> Add for &Surd<'a> {
    type Output = Surd<'a>;
    fn add(self, other: &Surd<'a>) -> Surd<'a> {
        Surd::new(&self.x + &other.x, &self.y + &other.y, self.radicand)
    }
}

impl<'a> Sub for &Surd<'a> {
    type Output = Surd<'a>;
    fn sub(self, other: &Surd<'a>) -> Surd<'a> {
        Surd::new(&self.x - &other.x, &self.y - &other.y, self.radicand)
    }
}

impl<'a> Mul for &Surd<'a> {
    type Output = Surd<'a>;
    fn mul(self, other: &Surd<'a>) -> Surd<'a> {
        Surd::new(
            &self.x * &other.x + &self.y * &other.y * self.radicand,
            &self.x * &other.y + &self.y * &other.x,
            self.radicand,
        )
    }
}

impl<'a> Neg for Surd<'a> {
    type Output = Surd<'a>;
    fn neg(self) -> Surd<'a> {
        Surd::new(-self.x, -self.y, self.radicand)
    }
}

pub(super) type Surd3<'a> = [Surd<'a>; 3];

pub(super) fn dot<'a>(u: &Surd3<'a>, v: &Surd3<'a>) -> Surd<'a> {
    let [x, y, z] = std::array::from_fn(|axis| &u[axis] * &v[axis]);
    &(&x + &y) + &z
}

pub(super) fn dot_real<'a>(u: &Surd3<'a>, n: &[Dyadic; 3]) -> Surd<'a> {
    let [x, y, z] = std::array::from_fn(|axis| u[axis].scaled(&n[axis]));
    &(&x + &y) + &z
}

/// The point of an object that a ray sees: `(base + root·√radicand)/scale`.
#[derive(Clone, Debug)]
pub struct ExactPoint<'a> {
    object: Object<'a>,
    side: Side,
    base: [Dyadic; 3],
    root: [Dyadic; 3],
    radicand: Dyadic,
    /// Positive.
    pub(super) scale: Dyadic,
}

impl<'a> ExactPoint<'a> {
    /// The point of a hit. With the ray's own root `τ = (B + s√D)/A`, in a world `S` times as large,
    /// `A·S·p = A·(S·o) + B·(F·d) + s·(F·d)·√D`.
    pub fn new(ray: &ExactRay, hit: &ExactHit<'a>) -> ExactPoint<'a> {
        let root = &hit.root;
        let (origin, direction) = (ray.origin(), ray.direction());
        let base = |axis: usize| {
            &origin[axis] * root.denominator() + &direction[axis] * root.rational_part()
        };
        let base: [Dyadic; 3] = std::array::from_fn(base);
        let sign = integer(root.root_sign().into());
        let part = |axis: usize| &direction[axis] * &sign;
        // A point with rational coordinates has no root.
        let (base, root_part, radicand) = match dyadic_root(root.radicand()) {
            Some(known) => (
                std::array::from_fn(|axis| &base[axis] + part(axis) * &known),
                std::array::from_fn(|_| Dyadic::zero()),
                Dyadic::zero(),
            ),
            None => (base, std::array::from_fn(part), root.radicand().clone()),
        };
        ExactPoint {
            object: hit.object,
            side: hit.side,
            base,
            root: root_part,
            radicand,
            scale: ray.to_scale(root.denominator().clone()),
        }
    }

    /// `scale²·(v·v − r²)`, where `v` is `scale` times as long already.
    pub(super) fn off_sphere<'s>(&'s self, v: &Surd3<'s>, radius: f64) -> Option<Surd<'s>> {
        let r = real(radius)? * &self.scale;
        Some(&dot(v, v) - &Surd::new(&r * &r, Dyadic::zero(), &self.radicand))
    }

    /// Whether the point is at most `distance` away from another one. `None` where a number is not
    /// finite.
    #[cfg(test)]
    pub fn is_within(&self, distance: f64, point: DVec3) -> Option<bool> {
        Some(self.off_sphere(&self.offset_from(&real3(point)?), distance)?.signum() <= 0)
    }

    /// `scale·(p − point)`
    pub(super) fn offset_from(&self, point: &[Dyadic; 3]) -> Surd3<'_> {
        std::array::from_fn(|axis| {
            let base = &self.base[axis] - &(&point[axis] * &self.scale);
            Surd::new(base, self.root[axis].clone(), &self.radicand)
        })
    }
}

/// The way from a point to a light.
#[derive(Clone, Debug)]
pub struct ExactBeam<'a> {
    pub(super) point: &'a ExactPoint<'a>,
    /// `scale·w`
    pub(super) way: Surd3<'a>,
    /// `‖scale·w‖²`
    pub(super) square: Surd<'a>,
    /// Whether it is to a sun.
    pub(super) is_endless: bool,
}

impl<'a> ExactBeam<'a> {
    fn new(point: &'a ExactPoint<'a>, way: Surd3<'a>, is_endless: bool) -> ExactBeam<'a> {
        let square = dot(&way, &way);
        ExactBeam { point, way, square, is_endless }
    }

    /// To a point light. `None` where a number is not finite.
    pub fn to_position(point: &'a ExactPoint<'a>, position: DVec3) -> Option<ExactBeam<'a>> {
        let way = point.offset_from(&real3(position)?).map(|x| -x);
        Some(ExactBeam::new(point, way, false))
    }

    /// To a sun whose light travels along `direction`. `None` where a number is not finite.
    pub fn against(point: &'a ExactPoint<'a>, direction: DVec3) -> Option<ExactBeam<'a>> {
        let direction = real3(direction)?;
        let way = std::array::from_fn(|axis| {
            Surd::new(-(&direction[axis] * &point.scale), Dyadic::zero(), &point.radicand)
        });
        Some(ExactBeam::new(point, way, true))
    }

    /// `n·ω` at the object that the point is on. `None` where it is not positive, a light at the point itself included.
    pub fn cosine(&self) -> Option<ExactCosine<'a>> {
        self.slope().filter(|(sign, _)| *sign > 0).map(|(_, cosine)| cosine)
    }

    /// The sign and the magnitude of `n·ω`; `None` where it is 0, a light at the point itself included.
    pub fn slope(&self) -> Option<(i32, ExactCosine<'a>)> {
        let (outward, length2) = self.point.object.exact().slope(self)?;
        let facing = match self.point.side {
            Side::Front => outward,
            Side::Back => -outward,
        };
        let denominator2 = self.square.scaled(&length2);
        let sign = facing.signum();
        let numerator = if sign < 0 { -facing } else { facing };
        (sign != 0).then_some((sign, ExactCosine { numerator, denominator2 }))
    }

    /// Whether an object is in the way: it has a root `s` of `p + s·w` with `0 < s`, and before a
    /// point light `s < 1`.
    pub fn is_blocked_by(&self, object: Object) -> bool {
        object.exact().blocks(self).unwrap_or(false)
    }

    /// Bounds, computed with `n_bits` bits, of the smallest root `s` of an object that is in the way;
    /// `None` for another, and where the bits don't suffice.
    pub fn first_root(&self, object: Object, n_bits: usize) -> Option<Enclosure> {
        if !self.is_blocked_by(object) {
            return None;
        }
        let [numerator, denominator] = object.exact().first_root(self, n_bits)?;
        numerator.over(&denominator, n_bits)
    }
}

/// The cosine of the angle between a normal and a beam, greater than 0.
#[derive(Clone, Debug)]
pub struct ExactCosine<'a> {
    numerator: Surd<'a>,
    denominator2: Surd<'a>,
}

impl ExactCosine<'_> {
    /// The number where it is that of a point without a root and of a way of rational length. There are other rational ones,
    /// for which `None` is right as well.
    pub fn fraction(&self) -> Option<Rational> {
        let numerator = self.numerator.rational()?;
        Some(Rational::new(numerator, &dyadic_root(self.denominator2.rational()?)?))
    }

    /// Bounds, computed with `n_bits` bits.
    pub fn enclose(&self, n_bits: usize) -> Enclosure {
        let divisor = self.denominator2.enclose(n_bits).sqrt(n_bits);
        let quotient = self.numerator.enclose(n_bits).over(&divisor, n_bits);
        let one = Dyadic::one();
        debug_assert!(quotient.is_some(), "a way without a length");
        let (low, high) = quotient.map_or((Dyadic::zero(), one.clone()), |e| (e.low, e.high));
        Enclosure::between(low, if high > one { one } else { high })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `(2ᵏ + n) − √(4ᵏ + 1)`, which is `n` less `1/2ᵏ⁺¹`, is narrowly enclosed however many bits cancel.
    #[test]
    fn what_cancels_is_enclosed_narrowly() {
        for (k, n) in [(10, 1), (100, 3), (5000, 1), (5000, 0)] {
            let radicand = &power_of_two(2 * k) + &Dyadic::one();
            let large = &power_of_two(k) + &Dyadic::new(n.into(), 0);
            let surd = match n {
                0 => Surd::new(-large, Dyadic::one(), &radicand),
                _ => Surd::new(large, -Dyadic::one(), &radicand),
            };
            let Enclosure { low, high } = surd.enclose(64);
            let half_step = power_of_two(-k - 1);
            let [least, most] = match n {
                0 => [&half_step - &power_of_two(-3 * k - 3), half_step],
                _ => [&Dyadic::new(n.into(), 0) - &half_step, Dyadic::new(n.into(), 0)],
            };
            assert!(low <= most && least <= high, "{k} {n}");
            assert!(&high - &low <= &low * &power_of_two(-32), "{k} {n}");
        }
    }
}
