//! The coordinates of a kernel's numbers, and the rays of lists in them.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::Kernel;
use super::about::{About, Float, Space};
use crate::num::{Float as Number, Scaled, V3};
use crate::rays::Ray;

/// The coordinates of a kernel's numbers.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// The kernel.
    pub kernel: Kernel,
    /// The point that they are relative to, unless they are the world's.
    pub reference: DVec3,
}

impl Coordinates {
    /// The reference point, where a camera stands.
    pub fn camera_origin(&self) -> DVec3 {
        match self.kernel.about().space {
            Space::World => self.reference,
            Space::Reference => DVec3::ZERO,
        }
    }

    /// A point of the world.
    pub fn of(&self, point: DVec3) -> DVec3 {
        match self.kernel.about().space {
            Space::World => point,
            Space::Reference => point - self.reference,
        }
    }

    /// Origin and direction of a ray of a list, and the exponent `e` with which the direction is `2^e` times this one, so that
    /// `t` is `2^−e` times that of this ray.
    pub fn ray(&self, ray: &Ray) -> (DVec3, DVec3, i32) {
        let About { space, float, .. } = self.kernel.about();
        if (*space, *float) != (Space::Reference, Float::F32) {
            return (self.of(ray.origin), ray.direction, 0);
        }
        let scaled = Scaled::new(ray.direction);
        let direction = match self.kernel {
            // No ray, and undecided; but 1/d² stays finite.
            Kernel::Certified if ray.direction == DVec3::ZERO => DVec3::X,
            _ => scaled.rounded(),
        };
        (self.of(ray.origin), direction, scaled.exponent())
    }

    /// A ray of a list for a kernel in f64.
    pub fn ray_record_double(&self, ray: &Ray) -> RayRecordDouble {
        let (origin, direction, _) = self.ray(ray);
        let (origin, direction) = (origin.to_array(), direction.to_array());
        RayRecordDouble { origin, pad0: 0.0, direction, pad1: 0.0 }
    }

    /// The same for one in f32, with the exponent of [`Coordinates::ray`].
    pub fn ray_record(&self, ray: &Ray) -> (RayRecord, i32) {
        let (origin, direction, exponent) = self.ray(ray);
        let ([origin, origin_low], direction) = (split(origin), direction.as_vec3().to_array());
        (RayRecord { origin, pad0: 0.0, origin_low, pad1: 0.0, direction, pad2: 0.0 }, exponent)
    }
}

/// A ray of a list as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct RayRecord {
    /// Origin: world units for `lecture`, else the high part relative to the reference point.
    pub origin: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad0: f32,
    /// Low part of the origin.
    pub origin_low: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad1: f32,
    /// Direction; scaled by a power of two to a largest component in `1..2`, but not for `lecture`.
    pub direction: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad2: f32,
}

/// A ray of a list as the device sees it, for [`Kernel::Double`].
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct RayRecordDouble {
    /// Origin relative to the reference point.
    pub origin: [f64; 3],
    /// Fills WGSL's 32-byte alignment of `vec3<f64>`.
    pub pad0: f64,
    /// Direction, as it is.
    pub direction: [f64; 3],
    /// Fills WGSL's 32-byte alignment of `vec3<f64>`.
    pub pad1: f64,
}

/// `v` in two parts: together 48 bits of f32. Of f64 the second one is 0.
pub fn split<F: Number>(v: DVec3) -> [[F; 3]; 2] {
    let high = V3::<F>::near(v);
    [high.0, V3::near(v - DVec3::from_array(high.0.map(F::to_f64))).0]
}
