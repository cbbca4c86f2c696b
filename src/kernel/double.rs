//! What one would do without this crate's design: the formulas of [`super::relative`] in f64 from
//! end to end. Twin of `shaders/double.wgsl`.
//!
//! More digits make wrong objects rare, but nothing says which rays they are.

use bytemuck::{Pod, Zeroable};

use super::relative::{RelativePlane, RelativeSphere};
use super::{Hit, RayOf};
use crate::vec3::{Vec3, dot3};

/// A sphere as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereDouble {
    /// Centre relative to the reference point.
    pub center: [f64; 3],
    /// Radius.
    pub radius: f64,
    /// `l·l − r²` for the reference point.
    pub k: f64,
    /// Fills WGSL's 32-byte alignment of the struct.
    pub padding: [f64; 3],
}

/// A plane as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneDouble {
    /// Point of the plane relative to the reference point.
    pub offset: [f64; 3],
    /// `(a − o)·n` for the reference point.
    pub n_offset: f64,
    /// Normal, scaled by a power of two to a largest component in `1..2`.
    pub normal: [f64; 3],
    /// Fills WGSL's 32-byte alignment of the struct.
    pub padding: f64,
}

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
