//! Scenes made for the report: error and time against one quantity, and many spheres, which `certified` finds
//! through a hierarchy.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Result;
use kugelblitz::generate::{Distribution, Recipe};
use kugelblitz::random::SplitMix;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use kugelblitz::trace::{Kernel, Rays, WorldRay};
use kugelblitz_judge::verify::{Truth, sample};

use super::measure::{Subject, Work, n_pixels};
use super::{Benchmark, Missing, Of, Row, Settings};

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

impl Work<'_> {
    /// The numbers of spheres that are timed.
    fn numbers_of_spheres(&self) -> impl Iterator<Item = u64> {
        OBJECTS.into_iter().chain(self.settings.clouds.iter().copied())
    }

    /// The benchmarks that are timed with so many spheres.
    fn timed_with(&self, n: u64) -> impl Iterator<Item = &Benchmark> {
        let takes_part =
            move |of: &&Benchmark| of.kernel == Kernel::Certified || OBJECTS.contains(&n);
        self.benchmarks.iter().filter(takes_part)
    }

    /// Rays that [`Work::sweep_rows`] traces or compares.
    pub fn n_sweep_rays(&self) -> u64 {
        let of_distance = distances().len() * DISTANCE_RAYS;
        let errors = of_distance as u64 + offsets().len() as u64 * n_pixels(OFFSET_SIZE);
        let n_points: usize = self.numbers_of_spheres().map(|n| self.timed_with(n).count()).sum();
        let times = n_points as u64 * n_pixels(OBJECTS_SIZE) * self.n_pictures();
        let all = errors * (1 + self.benchmarks.len() as u64) + times;
        if self.settings.sweeps { all } else { 0 }
    }

    /// All sweeps: each point with each benchmark.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`](kugelblitz::Error::Interrupted).
    pub fn sweep_rows(&self) -> Result<Vec<Row>> {
        let (Settings { sweeps, seed, rounds, .. }, mut rows) = (self.settings, Vec::new());
        if !sweeps {
            return Ok(rows);
        }
        let of = |sweep: &str, x| Of::Sweep { sweep: sweep.into(), x };
        let distances = distances().map(|x| (of("distance", x), self.at_distance(x)));
        let offsets = offsets().map(|x| (of("offset", x), self.at_offset(x)));
        for (of, subject) in distances.chain(offsets) {
            rows.extend(self.rows(&of, self.benchmarks, &subject?)?.0);
        }
        for n in self.numbers_of_spheres() {
            let (scene, pixels) = self.cloud(n, *seed, OBJECTS_SIZE)?;
            let rays = Rays::Pixels(pixels);
            let subject = Subject { scene, rays, truth: None, n_rounds: *rounds };
            // Clouds in pictures tell what did not fit.
            let (timed, _) = self.rows(&of("objects", n as f64), self.timed_with(n), &subject)?;
            rows.extend(timed);
        }
        Ok(rows)
    }
}

/// Two points a decade.
fn distances() -> impl ExactSizeIterator<Item = f64> {
    (1..13).map(|k| 10f64.powf(f64::from(k) / 2.0))
}

fn offsets() -> impl ExactSizeIterator<Item = f64> {
    (0..11).map(|k| 10f64.powi(k))
}

fn sphere(center: DVec3, radius: f64) -> Sphere {
    Sphere { center, radius }
}

fn scene_of(camera: Option<Camera>, spheres: Vec<Sphere>, planes: Vec<Plane>) -> Arc<Scene> {
    Arc::new(Scene { camera, spheres: spheres.into(), planes, ..Scene::default() })
}

impl<'a> Work<'a> {
    /// Spheres evenly in a cube, as `kugelblitz generate cloud` makes them, and a picture of all of it.
    fn cloud(
        &self,
        count: u64,
        seed: u64,
        [width, height]: [u32; 2],
    ) -> Result<(Arc<Scene>, Pixels)> {
        let recipe = Recipe { distribution: Distribution::Uniform, count, seed };
        let pixels = Pixels::whole(View::new(&recipe.camera()), width, height);
        Ok((Arc::new(recipe.scene(self.control)?), pixels))
    }

    fn n_cloud_samples(&self) -> usize {
        self.settings.samples.min(CLOUD_SAMPLES)
    }

    /// Rays that [`Work::cloud_rows`] traces or compares.
    pub fn n_cloud_rays(&self) -> u64 {
        let of_cloud = |&n: &u64| {
            let pictures = self.timed_with(n).count() as u64 * (1 + self.n_pictures());
            let traced = n_pixels(CLOUD_SIZE) * pictures;
            if traced > 0 { traced + self.n_cloud_samples() as u64 } else { 0 }
        };
        self.settings.clouds.iter().map(of_cloud).sum()
    }

    /// Each cloud on each device that traces with `certified`, and what did not fit.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`](kugelblitz::Error::Interrupted).
    pub fn cloud_rows(&self) -> Result<(Vec<Row>, Vec<Missing>)> {
        let (mut rows, mut missing) = (Vec::new(), Vec::new());
        let is_timed = |n: &&u64| self.timed_with(**n).next().is_some();
        for &spheres in self.settings.clouds.iter().filter(is_timed) {
            let (scene, pixels) = self.cloud(spheres, 1, CLOUD_SIZE)?;
            let index = sample(pixels.len(), self.n_cloud_samples(), self.settings.seed);
            let truth = Truth::of_pixels(&scene, &pixels, index, self.control)?;
            let n_rounds = self.settings.rounds;
            let subject =
                Subject { scene, rays: Rays::Pixels(pixels), truth: Some(truth), n_rounds };
            let found = self.rows(&Of::Cloud { spheres }, self.timed_with(spheres), &subject)?;
            rows.extend(found.0);
            missing.extend(found.1);
        }
        Ok((rows, missing))
    }

    /// A sphere of radius 1 around a random point `distance` away from the eye at the origin. Every
    /// second ray passes its centre at `1 ± 2⁻ᵏ` radii with `k` up to 24, the others anywhere up to
    /// 1.5 radii.
    fn at_distance(&self, distance: f64) -> Result<Subject> {
        let mut random = SplitMix::new(self.settings.seed ^ distance.to_bits());
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
        let rays = Rays::List((0..DISTANCE_RAYS).map(ray).collect());
        let scene = scene_of(None, vec![sphere(center, 1.0)], Vec::new());
        let index = (0..rays.len()).collect();
        let truth = Truth::of_rays(&scene, &rays, index, self.control)?;
        Ok(Subject { scene, rays, truth: Some(truth), n_rounds: 0 })
    }

    /// Three spheres on a floor, moved away from the origin together with their camera.
    fn at_offset(&self, distance: f64) -> Result<Subject> {
        let offset = distance * DVec3::new(0.6, 0.48, -0.64);
        let camera = Camera {
            position: offset + DVec3::new(0.3, 1.6, 7.0),
            look_at: offset + DVec3::new(0.0, 0.8, 0.0),
            up: DVec3::Y,
            projection: Projection::Perspective { fov_degrees: 40.0 },
        };
        let spheres = [(-1.7, 1.0, 0.2), (0.4, 0.8, -0.9), (1.6, 0.6, 0.8)]
            .map(|(x, radius, z)| sphere(offset + DVec3::new(x, radius, z), radius));
        let floor = Plane { name: None, point: offset, normal: DVec3::Y, color: Color([0.5; 3]) };
        let [width, height] = OFFSET_SIZE;
        let pixels = Pixels::whole(View::new(&camera), width, height);
        let scene = scene_of(Some(camera), spheres.to_vec(), vec![floor]);
        let truth = Truth::of_pixels(&scene, &pixels, (0..pixels.len()).collect(), self.control)?;
        Ok(Subject { scene, rays: Rays::Pixels(pixels), truth: Some(truth), n_rounds: 0 })
    }
}
