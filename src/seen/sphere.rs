//! Spheres. The formula starts from the point of the line closest to the centre: an error of its place counts only squared,
//! as it is moved across the way to the centre. [`crate::guard`] has the bounds.

use super::{Bounds, Eye, Ray, Seen, record};
use glam::DVec3;

use crate::exact::{ExactRay, sphere_numbers};
use crate::guard::{self, Guard, ROOM, length_bound, steps};
use crate::num::{Float, Mask, Real, V3};
use crate::scene::Sphere;

record! {
    /// A sphere as an eye sees it.
    SphereSeen {
        /// From the eye's reference point.
        center: vec near,
        /// [`Guard::inner2`]
        inner2: num down,
        /// [`Guard::outer2`]
        outer2: num up,
        /// [`Guard::slack`]
        slack: num up,
        /// Most that the near root can be: 0 where the eye is inside or on the sphere.
        near_most: num up,
        /// `|c|² − r²`
        k: num near,
        /// What it is off by, anywhere within the eye's spread.
        k_error: num up,
        /// 1 where the eye is so close to the surface of so large a sphere that `k` is needed for `t`.
        is_close: num near,
        /// What `k/a` over a root is off by, relative.
        k_width: num up,
    }
}

/// Part of a distance that a sphere's surface is closer than to the eye, where its size hides its distance. No bound: it
/// weighs a quotient against a slack.
const CLOSE: f64 = 1.0 / 512.0;

impl SphereSeen<f64> {
    /// With bounds for arithmetic of `F`; all is left open where its range is left.
    pub fn new<F: Float>(sphere: &Sphere, eye: &Eye) -> SphereSeen<f64> {
        let (r, center) = (sphere.radius.abs(), sphere.center - eye.reference);
        let from_reference = length_bound(center);
        let l = from_reference + eye.spread;
        if !(l <= F::FARTHEST && r <= F::FARTHEST && r >= F::SMALLEST) {
            let far = F::FARTHEST;
            return SphereSeen {
                center: V3::default(),
                inner2: -1.0,
                outer2: far * far,
                slack: far,
                near_most: F::BEYOND,
                k: 0.0,
                k_error: far,
                is_close: 0.0,
                k_width: 1.0,
            };
        }
        let input = eye.reach.widen(eye.input, l);
        let Guard { inner2, outer2, slack, .. } = Guard::new(r, l, F::UNIT, input);
        let (k, error, is_outside) = k_of(center, sphere, eye);
        // Rounded, and moved to an origin: o·(c + l) is off by 20 units of |o|ℓ, with o and l themselves.
        let k_error = error + ROOM * F::UNIT * (k.abs() + 20.0 * eye.spread * l);
        // Origins that are apart change k itself.
        let is_close = (from_reference - r).abs() <= CLOSE * l && eye.reach.apart == 0.0;
        SphereSeen {
            center: V3(center.to_array()),
            inner2,
            outer2,
            slack,
            near_most: if !is_outside && eye.spread == 0.0 { 0.0 } else { F::BEYOND },
            k,
            k_error,
            is_close: f64::from(u8::from(is_close)),
            k_width: F::UNIT * (steps::RELATIVE + 2.0 * input.direction),
        }
    }
}

/// `k`, what it is off by, and its exact sign: in f64 where that tells it, else exactly and rounded once.
fn k_of(center: DVec3, sphere: &Sphere, eye: &Eye) -> (f64, f64, bool) {
    if let Some((k, error)) = guard::k_f64(center, sphere.radius) {
        return (k, error, k > 0.0);
    }
    let ray = ExactRay::new(&crate::rays::Ray { origin: eye.reference, direction: DVec3::X });
    match sphere_numbers(&ray, sphere.center, sphere.radius) {
        Some(numbers) => {
            let k = numbers.k.to_f64();
            (k, f64::EPSILON * k.abs() + f64::MIN_POSITIVE, numbers.k.signum() > 0)
        }
        None => (0.0, f64::MAX, true),
    }
}

/// Bounds of the near and the far end of a line's chord, and the half chords that they come from.
struct Chord<R> {
    s: R,
    inner: R,
    outer: R,
    half_inner: R,
    half_outer: R,
    near: Bounds<R>,
    far: Bounds<R>,
}

/// `None` where surely no lane hits.
#[inline(always)]
fn chord<R: Real>(seen: &SphereSeen<R>, l: V3<R>, ray: &Ray<R>) -> Option<Chord<R>> {
    let zero = R::lit(0.0);
    let s = ray.direction.dot(l) * ray.inv_a;
    let foot = l - ray.direction * s;
    let m = foot.dot(foot);
    let (inner, outer) = (seen.inner2 - m, seen.outer2 - m);
    if !zero.le(outer).any() {
        return None;
    }
    let half_inner = (inner.max(zero) * ray.inv_a).sqrt();
    let half_outer = (outer.max(zero) * ray.inv_a).sqrt();
    let near = Bounds {
        low: (s - half_outer) - seen.slack,
        high: ((s - half_inner) + seen.slack).min(seen.near_most),
    };
    let far = Bounds { low: (s + half_inner) - seen.slack, high: (s + half_outer) + seen.slack };
    Some(Chord { s, inner, outer, half_inner, half_outer, near, far })
}

/// Bounds of the visible root by the roots' product, which is `k/a`: the one of `s ∓ h` that cancels is `k/a` over
/// the other, off by as much as that relative to its size.
#[inline(always)]
fn visible_by_product<R: Real>(
    seen: &SphereSeen<R>,
    l: V3<R>,
    ray: &Ray<R>,
    chord: &Chord<R>,
) -> Bounds<R> {
    let (zero, one, beyond) = (R::lit(0.0), R::lit(1.0), R::lit(R::One::BEYOND));
    let &Chord { s, inner, outer, half_inner, half_outer, near, far } = chord;
    let k = seen.k - ray.origin.dot(seen.center + l);
    let (outside, inside) = (seen.k_error.lt(k), k.lt(-seen.k_error));
    let sum_low = (s.abs() + half_inner) - seen.slack;
    let sum_high = (s.abs() + half_outer) + seen.slack;
    let low_k = ((k.abs() - seen.k_error) * ray.inv_a) / sum_high * (one - seen.k_width);
    let high_k =
        ((k.abs() + seen.k_error) * ray.inv_a) / sum_low.max(seen.slack) * (one + seen.k_width);
    let high_k = R::select(seen.slack.lt(sum_low), high_k, beyond);
    // From outside both roots have the sign of s; from inside the far one alone is positive.
    let is_missed = outside.and(outer.lt(zero).or(s.lt(-seen.slack)));
    let is_hit = outside.and(zero.le(inner)).and(seen.slack.lt(s)).or(inside);
    let low = R::select(outside, near.low.max(low_k), far.low.max(low_k));
    let from_inside = R::select(s.lt(zero), far.high.min(high_k), far.high);
    let high = R::select(outside, near.high.min(high_k), from_inside);
    let low = R::select(outside.or(inside), low, zero);
    Bounds { low: R::select(is_missed, beyond, low), high: R::select(is_hit, high, beyond) }
}

impl Seen for SphereSeen<f64> {
    fn is_close(&self) -> bool {
        self.is_close > 0.0
    }

    #[inline(always)]
    fn bounds<R: Real>(seen: &SphereSeen<R>, ray: &Ray<R>) -> Option<Bounds<R>> {
        let (zero, beyond) = (R::lit(0.0), R::lit(R::One::BEYOND));
        let Chord { inner, outer, near, far, .. } = chord(seen, seen.center - ray.origin, ray)?;
        let low = R::select(near.high.le(zero), far.low, near.low);
        let high = R::select(zero.lt(near.low), near.high, far.high);
        let is_missed = outer.lt(zero).or(far.high.le(zero));
        let is_hit = zero.le(inner).and(zero.lt(far.low));
        Some(Bounds {
            low: R::select(is_missed, beyond, low),
            high: R::select(is_hit, high, beyond),
        })
    }

    #[inline(always)]
    fn bounds_close<R: Real>(seen: &SphereSeen<R>, ray: &Ray<R>) -> Option<Bounds<R>> {
        let l = seen.center - ray.origin;
        let chord = chord(seen, l, ray)?;
        Some(visible_by_product(seen, l, ray, &chord))
    }
}
