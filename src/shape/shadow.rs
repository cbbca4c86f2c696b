//! The way from a point of a surface to a light, with bounds: how steep the light falls, and what is in its way.
//!
//! # What is in the way
//! The true shadow ray is `p + s·w`, `0 < s < 1`, or `0 < s` for a sun. The computed one lies within `E` of it,
//! point by point, where `E` bounds what both ends, the object's place and the operations are off by.
//! So distances from a centre along it are off by at most `E`, and with `q(s)` the computed distance,
//! `q₀` and `q₁` at its ends and `q_min` the least of all:
//! - `q_min > r + E`: nothing is in the way.
//! - `q₀ < r − E` and `q₁ < r − E`: a ball is convex, the ray stays inside, nothing is in the way.
//! - one of `q₀`, `q₁`, `q_min` is below `r − E` and one of `q₀`, `q₁` above `r + E`: the ray goes
//!   through the surface, and it is in the way. A sun's ray ends beyond everything: `q₁²` is the largest number.
//! - else it is open.
//!
//! With the unit `ε` of [`Float`], and `l` the computed offset of the centre `c` from `p`
//! (both relative to the reference point), `E` sums up:
//! - the point's own error, which at the far end is the same or less;
//! - `ε|c|` and `ε|L|` for the differences of centre and light to the reference point, `ε|w|` for
//!   `w = L − p`, `ε|l|` for `l = c − p`;
//! - `q = l − s·w`: the product is off by `ε|s·w|`, the difference by `ε|q|`, and `|s·w|` is at most
//!   `|l|` at the foot and `|w|` at the end: `2ε(|l| + |w|)`;
//! - `s` itself, at the foot, by `9.51ε|l|/|w|` (step 2 of [`crate::bounds`]): what it moves along the
//!   ray, up to `9.51ε|l|`, lengthens `q_min` by no more.
//!
//! In all `e + ε(|c| + |L| + 3|w| + 13|l|)`; 14 and 4 leave room for the rounding of the sum itself. The
//! square of a distance is off by `3ε` of it, that of `r ± E` by `3ε`: `OF_SQUARES` is more than both, and one for the
//! factor that has it.
//!
//! # Far lights
//! The error `b = ε(|L| + 5|w|)` of the end is `s·b` at `s`. At the foot `s ≤ 1.01|l|/|w|`. Farther on, at
//! `s + x`, the distance of the ray from the center is `√(q² + x²|w|²)`, its error is larger by `x·b`, and the least difference of both
//! is `q√(1 − (b/|w|)²)`. A ray is used only if `4(e + ε(|L| + |w|)) < |w|`. Then `b ≤ |w|/4 + 4ε|w| ≤ 0.2501|w|`, and the difference is
//! `q`, less at most `0.52(b/|w|)²q ≤ 0.131·b|l|/|w|`. So for every distance except `q₁`, `b` counts with `(1.01 + 0.131)|l|/|w|`.
//! `OF_LEVER` is more, and it applies if that is less than 1. The occlusion by an object near a point is known as well
//! for a light at a distance of `10²⁵` as for a near one.
//!
//! # Boxes
//! At `s` the error of the computed way is at most the error `e` of its start and `s·b`. Let the true way be in a box at the point `x`,
//! relative to the reference point. Then `s ≤ (|x| + |p|)/|w|`, with the true start `p` and `|p| ≤ |p̂| + e`.
//! - If `off < 2⁻¹⁰|ŵ|`, then `|w| ≥ 0.999|ŵ|`, and `s·b` is at most `1.002·b(|x| + |p̂| + e)/|ŵ|`; `OF_LEVER` is more.
//! - If `off` is larger, it is nearly all error of the start: `b < 7ε|ŵ|` for a far light ([`BEND_IN_BOXES`]), so that `b` is less than
//!   1 % of the error.
//!
//! The term with `|x|` is in the boxes, which are wider, and the term with `|p̂|` is a slack of the ray. For a near light the slack is `b`.
//!
//! # In f32
//! There operations take whole units, and numbers are rounded that come from f64 ([`Float`]), by ½: `c` and `L`,
//! for which the `ε` of their differences stands; `r`, with `½εr` more in `E`; a sun's direction, which turns its ray by `ε`
//! at most and moves it by `½ε|l|` up to the foot ([`Float::near_or_least`] adds `2⁻¹⁰⁰`); a plane's normal, with `½ε|n|` times `|l|`, `|w|` or both. So with
//! [`Float::ROUNDED`] units more for each, and `OF_PLANE` and `OF_SLOPE` with as much again for what f64 has by its larger
//! unit: at a plane's end `|l| + 4|l − w|`, with the normal `|l| + 4.5|l − w|`.
//!
//! # Balls
//! Points about a middle are as one point that is off by as much as they are apart. What is surely not in the way of its ray
//! is in the way of none of theirs, and what surely is, is in that of all that don't start on it.

use glam::DVec3;

use crate::bounds::{ROOM, length_bound, steps};
use crate::num::fields::numbers;
use crate::num::{Float, Real, V3};

/// What a squared distance and the square that it is compared with are off by together, in units. No test sees it cut: as a
/// length it is less than a third of what [`OF_OFFSET`] grants, as no object is farther from a ray than from the ray's start.
pub(crate) const OF_SQUARES: f64 = 8.0;

/// Factor of `|w|` in `E`, in units. No test sees it cut: either `l` is about as long as `w`, and [`OF_OFFSET`] grants more, or
/// the object lies about the start, and its place or the light's is as far from the reference point.
pub(crate) const OF_WAY: f64 = 4.0;

/// Factor of `|l|/|w|` in the share of a ray's end in `E`.
pub(crate) const OF_LEVER: f64 = 1.2;

/// Largest bend of the way to a far light, in units: boxes are wider by this part of their distance. A light is far if its distance from
/// the point is at least 0.61 of its distance from the reference point. Halving it is not covered by a test: outward rounding of
/// the sides and the slack of the start hide it.
pub const BEND_IN_BOXES: f64 = 8.0;

/// Factor of `|l|` in `E`, in units.
pub(crate) const OF_OFFSET: f64 = 14.0;

/// Factor of the largest component of `c` in `E`, in units: `√3` and room.
pub(crate) const OF_PLACE: f64 = 1.75;

/// Factor of `|l| + |w|` in the `E` of a plane, in units.
pub(crate) const OF_PLANE: f64 = 5.0;

/// Factor of `|n||w|` in the error of `n·w`, in units.
pub(crate) const OF_SLOPE: f64 = 4.0;

/// Error of `n·ω`, in units: three roundings of a dot product of vectors of length 1, `1/√(w·w)` with 3/2 + 4.5 + 2.5, the
/// product with that and the sum with its error.
pub const OF_COSINE: f64 = 14.0;
const _: () = assert!(steps::DOT + (3.0 / 2.0 + 4.5 + 2.5) + 1.0 + 1.0 < OF_COSINE);

/// Factor of `ρ = |w − ŵ|/|ŵ|` in the angle that a way is turned by: up to ¼ it is at most `asin ρ`.
pub(crate) const OF_TURN: f64 = 1.02;

/// How many times what a way's end is off by the way is long, at least: what is granted for it holds up to there.
const APART: f64 = 4.0;

/// Where light comes from, relative to the reference point.
#[derive(Clone, Copy, Debug)]
pub enum Origin {
    /// A point.
    Point(DVec3),
    /// A sun: the direction that its light travels, with a largest component from 1 to 2.
    Sun(DVec3),
}

/// The numbers of an [`Origin`], without a branch between points and suns.
#[derive(Clone, Copy, Debug)]
pub struct Aim<R> {
    /// 1 for a point, 0 for a sun.
    from_point: R,
    /// The point, or the way to a sun.
    to: V3<R>,
    /// At least the length of that of a point, else 0.
    away: R,
    /// What a sun's way is turned by.
    turned: R,
    /// Where a ray ends, in lengths of its way,
    last: R,
    /// and the least that the square of its end's distance is.
    end2: R,
}

numbers! { Aim { from_point: num, to: vec, away: num, turned: num, last: num, end2: num } }

impl<R: Real> Aim<R> {
    /// At a light.
    pub fn new(origin: Origin) -> Aim<R> {
        let lit = R::lit;
        let [one, zero, largest] = [1.0, 0.0, R::One::LARGEST].map(lit);
        match origin {
            Origin::Point(to) => {
                let (to, away) = (V3::lit(to), lit(ROOM * length_bound(to)));
                Aim { from_point: one, to, away, turned: zero, last: one, end2: zero }
            }
            Origin::Sun(direction) => Aim {
                from_point: zero,
                to: V3((-direction).to_array().map(|x| R::splat(R::One::near_or_least(x)))),
                away: zero,
                // No test sees it cut: [`OF_COSINE`] grants more.
                turned: lit(2.0 * R::One::ROUNDED * R::One::UNIT),
                last: largest,
                end2: largest,
            },
        }
    }
}

/// The way from a point to a light; or several side by side.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRay<R> {
    /// Where it starts, relative to the reference point.
    pub start: V3<R>,
    /// To the light; of any length for a sun.
    pub way: V3<R>,
    /// `|w|`
    pub(super) length: R,
    /// `1/(w·w)`
    pub(super) inv_square: R,
    /// `1/|w|`
    inv_length: R,
    /// The part of `E` that is the same for all objects, and all along.
    pub(super) error: R,
    /// What its end is off by beside that; 0 where it goes on for ever.
    pub(super) end_error: R,
    /// What that is at an object, for each unit of the object's distance from the start.
    pub(super) bend: R,
    /// 1 where it ends, 0 where it goes on for ever.
    pub(super) from_point: R,
    /// Where it ends, in lengths of the way.
    pub last: R,
    /// The least that the square of its end's distance is.
    pub(super) end2: R,
    /// Bound of the angle between the true and the computed way.
    turned: R,
    /// `ε`; the tests cut it.
    pub(super) unit: R,
}

numbers! {
    ShadowRay {
        start: vec, way: vec, length: num, inv_square: num, inv_length: num, error: num, end_error: num, bend: num,
        from_point: num, last: num, end2: num, turned: num, unit: num,
    }
}

/// Whether an object is in the way: surely, and surely not, each where the number is positive. What is neither is open.
///
/// Masks that are combined fall apart into single bits; numbers stay side by side.
#[derive(Clone, Copy, Debug)]
pub struct Occlusion<R> {
    /// Surely in the way.
    pub blocked: R,
    /// Surely not.
    pub clear: R,
}

numbers! { Occlusion { blocked: num, clear: num } }

impl<R: Real> Occlusion<R> {
    /// Nothing is in the way.
    #[inline(always)]
    pub fn none() -> Occlusion<R> {
        Occlusion { blocked: R::lit(-1.0), clear: R::lit(1.0) }
    }

    /// Something is surely in the way.
    #[inline(always)]
    pub fn dark() -> Occlusion<R> {
        Occlusion { blocked: R::lit(1.0), clear: R::lit(-1.0) }
    }

    /// `yes` where the mask holds, `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Occlusion<R>, no: Occlusion<R>) -> Occlusion<R> {
        Occlusion {
            blocked: R::select(mask, yes.blocked, no.blocked),
            clear: R::select(mask, yes.clear, no.clear),
        }
    }

    /// With one more object. What is not a number says nothing.
    #[inline(always)]
    pub fn with(self, next: Occlusion<R>) -> Occlusion<R> {
        let (zero, one) = (R::lit(0.0), R::lit(1.0));
        Occlusion {
            blocked: R::select(zero.lt(next.blocked), one, self.blocked),
            clear: R::select(zero.lt(next.clear), self.clear, -one),
        }
    }
}

impl Occlusion<f64> {
    /// Whether it is surely in the way.
    #[inline(always)]
    pub fn is_blocked(self) -> bool {
        self.blocked > 0.0
    }

    /// Whether it is surely not.
    #[inline(always)]
    pub fn is_clear(self) -> bool {
        self.clear > 0.0
    }
}

impl<R: Real> ShadowRay<R> {
    /// From a point that is off by `error`. Where the light is too close to it, nothing is known.
    #[inline(always)]
    pub fn new(aim: &Aim<R>, start: V3<R>, error: R) -> ShadowRay<R> {
        let lit = R::lit;
        let (unit, unknown) = (lit(R::One::UNIT), lit(R::One::UNKNOWN));
        let most2 = R::One::LARGEST_ROOT * R::One::LARGEST_ROOT;
        let (least2, most2) = (lit(1.0 / most2), lit(most2));
        let way = aim.to - start * aim.from_point;
        let way2 = way.dot(way);
        let square = way2.max(least2);
        let length = square.sqrt();
        let inv_length = lit(1.0) / length;
        let off = (error + unit * (aim.away + length)) * aim.from_point;
        let is_far = least2.lt(way2) & way2.lt(most2);
        let is_apart = (lit(APART) * off).lt(length) & is_far;
        // No test sees the 1 cut, as little as `OF_WAY`.
        let end_error = unit * (aim.away + lit(1.0 + OF_WAY) * length) * aim.from_point;
        let turned = lit(OF_TURN) * R::select(is_apart, off, lit(0.0)) * inv_length;
        ShadowRay {
            start,
            way,
            length,
            inv_square: lit(1.0) / square,
            inv_length,
            error: R::select(is_apart, error.min(unknown), unknown),
            end_error,
            bend: lit(OF_LEVER) * end_error * inv_length,
            from_point: aim.from_point,
            last: aim.last,
            end2: aim.end2,
            turned: R::select(is_apart, turned, unknown) + aim.turned,
            unit,
        }
    }

    /// Upper bound of the distance between the true way and this one up to a box, except for the rounding of a sun's direction and
    /// for `BEND_IN_BOXES` units of the distance of the box's farthest corner from the reference point, which the boxes contain.
    #[inline(always)]
    #[track_caller]
    pub fn beside(&self) -> R {
        let V3([x, y, z]) = self.start.abs();
        // √3 and room.
        let start = x.max(y).max(z) * R::lit(OF_PLACE);
        let is_far = self.bend.le(R::lit(BEND_IN_BOXES) * self.unit);
        let of_end = R::select(is_far, (self.bend * start).min(self.end_error), self.end_error);
        R::lit(ROOM) * (self.error + of_end)
    }

    /// Returns `v·ω` for a vector with this error, and the error of the product.
    #[inline(always)]
    pub(super) fn along(&self, v: V3<R>, error: R) -> (R, R) {
        let (lit, length) = (R::lit, v.dot(v).sqrt());
        let rounding = lit((OF_COSINE + 2.0 * R::One::ROUNDED) * R::One::UNIT) * length;
        let along_error = lit(ROOM) * (error + (length + error) * self.turned) + rounding;
        (v.dot(self.way) * self.inv_length, along_error)
    }

    /// Bounds of `n·ω` for a unit normal that is off by `normal_error`. Both are 0 where it is certain not
    /// to be positive.
    #[inline(always)]
    pub fn cosine(&self, normal: V3<R>, normal_error: R) -> (R, R) {
        let (lit, zero, one) = (R::lit, R::lit(0.0), R::lit(1.0));
        let cosine = normal.dot(self.way) * self.inv_length;
        // No test sees the 2 cut: in f32 `turned` and the normal's error grant them, too.
        let rounding = (OF_COSINE + 2.0 * R::One::ROUNDED) * R::One::UNIT;
        let error = lit(ROOM) * (normal_error + self.turned) + lit(rounding);
        // What is not a number says nothing.
        let (low, high) = (cosine - error, cosine + error);
        let high = R::select(high.lt(one), high, one);
        (zero.max(low), zero.max(high))
    }
}

#[cfg(test)]
mod tests;
