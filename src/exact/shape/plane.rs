//! A plane, exactly.

use glam::DVec3;

use super::{ExactPlace, ExactShape, Side};
use crate::bounds::steps;
use crate::exact::double_double::ball_dot;
use crate::exact::light::{ExactBeam, Surd, dot_real};
use crate::exact::number::{primitive, product3, real3};
use crate::exact::{Ball, DoubleDoubleRay, Dyadic, Enclosure, ExactRay, QuadraticSurd, signum};
use crate::num::{Float, ScaledInteger};
use crate::rays::WorldRay;
use crate::scene::Plane;

/// Numerator `N = (p − o)·n` and denominator `M = d·n` of a plane, for the ray's own (scaled)
/// origin and direction.
fn plane_quotient(ray: &ExactRay, plane: &Plane) -> Option<(Dyadic, Dyadic)> {
    let n = real3(plane.normal)?;
    Some((product3(&ray.to_point(plane.point)?, &n), product3(ray.direction(), &n)))
}

/// `N = (a − p)·n` and `M = w·n` of a beam, whose root is `N/M`.
fn beam_quotient<'a>(beam: &ExactBeam<'a>, plane: &Plane) -> Option<[Surd<'a>; 2]> {
    let n = real3(plane.normal)?;
    let offset = beam.point.offset_from(&real3(plane.point)?);
    Some([-dot_real(&offset, &n), dot_real(&beam.way, &n)])
}

impl ExactShape for Plane {
    /// The root `t > 0`: `N/M`, written with a positive denominator. `M > 0` means that the ray runs along
    /// the normal: it meets the back.
    fn visible_root(&self, ray: &ExactRay) -> Option<(QuadraticSurd, Side)> {
        let (n, m) = plane_quotient(ray, self)?;
        match (signum(&n), signum(&m)) {
            (1, 1) => Some((QuadraticSurd::quotient(n, m, ray.t_factor()), Side::Back)),
            (-1, -1) => Some((QuadraticSurd::quotient(-n, -m, ray.t_factor()), Side::Front)),
            _ => None,
        }
    }

    fn outward_normal(&self, _: &ExactRay, _: &QuadraticSurd) -> Option<[QuadraticSurd; 3]> {
        plane_normal(self)
    }

    fn surface_in_balls(&self, sight: &DoubleDoubleRay) -> Option<(Ball, [f32; 3])> {
        let n = self.normal.to_array().map(Ball::from);
        let slope = ball_dot(&n, &sight.direction);
        let is_along = slope.is_positive();
        if !(is_along || (-slope).is_positive()) {
            return None;
        }
        let root = ball_dot(&n, &sight.to_point(self.point)).over(slope);
        Some((root, unit_f32(self).map(|x| if is_along { 0.0 - x } else { x })))
    }

    fn slope<'a>(&self, beam: &ExactBeam<'a>) -> Option<(Surd<'a>, Dyadic)> {
        let n = real3(self.normal)?;
        Some((dot_real(&beam.way, &n), product3(&n, &n)))
    }

    fn blocks(&self, beam: &ExactBeam) -> Option<bool> {
        let [n, m] = beam_quotient(beam, self)?;
        let sign = m.signum();
        let is_ahead = sign != 0 && n.signum() == sign;
        Some(is_ahead && (beam.is_endless || (&m - &n).signum() == sign))
    }

    fn first_root(&self, beam: &ExactBeam, n_bits: usize) -> Option<[Enclosure; 2]> {
        let enclosed = |x: Surd<'_>| (if x.signum() < 0 { -x } else { x }).enclose(n_bits);
        let [n, m] = beam_quotient(beam, self)?;
        Some([enclosed(n), enclosed(m)])
    }

    fn side_of(&self, point: DVec3) -> Option<i32> {
        let ray = ExactRay::new(&WorldRay { origin: point, direction: DVec3::X });
        Some(-signum(&plane_quotient(&ray, self)?.0))
    }

    /// However long its normal is, and whichever of its points is named. Of the normal whole numbers without a common divisor,
    /// the first of which that is not 0 is positive.
    fn place(&self) -> Option<ExactPlace> {
        let normal = primitive(&real3(self.normal)?)?;
        let n = normal.each_ref().map(|x| Dyadic::from(x.clone()));
        let offset = product3(&real3(self.point)?, &n).shortest();
        Some(ExactPlace::Plane(Box::new((normal, offset))))
    }
}

/// The exact unit normal of a plane, each component rounded to the nearest f32.
pub(crate) fn unit_f32(plane: &Plane) -> [f32; 3] {
    let normal = ScaledInteger::new(plane.normal).rounded();
    let unit = (normal * (1.0 / normal.length())).to_array();
    let error = steps::NORMALIZED * f64::UNIT;
    let [low, high] = [-error, error].map(|error| unit.map(|x| (x + error) as f32));
    if low == high {
        // Not `−0`.
        return low.map(|x| x + 0.0);
    }
    plane_normal(plane).map_or([0.0; 3], |normal| normal.map(|x| x.to_f32()))
}

/// `nᵢ/‖n‖ = sgn(nᵢ)·√(nᵢ²·‖n‖²) / ‖n‖²`
fn plane_normal(plane: &Plane) -> Option<[QuadraticSurd; 3]> {
    let n = real3(plane.normal)?;
    let norm_squared = product3(&n, &n);
    if signum(&norm_squared) == 0 {
        return None;
    }
    Some(std::array::from_fn(|i| {
        let radicand = &n[i] * &n[i] * &norm_squared;
        QuadraticSurd::new(Dyadic::zero(), signum(&n[i]), radicand, norm_squared.clone(), 1)
    }))
}

/// The numbers of the plane's quotient, exactly, for the contract's `d`.
#[derive(Clone, Debug)]
pub struct PlaneNumbers {
    /// `(a − o)·n`.
    pub numerator: QuadraticSurd,
    /// `d·n`.
    pub denominator: QuadraticSurd,
}

/// The numbers of a ray and a plane; `None` where a number is not finite.
pub fn plane_numbers(ray: &ExactRay, plane: &Plane) -> Option<PlaneNumbers> {
    let (n, m) = plane_quotient(ray, plane)?;
    Some(PlaneNumbers {
        numerator: QuadraticSurd::ratio(n, ray.world_scale()),
        denominator: QuadraticSurd::ratio(m, ray.direction_scale()),
    })
}
