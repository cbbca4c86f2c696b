//! The oracle, asked about scenes as the crate holds them.

use std::sync::Arc;

use kugelblitz::rays::{Lens, View};
use kugelblitz::scene::{self, Color, Object, Scene, Source};
use kugelblitz::shade::Background;

use crate::oracle;
use crate::oracle::scene as text;
pub use crate::oracle::{Answer, Channel, TIE_BITS, Truth, edges, enclosure};

pub struct Oracle(oracle::Oracle);

impl Oracle {
    /// The scene's picture with its camera and its samples.
    pub fn new(scene: &Scene, width: u32, height: u32) -> Oracle {
        let view = View::new(scene.camera.as_ref().expect("a camera"));
        let samples = scene.samples.map_or(1, |samples| samples.across());
        Oracle::with_view(scene, view, width, height, samples)
    }

    pub fn with_view(scene: &Scene, view: View, width: u32, height: u32, samples: u32) -> Oracle {
        let scene = Arc::new(of_scene(scene));
        Oracle(oracle::Oracle::seen_by(&scene, of_view(&view), width, height, samples))
    }

    /// The same where samples that hit nothing count otherwise.
    pub fn before(self, background: Background) -> Oracle {
        Oracle(self.0.before(match background {
            Background::Shown => oracle::Background::Shown,
            Background::LeftOut => oracle::Background::LeftOut,
            Background::Black => oracle::Background::Black,
        }))
    }

    pub fn pixel(&self, x: u32, y: u32) -> Truth {
        self.0.pixel(x, y)
    }
}

fn of_view(view: &View) -> text::Camera {
    text::Camera {
        position: view.position.to_array(),
        forward: view.forward.to_array(),
        right: view.right.to_array(),
        true_up: view.true_up.to_array(),
        h: view.h,
        is_orthographic: view.lens == Lens::Orthographic,
    }
}

fn of_scene(scene: &Scene) -> text::Scene {
    let light = |light: &scene::Light| text::Light {
        source: match light.source {
            Source::Point(position) => text::Source::Point(position.to_array()),
            Source::Sun(direction) => text::Source::Sun(direction.to_array()),
            Source::Eye => text::Source::Eye,
        },
        color: light.color.0,
        intensity: light.intensity,
        shadows: light.shadows,
    };
    let sky = |sky: scene::Sky| text::Sky { intensity: sky.intensity, directions: sky.directions };
    let mut converted = text::Scene {
        background: scene.background.0,
        ambient: scene.ambient.map(|ambient| ambient.0),
        lights: scene.lights.iter().map(light).collect(),
        sky: scene.sky.map(sky),
        ..text::Scene::default()
    };
    for ((_, object), Color(color)) in scene.objects().zip(scene.colors().skip(1)) {
        match object {
            Object::Sphere(sphere) => {
                let (center, radius) = (sphere.center.to_array(), sphere.radius);
                converted.spheres.push(text::Sphere { center, radius, color });
            }
            Object::Plane(plane) => {
                let (point, normal) = (plane.point.to_array(), plane.normal.to_array());
                converted.planes.push(text::Plane { point, normal, color });
            }
        }
    }
    converted
}
