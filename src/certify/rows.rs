//! `t` and normals of neighbours in a row of pixels that see one object, side by side. Their bounds are those of
//! [`crate::guard::rows`]; what these leave open goes to [`super::surface`].

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use pulp::Simd;

use super::nearness::PlaneF64;
use super::surface::{NORMAL_TOLERANCE, Surface};
use super::{Stage, StageRays};
use crate::guard::rows::{ChordGuard, INVERSE, MOST_OF_SLOPE, QUOTIENT};
use crate::guard::{self, UNIT_F64};
use crate::kernel::RayOf;
use crate::kernel::certified::closest_approach;
use crate::rays::{CameraF64, Lens, Pixels};
use crate::scene::{Object, Sphere};
use crate::vec3::{Vec3, dot3};
use crate::wide::{Holds, MaskF64, SideBySide, WideF64};

/// Part of `t` up to which an error is of use: f32 then leaves one of a thousand rays open.
const MOST_ERROR: f64 = 1.0 / (1u64 << 36) as f64;

/// Part of `t` up to which an error is of use for points. Where it is more, for one beside a sphere that is large,
/// the bounds of [`super::surface`] are narrower.
const MOST_OF_POINT: f64 = 1.0 / (1u64 << 46) as f64;

/// Rays whose numbers are held at once.
const BLOCK: usize = 16;

/// Most numbers of a register.
const MOST_LANES: usize = 8;

/// What is found of rays: two numbers that `t` lies between, where the lower one is positive, and the
/// normals.
pub struct Found<S: Simd> {
    low: WideF64<S>,
    high: WideF64<S>,
    normal: Vec3<WideF64<S>>,
}

/// Where rays meet what they hit, seen from their origins.
pub struct Reached<S: Simd> {
    /// Where the others are known.
    pub is_known: MaskF64<S>,
    pub t: WideF64<S>,
    /// What `t` is off by, as a length.
    pub error: WideF64<S>,
    /// Of about unit length, towards the origin.
    pub normal: Vec3<WideF64<S>>,
    pub normal_error: WideF64<S>,
}

/// An object as all rays of a picture see it.
pub enum RowSight {
    Sphere(SphereRow),
    Plane(PlaneRow),
}

/// What rays that hit an object find.
pub trait Finds {
    /// True for a sphere that the rays start in.
    fn is_inside(&self) -> bool {
        false
    }
    fn find<S: Simd>(&self, rays: &RayOf<WideF64<S>>) -> Found<S>;
    /// The same with bounds for each ray; none is longer than `longest`.
    fn reach<S: Simd>(&self, rays: &RayOf<WideF64<S>>, longest: f64) -> Reached<S>;
}

/// A sphere that all rays start outside of, or all inside.
pub struct SphereRow {
    /// From the camera's position.
    center: Vec3<f64>,
    r: f64,
    is_outside: bool,
    guard: ChordGuard,
}

/// A chord of a sphere.
struct Chord<S: Simd> {
    /// Whether its bounds hold.
    is_known: MaskF64<S>,
    half: WideF64<S>,
    /// At the visible end.
    t: WideF64<S>,
    radius: Vec3<WideF64<S>>,
}

impl SphereRow {
    /// The radius is [`crate::kernel::certified::half_chord_radius`], in the same steps.
    #[inline(always)]
    fn chord<S: Simd>(&self, rays: &RayOf<WideF64<S>>) -> Chord<S> {
        let &SphereRow { center, r, is_outside, guard: ChordGuard { least2, .. } } = self;
        let &RayOf { origin, direction, a, inv_a, .. } = rays;
        let l = a.like3(center) - origin;
        let (s, m) = closest_approach(direction, inv_a, l);
        let p = l - direction * s;
        let chord2 = a.like(r * r) - m;
        let half = (chord2.max(a.like(0.0)) * inv_a).sqrt();
        let chord = direction * half;
        let (t, radius) = match is_outside {
            true => (s - half, -p - chord),
            false => (s + half, p - chord),
        };
        Chord { is_known: a.like(least2).le(chord2), half, t, radius }
    }
}

impl Finds for SphereRow {
    fn is_inside(&self) -> bool {
        !self.is_outside
    }

    #[inline(always)]
    fn find<S: Simd>(&self, rays: &RayOf<WideF64<S>>) -> Found<S> {
        let a = rays.a;
        let error = a.like(self.guard.error);
        let Chord { is_known, t, radius, .. } = self.chord(rays);
        Found {
            low: is_known.select(t - error, a.like(0.0)),
            high: t + error,
            normal: radius * (a.like(1.0) / dot3(radius, radius).sqrt()),
        }
    }

    #[inline(always)]
    fn reach<S: Simd>(&self, rays: &RayOf<WideF64<S>>, longest: f64) -> Reached<S> {
        let like = |number: f64| rays.a.like(number);
        let ChordGuard { slack, of_chord, of_normal, .. } = self.guard;
        let Chord { is_known, half, t, radius } = self.chord(rays);
        let of_half = like(of_chord) / half;
        Reached {
            is_known: is_known.and(like(0.0).lt(t)),
            t,
            error: like(slack * longest) + of_half,
            normal: radius * like(1.0 / self.r),
            normal_error: (like(of_normal) + of_half) * like(1.01 / self.r),
        }
    }
}

/// A plane.
pub struct PlaneRow {
    /// A point of it, from the camera's position.
    point: Vec3<f64>,
    normal: Vec3<f64>,
    /// Unit length, either way.
    unit: Vec3<f64>,
    /// Of `N`, and of `M`.
    offset_error: f64,
    slope_error: f64,
}

/// Where rays meet a plane.
struct Crossing<S: Simd> {
    is_known: MaskF64<S>,
    t: WideF64<S>,
    error: WideF64<S>,
    normal: Vec3<WideF64<S>>,
}

impl PlaneRow {
    #[inline(always)]
    fn crossing<S: Simd>(&self, rays: &RayOf<WideF64<S>>) -> Crossing<S> {
        let &PlaneRow { point, normal, unit, offset_error, slope_error } = self;
        let &RayOf { origin, direction, a, .. } = rays;
        let (normal, unit) = (a.like3(normal), a.like3(unit));
        let slope = dot3(direction, normal);
        let inverse = a.like(1.0) / slope;
        let t = dot3(a.like3(point) - origin, normal) * inverse;
        let of_quotient = inverse.abs() * (a.like(offset_error) + t * a.like(slope_error));
        let is_along = a.like(0.0).lt(dot3(unit, direction));
        let [x, y, z] = unit.0;
        Crossing {
            is_known: a.like(slope_error).lt(slope.abs() * a.like(MOST_OF_SLOPE)),
            t,
            error: of_quotient * a.like(QUOTIENT) + t * a.like(INVERSE * UNIT_F64),
            normal: Vec3([is_along.select(-x, x), is_along.select(-y, y), is_along.select(-z, z)]),
        }
    }
}

impl Finds for PlaneRow {
    #[inline(always)]
    fn find<S: Simd>(&self, rays: &RayOf<WideF64<S>>) -> Found<S> {
        let Crossing { is_known, t, error, normal } = self.crossing(rays);
        Found { low: is_known.select(t - error, t.like(0.0)), high: t + error, normal }
    }

    #[inline(always)]
    fn reach<S: Simd>(&self, rays: &RayOf<WideF64<S>>, longest: f64) -> Reached<S> {
        let Crossing { is_known, t, error, normal } = self.crossing(rays);
        Reached {
            is_known: is_known.and(t.like(0.0).lt(t)),
            t,
            error: error * t.like(longest),
            normal,
            normal_error: t.like(guard::steps::NORMALIZED * UNIT_F64),
        }
    }
}

impl Stage<'_> {
    /// An object as all rays of the picture see it; `None` for lists, and where that is of no use.
    pub fn row_sight(&self, id: u32) -> Option<RowSight> {
        self.sight_with(id, |sphere, least_t| sphere.guard.error <= MOST_ERROR * least_t)
    }

    /// The same, for those who want bounds for each ray.
    pub fn point_sight(&self, id: u32) -> Option<RowSight> {
        self.sight_with(id, |sphere, least_t| {
            let ChordGuard { slack, of_chord, .. } = sphere.guard;
            slack + of_chord / sphere.r <= MOST_OF_POINT * least_t
        })
    }

    /// `is_of_use` is told of a sphere and of the least `t` that it is seen at.
    fn sight_with(&self, id: u32, is_of_use: impl Fn(&SphereRow, f64) -> bool) -> Option<RowSight> {
        let StageRays::Pixels { pixels, .. } = &self.rays else { return None };
        match self.scene.object(id)? {
            _ if !self.usable => None,
            Object::Sphere(sphere) => {
                let (row, least_t) = self.sphere_row(pixels, id, sphere)?;
                is_of_use(&row, least_t).then_some(RowSight::Sphere(row))
            }
            Object::Plane(_) => self.plane_row(pixels, self.plane(id)).map(RowSight::Plane),
        }
    }

    /// A sphere, and the least `t` that it is seen at.
    fn sphere_row(&self, pixels: &Pixels, id: u32, sphere: &Sphere) -> Option<(SphereRow, f64)> {
        let (center, r) = (sphere.center - pixels.view.position, sphere.radius.abs());
        let from_position = guard::length_bound(center);
        let distance = from_position + pixels.spread();
        if !guard::sphere_in_range_f64(r, distance) {
            return None;
        }
        let (is_outside, least_t) = match pixels.view.lens {
            Lens::Perspective => {
                let k = self.known_k(id, sphere)?;
                if k.value.abs() <= k.error {
                    return None;
                }
                (k.value > 0.0, (from_position - r).abs() / pixels.longest_direction())
            }
            // All rays start on one side of it, in a plane that is across the axis up to `2⁻¹⁰`.
            Lens::Orthographic => {
                let depth = center.dot(pixels.view.forward) - pixels.spread() / 512.0;
                (depth > 1.01 * r, depth - r)
            }
        };
        let guard = ChordGuard::new(r, distance, self.bounds.input, NORMAL_TOLERANCE)?;
        let is_known = is_outside || pixels.view.lens == Lens::Perspective;
        is_known.then_some((SphereRow { center: center.into(), r, is_outside, guard }, least_t))
    }

    fn plane_row(&self, pixels: &Pixels, plane: &PlaneF64) -> Option<PlaneRow> {
        let point = plane.point - pixels.view.position;
        let distance = guard::length_bound(point) + pixels.spread();
        guard::plane_in_range_f64(distance).then(|| PlaneRow {
            point: point.into(),
            normal: plane.normal,
            unit: plane.unit,
            offset_error: plane.offset_error(distance, self.bounds.input),
            slope_error: plane.direction_error * pixels.longest_direction(),
        })
    }
}

impl RowSight {
    /// Finds `t` and normals of neighbours that hit it, the first one at this
    /// [`crate::rays::Pixels::offset2`]: a `t` of 0 where they are open.
    pub fn find(
        &self,
        camera: &CameraF64,
        offset: (i64, i64),
        t: &mut [f32],
        normal: &mut [[f32; 3]],
    ) {
        let arch = pulp::Arch::new();
        match self {
            RowSight::Sphere(sight) => arch.dispatch(Row { sight, camera, offset, t, normal }),
            RowSight::Plane(sight) => arch.dispatch(Row { sight, camera, offset, t, normal }),
        }
    }

    /// The same of one pixel.
    pub fn find_one(&self, camera: &CameraF64, offset: (i64, i64)) -> Option<Surface> {
        let (mut t, mut normal) = ([0.0], [[0.0; 3]]);
        let simd = pulp::Scalar;
        let (t_of, normal_of) = (&mut t, &mut normal);
        match self {
            RowSight::Sphere(sight) => {
                Row { sight, camera, offset, t: t_of, normal: normal_of }.find(simd);
            }
            RowSight::Plane(sight) => {
                Row { sight, camera, offset, t: t_of, normal: normal_of }.find(simd);
            }
        }
        (t[0] > 0.0).then_some((t[0], normal[0]))
    }
}

/// Neighbours that hit one object.
struct Row<'a, T> {
    sight: &'a T,
    camera: &'a CameraF64,
    offset: (i64, i64),
    t: &'a mut [f32],
    normal: &'a mut [[f32; 3]],
}

impl<T: Finds> Row<'_, T> {
    #[inline(always)]
    fn find<S: Simd>(self, simd: S) {
        let Row { sight, camera, offset: (i, j), t, normal } = self;
        let n_lanes = WideF64::<S>::LANES.min(MOST_LANES);
        let places: [f64; MOST_LANES] = std::array::from_fn(|lane| 2.0 * lane as f64);
        let (places, j) = (WideF64::load(simd, &places), WideF64::splat(simd, j as f64));
        let (mut low, mut high) = ([0.0; BLOCK], [0.0; BLOCK]);
        let mut normals = [[0.0; BLOCK]; 3];
        for (block, (t, normal)) in t.chunks_mut(BLOCK).zip(normal.chunks_mut(BLOCK)).enumerate() {
            for first in (0..t.len()).step_by(n_lanes) {
                let column = i + 2 * (block * BLOCK + first) as i64;
                let found = sight.find(&camera.camera_rays(j.like(column as f64) + places, j));
                found.low.store(&mut low[first..]);
                found.high.store(&mut high[first..]);
                for axis in 0..3 {
                    found.normal.0[axis].store(&mut normals[axis][first..]);
                }
            }
            let (mut ts, mut rounded) = ([0.0; BLOCK], [[0.0; 3]; BLOCK]);
            for lane in 0..BLOCK {
                let (low, high) = (low[lane] as f32, high[lane] as f32);
                let is_certain = (low > 0.0) & (low == high) & (high < f32::INFINITY);
                ts[lane] = if is_certain { low } else { 0.0 };
            }
            for lane in 0..BLOCK {
                let [x, y, z] = &normals;
                rounded[lane] = [x[lane] as f32, y[lane] as f32, z[lane] as f32];
            }
            put(&ts, t);
            put(&rounded, normal);
        }
    }
}

/// The first numbers of a block into a slice; a whole block without a call.
#[inline(always)]
fn put<T: Copy>(block: &[T; BLOCK], to: &mut [T]) {
    match <&mut [T; BLOCK]>::try_from(&mut *to) {
        Ok(to) => *to = *block,
        Err(_) => to.copy_from_slice(&block[..to.len()]),
    }
}

impl<T: Finds> pulp::WithSimd for Row<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.find(simd);
    }
}
