//! A sphere, exactly.

use glam::DVec3;

use super::{ExactPlace, ExactShape, Side};
use crate::exact::double_double::ball_dot;
use crate::exact::light::{ExactBeam, Surd, dot};
use crate::exact::number::{double, product3, real3};
use crate::exact::{
    Ball, DoubleDoubleRay, Dyadic, Enclosure, ExactRay, QuadraticSurd, integer, real, signum,
};
use crate::rays::WorldRay;
use crate::scene::{Source, Sphere};

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

/// `B = w·(p − c)` and `C = ‖p − c‖² − r²` of a beam.
fn beam_quadratic<'a>(beam: &ExactBeam<'a>, sphere: &Sphere) -> Option<[Surd<'a>; 2]> {
    let v = beam.point.offset_from(&real3(sphere.center)?);
    Some([dot(&beam.way, &v), beam.point.off_sphere(&v, sphere.radius)?])
}

impl ExactShape for Sphere {
    /// With `a > 0` and the roots `(b' ± √D')/a`, whose product is `k/a`:
    /// - `k < 0` (origin inside): `D' ≥ −a·k > 0` and the roots have opposite signs: the far one.
    /// - `k = 0` (origin on the surface): the roots are 0 and `2b'/a`: the latter if `b' > 0`. Here
    ///   `D' = b'²`, so it is the far root as well.
    /// - `k > 0` (outside): where the roots are real they have the sign of `b'`, and with `b' = 0`,
    ///   `D' = −a·k < 0`. So `b' > 0` and `D' ≥ 0`, and then the near one.
    ///
    /// Side: with the outward normal `(τ·d − L)/r`, `d·(τ·d − L) = a·τ − b' = ±√D'`: the near root
    /// meets the front, the far root the back, a tangent ray the front.
    fn visible_root(&self, ray: &ExactRay) -> Option<(QuadraticSurd, Side)> {
        let a = ray.norm_squared();
        if self.radius == 0.0 {
            return None;
        }
        let half_b = HalfB::new(ray, self)?;
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
        let root = QuadraticSurd::new(half_b.b, sign, d, a.clone(), ray.t_factor());
        Some((root, side))
    }

    /// With `τ = (B + s√D)/A` the root in the ray's own scale, and so all other numbers:
    /// `nᵢ = (τ·dᵢ − Lᵢ)/|r| = (dᵢB − LᵢA + s·sgn(dᵢ)·√(dᵢ²D)) / (A·|r|)`.
    fn outward_normal(&self, ray: &ExactRay, root: &QuadraticSurd) -> Option<[QuadraticSurd; 3]> {
        let r = real(self.radius.abs()).filter(|r| signum(r) > 0)?;
        let l = ray.to_point(self.center)?;
        let denominator = root.denominator() * ray.to_scale(r);
        Some(std::array::from_fn(|i| {
            let d = &ray.direction()[i];
            QuadraticSurd::new(
                d * root.rational_part() - &l[i] * root.denominator(),
                root.root_sign() * signum(d),
                d * d * root.radicand(),
                denominator.clone(),
                1,
            )
        }))
    }

    /// With `a = d·d`, `b = d·l`, `k = l·l − r²` and `w = √(b² − ak)` the visible root is `k/(b + w)` from outside, and
    /// `(b + w)/a` or `−k/(w − b)` from inside, whichever does not cancel.
    fn surface_in_balls(&self, sight: &DoubleDoubleRay) -> Option<(Ball, [f32; 3])> {
        let (d, l) = (&sight.direction, &sight.to_point(self.center));
        let r = sight.to_scale(self.radius.abs());
        let (a, b, k) = (ball_dot(d, d), ball_dot(d, l), ball_dot(l, l) - r * r);
        let w = (b * b - a * k).sqrt();
        let is_inside = (-k).is_positive();
        let root = match is_inside {
            false if !(k.is_positive() && b.is_positive()) => return None,
            false => k.over(b + w),
            true if b.is_positive() => (b + w).over(a),
            true => (-k).over(w - b),
        };
        let mut normal = [0.0; 3];
        for axis in 0..3 {
            let outward = (d[axis] * root - l[axis]).over(r);
            normal[axis] = if is_inside { -outward } else { outward }.nearest_f32()?;
        }
        Some((root, normal))
    }

    fn slope<'a>(&self, beam: &ExactBeam<'a>) -> Option<(Surd<'a>, Dyadic)> {
        let r = real(self.radius)? * &beam.point.scale;
        Some((dot(&beam.way, &beam.point.offset_from(&real3(self.center)?)), &r * &r))
    }

    /// Roots of `A·s² + 2B·s + C` with `A = w·w`, by signs. At the light the polynomial is `Q = A + 2B + C`.
    /// - `C < 0`, inside: the one positive root comes before the light where `Q > 0`.
    /// - `C = 0`, on it: the other root is `−2B/A`, in the way where `B < 0` and `A + 2B > 0`.
    /// - `C > 0`, outside: real roots have the sign of `−B`. Where `Q < 0`, exactly one is before the
    ///   light. Where `Q ≥ 0` both are on the same side of it (one may be at it), and on that of their
    ///   mean `−B/A`: before it where `A + B > 0`.
    fn blocks(&self, beam: &ExactBeam) -> Option<bool> {
        if self.radius == 0.0 {
            return None;
        }
        let (a, [b, c]) = (&beam.square, beam_quadratic(beam, self)?);
        if a.signum() == 0 {
            return Some(false);
        }
        let b2 = &b + &b;
        Some(match c.signum() {
            -1 => beam.is_endless || (&(a + &b2) + &c).signum() > 0,
            0 => b.signum() < 0 && (beam.is_endless || (a + &b2).signum() > 0),
            _ => {
                b.signum() < 0
                    && (&(&b * &b) - &(a * &c)).signum() >= 0
                    && (beam.is_endless || (a + &b).signum() > 0 || (&(a + &b2) + &c).signum() < 0)
            }
        })
    }

    /// It is where the light is outside.
    fn darkens_its_back(&self, light: Source) -> bool {
        match light {
            Source::Eye => false,
            Source::Point(position) => self.side_of(position).is_none_or(|side| side > 0),
            Source::Sun(_) => true,
        }
    }

    /// Without cancellation where the sign of `B` is known: from outside, the near root `C/(−B + √(B² − AC))`; on the sphere,
    /// `−2B/A`; from inside, the far root `(−B + √(B² − AC))/A = −C/(B + √(B² − AC))`.
    fn first_root(&self, beam: &ExactBeam, n_bits: usize) -> Option<[Enclosure; 2]> {
        let (a, [b, c]) = (&beam.square, beam_quadratic(beam, self)?);
        let root = (&(&b * &b) - &(a * &c)).enclose(n_bits).sqrt(n_bits);
        let (sign_b, sign_c) = (b.signum(), c.signum());
        let half = |b: Surd| b.enclose(n_bits).plus(&root);
        Some(match sign_c {
            1 => [c.enclose(n_bits), half(-b)],
            0 => [(-(&b + &b)).enclose(n_bits), a.enclose(n_bits)],
            _ if sign_b > 0 => [(-c).enclose(n_bits), half(b)],
            _ => [half(-b), a.enclose(n_bits)],
        })
    }

    fn side_of(&self, point: DVec3) -> Option<i32> {
        let ray = ExactRay::new(&WorldRay { origin: point, direction: DVec3::X });
        Some(signum(&HalfB::new(&ray, self)?.k))
    }

    fn place(&self) -> Option<ExactPlace> {
        (self.radius != 0.0).then(|| ExactPlace::Sphere(self.bits()))
    }
}

/// Numbers of the lecture's quadratic equation, exactly, for the contract's `d` (`a·t² + b·t + k = 0`).
#[derive(Clone, Debug)]
pub struct SphereNumbers {
    /// `b = 2·d·(o − c)`.
    pub b: QuadraticSurd,
    /// `k = (o − c)·(o − c) − r²`.
    pub k: QuadraticSurd,
    /// `D = b² − 4ak`.
    pub discriminant: QuadraticSurd,
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
        discriminant: QuadraticSurd::quotient(double(&double(&d)), &fs * &fs, 1),
        b: QuadraticSurd::quotient(-double(&half_b.b), fs, 1),
        k: QuadraticSurd::quotient(half_b.k, &s * &s, 1),
    })
}

/// The sign of the discriminant of a ray's line and a sphere; `None` where a number is not finite.
pub fn signum_of_discriminant(ray: &ExactRay, sphere: &Sphere) -> Option<i32> {
    let half_b = HalfB::new(ray, sphere)?;
    Some(signum(&half_b.quarter_discriminant(ray.norm_squared())))
}
