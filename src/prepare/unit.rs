//! Another unit of length for scenes that f32 has no room for: a galaxy in meters, atoms in meters.
//!
//! The unit is a power of two, so that every number stays exact. Then ids, normals, shadows and colors stay the same as well, and
//! `t` is multiplied by the unit before it is rounded.

use std::sync::Arc;

use glam::DVec3;

use crate::bounds;
use crate::num::typical::{nth, sample};
use crate::num::{exponent_of, power_of_two};
use crate::rays::{Lens, Pixels, Rays, View, WorldRay};
use crate::scene::{Light, Plane, Scene, Source, Sphere};
use crate::support::parallel;

/// A unit of length: `2^exponent` world units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LengthUnit {
    exponent: i32,
}

/// A scene keeps world units if the exponent of a typical distance is in this range, and the typical radius is not too small. Not
/// bounds: f32 has room for more, but devices have boxes and origins up to `2⁴⁰` ([`crate::bvh::REACH`]) and a least slack of `2⁻³⁷`,
/// and a scene has spheres and rays that are not typical.
const DISTANCES: std::ops::RangeInclusive<i32> = -14..=31;

/// Smallest exponent of a typical radius with which a scene keeps world units. Not a bound.
const SMALLEST_RADIUS: i32 = -30;

/// Largest exponent of a unit: `t` stays in f32's range.
const LARGEST: i32 = bounds::LARGEST_SHIFT;

/// Smallest exponent of a unit. No bound: a smaller scene is traced in this unit, mostly by f64.
const SMALLEST: i32 = -400;

impl LengthUnit {
    /// World units.
    pub const WORLD: LengthUnit = LengthUnit { exponent: 0 };

    /// Chooses the unit of a scene: that in which a typical distance between objects is as much above 1 as a typical radius is
    /// below.
    pub fn of(scene: &Scene) -> LengthUnit {
        let spheres = sample(&scene.spheres);
        let points = scene.lights.iter().filter_map(|light| match light.source {
            Source::Point(position) => Some(position),
            Source::Sun(_) | Source::Eye => None,
        });
        let points = points.chain(scene.planes.iter().map(|plane| plane.point));
        let radii: Vec<f64> = spheres.clone().map(|sphere| sphere.radius.abs()).collect();
        let places: Vec<(DVec3, f64)> = spheres
            .map(|sphere| (sphere.center, sphere.radius.abs()))
            .chain(points.map(|point| (point, 0.0)))
            .collect();
        // Of two in the middle, the lesser one.
        let median = |all: Vec<f64>| nth(all.len().saturating_sub(1) / 2, all);
        let coordinates = |axis| places.iter().map(|(at, _)| at[axis]).collect();
        let middle = DVec3::from_array([0, 1, 2].map(|axis| median(coordinates(axis))));
        let distance = |&(at, r): &(DVec3, f64)| (at - middle).abs().max_element() + r;
        let exponent = |length: f64| exponent_of(DVec3::splat(length));
        // Distances of 0 are no measure: a plane whose point is in the middle of a single sphere.
        let distances = places.iter().map(distance).filter(|&distance| distance > 0.0);
        let far = exponent(median(distances.collect()));
        // A tiny sphere among few is not typical either: of two in the middle, the larger one.
        let near = if radii.is_empty() { far } else { exponent(nth(radii.len() / 2, radii)) };
        if DISTANCES.contains(&far) && near >= SMALLEST_RADIUS {
            return LengthUnit::WORLD;
        }
        LengthUnit { exponent: ((far + near) / 2).clamp(SMALLEST, LARGEST) }
    }

    /// A unit of `2^exponent` world units.
    #[cfg(test)]
    pub(crate) fn of_exponent(exponent: i32) -> LengthUnit {
        LengthUnit { exponent }
    }

    /// World units in this one.
    pub fn factor(self) -> f64 {
        power_of_two(self.exponent)
    }

    /// The unit is `2^exponent` world units.
    pub fn exponent(self) -> i32 {
        self.exponent
    }

    /// A length in this unit; `None` where f64 does not have it exactly.
    fn length(self, x: f64) -> Option<f64> {
        let half = self.exponent / 2;
        let scale = |x: f64, sign: i32| {
            x * power_of_two(sign * half) * power_of_two(sign * (self.exponent - half))
        };
        let scaled = scale(x, -1);
        (scaled.is_finite() && scale(scaled, 1) == x).then_some(scaled)
    }

    fn point(self, v: DVec3) -> Option<DVec3> {
        Some(DVec3::new(self.length(v.x)?, self.length(v.y)?, self.length(v.z)?))
    }

    fn sphere(self, sphere: &Sphere) -> Option<Sphere> {
        let Sphere { center, radius } = *sphere;
        Some(Sphere { center: self.point(center)?, radius: self.length(radius)? })
    }

    /// The scene in this unit, without its camera; `None` where f64 does not have a number exactly.
    pub fn scene(self, scene: &Scene) -> Option<Arc<Scene>> {
        let mut scaled = Scene { camera: None, ..scene.clone() };
        let inexact = |i| self.sphere(&scene.spheres[i]).is_none().then_some(());
        if !parallel::filter_map(scene.spheres.len(), inexact).is_empty() {
            return None;
        }
        for sphere in &mut *scaled.spheres {
            *sphere = self.sphere(sphere)?;
        }
        for Plane { point, .. } in &mut scaled.planes {
            *point = self.point(*point)?;
        }
        for Light { source, .. } in &mut scaled.lights {
            if let Source::Point(position) = source {
                *position = self.point(*position)?;
            }
        }
        Some(Arc::new(scaled))
    }

    /// Pixels in this unit; `None` where f64 does not have a number exactly.
    pub fn pixels(self, pixels: &Pixels) -> Option<Pixels> {
        let View { position, h, lens, .. } = pixels.view;
        let h = match lens {
            Lens::Perspective => h,
            Lens::Orthographic => self.length(h)?,
        };
        let view = View { position: self.point(position)?, h, ..pixels.view };
        Some(Pixels { view, ..*pixels })
    }

    /// Rays in this unit; `None` where f64 does not have a number exactly. Directions keep their lengths.
    pub fn rays(self, rays: &Rays) -> Option<Rays> {
        Some(match rays {
            Rays::Pixels(pixels) => Rays::Pixels(self.pixels(pixels)?),
            Rays::List(rays) => {
                let ray =
                    |ray: &WorldRay| Some(WorldRay { origin: self.point(ray.origin)?, ..*ray });
                Rays::List(rays.iter().map(ray).collect::<Option<Vec<WorldRay>>>()?)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Color;

    fn row(size: f64) -> Scene {
        let sphere =
            |k: i32| Sphere { center: DVec3::X * f64::from(k) * size, radius: 0.25 * size };
        Scene { spheres: (0..100).map(sphere).collect::<Vec<_>>().into(), ..Scene::default() }
    }

    #[test]
    fn ordinary_scenes_keep_world_units_and_others_come_near_1() {
        for size in [1e-3, 1.0, 1e6, 1e8] {
            assert_eq!(LengthUnit::of(&row(size)), LengthUnit::WORLD, "{size:e}");
        }
        for size in [1e-30, 1e-10, 1e12, 1e20] {
            let unit = LengthUnit::of(&row(size));
            let scaled = unit.scene(&row(size)).unwrap().spheres[1];
            assert!((1e-3..1e3).contains(&scaled.center.x), "{size:e}: {scaled:?}");
            assert_eq!(scaled.center.x * unit.factor(), size);
        }
        assert_eq!(LengthUnit::of(&row(1e200)).exponent, LARGEST);
        assert_eq!(LengthUnit::of(&Scene::default()), LengthUnit::WORLD);
    }

    #[test]
    fn a_sphere_on_a_plane_chooses_the_unit() {
        let sphere = Sphere { center: DVec3::Y * 1e16, radius: 1e16 };
        let mut scene = Scene { spheres: vec![sphere].into(), ..Scene::default() };
        scene.planes =
            vec![Plane { name: None, point: DVec3::ZERO, normal: DVec3::Y, color: Color::BLACK }];
        assert_eq!(LengthUnit::of(&scene).exponent, 53);
    }

    /// An outlier does not choose the unit.
    #[test]
    fn one_far_or_huge_sphere_keeps_world_units() {
        for (x, radius) in [(1e30, 1.0), (0.0, 1e30), (0.0, 1e-30)] {
            let mut spheres = row(1.0).spheres.to_vec();
            spheres[17] = Sphere { center: DVec3::X * x, radius };
            let scene = Scene { spheres: spheres.into(), ..Scene::default() };
            assert_eq!(LengthUnit::of(&scene), LengthUnit::WORLD);
        }
    }

    #[test]
    fn what_does_not_stay_exact_is_refused() {
        let unit = LengthUnit { exponent: 20 };
        assert_eq!(unit.length(3e-300), Some(3e-300 * 2f64.powi(-20)));
        assert_eq!(unit.length(3e-305), None);
        assert_eq!(LengthUnit { exponent: -20 }.length(f64::MAX), None);
        let tiny = Sphere { center: DVec3::X * 3e-310, radius: 1.0 };
        assert!(unit.scene(&Scene { spheres: vec![tiny].into(), ..Scene::default() }).is_none());
    }
}
