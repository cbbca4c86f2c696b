//! The best plain-f32 kernel: the formulas of [`super::relative`] in f32. Twin of
//! `shaders/stable.wgsl`.
//!
//! Offsets from the ray's origin are formed in f64 on the host, or from high and low parts for
//! lists of rays. Still plain f32: nothing is promised near a silhouette.

use bytemuck::{Pod, Zeroable};

use super::RayOf;
use super::relative::{RelativePlane, RelativeSphere};
use crate::vec3::{Vec3, dot3};

/// A sphere as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereStable {
    /// Centre relative to the reference point, high part.
    pub center: [f32; 3],
    /// Radius.
    pub radius: f32,
    /// Centre relative to the reference point, low part.
    pub center_low: [f32; 3],
    /// `l·l − r²` for the reference point, rounded from f64.
    pub k: f32,
}

/// A plane as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneStable {
    /// Point of the plane relative to the reference point, high part.
    pub offset: [f32; 3],
    /// `(a − o)·n` for the reference point, rounded from f64.
    pub n_offset: f32,
    /// Point of the plane relative to the reference point, low part.
    pub offset_low: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad0: f32,
    /// Normal, scaled by a power of two to a largest component in `1..2`.
    pub normal: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad1: f32,
}

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
