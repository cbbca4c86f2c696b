//! The certified kernel's promise: the id is the exact one, `t` is the exact one's nearest f32,
//! each component of the normal that of the exact one, on the device and on the CPU.

use std::sync::Arc;

use kugelblitz::exact::{ExactRay, Shape, nearest};
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, StageCounts};
use kugelblitz_tests::hard_cases::hard_cases;
use kugelblitz_tests::hard_scene::hard_scene;
use kugelblitz_tests::{gpu, in_cube, judge, log_uniform, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn trace(scene: &Arc<Scene>, kernel: Kernel, rays: &Rays, on_gpu: bool) -> Hits {
    judge::trace(scene, kernel, rays, on_gpu.then(gpu).as_ref())
}

fn objects(scene: &Scene) -> Vec<(u32, Shape)> {
    (1..=scene.n_objects() as u32).map(|id| (id, Shape::from(scene.object(id).unwrap()))).collect()
}

/// Fails with a case to paste when a ray's result is not the exact one.
fn assert_exact(scene: &Scene, rays: &[Ray], hits: &Hits, what: &str) {
    let objects = objects(scene);
    for (i, ray) in rays.iter().enumerate() {
        let exact_ray = ExactRay::new(ray);
        let exact = nearest(&exact_ray, objects.iter().copied());
        let id = exact.as_ref().map_or(0, |hit| hit.id);
        let t = exact.as_ref().map_or(f32::INFINITY, |hit| hit.t_f32());
        let paste = || format!("{what}, ray {i}: {ray:?} in {scene:?}");
        assert_eq!(hits.id[i], id, "id of {}", paste());
        assert_eq!(hits.t[i].to_bits(), t.to_bits(), "t {} not {t} of {}", hits.t[i], paste());
        if let Some(hit) = exact {
            let shape = Shape::from(scene.object(id).unwrap());
            let normal = hit.normal_f32(&exact_ray, &shape);
            let bits = |normal: [f32; 3]| normal.map(f32::to_bits);
            let found = hits.normal[i];
            assert_eq!(bits(found), bits(normal), "{found:?} not {normal:?} of {}", paste());
        }
    }
}

#[test]
fn all_hard_cases_on_both_devices() {
    for case in hard_cases() {
        let (scene, rays) = hard_scene(&case);
        for on_gpu in [false, true] {
            let hits = trace(&scene, Kernel::Certified, &rays, on_gpu);
            assert_eq!(hits.id[0] != 0, case.t.is_some(), "{}", case.name);
            let t = case.t.map_or(f32::INFINITY.to_bits(), f32::to_bits);
            assert_eq!(hits.t[0].to_bits(), t, "{}", case.name);
        }
    }
}

/// A sphere around the origin of the ray's decade and rays aimed near its silhouette.
fn near_silhouette(rng: &mut ChaCha8Rng, n_rays: usize) -> (Scene, Vec<Ray>) {
    let r = log_uniform(rng, 1e-6, 1e6).abs();
    let ratio = match rng.random_range(0..3) {
        0 => 1.0 + 10f64.powf(rng.random_range(-9.0..0.0)),
        1 => 10f64.powf(rng.random_range(0.0..3.0)),
        _ => 10f64.powf(rng.random_range(3.0..8.0)),
    };
    let eye = in_cube(rng) * log_uniform(rng, 1e-3, 1e3);
    let to_center = in_cube(rng).normalize() * (ratio * r);
    let center = eye + to_center;
    let rays = (0..n_rays)
        .map(|_| {
            let sideways = in_cube(rng).cross(to_center).normalize();
            let off = 2f64.powi(-rng.random_range(4..50)) * if rng.random() { 1.0 } else { -1.0 };
            let sine = ((1.0 + off) / ratio).min(1.0);
            let cosine = (1.0 - sine * sine).sqrt();
            let length = log_uniform(rng, 1e-8, 1e8).abs();
            let direction = (to_center.normalize() * cosine + sideways * sine) * length;
            Ray { origin: eye, direction }
        })
        .collect();
    (scene(vec![sphere(center, r)], vec![]), rays)
}

#[test]
fn rays_near_silhouettes() {
    let mut counts = StageCounts::default();
    for seed in 0..300 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (scene, rays) = near_silhouette(&mut rng, 400);
        let scene = Arc::new(scene);
        let list = Rays::List(rays.clone());
        let hits = trace(&scene, Kernel::Certified, &list, seed % 10 == 0);
        assert_exact(&scene, &rays, &hits, &format!("seed {seed}"));
        counts.add(hits.counts);
    }
    println!("{counts:?}");
    assert!(counts.f32 > 0 && counts.f64 > 0 && counts.exact > 0, "{counts:?}");
}
