//! The geometry of objects, a file each: the exact root that is seen, its normal, and the numbers on
//! the way there.

mod plane;
mod sphere;

use glam::DVec3;

pub(crate) use plane::plane_normal;
pub use plane::{PlaneNumbers, PlanePlace, plane_numbers};
pub use sphere::{SphereNumbers, is_outside, signum_of_discriminant, sphere_numbers};

use crate::exact::{ExactRay, Root, signum};
use crate::scene::{Object, Plane, Sphere};

/// The geometry of an object, without name and colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// `‖p − center‖ = |radius|`. A radius of 0 is hit by no ray; a negative one stands for its
    /// magnitude. (Scene files allow neither.)
    Sphere {
        /// Centre, world units.
        center: DVec3,
        /// Radius, world units.
        radius: f64,
    },
    /// `(p − point)·normal = 0`. A zero normal is hit by no ray. (Scene files allow none.)
    Plane {
        /// Any point of the plane, world units.
        point: DVec3,
        /// Normal of any length.
        normal: DVec3,
    },
}

impl From<&Sphere> for Shape {
    fn from(sphere: &Sphere) -> Shape {
        Shape::Sphere { center: sphere.center, radius: sphere.radius }
    }
}

impl From<&Plane> for Shape {
    fn from(plane: &Plane) -> Shape {
        Shape::Plane { point: plane.point, normal: plane.normal }
    }
}

impl From<Object<'_>> for Shape {
    fn from(object: Object<'_>) -> Shape {
        match object {
            Object::Sphere(sphere) => sphere.into(),
            Object::Plane(plane) => plane.into(),
        }
    }
}

/// The side of a surface that a ray meets (contract §1, "normal").
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The outside of a sphere, the side of a plane that its normal points to. A ray tangent to a
    /// sphere meets the front.
    Front,
    /// The other one: the reported normal is the flipped one.
    Back,
}

/// The smallest root `t > 0` of one object, however large, and the side that the ray meets there.
pub fn visible_root(ray: &ExactRay, shape: &Shape) -> Option<(Root, Side)> {
    if signum(ray.norm_squared()) == 0 {
        return None;
    }
    match *shape {
        Shape::Sphere { center, radius } => sphere::visible_root(ray, center, radius),
        Shape::Plane { point, normal } => plane::visible_root(ray, point, normal),
    }
}

/// The unit normal on the front at a root, in numbers of the same kind as the root itself. `None` where
/// there is none: a number that is not finite, a radius or normal of 0.
pub(crate) fn outward_normal(ray: &ExactRay, root: &Root, shape: &Shape) -> Option<[Root; 3]> {
    match *shape {
        Shape::Sphere { center, radius } => sphere::outward_normal(ray, root, center, radius),
        Shape::Plane { normal, .. } => plane_normal(normal),
    }
}
