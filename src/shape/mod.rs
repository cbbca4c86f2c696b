//! The geometry of objects, a file each: the exact root that is seen, its normal, and the numbers on
//! the way there.

mod plane;
mod sphere;

pub(crate) use plane::plane_normal;
pub use plane::{PlaneNumbers, plane_numbers};
pub use sphere::{SphereNumbers, is_outside, signum_of_discriminant, sphere_numbers};

use dashu_int::IBig;

use crate::exact::{ExactHit, ExactRay, Root, signum};
use crate::scene::{Object, Sphere};

/// The side of a surface that a ray meets (contract §1, "normal").
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The outside of a sphere, the side of a plane that its normal points to. A ray tangent to a
    /// sphere meets the front.
    Front,
    /// The other one: the reported normal is the flipped one.
    Back,
}

/// The hit of one object: the smallest root `t > 0`, however large, and the side that the ray meets there.
///
/// A sphere of radius 0 and a plane with a zero normal are hit by no ray; a negative radius stands for its magnitude. (Scene
/// files allow none of these.)
pub fn visible_hit<'a>(ray: &ExactRay, id: u32, object: Object<'a>) -> Option<ExactHit<'a>> {
    if signum(ray.norm_squared()) == 0 {
        return None;
    }
    let (root, side) = match object {
        Object::Sphere(sphere) => sphere::visible_root(ray, sphere)?,
        Object::Plane(plane) => plane::visible_root(ray, plane)?,
    };
    Some(ExactHit { id, object, root, side })
}

/// The unit normal on the front at a hit, in numbers of the same kind as the root itself. `None` where
/// there is none: a number that is not finite, a radius or normal of 0.
pub(crate) fn outward_normal(ray: &ExactRay, hit: &ExactHit) -> Option<[Root; 3]> {
    match hit.object {
        Object::Sphere(sphere) => sphere::outward_normal(ray, &hit.root, sphere),
        Object::Plane(plane) => plane_normal(plane),
    }
}

/// The points of an object: the same for two that are in one place.
#[derive(PartialEq, Eq, Hash)]
pub(crate) enum Place {
    /// Bits of a centre and a radius.
    Sphere([u64; 4]),
    /// A normal and an offset.
    Plane(Box<([IBig; 3], (IBig, isize))>),
}

impl Object<'_> {
    /// Where it is; `None` where no ray hits it.
    pub(crate) fn place(self) -> Option<Place> {
        match self {
            Object::Sphere(Sphere { center, radius }) => {
                let [x, y, z] = center.to_array();
                (*radius != 0.0).then(|| Place::Sphere([x, y, z, *radius].map(f64::to_bits)))
            }
            Object::Plane(plane) => plane::place(plane),
        }
    }
}
