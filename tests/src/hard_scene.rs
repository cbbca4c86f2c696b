//! A hard case as a scene and its ray.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Ray, Rays};

use crate::hard_cases::{HardCase, HardShape};
use crate::{plane, scene, sphere};

pub fn hard_scene(case: &HardCase) -> (Arc<Scene>, Rays) {
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let (spheres, planes) = match case.shape {
        HardShape::Sphere { center, radius, .. } => {
            (vec![sphere(vector(center), radius.into())], vec![])
        }
        HardShape::Plane { point, normal, .. } => {
            (vec![], vec![plane(vector(point), vector(normal))])
        }
    };
    let ray = Ray { origin: vector(case.origin), direction: vector(case.direction) };
    (Arc::new(scene(spheres, planes)), Rays::List(vec![ray]))
}
