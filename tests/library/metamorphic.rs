//! What must not change a picture does not: moving, scaling and turning the whole scene, the order
//! of the objects, and how the picture is cut into parts.

use std::sync::Arc;

use glam::{DVec3, Vec3Swizzles as _, dvec3};
use kugelblitz::compare::distance;
use kugelblitz::prepare::FEW_SPHERES;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays};
use kugelblitz_tests::{
    camera, cases, gpu, in_cube, judge, log_uniform, plane, root, scene, sphere,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A scene with rays.
#[derive(Clone)]
struct World {
    name: String,
    scene: Scene,
    rays: Rays,
}

/// The nearest multiple of 2⁻¹⁰: short enough to be moved by 10¹² without rounding.
fn short(x: f64) -> f64 {
    (x * 1024.0).round() / 1024.0
}

fn short3(v: DVec3) -> DVec3 {
    dvec3(short(v.x), short(v.y), short(v.z))
}

impl World {
    fn hits(&self, on_gpu: bool) -> Hits {
        let gpu = on_gpu.then(gpu);
        trace(&Arc::new(self.scene.clone()), &self.rays, gpu.as_ref())
    }

    /// All points, directions and normals, and lengths, put through these maps.
    fn map(
        &self,
        point: impl Fn(DVec3) -> DVec3,
        vector: impl Fn(DVec3) -> DVec3,
        length: impl Fn(f64) -> f64,
    ) -> World {
        let mut world = self.clone();
        for sphere in world.scene.spheres.iter_mut() {
            sphere.center = point(sphere.center);
            sphere.radius = length(sphere.radius);
        }
        for plane in &mut world.scene.planes {
            plane.point = point(plane.point);
            plane.normal = vector(plane.normal);
        }
        match &mut world.rays {
            Rays::Pixels(pixels) => {
                let view = &mut pixels.view;
                view.position = point(view.position);
                view.forward = vector(view.forward);
                view.right = vector(view.right);
                view.true_up = vector(view.true_up);
            }
            Rays::List(rays) => {
                for ray in rays {
                    ray.origin = point(ray.origin);
                    ray.direction = vector(ray.direction);
                }
            }
        }
        world
    }
}

fn trace(scene: &Arc<Scene>, rays: &Rays, gpu: Option<&Arc<kugelblitz::gpu::Gpu>>) -> Hits {
    judge::trace(scene, Kernel::Certified, rays, gpu)
}

fn same(x: f64) -> f64 {
    x
}

fn same3(v: DVec3) -> DVec3 {
    v
}

/// Figures 1 and 2 and random scenes, seen by a camera and by lists of rays.
fn worlds() -> Vec<World> {
    let seed = cases::seed();
    println!("seed {seed}: KUGELBLITZ_SEED={seed} repeats this run");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut worlds = Vec::new();
    for name in ["figure1.toml", "figure2.toml"] {
        let path = root().join("scenes").join(name);
        let scene = read_scene(&path).unwrap_or_else(|error| panic!("{error}"));
        let view = View::new(scene.camera.as_ref().expect("a camera"));
        worlds.push(World {
            name: name.to_string(),
            scene,
            rays: Rays::Pixels(Pixels::whole(view, 161, 91)),
        });
    }
    for n_planes in 0..3 {
        let spheres: Vec<_> = (0..15)
            .map(|_| {
                let at = log_uniform(&mut rng, 1.0, 300.0).abs();
                sphere(in_cube(&mut rng) * at, at * rng.random_range(0.02..0.7))
            })
            .collect();
        let planes = (0..n_planes)
            .map(|_| plane(in_cube(&mut rng) * 30.0, in_cube(&mut rng) * 8.0))
            .collect();
        // Toward a sphere, so that something is hit.
        let view = View::new(&camera(in_cube(&mut rng), spheres[0].center));
        let scene = scene(spheres, planes);
        let list = (0..15_000)
            .map(|_| Ray {
                origin: in_cube(&mut rng) * 5.0,
                direction: in_cube(&mut rng) * log_uniform(&mut rng, 1e-3, 1e3),
            })
            .collect();
        let pixels = Rays::Pixels(Pixels::whole(view, 161, 91));
        for (source, rays) in [("pixels", pixels), ("list", Rays::List(list))] {
            let name = format!("random with {n_planes} planes, {source}");
            worlds.push(World { name, scene: scene.clone(), rays });
        }
    }
    // Points and radii only: directions are never moved or scaled together with them.
    worlds.iter().map(|world| world.map(short3, same3, short)).collect()
}

/// Equal ids; `t` times `factor` bit by bit; normals turned by `turn`, to f32 rounding.
fn assert_same(
    what: &str,
    before: &Hits,
    after: &Hits,
    factor: f64,
    turn: impl Fn([f32; 3]) -> [f32; 3],
) {
    assert_eq!(before.id.len(), after.id.len(), "{what}");
    assert!(before.n_hits() > 0, "{what}: nothing is hit");
    for i in 0..before.id.len() {
        assert_eq!(before.id[i], after.id[i], "id of ray {i}, {what}");
        let t = (f64::from(before.t[i]) * factor) as f32;
        assert_eq!(t.to_bits(), after.t[i].to_bits(), "t of ray {i}, {what}");
        let off = distance(turn(before.normal[i]), after.normal[i]);
        assert!(off <= 2f64.powi(-22), "normal of ray {i} by {off:e}, {what}");
    }
}

fn moves_exactly(x: f64, by: f64) -> bool {
    let moved = x + by;
    moved - by == x && moved - x == by
}

#[test]
fn moving_everything_changes_nothing() {
    for world in worlds() {
        let before = [false, true].map(|on_gpu| world.hits(on_gpu));
        for (k, exponent) in (3..=12).step_by(3).enumerate() {
            let size = 10f64.powi(exponent);
            let by = [DVec3::X, dvec3(1.0, -1.0, 0.0), dvec3(-1.0, 1.0, 1.0)][k % 3] * size;
            let moved = world.map(
                |p| {
                    for axis in 0..3 {
                        assert!(moves_exactly(p[axis], by[axis]), "{p} by {by}");
                    }
                    p + by
                },
                same3,
                same,
            );
            let what = format!("{} moved by {by}", world.name);
            assert_same(&what, &before[0], &moved.hits(false), 1.0, |n| n);
            if exponent > 6 {
                assert_same(&what, &before[1], &moved.hits(true), 1.0, |n| n);
            }
        }
    }
}

#[test]
fn scaling_by_powers_of_two_scales_t() {
    for world in worlds() {
        let before = world.hits(false);
        for exponent in [-40, -17, 1, 40] {
            let factor = 2f64.powi(exponent);
            let scaled = world.map(|p| p * factor, same3, |r| r * factor);
            let what = format!("{} times 2^{exponent}", world.name);
            let on_gpu = exponent.abs() == 40;
            assert_same(&what, &before, &scaled.hits(on_gpu), factor, |n| n);
            if let Rays::List(_) = world.rays {
                // Directions as well (and normals, which may have any length): the same `t`.
                let scaled = world.map(|p| p * factor, |d| d * factor, |r| r * factor);
                assert_same(&what, &before, &scaled.hits(false), 1.0, |n| n);
            }
        }
    }
}

#[test]
fn turning_by_quarters_turns_normals_only() {
    type Turn = (&'static str, fn(DVec3) -> DVec3);
    let turns: [Turn; 5] = [
        ("x → y → z", |v| v.zxy()),
        ("x → z → y", |v| v.yzx()),
        ("quarter about z", |v| dvec3(-v.y, v.x, v.z)),
        ("half about y", |v| dvec3(-v.x, v.y, -v.z)),
        ("mirror", |v| dvec3(v.x, -v.y, v.z)),
    ];
    for world in worlds() {
        let before = world.hits(false);
        for (name, turn) in turns {
            let turned = world.map(turn, turn, same);
            let turn32 = |n: [f32; 3]| turn(DVec3::from(n.map(f64::from))).as_vec3().to_array();
            let what = format!("{}, {name}", world.name);
            let on_gpu = name.starts_with("quarter");
            assert_same(&what, &before, &turned.hits(on_gpu), 1.0, turn32);
        }
    }
}

#[test]
fn the_order_of_the_objects_only_names_them() {
    for (seed, world) in worlds().into_iter().enumerate() {
        let mut rng = ChaCha8Rng::seed_from_u64(seed as u64);
        let n = world.scene.spheres.len();
        let mut order: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            order.swap(i, rng.random_range(0..=i));
        }
        let mut permuted = world.clone();
        permuted.scene.spheres = order.iter().map(|&i| world.scene.spheres[i]).collect();
        permuted.scene.planes.reverse();
        let mut before = world.hits(false);
        let (n_planes, n) = (world.scene.planes.len() as u32, n as u32);
        for id in &mut before.id {
            *id = match *id {
                0 => 0,
                old if old <= n => {
                    order.iter().position(|&i| i as u32 + 1 == old).unwrap() as u32 + 1
                }
                old => n + (n_planes - (old - n)) + 1,
            };
        }
        for on_gpu in [false, true] {
            assert_same(&world.name, &before, &permuted.hits(on_gpu), 1.0, |n| n);
        }
    }
}

/// Of objects that coincide the lowest id is seen, however they are ordered.
#[test]
fn ties_go_to_the_lowest_id() {
    for mut world in worlds() {
        let ids = world.hits(false).id;
        let n = world.scene.spheres.len();
        // Each sphere again, in the opposite order: the copies' ids are the higher ones.
        let spheres = &world.scene.spheres;
        world.scene.spheres = spheres.iter().chain(spheres.iter().rev()).copied().collect();
        let planes = world.scene.planes.clone();
        world.scene.planes.extend(planes);
        for on_gpu in [false, true] {
            let doubled = world.hits(on_gpu);
            assert_eq!(doubled.id.len(), ids.len(), "{}", world.name);
            assert!(doubled.n_hits() > 0, "{}: nothing is hit", world.name);
            for (i, (&id, &doubled)) in ids.iter().zip(&doubled.id).enumerate() {
                let expected = if id as usize > n { id + n as u32 } else { id };
                assert_eq!(doubled, expected, "ray {i}, {}", world.name);
            }
            // A device's f32 decides no tie. The CPU and a hierarchy leave out what equals an earlier sphere.
            if on_gpu && world.scene.spheres.len() <= FEW_SPHERES {
                let others = doubled.counts.f64 + doubled.counts.exact;
                assert!(others >= doubled.n_hits(), "{}", world.name);
            }
        }
    }
}

fn part(hits: &Hits, index: impl Iterator<Item = usize> + Clone) -> Hits {
    Hits {
        id: index.clone().map(|i| hits.id[i]).collect(),
        t: index.clone().map(|i| hits.t[i]).collect(),
        normal: index.clone().map(|i| hits.normal[i]).collect(),
        level: index.map(|i| hits.level[i]).collect(),
        ..Hits::default()
    }
}

fn assert_equal(what: &str, expected: &Hits, found: &Hits) {
    assert!(expected.id == found.id, "ids, {what}");
    let bits = |hits: &Hits| hits.t.iter().map(|t| t.to_bits()).collect::<Vec<_>>();
    assert!(bits(expected) == bits(found), "t, {what}");
    assert!(expected.normal == found.normal, "normals, {what}");
    assert!(expected.level == found.level, "levels, {what}");
}

#[test]
fn parts_of_a_picture_are_parts_of_the_whole() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for world in worlds() {
        let Rays::Pixels(whole) = world.rays else { continue };
        for on_gpu in [false, true] {
            let hits = world.hits(on_gpu);
            for cut in 0..if on_gpu { 4 } else { 20 } {
                let mut crop = whole;
                match cut {
                    // A row, a column, a pixel.
                    0 => (crop.y, crop.height) = (rng.random_range(0..91), 1),
                    1 => (crop.x, crop.width) = (rng.random_range(0..161), 1),
                    2 => {
                        (crop.x, crop.width) = (rng.random_range(0..161), 1);
                        (crop.y, crop.height) = (rng.random_range(0..91), 1);
                    }
                    _ => {
                        crop.x = rng.random_range(0..161);
                        crop.y = rng.random_range(0..91);
                        crop.width = rng.random_range(1..=161 - crop.x);
                        crop.height = rng.random_range(1..=91 - crop.y);
                    }
                }
                let index = (0..crop.len()).map(|i| {
                    let (x, y) = crop.xy(i);
                    (y * 161 + x) as usize
                });
                let cropped = World { rays: Rays::Pixels(crop), ..world.clone() }.hits(on_gpu);
                let what = format!("{}, {crop:?}", world.name);
                assert_equal(&what, &part(&hits, index), &cropped);
            }
        }
    }
}

#[test]
fn parts_of_a_list_are_parts_of_the_whole() {
    for world in worlds() {
        let Rays::List(rays) = &world.rays else { continue };
        for on_gpu in [false, true] {
            let hits = world.hits(on_gpu);
            // Backwards, and a part: other chunks, and another reference point.
            let order: Vec<usize> = (0..rays.len()).rev().step_by(3).collect();
            let some = order.iter().map(|&i| rays[i]).collect();
            let mut found = World { rays: Rays::List(some), ..world.clone() }.hits(on_gpu);
            let mut expected = part(&hits, order.into_iter());
            // The stage may be another one: the filter's bounds depend on the reference point.
            expected.level.clear();
            found.level.clear();
            assert_equal(&world.name, &expected, &found);
        }
    }
}
