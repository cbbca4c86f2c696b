//! The coordinates of a kernel's numbers, and the rays of lists in them.

use glam::DVec3;

use super::Kernel;
use super::info::{FloatType, KernelInfo, Space};
use crate::num::{Float as Number, ScaledInteger, V3};
use crate::rays::{Origins, WorldRay};

/// The coordinates of a kernel's numbers.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// The kernel.
    pub kernel: Kernel,
    /// The point of the scene that they are relative to: 0 for world coordinates.
    pub origin: DVec3,
    /// Distance from there up to which the kernel looks at the rays of a list. Those that start farther away are undecided.
    pub spread: f64,
}

impl Coordinates {
    /// A point of the world.
    pub fn of(&self, point: DVec3) -> DVec3 {
        point - self.origin
    }

    /// Origin and direction of a ray of a list, and the exponent `e` with which the direction is `2^e` times this one, so that
    /// `t` is `2^−e` times that of this ray.
    pub fn ray(&self, ray: &WorldRay) -> (DVec3, DVec3, i32) {
        let KernelInfo { space, float, .. } = self.kernel.about();
        if (*space, *float) != (Space::Reference, FloatType::F32) {
            return (self.of(ray.origin), ray.direction, 0);
        }
        let origins = Origins { reference: self.origin, spread: self.spread };
        if self.kernel == Kernel::Certified
            && (ray.direction == DVec3::ZERO || origins.is_far(ray.origin))
        {
            // Undecided, whatever is found; but 1/d² stays finite.
            return (DVec3::ZERO, DVec3::X, 0);
        }
        let scaled = ScaledInteger::new(ray.direction);
        (self.of(ray.origin), scaled.rounded(), scaled.exponent())
    }
}

/// `v` in two parts: together 48 bits of f32. Of f64 the second one is 0.
pub fn split<F: Number>(v: DVec3) -> [[F; 3]; 2] {
    let high = V3::<F>::lit(v);
    [high.0, V3::lit(v - DVec3::from_array(high.0.map(F::to_f64))).0]
}
