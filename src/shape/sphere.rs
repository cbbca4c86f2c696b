//! Spheres. The formula starts from the point of the line closest to the centre: an error of its place counts only squared,
//! as it is moved across the way to the centre. [`crate::bounds`] has the bounds.

use super::shadow::{OF_OFFSET, OF_PLACE, OF_SQUARES, Occlusion, ShadowRay};
use super::{Bounds, Ray, RayOrigin, Record, ShapeRecord, Surface, SurfaceErrorTerms, record};
use glam::DVec3;

use crate::bounds::rows::{CHORD, LEAST_WIDTHS};
use crate::bounds::{self, FilterBounds, InputError, ROOM, length_bound, length_bounds, steps};
use crate::exact::{ExactRay, sphere_numbers};
use crate::num::{Float, Mask, Real, V3, exponent_of, power_of_two};
use crate::scene::Sphere;

record! {
    /// What tells where a ray meets a sphere: all that a tree's leaf has of a [`SphereRecord`].
    SphereLeaf {
        /// From the eye's reference point.
        center: vec near,
        /// [`FilterBounds::inner2`]
        inner2: num down,
        /// [`FilterBounds::outer2`]
        outer2: num up,
        /// [`FilterBounds::slack`]
        slack: num up,
        /// Most that the near root can be: 0 where the eye is inside or on the sphere.
        near_most: num up,
    }
}

record! {
    /// A sphere as an eye sees it.
    SphereRecord {
        /// [`SphereLeaf::center`]
        center: vec near,
        /// [`FilterBounds::inner2`]
        inner2: num down,
        /// [`FilterBounds::outer2`]
        outer2: num up,
        /// [`FilterBounds::slack`]
        slack: num up,
        /// [`SphereLeaf::near_most`]
        near_most: num up,
        /// `|c|² − r²`
        k: num near,
        /// What it is off by, anywhere within the eye's spread.
        k_error: num up,
        /// 1 where the eye is so close to the surface of so large a sphere that `k` is needed for `t`.
        is_close: num near,
        /// What `k/a` over a root is off by, relative.
        k_width: num up,
        /// `1/r`
        inv_r: num near,
        /// What `c` and an origin are off by together.
        offset_error: num up,
        /// What `c` and an origin are off by together where that is more than a rounding, else 0.
        moved_error: num up,
        /// `r²`
        r2: num near,
        /// `r² − m` from here on tells half a chord,
        least2: num up,
        /// which over it bounds what half a chord is off by, as a length.
        of_chord: num up,
        /// What the normal that comes from the chord is off by, but for the chord.
        normal_error: num up,
    }
}

/// Part of a distance that a sphere's surface is closer than to the eye, where its size hides its distance. No bound: it
/// weighs a quotient against a slack.
const CLOSE: f64 = 1.0 / 32.0;

/// Part of `r²` that `r² − m` is at least. No bound: it weighs the rays at the silhouette that are left open
/// against an error that grows towards it.
const LEAST: f64 = 1.0 / (1u64 << 14) as f64;

/// Whether a sphere whose points are up to `l` and its radius away suits arithmetic of `F`.
#[inline(always)]
fn is_in_range<F: Float, R: Real<One = f64>>(r: R, l: R) -> R::Mask {
    let farthest = R::lit(F::FARTHEST);
    l.le(farthest) & r.le(farthest) & R::lit(F::SMALLEST).le(r)
}

/// Whether the reference point is so close to the surface that the sphere's size may hide its distance, `l` from any eye.
#[inline(always)]
pub fn is_near_surface<R: Real<One = f64>>(from_reference: R, r: R, l: R) -> R::Mask {
    (from_reference - r).abs().le(R::lit(CLOSE) * l)
}

impl<F: Float> SphereLeaf<F> {
    /// What no ray meets, whatever else a [`SphereRecord`] that begins with it says.
    pub fn nowhere() -> SphereLeaf<F> {
        let (below, one) = (F::near(-1.0), F::near(1.0));
        let center = V3([F::default(); 3]);
        SphereLeaf { center, inner2: below, outer2: below, slack: one, near_most: one }
    }
}

impl<R: Real<One = f64>> SphereLeaf<R> {
    /// Spheres at `center` from the eye's reference point and up to `l` from its rays' origins; all is left open out of the
    /// range of `F`. Where the eye is one point, `is_outside` may hold in doubt, and holds if it is outside.
    #[inline(always)]
    fn of<F: Float>(
        center: V3<R>,
        r: R,
        l: R,
        is_outside: R::Mask,
        input: InputError<R>,
        eye: &RayOrigin,
    ) -> SphereLeaf<R> {
        let (lit, far) = (R::lit, F::FARTHEST);
        let smallest = lit(F::SMALLEST);
        let (is_tiny, r) = (r.lt(smallest), r.max(smallest));
        let in_range = is_in_range::<F, R>(r, l);
        let or = |number: R, open: f64| R::select(in_range, number, lit(open));
        let FilterBounds { inner2, outer2, slack } = FilterBounds::new(r, l, eye.unit, input);
        // A ray that misses a larger sphere misses a tiny one, and the chord of the tiny one is part of the other chord.
        let inner2 = R::select(is_tiny, lit(-1.0), inner2);
        let near_most = match eye.spread > 0.0 {
            true => lit(F::BEYOND),
            false => R::select(is_outside, lit(F::BEYOND), lit(0.0)),
        };
        SphereLeaf {
            center: center.map(|x| or(x, 0.0)),
            inner2: or(inner2, -1.0),
            // Of a ray that starts within the spread `m` and `|k|` are at most far².
            outer2: or(outer2, 2.0 * far * far),
            slack: or(slack, far),
            near_most: or(near_most, F::BEYOND),
        }
    }

    /// Spheres at `center` from the eye's reference point, where f64 alone says whether the eye is outside.
    #[inline(always)]
    pub fn at<F: Float>(center: V3<R>, r: R, eye: &RayOrigin) -> SphereLeaf<R> {
        let l = length_bounds(center) + R::lit(eye.spread);
        let (k, k_error) = bounds::k_in_f64(center, r);
        let is_outside = R::lit(0.0).le(k + k_error);
        let input = eye.reach.widen(eye.input, l, eye.unit);
        SphereLeaf::of::<F>(center, r, l, is_outside, input, eye)
    }
}

impl<R: Real> SphereLeaf<R> {
    /// [`ShapeRecord::bounds`] of a sphere.
    #[inline(always)]
    pub fn bounds(&self, ray: &Ray<R>) -> Option<Bounds<R>> {
        let (zero, beyond) = (R::lit(0.0), R::lit(R::One::BEYOND));
        let l = self.center - ray.origin;
        let foot = Foot::new(self, l, ray);
        let Foot { inner, outer, .. } = foot;
        if !zero.le(outer).any() {
            return None;
        }
        let Chord { near, far, .. } = Chord::new(self, &foot, ray);
        let low = R::select(near.high.le(zero), far.low, near.low);
        let high = R::select(zero.lt(near.low), near.high, far.high);
        let is_missed = outer.lt(zero) | far.high.le(zero);
        let is_hit = zero.le(inner) & zero.lt(far.low);
        Some(Bounds {
            low: R::select(is_missed, beyond, low),
            high: R::select(is_hit, high, beyond),
        })
    }
}

impl<R: Copy> SphereRecord<R> {
    /// What a tree's leaf has of it.
    #[inline(always)]
    pub fn leaf(&self) -> SphereLeaf<R> {
        let &SphereRecord { center, inner2, outer2, slack, near_most, .. } = self;
        SphereLeaf { center, inner2, outer2, slack, near_most }
    }
}

impl SphereRecord<f64> {
    /// With bounds for arithmetic of `F`; all is left open where its range is left.
    pub fn new<F: Float>(sphere: &Sphere, eye: &RayOrigin) -> SphereRecord<f64> {
        let (r, center) = (sphere.radius.abs(), sphere.center - eye.reference);
        let k = k_of(center, sphere, eye.reference);
        let l = length_bound(center) + eye.spread;
        let size = l.max(r);
        if size > F::FARTHEST && center.is_finite() {
            return SphereRecord::far::<F>(center, r, k, eye);
        }
        let input = eye.reach.widen(eye.input, l, eye.unit);
        SphereRecord::of::<F>(V3(center.to_array()), r, k, eye.spread, input, eye)
    }

    /// A sphere beyond the range of `F`: its record rules out rays, and bounds `t` from below.
    ///
    /// Let `g < 1`. A ray from `o` meets the sphere with the center `o + g(c − o)` and the radius `g·r` at `g·t`, if it meets the one
    /// with `c` and `r` at `t`. So it misses both or none, and the smaller sphere is not farther away. Its center is `g·c` but for
    /// `(1 − g)·o`, which is less than the eye's spread. The upper bound of `t` is beyond everything. Here `g` is a power of two, and
    /// no number of the smaller sphere is larger than a quarter of the range.
    fn far<F: Float>(center: DVec3, r: f64, k: (f64, f64), eye: &RayOrigin) -> SphereRecord<f64> {
        let largest = center.abs().max(DVec3::splat(eye.spread.max(r)));
        let factor =
            power_of_two(exponent_of(DVec3::splat(F::FARTHEST)) - 3 - exponent_of(largest));
        let (near, r) = (center * factor, r * factor);
        // Any larger bound will do; one of 0 would make the errors below infinite.
        let l = (length_bound(near) + eye.spread).max(1.0);
        let InputError { offset, direction } = eye.reach.widen(eye.input, l, eye.unit);
        // The 1 is more than what underflows.
        let moved = eye.spread / (eye.unit * l);
        let input = InputError { offset: offset + moved + 1.0, direction };
        let is_outside = 0.0 < k.0;
        let leaf = SphereLeaf::of::<F>(V3(near.to_array()), r, l, is_outside, input, eye);
        let open = SphereRecord::of::<F>(V3([0.0; 3]), f64::MAX, k, eye.spread, eye.input, eye);
        let SphereLeaf { center, outer2, slack, near_most, .. } = leaf;
        SphereRecord { center, inner2: -1.0, outer2, slack, near_most, ..open }
    }
}

impl<R: Real<One = f64>> SphereRecord<R> {
    /// Spheres at `center` from the eye's reference point, for which `k` has the right sign where it is off by less than
    /// itself, and is 0 where it is off by 0. Their own rays start within `spread` of that point, which is 0 if the eye's is.
    #[inline(always)]
    pub fn of<F: Float>(
        center: V3<R>,
        r: R,
        (k, k_error): (R, R),
        spread: R,
        input: InputError,
        eye: &RayOrigin,
    ) -> SphereRecord<R> {
        let lit = R::lit;
        let from_reference = length_bounds(center);
        let l = from_reference + spread;
        let in_range = is_in_range::<F, R>(r, l);
        let or = |number: R, open: f64| R::select(in_range, number, lit(open));
        let InputError { offset, direction } = input;
        let errors = InputError { offset: lit(offset), direction };
        let SphereLeaf { center, inner2, outer2, slack, near_most } =
            SphereLeaf::of::<F>(center, r, l, lit(0.0).lt(k), errors, eye);
        // Rounded, ½, and moved to an origin: `o·(c + l)` is off by `2(λ − 1)` of `|o|ℓ` for `o`, `λ + 3` for `c + l`, 6 for the
        // dot product; and the difference by one of `|k|` and 2 of `|o|ℓ`.
        let roundings_of_k = if eye.spread > 0.0 { 1.5 } else { 0.5 };
        let of_moving = lit(3.0 * offset + 9.0) * spread * l;
        // What underflows is an origin, times `c + l`, or a product. It is so little that no test sees it.
        let lost = lit(F::TINY) * (lit(1.0) + l);
        let of_k = lit(roundings_of_k) * k.abs();
        let error = k_error + lit(ROOM * eye.unit) * (of_k + of_moving) + lost;
        // A `k` of 0 has no rounding, if all rays start there.
        let k_error = match eye.spread > 0.0 {
            true => error,
            false => R::select(k_error.le(lit(0.0)), lit(0.0), error),
        };
        // Origins that are apart change k itself; and if its sign is open, the roots are unknown. A `k` of 0 is exact.
        let is_close = is_near_surface(from_reference, r, l);
        let is_close = match eye.spread > 0.0 {
            true => is_close,
            false => is_close & (k_error.lt(k.abs()) | k_error.le(lit(0.0))),
        };
        let close = if eye.reach.apart == 0.0 { 1.0 } else { 0.0 };
        let inv_r = lit(1.0) / r;
        // No test sees the 2 halved: a direction that is turned moves the foot but once.
        let of_foot = lit(offset + 2.0 * direction + steps::NORMAL_FOOT) * l * inv_r;
        let normal_error = of_foot + lit(steps::CHORD_MIDDLE + direction);
        // No test sees it cut: close spheres, whose `t` is known better, are about as far away as they are large, and the rest of
        // a normal is granted more.
        let offset_error = lit(ROOM * eye.unit * offset) * l;
        let r2 = r * r;
        let width2 = outer2 - inner2;
        let least2 = (lit(LEAST) * r2).max(lit(LEAST_WIDTHS * ROOM) * width2);
        let far = F::FARTHEST;
        SphereRecord {
            center,
            inner2,
            outer2,
            slack,
            near_most,
            k: or(k, 0.0),
            k_error: or(k_error, 2.0 * far * far),
            is_close: or(R::select(is_close, lit(close), lit(0.0)), 0.0),
            // No test sees the 2 cut: a longer direction has a shorter root, for which the slack grants it.
            k_width: or(lit(eye.unit * (steps::RELATIVE + 2.0 * direction)), 1.0),
            inv_r: or(inv_r, 1.0),
            offset_error: or(offset_error, F::BEYOND),
            moved_error: or(
                lit(if eye.spread > 0.0 { 1.0 } else { 0.0 }) * offset_error,
                F::BEYOND,
            ),
            r2: or(r2, 0.0),
            least2: or(least2, far * far),
            of_chord: or(lit(ROOM * CHORD) * width2, far * far),
            normal_error: or(lit(ROOM * eye.unit) * normal_error, F::BEYOND),
        }
    }
}

/// Relative error of `k` that still lets nearly every `t` be rounded to f32. No bound: it weighs an
/// exact `k` once a sphere against an exact `t` for one ray in `2⁴²/2²⁸`.
const K_TOLERANCE: f64 = 1.0 / (1u64 << 42) as f64;

/// `k` with its exact sign, and what it is off by: in f64 where that tells it, else exactly and rounded once.
pub(super) fn k_of(center: DVec3, sphere: &Sphere, reference: DVec3) -> (f64, f64) {
    let (k, error) = bounds::k_in_f64(V3(center.to_array()), sphere.radius);
    if k != 0.0 && error <= K_TOLERANCE * k.abs() {
        return (k, error);
    }
    let ray = ExactRay::new(&crate::rays::WorldRay { origin: reference, direction: DVec3::X });
    match sphere_numbers(&ray, sphere) {
        Some(numbers) => {
            let k = match numbers.k.signum() {
                // The eye is on the sphere.
                0 => return (0.0, 0.0),
                // What is too small for f64 still has its sign.
                1 => numbers.k.to_f64().max(f64::MIN_POSITIVE),
                _ => numbers.k.to_f64(),
            };
            (k, f64::UNIT * k.abs() + f64::MIN_POSITIVE)
        }
        None => (f64::MAX, f64::MAX),
    }
}

/// `k` from where a ray starts.
#[inline(always)]
pub(super) fn k_from<R: Real>(seen: &SphereRecord<R>, l: V3<R>, ray: &Ray<R>) -> R {
    seen.k - ray.origin.dot(seen.center + l)
}

/// The line's point nearest to the centre: its `t`, the way from it to the centre, and by how much the square of its distance is below those of the two
/// radii.
struct Foot<R> {
    s: R,
    to_center: V3<R>,
    inner: R,
    outer: R,
}

impl<R: Real> Foot<R> {
    #[inline(always)]
    fn new(seen: &SphereLeaf<R>, l: V3<R>, ray: &Ray<R>) -> Foot<R> {
        let s = ray.direction.dot(l) * ray.inv_a;
        let to_center = l - ray.direction * s;
        let m = to_center.dot(to_center);
        Foot { s, to_center, inner: seen.inner2 - m, outer: seen.outer2 - m }
    }
}

/// Bounds of the near and the far end of a line's chord, and the half chords that they come from.
struct Chord<R> {
    half_inner: R,
    half_outer: R,
    near: Bounds<R>,
    far: Bounds<R>,
}

impl<R: Real> Chord<R> {
    #[inline(always)]
    fn new(seen: &SphereLeaf<R>, foot: &Foot<R>, ray: &Ray<R>) -> Chord<R> {
        let &Foot { s, inner, outer, .. } = foot;
        let zero = R::lit(0.0);
        let half_inner = (inner.max(zero) * ray.inv_a).sqrt();
        let half_outer = (outer.max(zero) * ray.inv_a).sqrt();
        Chord {
            half_inner,
            half_outer,
            near: Bounds {
                low: (s - half_outer) - seen.slack,
                high: ((s - half_inner) + seen.slack).min(seen.near_most),
            },
            far: Bounds { low: (s + half_inner) - seen.slack, high: (s + half_outer) + seen.slack },
        }
    }
}

/// Bounds of the root that a ray that hits sees.
struct Visible<R: Real> {
    t: Bounds<R>,
    /// Whether the ray surely starts outside, and surely inside or on it. Else nothing is known.
    outside: R::Mask,
    inside: R::Mask,
}

impl<R: Real> Visible<R> {
    /// By the roots' product, which is `k/a`: the one of `s ∓ h` that cancels is `k/a` over the other, off by as much as that
    /// relative to its size.
    ///
    /// From inside, where `s` is computed below 0 and is not, the root that is seen is `(|k|/a)/(h − s)`, and `h − s` is at least
    /// `|ŝ| + h_in` less the slack all the same, as that bounds `|ŝ − s|`.
    #[inline(always)]
    fn by_product(
        seen: &SphereRecord<R>,
        l: V3<R>,
        ray: &Ray<R>,
        foot: &Foot<R>,
        chord: &Chord<R>,
    ) -> Visible<R> {
        let (zero, one, beyond) = (R::lit(0.0), R::lit(1.0), R::lit(R::One::BEYOND));
        let &Chord { half_inner, half_outer, near, far } = chord;
        let s = foot.s;
        let k = k_from(seen, l, ray);
        let (outside, inside) = (seen.k_error.lt(k), k.le(-seen.k_error));
        let sum_low = (s.abs() + half_inner) - seen.slack;
        let sum_high = (s.abs() + half_outer) + seen.slack;
        // A visible root is positive. No quotient is larger than the bound beyond which nothing is known.
        let least_k = (k.abs() - seen.k_error).max(zero) * ray.inv_a;
        let most_k = (k.abs() + seen.k_error) * ray.inv_a;
        let per_beyond = R::lit(1.0 / R::One::BEYOND);
        let low_k = least_k / sum_high.max(least_k * per_beyond) * (one - seen.k_width);
        let least_sum = seen.slack.max(most_k * per_beyond);
        let high_k = most_k / sum_low.max(least_sum) * (one + seen.k_width);
        let high_k = R::select(least_sum.lt(sum_low), high_k, beyond);
        // From outside both roots have the sign of s; from inside the far one alone is positive.
        let low = R::select(outside, near.low.max(low_k), far.low.max(low_k));
        let from_inside = R::select(s.lt(zero), far.high.min(high_k), far.high);
        let high = R::select(outside, near.high.min(high_k), from_inside);
        let is_known = outside | inside;
        let low = R::select(is_known, low, zero);
        let high = R::select(is_known, high, beyond);
        Visible { t: Bounds { low, high }, outside, inside }
    }
}

impl ShapeRecord for SphereRecord<f64> {
    const CAN_BE_CLOSE: bool = true;

    fn is_close(&self) -> bool {
        self.is_close > 0.0
    }

    #[inline(always)]
    fn bounds<R: Real>(seen: &SphereRecord<R>, ray: &Ray<R>) -> Option<Bounds<R>> {
        seen.leaf().bounds(ray)
    }

    #[inline(always)]
    fn bounds_close<R: Real>(seen: &SphereRecord<R>, ray: &Ray<R>) -> Option<Bounds<R>> {
        let (zero, beyond) = (R::lit(0.0), R::lit(R::One::BEYOND));
        let l = seen.center - ray.origin;
        let foot = Foot::new(&seen.leaf(), l, ray);
        let Foot { s, inner, outer, .. } = foot;
        if !zero.le(outer).any() {
            return None;
        }
        let chord = Chord::new(&seen.leaf(), &foot, ray);
        let Visible { t, outside, inside } = Visible::by_product(seen, l, ray, &foot, &chord);
        // From an eye on the sphere the far root is `2s`.
        let on_surface = seen.k_error.le(zero);
        let is_missed = (outside & outer.lt(zero)) | ((outside | on_surface) & s.lt(-seen.slack));
        let is_behind = on_surface & s.le(seen.slack);
        let is_hit = (outside & zero.le(inner) & seen.slack.lt(s)) | (inside & !is_behind);
        Some(Bounds {
            low: R::select(is_missed, beyond, t.low),
            high: R::select(is_hit, t.high, beyond),
        })
    }

    /// `t = s ∓ h` and the normal `(∓P − h·d)/r`, with one root: [`crate::bounds::rows`].
    #[inline(always)]
    fn surface<R: Real>(
        seen: &SphereRecord<R>,
        ray: &Ray<R>,
        lengths: &SurfaceErrorTerms<R>,
    ) -> Surface<R> {
        let (zero, one, beyond) = (R::lit(0.0), R::lit(1.0), R::lit(R::One::BEYOND));
        let l = seen.center - ray.origin;
        let s = ray.direction.dot(l) * ray.inv_a;
        let p = l - ray.direction * s;
        let chord2 = seen.r2 - p.dot(p);
        let half = (chord2.max(zero) * ray.inv_a).sqrt();
        let k = k_from(seen, l, ray);
        let outside = seen.k_error.lt(k);
        let side = R::select(outside, -one, one);
        let inside = k.le(-seen.k_error);
        let is_known = seen.least2.le(chord2) & (outside | inside);
        let of_half = seen.of_chord / R::select(is_known, half, one);
        let or_beyond = |error: R| R::select(is_known, error, beyond);
        let t = s + half * side;
        let error = or_beyond(seen.slack + of_half);
        let radius = p * side - ray.direction * half;
        let normal_error = or_beyond(seen.normal_error + of_half * seen.inv_r);
        let point_error = lengths.longest * seen.slack
            + R::lit(ROOM) * of_half
            + (lengths.of_t * t + lengths.of_origin);
        Surface {
            t: Bounds { low: (t - error).max(zero), high: t + error },
            point: ray.origin + ray.direction * t,
            point_error: or_beyond(point_error),
            normal: radius * seen.inv_r,
            normal_error,
            component_error: V3([normal_error; 3]),
            front: outside,
        }
    }

    /// `t` by the roots' product, and the normal `(t·d − l)/r`, or as in [`ShapeRecord::surface`], whichever is known better.
    #[inline(always)]
    fn surface_close<R: Real>(
        seen: &SphereRecord<R>,
        ray: &Ray<R>,
        lengths: &SurfaceErrorTerms<R>,
    ) -> Surface<R> {
        let (half, room, beyond) = (R::lit(0.5), R::lit(ROOM), R::lit(R::One::BEYOND));
        let l = seen.center - ray.origin;
        let foot = Foot::new(&seen.leaf(), l, ray);
        let chord = Chord::new(&seen.leaf(), &foot, ray);
        let Visible { t, outside, inside } = Visible::by_product(seen, l, ray, &foot, &chord);
        let is_known = outside | inside;
        // Of what is not known each number is in range.
        let inv_r = R::select(is_known, seen.inv_r, R::lit(1.0));
        let (along, error) = Surface::along(t, ray, lengths);
        let point_error = (error + seen.offset_error) * inv_r + lengths.of_normal;
        let half_chord = (chord.half_inner + chord.half_outer) * half;
        let of_half = (chord.half_outer - chord.half_inner) * half * lengths.longest;
        let chord_error = seen.normal_error + of_half * inv_r;
        let chord_error = R::select(is_known, chord_error, beyond);
        let is_chord = chord_error.lt(point_error);
        let (p, outward) = (foot.to_center, along - l);
        let side = R::select(outside, R::lit(-1.0), R::lit(1.0));
        let by_chord = p * side - ray.direction * half_chord;
        let by_point = outward * -side;
        let normal = V3::select(is_chord, by_chord, by_point) * inv_r;
        let of_moved = error + seen.moved_error;
        // From the eye itself a component of `l` is but a difference that is rounded.
        let of_point = V3([of_moved; 3]) + l.abs() * lengths.rounding;
        let by_point = of_point * inv_r + normal.abs() * lengths.of_normal;
        let component_error = V3::select(is_chord, V3([chord_error; 3]), by_point) * room;
        Surface {
            t,
            point: ray.origin + along,
            point_error: error + lengths.of_origin,
            normal,
            normal_error: R::select(is_chord, chord_error, point_error) * room,
            component_error,
            front: outside,
        }
    }
}

record! {
    /// A sphere as shadow rays meet it.
    SphereOccluder {
        /// From the reference point.
        center: vec near,
        /// The sphere's radius.
        r: num near,
        /// What its place and its radius are off by, in units.
        place: num up,
    }
}

impl<F: Float> SphereOccluder<F> {
    /// A sphere from a reference point; all is left open where the range of `F` is left. No test sees the rounding of the radius
    /// left out: `OF_OFFSET` grants more of at least as long a way.
    #[inline(always)]
    pub fn new(sphere: &Sphere, reference: DVec3) -> SphereOccluder<F> {
        let (center, r) = (sphere.center - reference, sphere.radius.abs());
        let largest = center.abs().max_element();
        let smallest = 2.0 / F::LARGEST_ROOT;
        let is_in_range = r.max(largest) < F::LARGEST_ROOT;
        let met = if smallest <= r && is_in_range {
            let place = OF_PLACE * largest + F::ROUNDED * r;
            SphereOccluder { center: V3(center.to_array()), r, place }
        } else if is_in_range {
            // A ray that misses a larger sphere misses a tiny one. With an error of its radius, no point is surely inside.
            let place = OF_PLACE * largest + 2.0 * smallest / F::UNIT;
            SphereOccluder { center: V3(center.to_array()), r: smallest, place }
        } else {
            SphereOccluder { center: V3([0.0; 3]), r: 1.0, place: F::UNKNOWN / F::UNIT }
        };
        met.round()
    }
}

impl<R: Real> SphereOccluder<R> {
    /// Returns whether the sphere occludes a light for a shadow ray that does not start on it: [`super::shadow`] has the bounds. `side`
    /// is the side of a light that is close to the sphere ([`super::Contact`] has the derivation).
    #[inline(always)]
    pub fn occlude(&self, ray: &ShadowRay<R>, side: Option<R>) -> Occlusion<R> {
        let (lit, zero) = (R::lit, R::lit(0.0));
        let rounded = R::One::ROUNDED;
        let l = self.center - ray.start;
        let l2 = l.dot(l);
        let foot = (l.dot(ray.way) * ray.inv_square).max(zero).min(ray.last);
        let q = l - ray.way * foot;
        let distance = l2.sqrt();
        let here = ray.error + ray.unit * (self.place + lit(OF_OFFSET + rounded) * distance);
        let e = here + (ray.bend * distance).min(ray.end_error);
        let in_range = e.max(distance).lt(lit(R::One::LARGEST_ROOT));
        let e = R::select(in_range, e, lit(R::One::UNKNOWN));
        let least2 = q.dot(q);
        let (inner2, outer2) = squares(self.r, e);
        let end = l - ray.way;
        let end2 = end.dot(end).max(ray.end2);
        let (end_inner2, end_outer2) = squares(self.r, here + ray.end_error);
        let Some(side) = side else {
            let (end_inside, end_outside) = (end_inner2 - end2, end2 - end_outer2);
            return Occlusion {
                clear: (least2 - outer2).max(end_inside.min(inner2 - l2)),
                blocked: (inner2 - least2).min((l2 - outer2).max(end_outside)),
            };
        };
        let half = lit(0.5);
        let (along, along_error) = ray.along(end, here + ray.end_error);
        // Computed numbers come first: if one is NaN, then so is the minimum.
        let stays_inside = (inner2 - l2).min(half - side);
        let passes = (least2 - outer2).max(along - along_error).min(side + half);
        let leaves = (-along - along_error).min(half - side.abs());
        let crosses = (inner2 - least2).max(leaves).max(-side - half);
        Occlusion {
            clear: passes.max(stays_inside),
            blocked: crosses.min((l2 - outer2).max(side - half)),
        }
    }
}

/// Squares of `r − e`, −1 where that is negative, and of `r + e`: what a squared distance must be below, or above, to be
/// surely inside, or outside.
#[inline(always)]
fn squares<R: Real>(r: R, e: R) -> (R, R) {
    let (lit, relative) = (R::lit, OF_SQUARES * R::One::UNIT);
    let (inner, outer) = (r - e, r + e);
    let inner2 = inner * inner * lit(1.0 - relative);
    let inner2 = R::select(lit(0.0).lt(inner), inner2, lit(-1.0));
    (inner2, outer * outer * lit(1.0 + relative))
}
