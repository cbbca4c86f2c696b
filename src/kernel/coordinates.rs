//! The coordinates of a kernel's numbers, and the rays of lists in them.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::about::Space;
use super::registry::Kernel;
use crate::num::Scaled;
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

    /// A ray of a list for a kernel in f64.
    pub fn ray_record_double(&self, ray: &Ray) -> RayRecordDouble {
        RayRecordDouble {
            origin: (ray.origin - self.reference).to_array(),
            pad0: 0.0,
            direction: ray.direction.to_array(),
            pad1: 0.0,
        }
    }

    /// A ray of a list for a kernel in f32, and the exponent `e` with
    /// `direction = 2^e · record.direction`, so that `t = 2^−e · t_record`.
    pub fn ray_record(&self, ray: &Ray) -> (RayRecord, i32) {
        let (origin, origin_low, direction, exponent) = match self.kernel.about().space {
            Space::World => (ray.origin.as_vec3().to_array(), [0.0; 3], ray.direction, 0),
            Space::Reference => {
                let (high, low) = split(ray.origin - self.reference);
                let scaled = Scaled::new(ray.direction);
                let direction = match self.kernel {
                    // No ray, and undecided; but 1/d² stays finite.
                    Kernel::Certified if ray.direction == DVec3::ZERO => DVec3::X,
                    _ => scaled.rounded(),
                };
                (high, low, direction, scaled.exponent())
            }
        };
        let direction = direction.as_vec3().to_array();
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

/// `v` as f32 high part and f32 low part: together 48 bits.
pub fn split(v: DVec3) -> ([f32; 3], [f32; 3]) {
    let high = v.as_vec3();
    let low = (v - high.as_dvec3()).as_vec3();
    (high.to_array(), low.to_array())
}
