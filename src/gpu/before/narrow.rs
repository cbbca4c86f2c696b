//! What is in the way of a beam, in f32 with bounds: a device looks here first, and in f64
//! (`Beam::meets_sphere`) where this says nothing.
//!
//! # Spheres
//! As in `Beam`, distances `q` from the centre to the beam's start, to its end and to the nearest point
//! between them are compared with `r ± E`. The beam is `p + s·d`, `0 ≤ s ≤ D`, with a unit vector `d`. Let `ε`
//! be the unit of a faithful rounding of f32, `l` the centre's offset from `p`, and `η = ε|l|`.
//! - `p` and the centre come as two f32 each, and `l = (c − p) + (c' − p')`. Two roundings take `2.01η`. The low
//!   parts, at most half a step of the high ones, leave out `⅛ε²(|c| + |p|)`, and their difference, at most a step,
//!   loses `½ε²|p|`; that of the high parts is exact, or `|l|` is about as large as they are, and all this is of
//!   second order. So it is `¾ε²|p|`, at most `1.3ε²` of `p`'s largest component, and `2⁻⁵²` of that for the centre's
//!   own place: [`START`]. It is the same for all objects and in the beam's `e`.
//! - `d` is rounded once. Up to the foot that moves the beam by `0.501η`.
//! - `D` is rounded once, which matters where the foot is at the end, and so no farther away than `|l|`: `0.501η`.
//! - `s·d` and the difference: [`steps::FOOT`] `1.01η`, and what is relative, in [`steps::SQUARE`].
//! - `s` itself is off by `3.01η` for the dot product and, as `d·d` is 1 up to `1.01ε`, by `1.01η`: `τ = 4.02η`.
//!   That only lengthens `q`, and only squared: along a line, `q² = m² + τ²`. Cut off at `D` this is no different
//!   but for `D`'s own rounding, which is counted above.
//!
//! So `E = e + 4.03η` is enough for what is nearer than it seems: [`OFFSET`]. For what seems nearer than it is, `q`
//! may be as large as `√((r + e + 2.52η)² + τ²) + 1.52η`. Its square is at most `(r + E)² + (4.02² + 2·1.52·4.02)η²`, which is
//! [`ASIDE`] with `28.4η²`.
//!
//! Relative errors of the squares that are compared: of the end's `l − w`, `w` rounded once, `½(|l| + |end|)`, of which
//! `½η` is in `E`, and with the difference and the dot product `2·1.5 + 3`; that is more than [`steps::SQUARE`] of the nearest
//! point. Of the radius `2·½`, of `r ± E` `2`, of its square, the sum in it and the widening `1` each: [`SQUARES`].
//!
//! # Planes
//! With `n` rounded once, `n·l` is off by `|n|` times `e + (2.01 + 0.501 + 3.01)η` where the beam starts. At its end `l − w` adds
//! `½ε|w|` and a rounding, `|w| ≤ |l| + |end|`: `(2.01 + 0.501)η + (1 + 3.01 + 2·0.501)ε|end|`. Both are less than `|n|(e +` [`PLANE`]
//! `ε(|l| + |end|))`. For a sun `n·d` is off by `3.01 + 2·0.501` units of `|n|`: [`SLOPE`].
//!
//! # Beams that are made in f32
//! They start at a point of f32, whose low part is 0, and their way `w` to a lamp is computed there: its own rounding is in
//! the beam's `e`, which is both ends'. `D` is the root of `w·w`, off by `1½ + 4.5`, and `d = w·(1/D)`: its components are off
//! by 2.5 and those 6 together, which does not turn it, and by 1 each for the product, and ½ more of a sun's, which the host rounds.
//! - So up to the foot `d` moves the beam aside by `1.52η`. At the end `D·d` is `w` but for the quotient: `2.51η`. In all `E = e +
//!   (2.01 + 1.01 + 1.52 + 2.51)η` ([`OFFSET_IN_F32`]).
//! - `d·d` is off by `2·9.52`: `τ = (3.01 + 19.1)η`. Cut off at `D` or not, the foot is along the beam no farther off than that, as the end is not.
//!   So [`ASIDE_IN_F32`] is above `(22.2² + 2·1.01·22.2)η²`.
//! - A sun's `n·d` is off by `3.01 + 0.501 + 0.501 + `[`steps::NORMALIZED_WIDE`]: [`SLOPE_IN_F32`].
//!
//! The rest is granted as above.
//!
//! # Range
//! Where a beam starts, its error, centres and radii are below `REACH`; beams that are longer than `END` go on for ever:
//! from no sphere in reach can the end be told otherwise. So squares are below `2¹²⁴`. What underflows is, under a root,
//! below `LEAST`.

use super::beam::Beam;
pub use super::beam::in_the_way;
use super::records::{NarrowPlane, NarrowSphere};
use crate::guard::{LIST, ROOM, UNIT_F32, round_down, round_up, sphere_in_range_f32, steps};
use crate::prepare::split;
use crate::vec3::{Real, Vec3, dot3};

/// Of the largest component of `p` in the error of `l`, in units `ε²`.
pub const START: f64 = 1.4;

/// Of `|l|` in `E`, in units `ε`.
pub const OFFSET: f64 = 4.1;
const _: () = assert!(LIST.offset + steps::FOOT + 2.0 * LIST.direction < OFFSET);

/// Of `|l|²` in the square of `r + E`, in units `ε²`.
pub const ASIDE: f64 = 29.0;

/// Of squares that are compared, relative, in units `ε`.
pub const SQUARES: f64 = 12.5;

/// Of `|l| + |end|` in the error of `n·l`, in units `ε|n|`.
pub const PLANE: f64 = 5.6;

/// Of `n·d`, in the same.
pub const SLOPE: f64 = 4.1;

/// [`OFFSET`] of beams that are made in f32.
pub const OFFSET_IN_F32: f64 = 7.2;
const _: () = assert!(LIST.offset + steps::FOOT + (1.01 + LIST.direction) + 2.51 < OFFSET_IN_F32);

/// [`ASIDE`] of those.
pub const ASIDE_IN_F32: f64 = 540.0;

/// [`SLOPE`] of those.
pub const SLOPE_IN_F32: f64 = 13.8;

/// Least error of a beam: the root of what a square loses.
const LEAST: f64 = 1.0 / (1u64 << 62) as f64;

/// Most of a coordinate, a radius and an error.
const REACH: f64 = (1u64 << 58) as f64;

/// Length of a beam that goes on for ever.
const END: f64 = (1u64 << 61) as f64;

/// What splits an f64 into 24 and 29 bits (Veltkamp 1968).
const SPLITTER: f64 = (1u64 << 29) as f64 + 1.0;

/// The constants of the twin in `shaders/narrow.wgsl` that are f64 there, by their names.
#[cfg(feature = "gpu")]
pub const IN_F64: [(&str, f64); 5] = [
    ("NARROW_START", START * UNIT_F32 * UNIT_F32),
    ("NARROW_LEAST", LEAST),
    ("NARROW_REACH", REACH),
    ("NARROW_END", END),
    ("SPLITTER", SPLITTER),
];

/// The others, in f32.
#[cfg(feature = "gpu")]
pub fn constants_in_f32(room: &NarrowRoom<f32>) -> [(&'static str, f32); 6] {
    let &NarrowRoom { offset, aside, inside, outside, plane, slope } = room;
    [
        ("NARROW_OFFSET", offset),
        ("NARROW_ASIDE", aside),
        ("NARROW_INSIDE", inside),
        ("NARROW_OUTSIDE", outside),
        ("NARROW_PLANE", plane),
        ("NARROW_SLOPE", slope),
    ]
}

/// The bounds of the arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct NarrowRoom<R> {
    /// [`OFFSET`], relative.
    pub offset: R,
    /// [`ASIDE`], relative.
    pub aside: R,
    /// Below 1: [`SQUARES`].
    pub inside: R,
    /// Above 1: the same.
    pub outside: R,
    /// [`PLANE`], relative.
    pub plane: R,
    /// [`SLOPE`], relative.
    pub slope: R,
}

impl NarrowRoom<f32> {
    /// Those of f32, rounded outward.
    pub fn f32() -> NarrowRoom<f32> {
        NarrowRoom {
            offset: round_up(OFFSET * UNIT_F32),
            aside: round_up(ASIDE * UNIT_F32 * UNIT_F32),
            inside: round_down(1.0 - SQUARES * UNIT_F32),
            outside: round_up(1.0 + SQUARES * UNIT_F32),
            plane: round_up(PLANE * UNIT_F32),
            slope: round_up(SLOPE * UNIT_F32),
        }
    }

    /// The same for beams that are made in f32.
    pub fn of_beams_in_f32() -> NarrowRoom<f32> {
        NarrowRoom {
            offset: round_up(OFFSET_IN_F32 * UNIT_F32),
            aside: round_up(ASIDE_IN_F32 * UNIT_F32 * UNIT_F32),
            slope: round_up(SLOPE_IN_F32 * UNIT_F32),
            ..NarrowRoom::f32()
        }
    }
}

/// A beam in f32.
#[derive(Clone, Copy, Debug)]
pub struct NarrowBeam<R> {
    /// Where it starts.
    pub start: Vec3<R>,
    /// What that leaves out.
    pub start_low: Vec3<R>,
    /// To the lamp, of length 1.
    pub direction: Vec3<R>,
    /// To the lamp; nothing for a beam that goes on for ever.
    pub way: Vec3<R>,
    /// Its length.
    pub distance: R,
    /// The part of `E` that is the same for all objects.
    pub error: R,
    /// Whether it goes on for ever.
    pub is_endless: bool,
    /// Whether f32 has its numbers.
    pub is_known: bool,
}

/// A sphere's numbers; the radius is 0 where f32 has none.
pub fn narrow_sphere(center: [f64; 3], radius: f64) -> NarrowSphere {
    let far = center.iter().fold(radius, |far, x| f64::max(far, x.abs()));
    let in_range = sphere_in_range_f32(radius, far) && far < REACH;
    let (center, radius) = if in_range { (center, radius) } else { ([0.0; 3], 0.0) };
    let (center, center_low) = split(center.into());
    NarrowSphere { center, radius: radius as f32, center_low, padding: 0 }
}

/// A plane's numbers, from a normal whose largest component is from 1 to 2; the size is 0 where f32 has none.
pub fn narrow_plane(point: [f64; 3], normal: [f64; 3]) -> NarrowPlane {
    let in_range = point.iter().all(|x| x.abs() < REACH);
    let point = if in_range { point } else { [0.0; 3] };
    let size = dot3::<f64>(Vec3(normal), Vec3(normal)).sqrt() * ROOM;
    let (point, point_low) = split(point.into());
    NarrowPlane {
        point,
        size: if in_range { round_up(size) } else { 0.0 },
        point_low,
        padding: 0,
        normal: normal.map(|x| x as f32),
        padding_again: 0,
    }
}

/// The beam of f64, in f32.
pub fn narrowed(beam: &Beam) -> NarrowBeam<f32> {
    let length = beam.square.sqrt();
    let far = beam.from.0.iter().fold(0.0, |far, x| f64::max(far, x.abs()));
    let error = ROOM * (beam.error + beam.end_error + START * UNIT_F32 * UNIT_F32 * far) + LEAST;
    let in_range =
        far < REACH && error < REACH && length > 1.0 / REACH && length < super::beam::LARGEST;
    let is_endless = beam.is_endless || length > END;
    let from = if in_range { beam.from } else { Vec3::ZERO };
    let direction = beam.way * (1.0 / if in_range { length } else { 1.0 });
    let way = if in_range && !is_endless { beam.way } else { direction };
    let high = from * SPLITTER - (from * SPLITTER - from);
    let narrow = |v: Vec3<f64>| Vec3(v.0.map(|x| x as f32));
    let known = |v: Vec3<f64>| narrow(if in_range { v } else { Vec3::ZERO });
    NarrowBeam {
        start: narrow(high),
        start_low: narrow(from - high),
        direction: known(direction),
        way: known(way),
        distance: (if is_endless { END } else { f64::min(length, END) }) as f32,
        error: (if in_range { error } else { REACH }) as f32,
        is_endless,
        is_known: in_range,
    }
}

/// As in [`crate::vec3`].
#[inline(always)]
fn dot3f<R: Real>(a: Vec3<R>, b: Vec3<R>) -> R {
    dot3(a, b)
}

/// [`NarrowSphere`] in any arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct NarrowSphereOf<R> {
    /// The centre's high parts.
    pub center: Vec3<R>,
    /// The radius.
    pub radius: R,
    /// The centre's low parts.
    pub center_low: Vec3<R>,
}

/// [`NarrowPlane`] in any arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct NarrowPlaneOf<R> {
    /// A point's high parts.
    pub point: Vec3<R>,
    /// At least the length of the normal.
    pub size: R,
    /// The point's low parts.
    pub point_low: Vec3<R>,
    /// The normal.
    pub normal: Vec3<R>,
}

impl From<&NarrowSphere> for NarrowSphereOf<f32> {
    fn from(sphere: &NarrowSphere) -> Self {
        let &NarrowSphere { center, radius, center_low, .. } = sphere;
        NarrowSphereOf { center: Vec3(center), radius, center_low: Vec3(center_low) }
    }
}

impl From<&NarrowPlane> for NarrowPlaneOf<f32> {
    fn from(plane: &NarrowPlane) -> Self {
        let &NarrowPlane { point, size, point_low, normal, .. } = plane;
        let [point, point_low, normal] = [point, point_low, normal].map(Vec3);
        NarrowPlaneOf { point, size, point_low, normal }
    }
}

impl<R: Real> NarrowBeam<R> {
    /// From where it starts to a place of two parts.
    pub fn offset_to(&self, place: Vec3<R>, low: Vec3<R>) -> Vec3<R> {
        (place - self.start) + (low - self.start_low)
    }

    /// The square of its distance from a place at this offset from its start.
    pub fn nearest2(&self, l: Vec3<R>) -> R {
        let foot = dot3f(l, self.direction).max(R::ZERO).min(self.distance);
        let q = l - self.direction * foot;
        dot3f(q, q)
    }

    /// Whether a sphere is in the way, as far as f32 knows.
    pub fn meets_narrow_sphere(&self, sphere: &NarrowSphereOf<R>, room: &NarrowRoom<R>) -> f64 {
        let l = self.offset_to(sphere.center, sphere.center_low);
        let r = sphere.radius;
        let l2 = dot3f(l, l);
        let least2 = self.nearest2(l);
        let end = l - self.way;
        let end2 = dot3f(end, end);
        let e = self.error + room.offset * l2.sqrt();
        let (inner, outer) = (r - e, r + e);
        let inner2 = if inner > R::ZERO { inner * inner * room.inside } else { -R::ONE };
        let outer2 = (outer * outer + room.aside * l2) * room.outside;
        let ends_inside = !self.is_endless & (end2 < inner2);
        let ends_outside = self.is_endless | (end2 > outer2);
        let is_clear = (least2 > outer2) | ((l2 < inner2) & ends_inside);
        let is_crossed = (least2 < inner2) & ((l2 > outer2) | ends_outside);
        let known = if is_crossed { in_the_way::YES } else { in_the_way::OPEN };
        let known = if is_clear { in_the_way::NO } else { known };
        if self.is_known & (r > R::ZERO) { known } else { in_the_way::OPEN }
    }

    /// Whether a beam that starts on the inside of a sphere leaves it: a ball is convex, so that its end says so.
    pub fn leaves_narrow_sphere(&self, sphere: &NarrowSphereOf<R>, room: &NarrowRoom<R>) -> f64 {
        let l = self.offset_to(sphere.center, sphere.center_low);
        let r = sphere.radius;
        let end = l - self.way;
        let end2 = dot3f(end, end);
        let e = self.error + room.offset * dot3f(l, l).sqrt();
        let (inner, outer) = (r - e, r + e);
        let is_near = (inner > R::ZERO) & (end2 < inner * inner * room.inside);
        let is_outside = self.is_endless | (end2 > outer * outer * room.outside);
        let known = if is_outside { in_the_way::YES } else { in_the_way::OPEN };
        let known = if is_near & !self.is_endless { in_the_way::NO } else { known };
        if self.is_known & (r > R::ZERO) { known } else { in_the_way::OPEN }
    }

    /// Whether a plane is in the way, as far as f32 knows.
    pub fn meets_narrow_plane(&self, plane: &NarrowPlaneOf<R>, room: &NarrowRoom<R>) -> f64 {
        let l = self.offset_to(plane.point, plane.point_low);
        let end = l - self.way;
        let near = dot3f(l, l).sqrt();
        let far = near + dot3f(end, end).sqrt();
        let start = dot3f(plane.normal, l);
        let start_error = plane.size * (self.error + room.plane * near);
        let slope = -dot3f(plane.normal, self.direction);
        let stop = if self.is_endless { slope } else { dot3f(plane.normal, end) };
        let error = if self.is_endless { room.slope } else { self.error + room.plane * far };
        let stop_error = plane.size * error;
        let are_known = (start.abs() > start_error) & (stop.abs() > stop_error);
        let are_apart = (start > R::ZERO) != (stop > R::ZERO);
        let known = if are_apart { in_the_way::YES } else { in_the_way::NO };
        let in_range = self.is_known & (plane.size > R::ZERO);
        if are_known & in_range { known } else { in_the_way::OPEN }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
    }

    /// Statements about `n` spheres and planes that a beam nearly touches, begins or ends at, with bounds that are
    /// this part of what they should be: those at all, and those that f64 contradicts.
    fn statements(n: usize, part: f64) -> (usize, usize) {
        let mut rng = ChaCha8Rng::seed_from_u64(1429);
        let room = NarrowRoom::f32();
        let cut = |x: f32| (f64::from(x) * part) as f32;
        let toward_one = |x: f32| (1.0 + (f64::from(x) - 1.0) * part) as f32;
        let room = NarrowRoom {
            offset: cut(room.offset),
            aside: cut(room.aside),
            inside: toward_one(room.inside),
            outside: toward_one(room.outside),
            plane: cut(room.plane),
            slope: cut(room.slope),
        };
        let (mut n_said, mut n_wrong) = (0, 0);
        for _ in 0..n {
            let moved = [0.0, 0.0, 1e3, 1e7][rng.random_range(0..4)];
            let from = vector(&mut rng) + vector(&mut rng) * moved;
            let way = vector(&mut rng) * 2f64.powi(rng.random_range(-6..6));
            let beam = match rng.random_bool(0.3) {
                true => Beam::to_sun(from.into(), 0.0, (-way.normalize() * 1.5).into()),
                false => Beam::to_point(from.into(), 0.0, (from + way).into()),
            };
            let beam = Beam { error: beam.error * part, ..beam };
            let narrow = narrowed(&beam);
            let narrow = NarrowBeam { error: cut(narrow.error), ..narrow };
            let s = [0.0, 1.0, rng.random_range(0.0..1.0)][rng.random_range(0..3)];
            let at = DVec3::from_array(beam.from.0) + way * s;
            let aside = way.cross(vector(&mut rng)).normalize();
            let near = 1.0 + f64::from(rng.random_range(-40..=40)) * UNIT_F32 / 2.0;
            let (said, known) = if rng.random_bool(0.7) {
                let r = way.length() * rng.random_range(0.01..1.0);
                let across = if s > 0.0 && s < 1.0 { aside } else { vector(&mut rng).normalize() };
                let center = (at + across * r * near).to_array();
                let sphere = NarrowSphereOf::from(&narrow_sphere(center, r));
                (narrow.meets_narrow_sphere(&sphere, &room), beam.meets_sphere(Vec3(center), r))
            } else {
                let normal = way.cross(aside) + way * 1e-3;
                let normal = (normal / normal.abs().max_element() * 1.5).to_array();
                let point = (at + aside * way.length() + way * (near - 1.0)).to_array();
                let plane = NarrowPlaneOf::from(&narrow_plane(point, normal));
                let (point, normal) = (Vec3(point), Vec3(normal));
                (narrow.meets_narrow_plane(&plane, &room), beam.meets_plane(point, normal))
            };
            n_said += usize::from(said != in_the_way::OPEN);
            let is_wrong = said != in_the_way::OPEN && known != in_the_way::OPEN && said != known;
            n_wrong += usize::from(is_wrong);
        }
        (n_said, n_wrong)
    }

    #[test]
    fn what_f32_says_is_what_f64_says() {
        let (n_said, n_wrong) = statements(400_000, 1.0);
        assert_eq!(n_wrong, 0);
        assert!(n_said > 100_000, "{n_said}");
    }

    /// The host rounds to nearest, twice as well as is granted, and the largest errors of all steps don't meet in one
    /// beam: wrong statements begin at a sixth.
    #[test]
    fn sabotage_smaller_bounds_are_noticed() {
        assert!(statements(400_000, 0.125).1 > 0);
    }

    /// Numbers beyond f32 say nothing.
    #[test]
    fn what_is_out_of_reach_is_left_open() {
        let room = NarrowRoom::f32();
        let beam = |from: DVec3, lamp: DVec3| Beam::to_point(from.into(), 0.0, lamp.into());
        let ball = |center: f64, r| NarrowSphereOf::from(&narrow_sphere([center, 0.0, 0.0], r));
        let says = |beam: &Beam, ball| narrowed(beam).meets_narrow_sphere(&ball, &room);
        let short = beam(DVec3::ZERO, DVec3::X * 2.0);
        assert_eq!(says(&short, ball(1.0, 0.5)), in_the_way::YES);
        assert_eq!(says(&short, ball(3.0, 0.5)), in_the_way::NO);
        for far in [1e-20, 1e20] {
            assert_eq!(says(&short, ball(1.0, far)), in_the_way::OPEN, "{far}");
        }
        assert_eq!(says(&short, ball(1e20, 1.0)), in_the_way::OPEN);
        for (from, lamp) in [(1e20, 2e20), (0.0, 1e-20)] {
            let beam = beam(DVec3::X * from, DVec3::X * lamp);
            assert_eq!(says(&beam, ball(1.0, 0.5)), in_the_way::OPEN, "{from} {lamp}");
        }
        // A lamp as far away as a sun.
        let long = beam(DVec3::ZERO, DVec3::X * 1e19);
        let plane = |x| NarrowPlaneOf::from(&narrow_plane([x, 0.0, 0.0], [1.0, 0.1, 0.0]));
        let long = NarrowBeam { error: 1e-6, ..narrowed(&long) };
        assert!(long.is_endless);
        assert_eq!(long.meets_narrow_sphere(&ball(1.0, 0.5), &room), in_the_way::YES);
        assert_eq!(long.meets_narrow_sphere(&ball(-1.0, 0.5), &room), in_the_way::NO);
        assert_eq!(long.meets_narrow_plane(&plane(1.0), &room), in_the_way::YES);
        assert_eq!(long.meets_narrow_plane(&plane(-1.0), &room), in_the_way::NO);
        assert_eq!(long.meets_narrow_plane(&plane(1e20), &room), in_the_way::OPEN);
    }
}
