//! Where a ray meets its object, in f64 with a bound of the error.

use super::Stage;
use super::nearness::Place;
use super::surface::{PlaneSight, Sight, SphereSight};
use crate::exact::{ExactHit, ExactPoint, Shape, visible_root};
use crate::guard::{UNIT_F64, steps};
use crate::kernel::RayOf;
use crate::scene::Object;
use crate::vec3::{Vec3, dot3};

/// A point of a surface, relative to [`Prepared::reference`](crate::prepare::Prepared::reference), and
/// the unit normal there that faces the ray.
#[derive(Clone, Copy, Debug)]
pub struct PointF64 {
    /// The point.
    pub at: Vec3<f64>,
    /// Bound of its distance from the true one.
    pub error: f64,
    /// The normal.
    pub normal: Vec3<f64>,
    /// Bound of its distance from the true one.
    pub normal_error: f64,
    /// True where the point is on a sphere that the ray starts in.
    pub is_inside: bool,
    /// Direction of the ray.
    pub direction: Vec3<f64>,
    /// Bound of its relative error.
    pub direction_error: f64,
}

impl Stage<'_> {
    /// The point of the object that a ray is known to see; `None` where nothing is known in f64.
    ///
    /// With `t` between two bounds, `Δ` half their difference, and its middle, `o + t·d` is off by
    /// `|d|·Δ`, by the direction's `δε·t|d|`, the origin's `λε|o|`, and by the rounding of the product
    /// and the sum, `ε·t|d|` and `ε(|o| + t|d|)`; a third digit more for the rest, and the middle's own
    /// rounding, `ε·t|d|`.
    pub(crate) fn point_f64(&self, index: usize, id: u32) -> Option<PointF64> {
        let ray = self.ray_f64(index);
        if !self.usable || ray.exponent != 0 {
            return None;
        }
        let bounds = &self.bounds;
        let (found, normal_error, is_inside) = match self.scene.object(id)? {
            Object::Sphere(sphere) => {
                let place = Place::new(sphere, ray.reference, ray.ray.origin);
                let sight = SphereSight::new(&place, self.known_k(id, sphere), bounds);
                let (found, error) = sight.seen(&ray.ray, bounds)?;
                (found, error, sight.k < 0.0)
            }
            Object::Plane(_) => {
                let sight = PlaneSight::new(self.plane(id), &ray, bounds);
                (sight.surface(&ray.ray, bounds), steps::NORMALIZED * UNIT_F64, false)
            }
        };
        let RayOf { origin, direction, a, .. } = ray.ray;
        let (low, high) = found.t(a, &bounds.widening)?;
        let t = low + (high - low) / 2.0;
        let (length, from) = (a.sqrt(), dot3(origin, origin).sqrt());
        let (offset, turned) = (bounds.input.offset, bounds.input.direction);
        let rounding = UNIT_F64 * ((turned + 3.0) * t * length + (offset + 1.0) * from);
        let at = origin + direction * t;
        let error = 1.01 * (length * (high - low) / 2.0 + rounding);
        let normal = found.normal();
        let is_finite = error.is_finite() && normal_error.is_finite();
        is_finite.then_some(PointF64 {
            at,
            error,
            normal,
            normal_error,
            is_inside,
            direction,
            direction_error: turned * UNIT_F64,
        })
    }

    /// The exact ray of a pixel, the shape of the object that it is known to see, and the point there.
    pub(crate) fn exact_point(&self, index: usize, id: u32) -> Option<(ExactPoint, Shape)> {
        let ray = self.exact_ray(index);
        let shape = Shape::from(self.scene.object(id)?);
        let (root, side) = visible_root(&ray, &shape)?;
        Some((ExactPoint::new(&ray, &ExactHit { id, root, side }), shape))
    }
}
