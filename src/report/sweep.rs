//! Error and time against one quantity, in scenes made for it.

use std::sync::Arc;

use glam::DVec3;

use super::errors::Collector;
use super::measure::{IDS, SURFACE, Subject, run, spread};
use super::{Effort, Series, Sweep, SweepPoint};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::random::SplitMix;
use crate::rays::{Pixels, View};
use crate::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use crate::trace::{Hits, Kernel, Ray, Rays, Timing};
use crate::verify::Truth;

/// Rays of each point of the sweep over distance.
const DISTANCE_RAYS: usize = 1 << 14;

/// Pictures of the sweep over the offset, px.
const OFFSET_SIZE: [u32; 2] = [240, 135];

/// Pictures of the sweep over the number of objects, px.
const OBJECTS_SIZE: [u32; 2] = [480, 270];

/// Numbers of spheres that are timed with every kernel. [`Effort::clouds`] are timed with `certified`
/// alone: the others test every ray against each sphere.
const OBJECTS: [usize; 5] = [1, 4, 16, 64, 256];

/// Numbers of spheres that are timed with a kernel.
fn numbers_of_spheres(kernel: Kernel, effort: &Effort) -> Vec<usize> {
    let clouds = effort.clouds.iter().map(|count| *count as usize);
    let clouds = clouds.filter(|_| kernel == Kernel::Certified);
    OBJECTS.into_iter().chain(clouds).collect()
}

/// Rays that [`measure_sweeps`] traces or compares.
pub(super) fn n_rays(subjects: &[Subject], effort: &Effort) -> u64 {
    let n_pixels = |[width, height]: [u32; 2]| (width * height) as usize;
    let errors = distances().len() * DISTANCE_RAYS + offsets().len() * n_pixels(OFFSET_SIZE);
    let n_points = subjects.iter().map(|subject| numbers_of_spheres(subject.kernel, effort).len());
    let times = n_points.sum::<usize>() * n_pixels(OBJECTS_SIZE) * (1 + n_runs(effort));
    (errors + subjects.len() * errors + times) as u64
}

fn n_runs(effort: &Effort) -> usize {
    effort.rounds * effort.runs
}

/// All sweeps.
///
/// # Errors
/// Those of tracing; [`Error::Interrupted`](crate::Error::Interrupted).
pub(super) fn measure_sweeps(
    subjects: &[Subject],
    effort: &Effort,
    control: &Control,
) -> Result<Vec<Sweep>> {
    let distance = distances().into_iter().map(|x| Ok((x, at_distance(x, effort.seed, control)?)));
    let offset = offsets().into_iter().map(|x| Ok((x, at_offset(x, control)?)));
    Ok(vec![
        Sweep {
            name: "distance",
            title: "Error against distance: a sphere of radius 1, half of the rays aimed close to \
                    its silhouette",
            x_label: "distance of the sphere's centre from the eye / radius",
            series: errors_along(distance, subjects, control)?,
        },
        Sweep {
            name: "offset",
            title: "Error against the distance from the origin: three spheres on a floor, each of \
                    size 1, moved together with the camera",
            x_label: "distance of the scene from the origin / size of an object",
            series: errors_along(offset, subjects, control)?,
        },
        Sweep {
            name: "objects",
            title: "Time against the number of spheres: spread evenly in a cube, all in view; clouds with \
                    certified alone, which finds the spheres of a pixel in a hierarchy",
            x_label: "spheres",
            series: times_along(subjects, effort, control)?,
        },
    ])
}

/// A scene, rays into it, and what they see.
type Setting = (Arc<Scene>, Rays, Truth);

fn errors_along(
    settings: impl Iterator<Item = Result<(f64, Setting)>>,
    subjects: &[Subject],
    control: &Control,
) -> Result<Vec<Series>> {
    let mut all = series(subjects);
    let mut hits = Hits::default();
    for setting in settings {
        let (x, (scene, rays, truth)) = setting?;
        for (subject, series) in subjects.iter().zip(&mut all) {
            let mut tracer = subject.tracer(&scene, &rays, SURFACE)?.tracer;
            tracer.trace(&rays, control, &mut hits)?;
            let mut errors = Collector::default();
            errors.add(&hits, &truth);
            let errors = Some(errors.finish());
            series.points.push(SweepPoint { x, errors, trace_ns_per_ray: None });
        }
    }
    Ok(all)
}

fn series(subjects: &[Subject]) -> Vec<Series> {
    let empty =
        |subject: &Subject| Series { contestant: subject.contestant.clone(), points: Vec::new() };
    subjects.iter().map(empty).collect()
}

/// Two points a decade.
fn distances() -> Vec<f64> {
    (1..=12).map(|k| 10f64.powf(f64::from(k) / 2.0)).collect()
}

fn offsets() -> Vec<f64> {
    (0..=10).map(|k| 10f64.powi(k)).collect()
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

/// `n` spheres spread evenly in a cube of side 1, of radius `0.3·n^(−1/3)`, the whole cube in view.
fn many_spheres(n: usize, seed: u64) -> (Arc<Scene>, Rays) {
    let mut random = SplitMix::new(seed ^ n as u64);
    let radius = 0.3 * (n as f64).powf(-1.0 / 3.0);
    let mut center = || DVec3::new(random.unit(), random.unit(), random.unit());
    let spheres = (0..n).map(|_| sphere(center(), radius)).collect();
    let camera = Camera {
        position: DVec3::new(0.5, 0.5, 3.0),
        look_at: DVec3::splat(0.5),
        up: DVec3::Y,
        projection: Projection::Perspective { fov_degrees: 35.0 },
    };
    let [width, height] = OBJECTS_SIZE;
    let pixels = Pixels::whole(View::new(&camera), width, height);
    (scene_of(Some(camera), spheres, Vec::new()), Rays::Pixels(pixels))
}

fn times_along(subjects: &[Subject], effort: &Effort, control: &Control) -> Result<Vec<Series>> {
    let mut all = series(subjects);
    let mut hits = Hits::default();
    for n in numbers_of_spheres(Kernel::Certified, effort) {
        let (scene, rays) = many_spheres(n, effort.seed);
        for (subject, series) in subjects.iter().zip(&mut all) {
            if !numbers_of_spheres(subject.kernel, effort).contains(&n) {
                continue;
            }
            let made = match subject.tracer(&scene, &rays, IDS) {
                Ok(made) => made,
                // Clouds in pictures tell why.
                Err(Error::TooLarge(_)) => continue,
                Err(error) => return Err(error),
            };
            let runs = run(made, &rays, n_runs(effort), control, &mut hits)?;
            let times = runs.timed.iter().map(Timing::deciding);
            let trace_ns_per_ray = spread(times, 1e9 / rays.len() as f64);
            series.points.push(SweepPoint { x: n as f64, errors: None, trace_ns_per_ray });
        }
    }
    Ok(all)
}
