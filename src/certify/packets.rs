//! Rays that f64 decides side by side, where objects are tested one after the other: the steps of
//! [`Stage::decide_f64`] without its branches. What they leave open goes there.

use std::collections::HashSet;
use std::ops::Range;

use glam::DVec3;
use pulp::Simd;

use super::decide::bits;
use super::nearness::{Foot, K, Place, PlaneF64, t_f32};
use super::surface::Bounds;
use super::{RayF64, Stage, StageRays};
use crate::control::Control;
use crate::error::Result;
use crate::guard::{self, Guard};
use crate::kernel::RayOf;
use crate::kernel::certified::{
    GuardOf, NearestOf, Nearness, UNDECIDED, Widening, closest_approach, inside_at, outside_at,
    plane_nearness_at, plane_nearness_of, sphere_nearness,
};
use crate::rays::Pixels;
use crate::scene::{Object, Sphere};
use crate::vec3::{Vec3, dot3};
use crate::wide::{SideBySide, WideF64};

/// Most numbers of a register.
const MOST_LANES: usize = 8;

type Lanes = [f64; MOST_LANES];

/// More objects than this are found through a hierarchy where there is one.
const MOST_TESTED: u32 = 64;

/// Of more objects, equal ones are not looked for.
const MOST_COMPARED: u32 = 256;

/// Rays of a stage in packets, and the objects as they see them.
pub struct Packets<'a> {
    stage: &'a Stage<'a>,
    bounds: Bounds,
    /// Of the rays of pixels.
    reference: DVec3,
    objects: Vec<(u32, Sight<'a>)>,
}

/// An object as all rays see it.
enum Sight<'a> {
    /// A sphere that all rays start outside of, at one point.
    Outside { l: Vec3<f64>, guard: GuardOf<f64>, q: Nearness<f64> },
    /// A sphere that all rays start inside of, at one point.
    Inside { l: Vec3<f64>, guard: GuardOf<f64>, q: Nearness<f64> },
    /// A plane that all rays start from one point to.
    Plane { away: Vec3<f64>, direction_error: f64, q: Nearness<f64> },
    /// A sphere, and its `k` for the camera's position.
    AnySphere(&'a Sphere, Option<K>),
    /// A plane.
    AnyPlane(&'a PlaneF64),
}

/// Some rays with origins of their own, relative to a reference point of their own.
struct Origins {
    reference: [Lanes; 3],
    origin: [Lanes; 3],
    direction: [Lanes; 3],
}

/// The numbers of some rays, and what is nearest to each so far.
struct Packet<'a, S: Simd> {
    rays: RayOf<WideF64<S>>,
    origins: &'a Origins,
    nearest: NearestOf<WideF64<S>>,
}

impl<'a> Packets<'a> {
    /// `None` where f64 knows too little of an object to decide anything, or where it pays to find
    /// objects through the hierarchy.
    pub fn new(stage: &'a Stage<'a>) -> Option<Packets<'a>> {
        let n_objects = stage.scene.n_objects() as u32;
        let is_compared = n_objects <= MOST_COMPARED;
        if !stage.usable || stage.hierarchy.is_some() && n_objects > MOST_TESTED {
            return None;
        }
        let (mut seen, mut objects) = (HashSet::new(), Vec::new());
        for id in 1..=n_objects {
            let Some(object) = stage.scene.object(id) else { continue };
            // Of equal objects, the lowest id wins.
            if is_compared && !seen.insert(bits(object)) {
                continue;
            }
            match object {
                Object::Sphere(sphere) if sphere.radius == 0.0 => {}
                Object::Plane(plane) if plane.normal == DVec3::ZERO => {}
                Object::Sphere(sphere) => objects.push((id, stage.sphere_sight(id, sphere)?)),
                Object::Plane(_) => objects.push((id, stage.plane_sight(id)?)),
            }
        }
        let reference = match &stage.rays {
            StageRays::Pixels { pixels, .. } => pixels.view.position,
            StageRays::List(_) => DVec3::ZERO,
        };
        Some(Packets { stage, bounds: stage.bounds, reference, objects })
    }

    /// Decides `rays`, whose ids are [`UNDECIDED`] where f64 leaves them open.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn decide(&self, rays: &[u32], control: &Control, ids: &mut [u32]) -> Result<()> {
        pulp::Arch::new().dispatch(Decide { packets: self, rays, control, ids })
    }
}

/// The row of pixels that the last ray was in.
#[derive(Default)]
struct Row {
    rays: Range<usize>,
    /// [`crate::rays::Pixels::offset2`] of the first pixel.
    offset: (i64, i64),
}

impl<'a> Stage<'a> {
    fn sphere_sight(&'a self, id: u32, sphere: &'a Sphere) -> Option<Sight<'a>> {
        let Some(ray) = self.ray_of_all() else {
            let known = match &self.rays {
                StageRays::Pixels { .. } => self.known_k(id, sphere),
                StageRays::List(_) => None,
            };
            return Some(Sight::AnySphere(sphere, known));
        };
        let Foot { l, k, guard, .. } = self.sphere_foot(&ray, id, sphere)?;
        let (guard, q) = (guard_of(&guard), self.bounds.widening.inverse(k.value.abs(), k.error));
        if k.value.abs() <= k.error {
            None
        } else if k.value > 0.0 {
            Some(Sight::Outside { l, guard, q })
        } else {
            Some(Sight::Inside { l, guard, q })
        }
    }

    fn plane_sight(&'a self, id: u32) -> Option<Sight<'a>> {
        let plane = self.plane(id);
        let Some(ray) = self.ray_of_all() else { return Some(Sight::AnyPlane(plane)) };
        let (offset, error) = plane.offset(&ray, self.bounds.input);
        let &PlaneF64 { normal, direction_error, .. } = plane;
        let q = self.bounds.widening.inverse(offset.abs(), error);
        let away = if offset < 0.0 { -normal } else { normal };
        (offset.abs() > error).then_some(Sight::Plane { away, direction_error, q })
    }
}

fn guard_of(guard: &Guard) -> GuardOf<f64> {
    let &Guard { inner2, outer2, slack, .. } = guard;
    GuardOf { inner2, outer2, slack }
}

/// Rays on their way through all objects, compiled for each instruction set that the processor may
/// have.
struct Decide<'a> {
    packets: &'a Packets<'a>,
    rays: &'a [u32],
    control: &'a Control,
    ids: &'a mut [u32],
}

impl pulp::WithSimd for Decide<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<()> {
        let Decide { packets, rays, control, ids } = self;
        let n_lanes = WideF64::<S>::LANES.min(MOST_LANES);
        let mut row = Row::default();
        let mut origins = Origins {
            reference: packets.reference.to_array().map(|at| [at; MOST_LANES]),
            origin: [[0.0; MOST_LANES]; 3],
            direction: [[0.0; MOST_LANES]; 3],
        };
        for (rays, ids) in rays.chunks(n_lanes).zip(ids.chunks_mut(n_lanes)) {
            // A ray may have millions of spheres to look at.
            control.check()?;
            packets.decide_packet(simd, rays, &mut row, &mut origins, ids);
        }
        Ok(())
    }
}

impl Packets<'_> {
    /// Decides up to a register of rays. Where there are fewer, the last of them is repeated.
    #[inline(always)]
    fn decide_packet<S: Simd>(
        &self,
        simd: S,
        rays: &[u32],
        row: &mut Row,
        origins: &mut Origins,
        ids: &mut [u32],
    ) {
        let n_lanes = WideF64::<S>::LANES.min(MOST_LANES);
        let index = |lane: usize| rays[lane.min(rays.len() - 1)] as usize;
        let mut scale = [1.0; MOST_LANES];
        let rays = match &self.stage.rays {
            StageRays::Pixels { pixels, camera, .. } => {
                let (mut i, mut j) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
                for lane in 0..n_lanes {
                    let (x, y) = row.offset2(index(lane), pixels);
                    (i[lane], j[lane]) = (x as f64, y as f64);
                }
                camera.camera_rays(WideF64::load(simd, &i), WideF64::load(simd, &j))
            }
            StageRays::List(_) => {
                for (lane, scale) in scale[..n_lanes].iter_mut().enumerate() {
                    let ray = self.stage.ray_f64(index(lane));
                    // 0 leaves a ray open.
                    let is_usable = ray.scale().is_normal() && ray.ray.direction != Vec3::ZERO;
                    *scale = if is_usable { ray.scale() } else { 0.0 };
                    for axis in 0..3 {
                        origins.reference[axis][lane] = ray.reference[axis];
                        origins.direction[axis][lane] = ray.ray.direction.0[axis];
                    }
                }
                let direction = Vec3(origins.direction.map(|axis| WideF64::load(simd, &axis)));
                let (zero, a) = (WideF64::splat(simd, 0.0), dot3(direction, direction));
                let origin = zero.like3(Vec3::ZERO);
                RayOf { origin, origin_low: origin, direction, a, inv_a: a.like(1.0) / a }
            }
        };
        if !self.stage.has_one_origin {
            for axis in 0..3 {
                rays.origin.0[axis].store(&mut origins.origin[axis]);
                rays.direction.0[axis].store(&mut origins.direction[axis]);
            }
        }
        let (zero, none) = (rays.a.like(0.0), simd.splat_u64s(0));
        let mut packet = Packet { rays, origins, nearest: NearestOf::none(zero, none) };
        for &(id, ref sight) in &self.objects {
            if let Some(root) = packet.root(simd, sight, &self.bounds) {
                packet.nearest.nearer(root, simd.splat_u64s(u64::from(id)));
            }
        }
        packet.finish(&scale, &self.bounds.widening, ids);
    }
}

impl Row {
    #[inline(always)]
    fn offset2(&mut self, index: usize, pixels: &Pixels) -> (i64, i64) {
        if !self.rays.contains(&index) {
            let width = pixels.width as usize;
            let first = index - index % width;
            let (x, y) = pixels.xy(first);
            *self = Row { rays: first..first + width, offset: pixels.offset2(x, y) };
        }
        let (i, j) = self.offset;
        (i + 2 * (index - self.rays.start) as i64, j)
    }
}

impl<S: Simd> Packet<'_, S> {
    /// Bounds of the roots of an object; `None` where all rays miss it.
    #[inline(always)]
    fn root(&self, simd: S, sight: &Sight, bounds: &Bounds) -> Option<Nearness<WideF64<S>>> {
        let RayOf { direction, a, inv_a, .. } = self.rays;
        match *sight {
            Sight::Outside { l, guard, q } => {
                let (s, m) = closest_approach(direction, inv_a, a.like3(l));
                let is_near = m.le(m.like(guard.outer2)).any();
                is_near.then(|| outside_at(s, m, inv_a, &guard, q))
            }
            Sight::Inside { l, guard, q } => {
                let (s, m) = closest_approach(direction, inv_a, a.like3(l));
                Some(inside_at(s, m, inv_a, &guard, q, &bounds.widening))
            }
            Sight::Plane { away, direction_error, q } => {
                let away = dot3(direction, a.like3(away));
                let q = Nearness { low: a.like(q.low), high: a.like(q.high) };
                Some(plane_nearness_of(&self.rays, away, direction_error, q))
            }
            Sight::AnySphere(sphere, known) => {
                Some(self.one_by_one(simd, |ray| any_sphere(ray, sphere, known, bounds)))
            }
            Sight::AnyPlane(plane) => {
                Some(self.one_by_one(simd, |ray| any_plane(ray, plane, bounds)))
            }
        }
    }

    #[inline(always)]
    fn one_by_one(&self, simd: S, root: impl Fn(&RayF64) -> Nearness<f64>) -> Nearness<WideF64<S>> {
        let Origins { reference, origin, direction } = self.origins;
        let (mut a, mut inv_a) = ([1.0; MOST_LANES], [1.0; MOST_LANES]);
        self.rays.a.store(&mut a);
        self.rays.inv_a.store(&mut inv_a);
        let (mut low, mut high) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
        for lane in 0..WideF64::<S>::LANES.min(MOST_LANES) {
            let at = |v: &[Lanes; 3]| std::array::from_fn(|axis| v[axis][lane]);
            let ray = RayOf {
                origin: Vec3(at(origin)),
                origin_low: Vec3::ZERO,
                direction: Vec3(at(direction)),
                a: a[lane],
                inv_a: inv_a[lane],
            };
            let reference = DVec3::from_array(at(reference));
            let root = root(&RayF64 { reference, ray, exponent: 0 });
            (low[lane], high[lane]) = (root.low, root.high);
        }
        Nearness { low: WideF64::load(simd, &low), high: WideF64::load(simd, &high) }
    }

    /// The ids that are certain. Of a certain object `t` is, too, as it may be beyond the largest f32.
    #[inline(always)]
    fn finish(&self, scale: &Lanes, widening: &Widening<f64>, ids: &mut [u32]) {
        let (mut a, mut low, mut high) = ([1.0; MOST_LANES], [0.0; MOST_LANES], [0.0; MOST_LANES]);
        let mut second_high = [0.0; MOST_LANES];
        self.rays.a.store(&mut a);
        self.nearest.low.store(&mut low);
        self.nearest.high.store(&mut high);
        self.nearest.second_high.store(&mut second_high);
        let numbers: &[u64] = bytemuck::cast_slice(std::slice::from_ref(&self.nearest.id));
        for (lane, id) in ids.iter_mut().enumerate() {
            let root = Nearness { low: low[lane], high: high[lane] };
            let t = t_f32(a[lane], root, scale[lane], widening);
            let is_hit = (low[lane] > second_high[lane]) & (t > 0.0);
            let is_missed = (numbers[lane] == 0) & (scale[lane] > 0.0);
            *id = if is_hit | is_missed { numbers[lane] as u32 } else { UNDECIDED };
        }
    }
}

/// [`Stage::nearness`] of a sphere and a ray with an origin of its own.
#[inline(always)]
fn any_sphere(ray: &RayF64, sphere: &Sphere, known: Option<K>, bounds: &Bounds) -> Nearness<f64> {
    let place = Place::new(sphere, ray.reference, ray.ray.origin);
    let Foot { l, k, r, distance, guard } = Foot::new(&place, known, bounds.input);
    let K { value, error } = k;
    match guard::sphere_in_range_f64(r, distance) {
        true => sphere_nearness(&ray.ray, l, &guard_of(&guard), value, error, &bounds.widening),
        false => Nearness::OPEN,
    }
}

/// [`Stage::nearness`] of a plane and a ray with an origin of its own.
#[inline(always)]
fn any_plane(ray: &RayF64, plane: &PlaneF64, bounds: &Bounds) -> Nearness<f64> {
    let (offset, error) = plane.offset(ray, bounds.input);
    let &PlaneF64 { normal, direction_error, .. } = plane;
    plane_nearness_at(&ray.ray, offset, error, normal, direction_error, &bounds.widening)
}
