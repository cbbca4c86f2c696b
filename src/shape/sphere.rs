//! A sphere, exactly.

use glam::DVec3;

use super::Side;
use crate::exact::{Dyadic, ExactRay, Root, double, integer, product3, real, signum};
use crate::rays::WorldRay;
use crate::scene::Sphere;

/// The coefficients of a sphere in half-b form, for the ray's own (scaled) origin and direction:
/// `a·τ² − 2b'·τ + k = 0` with `b' = d·L`, `L = c − o`, `k = L·L − r²`.
struct HalfB {
    b: Dyadic,
    k: Dyadic,
}

impl HalfB {
    fn new(ray: &ExactRay, sphere: &Sphere) -> Option<HalfB> {
        let r = ray.to_scale(real(sphere.radius)?);
        let l = ray.to_point(sphere.center)?;
        Some(HalfB { b: product3(ray.direction(), &l), k: product3(&l, &l) - &r * &r })
    }

    /// A quarter of the discriminant: `D' = b'² − a·k`.
    fn quarter_discriminant(&self, a: &Dyadic) -> Dyadic {
        &self.b * &self.b - a * &self.k
    }
}

/// The smallest root `t > 0`. With `a > 0` and the roots `(b' ± √D')/a`, whose product is `k/a`:
/// - `k < 0` (origin inside): `D' ≥ −a·k > 0` and the roots have opposite signs: the far one.
/// - `k = 0` (origin on the surface): the roots are 0 and `2b'/a`: the latter if `b' > 0`. Here
///   `D' = b'²`, so it is the far root as well.
/// - `k > 0` (outside): where the roots are real they have the sign of `b'`, and with `b' = 0`,
///   `D' = −a·k < 0`. So `b' > 0` and `D' ≥ 0`, and then the near one.
///
/// Side: with the outward normal `(τ·d − L)/r`, `d·(τ·d − L) = a·τ − b' = ±√D'`: the near root
/// meets the front, the far root the back, a tangent ray the front.
pub(super) fn visible_root(ray: &ExactRay, sphere: &Sphere) -> Option<(Root, Side)> {
    let a = ray.norm_squared();
    if sphere.radius == 0.0 {
        return None;
    }
    let half_b = HalfB::new(ray, sphere)?;
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

/// With `τ = (B + s√D)/A` the root in the ray's own scale, and so all other numbers:
/// `nᵢ = (τ·dᵢ − Lᵢ)/|r| = (dᵢB − LᵢA + s·sgn(dᵢ)·√(dᵢ²D)) / (A·|r|)`.
pub(super) fn outward_normal(ray: &ExactRay, root: &Root, sphere: &Sphere) -> Option<[Root; 3]> {
    let r = real(sphere.radius.abs()).filter(|r| signum(r) > 0)?;
    let l = ray.to_point(sphere.center)?;
    let denominator = root.denominator() * ray.to_scale(r);
    Some(std::array::from_fn(|i| {
        let d = &ray.direction()[i];
        Root::new(
            d * root.rational_part() - &l[i] * root.denominator(),
            root.sign() * signum(d),
            d * d * root.radicand(),
            denominator.clone(),
            1,
        )
    }))
}

/// Numbers of the lecture's quadratic equation, exactly, for the contract's `d` (`a·t² + b·t + k = 0`).
#[derive(Clone, Debug)]
pub struct SphereNumbers {
    /// `b = 2·d·(o − c)`.
    pub b: Root,
    /// `k = (o − c)·(o − c) − r²`.
    pub k: Root,
    /// `D = b² − 4ak`.
    pub discriminant: Root,
}

/// The numbers of the quadratic equation of a ray and a sphere; `None` where a number is not
/// finite.
///
/// A pixel's ray carries `F·d` in place of `d`, in a world `S` times as large, so `b`, `k` and
/// `D` are the scaled ones divided by `FS`, `S²` and `F²S²`.
pub fn sphere_numbers(ray: &ExactRay, sphere: &Sphere) -> Option<SphereNumbers> {
    let half_b = HalfB::new(ray, sphere)?;
    let d = half_b.quarter_discriminant(ray.norm_squared());
    let s = integer(i64::from(ray.world_scale()));
    let fs = integer(i64::from(ray.direction_scale())) * &s;
    Some(SphereNumbers {
        discriminant: Root::quotient(double(&double(&d)), &fs * &fs, 1),
        b: Root::quotient(-double(&half_b.b), fs, 1),
        k: Root::quotient(half_b.k, &s * &s, 1),
    })
}

/// The sign of the discriminant of a ray's line and a sphere; `None` where a number is not finite.
pub fn signum_of_discriminant(ray: &ExactRay, sphere: &Sphere) -> Option<i32> {
    let half_b = HalfB::new(ray, sphere)?;
    Some(signum(&half_b.quarter_discriminant(ray.norm_squared())))
}

/// True where a point lies outside of a sphere (not on it); `None` where a number is not finite.
pub fn is_outside(point: DVec3, sphere: &Sphere) -> Option<bool> {
    let ray = ExactRay::new(&WorldRay { origin: point, direction: DVec3::X });
    Some(signum(&HalfB::new(&ray, sphere)?.k) > 0)
}
