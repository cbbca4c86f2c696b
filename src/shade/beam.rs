//! The way from a point to a lamp in f64 or f32, with bounds: how steep the light falls, and what is in its
//! way.
//!
//! # What is in the way of a beam
//! The true beam is `p + s·w`, `0 < s < 1`, or `0 < s` for a sun. The computed one lies within `E` of it,
//! point by point, where `E` bounds what both ends, the object's place and the operations are off by.
//! So distances from a centre along it are off by at most `E`, and with `q(s)` the computed distance,
//! `q₀` and `q₁` at its ends and `q_min` the least of all:
//! - `q_min > r + E`: nothing is in the way.
//! - `q₀ < r − E` and `q₁ < r − E`: a ball is convex, the beam stays inside, nothing is in the way.
//! - one of `q₀`, `q₁`, `q_min` is below `r − E` and one of `q₀`, `q₁` above `r + E`: the beam goes
//!   through the surface, and it is in the way. A sun's beam ends beyond everything: `q₁ = ∞`.
//! - else it is open.
//!
//! With `ε = 2⁻⁵²`, the unit of [`crate::guard`], and `l` the computed offset of the centre `c` from `p`
//! (both relative to the reference point), `E` sums up:
//! - the point's own error, which at the far end is the same or less;
//! - `ε|c|` and `ε|L|` for the differences of centre and light to the reference point, `ε|w|` for
//!   `w = L − p`, `ε|l|` for `l = c − p`;
//! - `q = l − s·w`: the product is off by `ε|s·w|`, the difference by `ε|q|`, and `|s·w|` is at most
//!   `|l|` at the foot and `|w|` at the end: `2ε(|l| + |w|)`;
//! - `s` itself, at the foot, by `9.51ε|l|/|w|` (step 2 of [`crate::guard`]): what it moves along the
//!   beam, up to `9.51ε|l|`, lengthens `q_min` by no more.
//!
//! In all `e + ε(|c| + |L| + 3|w| + 13|l|)`; 14 and 4 leave room for the rounding of the sum itself. The
//! square of a distance is off by `3ε` of it, that of `r ± E` by `3ε`: [`OF_SQUARES`] is more than both, and one for the
//! factor that has it.
//!
//! # Far lamps
//! What is `b = ε(|L| + 4|w|)` at the beam's end is `s·b` on the way there. At the foot `s ≤ 1.01|l|/|w|`. Farther on, at
//! `s + x`, the beam is `√(q² + x²|w|²)` from the centre and off by `x·b` more, of which the least difference is
//! `q√(1 − (b/|w|)²)`. As a beam is used where `b ≤ |w|/4` alone, that is `q` less at most `0.52(b/|w|)²q ≤ 0.13·b|l|/|w|`. So but
//! for `q₁`, `b` counts with `1.2|l|/|w|`, [`OF_LEVER`], where that is less than 1. An object near a point is so judged as
//! well whether its lamp is near or `10²⁵` away.
//!
//! # In f32
//! There the unit is what rounding to nearest takes, and numbers are rounded that come from f64 ([`Bounded`]): `c` and `L`,
//! for which the `ε` of their differences stands; `r`, with `εr` more in `E`; a sun's direction, which turns its beam by `ε`
//! at most and moves it by `ε|l|` up to the foot; a plane's normal, with `ε|n|` times `|l|`, `|w|` or both. So with
//! [`Bounded::ROUNDED`] units more for each, and [`OF_PLANE`] and [`OF_SLOPE`] with one more for what f64 has by its larger unit: at a
//! plane's end `|l| + 4|l − w|`, with the normal `|l| + 5|l − w|`.
//!
//! # Shells
//! Where the beam starts on a sphere `(c₁, r₁)` and this one is nearly the same, `|p − c|² − r²` is known much better than
//! from a distance: with `a = c₁ − c` and `v = p − c₁`, whose length is `r₁` exactly, it is
//! `(r₁ − r)(r₁ + r) + a·(a + 2v)`. Its errors are `2|a|E` for `v`, with the place of `c₁` in `E`, and in units `ε`: 3 of the
//! first product; of `|a|(|a| + 2|v|)` 2 for `a`, 1 for the difference in `v`, 1 for `a + 2v` and 3 for the dot product; and of
//! both 1 for the sum: less than [`OF_SHELL`]. So a beam surely starts outside or inside:
//! - from inside, it is in the way where its end is outside, and not where its end is inside;
//! - from outside, it is not in the way if the beam leaves: `l·w < 0`, which is off by `E|w|`, where `14ε|l|` is more than the
//!   `3ε|l|` of the dot product, and by `|l|` times what the ends of `w` are off, `2E`.

use crate::guard::host::Bounded;
use crate::guard::{ROOM, UNIT_F64, steps};
use crate::vec3::{Real, Vec3, dot3};
use crate::wide::{Holds, SideBySide};

/// What a squared distance and the square that it is compared with are off by together, in units.
const OF_SQUARES: f64 = 8.0;

/// The same in f64.
const RELATIVE: f64 = OF_SQUARES * UNIT_F64;

/// Numbers up to this and above its inverse have squares in range.
pub const LARGEST: f64 = f64::LARGEST_ROOT;

/// Of `|w|` in `E`.
const OF_WAY: f64 = 4.0;

/// Of `|l|/|w|` in the share of a beam's end in `E`.
const OF_LEVER: f64 = 1.2;

/// Of `|l|` in `E`.
const OF_OFFSET: f64 = 14.0;

/// Of the largest component of `c` in `E`: `√3` and room.
const OF_PLACE: f64 = 1.75;

/// Of `|l| + |w|` in the `E` of a plane.
const OF_PLANE: f64 = 5.0;

/// Of `|n||w|` in the error of `n·w`.
const OF_SLOPE: f64 = 4.0;

/// Of the parts of the side of a shell on which a beam starts.
const OF_SHELL: f64 = 9.0;

/// Of `n·ω`: three roundings of a dot product of vectors of length 1, and
/// [`crate::guard::steps::NORMALIZED`] of one of them.
const OF_COSINE: f64 = 8.0;
const _: () = assert!(steps::DOT + steps::NORMALIZED < OF_COSINE);

/// The same on a device, where division and root are not as good.
#[cfg(feature = "gpu")]
const OF_COSINE_WIDE: f64 = 13.0;
#[cfg(feature = "gpu")]
const _: () = assert!(steps::DOT + steps::NORMALIZED_WIDE < OF_COSINE_WIDE);

/// Of `ρ = |w − ŵ|/|ŵ|` in the angle that a way is turned by: up to ¼ it is at most `asin ρ`.
const OF_TURN: f64 = 1.02;

/// The constants of the twin in `shaders/beam.wgsl`, by their names there. A device rounds each sum and
/// product to nearest as the host does. Its roots are parts of bounds alone, and its division is off by up
/// to 2.5 units where the host's is by a half: step 2 of [`crate::guard`] has room for that, and so has
/// [`ROOM`]. Only the cosine has a bound of its own.
#[cfg(feature = "gpu")]
pub const FOR_DEVICE: [(&str, f64); 11] = [
    ("RELATIVE", RELATIVE),
    ("BEYOND", LARGEST),
    ("NEGLIGIBLE", 1.0 / LARGEST),
    ("OF_WAY", OF_WAY),
    ("OF_OFFSET", OF_OFFSET),
    ("OF_PLACE", OF_PLACE),
    ("OF_PLANE", OF_PLANE),
    ("OF_SLOPE", OF_SLOPE),
    ("OF_SHELL", OF_SHELL),
    ("OF_COSINE", OF_COSINE_WIDE),
    ("OF_TURN", OF_TURN),
];

/// The same where the twin is in f32, for [`Beam::to_point`], [`Beam::to_eye`], [`Beam::to_sun`] and [`Beam::cosine`], whose
/// errors are those of f64 in another unit:
/// - The host rounds a lamp's place once, half a unit of the `ε|L|` that are granted, and a sun's direction, half a unit
///   more in its cosine. The cosine's bounds are a sum, 1 more.
/// - What is in a beam's way [`super::narrow`] finds, with constants of its own for `|w|`.
/// - Places and lamps that f32 has are below `2⁶⁰`; others are put beyond it, and their beams know nothing.
#[cfg(feature = "gpu")]
pub const FOR_DEVICE_IN_F32: [(&str, f64); 6] = [
    ("BEYOND", LARGEST_IN_F32),
    ("NEGLIGIBLE", 1.0 / LARGEST_IN_F32),
    ("OF_WAY", 0.0),
    ("OF_PLACE", OF_PLACE),
    ("OF_COSINE", OF_COSINE_IN_F32),
    ("OF_TURN", OF_TURN),
];

/// Largest place that a device has in f32.
pub const LARGEST_IN_F32: f64 = (1u64 << 60) as f64;

#[cfg(feature = "gpu")]
const OF_COSINE_IN_F32: f64 = 14.5;
#[cfg(feature = "gpu")]
const _: () = assert!(steps::DOT + steps::NORMALIZED_WIDE + 0.501 + 1.0 < OF_COSINE_IN_F32);

/// What is known of an object in the way, as numbers of which the largest wins.
pub mod in_the_way {
    /// It is not.
    pub const NO: f64 = 0.0;
    /// It is or it is not.
    pub const OPEN: f64 = 1.0;
    /// It is.
    pub const YES: f64 = 2.0;
}

/// The way from a point to a lamp; or several ways side by side.
#[derive(Clone, Copy, Debug)]
pub struct Beam<R = f64> {
    /// Where it starts, relative to the reference point.
    pub from: Vec3<R>,
    /// To the lamp; of any length for a sun.
    pub way: Vec3<R>,
    /// `way·way`
    pub square: R,
    /// `1/(way·way)`
    pub inverse: R,
    /// `1/|way|`
    pub inverse_length: R,
    /// The part of `E` that is the same for all objects, and all along.
    pub error: R,
    /// What its end is off by beside that; 0 where it goes on for ever.
    pub end_error: R,
    /// What that is at an object, for each unit of the object's distance from the start.
    pub bend: R,
    /// Whether it goes on for ever.
    pub is_endless: bool,
    /// Bound of the angle between the true and the computed way.
    pub turned: R,
    /// `ε`; the tests cut it.
    pub unit: f64,
}

/// At least the length of a vector, but for rounding: where its squares underflow, it is below the inverse of the
/// largest number whose square is in range.
#[inline(always)]
fn length_of<R: SideBySide<Plain: Bounded>>(v: Vec3<R>) -> R {
    let square = dot3(v, v);
    square.sqrt().max(likes(square)(1.0 / R::Plain::LARGEST_ROOT))
}

/// What puts the nearest number in all places.
#[inline(always)]
fn likes<R: SideBySide>(some: R) -> impl Fn(f64) -> R {
    move |number| some.like(R::Plain::from_f64(number))
}

#[inline(always)]
fn like3<R: SideBySide>(some: R, v: Vec3<f64>) -> Vec3<R> {
    let (like, Vec3([x, y, z])) = (likes(some), v);
    Vec3([like(x), like(y), like(z)])
}

/// Squares of `r − e`, −1 where that is negative, and of `r + e`: what a squared distance must be below, or above, to be
/// surely inside, or outside.
#[inline(always)]
fn squares<R: SideBySide<Plain: Bounded>>(r: R, e: R) -> (R, R) {
    let (like, relative) = (likes(r), OF_SQUARES * R::Plain::UNIT);
    let (inner, outer) = (r - e, r + e);
    let inner2 = inner * inner * like(1.0 - relative);
    (R::select(like(0.0).lt(inner), inner2, like(-1.0)), outer * outer * like(1.0 + relative))
}

impl<R: SideBySide<Plain: Bounded>> Beam<R> {
    /// The beam from a point that is off by `error` to a lamp at `position`. Where the two are too close
    /// to each other, its bounds say nothing.
    #[inline(always)]
    pub fn to_point(start: Vec3<R>, error: R, position: Vec3<f64>) -> Beam<R> {
        let (like, unit, largest) = (likes(error), R::Plain::UNIT, R::Plain::LARGEST_ROOT);
        let way = like3(error, position) - start;
        let beam = Beam::new(start, way, error, error);
        let distance = beam.square.sqrt();
        let off = error + like(unit) * (like(length_of(position)) + distance);
        let is_far = like(1.0 / largest).lt(distance).and(distance.lt(like(largest)));
        let is_apart = (like(4.0) * off).lt(distance).and(is_far);
        let off = R::select(is_apart, off, like(f64::INFINITY));
        let turned = like(OF_TURN) * off * beam.inverse_length;
        let at_end = like(unit) * (like(length_of(position)) + like(1.0 + OF_WAY) * distance);
        let bend = like(OF_LEVER) * at_end * beam.inverse_length;
        let error = R::select(is_apart, error, like(f64::INFINITY));
        Beam { error, end_error: at_end, bend, turned, ..beam }
    }

    /// The beam back along a ray whose direction is off by the relative error `turned`.
    #[inline(always)]
    pub fn to_eye(start: Vec3<R>, direction: Vec3<R>, turned: f64) -> Beam<R> {
        let [some, ..] = direction.0;
        let like = likes(some);
        Beam::new(start, -direction, like(0.0), like(2.0 * turned))
    }

    /// The beam against the direction of a sun's light, whose largest component is from 1 to 2.
    #[inline(always)]
    pub fn to_sun(start: Vec3<R>, error: R, direction: Vec3<f64>) -> Beam<R> {
        let way = like3(error, -direction);
        let turned = likes(error)(2.0 * R::Plain::ROUNDED * R::Plain::UNIT);
        Beam { is_endless: true, ..Beam::new(start, way, error, turned) }
    }

    #[inline(always)]
    fn new(start: Vec3<R>, way: Vec3<R>, error: R, turned: R) -> Beam<R> {
        let square = dot3(way, way);
        let one = likes(square)(1.0);
        let (inverse, inverse_length) = (one / square, one / square.sqrt());
        let (is_endless, unit) = (false, R::Plain::UNIT);
        let [end_error, bend] = [likes(square)(0.0); 2];
        Beam {
            from: start,
            way,
            square,
            inverse,
            inverse_length,
            error,
            end_error,
            bend,
            is_endless,
            turned,
            unit,
        }
    }

    /// Bounds of `n·ω` for a unit normal that is off by `normal_error`. Both are 0 where it is certain not
    /// to be positive.
    #[inline(always)]
    pub fn cosine(&self, normal: Vec3<R>, normal_error: R) -> (R, R) {
        let like = likes(normal_error);
        let cosine = dot3(normal, self.way) * self.inverse_length;
        let rounding = (OF_COSINE + 2.0 * R::Plain::ROUNDED) * R::Plain::UNIT;
        let error = like(ROOM) * (normal_error + self.turned) + like(rounding);
        // What is not a number says nothing.
        let (low, high) = (cosine - error, cosine + error);
        let (zero, one) = (like(0.0), like(1.0));
        let high = R::select(high.lt(one), high, one);
        (R::select(zero.lt(low), low, zero), R::select(zero.lt(high), high, zero))
    }

    /// Whether a sphere is in the way, its centre relative to the reference point.
    #[inline(always)]
    pub fn meets_sphere(&self, center: Vec3<R>, r: R) -> R {
        let (like, rounded) = (likes(r), R::Plain::ROUNDED);
        let l = center - self.from;
        let Vec3([x, y, z]) = center;
        let [x, y, z] = [x.abs(), y.abs(), z.abs()];
        let (l2, far) = (dot3(l, l), x.max(y).max(z));
        let last = if self.is_endless { r.like(R::Plain::LARGEST) } else { like(1.0) };
        let foot = (dot3(l, self.way) * self.inverse).max(like(0.0)).min(last);
        let q = l - self.way * foot;
        let distance = l2.sqrt();
        let of_object = like(OF_PLACE) * far + like(OF_OFFSET + rounded) * distance;
        let of_object = if rounded > 0.0 { of_object + r * like(rounded) } else { of_object };
        let here = self.error + like(self.unit) * of_object;
        let e = here + (self.bend * distance).min(self.end_error);
        let e_of_end = if self.is_endless { e } else { here + self.end_error };
        let (least2, end) = (dot3(q, q), l - self.way);
        let end2 = if self.is_endless { like(f64::INFINITY) } else { dot3(end, end) };
        let ((inner2, outer2), (end_inner2, end_outer2)) = (squares(r, e), squares(r, e_of_end));
        let largest = R::Plain::LARGEST_ROOT;
        let (beyond, negligible) = (like(largest), like(1.0 / largest));
        let is_ordinary = r.lt(beyond).and(negligible.lt(r));
        let in_range = l2.lt(beyond).and(e.lt(beyond)).and(is_ordinary);
        let is_clear = outer2.lt(least2).or(l2.lt(inner2).and(end2.lt(end_inner2)));
        let is_crossed = least2.lt(inner2).and(outer2.lt(l2).or(end_outer2.lt(end2)));
        let known = R::select(is_crossed, like(in_the_way::YES), like(in_the_way::OPEN));
        let known = R::select(is_clear, like(in_the_way::NO), known);
        R::select(in_range, known, like(in_the_way::OPEN))
    }

    /// Whether a plane is in the way: `point` relative to the reference point, and a normal of largest
    /// component from 1 to 2. `N = n·(a − p)` at the beam's start and `N₁ = n·(a − L)` at its end; it is in the
    /// way where their signs differ. They are off by `|n|·E`, without the end's part where the beam starts, and `3ε` of the
    /// product of the lengths for the dot product. A sun's end has the sign of `−n·w`, off by `3ε|n||w|` alone, as both are exact; so its
    /// beam surely runs along a plane where each product is one with 0, and then misses it.
    #[inline(always)]
    pub fn meets_plane(&self, point: Vec3<f64>, normal: Vec3<f64>) -> R {
        let (like, more) = (likes(self.square), 2.0 * R::Plain::ROUNDED);
        let zero = like(0.0);
        let l = like3(zero, point) - self.from;
        let end = l - self.way;
        let (n, way, away) = (length_of(normal), self.square.sqrt(), length_of(point));
        let normals = like3(zero, normal);
        let (of_lengths, unit) = (like(OF_PLANE + more), like(self.unit));
        let here = self.error + unit * (like(away) + of_lengths * length_of(l));
        let e = here + self.end_error + unit * (of_lengths * way);
        let start = dot3(normals, l);
        let start_error = like(ROOM * n) * here;
        let sun_error = like((OF_SLOPE + more) * self.unit * n) * way;
        let stop = if self.is_endless { -dot3(normals, self.way) } else { dot3(normals, end) };
        let stop_error = if self.is_endless { sun_error } else { like(ROOM * n) * e };
        let are_off = start_error.lt(start.abs()).and(stop_error.lt(stop.abs()));
        let are_known = are_off.and(e.lt(like(R::Plain::LARGEST_ROOT)));
        let is_apart = zero.lt(start).and(stop.le(zero)).or(start.le(zero).and(zero.lt(stop)));
        let known = R::select(is_apart, like(in_the_way::YES), like(in_the_way::NO));
        let known = R::select(are_known, known, like(in_the_way::OPEN));
        // What is 0 in f32 may have been less before.
        if !self.is_endless || more > 0.0 {
            return known;
        }
        let is_zero = |axis: usize| match normal.0[axis] {
            0.0 => zero.le(zero),
            _ => self.way.0[axis].abs().le(zero),
        };
        let runs_along = is_zero(0).and(is_zero(1)).and(is_zero(2));
        R::select(runs_along, like(in_the_way::NO), known)
    }

    /// Beams side by side that are all like this one.
    #[inline(always)]
    pub fn repeated<W: SideBySide<Plain = R>>(&self, some: W) -> Beam<W>
    where
        R: Real,
    {
        Beam {
            from: some.like3(self.from),
            way: some.like3(self.way),
            square: some.like(self.square),
            inverse: some.like(self.inverse),
            inverse_length: some.like(self.inverse_length),
            error: some.like(self.error),
            end_error: some.like(self.end_error),
            bend: some.like(self.bend),
            is_endless: self.is_endless,
            turned: some.like(self.turned),
            unit: self.unit,
        }
    }
}

impl Beam {
    /// [`Beam::meets_sphere`] of a beam that starts on another sphere, whose centre lies `apart` from this one's, for
    /// spheres that are nearly the same.
    pub fn meets_shell(
        &self,
        center: Vec3<f64>,
        r: f64,
        own_center: Vec3<f64>,
        own_r: f64,
        apart: Vec3<f64>,
    ) -> f64 {
        let l = center - self.from;
        let far = |v: Vec3<f64>| v.0.iter().fold(0.0, |far, x| f64::max(far, x.abs()));
        let far = f64::max(far(center), far(own_center));
        let e =
            self.error + self.end_error + self.unit * (OF_PLACE * far + OF_OFFSET * length_of(l));
        let way = self.square.sqrt();
        let v = self.from - own_center;
        let a = length_of(apart);
        let k = (own_r - r) * (own_r + r);
        let side = k + dot3(apart, apart + v * 2.0);
        let reach = a + 2.0 * length_of(v);
        let side_error = ROOM * (2.0 * a * e + self.unit * OF_SHELL * (k.abs() + a * reach));
        let leaves = dot3(l, self.way) < -ROOM * e * (way + 2.0 * length_of(l));
        let end = l - self.way;
        let end2 = if self.is_endless { f64::INFINITY } else { dot3(end, end) };
        let (inner, outer) = (r - e, r + e);
        let inner2 = if inner > 0.0 { inner * inner * (1.0 - RELATIVE) } else { -1.0 };
        let outer2 = outer * outer * (1.0 + RELATIVE);
        let starts_inside = side < -side_error;
        let are_in_range = [length_of(l), r, own_r, e, a, way].iter().all(|&x| x < LARGEST)
            && r.min(own_r) > 1.0 / LARGEST;
        let is_clear = (starts_inside & (end2 < inner2)) | ((side > side_error) & leaves);
        let known =
            if starts_inside & (end2 > outer2) { in_the_way::YES } else { in_the_way::OPEN };
        let known = if is_clear { in_the_way::NO } else { known };
        if are_in_range { known } else { in_the_way::OPEN }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::exact::{ExactBeam, ExactHit, ExactPoint, ExactRay, Shape, visible_root};
    use crate::kernel::arithmetic::Arithmetic;
    use crate::rays::Ray;

    /// A point in a plane across the x axis, where a ray along that meets it: a point of f64, exactly.
    fn exact_point(at: DVec3) -> ExactPoint {
        let ray = ExactRay::new(&Ray { origin: at - DVec3::X, direction: DVec3::X });
        let plane = Shape::Plane { point: at, normal: DVec3::X };
        let (root, side) = visible_root(&ray, &plane).unwrap();
        let point = ExactPoint::new(&ray, &ExactHit { id: 1, root, side });
        assert_eq!(point.is_within(0.0, at), Some(true), "{at}");
        point
    }

    fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
    }

    struct Case {
        from: DVec3,
        lamp: DVec3,
        is_sun: bool,
        shape: Shape,
    }

    /// Spheres and planes that a beam touches, begins at, or ends at, within some units of f64.
    fn case(rng: &mut ChaCha8Rng, unit: f64) -> Case {
        let size = 2f64.powi(rng.random_range(-12..12));
        // x keeps its digits when 1 is taken away and added again.
        let from = DVec3::new(rng.random_range(-8..8).into(), 0.0, 0.0)
            + vector(rng) * DVec3::new(0.0, 1.0, 1.0) * 2f64.powi(rng.random_range(-6..6));
        let lamp = vector(rng) * size;
        let is_sun = rng.random_bool(0.3);
        let way = if is_sun { -lamp } else { lamp - from };
        let s = [0.0, 1.0, rng.random_range(0.0..1.0)][rng.random_range(0..3)];
        let on_beam = from + way * s;
        let aside = way.cross(vector(rng)).normalize();
        let near = 1.0 + f64::from(rng.random_range(-24..=24)) * unit;
        let shape = if rng.random_bool(0.7) {
            let radius = way.length() * rng.random_range(0.01..1.0);
            let across = if s > 0.0 && s < 1.0 { aside } else { vector(rng).normalize() };
            Shape::Sphere { center: on_beam + across * radius * near, radius }
        } else {
            Shape::Plane {
                point: on_beam + aside * way.length(),
                normal: way.cross(aside) + way * 1e-3,
            }
        };
        Case { from, lamp, is_sun, shape }
    }

    /// Wrong statements about `n` cases with this part of the bounds' unit, and statements at all.
    fn statements<F>(n: usize, part: f64) -> (Vec<String>, usize)
    where
        F: Bounded + Arithmetic + SideBySide<Plain = F>,
    {
        let mut rng = ChaCha8Rng::seed_from_u64(1404);
        let (mut wrong, mut n_said) = (Vec::new(), 0);
        let unit = F::UNIT * part;
        for _ in 0..n {
            let Case { from, lamp, is_sun, shape } = case(&mut rng, F::UNIT);
            // The computed point is the true one.
            let start = Vec3(from.to_array().map(F::from_f64));
            let from = DVec3::from_array(start.0.map(F::to_f64));
            let beam = match is_sun {
                true => Beam::to_sun(start, F::ZERO, lamp.into()),
                false => Beam::to_point(start, F::ZERO, lamp.into()),
            };
            let error = beam.error * F::from_f64(part);
            let beam = Beam { unit, error, ..beam };
            let said = match shape {
                Shape::Sphere { center, radius } => {
                    let center = Vec3(center.to_array().map(F::from_f64));
                    beam.meets_sphere(center, F::from_f64(radius))
                }
                Shape::Plane { point, normal } => {
                    let largest = normal.abs().max_element().log2().floor() as i32;
                    beam.meets_plane(point.into(), (normal * 2f64.powi(-largest)).into())
                }
            };
            let said = said.to_f64();
            if said == in_the_way::OPEN {
                continue;
            }
            n_said += 1;
            let point = exact_point(from);
            let exact = match is_sun {
                true => ExactBeam::against(&point, lamp).unwrap(),
                false => ExactBeam::to_position(&point, lamp).unwrap(),
            };
            if exact.is_blocked_by(&shape) != (said == in_the_way::YES) {
                wrong.push(format!("{from:?} {lamp:?} {is_sun} {shape:?}: {said}"));
            }
        }
        (wrong, n_said)
    }

    /// So near that the squares of lengths underflow, the rounding of a dot product is as large as ever: this one has the wrong
    /// sign.
    #[test]
    fn planes_nearer_than_squares_tell_are_open() {
        let normal = Vec3([1.6980664066748499, -1.592633229472514, -0.7121360615149421]);
        let point = Vec3([-3.324926991026493e-166, 6.670777831146176e-166, -2.28468268181911e-165]);
        for sun in [normal, -normal] {
            let beam = Beam::to_sun(Vec3::ZERO, 0.0, sun);
            assert_eq!(beam.meets_plane(point, normal), in_the_way::OPEN, "{sun:?}");
        }
        // The same of spheres whose centres are that close.
        let beam = Beam::to_sun(Vec3([1.0, 0.0, 0.0]), 1e-15, Vec3([-1.0, 0.3, 0.0]));
        let apart = Vec3([0.0, 1e-165, 0.0]);
        let met = beam.meets_shell(Vec3::ZERO, 1.0, apart, 1.0, apart);
        assert_eq!(met, in_the_way::OPEN);
    }

    /// A sun at the horizon of a floor, which is often exactly there.
    #[test]
    fn suns_along_a_plane_are_known() {
        let floor = (Vec3([0.0, -1.0, 3.0]), Vec3([0.0, 1.0, 0.0]));
        for (sun, known) in [
            (DVec3::new(1.0, 0.0, -0.5), in_the_way::NO),
            (DVec3::new(1.0, 1e-300, -0.5), in_the_way::OPEN),
            (DVec3::new(1.0, 1e-9, -0.5), in_the_way::YES),
            (DVec3::new(1.0, -1e-9, -0.5), in_the_way::NO),
        ] {
            // Its light comes from there.
            let beam = Beam::to_sun(Vec3([0.1, 0.7, 0.3]), 1e-15, sun.into());
            assert_eq!(beam.meets_plane(floor.0, floor.1), known, "{sun}");
        }
    }

    #[test]
    fn what_is_said_is_right() {
        for (wrong, n_said) in [statements::<f64>(100_000, 1.0), statements::<f32>(100_000, 1.0)] {
            assert_eq!(wrong.len(), 0, "{}", wrong[0]);
            assert!(n_said > 20_000, "{n_said}");
        }
    }

    /// The unit of f64 is twice what rounding to nearest takes, the largest errors of all steps don't meet in one
    /// beam, and coordinates are rarely as large as their sums: wrong statements begin at a 24th.
    #[test]
    fn sabotage_smaller_bounds_are_noticed() {
        assert!(!statements::<f64>(100_000, 1.0 / 48.0).0.is_empty());
        assert!(!statements::<f32>(100_000, 1.0 / 24.0).0.is_empty());
    }

    /// Wrong statements about spheres that touch beams, where lamp and centre are off by as much as their differences to the
    /// reference point may be, `ε|L|` and `ε|c|` with their own rounding, with this part of what is granted.
    fn statements_of_moved_lamps(n: usize, part: f64) -> Vec<String> {
        let mut rng = ChaCha8Rng::seed_from_u64(1431);
        let mut wrong = Vec::new();
        for _ in 0..n {
            // Along a diagonal, where the largest component says least of the length.
            let lamp =
                DVec3::splat(2f64.powi(rng.random_range(-6..48))) * rng.random_range(0.5..1.0);
            let way = vector(&mut rng) * lamp.length() * 2f64.powi(rng.random_range(-20..0));
            let from = exact_start(lamp - way);
            let way = lamp - from;
            let aside = way.cross(vector(&mut rng)).normalize();
            let off = 0.7 * UNIT_F64 * [1.0, -1.0][rng.random_range(0..2)];
            let s = [0.99, 1e-6, rng.random_range(0.0..1.0)][rng.random_range(0..3)];
            let radius = way.length() * s * rng.random_range(0.01..1.0);
            let near = 1.0 + rng.random_range(-1.0..1.0) * 4.0 * UNIT_F64 * lamp.length() / radius;
            let center = from + way * s + aside * radius * near;
            let moved_lamp = lamp + aside * off * lamp.length();
            let moved_center = center - aside * off * center.length();
            let beam = Beam::to_point(Vec3(from.to_array()), 0.0, moved_lamp.into());
            let (end_error, bend) = (beam.end_error * part, beam.bend * part);
            let beam = Beam { end_error, bend, unit: part * UNIT_F64, ..beam };
            let said = beam.meets_sphere(moved_center.into(), radius);
            if said == in_the_way::OPEN {
                continue;
            }
            let point = exact_point(from);
            let exact = ExactBeam::to_position(&point, lamp).unwrap();
            let shape = Shape::Sphere { center, radius };
            if exact.is_blocked_by(&shape) != (said == in_the_way::YES) {
                wrong.push(format!("{from:?} {lamp:?} {off:e} {shape:?}: {said}"));
            }
        }
        wrong
    }

    /// A point near this one that [`exact_point`] takes: its x keeps its digits when 1 is taken away and added again.
    fn exact_start(at: DVec3) -> DVec3 {
        DVec3::new((at.x - 1.0) + 1.0, at.y, at.z)
    }

    #[test]
    fn what_is_said_of_far_lamps_is_right() {
        let wrong = statements_of_moved_lamps(100_000, 1.0);
        assert_eq!(wrong.len(), 0, "{}", wrong[0]);
    }

    #[test]
    fn sabotage_half_of_what_far_lamps_are_granted_is_noticed() {
        assert!(!statements_of_moved_lamps(100_000, 0.5).is_empty());
    }

    /// A ball near a floor is as open as its distance says, however far its lamp is.
    #[test]
    fn near_objects_are_judged_as_well_in_the_light_of_far_lamps() {
        for far in [1e1, 1e8, 1e25, 1e60] {
            let lamp = Vec3([0.4 * far, 0.8 * far, 0.3 * far]);
            let beam = Beam::to_point(Vec3([0.1, 0.0, 0.2]), 1e-15, lamp);
            for (center, known) in [
                (Vec3([0.9, 1.6, 0.8]), in_the_way::YES),
                (Vec3([-0.9, 1.6, 0.8]), in_the_way::NO),
                (Vec3([-0.4, -0.8, -0.3]), in_the_way::NO),
            ] {
                assert_eq!(beam.meets_sphere(center, 0.5), known, "{far:e} {center:?}");
            }
            let floor = (Vec3([0.0, -1.0, 0.0]), Vec3([0.0, 1.0, 0.0]));
            assert_eq!(beam.meets_plane(floor.0, floor.1), in_the_way::NO, "{far:e}");
        }
    }

    /// Wrong statements about `n` cases of beams that start on a sphere and meet one that is nearly the same, or
    /// goes through the point, with this part of the bounds; and statements at all.
    fn statements_of_shells(n: usize, part: f64) -> (Vec<String>, [usize; 3]) {
        let mut rng = ChaCha8Rng::seed_from_u64(1430);
        let (mut wrong, mut n_said) = (Vec::new(), [0; 3]);
        for _ in 0..n {
            let (own, own_r) = (vector(&mut rng), rng.random_range(0.5..2.0));
            let origin = own + vector(&mut rng) * [0.4, 6.0][rng.random_range(0..2)];
            let target = own + vector(&mut rng) * own_r * 0.5;
            let ray = Ray { origin, direction: target - origin };
            let sphere = Shape::Sphere { center: own, radius: own_r };
            let exact_ray = ExactRay::new(&ray);
            let Some((root, side)) = visible_root(&exact_ray, &sphere) else { continue };
            let point = ExactPoint::new(&exact_ray, &ExactHit { id: 1, root, side });
            // The same point in f64.
            let d = ray.direction.normalize();
            let foot = (own - origin).dot(d);
            let across = (own - origin - d * foot).length_squared();
            let half = (own_r * own_r - across).max(0.0).sqrt();
            let t = if origin.distance(own) > own_r { foot - half } else { foot + half };
            let at = origin + d * t;
            let error = 16.0 * UNIT_F64;
            if point.is_within(error, at) != Some(true) {
                continue;
            }
            let steps = |rng: &mut ChaCha8Rng| f64::from(rng.random_range(-6..=6)) * UNIT_F64;
            let size = [0.0, 1e-15, 1e-12, 1e-7, 0.3][rng.random_range(0..5)];
            let center = own + vector(&mut rng) * size;
            let radius = match rng.random_bool(0.5) {
                true => own_r * (1.0 + steps(&mut rng)),
                false => at.distance(center) * (1.0 + steps(&mut rng)),
            };
            let lamp = own + vector(&mut rng) * [0.5, 5.0][rng.random_range(0..2)];
            let is_sun = rng.random_bool(0.3);
            let beam = match is_sun {
                true => Beam::to_sun(at.into(), error, (at - lamp).into()),
                false => Beam::to_point(at.into(), error, lamp.into()),
            };
            let beam = Beam { unit: UNIT_F64 * part, error: beam.error * part, ..beam };
            let apart = (own - center).into();
            let said = beam.meets_shell(center.into(), radius, own.into(), own_r, apart);
            n_said[said as usize] += 1;
            let exact = match is_sun {
                true => ExactBeam::against(&point, at - lamp).unwrap(),
                false => ExactBeam::to_position(&point, lamp).unwrap(),
            };
            let is_blocked = exact.is_blocked_by(&Shape::Sphere { center, radius });
            if said != in_the_way::OPEN && is_blocked != (said == in_the_way::YES) {
                wrong.push(format!("{ray:?} {own:?} {own_r} {center:?} {radius}: {said}"));
            }
        }
        (wrong, n_said)
    }

    #[test]
    fn what_is_said_of_shells_is_right() {
        let (wrong, [n_no, n_open, n_yes]) = statements_of_shells(40_000, 1.0);
        assert_eq!(wrong.len(), 0, "{}", wrong[0]);
        assert!(n_no.min(n_yes) > 5000 && n_open < 20_000, "{n_no} {n_open} {n_yes}");
    }

    /// The point is known better than is said, too.
    #[test]
    fn sabotage_smaller_bounds_of_shells_are_noticed() {
        assert!(!statements_of_shells(40_000, 1.0 / 48.0).0.is_empty());
    }
}
