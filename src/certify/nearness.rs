//! One ray and one object in f64, with the filter's bounds.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::surfaces::unit_f32;
use super::{RayF64, Stage, StageRays};
use crate::exact::{ExactRay, sphere_numbers};
use crate::guard::{self, Guard, InputError};
use crate::kernel::certified::{
    GuardOf, Nearness, Widening, normalized, plane_nearness_at, sphere_nearness,
};
use crate::num::Float;
use crate::prepare::Scaled;
use crate::scene::{Object, Plane, Sphere};
use crate::trace::Ray;
use crate::vec3::{Vec3, dot3};

impl Stage<'_> {
    pub fn nearness(&self, ray: &RayF64, id: u32, object: Object) -> Nearness<f64> {
        match object {
            _ if !self.usable => Nearness::OPEN,
            Object::Sphere(sphere) if sphere.radius == 0.0 => Nearness::MISS,
            Object::Plane(plane) if plane.normal == DVec3::ZERO => Nearness::MISS,
            Object::Plane(_) if self.plane(id).is_repeated => Nearness::MISS,
            Object::Sphere(sphere) => match self.sphere_foot(ray, id, sphere) {
                Some(Foot { l, k, guard, .. }) => {
                    let Guard { inner2, outer2, slack, .. } = guard;
                    let guard = GuardOf { inner2, outer2, slack };
                    let K { value, error } = k;
                    sphere_nearness(&ray.ray, l, &guard, value, error, &self.bounds.widening)
                }
                None => Nearness::OPEN,
            },
            Object::Plane(_) => self.plane_nearness(ray, id),
        }
    }

    /// The numbers of the plane with this id.
    pub fn plane(&self, id: u32) -> &PlaneF64 {
        &self.planes[id as usize - 1 - self.scene.spheres.len()]
    }

    fn plane_nearness(&self, ray: &RayF64, id: u32) -> Nearness<f64> {
        let plane = self.plane(id);
        let (offset, error) = plane.offset(ray, self.bounds.input);
        plane_nearness_at(
            &ray.ray,
            offset,
            error,
            plane.normal,
            plane.direction_error,
            &self.bounds.widening,
        )
    }

    pub fn sphere_foot(&self, ray: &RayF64, id: u32, sphere: &Sphere) -> Option<Foot> {
        if let Some(foot) = self.feet.get(id as usize - 1) {
            return *foot;
        }
        let r = sphere.radius.abs();
        let distance = ray.distance(sphere.center);
        if !guard::sphere_in_range_f64(r, distance) {
            return None;
        }
        let place = Place::new(sphere, ray.reference, ray.ray.origin);
        Some(Foot::new(&place, self.known_k(id, sphere), self.bounds.input))
    }

    /// `k` of a sphere for the camera's position; lists of rays have none.
    pub fn known_k(&self, id: u32, sphere: &Sphere) -> Option<K> {
        match &self.rays {
            StageRays::List(_) => None,
            StageRays::Pixels { pixels, .. } => {
                let known = self.ks.get(id as usize - 1).or_else(|| self.rest_ks.get(&id));
                Some(known.copied().unwrap_or_else(|| K::new(pixels.view.position, sphere)))
            }
        }
    }

    /// [`t_f32`] of a ray.
    pub fn to_f32(&self, ray: &RayF64, root: Nearness<f64>) -> Option<f32> {
        let scale = ray.scale();
        let t = t_f32(ray.ray.a, root, scale, &self.bounds.widening);
        (t > 0.0 && scale.is_normal()).then_some(t)
    }
}

/// The one f32 that both ends of `t` round to, or 0 where there is none: it is the exact root's
/// nearest f32 as well. `t = scale/(a·w)`, its rounding (`a` 3 + 2δ, product 1, quotient 2.5) once
/// more below the widening.
#[inline(always)]
pub fn t_f32(a: f64, root: Nearness<f64>, scale: f64, widening: &Widening<f64>) -> f32 {
    let low = (widening.narrower / (a * root.high) * scale) as f32;
    let high = (widening.wider / (a * root.low) * scale) as f32;
    let is_certain = (root.low > 0.0) & (low > 0.0) & (high < f32::INFINITY) & (low == high);
    if is_certain { low } else { 0.0 }
}

/// `k = l·l − r²` and a bound of its error.
#[derive(Clone, Copy)]
pub struct K {
    pub value: f64,
    pub error: f64,
}

impl K {
    /// In f64 where that is good enough to round `t`, else exactly and rounded once. On the ground
    /// of a huge sphere f64 keeps too few of its digits, and each `t` would need exact arithmetic.
    pub fn new(origin: DVec3, sphere: &Sphere) -> K {
        if let Some((value, error)) = guard::k_f64(sphere.center - origin, sphere.radius) {
            return K { value, error };
        }
        let eye = ExactRay::new(&Ray { origin, direction: DVec3::X });
        match sphere_numbers(&eye, sphere.center, sphere.radius).map(|n| n.k.to_f64()) {
            Some(value) if value.abs() >= guard::TINY_F64 => {
                K { value, error: f64::UNIT * value.abs() }
            }
            // 0, or so near it that u/k could overflow: left to exact arithmetic.
            _ => K { value: 0.0, error: f64::MAX },
        }
    }

    /// `k` for an origin, from that for the reference point, `distance` away from the centre
    /// and `from` from the origin: the same one where these are one.
    #[inline(always)]
    fn moved(self, place: &Place, l: Vec3<f64>, distance: f64, from: f64) -> K {
        let Place { center, origin, .. } = *place;
        let moved = dot3(Vec3(origin), Vec3(center) + l);
        let K { value, error } = self;
        let error_moved = guard::moved_k_error(value, error, distance, from);
        let is_there = (origin[0] == 0.0) & (origin[1] == 0.0) & (origin[2] == 0.0);
        K {
            value: if is_there { value } else { value - moved },
            error: if is_there { error } else { error_moved },
        }
    }
}

#[inline(always)]
fn length_bound(v: [f64; 3]) -> f64 {
    guard::length_bound(DVec3::from_array(v))
}

/// A sphere and the origin of a ray, both relative to the same point.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Place {
    pub center: [f64; 3],
    pub origin: [f64; 3],
    pub radius: f64,
}

impl Place {
    pub fn new(sphere: &Sphere, reference: DVec3, origin: Vec3<f64>) -> Place {
        let center = (sphere.center - reference).to_array();
        Place { center, origin: origin.0, radius: sphere.radius }
    }
}

/// A sphere seen from a ray's origin.
#[derive(Clone, Copy)]
pub struct Foot {
    pub l: Vec3<f64>,
    pub k: K,
    pub guard: Guard,
}

impl Foot {
    /// `known` is `k` for the reference point.
    #[inline(always)]
    pub fn new(place: &Place, known: Option<K>, input: InputError) -> Foot {
        let Place { center, origin, radius } = *place;
        let (l, r) = (Vec3(center) - Vec3(origin), radius.abs());
        let (from_reference, from) = (length_bound(center), length_bound(origin));
        let distance = from_reference + from;
        let guard = Guard::new(r, distance, f64::UNIT, input);
        let k = match known {
            Some(k) => k.moved(place, l, from_reference, from),
            None => K { value: dot3(l, l) - r * r, error: guard.k_error },
        };
        Foot { l, k, guard }
    }
}

/// A plane's numbers for all rays.
#[derive(Clone)]
pub struct PlaneF64 {
    pub point: DVec3,
    /// Scaled by a power of two to a largest component in `1..2`.
    pub normal: Vec3<f64>,
    n_length: f64,
    /// The exact one, each component rounded to the nearest f32.
    pub unit_f32: [f32; 3],
    pub direction_error: f64,
    /// Whether an earlier plane is the same: then nothing sees this one.
    pub is_repeated: bool,
}

impl PlaneF64 {
    pub fn new(plane: &Plane, input: InputError) -> PlaneF64 {
        let normal = Scaled::new(plane.normal).rounded();
        let (n_length, unit) = (guard::length_bound(normal), normalized(normal.into()));
        PlaneF64 {
            point: plane.point,
            normal: normal.into(),
            n_length,
            unit_f32: unit_f32(plane, unit.0),
            direction_error: guard::plane_direction_error(n_length, f64::UNIT, input),
            is_repeated: false,
        }
    }

    /// `(a − o)·n` and a bound of its error, which is ∞ where the bounds don't hold.
    #[inline(always)]
    pub fn offset(&self, ray: &RayF64, input: InputError) -> (f64, f64) {
        let distance = ray.distance(self.point);
        let error = self.offset_error(distance, input);
        let offset = dot3(ray.to_point(self.point), self.normal);
        (offset, if guard::plane_in_range_f64(distance) { error } else { f64::INFINITY })
    }

    /// Bound of the error of `(a − o)·n` for a distance in range.
    #[inline(always)]
    pub fn offset_error(&self, distance: f64, input: InputError) -> f64 {
        let (n, tiny) = (self.n_length, guard::TINY_F64);
        guard::plane_offset_error(n, distance, f64::UNIT, input, tiny)
    }
}
