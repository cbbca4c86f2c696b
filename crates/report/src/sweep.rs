//! Error and time against one quantity, in scenes made for it.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::control::Control;
use kugelblitz::random::SplitMix;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays};
use kugelblitz::{Error, Result};
use kugelblitz_judge::verify::Truth;

use super::clouds::cloud;
use super::measure::{IDS, SURFACE, Work, n_pixels, run};
use super::samples::Samples;
use super::{Benchmark, Metric, Of, Row, Settings};

/// Error or time against one quantity.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    /// `distance`, `offset` or `objects`.
    pub name: &'static str,
    /// Its subject, in a sentence.
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

impl Settings {
    /// Numbers of spheres that are timed with a kernel.
    fn numbers_of_spheres(&self, kernel: Kernel) -> impl Iterator<Item = u64> {
        let clouds = self.clouds.iter().filter(move |_| kernel == Kernel::Certified);
        OBJECTS.into_iter().chain(clouds.copied())
    }
}

impl Work<'_> {
    fn n_timed(&self) -> usize {
        self.settings.rounds * self.settings.runs
    }

    /// Rays that [`Work::sweep_rows`] traces or compares.
    pub fn n_sweep_rays(&self) -> u64 {
        let of_distance = distances().len() * DISTANCE_RAYS;
        let errors = of_distance as u64 + offsets().len() as u64 * n_pixels(OFFSET_SIZE);
        let n_points = |kernel| self.settings.numbers_of_spheres(kernel).count() as u64;
        let n_points: u64 =
            self.benchmarks.iter().map(|benchmark| n_points(benchmark.kernel)).sum();
        let times = n_points * n_pixels(OBJECTS_SIZE) * (1 + self.n_timed() as u64);
        let all = errors * (1 + self.benchmarks.len() as u64) + times;
        if self.settings.sweeps { all } else { 0 }
    }

    /// All sweeps: each point with each benchmark.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`].
    pub fn sweep_rows(&self, control: &Control) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        if !self.settings.sweeps {
            return Ok(rows);
        }
        for x in distances() {
            let setting = at_distance(x, self.settings.seed, control)?;
            rows.extend(self.error_rows("distance", x, setting, control)?);
        }
        for x in offsets() {
            rows.extend(self.error_rows("offset", x, at_offset(x, control)?, control)?);
        }
        for n in self.settings.numbers_of_spheres(Kernel::Certified) {
            rows.extend(self.time_rows(n, control)?);
        }
        Ok(rows)
    }

    fn error_rows(
        &self,
        sweep: &str,
        x: f64,
        (scene, rays, truth): Setting,
        control: &Control,
    ) -> Result<Vec<Row>> {
        let mut hits = Hits::default();
        let of_benchmark = |benchmark| {
            let mut tracer = Benchmark::tracer(benchmark, &scene, &rays, SURFACE)?.tracer;
            tracer.trace(&rays, control, &mut hits)?;
            let mut errors = Samples::default();
            errors.add_errors(&hits, &truth);
            Ok(Row::new(Of::Sweep { sweep: sweep.into(), x }, benchmark, &[&errors]))
        };
        self.benchmarks.iter().map(of_benchmark).collect()
    }

    fn time_rows(&self, n: u64, control: &Control) -> Result<Vec<Row>> {
        let (scene, pixels) = cloud(n, self.settings.seed, OBJECTS_SIZE, control)?;
        let rays = Rays::Pixels(pixels);
        let (mut rows, mut hits) = (Vec::new(), Hits::default());
        for benchmark in self.benchmarks {
            if !self.settings.numbers_of_spheres(benchmark.kernel).any(|own| own == n) {
                continue;
            }
            let made = match benchmark.tracer(&scene, &rays, IDS) {
                Ok(made) => made,
                // Clouds in pictures tell why.
                Err(Error::TooLarge(_)) => continue,
                Err(error) => return Err(error),
            };
            let runs = run(made, &rays, self.n_timed(), control, &mut hits)?;
            let mut times = Samples::default();
            times.add(Metric::TraceNsPerRay, runs.ns_per_ray());
            let of = Of::Sweep { sweep: "objects".into(), x: n as f64 };
            rows.push(Row::new(of, benchmark, &[&times]));
        }
        Ok(rows)
    }
}

/// A scene, rays into it, and what they see.
type Setting = (Arc<Scene>, Rays, Truth);

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

/// A sphere of radius 1 around a random point `distance` away from the eye at the origin. Every
/// second ray passes its centre at `1 ± 2⁻ᵏ` radii with `k` up to 24, the others anywhere up to
/// 1.5 radii.
fn at_distance(distance: f64, seed: u64, control: &Control) -> Result<Setting> {
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
        Ray { origin: DVec3::ZERO, direction: axis + tangent * (cosine * u + sine * v) }
    };
    let rays: Vec<Ray> = (0..DISTANCE_RAYS).map(ray).collect();
    let scene = scene_of(None, vec![sphere(center, 1.0)], Vec::new());
    let truth = Truth::of_list(&scene, &rays, control)?;
    Ok((scene, Rays::List(rays), truth))
}

/// Three spheres on a floor, moved away from the origin together with their camera.
fn at_offset(distance: f64, control: &Control) -> Result<Setting> {
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
    let truth = Truth::of_pixels(&scene, &pixels, (0..pixels.len()).collect(), control)?;
    Ok((scene, Rays::Pixels(pixels), truth))
}
