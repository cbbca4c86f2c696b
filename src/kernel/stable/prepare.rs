//! Scene → records.

use glam::DVec3;

use super::{PlaneStable, SphereStable};
use crate::kernel::Lists;
use crate::kernel::coordinates::split;
use crate::num::Scaled;
use crate::scene::{Plane, Scene, Sphere};

/// The objects of a scene, relative to `reference`.
pub fn objects(scene: &Scene, reference: DVec3) -> Lists<SphereStable, PlaneStable> {
    let sphere = |sphere: &Sphere| SphereStable::new(sphere, reference);
    Lists::new(scene, sphere, |plane| PlaneStable::new(plane, reference))
}

impl SphereStable {
    fn new(sphere: &Sphere, reference: DVec3) -> SphereStable {
        let l = sphere.center - reference;
        let (center, center_low) = split(l);
        let k = l.length_squared() - sphere.radius * sphere.radius;
        SphereStable { center, radius: sphere.radius as f32, center_low, k: k as f32 }
    }
}

impl PlaneStable {
    fn new(plane: &Plane, reference: DVec3) -> PlaneStable {
        let l = plane.point - reference;
        let normal = Scaled::new(plane.normal).rounded();
        let (offset, offset_low) = split(l);
        PlaneStable {
            offset,
            n_offset: l.dot(normal) as f32,
            offset_low,
            pad0: 0.0,
            normal: normal.as_vec3().to_array(),
            pad1: 0.0,
        }
    }
}
