//! The coordinates of a kernel's numbers, and the rays of lists in them.

use glam::DVec3;

use super::Kernel;
use super::about::{About, FloatType, Space};
use crate::num::{Float as Number, Scaled, V3};
use crate::rays::WorldRay;

/// The coordinates of a kernel's numbers.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// The kernel.
    pub kernel: Kernel,
    /// The point that they are relative to, world units: 0 where they are the world's.
    pub origin: DVec3,
}

impl Coordinates {
    /// A point of the world.
    pub fn of(&self, point: DVec3) -> DVec3 {
        point - self.origin
    }

    /// Origin and direction of a ray of a list, and the exponent `e` with which the direction is `2^e` times this one, so that
    /// `t` is `2^−e` times that of this ray.
    pub fn ray(&self, ray: &WorldRay) -> (DVec3, DVec3, i32) {
        let About { space, float, .. } = self.kernel.about();
        if (*space, *float) != (Space::Reference, FloatType::F32) {
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
}

/// `v` in two parts: together 48 bits of f32. Of f64 the second one is 0.
pub fn split<F: Number>(v: DVec3) -> [[F; 3]; 2] {
    let high = V3::<F>::lit(v);
    [high.0, V3::lit(v - DVec3::from_array(high.0.map(F::to_f64))).0]
}
