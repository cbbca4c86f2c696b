//! Lights on surfaces, or so close to them that numbers do not tell the side: a lamp in a ceiling, a bulb that touches its shade.
//!
//! The side is a sign that does not depend on the point that is lit. So it is found exactly, once for each light and object. With
//! it f32 decides most shadow rays that would otherwise all need exact arithmetic, as they end at the surface.
//!
//! # Spheres
//! A shadow ray `p + s·w` ends at the light `L = p + w`. Let `f(s) = |p + s·w − c|²`, which is convex, and `f(1) = |L − c|²`.
//! - The light is on the sphere or outside, `f(1) ≥ r²`. If `w·(L − c) ≤ 0`, then `f'(1) ≤ 0`, so `f(s) > f(1) ≥ r²` before the
//!   light: the sphere is not in the way. From inside and for a light on the sphere, the segment stays in the closed ball,
//!   which it leaves at the light at the earliest: not in the way either.
//! - The light is inside, `f(1) < r²`. From outside the segment crosses the surface; from inside it does not.
//!
//! All else follows as for other lights ([`super::shadow`]). For a light on the sphere, the end is neither outside nor crosses: a
//! point outside is in shadow exactly if `w·(L − c) > 0`, as the product of the roots is `(|p − c|² − r²)/|w|²` and the
//! other root is 1.
//!
//! The computed `(c − L)·w/|w|` is off by the error `e` of the computed `c − L`, by the turn `θ` of the way, times a length of at most
//! `|c − L| + e`, and by [`OF_COSINE`](super::shadow::OF_COSINE) roundings of `|c − L|`.
//!
//! # Planes
//! A plane is in the way if start and end are on different sides. The side of the end is known, and a light on the plane ends the
//! shadow ray before it crosses.

use glam::DVec3;

use crate::guard::length_bound;
use crate::num::Scaled;
use crate::scene::Object;

/// A light that is on the surface of an object, or close to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The id of the object.
    pub id: u32,
    /// The exact side of the light: 1 outside of a sphere or in front of a plane, 0 on the surface, −1 inside or behind.
    pub side: f64,
}

/// Distance of a light from a surface, relative to the distances of both from the reference point, up to which the exact side is
/// found. No bound: it weighs one exact sign against shadow rays that f32 leaves undecided.
const CLOSE: f64 = 1.0 / (1u64 << 12) as f64;

impl Contact {
    /// The contact of a light with an object, seen from a reference point; `None` where the light is not close to the surface.
    pub fn new((id, object): (u32, Object), light: DVec3, reference: DVec3) -> Option<Contact> {
        let from_reference = length_bound(light - reference);
        let (distance, size) = match object {
            Object::Sphere(sphere) => {
                let (center, r) = (sphere.center - reference, sphere.radius.abs());
                (length_bound(light - sphere.center) - r, length_bound(center) + r)
            }
            Object::Plane(plane) => {
                let normal = Scaled::new(plane.normal).rounded();
                let distance = normal.dot(light - plane.point) / length_bound(normal);
                (distance, length_bound(plane.point - reference))
            }
        };
        let is_close = distance.abs() <= CLOSE * (size + from_reference);
        let side = is_close.then(|| object.side_of(light)).flatten()?;
        Some(Contact { id, side: f64::from(side) })
    }

    /// The side of the light with these contacts at an object; `None` where it is not close to it.
    #[inline(always)]
    pub fn side_at(contacts: &[Contact], id: u32) -> Option<f64> {
        contacts.iter().find(|contact| contact.id == id).map(|contact| contact.side)
    }
}
