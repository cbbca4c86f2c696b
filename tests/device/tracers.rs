//! What tracers refuse and leave to the CPU, on either device.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::device::Device;
use kugelblitz::gpu::{Gpu, GpuTracer};
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, WorldRay};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, Sphere};
use kugelblitz::tracer::Tracer;
use kugelblitz_judge::compare::compare;
use kugelblitz_tests::{broken, camera, gpu, in_cube, plane, runs, scene, sphere, traced};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A ball ahead, in a picture of 40 × 30 pixels.
fn a_ball() -> (Arc<Scene>, Pixels) {
    let scene = scene(vec![sphere(DVec3::NEG_Z * 5.0, 1.0)], vec![]);
    let view = View::new(&camera(DVec3::ZERO, DVec3::NEG_Z));
    (Arc::new(scene), Pixels::whole(view, 40, 30))
}

/// Balls in a cube.
fn uniform(seed: u64, n: usize) -> Vec<Sphere> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| sphere(in_cube(&mut rng), 0.6 * (n as f64).powf(-1.0 / 3.0))).collect()
}

/// Rays into them.
fn list(seed: u64) -> Vec<WorldRay> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let ray = |_| WorldRay { origin: in_cube(&mut rng) * 3.0, direction: in_cube(&mut rng) };
    (0..20_000).map(ray).collect()
}

/// Not each adapter has f64, and those that have it can be told that they don't.
#[test]
fn an_adapter_without_f64_is_refused_for_the_f64_kernel_alone() {
    let mut without = Gpu::open("").unwrap();
    without.facts.f64 = false;
    let without = Arc::new(without);
    assert_eq!(without.arithmetic_f64().unwrap(), None);
    assert!(!without.is_ieee(Kernel::Double).unwrap());
    let (scene, pixels) = a_ball();
    let rays = Rays::Pixels(pixels);
    for kernel in Kernel::ALL {
        let prepared = Arc::new(Prepared::new(Arc::clone(&scene), kernel, &rays).unwrap());
        for gpu in [&gpu(), &without] {
            let made = GpuTracer::new(Arc::clone(gpu), Arc::clone(&prepared), Outputs::default());
            let refused = kernel == Kernel::Double && !gpu.facts.f64;
            assert_eq!(made.is_err(), refused, "{}", kernel.name());
            let Err(error) = made else { continue };
            assert_eq!(error.exit_code(), 4);
            for part in [gpu.facts.name.as_str(), "f64", "`double`"] {
                assert!(error.to_string().contains(part), "{part}: {error}");
            }
            assert!(error.hint().to_string().contains("device = \"cpu\""), "{}", error.hint());
        }
    }
}

#[test]
fn pixels_that_the_picture_lacks_are_refused() {
    let (scene, whole) = a_ball();
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
    let rays = Rays::Pixels(a_ball().1);
    for kernel in Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)) {
        for device in [None, Some(&gpu())] {
            let hits = traced(&Arc::new(scene(vec![], vec![])), kernel, &rays, device);
            assert!(hits.n_hits() == 0 && hits.t.iter().all(|&t| t == f32::INFINITY));
        }
    }
}

#[test]
fn rays_that_the_scene_was_not_prepared_for_are_refused() {
    let (scene, _) = a_ball();
    let view = |x: f64| View::new(&camera(DVec3::X * x, DVec3::NEG_Z));
    let list = |x: f64| {
        let ray = |x: f64| WorldRay { origin: DVec3::X * x, direction: DVec3::NEG_Z };
        Rays::List(vec![ray(x), ray(-x)])
    };
    let picture = |x: f64, width: u32| Rays::Pixels(Pixels::whole(view(x), width, 20));
    for (made_for, part, others) in [
        (picture(0.0, 30), picture(0.0, 30), [picture(0.1, 30), picture(0.0, 31), list(0.0)]),
        // f64 decides rays of a list that start farther away.
        (list(2.0), list(3.0), [picture(0.2, 30), picture(0.0, 30), picture(0.1, 31)]),
    ] {
        let prepared =
            Arc::new(Prepared::new(Arc::clone(&scene), Kernel::Certified, &made_for).unwrap());
        let wants = Outputs::default();
        let mut tracers = [
            Tracer::on_cpu(Arc::clone(&prepared), wants),
            Device::Gpu(gpu()).tracer(&prepared, wants).unwrap().tracer,
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
    let rays = Rays::Pixels(Pixels::whole(View::new(&camera(DVec3::ZERO, DVec3::NEG_Z)), 9, 7));
    for kernel in Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)) {
        let [on_cpu, on_gpu] =
            [None, Some(&gpu())].map(|device| traced(&scene, kernel, &rays, device));
        assert_eq!(broken(kernel, &on_cpu, &on_gpu), None);
        assert!(on_cpu.n_hits() > 0, "{}", kernel.name());
    }
}

/// Seen from the origin all have one outline but the last, which shows at the corners of their squares: a ray there
/// goes through all of them, and a device in software doesn't let it.
#[test]
fn a_ray_through_very_many_squares_comes_to_their_end() {
    let n = 40_000;
    let ball = |i: usize| {
        let distance = 5.0 * 10f64.powf(i as f64 / n as f64);
        sphere(DVec3::NEG_Z * distance, 0.2 * distance)
    };
    let mut spheres: Vec<Sphere> = (0..n).map(ball).collect();
    spheres.push(sphere(DVec3::NEG_Z * 2000.0, 800.0));
    let scene = Arc::new(scene(spheres, Vec::new()));
    let rays = Rays::Pixels(Pixels::whole(View::new(&camera(DVec3::ZERO, DVec3::NEG_Z)), 16, 12));
    let [on_cpu, on_gpu] =
        [None, Some(&gpu())].map(|device| traced(&scene, Kernel::Certified, &rays, device));
    assert!(compare(&on_gpu, &on_cpu).is_equal());
    let n_behind = on_cpu.id.iter().filter(|&&id| id as usize == n + 1).count();
    assert!(n_behind > 4, "{n_behind}");
}

/// Vulkan asks for no more than four storage buffers in a shader. A list of `certified` needs no more, nor do few objects;
/// where a kernel does, it is told with numbers.
#[test]
fn lists_need_few_storage_buffers() {
    let floor = plane(DVec3::Y * -3.0, DVec3::Y);
    let scene = Arc::new(scene(uniform(88, 1000), vec![floor]));
    let rays = Rays::List(list(88));
    let mut gpu = Gpu::open("").unwrap();
    gpu.facts.max_storage_buffers = 4;
    let gpu = Arc::new(gpu);
    assert!(traced(&scene, Kernel::Certified, &rays, Some(&gpu)).n_hits() > 0);
    let prepared = Prepared::new(scene, Kernel::Stable, &rays).unwrap();
    let wants = Outputs { surface: true, level: false };
    let refused = GpuTracer::new(gpu, Arc::new(prepared), wants).err().unwrap();
    assert_eq!(refused.exit_code(), 7);
    let text = refused.to_string();
    assert!(text.contains("5 storage buffers") && text.contains("at most 4"), "{text}");
}

/// Where spheres are too far from the rays for f32's slabs, the CPU takes the list.
#[test]
fn a_list_far_from_its_tree_is_left_to_the_cpu() {
    let (scene, mut rays) = (Arc::new(scene(uniform(90, 500), vec![])), list(90));
    rays.iter_mut().step_by(4).for_each(|ray| ray.origin = DVec3::X * 3e12);
    let rays = Rays::List(rays);
    let prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
    assert!(prepared.in_range && prepared.in_space().unwrap().is_none());
    let [on_cpu, on_gpu] =
        [None, Some(&gpu())].map(|device| traced(&scene, Kernel::Certified, &rays, device));
    assert_eq!(on_gpu, on_cpu);
    assert!(on_gpu.n_hits() > 1000);
}

#[test]
fn more_spheres_than_a_device_holds_are_refused() {
    let scene = Arc::new(scene(uniform(616, 3000), vec![]));
    let pixels = Pixels::whole(View::new(&camera(DVec3::Z * 4.0, DVec3::ZERO)), 1920, 1080);
    let prepared =
        Arc::new(Prepared::new(scene, Kernel::Certified, &Rays::Pixels(pixels)).unwrap());
    let refusal = |max_texture_side| {
        let mut gpu = Gpu::open("").expect("a Vulkan device; ci/setup.sh installs one");
        gpu.facts.max_texture_side = max_texture_side;
        GpuTracer::new(Arc::new(gpu), Arc::clone(&prepared), Outputs::default()).err()
    };
    let error = refusal(1).unwrap();
    assert_eq!(error.exit_code(), 7);
    assert!(error.to_string().contains("takes at most 1365"), "{error}");
    assert!(refusal(3).is_none());
}
