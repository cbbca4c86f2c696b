//! The exact arithmetic, and nothing else: which object a ray sees, decided in real numbers.
//!
//! A scene means what exact real arithmetic on its f64 numbers says (contract §1). Every f64 is
//! dyadic (`m·2^e`), dyadic numbers are closed under `+ − ×`, and every question about a hit is
//! the sign of a polynomial in them, or of a sum of a polynomial and square roots of such, which
//! clear by squaring ([`Root`]). So nothing here depends on a tolerance, a working precision or a
//! rounding mode: approximations appear only as first guesses that an exact comparison confirms.
//!
//! [`ExactRay`] is a ray, [`Shape`] the geometry of an object, [`nearest`] the visible object, and
//! [`ExactHit`] what is seen there, with `t` and the normal correctly rounded.

mod number;
mod ray;
mod root;

use std::cmp::Ordering;

use glam::DVec3;

pub use number::{Real, real, signum};
pub use ray::{ExactPixels, ExactRay};
pub use root::Root;
pub(crate) use root::layout;

use crate::rays::Ray;
use crate::scene::{Object, Plane, Sphere};
use number::{double, integer, product3, real3};

/// The geometry of an object, without name and colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// `‖p − center‖ = |radius|`. A radius of 0 is hit by no ray; a negative one stands for its
    /// magnitude. (Scene files allow neither.)
    Sphere {
        /// Centre, world units.
        center: DVec3,
        /// Radius, world units.
        radius: f64,
    },
    /// `(p − point)·normal = 0`. A zero normal is hit by no ray. (Scene files allow none.)
    Plane {
        /// Any point of the plane, world units.
        point: DVec3,
        /// Normal of any length.
        normal: DVec3,
    },
}

impl From<&Sphere> for Shape {
    fn from(sphere: &Sphere) -> Shape {
        Shape::Sphere { center: sphere.center, radius: sphere.radius }
    }
}

impl From<&Plane> for Shape {
    fn from(plane: &Plane) -> Shape {
        Shape::Plane { point: plane.point, normal: plane.normal }
    }
}

impl From<Object<'_>> for Shape {
    fn from(object: Object<'_>) -> Shape {
        match object {
            Object::Sphere(sphere) => sphere.into(),
            Object::Plane(plane) => plane.into(),
        }
    }
}

/// Which side of a surface a ray meets (contract §1, "normal").
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The outside of a sphere, the side of a plane that its normal points to. A ray tangent to a
    /// sphere meets the front.
    Front,
    /// The other one: the reported normal is the flipped one.
    Back,
}

/// The coefficients of a sphere in half-b form, for the ray's own (scaled) origin and direction:
/// `a·τ² − 2b'·τ + k = 0` with `b' = d·L`, `L = c − o`, `k = L·L − r²`.
struct HalfB {
    b: Real,
    k: Real,
}

impl HalfB {
    fn new(ray: &ExactRay, center: DVec3, radius: f64) -> Option<HalfB> {
        let r = ray.to_scale(real(radius)?);
        let l = ray.to_point(center)?;
        Some(HalfB { b: product3(ray.direction(), &l), k: product3(&l, &l) - &r * &r })
    }

    /// A quarter of the discriminant: `D' = b'² − a·k`.
    fn quarter_discriminant(&self, a: &Real) -> Real {
        &self.b * &self.b - a * &self.k
    }
}

/// Numerator `N = (p − o)·n` and denominator `M = d·n` of a plane, for the ray's own (scaled)
/// origin and direction.
fn plane_quotient(ray: &ExactRay, point: DVec3, normal: DVec3) -> Option<(Real, Real)> {
    let n = real3(normal)?;
    Some((product3(&ray.to_point(point)?, &n), product3(ray.direction(), &n)))
}

/// The smallest root `t > 0` of one object, however large, and the side that the ray meets there.
///
/// Sphere, with `a > 0` and the roots `(b' ± √D')/a`, whose product is `k/a`:
/// - `k < 0` (origin inside): `D' ≥ −a·k > 0` and the roots have opposite signs: the far one.
/// - `k = 0` (origin on the surface): the roots are 0 and `2b'/a`: the latter if `b' > 0`. Here
///   `D' = b'²`, so it is the far root as well.
/// - `k > 0` (outside): where the roots are real they have the sign of `b'`, and with `b' = 0`,
///   `D' = −a·k < 0`. So `b' > 0` and `D' ≥ 0`, and then the near one.
///
/// Side: with the outward normal `(τ·d − L)/r`, `d·(τ·d − L) = a·τ − b' = ±√D'`: the near root
/// meets the front, the far root the back, a tangent ray the front.
///
/// Plane: `N/M`, written with a positive denominator. `M > 0` means that the ray runs along the
/// normal: it meets the back.
pub fn visible_root(ray: &ExactRay, shape: &Shape) -> Option<(Root, Side)> {
    let a = ray.norm_squared();
    if signum(a) == 0 {
        return None;
    }
    match *shape {
        Shape::Sphere { center, radius } => {
            if radius == 0.0 {
                return None;
            }
            let half_b = HalfB::new(ray, center, radius)?;
            let sign_k = signum(&half_b.k);
            if sign_k >= 0 && signum(&half_b.b) <= 0 {
                return None;
            }
            let d = half_b.quarter_discriminant(a);
            let sign_d = signum(&d);
            if sign_d < 0 {
                return None;
            }
            let (sign, side) = if sign_k > 0 { (-1, Side::Front) } else { (1, Side::Back) };
            let root = Root::new(half_b.b, sign, d, a.clone(), ray.t_factor());
            Some((root, side))
        }
        Shape::Plane { point, normal } => {
            let (n, m) = plane_quotient(ray, point, normal)?;
            match (signum(&n), signum(&m)) {
                (1, 1) => Some((Root::quotient(n, m, ray.t_factor()), Side::Back)),
                (-1, -1) => Some((Root::quotient(-n, -m, ray.t_factor()), Side::Front)),
                _ => None,
            }
        }
    }
}

/// The object that a ray sees: the smallest `t > 0`, and of equal ones the lowest id, in whatever
/// order the objects come.
///
/// A `t` that rounds beyond the largest f32 (`t ≥ 2^128 − 2^103`) is no hit: the results of every
/// kernel are f32. It needs to be looked at once only: all the others are at least as far.
pub fn nearest<S: Into<Shape>>(
    ray: &ExactRay,
    objects: impl IntoIterator<Item = (u32, S)>,
) -> Option<ExactHit> {
    let mut best: Option<ExactHit> = None;
    for (id, shape) in objects {
        let Some((root, side)) = visible_root(ray, &shape.into()) else {
            continue;
        };
        let wins = best
            .as_ref()
            .is_none_or(|best| root.cmp(&best.root).then_with(|| id.cmp(&best.id)).is_lt());
        if wins {
            best = Some(ExactHit { id, root, side });
        }
    }
    best.filter(|hit| hit.root.cmp_real(&number::f32_overflow()) == Ordering::Less)
}

/// What a ray sees, exactly.
#[derive(Clone, Debug)]
pub struct ExactHit {
    /// Object id.
    pub id: u32,
    /// The ray parameter `t`.
    pub root: Root,
    /// The side of the surface that the ray meets.
    pub side: Side,
}

impl ExactHit {
    /// `t`, correctly rounded (nearest, ties to even); a `t` that rounds to 0 gives the smallest
    /// subnormal, `2^-149`, so that `t > 0` stays true.
    pub fn t_f32(&self) -> f32 {
        self.root.to_f32().max(f32::from_bits(1))
    }

    /// `t`, correctly rounded; at least the smallest subnormal.
    pub fn t_f64(&self) -> f64 {
        self.root.to_f64().max(f64::from_bits(1))
    }

    /// `t` in decimal, see [`Root::to_decimal`].
    pub fn t_decimal(&self, digits: usize) -> String {
        self.root.to_decimal(digits)
    }

    /// The unit normal that faces the ray, each component exactly and so without any bound to
    /// prove. `shape` is the object that was hit. `None` where it can't be: a number that is not
    /// finite, a radius or normal of 0.
    ///
    /// The components are numbers of the same kind as the root itself:
    /// - Sphere, `τ = (B + s√D)/A` the root in the ray's own scale, and so all other numbers:
    ///   `nᵢ = (τ·dᵢ − Lᵢ)/|r| = (dᵢB − LᵢA + s·sgn(dᵢ)·√(dᵢ²D)) / (A·|r|)`.
    /// - Plane: `nᵢ/‖n‖ = sgn(nᵢ)·√(nᵢ²·‖n‖²) / ‖n‖²`.
    pub fn normal(&self, ray: &ExactRay, shape: &Shape) -> Option<[Root; 3]> {
        let outward: [Root; 3] = match *shape {
            Shape::Sphere { center, radius } => {
                let r = real(radius.abs()).filter(|r| signum(r) > 0)?;
                let l = ray.to_point(center)?;
                let denominator = self.root.denominator() * ray.to_scale(r);
                std::array::from_fn(|i| {
                    let d = &ray.direction()[i];
                    Root::new(
                        d * self.root.rational_part() - &l[i] * self.root.denominator(),
                        self.root.sign() * signum(d),
                        d * d * self.root.radicand(),
                        denominator.clone(),
                        1,
                    )
                })
            }
            Shape::Plane { normal, .. } => {
                let n = real3(normal)?;
                let norm_squared = product3(&n, &n);
                if signum(&norm_squared) == 0 {
                    return None;
                }
                std::array::from_fn(|i| {
                    Root::new(
                        Real::zero(),
                        signum(&n[i]),
                        &n[i] * &n[i] * &norm_squared,
                        norm_squared.clone(),
                        1,
                    )
                })
            }
        };
        Some(match self.side {
            Side::Front => outward,
            Side::Back => outward.map(Root::negated),
        })
    }

    /// [`ExactHit::normal`] with each component correctly rounded; zero where there is none.
    pub fn normal_f32(&self, ray: &ExactRay, shape: &Shape) -> [f32; 3] {
        match self.normal(ray, shape) {
            Some(normal) => normal.map(|component| component.to_f32()),
            None => [0.0; 3],
        }
    }
}

/// The numbers of the lecture's quadratic equation, exactly, for the contract's `d`
/// (`a·t² + b·t + k = 0`).
#[derive(Clone, Debug)]
pub struct SphereNumbers {
    /// `a = d·d`.
    pub a: Root,
    /// `b = 2·d·(o − c)`.
    pub b: Root,
    /// `k = (o − c)·(o − c) − r²`.
    pub k: Root,
    /// `D = b² − 4ak`.
    pub discriminant: Root,
    /// `D/4a`, which is `r²` less the squared distance of the line from the centre. `None` where
    /// `d = 0`.
    pub delta: Option<Root>,
    /// `√D/2`. `None` where `D < 0`.
    pub half_root: Option<Root>,
    /// Near and far root, of any sign and size; equal where `D = 0`. `None` where `D < 0` or
    /// `d = 0`.
    pub roots: Option<[Root; 2]>,
}

/// The numbers of the quadratic equation of a ray and a sphere; `None` where a number is not
/// finite.
///
/// A pixel's ray carries `F·d` in place of `d`, in a world `S` times as large, so `a`, `b`, `k` and
/// `D` are the scaled ones divided by `F²`, `FS`, `S²` and `F²S²`.
pub fn sphere_numbers(ray: &ExactRay, center: DVec3, radius: f64) -> Option<SphereNumbers> {
    let half_b = HalfB::new(ray, center, radius)?;
    let a = ray.norm_squared();
    let d = half_b.quarter_discriminant(a);
    let s = integer(i64::from(ray.world_scale()));
    let f = integer(i64::from(ray.direction_scale()));
    let (fs, s2) = (&f * &s, &s * &s);
    let roots = (signum(a) > 0 && signum(&d) >= 0).then(|| {
        [-1, 1].map(|sign| Root::new(half_b.b.clone(), sign, d.clone(), a.clone(), ray.t_factor()))
    });
    Some(SphereNumbers {
        a: Root::quotient(a.clone(), &f * &f, 1),
        delta: (signum(a) > 0).then(|| Root::quotient(d.clone(), a * &s2, 1)),
        half_root: (signum(&d) >= 0).then(|| Root::new(Real::zero(), 1, d.clone(), fs.clone(), 1)),
        discriminant: Root::quotient(double(&double(&d)), &fs * &fs, 1),
        b: Root::quotient(-double(&half_b.b), fs, 1),
        k: Root::quotient(half_b.k, s2, 1),
        roots,
    })
}

/// The sign of the discriminant of a ray's line and a sphere; `None` where a number is not finite.
pub fn signum_of_discriminant(ray: &ExactRay, center: DVec3, radius: f64) -> Option<i32> {
    let half_b = HalfB::new(ray, center, radius)?;
    Some(signum(&half_b.quarter_discriminant(ray.norm_squared())))
}

/// Whether a point lies outside of a sphere (not on it); `None` where a number is not finite.
pub fn is_outside(point: DVec3, center: DVec3, radius: f64) -> Option<bool> {
    let ray = ExactRay::new(&Ray { origin: point, direction: DVec3::X });
    Some(signum(&HalfB::new(&ray, center, radius)?.k) > 0)
}

/// The numbers of the plane's quotient, exactly, for the contract's `d`.
#[derive(Clone, Debug)]
pub struct PlaneNumbers {
    /// `(a − o)·n`.
    pub numerator: Root,
    /// `d·n`.
    pub denominator: Root,
    /// Their quotient, of any sign and size; `None` where `d·n = 0`.
    pub root: Option<Root>,
}

/// The numbers of a ray and a plane; `None` where a number is not finite.
pub fn plane_numbers(ray: &ExactRay, point: DVec3, normal: DVec3) -> Option<PlaneNumbers> {
    let (n, m) = plane_quotient(ray, point, normal)?;
    let root = match signum(&m) {
        0 => None,
        1 => Some(Root::quotient(n.clone(), m.clone(), ray.t_factor())),
        _ => Some(Root::quotient(-n.clone(), -m.clone(), ray.t_factor())),
    };
    Some(PlaneNumbers {
        numerator: Root::ratio(n, ray.world_scale()),
        denominator: Root::ratio(m, ray.direction_scale()),
        root,
    })
}
