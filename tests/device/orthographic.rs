//! The orthographic camera: every pixel of the kernel `certified` against exact arithmetic, where it
//! is hard for parallel rays, and all kernels bit by bit the same on the device and on the CPU.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::compare::compare;
use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::gpu::GpuTracer;
use kugelblitz::gpu::before::propose_alone;
use kugelblitz::num::OPEN;
use kugelblitz::prepare::{FEW_SPHERES, Prepared};
use kugelblitz::rays::{Bundle, Lens, Pixels, View};
use kugelblitz::scene::{Camera, Color, Projection, Scene, Sphere, read_scene};
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz::verify::{Truth, compare_to_exact, sample};
use kugelblitz_tests::judge::{ALL, Tally, judge};
use kugelblitz_tests::{gpu, in_cube, judge, plane, root, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// An orthographic camera's picture.
fn pixels(
    position: DVec3,
    look_at: DVec3,
    height: f64,
    [image_width, image_height]: [u32; 2],
) -> Pixels {
    let up = DVec3::new(0.1, 1.0, 0.2);
    let projection = Projection::Orthographic { height };
    let view = View::new(&Camera { position, look_at, up, projection });
    Pixels::whole(view, image_width, image_height)
}

/// A camera along −z whose pixels are integers apart: all numbers of its rays are.
fn integer_pixels(position: DVec3, [width, height]: [u32; 2]) -> Pixels {
    let view = View {
        position,
        forward: DVec3::NEG_Z,
        right: DVec3::X,
        true_up: DVec3::Y,
        h: f64::from(height),
        lens: Lens::Orthographic,
    };
    Pixels::whole(view, width, height)
}

/// The certified kernel on the CPU and on the device: the same, and that of exact arithmetic.
fn check(what: &str, scene: Scene, pixels: Pixels) -> Tally {
    let (scene, rays) = (Arc::new(scene), Rays::Pixels(pixels));
    assert_eq!(rays.bundle(), Bundle::Parallel);
    let hits = judge::trace(&scene, Kernel::Certified, &rays, None);
    let tally = judge(&scene, &rays, &hits, 1).unwrap_or_else(|wrong| panic!("{what}: {wrong}"));
    let on_device = judge::trace(&scene, Kernel::Certified, &rays, Some(&gpu()));
    let difference = compare(&on_device, &hits);
    assert!(difference.is_equal(), "{what}: {difference:?}");
    println!("{what}: {:?}, {} hits", tally.counts, tally.hits);
    tally
}

/// Spheres of all sizes before, in and behind the picture's plane, and a plane.
fn some(rng: &mut ChaCha8Rng, n: usize) -> Scene {
    let spheres = (0..n)
        .map(|_| {
            let radius = 10f64.powf(rng.random_range(-2.0..0.3)) * (n as f64).powf(-0.3);
            sphere(in_cube(rng) * 3.0, radius)
        })
        .collect();
    scene(spheres, vec![plane(in_cube(rng), in_cube(rng))])
}

#[test]
fn random_scenes_are_exact() {
    let mut rng = ChaCha8Rng::seed_from_u64(1201);
    let mut all = Tally::default();
    for turn in 0..12 {
        let n = [1, 5, FEW_SPHERES, FEW_SPHERES + 1, 60, 400][turn % 6];
        let height = rng.random_range(0.5..8.0);
        let pixels = pixels(in_cube(&mut rng) * 2.0, in_cube(&mut rng), height, [61, 43]);
        all.add(check(&format!("turn {turn}, {n} spheres"), some(&mut rng, n), pixels));
    }
    assert!(all.hits > all.rays / 10, "{all:?}");
    // Spheres that the picture's plane cuts are open along their edge there.
    assert!(all.counts.f32 as f64 > 0.98 * all.rays as f64, "{all:?}");
}

/// The outlines of spheres on integers go exactly through pixels, and spheres touch.
#[test]
fn tangent_rays_are_hits() {
    let picture = integer_pixels(DVec3::ZERO, [41, 31]);
    let radius = [5.0, 10.0, 13.0];
    let few: Vec<Sphere> = (0..9)
        .map(|i| {
            let center = DVec3::new(f64::from(i % 3) * 20.0 - 20.0, f64::from(i / 3) * 12.0, -40.0);
            sphere(center.with_z(-40.0 - 3.0 * f64::from(i)), radius[i as usize % 3])
        })
        .collect();
    let tally = check("few", scene(few.clone(), vec![]), picture);
    assert!(tally.counts.exact > 10, "{tally:?}");
    let many = (0..400).map(|i| {
        let place = DVec3::new(f64::from(i % 20), f64::from(i / 20), 0.0) * 4.0;
        sphere(place - DVec3::new(40.0, 40.0, 20.0), 2.0)
    });
    let tally = check("a lattice", scene(many.chain(few).collect(), vec![]), picture);
    assert!(tally.counts.exact > 100, "{tally:?}");
}

/// Equal spheres and planes tie: the lower id is seen.
#[test]
fn what_coincides_ties() {
    let mut rng = ChaCha8Rng::seed_from_u64(1202);
    for n in [4, 100] {
        let once = some(&mut rng, n);
        let planes = vec![once.planes[0].clone(), once.planes[0].clone()];
        let twice = scene([&once.spheres[..], &once.spheres[..]].concat(), planes);
        let pixels = pixels(DVec3::Z * 9.0, DVec3::ZERO, 6.0, [40, 31]);
        let rays = Rays::Pixels(pixels);
        check("twice", twice.clone(), pixels);
        let hits = judge::trace(&Arc::new(twice), Kernel::Certified, &rays, None);
        let is_first = |&id: &u32| id as usize <= n || id as usize == 2 * n + 1;
        assert!(hits.id.iter().all(is_first), "the second is seen");
    }
}

/// What lies before the picture's plane is seen, what is at `t ≤ 0` is not: the near root is 0 where
/// a sphere touches the plane, and the far one where it ends there.
#[test]
fn the_pictures_plane_cuts() {
    let picture = integer_pixels(DVec3::ZERO, [21, 21]);
    for depth in [-5.0, -4.0, -3.0, 0.0, 3.0, 4.0, 5.0, 6.0] {
        let middle = DVec3::NEG_Z * depth;
        let few = vec![sphere(middle, 5.0), sphere(middle + DVec3::X * 10.0, 5.0)];
        let behind = plane(DVec3::NEG_Z * 7.0, DVec3::Z);
        let at = plane(DVec3::ZERO, DVec3::Z);
        let tally = check("few", scene(few.clone(), vec![behind.clone(), at.clone()]), picture);
        assert_eq!(tally.hits, tally.rays, "the plane behind is seen");
        let far = (0..50).map(|i| sphere(DVec3::new(f64::from(i), 0.0, 100.0), 3.0));
        let many = few.into_iter().chain(far).collect();
        check("many", scene(many, vec![at, behind]), picture);
    }
    let touching = scene(vec![sphere(DVec3::NEG_Z * 5.0, 5.0)], vec![]);
    let rays = Rays::Pixels(picture);
    let hits = judge::trace(&Arc::new(touching), Kernel::Certified, &rays, None);
    assert_eq!(hits.t[10 * 21 + 10], 10.0, "from t = 0 on it is the far root");
}

/// Coordinates of 10⁸ and of 10⁻⁶, a sphere like the Earth, and one that fills the picture.
#[test]
fn far_away_and_tiny_and_huge() {
    let mut rng = ChaCha8Rng::seed_from_u64(1203);
    for n in [6, 200] {
        for (by, scale) in [(DVec3::new(1e8, -2e8, 3e8), 1.0), (DVec3::ZERO, 1e-6)] {
            let Scene { spheres, mut planes, .. } = some(&mut rng, n);
            let mut spheres = spheres.to_vec();
            for sphere in &mut spheres {
                sphere.center = (sphere.center + by) * scale;
                sphere.radius *= scale;
            }
            for plane in &mut planes {
                plane.point = (plane.point + by) * scale;
            }
            let [eye, at] = [DVec3::new(1.0, 2.0, 9.0), DVec3::ZERO].map(|p| (p + by) * scale);
            let picture = pixels(eye, at, 5.0 * scale, [45, 33]);
            let tally = check("moved or scaled", scene(spheres, planes), picture);
            assert!(tally.counts.f32 as f64 > 0.97 * tally.rays as f64, "{tally:?}");
        }
        // The camera far behind everything: f32 knows no depth any more.
        let picture = pixels(DVec3::Z * 1e8, DVec3::ZERO, 5.0, [45, 33]);
        check("seen from afar", some(&mut rng, n), picture);
        let mut ground = some(&mut rng, n);
        ground.spheres.push(sphere(DVec3::Y * -6.371e6, 6.371e6), Color::BLACK);
        let picture = pixels(DVec3::new(0.0, 1.7, 0.0), DVec3::new(1.0, 1.0, -1.0), 2.0, [45, 33]);
        let tally = check("on a huge sphere", ground, picture);
        assert!(tally.counts.exact < tally.rays / 50, "{tally:?}");
    }
    // Numbers that f32 does not hold.
    let few = vec![sphere(DVec3::new(0.0, 0.0, -1e30), 1e29), sphere(DVec3::ZERO, 1e-30)];
    check("out of range", scene(few.clone(), vec![]), pixels(DVec3::Z, DVec3::ZERO, 1e30, [9, 9]));
    check("out of range", scene(few, vec![]), pixels(DVec3::Z, DVec3::ZERO, 1e-29, [9, 9]));
}

/// Ids, and `t` to f32's last digit, of a sample of pixels.
#[test]
fn a_million_spheres() {
    let mut rng = ChaCha8Rng::seed_from_u64(1204);
    let spheres = (0..1_000_000).map(|_| sphere(in_cube(&mut rng), 0.006)).collect();
    let scene = Arc::new(scene(spheres, vec![]));
    let picture = pixels(DVec3::new(0.7, 0.4, 3.0), DVec3::ZERO, 2.4, [640, 360]);
    let rays = Rays::Pixels(picture);
    let prepared = Arc::new(Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap());
    assert!(prepared.hierarchy.as_ref().unwrap().rest.len() < FEW_SPHERES);
    let mut hits = Hits::default();
    let mut tracer = CpuTracer::new(Arc::clone(&prepared), ALL);
    tracer.trace(&rays, &Control::default(), &mut hits).unwrap();
    let mut on_device = Hits::default();
    let mut tracer = GpuTracer::new(gpu(), prepared, ALL).unwrap();
    tracer.trace(&rays, &Control::default(), &mut on_device).unwrap();
    assert!(compare(&on_device, &hits).is_equal());
    let chosen = sample(picture.len(), 64, 5);
    let truth = Truth::of_pixels(&scene, &picture, chosen, &Control::default()).unwrap();
    let against = compare_to_exact(&hits, &truth);
    assert_eq!(against.wrong_ids(), 0, "{against:?}");
    assert!(against.t_ulp_max <= 0.501, "{against:?}");
    println!("{:?}, {} hits", hits.counts, hits.n_hits());
    assert!(hits.counts.f32 as f64 > 0.97 * rays.len() as f64, "{:?}", hits.counts);
}

/// A part of a picture is that part of the whole one.
#[test]
fn crops_are_parts() {
    let mut rng = ChaCha8Rng::seed_from_u64(1205);
    for n in [7, 300] {
        let scene = Arc::new(some(&mut rng, n));
        let whole = pixels(DVec3::new(1.0, 2.0, 5.0), DVec3::ZERO, 5.0, [61, 43]);
        let part = Pixels { x: 23, y: 11, width: 17, height: 9, ..whole };
        for device in [None, Some(&gpu())] {
            let [all, some] = [whole, part].map(|pixels| {
                judge::trace(&scene, Kernel::Certified, &Rays::Pixels(pixels), device)
            });
            for index in 0..part.len() {
                let (x, y) = part.xy(index);
                let of_all = y as usize * 61 + x as usize;
                assert_eq!(some.id[index], all.id[of_all]);
                assert_eq!(some.t[index].to_bits(), all.t[of_all].to_bits());
            }
        }
    }
}

/// On a device with the CPU's arithmetic.
#[test]
fn all_kernels_are_byte_equal_on_device_and_cpu() {
    let mut rng = ChaCha8Rng::seed_from_u64(1206);
    for n in [0, 3, 150] {
        let scene = Arc::new(some(&mut rng, n.max(1)));
        let picture = pixels(DVec3::new(1.0, 2.0, 5.0), DVec3::ZERO, 5.0, [61, 43]);
        let rays = Rays::Pixels(picture);
        for kernel in Kernel::ALL {
            if !gpu().is_ieee(kernel).unwrap() {
                continue;
            }
            let hits = judge::trace(&scene, kernel, &rays, None);
            let difference = compare(&judge::trace(&scene, kernel, &rays, Some(&gpu())), &hits);
            assert!(difference.is_equal(), "{}: {difference:?}", kernel.name());
            assert!(hits.n_hits() > 100, "{}", kernel.name());
        }
    }
}

fn proposed(tracer: &mut dyn Tracer, rays: &Rays) -> Vec<u32> {
    let mut hits = Hits::default();
    tracer.propose(rays, &Control::default(), &mut hits).unwrap();
    hits.id
}

/// Before anything is resolved. A device whose arithmetic is not the CPU's may leave other rays open.
#[test]
fn proposals_are_the_same() {
    let mut rng = ChaCha8Rng::seed_from_u64(1207);
    let is_ieee = gpu().is_ieee(Kernel::Certified).unwrap();
    for n in [3, 300] {
        let scene = Arc::new(some(&mut rng, n));
        let picture = pixels(DVec3::new(0.2, 0.1, 1.0), DVec3::ZERO, 5.0, [203, 151]);
        let rays = Rays::Pixels(picture);
        let prepared = Arc::new(Prepared::new(scene, Kernel::Certified, &rays).unwrap());
        let wants = Wants::default();
        let device =
            proposed(&mut GpuTracer::new(gpu(), Arc::clone(&prepared), wants).unwrap(), &rays);
        let twin = propose_alone(&prepared, &picture).unwrap();
        let differs = |ray: &usize| {
            let (a, b) = (device[*ray], twin[*ray]);
            a != b && (is_ieee || a != OPEN && b != OPEN)
        };
        assert_eq!((0..twin.len()).find(differs), None, "{n} spheres");
        let n_open = twin.iter().filter(|&&id| id == OPEN).count();
        println!("{n} spheres: {n_open} of {} open", twin.len());
        assert!((n == 3 || n_open > 0) && n_open < twin.len() / 20, "{n_open} of {}", twin.len());
    }
}

/// A camera that is upside down, too near or too far, is another camera: exact arithmetic says so.
#[test]
fn sabotage_is_noticed() {
    let mut rng = ChaCha8Rng::seed_from_u64(1208);
    let right = pixels(DVec3::new(1.0, 2.0, 5.0), DVec3::ZERO, 5.0, [61, 43]);
    for n in [6, 200] {
        let scene = Arc::new(some(&mut rng, n));
        let wrong: [fn(&mut View); 5] = [
            |_| {},
            |view| view.true_up = -view.true_up,
            |view| view.h *= 2.0,
            |view| view.position += view.forward * 0.5,
            |view| view.lens = Lens::Perspective,
        ];
        for (place, change) in wrong.into_iter().enumerate() {
            let mut other = right;
            change(&mut other.view);
            let hits = judge::trace(&scene, Kernel::Certified, &Rays::Pixels(other), None);
            let judged = judge(&scene, &Rays::Pixels(right), &hits, 1);
            assert_eq!(judged.is_ok(), place == 0, "change {place}, {n} spheres");
        }
    }
}

/// The scene file of the README is seen as it says, in every kernel.
#[test]
fn the_scene_file_is_orthographic() {
    let path = root().join("scenes/orthographic.toml");
    let scene = Arc::new(read_scene(&path).unwrap());
    let camera = scene.camera.as_ref().unwrap();
    assert!(matches!(camera.projection, Projection::Orthographic { .. }));
    let picture = Pixels::whole(View::new(camera), 96, 54);
    let tally = check("the file", (*scene).clone(), picture);
    assert!(tally.hits > tally.rays / 10, "{tally:?}");
    let image = scene.image.unwrap();
    assert_eq!((image.width, image.height), (1280, 720));
}
