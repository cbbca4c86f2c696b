//! Many spheres: what a tree shows a ray, what of it is made again for another camera, and clouds too large for the matrix.

use std::collections::HashSet;
use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::bounds::PIXELS;
use kugelblitz::bvh::{Beam, FlatBox, IS_LEAF, MOST_BOXES, Traversal, Visitor};
use kugelblitz::device::Device;
use kugelblitz::exact::{ExactRay, visible_hit};
use kugelblitz::gpu::slabs::{LEAST_SLACK, Slabs};
use kugelblitz::num;
use kugelblitz::num::{UNDECIDED, V3};
use kugelblitz::prepare::{Prepared, ScaledInteger};
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, WorldRay};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Object, Projection, Sphere};
use kugelblitz::tracer::Tracer;
use kugelblitz_judge::compare::compare;
use kugelblitz_judge::verify::{Truth, compare_to_exact, sample};
use kugelblitz_tests::twins::{Twin, propose_alone};
use kugelblitz_tests::{camera, gpu, in_cube, scene, sphere, traced};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A camera that flies through a cloud is close to another number of spheres at each place, but needs few shaders. What is made
/// again for it is what is made anew.
#[test]
fn a_flight_through_a_cloud_needs_few_shaders() {
    let mut rng = ChaCha8Rng::seed_from_u64(614);
    // They touch the way of the camera here and there.
    let spheres = (0..3000).map(|_| {
        let (turned, radius) = (rng.random_range(0.0..TAU), rng.random_range(0.05..0.2));
        let aside = DVec3::new(turned.cos(), turned.sin(), 0.0) * radius;
        sphere(DVec3::new(0.1, 0.05, rng.random_range(-1.0..1.0)) + aside, radius)
    });
    let scene = Arc::new(scene(spheres.collect(), vec![]));
    let renewed = |old: Option<&Prepared>, rays: &Rays| {
        let (scene, control) = (Arc::clone(&scene), Control::default());
        Prepared::renewed(old, scene, Kernel::Certified, rays, &control).unwrap()
    };
    let seen = |prepared: Prepared, rays: &Rays| {
        let mut hits = Hits::default();
        let wants = Outputs { level: true, ..Outputs::default() };
        let mut tracer = Tracer::on_cpu(Arc::new(prepared), wants);
        tracer.trace(rays, &Control::default(), &mut hits).unwrap();
        (hits.id, hits.level)
    };
    let (mut last, mut numbers, mut keys) = (None, HashSet::new(), HashSet::new());
    for step in 0..60 {
        let along = f64::from(step) / 30.0 - 1.0;
        let camera = camera(DVec3::new(0.1, 0.05, along), DVec3::new(0.3, 0.2, 3.0));
        let rays = Rays::Pixels(Pixels::whole(View::new(&camera), 24, 16));
        let prepared = renewed(last.as_ref(), &rays);
        let anew = renewed(None, &rays);
        assert_eq!(prepared.objects.bytes(), anew.objects.bytes());
        let hierarchy = prepared.hierarchy.as_ref().unwrap();
        assert_eq!(hierarchy.leaves.rest, anew.hierarchy.as_ref().unwrap().leaves.rest);
        numbers.insert(hierarchy.leaves.rest.len());
        keys.insert(prepared.shader_key(Outputs::default()));
        assert_eq!(seen(prepared.clone(), &rays), seen(anew, &rays));
        if step % 20 == 0 {
            let list = Rays::List(vec![WorldRay { origin: DVec3::Z, direction: DVec3::X }]);
            let of_list = renewed(Some(&prepared), &list);
            assert_eq!(seen(of_list, &list), seen(renewed(None, &list), &list));
        }
        last = Some(prepared);
    }
    println!("close to {numbers:?}");
    assert!(numbers.len() > 5 && keys.len() <= 4, "{} keys for {numbers:?}", keys.len());
}

/// Notes the places that it is shown.
#[derive(Default)]
struct All(Vec<u32>);

impl Visitor for All {
    fn last(&self) -> f32 {
        f32::INFINITY
    }

    fn see(&mut self, place: u32) {
        self.0.push(place);
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
            aimed.push(WorldRay { origin, direction: across * 2f64.powi(rng.random_range(-3..4)) });
        }
        let scene = Arc::new(scene(spheres.clone(), vec![]));
        let rays = Rays::List(aimed.clone());
        let prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
        let bvh = &prepared.hierarchy.as_ref().unwrap().bvh;
        let in_space = prepared.in_space().unwrap().unwrap();
        for (index, ray) in (0..).zip(&aimed) {
            let Sphere { center, radius } = spheres[index as usize];
            let object = Object::Sphere(&spheres[index as usize]);
            if visible_hit(&ExactRay::new(ray), index + 1, object).is_none() {
                continue;
            }
            n_hits += 1;
            let (direction, mut seen) =
                (ScaledInteger::new(ray.direction).rounded(), All::default());
            let from = ray.origin - bvh.reference;
            let room = from.abs() * f64::EPSILON;
            let corners = [from - room, from + room];
            let beam = Beam::new(corners, [direction; 2], bvh.end(corners));
            Traversal::default().all(bvh, bvh.root(), beam, &mut seen);
            let is_shown = seen.0.iter().any(|&place| bvh.ids[place as usize] == index + 1);
            assert!(is_shown, "{ray:?} misses {center} {radius}");
            let (origin, way, _) = prepared.coordinates().ray(ray);
            let slabs =
                Slabs::new(&num::Ray::<f32>::new(V3::lit(origin), V3::lit(way)), LEAST_SLACK);
            let (mut at, mut seen) = (0, vec![]);
            while let Some(node) = in_space.boxes.get(at) {
                let is_met = slabs.between(V3(node.low), V3(node.high)).is_within(f32::MAX);
                let is_leaf = node.link & IS_LEAF != 0;
                at += if is_met || is_leaf { 1 } else { node.link as usize };
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

/// A device leaves rays open that meet the boxes of very many spheres and none of these; the CPU finds what they see.
#[test]
fn rays_into_nested_spheres_come_to_an_end() {
    let n = MOST_BOXES + 2000;
    let radii = (0..n).map(|k| 1.0 + f64::from(k) * 1e-5);
    let scene = Arc::new(scene(radii.map(|radius| sphere(DVec3::ZERO, radius)).collect(), vec![]));
    let projection = Projection::Orthographic { height: 2.0 };
    let camera = Camera { projection, ..camera(DVec3::Z * 3.0, DVec3::ZERO) };
    let rays = Rays::Pixels(Pixels::whole(View::new(&camera), 8, 8));
    let prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
    let prepared = Arc::new(prepared);
    let mut tracer = Device::Gpu(gpu()).tracer(&prepared, Outputs::default()).unwrap().tracer;
    let (mut hits, corner, middle) = (Hits::default(), 0, 8 * 4 + 4);
    let backend = tracer.backend().unwrap();
    assert!(backend.propose(&rays, &Control::default(), &mut hits).unwrap().is_some());
    let twin = propose_alone(&prepared, &rays).unwrap();
    assert_eq!([hits.id[corner], twin[corner]], [UNDECIDED; 2]);
    let [on_cpu, on_gpu] =
        [None, Some(&gpu())].map(|device| traced(&scene, Kernel::Certified, &rays, device));
    assert!(compare(&on_gpu, &on_cpu).is_equal());
    assert_eq!([on_cpu.id[corner], on_cpu.id[middle]], [0, n]);
}

/// Ids, and `t` to f32's last digit, of a sample of the pixels of so many spheres, and the same on the device.
fn check_cloud(n: usize, radius: f64, camera: &Camera, n_judged: usize) {
    let mut rng = ChaCha8Rng::seed_from_u64(612);
    let spheres = (0..n).map(|_| sphere(in_cube(&mut rng), radius)).collect();
    let scene = Arc::new(scene(spheres, vec![]));
    let pixels = Pixels::whole(View::new(camera), 640, 360);
    let rays = Rays::Pixels(pixels);
    let [on_cpu, on_gpu] =
        [None, Some(&gpu())].map(|device| traced(&scene, Kernel::Certified, &rays, device));
    assert!(compare(&on_gpu, &on_cpu).is_equal());
    let chosen = sample(pixels.len(), n_judged, 5);
    let truth = Truth::of_rays(&scene, &rays, chosen, &Control::default()).unwrap();
    let against = compare_to_exact(&on_cpu, &truth);
    println!("{n} spheres: {:?}, {} hits", on_cpu.counts, on_cpu.n_hits());
    assert!(against.wrong_ids() == 0 && against.t_ulp_max <= 0.501, "{against:?}");
    assert!(on_cpu.counts.f32 as f64 > 0.97 * rays.len() as f64, "{:?}", on_cpu.counts);
}

fn parallel() -> Camera {
    let projection = Projection::Orthographic { height: 2.4 };
    Camera { projection, ..camera(DVec3::new(0.7, 0.4, 3.0), DVec3::ZERO) }
}

#[test]
fn a_million_spheres() {
    check_cloud(1_000_000, 0.006, &parallel(), 64);
}

/// `KUGELBLITZ_SPHERES` is the largest number.
#[test]
#[ignore = "takes minutes"]
fn many_rays_into_large_clouds() {
    let most = std::env::var("KUGELBLITZ_SPHERES").map_or(100_000, |n| n.parse().unwrap());
    for camera in [parallel(), camera(DVec3::new(1.1, 0.7, 3.8), DVec3::ZERO)] {
        for n in (3..).map(|k| 10usize.pow(k)).take_while(|n| *n <= most) {
            check_cloud(n, 0.6 * (n as f64).powf(-1.0 / 3.0), &camera, 100_000);
        }
    }
}

/// Spheres of a cloud in a cube of side 2, and a camera that frames it.
fn cloud_with(more: &[Sphere]) -> (Prepared, Rays) {
    let mut rng = ChaCha8Rng::seed_from_u64(741);
    let spheres = (0..5000).map(|_| sphere(in_cube(&mut rng), rng.random_range(0.01..0.03)));
    let scene = Arc::new(scene(spheres.chain(more.iter().copied()).collect(), vec![]));
    let camera = camera(DVec3::new(2.6, 1.8, 3.4), DVec3::ZERO);
    let rays = Rays::Pixels(Pixels::whole(View::new(&camera), 64, 36));
    (Prepared::new(scene, Kernel::Certified, &rays).unwrap(), rays)
}

/// The boxes that all rays visit on a device, and the rays that it leaves undecided.
fn costs((prepared, rays): &(Prepared, Rays)) -> [u64; 2] {
    let twin = Twin::new(prepared).unwrap();
    let n_boxes = |index| u64::from(twin.n_boxes(&twin.ray(rays, index)));
    let undecided =
        propose_alone(prepared, rays).unwrap().iter().filter(|&&id| id == UNDECIDED).count();
    [(0..rays.len()).map(n_boxes).sum(), undecided as u64]
}

/// The error of a ray's direction grows with the distance, so each box needs a slack for its distance. With the slack of the farthest
/// box for all, each ray visited all spheres.
#[test]
fn one_far_or_huge_sphere_costs_a_device_little() {
    let alone = costs(&cloud_with(&[]));
    println!("alone: {alone:?}");
    for exponent in [2, 4, 6, 8, 10] {
        let far = 10f64.powi(exponent);
        for (name, outlier) in [
            ("far to the side", sphere(DVec3::X * far, 0.5)),
            ("far behind", sphere(DVec3::new(-0.7, -0.6, -1.0) * far, 1e-3 * far)),
            ("ground", sphere(DVec3::Y * (-1.1 - far), far)),
        ] {
            let with = costs(&cloud_with(&[outlier]));
            println!("{name} {far:e}: {with:?}");
            assert!(with[0] <= 3 * alone[0], "{name} {far:e}: {with:?} boxes, not {alone:?}");
            assert!(
                with[1] <= 3 * alone[1] + 23,
                "{name} {far:e}: {with:?} undecided, not {alone:?}"
            );
        }
    }
}

/// Tiny spheres on the exact rays of pixels, at distances from 10⁻³ to 10⁹: the device's ray of a pixel has to meet the box of
/// its sphere, and without the slack for the error of directions some do not.
#[test]
fn the_rays_of_pixels_meet_boxes_on_them() {
    let mut rng = ChaCha8Rng::seed_from_u64(742);
    let (mut lost, mut n_rays) = ([0, 0], 0);
    for _ in 0..8 {
        let camera = camera(in_cube(&mut rng) * 10.0, in_cube(&mut rng));
        let pixels = Pixels::whole(View::new(&camera), 64, 36);
        let rays = Rays::Pixels(pixels);
        let ray = |index| {
            let (x, y) = pixels.xy(index);
            pixels.ray(x, y)
        };
        let on_ray = |index| {
            let WorldRay { origin, direction } = ray(index);
            let distance = 10f64.powf(rng.random_range(-3.0..9.0));
            sphere(origin + direction.normalize() * distance, 1e-13 * distance)
        };
        let scene = Arc::new(scene((0..rays.len()).map(on_ray).collect(), vec![]));
        let prepared = Prepared::new(scene, Kernel::Certified, &rays).unwrap();
        let bvh = &prepared.hierarchy.as_ref().unwrap().bvh;
        let twin = Twin::new(&prepared).unwrap();
        let with_slack = prepared.in_space().unwrap().unwrap().boxes;
        let boxes = [0.0, 0.5].map(|share| {
            let turn = share * PIXELS.direction * f64::from(f32::EPSILON) / 2.0;
            bvh.boxes_from(prepared.reference, turn, |_| 0.0).unwrap()
        });
        for index in 0..rays.len() {
            let slabs = Slabs::new(&twin.ray(&rays, index), LEAST_SLACK);
            let is_met = |boxes: &[FlatBox]| {
                let id = index as u32 + 1;
                let leaf = boxes.iter().find(|leaf| leaf.link & IS_LEAF != 0 && leaf.id == id);
                leaf.is_some_and(|leaf| {
                    slabs.between(V3(leaf.low), V3(leaf.high)).is_within(f32::MAX)
                })
            };
            assert!(is_met(&with_slack), "{:?}", ray(index));
            for (lost, boxes) in lost.iter_mut().zip(&boxes) {
                *lost += u32::from(!is_met(boxes));
            }
            n_rays += 1;
        }
    }
    println!("{lost:?} of {n_rays} lost without and with half of the slack");
    assert!(lost[0] > 40, "{lost:?}");
}
