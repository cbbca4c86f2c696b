//! Twin of `shaders/double.wgsl`.

use super::{PlaneDouble, SphereDouble};
use crate::kernel::relative::{RelativePlane, RelativeSphere};
use crate::kernel::{Hit, RayOf};
use crate::vec3::{Vec3, dot3};

impl RelativeSphere for SphereDouble {
    type Float = f64;

    #[inline(always)]
    fn sphere_offset<const IS_POINT: bool>(&self, ray: &RayOf<f64>) -> Vec3<f64> {
        if IS_POINT { Vec3(self.center) } else { Vec3(self.center) - ray.origin }
    }

    #[inline(always)]
    fn radius(&self) -> f64 {
        self.radius
    }

    #[inline(always)]
    fn sphere_k<const IS_POINT: bool>(&self, l: Vec3<f64>) -> f64 {
        if IS_POINT { self.k } else { dot3(l, l) - self.radius * self.radius }
    }
}

impl RelativePlane for PlaneDouble {
    type Float = f64;

    #[inline(always)]
    fn plane_n_offset<const IS_POINT: bool>(&self, ray: &RayOf<f64>) -> f64 {
        if IS_POINT {
            self.n_offset
        } else {
            dot3(Vec3(self.offset) - ray.origin, Vec3(self.normal))
        }
    }

    #[inline(always)]
    fn normal(&self) -> Vec3<f64> {
        Vec3(self.normal)
    }
}

/// The hit as its caller sees it, in f32. What f32 can't hold is a miss.
#[inline(always)]
pub fn narrow(hit: Hit<f64>) -> Hit<f32> {
    let t = hit.t as f32;
    if t < f32::INFINITY { Hit { t, id: hit.id } } else { Hit::MISS }
}
