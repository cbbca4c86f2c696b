//! Rays that f64 decides side by side, where objects are tested one after the other: the steps of
//! [`Stage::decide_f64`], each for some rays before the next, so that the compiler finds them side by
//! side. What they leave open goes there.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::collections::HashSet;
use std::ops::Range;

use glam::DVec3;

use super::decide::bits;
use super::nearness::{Foot, K, Place, PlaneF64, t_f32};
use super::surface::Bounds;
use super::{RayF64, Stage, StageRays};
use crate::control::Control;
use crate::error::Result;
use crate::guard::{self, Guard};
use crate::kernel::RayOf;
use crate::kernel::certified::{
    GuardOf, Nearness, UNDECIDED, Widening, closest_approach, plane_nearness_at,
};
use crate::scene::{Object, Sphere};
use crate::vec3::{Real, Vec3, dot3};

/// Rays side by side.
const LANES: usize = 8;

type Lanes = [f64; LANES];

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

/// The numbers of some rays, and what is nearest to each so far.
struct Packet {
    reference: [Lanes; 3],
    origin: [Lanes; 3],
    direction: [Lanes; 3],
    a: Lanes,
    inv_a: Lanes,
    /// `√a`
    length: Lanes,
    scale: Lanes,
    low: Lanes,
    high: Lanes,
    second_high: Lanes,
    id: [u64; LANES],
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
        let arch = pulp::Arch::new();
        let mut row = Row::default();
        for (rays, ids) in rays.chunks(LANES).zip(ids.chunks_mut(LANES)) {
            // A ray may have millions of spheres to look at.
            control.check()?;
            let mut packet = self.begin(rays, &mut row);
            arch.dispatch(Decide { packets: self, packet: &mut packet, ids });
        }
        Ok(())
    }

    /// The rays, the last of them repeated where there are fewer than fill a packet.
    #[inline(always)]
    fn begin(&self, rays: &[u32], row: &mut Row) -> Packet {
        let mut packet = Packet {
            reference: self.reference.to_array().map(|at| [at; LANES]),
            origin: [[0.0; LANES]; 3],
            direction: [[0.0; LANES]; 3],
            a: [1.0; LANES],
            inv_a: [1.0; LANES],
            length: [1.0; LANES],
            scale: [1.0; LANES],
            low: [0.0; LANES],
            high: [0.0; LANES],
            second_high: [0.0; LANES],
            id: [0; LANES],
        };
        for lane in 0..LANES {
            let index = rays[lane.min(rays.len() - 1)] as usize;
            let ray = match &self.stage.rays {
                StageRays::Pixels { pixels, camera, .. } => {
                    if !row.rays.contains(&index) {
                        let width = pixels.width as usize;
                        let first = index - index % width;
                        let (x, y) = pixels.xy(first);
                        *row = Row { rays: first..first + width, offset: pixels.offset2(x, y) };
                    }
                    let (i, j) = row.offset;
                    camera.camera_ray((i + 2 * (index - row.rays.start) as i64) as f64, j as f64)
                }
                StageRays::List(_) => {
                    let ray = self.stage.ray_f64(index);
                    // 0 leaves a ray open.
                    let is_usable = ray.scale().is_normal() && ray.ray.direction != Vec3::ZERO;
                    packet.scale[lane] = if is_usable { ray.scale() } else { 0.0 };
                    for axis in 0..3 {
                        packet.reference[axis][lane] = ray.reference[axis];
                    }
                    ray.ray
                }
            };
            for axis in 0..3 {
                packet.origin[axis][lane] = ray.origin.0[axis];
                packet.direction[axis][lane] = ray.direction.0[axis];
            }
        }
        packet
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

/// A packet on its way through all objects, compiled for each instruction set that the processor may
/// have.
struct Decide<'a> {
    packets: &'a Packets<'a>,
    packet: &'a mut Packet,
    ids: &'a mut [u32],
}

impl pulp::WithSimd for Decide<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Decide { packets: Packets { bounds, objects, .. }, packet, ids } = self;
        packet.square();
        for &(id, ref sight) in objects {
            match *sight {
                Sight::Outside { l, guard, q } => {
                    let Some((s, m)) = packet.approach(l, guard.outer2) else { continue };
                    packet.nearer(id, |packet, lane| {
                        outside_at(s[lane], m[lane], packet.inv_a[lane], &guard, q)
                    });
                }
                Sight::Inside { l, guard, q } => {
                    let Some((s, m)) = packet.approach(l, f64::INFINITY) else { continue };
                    packet.nearer(id, |packet, lane| {
                        let inv_a = packet.inv_a[lane];
                        inside_at(s[lane], m[lane], inv_a, &guard, q, &bounds.widening)
                    });
                }
                Sight::Plane { away, direction_error, q } => packet.nearer(id, |packet, lane| {
                    let away = dot3(packet.direction(lane), away);
                    let error = direction_error * packet.length[lane];
                    plane_at(away, error, packet.inv_a[lane], q)
                }),
                Sight::AnySphere(sphere, known) => packet
                    .nearer(id, |packet, lane| any_sphere(packet, lane, sphere, known, bounds)),
                Sight::AnyPlane(plane) => {
                    packet.nearer(id, |packet, lane| any_plane(packet, lane, plane, bounds));
                }
            }
        }
        packet.finish(&bounds.widening, ids);
    }
}

impl Packet {
    /// `d·d`, its inverse and its root.
    #[inline(always)]
    fn square(&mut self) {
        for lane in 0..LANES {
            let direction = self.direction(lane);
            self.a[lane] = dot3(direction, direction);
            self.inv_a[lane] = 1.0 / self.a[lane];
            self.length[lane] = self.a[lane].sqrt();
        }
    }

    #[inline(always)]
    fn direction(&self, lane: usize) -> Vec3<f64> {
        Vec3(std::array::from_fn(|axis| self.direction[axis][lane]))
    }

    #[inline(always)]
    fn ray_f64(&self, lane: usize) -> RayF64 {
        let reference = DVec3::from_array(std::array::from_fn(|axis| self.reference[axis][lane]));
        RayF64 { reference, ray: self.ray(lane), exponent: 0 }
    }

    #[inline(always)]
    fn ray(&self, lane: usize) -> RayOf<f64> {
        RayOf {
            origin: Vec3(std::array::from_fn(|axis| self.origin[axis][lane])),
            origin_low: Vec3::ZERO,
            direction: self.direction(lane),
            a: self.a[lane],
            inv_a: self.inv_a[lane],
        }
    }

    /// [`closest_approach`] of all rays; `None` where all of them stay outside of a radius.
    #[inline(always)]
    fn approach(&self, l: Vec3<f64>, outer2: f64) -> Option<(Lanes, Lanes)> {
        let (mut s, mut m) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            (s[lane], m[lane]) = closest_approach(self.direction(lane), self.inv_a[lane], l);
        }
        let mut is_near = false;
        for lane in 0..LANES {
            is_near |= m[lane] <= outer2;
        }
        is_near.then_some((s, m))
    }

    /// [`crate::kernel::certified::Nearest::nearer`] of all rays.
    #[inline(always)]
    fn nearer(&mut self, id: u32, root: impl Fn(&Packet, usize) -> Nearness<f64>) {
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let root = root(self, lane);
            (low[lane], high[lane]) = (root.low, root.high);
        }
        for lane in 0..LANES {
            let is_nearer = high[lane] > self.high[lane];
            let farther = if is_nearer { self.high[lane] } else { high[lane] };
            self.low[lane] = if is_nearer { low[lane] } else { self.low[lane] };
            self.high[lane] = if is_nearer { high[lane] } else { self.high[lane] };
            self.id[lane] = if is_nearer { u64::from(id) } else { self.id[lane] };
            let second = self.second_high[lane];
            self.second_high[lane] = if farther > second { farther } else { second };
        }
    }

    /// The ids that are certain. Of a certain object `t` is, too, as it may be beyond the largest f32.
    #[inline(always)]
    fn finish(&self, widening: &Widening<f64>, ids: &mut [u32]) {
        let mut decided = [UNDECIDED; LANES];
        for lane in 0..LANES {
            let root = Nearness { low: self.low[lane], high: self.high[lane] };
            let t = t_f32(self.a[lane], root, self.scale[lane], widening);
            let is_hit = (root.low > self.second_high[lane]) & (t > 0.0);
            let is_missed = (self.id[lane] == 0) & (self.scale[lane] > 0.0);
            let id = self.id[lane] as u32;
            decided[lane] = if is_hit | is_missed { id } else { UNDECIDED };
        }
        ids.copy_from_slice(&decided[..ids.len()]);
    }
}

/// [`crate::kernel::certified::outside_nearness`] from the closest approach, without branches.
#[inline(always)]
pub fn outside_at(
    s: f64,
    m: f64,
    inv_a: f64,
    guard: &GuardOf<f64>,
    q: Nearness<f64>,
) -> Nearness<f64> {
    let (inner, outer) = (guard.inner2 - m, guard.outer2 - m);
    let low = ((s - guard.slack) + (Real::max(inner, 0.0) * inv_a).sqrt()) * q.low;
    let high = ((s + guard.slack) + (Real::max(outer, 0.0) * inv_a).sqrt()) * q.high;
    Nearness {
        low: if inner < 0.0 { 0.0 } else { low },
        high: if outer < 0.0 { 0.0 } else { high },
    }
}

/// [`crate::kernel::certified::plane_nearness`] with the error of `d·n`.
#[inline(always)]
pub fn plane_at(away: f64, error: f64, inv_a: f64, q: Nearness<f64>) -> Nearness<f64> {
    Nearness { low: (away - error) * inv_a * q.low, high: (away + error) * inv_a * q.high }
}

/// [`crate::kernel::certified::inside_nearness`] from the closest approach, without branches, where
/// `q` is not 0.
#[inline(always)]
pub fn inside_at(
    s: f64,
    m: f64,
    inv_a: f64,
    guard: &GuardOf<f64>,
    q: Nearness<f64>,
    widening: &Widening<f64>,
) -> Nearness<f64> {
    let half = |r2: f64| (Real::max(r2 - m, 0.0) * inv_a).sqrt();
    let u_low = (s.abs() + half(guard.inner2)) - guard.slack;
    let u_high = (s.abs() + half(guard.outer2)) + guard.slack;
    let ahead_low = inv_a / u_high * widening.narrower;
    let ahead_high = inv_a / u_low * widening.wider;
    let ahead_high = if u_low > 0.0 { ahead_high } else { f64::LARGEST };
    Nearness {
        low: if s > 0.0 { ahead_low } else { u_low * q.low },
        high: if s > 0.0 { ahead_high } else { u_high * q.high },
    }
}

/// [`Stage::nearness`] of a sphere and a ray with an origin of its own.
#[inline(always)]
fn any_sphere(
    packet: &Packet,
    lane: usize,
    sphere: &Sphere,
    known: Option<K>,
    bounds: &Bounds,
) -> Nearness<f64> {
    let ray = packet.ray_f64(lane);
    let place = Place::new(sphere, ray.reference, ray.ray.origin);
    let Foot { l, k, r, distance, guard } = Foot::new(&place, known, bounds.input);
    let guard = guard_of(&guard);
    let q = bounds.widening.inverse(k.value.abs(), k.error);
    let inv_a = ray.ray.inv_a;
    let (s, m) = closest_approach(ray.ray.direction, inv_a, l);
    let outside = outside_at(s, m, inv_a, &guard, q);
    let inside = inside_at(s, m, inv_a, &guard, q, &bounds.widening);
    let root = if k.value > 0.0 { outside } else { inside };
    let is_known = guard::sphere_in_range_f64(r, distance) & (k.value.abs() > k.error);
    if is_known { root } else { Nearness::OPEN }
}

/// [`Stage::nearness`] of a plane and a ray with an origin of its own.
#[inline(always)]
fn any_plane(packet: &Packet, lane: usize, plane: &PlaneF64, bounds: &Bounds) -> Nearness<f64> {
    let ray = packet.ray_f64(lane);
    let (offset, error) = plane.offset(&ray, bounds.input);
    let &PlaneF64 { normal, direction_error, .. } = plane;
    plane_nearness_at(&ray.ray, offset, error, normal, direction_error, &bounds.widening)
}
