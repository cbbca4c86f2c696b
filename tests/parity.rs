//! The device's result is that of the kernels' Rust twins, bit by bit.

mod common;

use std::sync::Arc;

use common::{camera, gpu, in_cube, log_uniform, plane, scene, sphere};
use glam::DVec3;
use kugelblitz::camera::{Pixels, View};
use kugelblitz::compare::compare;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::gpu::GpuTracer;
use kugelblitz::prepare::Prepared;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Control, Hits, Kernel, Ray, Rays, Tracer, Wants};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const KERNELS: [Kernel; 3] = [Kernel::Lecture, Kernel::Stable, Kernel::Certified];

fn both(scene: &Arc<Scene>, kernel: Kernel, rays: &Rays, surface: bool) -> (Hits, Hits) {
    let wants = Wants { surface, level: false };
    let prepared = Arc::new(Prepared::new(Arc::clone(scene), kernel, rays).unwrap());
    let mut on_cpu = Hits::default();
    let mut on_gpu = Hits::default();
    CpuTracer::new(Arc::clone(&prepared), wants)
        .trace(rays, &Control::default(), &mut on_cpu)
        .unwrap();
    GpuTracer::new(gpu(), prepared, wants)
        .unwrap()
        .trace(rays, &Control::default(), &mut on_gpu)
        .unwrap();
    (on_cpu, on_gpu)
}

fn assert_parity(scene: &Arc<Scene>, kernel: Kernel, rays: &Rays, surface: bool, what: &str) {
    let (on_cpu, on_gpu) = both(scene, kernel, rays, surface);
    let comparison = compare(&on_cpu, &on_gpu);
    if let Some(first) = comparison.first {
        panic!(
            "{what}, {}: {comparison:?}\ncpu: {} {:?} {:?}\ngpu: {} {:?} {:?}",
            kernel.name(),
            on_cpu.id[first],
            on_cpu.t.get(first),
            on_cpu.normal.get(first),
            on_gpu.id[first],
            on_gpu.t.get(first),
            on_gpu.normal.get(first),
        );
    }
    assert!(on_cpu.n_hits() > 0, "{what}: no ray hits anything");
}

/// Spheres and planes over several decades of size and distance.
fn random_scene(rng: &mut ChaCha8Rng, n_spheres: usize, n_planes: usize) -> Arc<Scene> {
    let spheres = (0..n_spheres)
        .map(|_| {
            let distance = log_uniform(rng, 1.0, 1e4).abs();
            sphere(in_cube(rng) * distance, distance * rng.random_range(0.001..0.7))
        })
        .collect();
    let planes = (0..n_planes)
        .map(|_| {
            let length = log_uniform(rng, 1e-3, 1e3);
            plane(in_cube(rng) * 100.0, in_cube(rng) * length)
        })
        .collect();
    Arc::new(scene(spheres, planes))
}

#[test]
fn pictures_of_random_scenes() {
    for seed in 0..8 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let n_planes = seed as usize % 3;
        let scene = random_scene(&mut rng, 20 - 9 * n_planes, n_planes);
        let camera = camera(in_cube(&mut rng), in_cube(&mut rng) * 3.0);
        let mut pixels = Pixels::whole(View::new(&camera), 301, 203);
        pixels.x = 7;
        pixels.y = 3;
        pixels.width = 260;
        pixels.height = 190;
        for kernel in KERNELS {
            for surface in [false, true] {
                let what = format!("seed {seed}");
                assert_parity(&scene, kernel, &Rays::Pixels(pixels), surface, &what);
            }
        }
    }
}

#[test]
fn a_million_random_rays() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for (n_spheres, n_planes) in [(12, 2), (10, 0), (0, 3)] {
        let scene = random_scene(&mut rng, n_spheres, n_planes);
        let rays = (0..350_000)
            .map(|_| Ray {
                origin: in_cube(&mut rng) * 10.0,
                direction: in_cube(&mut rng) * log_uniform(&mut rng, 1e-6, 1e6),
            })
            .collect();
        let rays = Rays::List(rays);
        for kernel in KERNELS {
            let what = format!("{n_spheres} spheres, {n_planes} planes");
            assert_parity(&scene, kernel, &rays, true, &what);
        }
    }
}

#[test]
fn an_empty_scene_is_background() {
    let scene = Arc::new(scene(vec![], vec![]));
    let pixels = Pixels::whole(View::new(&camera(DVec3::ZERO, DVec3::NEG_Z)), 40, 30);
    for kernel in KERNELS {
        let (on_cpu, on_gpu) = both(&scene, kernel, &Rays::Pixels(pixels), true);
        assert!(compare(&on_cpu, &on_gpu).is_equal());
        assert_eq!(on_gpu.n_hits(), 0);
        assert!(on_gpu.t.iter().all(|&t| t == f32::INFINITY));
    }
}

/// The CPU takes eight pixels of a row at a time and the rest one by one; rectangles of one column
/// have no eight.
#[test]
fn packets_give_what_single_rays_give() {
    for seed in 20..26 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let spheres = (0..30)
            .map(|_| {
                let distance = log_uniform(&mut rng, 5.0, 1e3).abs();
                sphere(in_cube(&mut rng).normalize() * distance, distance * 0.2)
            })
            .collect();
        let floor = plane(DVec3::new(0.0, -2.0, 0.0), DVec3::new(0.1, 1.0, 0.0));
        let scene = Arc::new(scene(spheres, vec![floor]));
        let camera = camera(DVec3::ZERO, in_cube(&mut rng));
        let whole = Pixels::whole(View::new(&camera), 67, 50);
        let on_cpu = |pixels: Pixels| {
            let rays = Rays::Pixels(pixels);
            let prepared =
                Arc::new(Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap());
            assert!(!prepared.near, "no packets here");
            let mut hits = Hits::default();
            let wants = Wants { surface: false, level: true };
            CpuTracer::new(prepared, wants).trace(&rays, &Control::default(), &mut hits).unwrap();
            hits
        };
        let packets = on_cpu(whole);
        assert!(packets.n_hits() > 0);
        for x in 0..67 {
            let single = on_cpu(Pixels { x, width: 1, ..whole });
            for y in 0..50 {
                let index = y * 67 + x as usize;
                assert_eq!(single.id[y], packets.id[index], "seed {seed}, pixel {x}, {y}");
                assert_eq!(single.level[y], packets.level[index], "seed {seed}, pixel {x}, {y}");
            }
        }
    }
}

#[test]
fn rays_that_the_scene_was_not_prepared_for_are_refused() {
    let scene = Arc::new(scene(vec![sphere(DVec3::NEG_Z * 5.0, 1.0)], vec![]));
    let view = |x: f64| View::new(&camera(DVec3::X * x, DVec3::NEG_Z));
    let list = |x: f64| {
        let ray = |x: f64| Ray { origin: DVec3::X * x, direction: DVec3::NEG_Z };
        Rays::List(vec![ray(x), ray(-x)])
    };
    let picture = |x: f64, width: u32| Rays::Pixels(Pixels::whole(view(x), width, 20));
    for (made_for, part, others) in [
        (picture(0.0, 30), picture(0.0, 30), [picture(0.1, 30), picture(0.0, 31), list(0.0)]),
        (list(2.0), list(1.0), [list(3.0), picture(0.0, 30), picture(0.1, 31)]),
    ] {
        let prepared =
            Arc::new(Prepared::new(Arc::clone(&scene), Kernel::Certified, &made_for).unwrap());
        let wants = Wants::default();
        let mut tracers: [Box<dyn Tracer>; 2] = [
            Box::new(CpuTracer::new(Arc::clone(&prepared), wants)),
            Box::new(GpuTracer::new(gpu(), prepared, wants).unwrap()),
        ];
        for tracer in &mut tracers {
            let mut trace = |rays| tracer.trace(rays, &Control::default(), &mut Hits::default());
            assert!(trace(&part).is_ok());
            for other in &others {
                assert!(trace(other).is_err(), "{other:?} for {made_for:?}");
            }
        }
    }
}
