//! Twin of `shaders/stable.wgsl`.

use super::{PlaneStable, SphereStable};
use crate::kernel::RayOf;
use crate::kernel::relative::{RelativePlane, RelativeSphere};
use crate::vec3::{Vec3, dot3};

#[inline(always)]
fn offset(ray: &RayOf<f32>, high: [f32; 3], low: [f32; 3]) -> Vec3<f32> {
    (Vec3(high) - ray.origin) + (Vec3(low) - ray.origin_low)
}

impl RelativeSphere for SphereStable {
    type Float = f32;

    #[inline(always)]
    fn sphere_offset<const IS_POINT: bool>(&self, ray: &RayOf<f32>) -> Vec3<f32> {
        if IS_POINT { Vec3(self.center) } else { offset(ray, self.center, self.center_low) }
    }

    #[inline(always)]
    fn radius(&self) -> f32 {
        self.radius
    }

    #[inline(always)]
    fn sphere_k<const IS_POINT: bool>(&self, l: Vec3<f32>) -> f32 {
        if IS_POINT { self.k } else { dot3(l, l) - self.radius * self.radius }
    }
}

impl RelativePlane for PlaneStable {
    type Float = f32;

    #[inline(always)]
    fn plane_n_offset<const IS_POINT: bool>(&self, ray: &RayOf<f32>) -> f32 {
        if IS_POINT {
            self.n_offset
        } else {
            dot3(offset(ray, self.offset, self.offset_low), Vec3(self.normal))
        }
    }

    #[inline(always)]
    fn normal(&self) -> Vec3<f32> {
        Vec3(self.normal)
    }
}
