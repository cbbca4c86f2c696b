//! Scenes made for the report: error and time against one quantity, and many spheres, which `certified` finds
//! through a hierarchy.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::generate::{Distribution, Recipe};
use kugelblitz::random::SplitMix;
use kugelblitz::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use kugelblitz::trace::{Kernel, Rays, WorldRay};

use super::measure::{IDS, Make, Subject, Times, Work, n_pixels, pixels_of};
use super::{Benchmark, Metric, Of, Settings};

/// Error or time against one quantity.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    /// `distance`, `offset` or `objects`.
    pub name: &'static str,
    /// The sweep's subject, in a sentence.
    pub title: &'static str,
    /// The quantity in words.
    pub x_label: &'static str,
}

/// The sweeps that a report has.
pub const SWEEPS: [Sweep; 3] = [
    Sweep {
        name: "distance",
        title: "Error against distance: a sphere of radius 1, half of the rays aimed close to its silhouette",
        x_label: "distance of the sphere's centre from the eye / radius",
    },
    Sweep {
        name: "offset",
        title: "Error against the distance from the origin: three spheres on a floor, each of size 1, moved \
                together with the camera",
        x_label: "distance of the scene from the origin / size of an object",
    },
    Sweep {
        name: "objects",
        title: "Time against the number of spheres: spread evenly in a cube, all in view; clouds with \
                certified alone, which finds the spheres of a pixel in a hierarchy",
        x_label: "spheres",
    },
];

/// Rays of each point of the sweep over distance.
const DISTANCE_RAYS: usize = 1 << 14;

/// Pictures of the sweep over the offset, px.
const OFFSET_SIZE: [u32; 2] = [240, 135];

/// Pictures of the sweep over the number of objects, px.
const OBJECTS_SIZE: [u32; 2] = [480, 270];

/// Numbers of spheres that are timed with every kernel. [`Settings::clouds`] are timed with `certified`
/// alone: the others test every ray against each sphere.
const OBJECTS: [u64; 5] = [1, 4, 16, 64, 256];

/// Pictures of clouds, px.
pub const CLOUD_SIZE: [u32; 2] = [1920, 1080];

/// Rays of a cloud that are compared with exact arithmetic, which looks at each sphere for each of them.
const CLOUD_SAMPLES: usize = 1 << 10;

/// The times of a picture of spheres.
const TIMES: Times = &[(IDS, &[Metric::TraceNsPerRay, Metric::PictureMs, Metric::BuildMs])];

impl<'a> Work<'a> {
    /// The points of all sweeps, and the clouds.
    pub(super) fn made(self) -> Vec<Subject<'a>> {
        let Settings { samples, seed, sweeps, clouds, .. } = self.settings;
        let of = |sweep: &str, x| Of::Sweep { sweep: sweep.into(), x };
        // Rays of which the errors alone are measured.
        let untimed = |of, n_rays: usize, make: Make<'a>| Subject {
            of,
            make,
            n_rays: n_rays as u64,
            n_compared: n_rays,
            times: &[],
            benchmarks: self.benchmarks.iter().collect(),
        };
        let distances = (1..13).map(|k| 10f64.powf(f64::from(k) / 2.0)).map(|x| {
            let make = Box::new(move || Ok(at_distance(x, *seed)));
            untimed(of("distance", x), DISTANCE_RAYS, make)
        });
        let offsets = (0..11).map(|k| 10f64.powi(k)).map(|x| {
            let make = Box::new(move || Ok(at_offset(x)));
            untimed(of("offset", x), n_pixels(OFFSET_SIZE) as usize, make)
        });
        let objects = OBJECTS
            .iter()
            .chain(clouds)
            .map(|&n| self.cloud(of("objects", n as f64), (n, *seed), OBJECTS_SIZE, 0));
        let swept = distances.chain(offsets).chain(objects).filter(|_| *sweeps);
        let clouds = clouds.iter().map(|&spheres| {
            let n_compared = (*samples).min(CLOUD_SAMPLES);
            self.cloud(Of::Cloud { spheres }, (spheres, 1), CLOUD_SIZE, n_compared)
        });
        swept.chain(clouds).collect()
    }

    /// Spheres evenly in a cube, as `kugelblitz generate cloud` makes them, and a picture of all of it.
    fn cloud(
        self,
        of: Of,
        (count, seed): (u64, u64),
        size: [u32; 2],
        n_compared: usize,
    ) -> Subject<'a> {
        let recipe = Recipe { distribution: Distribution::Uniform, count, seed };
        let make = move || {
            let pixels = pixels_of(&recipe.camera(), size);
            Ok((Arc::new(recipe.scene(self.control)?), Rays::Pixels(pixels)))
        };
        let takes_part =
            |of: &&Benchmark| of.kernel == Kernel::Certified || OBJECTS.contains(&count);
        let benchmarks = self.benchmarks.iter().filter(takes_part).collect();
        let n_rays = n_pixels(size);
        Subject { of, make: Box::new(make), n_rays, n_compared, times: TIMES, benchmarks }
    }
}

/// A sphere of radius 1 around a random point `distance` away from the eye at the origin. Every
/// second ray passes its centre at `1 ± 2⁻ᵏ` radii with `k` up to 24, the others anywhere up to
/// 1.5 radii.
fn at_distance(distance: f64, seed: u64) -> (Arc<Scene>, Rays) {
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

/// Three spheres on a floor, moved away from the origin together with their camera.
fn at_offset(distance: f64) -> (Arc<Scene>, Rays) {
    let offset = distance * DVec3::new(0.6, 0.48, -0.64);
    let camera = Camera {
        position: offset + DVec3::new(0.3, 1.6, 7.0),
        look_at: offset + DVec3::new(0.0, 0.8, 0.0),
        up: DVec3::Y,
        projection: Projection::Perspective { fov_degrees: 40.0 },
    };
    let spheres = [(-1.7, 1.0, 0.2), (0.4, 0.8, -0.9), (1.6, 0.6, 0.8)]
        .map(|(x, radius, z)| Sphere { center: offset + DVec3::new(x, radius, z), radius });
    let floor = Plane { name: None, point: offset, normal: DVec3::Y, color: Color([0.5; 3]) };
    let pixels = pixels_of(&camera, OFFSET_SIZE);
    let (spheres, planes) = (spheres.to_vec().into(), vec![floor]);
    let scene = Scene { camera: Some(camera), spheres, planes, ..Scene::default() };
    (Arc::new(scene), Rays::Pixels(pixels))
}
