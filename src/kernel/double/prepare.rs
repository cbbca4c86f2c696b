//! Scene → records.

use glam::DVec3;

use super::{PlaneDouble, SphereDouble};
use crate::kernel::Lists;
use crate::num::Scaled;
use crate::scene::{Plane, Scene, Sphere};

/// The objects of a scene, relative to `reference`.
pub fn objects(scene: &Scene, reference: DVec3) -> Lists<SphereDouble, PlaneDouble> {
    let sphere = |sphere: &Sphere| SphereDouble::new(sphere, reference);
    Lists::new(scene, sphere, |plane| PlaneDouble::new(plane, reference))
}

impl SphereDouble {
    fn new(sphere: &Sphere, reference: DVec3) -> SphereDouble {
        let l = sphere.center - reference;
        SphereDouble {
            center: l.to_array(),
            radius: sphere.radius,
            k: l.length_squared() - sphere.radius * sphere.radius,
            padding: [0.0; 3],
        }
    }
}

impl PlaneDouble {
    fn new(plane: &Plane, reference: DVec3) -> PlaneDouble {
        let l = plane.point - reference;
        let normal = Scaled::new(plane.normal).rounded();
        PlaneDouble {
            offset: l.to_array(),
            n_offset: l.dot(normal),
            normal: normal.to_array(),
            padding: 0.0,
        }
    }
}
