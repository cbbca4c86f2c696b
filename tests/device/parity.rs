//! The device's result is that of the kernels' Rust twins, bit by bit where its arithmetic is the CPU's.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::compare::compare;
use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::gpu::{Gpu, GpuTracer, Pick};
use kugelblitz::prepare::{FEW_SPHERES, Prepared};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Level, Ray, Rays, StageCounts, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::{broken, camera, gpu, in_cube, log_uniform, plane, runs, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn both(scene: &Arc<Scene>, kernel: Kernel, rays: &Rays, surface: bool) -> (Hits, Hits) {
    both_of(&Arc::new(Prepared::new(Arc::clone(scene), kernel, rays).unwrap()), rays, surface)
}

fn both_of(prepared: &Arc<Prepared>, rays: &Rays, surface: bool) -> (Hits, Hits) {
    let wants = Wants { surface, level: false };
    let mut on_cpu = Hits::default();
    let mut on_gpu = Hits::default();
    CpuTracer::new(Arc::clone(prepared), wants)
        .trace(rays, &Control::default(), &mut on_cpu)
        .unwrap();
    GpuTracer::new(gpu(), Arc::clone(prepared), wants)
        .unwrap()
        .trace(rays, &Control::default(), &mut on_gpu)
        .unwrap();
    // `compare` takes what both have.
    for hits in [&on_cpu, &on_gpu] {
        let n_surface = if surface { rays.len() } else { 0 };
        assert_eq!(
            [hits.id.len(), hits.t.len(), hits.normal.len()],
            [rays.len(), n_surface, n_surface]
        );
    }
    (on_cpu, on_gpu)
}

fn assert_parity(scene: &Arc<Scene>, kernel: Kernel, rays: &Rays, surface: bool, what: &str) {
    let prepared = Arc::new(Prepared::new(Arc::clone(scene), kernel, rays).unwrap());
    let (on_cpu, on_gpu) = both_of(&prepared, rays, surface);
    if let Some(broken) = broken(&prepared, rays, &on_cpu, &on_gpu) {
        panic!("{what}, {broken}");
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
        for kernel in Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)) {
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
        for kernel in Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)) {
            let what = format!("{n_spheres} spheres, {n_planes} planes");
            assert_parity(&scene, kernel, &rays, true, &what);
        }
    }
}

/// `double` takes directions as they are, of lengths that f32 does not even hold, and narrows what
/// comes out: `t` beyond f32 is a miss.
#[test]
fn f64_rays_over_all_of_f32_and_beyond() {
    if !runs(Kernel::Double) {
        return;
    }
    for seed in 30..34 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let scene = random_scene(&mut rng, 9, 2);
        let rays = (0..50_000)
            .map(|_| Ray {
                origin: in_cube(&mut rng) * log_uniform(&mut rng, 1e-3, 1e6),
                direction: in_cube(&mut rng) * log_uniform(&mut rng, 1e-60, 1e60),
            })
            .collect();
        let rays = Rays::List(rays);
        assert_parity(&scene, Kernel::Double, &rays, true, &format!("seed {seed}"));
        let (hits, _) = both(&scene, Kernel::Double, &rays, true);
        for (&id, t) in hits.id.iter().zip(hits.t) {
            assert_eq!(id == 0, t == f32::INFINITY, "id {id}, t {t:e}");
        }
        let (ids_alone, _) = both(&scene, Kernel::Double, &rays, false);
        assert_eq!(ids_alone.id, hits.id);
    }
}

/// f32 hides the last bits of f64, so here they decide: rays along a plane, where `d·n` is nothing
/// but rounding, and rays that graze a sphere or start on an object.
#[test]
fn the_last_bits_of_f64_are_the_same() {
    if !runs(Kernel::Double) {
        return;
    }
    for seed in 40..50 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let view = View::new(&camera(in_cube(&mut rng), in_cube(&mut rng) * 3.0));
        let whole = Pixels::whole(view, 301, 203);
        let y = rng.random_range(0..203);
        let normal = whole.direction(0, y).cross(whole.direction(300, y));
        let along = plane(view.position + normal * 1e-15, normal);
        let row = Rays::Pixels(Pixels { y, height: 1, ..whole });
        let along = Arc::new(scene(vec![], vec![along]));
        assert_parity(&along, Kernel::Double, &row, true, &format!("seed {seed}, row {y}"));

        let (center, point) = (in_cube(&mut rng) * 10.0, in_cube(&mut rng) * 10.0);
        let radius = rng.random_range(0.1..3.0);
        let ball = Arc::new(scene(vec![sphere(center, radius)], vec![]));
        let wall = Arc::new(scene(vec![], vec![plane(point, normal)]));
        let (mut grazing, mut from_ball, mut from_wall) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..5000 {
            let (out, any) = (in_cube(&mut rng).normalize(), in_cube(&mut rng));
            let (on_ball, on_wall) = (center + out * radius, point + out.cross(normal));
            let across = out.cross(any);
            grazing.push(Ray { origin: on_ball - across * 5.0, direction: across });
            from_ball.push(Ray { origin: on_ball, direction: any });
            from_wall.push(Ray { origin: on_wall, direction: any });
        }
        for (scene, rays, what) in [
            (&ball, grazing, "grazing a sphere"),
            (&ball, from_ball, "from a sphere"),
            (&wall, from_wall, "from a plane"),
        ] {
            let rays = Rays::List(rays);
            assert_parity(scene, Kernel::Double, &rays, true, &format!("seed {seed}, {what}"));
            let n_hits = both(scene, Kernel::Double, &rays, false).0.n_hits();
            assert!((500..4500).contains(&n_hits), "{what}: {n_hits} of 5000 rays hit");
        }
    }
}

/// Ids, `t` and normals are the same bits on both devices, for a picture and for any part of it.
/// Levels need not be.
#[test]
fn nothing_but_levels_may_differ_between_devices_and_crops() {
    let mut rng = ChaCha8Rng::seed_from_u64(70);
    for n_spheres in [3, 12, 3000] {
        let scene = random_scene(&mut rng, n_spheres, 2);
        let camera = camera(in_cube(&mut rng), in_cube(&mut rng) * 3.0);
        let whole = Pixels::whole(View::new(&camera), 157, 113);
        let part = Pixels { x: 29, y: 11, width: 101, height: 77, ..whole };
        let (rays, part_rays) = (Rays::Pixels(whole), Rays::Pixels(part));
        let (on_cpu, on_gpu) = both(&scene, Kernel::Certified, &rays, true);
        assert!(compare(&on_cpu, &on_gpu).is_equal(), "{n_spheres} spheres");
        assert!(on_cpu.n_hits() > 1000);
        let (part_on_cpu, part_on_gpu) = both(&scene, Kernel::Certified, &part_rays, true);
        for hits in [part_on_cpu, part_on_gpu] {
            assert_eq!(hits.id.len(), part.len());
            for i in 0..part.len() {
                let (x, y) = part.xy(i);
                let of_whole = (y * whole.width + x) as usize;
                let what = || format!("{n_spheres} spheres, pixel {x}, {y}");
                assert_eq!(hits.id[i], on_cpu.id[of_whole], "{}", what());
                assert_eq!(hits.t[i].to_bits(), on_cpu.t[of_whole].to_bits(), "{}", what());
                let [part, whole] = [hits.normal[i], on_cpu.normal[of_whole]];
                assert_eq!(part.map(f32::to_bits), whole.map(f32::to_bits), "{}", what());
            }
        }
    }
}

#[test]
fn every_ray_is_counted_at_the_level_of_its_kernel() {
    let scene = Arc::new(scene(vec![sphere(DVec3::NEG_Z * 5.0, 1.0)], vec![]));
    let rays = Rays::Pixels(Pixels::whole(View::new(&camera(DVec3::ZERO, DVec3::NEG_Z)), 40, 30));
    let wants = Wants { surface: false, level: true };
    for kernel in Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)) {
        let prepared = Arc::new(Prepared::new(Arc::clone(&scene), kernel, &rays).unwrap());
        let mut tracers: [Box<dyn Tracer>; 2] = [
            Box::new(CpuTracer::new(Arc::clone(&prepared), wants)),
            Box::new(GpuTracer::new(gpu(), prepared, wants).unwrap()),
        ];
        for tracer in &mut tracers {
            let mut hits = Hits::default();
            tracer.trace(&rays, &Control::default(), &mut hits).unwrap();
            let of_level = |level: Level| {
                hits.level.iter().filter(|&&other| other == level as u8).count() as u64
            };
            let counts = StageCounts {
                f32: of_level(Level::F32),
                f64: of_level(Level::F64),
                exact: of_level(Level::Exact),
            };
            assert_eq!(hits.counts, counts, "{}", kernel.name());
            assert_eq!(counts.total(), 1200);
            if kernel != Kernel::Certified {
                let of_f64 = if kernel == Kernel::Double { 1200 } else { 0 };
                assert_eq!(counts.f64, of_f64, "{}", kernel.name());
            }
        }
    }
}

/// Not each adapter has f64, and those that have it can be told that they don't.
#[test]
fn an_adapter_without_f64_is_refused_for_the_f64_kernel_alone() {
    let mut without = Gpu::open(&Pick::Best).unwrap();
    without.facts.f64 = false;
    let without = Arc::new(without);
    assert_eq!(without.arithmetic_f64().unwrap(), None);
    assert!(!without.is_ieee(Kernel::Double).unwrap());
    let scene = Arc::new(scene(vec![sphere(DVec3::NEG_Z * 5.0, 1.0)], vec![]));
    let rays = Rays::Pixels(Pixels::whole(View::new(&camera(DVec3::ZERO, DVec3::NEG_Z)), 40, 30));
    for kernel in Kernel::ALL {
        let prepared = Arc::new(Prepared::new(Arc::clone(&scene), kernel, &rays).unwrap());
        for gpu in [&gpu(), &without] {
            let made = GpuTracer::new(Arc::clone(gpu), Arc::clone(&prepared), Wants::default());
            let refused = kernel == Kernel::Double && !gpu.facts.f64;
            assert_eq!(made.is_err(), refused, "{}", kernel.name());
            let Err(error) = made else { continue };
            assert_eq!(error.exit_code(), 4);
            for part in [gpu.facts.name.as_str(), "f64", "`double`", "`--device cpu`"] {
                assert!(error.to_string().contains(part), "{part}: {error}");
            }
        }
    }
}

#[test]
fn pixels_that_the_picture_lacks_are_refused() {
    let scene = Arc::new(scene(vec![sphere(DVec3::NEG_Z * 5.0, 1.0)], vec![]));
    let whole = Pixels::whole(View::new(&camera(DVec3::ZERO, DVec3::NEG_Z)), 40, 30);
    let prepared = Prepared::new(scene, Kernel::Certified, &Rays::Pixels(whole)).unwrap();
    let check = |x, y, width, height| {
        prepared.check(&Rays::Pixels(Pixels { x, y, width, height, ..whole })).is_ok()
    };
    assert!(check(0, 0, 40, 30) && check(39, 29, 1, 1));
    assert!(!check(1, 0, 40, 30) && !check(0, 1, 40, 30));
    assert!(!check(u32::MAX, 0, 2, 1) && !check(0, u32::MAX, 1, 2));
}

#[test]
fn an_empty_scene_is_background() {
    let scene = Arc::new(scene(vec![], vec![]));
    let pixels = Pixels::whole(View::new(&camera(DVec3::ZERO, DVec3::NEG_Z)), 40, 30);
    for kernel in Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)) {
        let (on_cpu, on_gpu) = both(&scene, kernel, &Rays::Pixels(pixels), true);
        assert!(compare(&on_cpu, &on_gpu).is_equal());
        assert_eq!(on_gpu.n_hits(), 0);
        assert!(on_gpu.t.iter().all(|&t| t == f32::INFINITY));
    }
}

/// The CPU looks at squares of pixels before single ones; rectangles of one column have no squares.
#[test]
fn squares_give_what_single_rays_give() {
    for seed in 20..26 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let spheres = (0..FEW_SPHERES)
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
            assert!(prepared.hierarchy.is_none(), "no squares here");
            let mut hits = Hits::default();
            let wants = Wants { surface: false, level: true };
            CpuTracer::new(prepared, wants).trace(&rays, &Control::default(), &mut hits).unwrap();
            hits
        };
        let squares = on_cpu(whole);
        assert!(squares.n_hits() > 0);
        for x in 0..67 {
            let single = on_cpu(Pixels { x, width: 1, ..whole });
            for y in 0..50 {
                let index = y * 67 + x as usize;
                assert_eq!(single.id[y], squares.id[index], "seed {seed}, pixel {x}, {y}");
                assert_eq!(single.level[y], squares.level[index], "seed {seed}, pixel {x}, {y}");
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

/// More objects than a loop on a device in software has turns: they are not cut off.
#[test]
fn a_very_long_list_is_looked_at_to_its_end() {
    let mut spheres = vec![sphere(DVec3::Z * 9.0, 1.0); 66_000];
    spheres.push(sphere(DVec3::NEG_Z * 5.0, 1.0));
    let scene = Arc::new(scene(spheres, Vec::new()));
    let pixels = Pixels::whole(View::new(&camera(DVec3::ZERO, DVec3::NEG_Z)), 9, 7);
    for kernel in Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)) {
        assert_parity(&scene, kernel, &Rays::Pixels(pixels), false, "66 001 spheres");
    }
}
