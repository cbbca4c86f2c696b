//! Planes: `t = N/M` with `N = n·(a − o)` and `M = n·d`. [`crate::guard`] has the bounds.

use glam::DVec3;

use super::{Bounds, Eye, Seen, record};
use crate::exact::{ExactRay, plane_numbers};
use crate::guard::{self, ROOM, length_bound, steps};
use crate::num::{Float, Mask, Real, V3};
use crate::prepare::{Scaled, power_of_two};
use crate::rays::Ray;
use crate::scene::Plane;

record! {
    /// A plane as an eye sees it.
    PlaneSeen {
        /// Scaled by a power of two to a largest component in `1..2`.
        normal: vec near,
        /// `N` from the reference point.
        offset: num near,
        /// What it is off by, anywhere within the eye's spread.
        offset_error: num up,
        /// What `M` is off by, for `|d| = 1`.
        slope_error: num up,
    }
}

/// `(a − o)·n` for the eye's reference point, exactly and rounded once; `None` for 0.
fn numerator(plane: &Plane, eye: &Eye) -> Option<f64> {
    let ray = ExactRay::new(&Ray { origin: eye.reference, direction: DVec3::X });
    let exact = plane_numbers(&ray, plane.point, plane.normal)?.numerator;
    (exact.signum() != 0).then(|| exact.to_f64())
}

impl PlaneSeen<f64> {
    /// What no ray hits: it runs along all of them.
    const NEVER: PlaneSeen<f64> =
        PlaneSeen { normal: V3([0.0; 3]), offset: 1.0, offset_error: 0.0, slope_error: 0.0 };

    /// With bounds for arithmetic of `F`; all is left open where its range is left.
    pub fn new<F: Float>(plane: &Plane, eye: &Eye) -> PlaneSeen<f64> {
        let scaled = Scaled::new(plane.normal);
        let normal = scaled.rounded();
        let n = length_bound(normal);
        let l = plane.point - eye.reference;
        let distance = length_bound(l) + eye.spread;
        let input = eye.reach.widen(eye.input, distance);
        let in_range = distance <= F::FARTHEST;
        let (mut offset, mut error) = (normal.dot(l), 4.0 * f64::EPSILON * n * distance);
        if eye.spread == 0.0 && offset.abs() <= error {
            // A ray that starts in the plane does not hit it.
            let Some(exact) = numerator(plane, eye) else { return PlaneSeen::NEVER };
            // A number that is not normal says nothing more.
            let exact = exact * power_of_two(-scaled.exponent());
            if exact.is_normal() {
                (offset, error) = (exact, 2.0 * f64::EPSILON * exact.abs());
            }
        }
        // `N` in f64 (difference 1, dot product 3), rounded to `F` (1) and less that of the origin (1).
        let of_offset = error + 2.0 * F::UNIT * offset.abs();
        let of_spread = match eye.spread > 0.0 {
            true => F::UNIT * (steps::DOT + steps::NORMAL + 1.0 + input.offset) * n * distance,
            false => 0.0,
        };
        PlaneSeen {
            normal: V3(normal.to_array()),
            offset: if in_range { offset } else { 0.0 },
            offset_error: match in_range {
                true => ROOM * (of_offset + of_spread) + F::TINY,
                false => F::FARTHEST,
            },
            slope_error: guard::plane_direction_error(n, F::UNIT, input),
        }
    }
}

/// `(N ± e)/(M ± e)`: two sums and a quotient, and the product that widens; in units.
const QUOTIENT: f64 = 8.0;

impl Seen for PlaneSeen<f64> {
    #[inline(always)]
    fn bounds<R: Real>(seen: &PlaneSeen<R>, ray: &super::Ray<R>) -> Option<Bounds<R>> {
        let (zero, beyond) = (R::lit(0.0), R::lit(R::One::BEYOND));
        let (tiny, width) = (R::lit(R::One::TINY), QUOTIENT * R::One::UNIT);
        let offset = seen.offset - seen.normal.dot(ray.origin);
        let slope = seen.normal.dot(ray.direction);
        let away = R::select(offset.lt(zero), -slope, slope);
        // |d| ≤ a, as |d| ≥ 1.
        let error = seen.slope_error * ray.a;
        let (slow, quick) = (away - error, away + error);
        let least = ((offset.abs() - seen.offset_error) / quick.max(tiny)) * R::lit(1.0 - width);
        let most = ((offset.abs() + seen.offset_error) / slow.max(tiny)) * R::lit(1.0 + width);
        let is_known = seen.offset_error.lt(offset.abs());
        let is_missed = is_known.and(quick.le(zero));
        let is_hit = is_known.and(tiny.lt(slow));
        // A plane that is only far away is not missed.
        let low = R::select(is_known, least.min(R::lit(R::One::BEYOND / 2.0)), zero);
        Some(Bounds {
            low: R::select(is_missed, beyond, low),
            high: R::select(is_hit, most, beyond),
        })
    }
}
