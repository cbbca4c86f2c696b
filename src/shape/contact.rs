//! Lights on surfaces, or so close to one that f32 cannot compute the side: a lamp in a ceiling, a bulb that touches its shade.
//!
//! The side is a sign, which does not depend on the lit point. It is computed exactly, once for each light and object. With the side,
//! f32 decides most shadow rays. Without it, all shadow rays to the light need exact arithmetic, because they end at the
//! surface.
//!
//! # Spheres
//! A shadow ray `p + s·w` ends at the light `L = p + w`. Let `f(s) = |p + s·w − c|²`, which is convex, with `f(1) = |L − c|²`.
//! - The light is on the sphere or outside, `f(1) ≥ r²`. If `w·(L − c) ≤ 0`, then `f'(1) ≤ 0`, and `f(s) > f(1) ≥ r²` before the
//!   light: the sphere does not occlude it. If the point is inside and the light is on the sphere, then the segment stays in
//!   the ball up to the light: no occlusion either.
//! - The light is inside, `f(1) < r²`. The segment from a point outside crosses the surface; from a point inside it does not.
//! - The light is on the sphere, and the point is outside. One root of the polynomial `f(s) − r²` is 1, and the product of both is
//!   `(|p − c|² − r²)/|w|² > 0`. The other root is below 1 exactly if `w·(L − c) > 0`, because
//!   `|p − c|² − r² = |w|² − 2w·(L − c)`: then the sphere occludes the light.
//!
//! Everything else follows as for other lights ([`super::shadow`]).
//!
//! The error of the computed `(c − L)·w/|w|` has three parts: the error `e` of the computed `c − L`; the turn `θ` of the way, times a
//! length of at most `|c − L| + e`; and [`OF_COSINE`](super::shadow::OF_COSINE) roundings of `|c − L|`.
//!
//! # Planes
//! A plane occludes a light if start and end of the shadow ray are on different sides. The side of the end is known. A light on the plane
//! ends the shadow ray before it crosses.

use glam::DVec3;

use crate::bounds::length_bound;
use crate::num::{Float as _, ScaledInteger};
use crate::scene::Object;

/// A light that is on the surface of an object, or close to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The id of the object.
    pub id: u32,
    /// The exact side of the light: 1 outside of a sphere or in front of a plane, 0 on the surface, −1 inside or behind.
    pub side: f64,
}

/// The exact side is computed for lights up to this distance from a surface, relative to the distances of both from the reference
/// point. Not a bound: it weighs one exact sign against shadow rays that f32 leaves undecided.
const CLOSE: f64 = 1.0 / (1u64 << 12) as f64;

impl Contact {
    /// Returns the contact of a light with an object, seen from a reference point; `None` if the light is not close to the surface.
    pub fn new((id, object): (u32, Object), light: DVec3, reference: DVec3) -> Option<Contact> {
        let from_reference = length_bound(light - reference);
        let (distance, size) = match object {
            Object::Sphere(sphere) => {
                let (center, r) = (sphere.center - reference, sphere.radius.abs());
                (length_bound(light - sphere.center) - r, length_bound(center) + r)
            }
            Object::Plane(plane) => {
                let normal = ScaledInteger::new(plane.normal).rounded();
                let distance = normal.dot(light - plane.point) / length_bound(normal);
                (distance, length_bound(plane.point - reference))
            }
        };
        // Above this, both sides of the comparison below would be infinite.
        let is_in_range = from_reference < f64::LARGEST_ROOT && size < f64::LARGEST_ROOT;
        let is_close = is_in_range && distance.abs() <= CLOSE * (size + from_reference);
        let side = is_close.then(|| object.side_of(light)).flatten()?;
        Some(Contact { id, side: f64::from(side) })
    }

    /// Returns the side of an object that the light with these contacts is on; `None` if the light is not close to the object.
    #[inline(always)]
    pub fn side_at(contacts: &[Contact], id: u32) -> Option<f64> {
        contacts.iter().find(|contact| contact.id == id).map(|contact| contact.side)
    }
}
