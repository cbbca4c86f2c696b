//! Light on a point that a ray sees: which side it falls on, what is in its way, and how steep it
//! falls, in exact numbers.
//!
//! A hit point is `p = o + t·d` with `t = (B ± √D)/A`: every coordinate is `x + y·√D` with dyadic
//! `x` and `y`, over a common denominator, and so is every polynomial in them. Its sign comes from
//! those of `x`, `y` and `x² − y²D`.

use std::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;

use super::enclosure::Enclosure;
use super::number::{Real, product3, real, real3, signum};
use super::root::sign_of_sum;
use super::{ExactHit, ExactRay, Shape, Side};

/// `x + y·√D`, with a radicand `D` that all numbers of one point share.
#[derive(Clone, Debug)]
struct Surd<'a> {
    x: Real,
    y: Real,
    radicand: &'a Real,
}

impl<'a> Surd<'a> {
    fn new(x: Real, y: Real, radicand: &'a Real) -> Surd<'a> {
        Surd { x, y, radicand }
    }

    fn signum(&self) -> i32 {
        let square = &self.y * &self.y * self.radicand;
        let sign = if signum(&square) == 0 { 0 } else { signum(&self.y) };
        sign_of_sum(&self.x, sign, &square)
    }

    fn scaled(&self, by: &Real) -> Surd<'a> {
        Surd::new(&self.x * by, &self.y * by, self.radicand)
    }

    /// Bounds of a number that is at least 0.
    fn enclose(&self, n_bits: usize) -> Enclosure {
        let root = Enclosure::of(self.radicand).sqrt(n_bits);
        let (near, far) = (&self.y * &root.low, &self.y * &root.high);
        let (low, high) = if near < far { (near, far) } else { (far, near) };
        Enclosure::between(&self.x + low, &self.x + high).to_bits(n_bits)
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

type Surd3<'a> = [Surd<'a>; 3];

fn dot<'a>(u: &Surd3<'a>, v: &Surd3<'a>) -> Surd<'a> {
    let [x, y, z] = std::array::from_fn(|axis| &u[axis] * &v[axis]);
    &(&x + &y) + &z
}

fn dot_real<'a>(u: &Surd3<'a>, n: &[Real; 3]) -> Surd<'a> {
    let [x, y, z] = std::array::from_fn(|axis| u[axis].scaled(&n[axis]));
    &(&x + &y) + &z
}

/// The point of an object that a ray sees: `(base + root·√radicand)/scale`.
#[derive(Clone, Debug)]
pub struct ExactPoint {
    base: [Real; 3],
    root: [Real; 3],
    radicand: Real,
    /// Positive.
    scale: Real,
    side: Side,
}

impl ExactPoint {
    /// The point of a hit. With the ray's own root `τ = (B + s√D)/A`, in a world `S` times as large,
    /// `A·S·p = A·(S·o) + B·(F·d) + s·(F·d)·√D`.
    pub fn new(ray: &ExactRay, hit: &ExactHit) -> ExactPoint {
        let root = &hit.root;
        let (origin, direction) = (ray.origin(), ray.direction());
        let base = |axis: usize| {
            &origin[axis] * root.denominator() + &direction[axis] * root.rational_part()
        };
        let sign = Real::new(root.sign().into(), 0);
        ExactPoint {
            base: std::array::from_fn(base),
            root: std::array::from_fn(|axis| &direction[axis] * &sign),
            radicand: root.radicand().clone(),
            scale: ray.to_scale(root.denominator().clone()),
            side: hit.side,
        }
    }

    /// Whether the point is at most `distance` away from another one. `None` where a number is not
    /// finite.
    pub fn is_within(&self, distance: f64, point: DVec3) -> Option<bool> {
        let v = self.offset_from(&real3(point)?);
        Some((&dot(&v, &v) - &self.square_of(distance)?).signum() <= 0)
    }

    /// `(scale·r)²`
    fn square_of(&self, r: f64) -> Option<Surd<'_>> {
        let r = real(r)? * &self.scale;
        Some(Surd::new(&r * &r, Real::zero(), &self.radicand))
    }

    /// `scale·(p − point)`
    fn offset_from(&self, point: &[Real; 3]) -> Surd3<'_> {
        std::array::from_fn(|axis| {
            let base = &self.base[axis] - &(&point[axis] * &self.scale);
            Surd::new(base, self.root[axis].clone(), &self.radicand)
        })
    }
}

/// The way from a point to a light.
#[derive(Clone, Debug)]
pub struct ExactBeam<'a> {
    point: &'a ExactPoint,
    /// `scale·w`
    way: Surd3<'a>,
    /// `‖scale·w‖²`
    square: Surd<'a>,
    is_endless: bool,
}

impl<'a> ExactBeam<'a> {
    fn new(point: &'a ExactPoint, way: Surd3<'a>, is_endless: bool) -> ExactBeam<'a> {
        let square = dot(&way, &way);
        ExactBeam { point, way, square, is_endless }
    }

    /// To a point light. `None` where a number is not finite.
    pub fn to_position(point: &'a ExactPoint, position: DVec3) -> Option<ExactBeam<'a>> {
        let way = point.offset_from(&real3(position)?).map(|x| -x);
        Some(ExactBeam::new(point, way, false))
    }

    /// To a sun whose light travels along `direction`. `None` where a number is not finite.
    pub fn against(point: &'a ExactPoint, direction: DVec3) -> Option<ExactBeam<'a>> {
        let direction = real3(direction)?;
        let way = std::array::from_fn(|axis| {
            Surd::new(-(&direction[axis] * &point.scale), Real::zero(), &point.radicand)
        });
        Some(ExactBeam::new(point, way, true))
    }

    /// `n·ω` at the object with this shape, that the point is on. `None` where it is not positive, a
    /// light at the point itself included.
    pub fn cosine(&self, shape: &Shape) -> Option<ExactCosine<'a>> {
        let (outward, length2) = match *shape {
            Shape::Sphere { center, radius } => {
                let r = real(radius)? * &self.point.scale;
                (dot(&self.way, &self.point.offset_from(&real3(center)?)), &r * &r)
            }
            Shape::Plane { normal, .. } => {
                let n = real3(normal)?;
                (dot_real(&self.way, &n), product3(&n, &n))
            }
        };
        let numerator = match self.point.side {
            Side::Front => outward,
            Side::Back => -outward,
        };
        let denominator2 = self.square.scaled(&length2);
        (numerator.signum() > 0).then_some(ExactCosine { numerator, denominator2 })
    }

    /// Whether an object is in the way: it has a root `s` of `p + s·w` with `0 < s`, and before a
    /// point light `s < 1`.
    pub fn is_blocked_by(&self, shape: &Shape) -> bool {
        let blocked = match *shape {
            Shape::Sphere { center, radius } => self.is_blocked_by_sphere(center, radius),
            Shape::Plane { point, normal } => self.is_blocked_by_plane(point, normal),
        };
        blocked.unwrap_or(false)
    }

    /// Roots of `A·s² + 2B·s + C` with `A = w·w`, `B = w·(p − c)`, `C = ‖p − c‖² − r²`, by signs. At the
    /// light the polynomial is `Q = A + 2B + C`.
    /// - `C < 0`, inside: the one positive root comes before the light where `Q > 0`.
    /// - `C = 0`, on it: the other root is `−2B/A`, in the way where `B < 0` and `A + 2B > 0`.
    /// - `C > 0`, outside: real roots have the sign of `−B`. Where `Q < 0`, exactly one is before the
    ///   light. Where `Q ≥ 0` both are on the same side of it (one may be at it), and on that of their
    ///   mean `−B/A`: before it where `A + B > 0`.
    fn is_blocked_by_sphere(&self, center: DVec3, radius: f64) -> Option<bool> {
        if radius == 0.0 {
            return None;
        }
        let v = self.point.offset_from(&real3(center)?);
        let r2 = self.point.square_of(radius)?;
        let (a, b, c) = (&self.square, dot(&self.way, &v), &dot(&v, &v) - &r2);
        if a.signum() == 0 {
            return Some(false);
        }
        let b2 = &b + &b;
        Some(match c.signum() {
            -1 => self.is_endless || (&(a + &b2) + &c).signum() > 0,
            0 => b.signum() < 0 && (self.is_endless || (a + &b2).signum() > 0),
            _ => {
                b.signum() < 0
                    && (&(&b * &b) - &(a * &c)).signum() >= 0
                    && (self.is_endless || (a + &b).signum() > 0 || (&(a + &b2) + &c).signum() < 0)
            }
        })
    }

    /// `s = N/M` with `N = n·(a − p)` and `M = n·w`.
    fn is_blocked_by_plane(&self, point: DVec3, normal: DVec3) -> Option<bool> {
        let n = real3(normal)?;
        let m = dot_real(&self.way, &n);
        let offset = -dot_real(&self.point.offset_from(&real3(point)?), &n);
        let sign = m.signum();
        let is_ahead = sign != 0 && offset.signum() == sign;
        Some(is_ahead && (self.is_endless || (&m - &offset).signum() == sign))
    }
}

/// The cosine of the angle between a normal and a beam, greater than 0.
#[derive(Clone, Debug)]
pub struct ExactCosine<'a> {
    numerator: Surd<'a>,
    denominator2: Surd<'a>,
}

impl ExactCosine<'_> {
    /// Bounds, computed with `n_bits` bits.
    pub fn enclose(&self, n_bits: usize) -> Enclosure {
        let divisor = self.denominator2.enclose(n_bits).sqrt(n_bits);
        let quotient = self.numerator.enclose(n_bits).over(&divisor, n_bits);
        let one = Real::one();
        let (low, high) = quotient.map_or((Real::zero(), one.clone()), |e| (e.low, e.high));
        Enclosure::between(low, if high > one { one } else { high })
    }
}
