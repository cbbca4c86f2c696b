//! Many spheres: what is found through a hierarchy is what a look at every sphere finds, exactly.

use std::collections::HashSet;
use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::compare::compare;
use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::exact::{ExactRay, Shape, visible_root};
use kugelblitz::gpu::before::slabs::{SlabRoom, meets, slabs_of};
use kugelblitz::gpu::{Gpu, GpuTracer, Pick};
use kugelblitz::kernel::certified::SphereFar;
use kugelblitz::prepare::{FEW_SPHERES, Hierarchy, LISTED_SPHERES, Prepared, Scaled, Seen};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Plane, Projection, Scene, Sphere};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, StageCounts, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz::tree::{IS_LEAF, Tree, TreeRay};
use kugelblitz::vec3::Vec3;
use kugelblitz::verify::{Truth, compare_to_exact, sample};
use kugelblitz_tests::{in_cube, plane, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const WANTS: Wants = Wants { surface: true, level: true };

/// On the CPU. The device sees the same, though it may leave other rays to f64.
fn trace(scene: &Arc<Scene>, rays: &Rays, wants: Wants) -> (Hits, Arc<Prepared>) {
    let prepared = Arc::new(Prepared::new(Arc::clone(scene), Kernel::Certified, rays).unwrap());
    let hits = trace_with(&mut CpuTracer::new(Arc::clone(&prepared), wants), rays);
    let mut on_device =
        GpuTracer::new(kugelblitz_tests::gpu(), Arc::clone(&prepared), wants).unwrap();
    assert_same(&trace_with(&mut on_device, rays), &hits);
    (hits, prepared)
}

fn trace_with(tracer: &mut dyn Tracer, rays: &Rays) -> Hits {
    let mut hits = Hits::default();
    tracer.trace(rays, &Control::default(), &mut hits).unwrap();
    hits
}

fn assert_same(on_device: &Hits, on_cpu: &Hits) {
    let difference = compare(on_device, on_cpu);
    assert!(difference.is_equal(), "{difference:?}");
}

/// Every pixel is right, and the f32 stage decided most of them.
fn check_picture(
    what: &str,
    camera: &Camera,
    spheres: Vec<Sphere>,
    planes: Vec<Plane>,
) -> StageCounts {
    assert!(spheres.len() > FEW_SPHERES);
    let scene = Arc::new(kugelblitz_tests::scene(spheres, planes));
    // No side is a multiple of a tile's.
    let pixels = Pixels::whole(View::new(camera), 61, 43);
    let rays = Rays::Pixels(pixels);
    let (hits, prepared) = trace(&scene, &rays, WANTS);
    assert!(prepared.hierarchy.is_some(), "{what}: no hierarchy");
    let all = (0..pixels.len()).collect();
    let truth = Truth::of_pixels(&scene, &pixels, all, &Control::default()).unwrap();
    let against = compare_to_exact(&hits, &truth);
    assert_eq!(against.wrong_ids(), 0, "{what}: {against:?}");
    assert!(against.t_ulp_max <= 0.501, "{what}: {against:?}");
    assert!(hits.n_hits() > 200, "{what}: {} hits", hits.n_hits());
    let share = hits.counts.f32 as f64 / rays.len() as f64;
    println!(
        "{what}: {:?}, {} not in the hierarchy",
        hits.counts,
        prepared.hierarchy.as_ref().unwrap().rest.len()
    );
    assert!(share > 0.5, "{what}: f32 decided {share}");
    hits.counts
}

fn looking_at_the_origin(distance: f64) -> Camera {
    kugelblitz_tests::camera(DVec3::new(0.3, 0.2, 1.0).normalize() * distance, DVec3::ZERO)
}

fn uniform(rng: &mut ChaCha8Rng, n: usize) -> Vec<Sphere> {
    let radius = 0.6 * (n as f64).powf(-1.0 / 3.0);
    (0..n).map(|_| sphere(in_cube(rng), radius)).collect()
}

#[test]
fn clouds_of_all_sorts() {
    let mut rng = ChaCha8Rng::seed_from_u64(606);
    // On the device, more than a row of a texture.
    check_picture("uniform", &looking_at_the_origin(4.0), uniform(&mut rng, 5000), vec![]);

    let clustered = (0..500)
        .map(|i| {
            let center = DVec3::splat(f64::from(i % 5) * 0.3 - 0.6) + 0.1 * in_cube(&mut rng);
            sphere(center, 10f64.powf(rng.random_range(-3.0..-0.8)))
        })
        .collect();
    check_picture("clustered", &looking_at_the_origin(3.0), clustered, vec![]);

    let floor = plane(DVec3::new(0.0, -0.4, 0.0), DVec3::new(0.1, 1.0, 0.0));
    let with_floor = uniform(&mut rng, 300);
    check_picture("with a floor", &looking_at_the_origin(3.0), with_floor, vec![floor]);
}

/// Neighbours touch in exact arithmetic, and the middle pixel looks straight along sixteen contacts.
#[test]
fn a_lattice_of_touching_spheres() {
    let lattice: Vec<Sphere> = (0..8 * 8 * 8)
        .map(|i| sphere(DVec3::new(f64::from(i % 8), f64::from(i / 8 % 8), f64::from(i / 64)), 0.5))
        .collect();
    let camera = Camera {
        position: DVec3::new(3.5, 3.0, 30.0),
        look_at: DVec3::new(3.5, 3.0, 0.0),
        up: DVec3::Y,
        projection: Projection::Perspective { fov_degrees: 20.0 },
    };
    assert_eq!(check_picture("lattice", &camera, lattice, vec![]).exact, 1);
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
    let scene = Arc::new(kugelblitz_tests::scene(spheres, Vec::new()));
    let view = View::new(&kugelblitz_tests::camera(DVec3::ZERO, DVec3::NEG_Z));
    let rays = Rays::Pixels(Pixels::whole(view, 16, 12));
    let (hits, _) = trace(&scene, &rays, Wants::default());
    let n_behind = hits.id.iter().filter(|&&id| id as usize == n + 1).count();
    assert!(n_behind > 4, "{n_behind}");
}

#[test]
fn far_from_the_origin_and_from_within() {
    let mut rng = ChaCha8Rng::seed_from_u64(607);
    let offset = DVec3::new(1e7, -3e7, 2e7);
    let moved = uniform(&mut rng, 400)
        .into_iter()
        .map(|s| Sphere { center: s.center + offset, ..s })
        .collect();
    let camera = Camera {
        position: offset + DVec3::new(0.5, 0.5, 4.0),
        look_at: offset,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_degrees: 45.0 },
    };
    check_picture("at 1e7", &camera, moved, vec![]);

    // Among the spheres, within one of them, and on the ground of a huge one.
    let inside = kugelblitz_tests::camera(DVec3::new(0.01, 0.02, 0.03), DVec3::new(1.0, 0.3, 0.2));
    let mut spheres = uniform(&mut rng, 400);
    spheres.retain(|s| s.center.length() > s.radius + 0.05);
    check_picture("from within the cloud", &inside, spheres.clone(), vec![]);
    spheres.push(sphere(DVec3::ZERO, 0.9));
    check_picture("from within a sphere", &inside, spheres.clone(), vec![]);
    spheres.pop();
    spheres.push(sphere(DVec3::new(0.0, -1e9 - 0.5, 0.0), 1e9));
    check_picture("on a huge ground", &looking_at_the_origin(3.0), spheres, vec![]);
}

/// The device's copy of a hierarchy follows the camera, and parts of a picture are parts of the whole.
#[test]
fn a_moved_camera_and_parts_of_pictures() {
    let mut rng = ChaCha8Rng::seed_from_u64(614);
    let mut spheres = uniform(&mut rng, 700);
    spheres.push(sphere(DVec3::new(0.0, 0.0, 9.0), 0.5));
    let scene = Arc::new(kugelblitz_tests::scene(spheres, vec![]));
    let mut on_device: Option<GpuTracer> = None;
    let cameras = [
        looking_at_the_origin(4.0),
        // In a sphere, which is then in no hierarchy.
        kugelblitz_tests::camera(DVec3::new(0.0, 0.1, 9.0), DVec3::ZERO),
        looking_at_the_origin(30.0),
        // Away from all.
        kugelblitz_tests::camera(DVec3::new(0.0, 0.0, 40.0), DVec3::new(0.0, 0.0, 50.0)),
        looking_at_the_origin(2.5),
    ];
    for camera in &cameras {
        let whole = Pixels::whole(View::new(camera), 61, 43);
        let rays = Rays::Pixels(whole);
        let prepared =
            Arc::new(Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap());
        let on_cpu = trace_with(&mut CpuTracer::new(Arc::clone(&prepared), WANTS), &rays);
        let tracer = match &mut on_device {
            Some(tracer) => {
                tracer.retarget(Arc::clone(&prepared)).unwrap();
                tracer
            }
            None => on_device.insert(
                GpuTracer::new(kugelblitz_tests::gpu(), Arc::clone(&prepared), WANTS).unwrap(),
            ),
        };
        assert_same(&trace_with(tracer, &rays), &on_cpu);
        let part = Pixels { x: 13, y: 7, width: 29, height: 30, ..whole };
        let mut cpu = CpuTracer::new(prepared, WANTS);
        let on_device = trace_with(tracer, &Rays::Pixels(part));
        assert_same(&on_device, &trace_with(&mut cpu, &Rays::Pixels(part)));
        for index in 0..part.len() {
            let (x, y) = part.xy(index);
            assert_eq!(on_device.id[index], on_cpu.id[(y * 61 + x) as usize], "pixel {x}, {y}");
        }
    }
}

/// More spheres around the eye than a shader unrolls, and others, with ids all over.
#[test]
fn many_spheres_around_the_eye() {
    let mut rng = ChaCha8Rng::seed_from_u64(615);
    let eye = DVec3::new(0.0, 0.0, 4.0);
    let mut spheres = uniform(&mut rng, 300);
    for (k, index) in (0..LISTED_SPHERES + 20).zip((0..).step_by(2)) {
        let radius = 30.0 + 0.01 * k as f64;
        spheres.insert(index, sphere(eye + 0.1 * in_cube(&mut rng), radius));
    }
    let camera = kugelblitz_tests::camera(eye, DVec3::ZERO);
    check_picture("around the eye", &camera, spheres, vec![]);
}

#[test]
fn more_spheres_than_a_device_holds_are_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(616);
    let scene = Arc::new(kugelblitz_tests::scene(uniform(&mut rng, 3000), vec![]));
    let pixels = Pixels::whole(View::new(&looking_at_the_origin(4.0)), 1920, 1080);
    let prepared =
        Arc::new(Prepared::new(scene, Kernel::Certified, &Rays::Pixels(pixels)).unwrap());
    let refusal = |max_texture_side| {
        let mut gpu = Gpu::open(&Pick::Best).expect("a Vulkan device; ci/setup.sh installs one");
        gpu.facts.max_texture_side = max_texture_side;
        GpuTracer::new(Arc::new(gpu), Arc::clone(&prepared), WANTS).err()
    };
    let error = refusal(1).unwrap();
    assert_eq!(error.exit_code(), 7);
    assert!(error.to_string().contains("takes at most 2048"), "{error}");
    assert!(refusal(2).is_none());
}

/// Equal spheres, and spheres of extreme sizes among ordinary ones.
#[test]
fn ties_and_extremes() {
    let mut rng = ChaCha8Rng::seed_from_u64(608);
    let once = uniform(&mut rng, 200);
    let twice: Vec<Sphere> = once.iter().chain(&once).cloned().collect();
    let scene = Arc::new(kugelblitz_tests::scene(twice, vec![]));
    let pixels = Pixels::whole(View::new(&looking_at_the_origin(4.0)), 61, 43);
    let (hits, _) = trace(&scene, &Rays::Pixels(pixels), WANTS);
    assert!(hits.n_hits() > 500);
    assert_eq!(hits.id.len(), pixels.len());
    assert!(hits.id.iter().all(|&id| id <= 200), "of equals, the first is seen");

    let mut spheres = uniform(&mut rng, 300);
    for (center, radius) in [
        (DVec3::new(0.0, 0.0, -1e30), 1e29),
        (DVec3::new(0.0, -1e25, 0.0), 1e25),
        (DVec3::new(0.1, 0.1, 0.9), 1e-30),
        (DVec3::new(0.1, 0.2, 0.9), 1e-200),
        (DVec3::new(1e200, 0.0, 0.0), 1.0),
        (DVec3::new(0.0, 0.0, 0.5), 0.0),
    ] {
        spheres.push(sphere(center, radius));
    }
    let scene = Arc::new(kugelblitz_tests::scene(spheres, vec![]));
    let (hits, _) = trace(&scene, &Rays::Pixels(pixels), WANTS);
    let all = (0..pixels.len()).collect();
    let truth = Truth::of_pixels(&scene, &pixels, all, &Control::default()).unwrap();
    assert_eq!(compare_to_exact(&hits, &truth).wrong_ids(), 0);
}

/// The same numbers, whether the tree was built for them or before.
fn assert_equals(a: &Prepared, b: &Prepared) {
    assert_eq!(a.objects.bytes(), b.objects.bytes());
    let [a, b] = [a, b].map(|prepared| prepared.hierarchy.as_ref().unwrap());
    assert_eq!((&a.rest, &a.tree.order), (&b.rest, &b.tree.order));
    let numbers = |hierarchy: &Hierarchy| {
        let Seen { footprints, far } = hierarchy.seen.clone()?;
        let bytes = |far: &[SphereFar]| bytemuck::cast_slice::<_, u8>(far).to_vec();
        Some((footprints.nodes, footprints.cell_shift, bytes(&far)))
    };
    assert_eq!(numbers(a), numbers(b));
}

/// A camera that flies through a cloud is close to another number of spheres at each place, but needs
/// few shaders.
#[test]
fn a_flight_through_a_cloud_needs_few_shaders() {
    let mut rng = ChaCha8Rng::seed_from_u64(614);
    // They touch the way of the camera here and there.
    let spheres = (0..3000).map(|_| {
        let (turned, radius) = (rng.random_range(0.0..TAU), rng.random_range(0.05..0.2));
        let aside = DVec3::new(turned.cos(), turned.sin(), 0.0) * radius;
        sphere(DVec3::new(0.1, 0.05, rng.random_range(-1.0..1.0)) + aside, radius)
    });
    let scene = Arc::new(kugelblitz_tests::scene(spheres.collect(), vec![]));
    let renewed = |old: Option<&Prepared>, rays: &Rays| {
        let (scene, control) = (Arc::clone(&scene), Control::default());
        Prepared::renewed(old, scene, Kernel::Certified, rays, &control).unwrap()
    };
    let (mut last, mut numbers, mut keys) = (None, HashSet::new(), HashSet::new());
    for step in 0..60 {
        let along = f64::from(step) / 30.0 - 1.0;
        let camera =
            kugelblitz_tests::camera(DVec3::new(0.1, 0.05, along), DVec3::new(0.3, 0.2, 3.0));
        let rays = Rays::Pixels(Pixels::whole(View::new(&camera), 24, 16));
        let prepared = renewed(last.as_ref(), &rays);
        assert_equals(&prepared, &renewed(None, &rays));
        if step % 20 == 0 {
            let list = Rays::List(vec![Ray { origin: DVec3::Z, direction: DVec3::X }]);
            let of_list = renewed(Some(&prepared), &list);
            assert_equals(&of_list, &renewed(None, &list));
            assert_equals(&renewed(Some(&of_list), &rays), &prepared);
        }
        let hierarchy = prepared.hierarchy.as_ref().unwrap();
        let n_places = hierarchy.n_places_of_rest();
        assert!(n_places >= hierarchy.rest.len() && prepared.n_listed_spheres() == n_places);
        numbers.insert(hierarchy.rest.len());
        keys.insert(prepared.shader_key(Wants::default()));
        if step % 20 == 10 {
            trace(&scene, &rays, WANTS);
        }
        last = Some(prepared);
    }
    println!("close to {numbers:?}");
    assert!(numbers.len() > 5 && keys.len() <= 4, "{} keys for {numbers:?}", keys.len());
}

#[test]
fn any_rays() {
    let mut rng = ChaCha8Rng::seed_from_u64(609);
    let scene = Arc::new(kugelblitz_tests::scene(uniform(&mut rng, 500), vec![]));
    let mut rays: Vec<Ray> = (0..3000)
        .map(|_| {
            let length = 10f64.powf(rng.random_range(-20.0..20.0));
            Ray { origin: 3.0 * in_cube(&mut rng), direction: length * in_cube(&mut rng) }
        })
        .collect();
    for (index, ray) in rays.iter_mut().enumerate() {
        match index % 6 {
            0 => ray.direction[index % 3] = 0.0,
            1 => ray.direction[index % 3] *= 1e-300,
            2 => ray.direction = (-ray.origin).normalize(),
            3 => ray.origin *= 1e6,
            4 => ray.direction = -ray.origin,
            _ => {}
        }
    }
    let truth = Truth::of_list(&scene, &rays, &Control::default()).unwrap();
    let (hits, _) = trace(&scene, &Rays::List(rays), WANTS);
    let against = compare_to_exact(&hits, &truth);
    assert_eq!((against.wrong_ids(), against.t_ulp_max <= 0.501), (0, true), "{against:?}");
    assert!(hits.n_hits() > 500);
}

/// The offset of these rays from the spheres is no f64.
#[test]
fn rays_from_the_other_end_of_f64() {
    let spheres = (0..200).map(|i| sphere(DVec3::new(1.5e308, f64::from(i), 0.0), 0.4)).collect();
    let scene = Arc::new(kugelblitz_tests::scene(spheres, vec![]));
    let origin = DVec3::new(-1.5e308, 7.0, 0.0);
    let rays = vec![Ray { origin, direction: DVec3::X }, Ray { origin, direction: DVec3::NEG_X }];
    let truth = Truth::of_list(&scene, &rays, &Control::default()).unwrap();
    let (hits, _) = trace(&scene, &Rays::List(rays), WANTS);
    assert_eq!(compare_to_exact(&hits, &truth).wrong_ids(), 0, "{hits:?}");
}

/// A ray along an axis through the very edge of a box is not lost to 0 · ∞.
#[test]
fn flat_rays_are_not_lost() {
    let mut rng = ChaCha8Rng::seed_from_u64(611);
    let spheres: Vec<Sphere> = (0..300).map(|_| sphere(in_cube(&mut rng), 0.05)).collect();
    let tree = Tree::new(&spheres, &Control::default()).unwrap();
    for (index, &Sphere { center, radius }) in (0..).zip(&spheres) {
        let l = center - tree.reference;
        for axis in 0..3 {
            let mut direction = DVec3::ZERO;
            direction[axis] = if rng.random() { 1.0 } else { -1.0 };
            let mut origin = l - 5.0 * direction;
            origin[(axis + 1) % 3] += radius;
            let mut visited = Vec::new();
            tree.visit(&TreeRay { origin, direction }, |place| {
                visited.push(tree.order[place]);
                f64::INFINITY
            });
            assert!(visited.contains(&index), "{origin:?} {direction:?} misses {l:?}");
            assert!(visited.len() < 200, "a ray looks at {} of 300", visited.len());
        }
    }
}

/// Rays that touch a sphere where its box does, or pass it by a little, against exact arithmetic: what
/// they hit, each walk shows them.
#[test]
fn rays_that_touch_a_sphere_meet_its_box() {
    let mut rng = ChaCha8Rng::seed_from_u64(614);
    let (mut n_hits, mut n_seen) = (0, 0);
    for case in 0..40 {
        let scale = 10f64.powi(case % 9 - 4);
        let at = in_cube(&mut rng) * 10f64.powi(case % 7 - 1) * scale;
        let spheres: Vec<Sphere> = (0..200)
            .map(|_| sphere(at + in_cube(&mut rng) * scale, scale * rng.random_range(0.001..0.1)))
            .collect();
        let mut aimed = Vec::new();
        for index in 0..200 {
            let Sphere { center, radius } = spheres[index];
            let up = DVec3::AXES[index % 3] * if rng.random() { 1.0 } else { -1.0 };
            let across = up.cross(in_cube(&mut rng)).normalize();
            let off = [0.0, 1e-16, 1e-12, 1e-9][index % 4] * rng.random_range(-1.0..1.0);
            let away = 2f64.powi(rng.random_range(-2..8)) * radius;
            let origin = center + up * (radius * (1.0 + off)) - across * away;
            aimed.push(Ray { origin, direction: across * 2f64.powi(rng.random_range(-3..4)) });
        }
        let scene = Arc::new(kugelblitz_tests::scene(spheres.clone(), vec![]));
        let rays = Rays::List(aimed.clone());
        let prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
        let tree = &prepared.hierarchy.as_ref().unwrap().tree;
        let in_space = prepared.in_space().unwrap().unwrap();
        for (index, ray) in (0..).zip(&aimed) {
            let Sphere { center, radius } = spheres[index as usize];
            let shape = Shape::Sphere { center, radius };
            if visible_root(&ExactRay::new(ray), &shape).is_none() {
                continue;
            }
            n_hits += 1;
            let direction = Scaled::new(ray.direction).rounded();
            let mut seen = vec![];
            tree.visit(&TreeRay { origin: ray.origin - tree.reference, direction }, |place| {
                seen.push(tree.order[place] + 1);
                f64::INFINITY
            });
            assert!(seen.contains(&(index + 1)), "{ray:?} misses {center} {radius}");
            let (record, _) = prepared.coordinates().ray_record(ray);
            let ([origin, way], room) =
                ([record.origin, record.direction].map(Vec3), SlabRoom::f32());
            let slabs = slabs_of(origin, way, room.least_slack, &room);
            let (mut at, mut seen) = (0, vec![]);
            while let Some(node) = in_space.nodes.get(at) {
                let is_met = meets(&slabs, Vec3(node.low), Vec3(node.high), f32::MAX);
                let is_leaf = node.link & IS_LEAF != 0;
                at = if is_met || is_leaf { at + 1 } else { node.link as usize };
                if is_met && is_leaf {
                    seen.push(node.id);
                }
            }
            assert!(seen.contains(&(index + 1)), "{ray:?} misses {center} {radius} in f32");
            n_seen += seen.len();
        }
    }
    println!("{n_hits} hits, {n_seen} spheres looked at");
    assert!(n_hits > 3000 && n_seen < 40 * n_hits);
}

/// A radius of 0 is missed, also where the camera is inside of another sphere.
#[test]
fn a_radius_of_zero_is_missed() {
    let mut rng = ChaCha8Rng::seed_from_u64(613);
    let camera = kugelblitz_tests::camera(DVec3::ZERO, DVec3::new(0.2, 0.1, 1.0));
    for n in [1, 30, 300] {
        let mut spheres: Vec<Sphere> = (0..n).map(|_| sphere(in_cube(&mut rng), 0.0)).collect();
        spheres.push(sphere(DVec3::new(0.0, 0.1, 0.0), 3.0));
        let scene = Arc::new(kugelblitz_tests::scene(spheres, vec![]));
        let pixels = Pixels::whole(View::new(&camera), 24, 16);
        let (hits, _) = trace(&scene, &Rays::Pixels(pixels), WANTS);
        assert_eq!(hits.id, vec![n + 1; pixels.len()], "{n}");
    }
}

/// In a view so narrow that the product of two pixels' sizes is 0, the sphere ahead is seen.
#[test]
fn a_very_narrow_view() {
    let mut spheres: Vec<Sphere> =
        (0..20).map(|i| sphere(DVec3::new(10.0 + f64::from(i), 3.0, 0.0), 0.4)).collect();
    spheres.push(sphere(DVec3::new(0.0, 0.0, -9.0), 2.0));
    let scene = Arc::new(kugelblitz_tests::scene(spheres, vec![]));
    for fov_degrees in [1e-9, 1e-100, 1e-170, 1e-250] {
        let camera = Camera {
            position: DVec3::ZERO,
            look_at: DVec3::NEG_Z,
            up: DVec3::Y,
            projection: Projection::Perspective { fov_degrees },
        };
        let pixels = Pixels::whole(View::new(&camera), 24, 16);
        let (hits, _) = trace(&scene, &Rays::Pixels(pixels), Wants::default());
        assert_eq!(hits.id, vec![21; pixels.len()], "{fov_degrees}");
    }
}

/// Directions of any length, and what the truth rules out of them.
#[test]
fn the_truth_knows_rays_of_any_length() {
    let sphere = sphere(DVec3::new(0.0, 0.9e9, -5e9), 1e9);
    let scene = kugelblitz_tests::scene(vec![sphere], vec![]);
    // Shorter ones would have t beyond f32.
    let rays: Vec<Ray> = (-25..300)
        .map(|k| Ray { origin: DVec3::ZERO, direction: DVec3::NEG_Z * 1.7 * 10f64.powi(k) })
        .collect();
    let truth = Truth::of_list(&scene, &rays, &Control::default()).unwrap();
    assert_eq!(truth.id, vec![1; rays.len()]);
}

/// 10⁵ rays for each number of spheres; `KUGELBLITZ_SPHERES` is the largest.
#[test]
#[ignore = "takes minutes"]
fn many_rays_into_large_clouds() {
    let most = std::env::var("KUGELBLITZ_SPHERES").map_or(100_000, |n| n.parse().unwrap());
    let mut rng = ChaCha8Rng::seed_from_u64(612);
    let mut n = 1000;
    while n <= most {
        let scene = Arc::new(kugelblitz_tests::scene(uniform(&mut rng, n), vec![]));
        let pixels = Pixels::whole(View::new(&looking_at_the_origin(4.0)), 1920, 1080);
        let (hits, _) = trace(&scene, &Rays::Pixels(pixels), Wants::default());
        let index = sample(pixels.len(), 100_000, 5);
        let truth = Truth::of_pixels(&scene, &pixels, index, &Control::default()).unwrap();
        let against = compare_to_exact(&hits, &truth);
        println!("{n} spheres: {:?} {against:?}", hits.counts);
        assert_eq!(against.wrong_ids(), 0);
        n *= 10;
    }
}
