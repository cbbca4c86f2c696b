//! Scene → records.

use super::{PlaneLecture, SphereLecture};
use crate::kernel::Lists;
use crate::scene::{Plane, Scene, Sphere};

/// The objects of a scene.
pub fn objects(scene: &Scene) -> Lists<SphereLecture, PlaneLecture> {
    Lists::new(scene, SphereLecture::new, PlaneLecture::new)
}

impl SphereLecture {
    fn new(sphere: &Sphere) -> SphereLecture {
        SphereLecture { center: sphere.center.as_vec3().to_array(), radius: sphere.radius as f32 }
    }
}

impl PlaneLecture {
    fn new(plane: &Plane) -> PlaneLecture {
        PlaneLecture {
            point: plane.point.as_vec3().to_array(),
            pad0: 0.0,
            normal: plane.normal.as_vec3().to_array(),
            pad1: 0.0,
        }
    }
}
