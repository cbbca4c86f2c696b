//! Lit pictures where it is hard: the objects and cameras of `setups.rs`, with lights aimed at what
//! they see. A test that takes this module takes `cases.rs`, `oracle.rs`, `setups.rs`, `light_judge.rs`
//! and what these take.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz::exact::Shape;
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Color, Light, Object, Scene, Sky, Source, linear_from_srgb};
use kugelblitz::shade::Background;
use kugelblitz::trace::Rays;
use num_traits::ToPrimitive as _;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cases::{any_vector, nudged};
use crate::light_judge::LightCase;
use crate::rational::{self, OracleRay};
use crate::setups::{self, Batch, FAMILIES, SOURCES, Source as Origin};

/// The case of this number, the same for the same seed, and its family.
pub fn light_case(seed: u64, index: u64) -> (&'static str, LightCase) {
    let n_families = FAMILIES.len() as u64;
    let (family, round) = (index % n_families, index / n_families);
    // The batches whose rays are a camera's.
    let source = SOURCES.iter().position(|source| *source == Origin::Pixels).unwrap() as u64;
    let source = source + round % 2;
    let batch_index = family + n_families * (source + SOURCES.len() as u64 * (round / 2));
    let Batch { scene, rays, .. } = setups::batch(seed, batch_index);
    let Rays::Pixels(mut pixels) = rays else { unreachable!("a picture") };
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x6c69_6768_7400_0000);
    rng.set_stream(index);
    pixels.width = pixels.width.min(17);
    pixels.height = pixels.height.min(17);
    let n_samples = match rng.random_range(0..8) {
        0 => 3,
        1 | 2 => 2,
        _ => 1,
    };
    let mut case = LightCase::new(Scene::default(), pixels, n_samples);
    case.background = match rng.random_range(0..8) {
        0 => Background::LeftOut,
        1 => Background::Black,
        _ => Background::Shown,
    };
    light_up(&mut rng, scene, &mut case);
    if rng.random_bool(0.25) {
        onto_edge(&mut rng, &mut case);
    }
    (FAMILIES[family as usize].0, case)
}

fn sign(rng: &mut impl Rng) -> f64 {
    if rng.random() { 1.0 } else { -1.0 }
}

fn power_of_ten(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    10f64.powf(rng.random_range(low..high))
}

/// `2^-50 … 2^-4` of either sign, or 0.
fn tiny(rng: &mut impl Rng) -> f64 {
    if rng.random_bool(0.2) { 0.0 } else { 2f64.powi(rng.random_range(-54..-3)) * sign(rng) }
}

fn unit(rng: &mut impl Rng) -> DVec3 {
    any_vector(rng, 1.0).normalize_or(DVec3::X)
}

fn across(rng: &mut impl Rng, v: DVec3) -> DVec3 {
    let v = v.normalize_or(DVec3::X);
    v.cross(unit(rng)).normalize_or(v.any_orthonormal_vector())
}

fn color(rng: &mut impl Rng) -> Color {
    match rng.random_range(0..4) {
        0 => Color([1.0; 3]),
        1 => Color::from_srgb8(std::array::from_fn(|_| rng.random())),
        _ => Color(std::array::from_fn(|_| rng.random_range(0.0..1.0))),
    }
}

/// A point that a sample sees, to f64, with the direction of the ray and the object.
struct Seen {
    point: DVec3,
    direction: DVec3,
    id: u32,
}

fn seen(scene: &Scene, pixels: &Pixels, index: usize) -> Option<Seen> {
    let (x, y) = pixels.xy(index);
    let ray = OracleRay::from_pixel(pixels, x, y);
    let shapes =
        (1..=scene.n_objects() as u32).map(|id| (id, Shape::from(scene.object(id).unwrap())));
    let (id, root) = rational::nearest(&ray, &shapes.collect::<Vec<_>>())?;
    let f64s = |v: [rational::Q; 3]| DVec3::from_array(v.map(|x| x.to_f64().unwrap()));
    Some(Seen { point: f64s(ray.at(&root.below(70))), direction: f64s(ray.direction), id })
}

/// Gives the case the scene with lights, and its objects colours.
fn light_up(rng: &mut impl Rng, mut scene: Scene, case: &mut LightCase) {
    let spheres: Vec<_> = scene.spheres.iter().map(|sphere| (*sphere, color(rng))).collect();
    scene.spheres = spheres.into_iter().collect();
    scene.planes.iter_mut().for_each(|plane| plane.color = color(rng));
    scene.background = color(rng);
    let (pixels, n) = (&case.pixels, case.n_samples);
    let samples = pixels.samples(n);
    let targets: Vec<Seen> = (0..8)
        .filter_map(|_| {
            let index = rng.random_range(0..samples.len());
            let (x, y) = samples.xy(index);
            case.aims.push(((y / n - pixels.y) * pixels.width + x / n - pixels.x) as usize);
            seen(&scene, &samples, index)
        })
        .collect();
    let n_lights = rng.random_range(1..4);
    scene.lights = (0..n_lights)
        .map(|_| {
            let target = match targets.len() {
                0 => None,
                n => Some(&targets[rng.random_range(0..n)]),
            };
            let intensity = match rng.random_range(0..20) {
                0 => 0.0,
                1 => power_of_ten(rng, -30.0, 30.0),
                2..8 => 1.0,
                _ => power_of_ten(rng, -2.0, 1.0),
            };
            let source = match source(rng, &scene, &samples, target) {
                Source::Point(at) if !at.is_finite() => Source::Eye,
                Source::Sun(direction) if !direction.is_finite() || direction == DVec3::ZERO => {
                    Source::Eye
                }
                source => source,
            };
            Light { source, color: color(rng), intensity, shadows: rng.random_bool(0.9) }
        })
        .collect();
    if rng.random_bool(0.3) {
        scene.ambient = Some(Color(color(rng).0.map(|x| x * 0.25)));
    }
    if rng.random_bool(0.1) {
        let (intensity, directions) = (rng.random_range(0.1..1.0), rng.random_range(1..12));
        scene.sky = Some(Sky { intensity, directions });
    }
    case.scene = Arc::new(scene);
}

/// Where the points of the scene are, and how large it is.
fn place(scene: &Scene, pixels: &Pixels) -> (DVec3, f64) {
    match scene.object(1) {
        Some(Object::Sphere(sphere)) => (sphere.center, sphere.radius),
        Some(Object::Plane(plane)) => (plane.point, plane.point.distance(pixels.view.position)),
        None => (pixels.view.position, 1.0),
    }
}

/// A light where the question is hard for the target.
fn source(rng: &mut impl Rng, scene: &Scene, pixels: &Pixels, target: Option<&Seen>) -> Source {
    let (middle, size) = place(scene, pixels);
    let Some(Seen { point: p, direction, id }) = target else {
        return Source::Point(middle + unit(rng) * (size * power_of_ten(rng, -1.0, 3.0)));
    };
    let (p, object) = (*p, scene.object(*id).unwrap());
    let depth = p.distance(pixels.view.position);
    let normal = match object {
        Object::Sphere(sphere) => (p - sphere.center).normalize_or(DVec3::X),
        Object::Plane(plane) => plane.normal.normalize_or(DVec3::X),
    };
    let facing = if normal.dot(*direction) > 0.0 { -normal } else { normal };
    let sphere = match scene.spheres.len() {
        0 => None,
        n => Some(scene.spheres[rng.random_range(0..n)]),
    };
    let either = |rng: &mut dyn FnMut() -> bool, at: DVec3| {
        if rng() { Source::Point(at) } else { Source::Sun(p - at) }
    };
    let mut coin = {
        let bits: u64 = rng.random();
        move || bits.is_multiple_of(2)
    };
    match (rng.random_range(0..12), sphere) {
        // Past the silhouette of a sphere, as the target sees it.
        (0..4, Some(sphere)) => {
            let (c, r) = (sphere.center, sphere.radius);
            let toward = c - p;
            let distance = toward.length();
            let sine = ((1.0 + tiny(rng)) * r / distance).min(1.0);
            let aside = across(rng, toward);
            let along = toward / distance * (1.0 - sine * sine).max(0.0).sqrt() + aside * sine;
            let tangent = (distance * distance - r * r).max(0.0).sqrt();
            let length = match rng.random_range(0..3) {
                0 => tangent * (1.0 + tiny(rng)),
                1 => distance * rng.random_range(0.1..3.0),
                _ => distance * power_of_ten(rng, 0.0, 6.0),
            };
            either(&mut coin, p + along * length.max(size * 1e-6))
        }
        // The terminator of the target.
        (4, _) => {
            let along = across(rng, normal) + facing * tiny(rng);
            either(&mut coin, p + along * (size * power_of_ten(rng, -2.0, 3.0)))
        }
        // On a sphere, and just beside its surface.
        (5, Some(sphere)) => {
            let outward = match rng.random_range(0..3) {
                0 => [DVec3::X, DVec3::Y, DVec3::Z][rng.random_range(0..3)] * sign(rng),
                _ => unit(rng),
            };
            Source::Point(sphere.center + outward * (sphere.radius * (1.0 + tiny(rng))))
        }
        // In a sphere, often that of the target.
        (6, Some(sphere)) => {
            let sphere = match object {
                Object::Sphere(own) if rng.random() => *own,
                _ => sphere,
            };
            let from_center = unit(rng) * (sphere.radius * rng.random_range(0.0..1.0));
            Source::Point(sphere.center + from_center * f64::from(rng.random_bool(0.8)))
        }
        // Near the target, or on it.
        (7, _) => {
            let far = power_of_ten(rng, -12.0, 0.0);
            Source::Point(match rng.random_range(0..4) {
                0 => dvec3(nudged(rng, p.x), nudged(rng, p.y), nudged(rng, p.z)),
                1 => p + facing * (size * far),
                2 => p - facing * (size * far),
                _ => p + (facing + unit(rng)) * (size * far),
            })
        }
        (8, _) => Source::Eye,
        // In a plane, or across its normal.
        (9, _) if !scene.planes.is_empty() => {
            let plane = &scene.planes[rng.random_range(0..scene.planes.len())];
            let n = plane.normal;
            // Exactly across a normal whose numbers are short.
            let across = dvec3(n.y, -n.x, 0.0);
            match rng.random_range(0..3) {
                0 => Source::Point(plane.point),
                1 if across != DVec3::ZERO => Source::Sun(across),
                _ => Source::Point(plane.point + across * (depth / n.length())),
            }
        }
        // Along an axis.
        (10, _) => {
            let axis = [DVec3::X, DVec3::Y, DVec3::Z][rng.random_range(0..3)] * sign(rng);
            Source::Sun(axis * power_of_ten(rng, -20.0, 20.0))
        }
        _ => {
            let at = p + (facing + unit(rng) * 0.9) * (size * power_of_ten(rng, -1.0, 6.0));
            either(&mut coin, at)
        }
    }
}

/// All light times a factor that brings a number of one pixel to an edge of its range, within
/// rounding.
fn onto_edge(rng: &mut impl Rng, case: &mut LightCase) {
    let index = rng.random_range(0..case.pixels.len());
    let (x, y) = case.pixels.xy(index);
    let truth = case.oracle().pixel(x, y);
    let mean = truth.channels[rng.random_range(0..3)].mean[0];
    let edge = match rng.random_range(0..4) {
        0 | 1 => linear_from_srgb((f64::from(rng.random_range(1..256)) - 0.5) / 255.0),
        2 => linear_from_srgb((f64::from(rng.random_range(1..65536)) - 0.5) / 65535.0),
        _ => {
            let float: f32 = rng.random_range(1e-6..1.0);
            (f64::from(float) + f64::from(float.next_up())) / 2.0
        }
    };
    let factor = edge / mean;
    // A sample beside the objects has the background's light, which stays.
    if truth.n_hits < case.n_samples.pow(2) || !(1e-30..1e30).contains(&factor) {
        return;
    }
    let mut scene = (*case.scene).clone();
    scene.lights.iter_mut().for_each(|light| light.intensity *= factor);
    scene.sky.iter_mut().for_each(|sky| sky.intensity *= factor);
    scene.ambient = scene.ambient.map(|Color(light)| Color(light.map(|x| x * factor)));
    case.scene = Arc::new(scene);
    case.aims.push(index);
}
