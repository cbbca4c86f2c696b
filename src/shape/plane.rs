//! Planes: `t = N/M` with `N = n·(a − o)` and `M = n·d`. [`crate::bounds`] has the bounds.

use glam::DVec3;

use super::shadow::{OF_PLANE, OF_SLOPE, Occlusion, ShadowRay};
use super::{Bounds, RayOrigin, Record, ShapeRecord, Surface, SurfaceErrorTerms, record};
use crate::bounds::{self, ROOM, length_bound, length_bounds, rows, steps};
use crate::exact::{ExactRay, plane_numbers};
use crate::num::{Float, Real, V3};
use crate::num::{ScaledInteger, power_of_two};
use crate::rays::WorldRay;
use crate::scene::Plane;

record! {
    /// A plane as an eye sees it.
    PlaneRecord {
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
pub(super) fn numerator(plane: &Plane, eye: &RayOrigin) -> Option<f64> {
    let ray = ExactRay::new(&WorldRay { origin: eye.reference, direction: DVec3::X });
    let exact = plane_numbers(&ray, plane)?.numerator;
    (exact.signum() != 0).then(|| exact.to_f64())
}

impl PlaneRecord<f64> {
    /// What no ray hits: it runs along all of them.
    pub const NEVER: PlaneRecord<f64> = PlaneRecord {
        normal: V3([0.0; 3]),
        offset: 1.0,
        offset_error: 0.0,
        slope_error: 0.0,
        unit: V3([0.0; 3]),
        unit_error: 1.0,
    };

    /// With bounds for arithmetic of `F`; all is left open where its range is left.
    pub fn new<F: Float>(plane: &Plane, eye: &RayOrigin) -> PlaneRecord<f64> {
        let scaled = ScaledInteger::new(plane.normal);
        let normal = scaled.rounded();
        let l = plane.point - eye.reference;
        let distance = length_bound(l) + eye.spread;
        let input = eye.reach.widen(eye.input, distance, eye.unit);
        let eye = &RayOrigin { input, ..*eye };
        let mut offset = normal.dot(l);
        let mut error = bounds::N_ERROR * f64::UNIT * length_bound(normal) * distance;
        if eye.spread == 0.0 && offset.abs() <= error {
            // A ray that starts in the plane does not hit it.
            let Some(exact) = numerator(plane, eye) else { return PlaneRecord::NEVER };
            let rescaled = exact * power_of_two(-scaled.exponent());
            // A number that is not normal, or was not before, says nothing more.
            if exact.is_normal() && rescaled.is_normal() {
                // No test sees the 2 halved: it is four times a rounding.
                (offset, error) = (rescaled, 2.0 * f64::UNIT * rescaled.abs());
            }
        }
        PlaneRecord::at::<F>(normal, offset, error, distance, eye)
    }
}

impl<R: Real<One = f64>> PlaneRecord<R> {
    /// A plane whose point is at `l` from the eyes' reference points.
    #[inline(always)]
    pub fn of<F: Float>(plane: &Plane, l: V3<R>, eye: &RayOrigin) -> PlaneRecord<R> {
        let normal = ScaledInteger::new(plane.normal).rounded();
        let distance = length_bounds(l) + R::lit(eye.spread);
        let error = R::lit(bounds::N_ERROR * f64::UNIT * length_bound(normal)) * distance;
        PlaneRecord::at::<F>(normal, V3::lit(normal).dot(l), error, distance, eye)
    }

    /// One whose `offset` is off by `error`, with a point that is no farther away than `distance`.
    #[inline(always)]
    fn at<F: Float>(
        normal: DVec3,
        offset: R,
        error: R,
        distance: R,
        eye: &RayOrigin,
    ) -> PlaneRecord<R> {
        let (lit, n) = (R::lit, length_bound(normal));
        let in_range = distance.le(lit(F::FARTHEST));
        let or = |number: R, open: f64| R::select(in_range, number, lit(open));
        // `N` in f64 (difference 1, dot product 3), rounded to `F` (1) and less that of the origin (1). No test sees the latter two
        // cut: what a slope is granted is more of `t`.
        let of_offset = error + lit(2.0 * eye.unit) * offset.abs();
        let of_spread = match eye.spread > 0.0 {
            // No test sees the 1 cut: of an origin's error as much is for a difference that is not taken here.
            true => eye.unit * (steps::DOT + steps::NORMAL + 1.0 + eye.input.offset) * n,
            false => 0.0,
        };
        let offset_error = lit(ROOM) * (of_offset + lit(of_spread) * distance) + lit(F::TINY);
        let unit = normal * (1.0 / normal.length());
        PlaneRecord {
            normal: V3::lit(normal),
            offset: or(offset, 0.0),
            // Over the slope, at most 2·√3·|d|, this is beyond every `t`, and a point along the ray unknown.
            offset_error: or(offset_error, 4.0 * F::BEYOND),
            slope_error: lit(bounds::plane_direction_error(n, eye.unit, eye.input)),
            unit: V3::lit(unit),
            // In f64, and rounded to `F`.
            unit_error: lit(ROOM * (steps::NORMALIZED * f64::UNIT + steps::NORMAL * eye.unit)),
        }
    }
}

impl ShapeRecord for PlaneRecord<f64> {
    #[inline(always)]
    fn bounds<R: Real>(seen: &PlaneRecord<R>, ray: &super::Ray<R>) -> Option<Bounds<R>> {
        let (zero, beyond) = (R::lit(0.0), R::lit(R::One::BEYOND));
        let width = rows::BOUNDS * R::One::UNIT;
        let offset = seen.offset - seen.normal.dot(ray.origin);
        let slope = seen.normal.dot(ray.direction);
        let away = R::select(offset.lt(zero), -slope, slope);
        // |d| ≤ a, as |d| ≥ 1.
        let error = seen.slope_error * ray.a;
        let (slow, quick) = (away - error, away + error);
        // With a smaller slope `t` would be beyond everything.
        let reach = offset.abs() + seen.offset_error;
        let least_slope = (reach * R::lit(1.0 / R::One::BEYOND)).max(R::lit(R::One::TINY));
        let least =
            ((offset.abs() - seen.offset_error) / quick.max(least_slope)) * R::lit(1.0 - width);
        let most = (reach / slow.max(least_slope)) * R::lit(1.0 + width);
        let is_known = seen.offset_error.lt(offset.abs());
        let is_missed = is_known & quick.le(zero);
        let is_hit = is_known & least_slope.lt(slow);
        // A plane that is only far away is not missed.
        let low = R::select(is_known, least.min(R::lit(R::One::BEYOND / 2.0)), zero);
        Some(Bounds {
            low: R::select(is_missed, beyond, low),
            high: R::select(is_hit, most, beyond),
        })
    }

    /// With one quotient: [`crate::bounds::rows`].
    #[inline(always)]
    fn surface<R: Real>(
        seen: &PlaneRecord<R>,
        ray: &super::Ray<R>,
        lengths: &SurfaceErrorTerms<R>,
    ) -> Surface<R> {
        let (zero, one, beyond) = (R::lit(0.0), R::lit(1.0), R::lit(R::One::BEYOND));
        let offset = seen.offset - seen.normal.dot(ray.origin);
        let slope = seen.normal.dot(ray.direction);
        let against = R::select(zero.lt(slope), -one, one);
        let slope_error = seen.slope_error * lengths.longest;
        let steep = slope.abs() * R::lit(rows::MOST_OF_SLOPE) - slope_error;
        let inverse = one / R::select(zero.lt(steep), slope, one);
        let t = offset * inverse;
        let of_quotient = inverse.abs() * (seen.offset_error + t * slope_error);
        let error = of_quotient * R::lit(rows::QUOTIENT) + t * lengths.of_quotient;
        let is_known = zero.lt(t.min(steep));
        let (t, error) = (R::select(is_known, t, zero), R::select(is_known, error, beyond));
        let normal_error = R::select(is_known, seen.unit_error, beyond);
        Surface {
            t: Bounds { low: (t - error).max(zero), high: t + error },
            point: ray.origin + ray.direction * t,
            point_error: lengths.longest * error + (lengths.of_t * t + lengths.of_origin),
            normal: seen.unit * against,
            normal_error,
            component_error: V3([normal_error; 3]),
            front: zero.le(zero),
        }
    }
}

record! {
    /// A plane as shadow rays meet it.
    PlaneOccluder {
        /// From the reference point.
        point: vec near,
        /// With a largest component from 1 to 2.
        normal: vec near_or_least,
        /// Length of the normal, or a little more.
        length: num up,
        /// What the point's place is off by, in units.
        place: num up,
    }
}

impl<F: Float> PlaneOccluder<F> {
    /// A plane from a reference point; all is left open where the range of `F` is left.
    pub fn new(plane: &Plane, reference: DVec3) -> PlaneOccluder<F> {
        let (point, normal) = (plane.point - reference, ScaledInteger::new(plane.normal).rounded());
        let (length, place) = (length_bound(normal), length_bound(point));
        let (point, place) = match place < F::LARGEST_ROOT {
            true => (point, place),
            false => (DVec3::ZERO, F::UNKNOWN / F::UNIT),
        };
        let (point, normal) = (V3(point.to_array()), V3(normal.to_array()));
        PlaneOccluder { point, normal, length, place }.round()
    }
}

impl<R: Real> PlaneOccluder<R> {
    /// Returns whether the plane occludes a light for a shadow ray that does not start on it. `side` is the side of a light that is close
    /// to the plane ([`super::Contact`]).
    ///
    /// `N = n·(a − p)` at the start and `N₁ = n·(a − L)` at the end; it is in the
    /// way where their signs differ. They are off by `|n|·E`, without the end's part at the start, and `3ε` of the
    /// product of the lengths for the dot product. A sun's end has the sign of `−n·w`, off by `3ε|n||w|` alone, and their
    /// zeros are exact; so its ray surely runs along a plane where each product is one with 0, and then misses it.
    #[inline(always)]
    pub fn occlude(&self, ray: &ShadowRay<R>, side: Option<R>) -> Occlusion<R> {
        // No test sees the 2 halved: in f32 ½ is for the normal, and ½ is room.
        let (lit, zero, more) = (R::lit, R::lit(0.0), 2.0 * R::One::ROUNDED);
        let &PlaneOccluder { point, normal, length: n, place } = self;
        let l = point - ray.start;
        let (of_lengths, unit) = (lit(OF_PLANE + more), ray.unit);
        // Below that squares underflow.
        let distance = l.dot(l).sqrt().max(lit(1.0 / R::One::LARGEST_ROOT));
        let here = ray.error + unit * (place + of_lengths * distance);
        let e = here + ray.end_error + unit * (of_lengths * ray.length);
        let start = normal.dot(l);
        let start_error = lit(ROOM) * n * here;
        let stop = normal.dot(l * ray.from_point - ray.way);
        let of_slope = lit(OF_SLOPE + more) * unit * ray.length;
        let stop_error = n * (lit(ROOM) * e * ray.from_point).max(of_slope);
        let in_range = e.lt(lit(R::One::LARGEST_ROOT));
        let start_error = R::select(in_range, start_error, lit(R::One::BEYOND));
        let [above, below] = [start - start_error, -start - start_error];
        if let Some(side) = side {
            // `N₁` has the other sign.
            let half = lit(0.5);
            let [end_above, end_below] = [-side - half, side - half];
            let blocked = above.min(end_below).max(below.min(end_above));
            let clear = above.min(end_above).max(below.min(end_below)).max(half - side.abs());
            return Occlusion { blocked, clear };
        }
        let [end_above, end_below] = [stop - stop_error, -stop - stop_error];
        let blocked = above.min(end_below).max(below.min(end_above));
        let clear = above.min(end_above).max(below.min(end_below));
        let both = |axis: usize| normal.0[axis].abs().min(ray.way.0[axis].abs());
        let runs_along = both(0).max(both(1)).max(both(2)).max(ray.from_point).le(zero);
        Occlusion { blocked, clear: R::select(runs_along, lit(1.0), clear) }
    }
}
