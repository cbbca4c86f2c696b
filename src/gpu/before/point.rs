//! Where rays meet their objects, in f32 with bounds: a device finds the colours of pixels here first, and in f64 where
//! that leaves a byte open. Twin of `shaders/point.wgsl`; beams from these points are those of `beam.rs` and
//! [`super::narrow`].
//!
//! Which object a ray meets is known, and that it meets it. Let `ε` be the unit of [`crate::guard`] in f32,
//! `δ` the error of the direction `d` there ([`InputError`]), `a = d·d`. All errors below are in units `ε`, unless they
//! are said to be absolute.
//!
//! # Spheres
//! The normal of a small sphere far away needs more than f32 has of the way to its centre. But the picture shows
//! where the centre is: it lies at depth `λ` behind the point `(i₀, j₀)` of the picture, which need not be a
//! pixel's, as `c − o = λ(f + i₀R + j₀T)` with the view axis `f` and the pixel's steps `R` and `T`. A ray through
//! `(i, j)` passes it at the distance of `P`, the part across `d` of `l = −λu`, `u = (i − i₀)R + (j − j₀)T`: all errors are
//! relative to `|l|`, which is at most `r·|d|` where the sphere is hit, and not to the way. A parallel ray starts
//! at `iR + jT`, so that the same holds with `λ = 1`. Where the depth is nothing to divide by, `l = c`, as it is in f32.
//!
//! - The host finds `λ`, `i₀`, `j₀` in f64, splits these two into two f32 each, and puts what `λ(f + i₀R + j₀T)` misses of
//!   the centre, with a bound of its own rounding, into the sphere's absolute error `ρ` ([`SeenFrom::sphere`]).
//! - `i − i₀` takes two roundings, 2.01: the first one is exact, or the low part of `i₀` is no more than `ε|i − i₀|`.
//!   `R` and `T` are rounded once, multiplied and added: `3.53√2` of `|u|`, and 1 for the sum. With `λ` rounded and
//!   multiplied, 7.5 of `|l|`: [`PLACE`]. As it is in f32, the centre is off by 0.501 only.
//! - The parts across two directions differ by the sine of the angle between them: `δ`.
//! - The foot's product takes [`steps::FOOT`] 1.01 of the part of `l` along `d`, the difference as much of that across: together
//!   `1.01√2` of `|l|` at most ([`ROUNDED`]). So the error across `d` is [`ACROSS`] and `δ`.
//! - Along `d`, the foot's parameter takes [`steps::CLOSEST`] 9.51 more: [`FOOT`] and `δ`.
//!
//! The chord's half has the square `H² = r² − |P|²`. `r` is rounded and squared, 2.01 of `r²`; the dot product takes 3.01
//! of `|P|² ≤ r²`, the difference 1.01 of `r²`: [`SQUARE`]. `P`'s own error takes `2|P|e + e²`
//! with the part `e` across `d`, and along `d`, where `P` has nothing, its square alone. With `|P|` as it is computed,
//! which is off by `e` itself, that is at most `2|P|e` and twice the square of the whole error. Where `H²` is at
//! least 4 times its error, `H` itself is off by at most that error divided by `(1 + √¾)H`: [`HALF`]. With
//! [`steps::CHORD_WIDE`] for the root, `h·d` and the sum, and `δ` for the direction, the way `out` from the centre to the
//! point is known, and the normal is `out/r`: 1.51 for the inverse of `r` and the product ([`NORMAL`]).
//!
//! The point is `c + out`, and `c` has two parts: 1 of `|out|` for the low one and 1 of the result. What `c` loses with two
//! parts and in f64 is of second order.
//!
//! # Planes
//! With the unit normal `n`, `t = N/M`, where `M = n·f + i(n·R) + j(n·T)` and `N` is the host's: for parallel rays `M = n·f` and
//! `N − i(n·R) − j(n·T)` stands for `N`. Each part is rounded once and multiplied, the sum takes two roundings: 3.51 of the sum of
//! the parts' magnitudes ([`SUM`]), which is far less than a dot product with `d` where the plane is nearly
//! along the view axis. What f64 loses of `n`, of `N` and of the parts is absolute: `2⁻⁴⁶` of `|d|` and of the distance. Where `M` and `N` are
//! [`APART`] times their errors, these add up relative to them, but for a 256th.
//!
//! `t` takes 3.5 more for its quotient; the point 1 for the product, `δ`, and 1 for the sum of `t|d|` and of the origin's
//! length, which is itself off by [`InputError::offset`] of it.
//!
//! # Beams and cosines
//! The host rounds lamps, weights and colours to nearest; `beam.rs` and [`super::narrow`] say what is granted for that.
//!
//! # Range
//! Spheres lie within `2⁵⁸`, `r·|d| ≤ 2⁶⁰`, `r ≥ 2⁻³⁰`, and no direction of the picture is longer than `2¹⁰`: so squares of `l`
//! are below `2¹²²`, and where `H²` is looked at it is above `2⁻¹⁰⁰`, so that its product with `1/a` is not subnormal. Planes
//! lie within `2⁵⁸`, `M` is above `2⁻³⁸` where it is known, so that `t·|d|` is below `2¹⁰⁶`, and used below `2⁵⁸` alone.

use glam::DVec3;

use super::narrow::NarrowSphereOf;
use super::records::{SeenPlane, SeenSphere};
use crate::guard::{InputError, LONGEST_IN_F32, ROOM, UNIT_F32, round_up, steps};
use crate::kernel::RayOf;
use crate::prepare::{Scaled, split};
use crate::rays::{CameraF64, Lens, Pixels};
use crate::scene::{Plane, Sphere};
use crate::vec3::{Real, Vec3, dot3};

/// Of `|l|` in its own error.
pub const PLACE: f64 = 7.6;

/// Of `|l|`, for the rounding of `P`.
pub const ROUNDED: f64 = 1.45;

/// Of `|l|` in the error of `P` across `d`, without `δ`.
pub const ACROSS: f64 = PLACE + ROUNDED;

/// The same with what is along `d`.
pub const FOOT: f64 = ACROSS + steps::CLOSEST;

/// Of `r²` in the error of `H²`.
pub const SQUARE: f64 = 6.1;

/// Of the error of `H²`, divided by `H`, in that of `H`.
pub const HALF: f64 = 0.54;

/// Of the normal.
pub const NORMAL: f64 = 1.6;

/// Of the parts of `M` or `N`.
pub const SUM: f64 = 3.6;

/// How many times its error a number is that others are divided by, or compared with, for planes.
pub const APART: f64 = 256.0;

/// Of `t|d|` in a plane's point, without `δ`.
pub const RAY: f64 = 5.6;

/// What f64 loses, relative.
const LOST: f64 = 1.0 / (1u64 << 46) as f64;

/// Most of a plane's distance.
const REACH: f64 = (1u64 << 58) as f64;

/// Least of what is divided by.
pub const LEAST: f64 = 1.0 / (1u64 << 60) as f64;

/// Largest place of a centre in the picture, in halves of a pixel.
const FARTHEST: f64 = (1u64 << 23) as f64;

/// The bounds of the arithmetic, for rays of a picture.
#[derive(Clone, Copy, Debug)]
pub struct PointRoom<R> {
    /// [`FOOT`]
    pub foot: R,
    /// [`ACROSS`]
    pub across: R,
    /// [`SQUARE`]
    pub square: R,
    /// [`HALF`]
    pub half: R,
    /// [`steps::CHORD_WIDE`] and `δ`
    pub chord: R,
    /// [`NORMAL`]
    pub normal: R,
    /// [`SUM`]
    pub sum: R,
    /// Of `|d|` in the error of `M`.
    pub slope: R,
    /// [`APART`]
    pub apart: R,
    /// [`RAY`] and `δ`
    pub ray: R,
    /// Of the length of the origin.
    pub origin: R,
    /// [`crate::guard::ROOM`]
    pub room: R,
    /// `ε`
    pub unit: R,
    /// [`LEAST`]
    pub least: R,
    /// Most of a plane's distance.
    pub reach: R,
}

impl PointRoom<f32> {
    /// Those of f32, rounded up, for rays with such an error.
    pub fn f32(input: InputError) -> PointRoom<f32> {
        let InputError { offset, direction } = input;
        let units = |n: f64| round_up(n * UNIT_F32);
        PointRoom {
            foot: units(FOOT + direction),
            across: units(ACROSS + direction),
            square: units(SQUARE),
            half: round_up(HALF),
            chord: units(steps::CHORD_WIDE + direction),
            normal: units(NORMAL),
            sum: units(SUM),
            slope: round_up(LOST),
            apart: round_up(APART),
            ray: units(RAY + direction),
            origin: units(offset + 1.0),
            room: round_up(ROOM),
            unit: round_up(UNIT_F32),
            least: round_up(LEAST),
            reach: round_up(REACH),
        }
    }
}

/// The constants of the twin, by their names there; others are those of `beam.rs` and [`super::narrow`].
#[cfg(feature = "gpu")]
pub fn constants(input: InputError) -> [(&'static str, f32); 12] {
    let room = PointRoom::f32(input);
    [
        ("POINT_FOOT", room.foot),
        ("POINT_ACROSS", room.across),
        ("POINT_SQUARE", room.square),
        ("POINT_HALF", room.half),
        ("POINT_CHORD", room.chord),
        ("POINT_NORMAL", room.normal),
        ("POINT_SUM", room.sum),
        ("POINT_SLOPE", room.slope),
        ("POINT_APART", room.apart),
        ("POINT_RAY", room.ray),
        ("POINT_ORIGIN", room.origin),
        ("DIRECTION_ERROR", round_up(input.direction * UNIT_F32)),
    ]
}

/// A point of an object and the unit normal there, which faces the ray.
#[derive(Clone, Copy, Debug)]
pub struct PointOf<R> {
    /// The point, relative to the reference point.
    pub at: Vec3<R>,
    /// Bound of its distance from the true one.
    pub error: R,
    /// The normal.
    pub normal: Vec3<R>,
    /// Bound of its distance from the true one.
    pub normal_error: R,
    /// Whether any of this holds.
    pub is_known: bool,
    /// Whether it is on a sphere that its ray starts in.
    pub is_inside: bool,
}

/// [`SeenSphere`] in any arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct SeenSphereOf<R> {
    /// The centre's place in the picture, high parts.
    pub place: [R; 2],
    /// The low ones.
    pub place_low: [R; 2],
    /// Its depth.
    pub depth: R,
    /// The absolute error of that.
    pub error: R,
    /// Of the radius.
    pub inverse_radius: R,
    /// Which side of it is seen.
    pub side: R,
}

/// [`SeenPlane`] in any arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct SeenPlaneOf<R> {
    /// The unit normal times the view axis and the picture's steps.
    pub slope: Vec3<R>,
    /// The same times the way there.
    pub offset: R,
    /// The unit normal.
    pub unit: Vec3<R>,
    /// Absolute error of the offset.
    pub error: R,
}

impl From<&SeenSphere> for SeenSphereOf<f32> {
    fn from(sphere: &SeenSphere) -> Self {
        let &SeenSphere { place, place_low, depth, error, inverse_radius, side } = sphere;
        SeenSphereOf { place, place_low, depth, error, inverse_radius, side }
    }
}

impl From<&SeenPlane> for SeenPlaneOf<f32> {
    fn from(plane: &SeenPlane) -> Self {
        let &SeenPlane { slope, offset, unit, error } = plane;
        SeenPlaneOf { slope: Vec3(slope), offset, unit: Vec3(unit), error }
    }
}

/// What all rays of a picture share.
#[derive(Clone, Copy, Debug)]
pub struct PointFinder<R> {
    /// Half a pixel to the right.
    pub right_step: Vec3<R>,
    /// Half a pixel to the top.
    pub true_up_step: Vec3<R>,
    /// What the place in the picture decides.
    pub lens: Lens,
    /// The bounds.
    pub room: PointRoom<R>,
}

impl<R: Real> PointFinder<R> {
    /// From the place of a sphere's centre to the pixel `(i, j)`, at distance 1.
    pub fn sphere_aside(&self, sphere: &SeenSphereOf<R>, i: R, j: R) -> Vec3<R> {
        let across = (i - sphere.place[0]) - sphere.place_low[0];
        let up = (j - sphere.place[1]) - sphere.place_low[1];
        self.right_step * across + self.true_up_step * up
    }

    /// From the ray to a place at this offset from its origin, across the ray.
    pub fn across_ray(&self, ray: &RayOf<R>, l: Vec3<R>) -> Vec3<R> {
        l - ray.direction * (dot3(ray.direction, l) * ray.inv_a)
    }

    /// Where a ray meets a sphere.
    pub fn sphere_point(
        &self,
        ray: &RayOf<R>,
        aside: Vec3<R>,
        sphere: &SeenSphereOf<R>,
        narrow: &NarrowSphereOf<R>,
    ) -> PointOf<R> {
        let (room, r) = (&self.room, narrow.radius);
        let l = if sphere.depth > R::ZERO { -aside * sphere.depth } else { narrow.center };
        let p = self.across_ray(ray, l);
        let m = dot3(p, p);
        let far = dot3(l, l).sqrt();
        let foot_error = room.foot * far + sphere.error;
        let across = room.across * far + sphere.error;
        let r2 = r * r;
        let half2 = r2 - m;
        let half2_error = R::TWO * (m.sqrt() * across + foot_error * foot_error) + room.square * r2;
        let is_known = (half2 > R::FOUR * half2_error) & (sphere.side != R::ZERO);
        let known2 = if is_known { half2 } else { R::ONE };
        let chord = ray.direction * ((known2 * ray.inv_a).sqrt() * sphere.side);
        let out = -p - chord;
        let off = foot_error + room.half * half2_error / known2.sqrt() + room.chord * r;
        let at = narrow.center + (narrow.center_low + out);
        let error = room.room * (off + room.unit * (r + dot3(at, at).sqrt()));
        let normal = out * (sphere.inverse_radius * sphere.side);
        let normal_error = room.room * (off * sphere.inverse_radius + room.normal);
        let is_inside = sphere.side < R::ZERO;
        PointOf { at, error, normal, normal_error, is_known, is_inside }
    }

    /// Where a ray meets a plane.
    pub fn plane_point(&self, ray: &RayOf<R>, plane: &SeenPlaneOf<R>, i: R, j: R) -> PointOf<R> {
        let room = &self.room;
        let Vec3([ahead, right, top]) = plane.slope;
        let (across, up) = (right * i, top * j);
        let length = ray.a.sqrt();
        let sizes = |first: R| (first.abs() + across.abs()) + up.abs();
        let (slope, offset, of_slope, of_offset) = match self.lens {
            Lens::Perspective => {
                ((ahead + across) + up, plane.offset, sizes(ahead), plane.offset.abs())
            }
            Lens::Orthographic => {
                (ahead, (plane.offset - across) - up, ahead.abs(), sizes(plane.offset))
            }
        };
        let slope_error = room.sum * of_slope + room.slope * length;
        let offset_error = room.sum * of_offset + plane.error;
        let is_apart = (slope.abs() > room.apart * slope_error)
            & (offset.abs() > room.apart * offset_error)
            & (offset.abs() > room.least);
        let known = |number: R| if is_apart { number } else { R::ONE };
        let (by_slope, by_offset) = (R::ONE / known(slope), R::ONE / known(offset));
        let t = if is_apart { offset * by_slope } else { R::ZERO };
        let is_known = (t > R::ZERO) & (t * length < room.reach);
        let t = if is_known { t } else { R::ZERO };
        let reach = t * length;
        let relative = slope_error * by_slope.abs() + offset_error * by_offset.abs();
        let start = dot3(ray.origin, ray.origin).sqrt();
        let error = room.room * (reach * (relative + room.ray) + room.origin * start);
        PointOf {
            at: ray.origin + ray.direction * t,
            error,
            normal: if slope > R::ZERO { -plane.unit } else { plane.unit },
            normal_error: room.unit,
            is_known,
            is_inside: false,
        }
    }
}

/// The numbers of a picture's objects for a device that shades in f32.
pub struct SeenFrom {
    camera: CameraF64,
    reference: DVec3,
    longest: f64,
    /// Largest distance of an origin from the reference point.
    spread: f64,
}

impl SeenFrom {
    /// For the rays of a picture; points are relative to `reference`, where its camera is.
    pub fn new(pixels: &Pixels, reference: DVec3) -> SeenFrom {
        let (longest, spread) = (pixels.longest_direction(), pixels.spread());
        SeenFrom { camera: CameraF64::new(pixels), reference, longest, spread }
    }

    /// A sphere's numbers; the side is 0 where f32 can't tell where its rays meet it.
    pub fn sphere(&self, sphere: &Sphere) -> SeenSphere {
        let unknown = SeenSphere::default();
        let (l, r) = (sphere.center - self.reference, sphere.radius.abs());
        let is_far = l.abs().max_element() > REACH / 2.0 || r * self.longest > 1.0 / LEAST;
        if is_far || self.longest > LONGEST_IN_F32 || r < LEAST.sqrt() {
            return unknown;
        }
        let CameraF64 { forward, right, true_up, step, lens } = self.camera;
        let [forward, right, true_up] = [forward, right, true_up].map(|v| DVec3::from_array(v.0));
        let (ahead, lost) = (l.dot(forward), LOST * (l.length() + self.spread));
        let (scale, side) = match lens {
            Lens::Perspective => {
                let (k, error) = (l.length_squared() - r * r, LOST * (l.length_squared() + r * r));
                (ahead, if k.abs() > error { k.signum() as f32 } else { 0.0 })
            }
            // The picture's plane, which is across the axis up to `2⁻¹⁰`, lies outside of it.
            Lens::Orthographic => {
                let depth = ahead - self.spread / 512.0;
                (1.0, if depth > r + 2.0 * lost + LOST * r { 1.0 } else { 0.0 })
            }
        };
        if side == 0.0 {
            return unknown;
        }
        let inverse_radius = (1.0 / r) as f32;
        let place = [l.dot(right), l.dot(true_up)].map(|x| x / (scale * step));
        let is_ahead =
            scale * LONGEST_IN_F32 > if lens == Lens::Perspective { l.length() } else { 1.0 };
        if !(is_ahead && place.iter().all(|x| x.abs() < FARTHEST)) {
            let is_known = lens == Lens::Perspective;
            let numbers = SeenSphere { error: round_up(lost), inverse_radius, side, ..unknown };
            return if is_known { numbers } else { unknown };
        }
        let (high, low) = split(DVec3::new(place[0], place[1], 0.0));
        let held = |axis: usize| (f64::from(high[axis]) + f64::from(low[axis])) * scale * step;
        let missed = l - forward * ahead - right * held(0) - true_up * held(1);
        SeenSphere {
            place: [high[0], high[1]],
            place_low: [low[0], low[1]],
            depth: scale as f32,
            error: round_up(missed.length() + lost),
            inverse_radius,
            side,
        }
    }

    /// A plane's numbers; the offset is 0 where f32 has none.
    pub fn plane(&self, plane: &Plane) -> SeenPlane {
        let l = plane.point - self.reference;
        if plane.normal == DVec3::ZERO || l.abs().max_element() > REACH / 2.0 {
            return SeenPlane::default();
        }
        let unit = Scaled::new(plane.normal).rounded().normalize();
        let CameraF64 { forward, right, true_up, step, .. } = self.camera;
        let of = |v: Vec3<f64>| unit.dot(DVec3::from_array(v.0));
        SeenPlane {
            slope: [of(forward), of(right) * step, of(true_up) * step].map(|x| x as f32),
            offset: unit.dot(l) as f32,
            unit: unit.as_vec3().to_array(),
            error: round_up(LOST * (l.length() + self.spread)),
        }
    }
}
