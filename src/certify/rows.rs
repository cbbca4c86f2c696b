//! `t` and normals of neighbours in a row of pixels that see one object, side by side, in f64 or f32. Their bounds are
//! those of [`crate::guard::rows`]; what these leave open goes to [`super::surfaces`].

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use super::nearness::PlaneF64;
use super::{Stage, StageRays};
use crate::guard::host::{Bounded, input_in_f32};
use crate::guard::rows::{ACROSS, ChordGuard, INVERSE, MOST_OF_SLOPE, QUOTIENT};
use crate::guard::{self, InputError, ROOM};
use crate::kernel::RayOf;
use crate::kernel::certified::closest_approach;
use crate::rays::{Lens, Pixels};
use crate::scene::{Object, Sphere};
use crate::vec3::{Real, Vec3, dot3};
use crate::wide::{Holds, SideBySide};

/// Where rays meet what they hit, seen from their origins.
pub struct Reached<R: SideBySide> {
    /// Where the others are known.
    pub is_known: R::Mask,
    pub t: R,
    /// What `t` is off by, as a length.
    pub error: R,
    /// Of about unit length, towards the origin.
    pub normal: Vec3<R>,
    pub normal_error: R,
}

/// An object as all rays of a picture see it, in numbers of `F`.
pub enum RowSight<F> {
    Sphere(SphereRow<F>),
    Plane(PlaneRow<F>),
}

/// What rays that hit an object find.
pub trait Finds<F> {
    /// True for a sphere that the rays start in.
    fn is_inside(&self) -> bool {
        false
    }
    /// With bounds for each ray; none is longer than `longest`.
    fn reach<R: SideBySide<Plain = F>>(&self, rays: &RayOf<R>, longest: f64) -> Reached<R>;
}

/// A sphere that all rays start outside of, or all inside.
pub struct SphereRow<F> {
    /// From the camera's position.
    center: Vec3<F>,
    r: F,
    is_outside: bool,
    guard: ChordGuard,
}

/// A chord of a sphere.
struct Chord<R: SideBySide> {
    /// Whether its bounds hold.
    is_known: R::Mask,
    half: R,
    /// At the visible end.
    t: R,
    radius: Vec3<R>,
}

/// The nearest number in all places.
#[inline(always)]
fn like<R: SideBySide>(some: R, number: f64) -> R {
    some.like(R::Plain::from_f64(number))
}

impl<F: Bounded> SphereRow<F> {
    /// The radius is [`crate::kernel::certified::half_chord_radius`], in the same steps.
    #[inline(always)]
    fn chord<R: SideBySide<Plain = F>>(&self, rays: &RayOf<R>) -> Chord<R> {
        let &SphereRow { center, r, is_outside, guard: ChordGuard { least2, .. } } = self;
        let &RayOf { origin, direction, a, inv_a, .. } = rays;
        let l = a.like3(center) - origin;
        let (s, m) = closest_approach(direction, inv_a, l);
        let p = l - direction * s;
        let chord2 = a.like(r * r) - m;
        let half = (chord2.max(a.like(F::ZERO)) * inv_a).sqrt();
        let chord = direction * half;
        let (t, radius) = match is_outside {
            true => (s - half, -p - chord),
            false => (s + half, p - chord),
        };
        Chord { is_known: like(a, least2).le(chord2), half, t, radius }
    }

    /// What the normal at the end of half a chord is off by.
    #[inline(always)]
    fn normal_error<R: SideBySide<Plain = F>>(&self, half: R) -> R {
        let ChordGuard { of_chord, of_normal, .. } = self.guard;
        let off = like(half, of_normal) + like(half, of_chord) / half;
        off * half.like(F::from_f64(ROOM) / self.r)
    }
}

impl<F: Bounded> Finds<F> for SphereRow<F> {
    fn is_inside(&self) -> bool {
        !self.is_outside
    }

    #[inline(always)]
    fn reach<R: SideBySide<Plain = F>>(&self, rays: &RayOf<R>, longest: f64) -> Reached<R> {
        let a = rays.a;
        let ChordGuard { slack, of_chord, .. } = self.guard;
        let Chord { is_known, half, t, radius } = self.chord(rays);
        let of_half = like(a, of_chord) / half;
        Reached {
            is_known: is_known.and(a.like(F::ZERO).lt(t)),
            t,
            error: like(a, slack * longest) + of_half,
            normal: radius * a.like(F::ONE / self.r),
            normal_error: self.normal_error(half),
        }
    }
}

/// A plane.
pub struct PlaneRow<F> {
    /// Its normal times a point of it, from the camera's position.
    offset: F,
    normal: Vec3<F>,
    /// Unit length, either way.
    unit: Vec3<F>,
    unit_error: f64,
    /// Of `N`, and of `M`.
    offset_error: f64,
    slope_error: f64,
}

/// Where rays meet a plane.
struct Crossing<R: SideBySide> {
    is_known: R::Mask,
    t: R,
    error: R,
    /// Whether the ray runs along [`PlaneRow::unit`].
    is_along: R::Mask,
}

impl<F: Bounded> PlaneRow<F> {
    #[inline(always)]
    fn crossing<R: SideBySide<Plain = F>>(&self, rays: &RayOf<R>) -> Crossing<R> {
        let &PlaneRow { offset, normal, unit, offset_error, slope_error, .. } = self;
        let &RayOf { origin, direction, a, .. } = rays;
        let (normal, unit, zero) = (a.like3(normal), a.like3(unit), a.like(F::ZERO));
        let slope = dot3(direction, normal);
        let inverse = a.like(F::ONE) / slope;
        let t = (a.like(offset) - dot3(origin, normal)) * inverse;
        let of_quotient = inverse.abs() * (like(a, offset_error) + t * like(a, slope_error));
        let is_along = zero.lt(dot3(unit, direction));
        Crossing {
            is_known: like(a, slope_error).lt(slope.abs() * like(a, MOST_OF_SLOPE)),
            t,
            error: of_quotient * like(a, QUOTIENT) + t * like(a, INVERSE * F::UNIT),
            is_along,
        }
    }
}

/// A vector, turned where this holds; not to `−0`.
#[inline(always)]
fn turned<R: SideBySide>(holds: R::Mask, v: Vec3<R>) -> Vec3<R> {
    let [x, y, z] = v.0;
    let turned = |x: R| R::select(holds, x.like(R::Plain::ZERO) - x, x);
    Vec3([turned(x), turned(y), turned(z)])
}

impl<F: Bounded> Finds<F> for PlaneRow<F> {
    #[inline(always)]
    fn reach<R: SideBySide<Plain = F>>(&self, rays: &RayOf<R>, longest: f64) -> Reached<R> {
        let Crossing { is_known, t, error, is_along } = self.crossing(rays);
        Reached {
            is_known: is_known.and(t.like(F::ZERO).lt(t)),
            t,
            error: error * like(t, longest),
            normal: turned(is_along, t.like3(self.unit)),
            normal_error: like(t, self.unit_error),
        }
    }
}

/// What rays of a picture are off by in numbers of `F`.
pub trait OfPicture: Bounded {
    /// Most that a sphere's normal may be off by.
    const TOLERANCE: f64;
    /// What the rays are off by.
    fn input(stage: &Stage) -> InputError;
    /// Whether objects at distance up to `l` keep it in range.
    fn holds(pixels: &Pixels, l: f64) -> bool;
    /// The same for a sphere of radius `r`.
    fn holds_sphere(r: f64, l: f64) -> bool;
    /// `N` of a plane and its error, and its normal.
    fn plane(plane: &PlaneF64, pixels: &Pixels, stage: &Stage) -> PlaneRow<Self>;
}

/// Most that the normal of a sphere may be off by in f32: a part of a byte.
const TOLERANCE_F32: f64 = 1.0 / (1u64 << 10) as f64;

/// Largest distance for f32. With radii from `2⁻⁴⁰` and directions up to [`guard::LONGEST_IN_F32`], what is under a root is
/// above `2⁻⁹⁴·2⁻²⁰`, and squares are below `2⁸⁰·2²⁰`.
const FARTHEST: f64 = (1u64 << 40) as f64;

/// What says nothing.
const UNKNOWN: InputError = InputError { offset: f64::INFINITY, direction: f64::INFINITY };

impl OfPicture for f32 {
    const TOLERANCE: f64 = TOLERANCE_F32;

    fn input(stage: &Stage) -> InputError {
        match &stage.rays {
            StageRays::Pixels { pixels, .. } => input_in_f32(pixels.view.lens),
            StageRays::List(_) => UNKNOWN,
        }
    }

    fn holds(pixels: &Pixels, l: f64) -> bool {
        l <= FARTHEST && pixels.longest_direction() <= guard::LONGEST_IN_F32
    }

    fn holds_sphere(r: f64, l: f64) -> bool {
        l <= FARTHEST && guard::sphere_in_range_f32(r, l)
    }

    fn plane(plane: &PlaneF64, pixels: &Pixels, stage: &Stage) -> PlaneRow<f32> {
        let point = plane.point - pixels.view.position;
        let scale = 1.0 / plane.length();
        let offset = dot3(Vec3::from(point), plane.normal) * scale;
        let of_point = plane.offset_error(guard::length_bound(point), stage.bounds.input) * scale;
        let unit = Vec3(plane.unit.0.map(|x| x as f32));
        let slope = guard::plane_direction_error(1.0, f32::UNIT, Self::input(stage));
        PlaneRow {
            offset: offset as f32,
            normal: unit,
            unit,
            unit_error: ROOM * f32::UNIT,
            offset_error: ROOM * of_point
                + f32::UNIT * (2.0 * ROOM * offset.abs() + ACROSS * pixels.spread())
                + guard::TINY_F32,
            slope_error: ROOM * (slope + f32::UNIT) * pixels.longest_direction(),
        }
    }
}

impl Stage<'_> {
    /// An object as all rays of the picture see it; `None` for lists, and where that is of no use.
    pub fn narrow_sight<F: OfPicture>(&self, id: u32) -> Option<RowSight<F>> {
        let StageRays::Pixels { pixels, .. } = &self.rays else { return None };
        match self.scene.object(id)? {
            _ if !self.usable => None,
            Object::Sphere(sphere) => self.sphere_row(pixels, id, sphere).map(RowSight::Sphere),
            Object::Plane(_) => self.plane_row(pixels, self.plane(id)).map(RowSight::Plane),
        }
    }

    fn sphere_row<F: OfPicture>(
        &self,
        pixels: &Pixels,
        id: u32,
        sphere: &Sphere,
    ) -> Option<SphereRow<F>> {
        let (center, r) = (sphere.center - pixels.view.position, sphere.radius.abs());
        let from_position = guard::length_bound(center);
        let distance = from_position + pixels.spread();
        if !(F::holds(pixels, distance) && F::holds_sphere(r, distance)) {
            return None;
        }
        let is_outside = match pixels.view.lens {
            Lens::Perspective => {
                let k = self.known_k(id, sphere)?;
                if k.value.abs() <= k.error {
                    return None;
                }
                k.value > 0.0
            }
            // All rays start on one side of it, in a plane that is across the axis up to `2⁻¹⁰`.
            Lens::Orthographic => {
                let depth = center.dot(pixels.view.forward) - pixels.spread() / 512.0;
                depth > 1.01 * r
            }
        };
        let guard = ChordGuard::new(r, distance, F::UNIT, F::input(self), F::TOLERANCE)?;
        let is_known = is_outside || pixels.view.lens == Lens::Perspective;
        let center = Vec3(center.to_array().map(F::from_f64));
        let row = SphereRow { center, r: F::from_f64(r), is_outside, guard };
        is_known.then_some(row)
    }

    fn plane_row<F: OfPicture>(&self, pixels: &Pixels, plane: &PlaneF64) -> Option<PlaneRow<F>> {
        let point = plane.point - pixels.view.position;
        let distance = guard::length_bound(point) + pixels.spread();
        F::holds(pixels, distance).then(|| F::plane(plane, pixels, self))
    }
}
