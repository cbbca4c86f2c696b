//! Generated scenes: a sphere at a distance, and many spheres.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::generate::{Distribution, Recipe};
use kugelblitz::query::{Rays, WorldRay};
use kugelblitz::scene::{Scene, Sphere};
use kugelblitz::support::random::SplitMix;

use super::measure::pixels_of;

/// Number of rays towards the sphere at each distance.
pub const DISTANCE_RAYS: usize = 1 << 14;

/// Maximum number of spheres for kernels without a hierarchy, which test each ray against each sphere.
pub const MOST_TESTED: u64 = 256;

/// Generates a sphere of radius 1 in a random direction from the camera at the origin. Every second ray passes the centre
/// at `1 ± 2⁻ᵏ` radii with `k` up to 24, close to the silhouette, the others anywhere up to 1.5 radii.
pub fn sphere_at_distance(distance: f64, seed: u64) -> (Arc<Scene>, Rays) {
    let mut random = SplitMix::new(seed ^ distance.to_bits());
    let mut signed = || 2.0 * random.unit() - 1.0;
    let axis = DVec3::new(signed(), signed(), signed()).normalize();
    let center = distance * axis;
    let (u, v) = axis.any_orthonormal_pair();
    let ray = |index: usize| {
        let pass = if index.is_multiple_of(2) {
            let k = 1.0 + 23.0 * random.unit();
            if random.unit() < 0.5 { 1.0 - 2f64.powf(-k) } else { 1.0 + 2f64.powf(-k) }
        } else {
            1.5 * random.unit()
        };
        let tangent = (pass / distance).min(1.0).asin().tan();
        let (sine, cosine) = (random.unit() * std::f64::consts::TAU).sin_cos();
        WorldRay { origin: DVec3::ZERO, direction: axis + tangent * (cosine * u + sine * v) }
    };
    let rays = (0..DISTANCE_RAYS).map(ray).collect();
    let spheres = vec![Sphere { center, radius: 1.0 }].into();
    (Arc::new(Scene { spheres, ..Scene::default() }), Rays::List(rays))
}

/// Generates spheres uniformly in a cube, as `kugelblitz generate` does, and a picture of all of them.
pub fn spheres_in_cube(
    count: u64,
    seed: u64,
    size: [u32; 2],
    control: &Control,
) -> Result<(Arc<Scene>, Rays)> {
    let recipe = Recipe { distribution: Distribution::Uniform, count, seed };
    let pixels = pixels_of(&recipe.camera(), size);
    Ok((Arc::new(recipe.scene(control)?), Rays::Pixels(pixels)))
}
