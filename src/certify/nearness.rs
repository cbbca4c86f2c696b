//! One ray and one object in f64, with the filter's bounds.

use glam::DVec3;

use super::{RayF64, Stage, StageRays};
use crate::exact::{ExactRay, sphere_numbers};
use crate::guard::{self, Guard};
use crate::kernel::certified::{GuardOf, Nearness, plane_nearness_at, sphere_nearness};
use crate::prepare::{exponent_of, scale_by_power_of_two};
use crate::scene::{Object, Plane, Sphere};
use crate::trace::Ray;
use crate::vec3::{Vec3, dot3};

impl Stage<'_> {
    pub fn nearness(&self, ray: &RayF64, id: u32, object: Object) -> Nearness<f64> {
        match object {
            _ if !self.usable => Nearness::OPEN,
            Object::Sphere(sphere) if sphere.radius == 0.0 => Nearness::MISS,
            Object::Plane(plane) if plane.normal == DVec3::ZERO => Nearness::MISS,
            Object::Sphere(sphere) => match self.sphere_foot(ray, id, sphere) {
                Some(Foot { l, k, guard, .. }) => {
                    let Guard { inner2, outer2, slack, .. } = guard;
                    let guard = GuardOf { inner2, outer2, slack };
                    let K { value, error } = k;
                    sphere_nearness(&ray.ray, l, &guard, value, error, &guard::widening_f64())
                }
                None => Nearness::OPEN,
            },
            Object::Plane(plane) => self.plane_nearness(ray, plane).unwrap_or(Nearness::OPEN),
        }
    }

    fn plane_nearness(&self, ray: &RayF64, plane: &Plane) -> Option<Nearness<f64>> {
        let normal = scale_by_power_of_two(plane.normal, -exponent_of(plane.normal));
        let l = ray.to_point(plane.point);
        let distance = ray.distance(plane.point);
        let n_length = guard::length_bound(normal);
        guard::plane_in_range_f64(distance).then(|| {
            plane_nearness_at(
                &ray.ray,
                dot3(l, normal.into()),
                guard::plane_offset_error(
                    n_length,
                    distance,
                    guard::UNIT_F64,
                    self.input,
                    guard::TINY_F64,
                ),
                normal.into(),
                guard::plane_direction_error(n_length, guard::UNIT_F64, self.input),
                &guard::widening_f64(),
            )
        })
    }

    pub fn sphere_foot(&self, ray: &RayF64, id: u32, sphere: &Sphere) -> Option<Foot> {
        let r = sphere.radius.abs();
        let distance = ray.distance(sphere.center);
        if !guard::sphere_in_range_f64(r, distance) {
            return None;
        }
        let l = ray.to_point(sphere.center);
        let guard = Guard::new(r, distance, guard::UNIT_F64, self.input);
        let known = self.ks.get(id as usize - 1).or_else(|| self.rest_ks.get(&id));
        let k = match (&self.rays, known) {
            (_, Some(k)) => k.moved(ray, sphere, l),
            (StageRays::Pixels(..), None) => K::new(ray.reference, sphere).moved(ray, sphere, l),
            (StageRays::List(_), None) => K { value: dot3(l, l) - r * r, error: guard.k_error },
        };
        Some(Foot { l, k, r, distance, guard })
    }

    /// The one f32 that both ends of `t` round to, if there is one: then it is the exact root's
    /// nearest f32 as well. `t = 1/(a·w)`, its rounding (`a` 3 + 2δ, product 1, quotient 2.5) once
    /// more below the widening.
    pub fn to_f32(&self, ray: &RayF64, root: Nearness<f64>) -> Option<f32> {
        let widening = guard::widening_f64();
        let scale = 2f64.powi(-ray.exponent);
        let low = (widening.narrower / (ray.ray.a * root.high) * scale) as f32;
        let high = (widening.wider / (ray.ray.a * root.low) * scale) as f32;
        let safe = root.low > 0.0 && low > 0.0 && high.is_finite() && scale.is_normal();
        (safe && low == high).then_some(low)
    }
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
                K { value, error: guard::UNIT_F64 * value.abs() }
            }
            // 0, or so near it that u/k could overflow: left to exact arithmetic.
            _ => K { value: 0.0, error: f64::MAX },
        }
    }

    /// `k` for the ray's origin, from that for the reference point: the same one where these are one.
    fn moved(self, ray: &RayF64, sphere: &Sphere, l: Vec3<f64>) -> K {
        if ray.ray.origin == Vec3::ZERO {
            return self;
        }
        let from_reference = sphere.center - ray.reference;
        let moved = dot3(ray.ray.origin, Vec3::from(from_reference) + l);
        let distance = guard::length_bound(from_reference);
        let K { value, error } = self;
        K {
            value: value - moved,
            error: guard::moved_k_error(value, error, distance, ray.origin_length()),
        }
    }
}

/// A sphere seen from a ray's origin.
pub struct Foot {
    pub l: Vec3<f64>,
    pub k: K,
    pub r: f64,
    pub distance: f64,
    pub guard: Guard,
}
