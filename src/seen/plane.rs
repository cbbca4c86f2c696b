//! Planes: `t = N/M` with `N = n·(a − o)` and `M = n·d`. [`crate::guard`] has the bounds.

use glam::DVec3;

use super::{Bounds, Eye, Lengths, Seen, Surface, record};
use crate::exact::{ExactRay, plane_numbers};
use crate::guard::{self, InputError, ROOM, length_bound, length_bounds, rows, steps};
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
        /// The normal at unit length,
        unit: vec near,
        /// and what that is off by.
        unit_error: num up,
    }
}

/// `(a − o)·n` for the eye's reference point, exactly and rounded once; `None` for 0.
fn numerator(plane: &Plane, eye: &Eye) -> Option<f64> {
    let ray = ExactRay::new(&Ray { origin: eye.reference, direction: DVec3::X });
    let exact = plane_numbers(&ray, plane.point, plane.normal)?.numerator;
    (exact.signum() != 0).then(|| exact.to_f64())
}

/// [`steps::NORMAL`] where the unit is that of rounding to the nearest.
const HOST_NORMAL: f64 = 1.001;

impl PlaneSeen<f64> {
    /// What no ray hits: it runs along all of them.
    const NEVER: PlaneSeen<f64> = PlaneSeen {
        normal: V3([0.0; 3]),
        offset: 1.0,
        offset_error: 0.0,
        slope_error: 0.0,
        unit: V3([0.0; 3]),
        unit_error: 1.0,
    };

    /// With bounds for arithmetic of `F`; all is left open where its range is left.
    pub fn new<F: Float>(plane: &Plane, eye: &Eye) -> PlaneSeen<f64> {
        let scaled = Scaled::new(plane.normal);
        let normal = scaled.rounded();
        let l = plane.point - eye.reference;
        let distance = length_bound(l) + eye.spread;
        let input = eye.reach.widen(eye.input, distance);
        let eye = &Eye { input, ..*eye };
        let mut offset = normal.dot(l);
        let mut error = 4.0 * f64::EPSILON * length_bound(normal) * distance;
        if eye.spread == 0.0 && offset.abs() <= error {
            // A ray that starts in the plane does not hit it.
            let Some(exact) = numerator(plane, eye) else { return PlaneSeen::NEVER };
            let rescaled = exact * power_of_two(-scaled.exponent());
            // A number that is not normal, or was not before, says nothing more.
            if exact.is_normal() && rescaled.is_normal() {
                (offset, error) = (rescaled, 2.0 * f64::EPSILON * rescaled.abs());
            }
        }
        PlaneSeen::at::<F>(normal, offset, error, distance, eye)
    }
}

impl<R: Real<One = f64>> PlaneSeen<R> {
    /// A plane whose point is at `l` from the eyes' reference points.
    pub fn of<F: Float>(normal: DVec3, l: V3<R>, eye: &Eye) -> PlaneSeen<R> {
        let distance = length_bounds(l) + R::lit(eye.spread);
        let error = R::lit(4.0 * f64::EPSILON * length_bound(normal)) * distance;
        PlaneSeen::at::<F>(normal, V3::lit(normal).dot(l), error, distance, eye)
    }

    /// One whose `offset` is off by `error`, with a point that is no farther away than `distance`.
    #[inline(always)]
    fn at<F: Float>(normal: DVec3, offset: R, error: R, distance: R, eye: &Eye) -> PlaneSeen<R> {
        let (lit, n) = (R::lit, length_bound(normal));
        let in_range = distance.le(lit(F::FARTHEST));
        let or = |number: R, open: f64| R::select(in_range, number, lit(open));
        // `N` in f64 (difference 1, dot product 3), rounded to `F` (1) and less that of the origin (1).
        let of_offset = error + lit(2.0 * eye.unit) * offset.abs();
        let of_spread = match eye.spread > 0.0 {
            true => eye.unit * (steps::DOT + HOST_NORMAL + 1.0 + eye.input.offset) * n,
            false => 0.0,
        };
        let offset_error = lit(ROOM) * (of_offset + lit(of_spread) * distance) + lit(F::TINY);
        let unit = normal * (1.0 / normal.length());
        let more = HOST_NORMAL - steps::NORMAL;
        let input = InputError { direction: eye.input.direction + more, ..eye.input };
        PlaneSeen {
            normal: V3::lit(normal),
            offset: or(offset, 0.0),
            // More than `n·o` can be.
            offset_error: or(offset_error, 4.0 * F::FARTHEST),
            slope_error: lit(guard::plane_direction_error(n, eye.unit, input)),
            unit: V3::lit(unit),
            // In f64, and rounded to `F`.
            unit_error: lit(ROOM * (steps::NORMALIZED * f64::EPSILON + eye.unit)),
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

    /// With one quotient: [`crate::guard::rows`].
    #[inline(always)]
    fn surface<R: Real>(
        seen: &PlaneSeen<R>,
        ray: &super::Ray<R>,
        lengths: &Lengths<R>,
    ) -> Surface<R> {
        let (zero, one, beyond) = (R::lit(0.0), R::lit(1.0), R::lit(R::One::BEYOND));
        let offset = seen.offset - seen.normal.dot(ray.origin);
        let slope = seen.normal.dot(ray.direction);
        let slope_error = seen.slope_error * lengths.longest;
        let inverse = one / slope;
        let t = offset * inverse;
        let of_quotient = inverse.abs() * (seen.offset_error + t * slope_error);
        let error = of_quotient * R::lit(rows::QUOTIENT) + t * lengths.of_quotient;
        let is_known = slope_error.lt(slope.abs() * R::lit(rows::MOST_OF_SLOPE)).and(zero.lt(t));
        let (t, error) = (R::select(is_known, t, zero), R::select(is_known, error, beyond));
        let is_along = zero.lt(slope);
        let normal_error = R::select(is_known, seen.unit_error, beyond);
        Surface {
            t: Bounds { low: (t - error).max(zero), high: t + error },
            point: ray.origin + ray.direction * t,
            point_error: lengths.longest * error + (lengths.of_t * t + lengths.of_origin),
            normal: V3::select(is_along, -seen.unit, seen.unit),
            normal_error,
            component_error: V3([normal_error; 3]),
            front: zero.le(zero),
        }
    }
}
