//! What exact arithmetic asks of a shape; each answers in a file of its own.

mod plane;
mod sphere;

pub(crate) use plane::unit_f32;
pub use plane::{PlaneNumbers, plane_numbers};
pub use sphere::{SphereNumbers, signum_of_discriminant, sphere_numbers};

use dashu_int::IBig;
use glam::DVec3;

use super::light::{ExactBeam, Surd};
use super::{Ball, DoubleDoubleRay, Dyadic, Enclosure, ExactRay, QuadraticSurd};
use crate::scene::{Object, Source};

/// The side of a surface that a ray meets (contract §1, "normal").
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The outside of a sphere, the side of a plane that its normal points to. A ray tangent to a
    /// sphere meets the front.
    Front,
    /// The other one: the reported normal is the flipped one.
    Back,
}

/// The points of an object: the same for two that are in one place.
#[derive(PartialEq, Eq, Hash)]
pub(crate) enum ExactPlace {
    /// Bits of a centre and a radius.
    Sphere([u64; 4]),
    /// A normal and an offset.
    Plane(Box<([IBig; 3], (IBig, isize))>),
}

/// A shape in exact numbers: `None` where one of them is not finite, and for a radius or a normal of 0, which no ray hits.
pub(super) trait ExactShape {
    /// The smallest root `t > 0` of a ray, however large, and the side that it meets there.
    fn visible_root(&self, ray: &ExactRay) -> Option<(QuadraticSurd, Side)>;
    /// The unit normal on the front at a root, in numbers of the same kind as the root itself.
    fn outward_normal(&self, ray: &ExactRay, root: &QuadraticSurd) -> Option<[QuadraticSurd; 3]>;
    /// Root and facing normal of a ray that is known to hit it, from numbers of some 100 bits; `None` where these leave it open.
    fn surface_in_balls(&self, sight: &DoubleDoubleRay) -> Option<(Ball, [f32; 3])>;
    /// `n·w` on the front where a beam starts, and `‖n‖²`.
    fn slope<'a>(&self, beam: &ExactBeam<'a>) -> Option<(Surd<'a>, Dyadic)>;
    /// Whether it is in the way: it has a root `s` of `p + s·w` with `0 < s`, and before a point light `s < 1`.
    fn blocks(&self, beam: &ExactBeam) -> Option<bool>;
    /// Whether it is, or may be, in the way of this light to the points on its own back.
    fn darkens_its_back(&self, _: Source) -> bool {
        false
    }
    /// Bounds of a numerator and a denominator, both positive, of the smallest such root, where it is in the way.
    fn first_root(&self, beam: &ExactBeam, n_bits: usize) -> Option<[Enclosure; 2]>;
    /// See [`Object::side_of`].
    fn side_of(&self, point: DVec3) -> Option<i32>;
    /// Where it is.
    fn place(&self) -> Option<ExactPlace>;
}

impl<'a> Object<'a> {
    pub(super) fn exact(self) -> &'a dyn ExactShape {
        match self {
            Object::Sphere(sphere) => sphere,
            Object::Plane(plane) => plane,
        }
    }

    /// Whether it is, or may be, in the way of this light to the points on its own back.
    pub(crate) fn darkens_its_back(self, light: Source) -> bool {
        self.exact().darkens_its_back(light)
    }

    /// The side of its surface that a point lies on: 1 outside of a sphere or in front of a plane, 0 on the surface, −1 inside or
    /// behind; `None` where a number is not finite.
    pub fn side_of(self, point: DVec3) -> Option<i32> {
        self.exact().side_of(point)
    }

    /// Where it is; `None` where no ray hits it.
    pub(crate) fn place(self) -> Option<ExactPlace> {
        self.exact().place()
    }
}
