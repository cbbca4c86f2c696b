//! No operation of the certified shaders takes or gives ∞ or NaN, which Vulkan lets a compiler
//! assume away; neither for objects and rays at the ends of the range, nor for those beyond it.
//!
//! The shaders run here as naga understands them, with a look at every float, and must propose what
//! their Rust twin proposes.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::bvh::REACH;
use kugelblitz::control::Control;
use kugelblitz::gpu::slabs::LEAST_SLACK;
use kugelblitz::gpu::{Layout, RayRecord, compile};
use kugelblitz::kernel::Float;
use kugelblitz::prepare::{InSpace, LISTED_SPHERES, Objects, Prepared};
use kugelblitz::rays::{Frame, Lens, Pixels, View};
use kugelblitz::scene::{Camera, Plane, Projection, Scene, Sphere};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::twins::propose_alone;
use kugelblitz_tests::wgsl::{Machine, Value};
use kugelblitz_tests::{in_cube, plane, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What one picture or list of rays showed.
#[derive(Debug, Default)]
struct Found {
    not_finite: Vec<String>,
    /// Float operations.
    operations: u64,
    proposals: Vec<u32>,
}

/// Four words each.
fn texels(bytes: &[u8]) -> Value {
    let words =
        bytes.chunks_exact(4).map(|w| Value::U32(u32::from_le_bytes(w.try_into().unwrap())));
    let words: Vec<Value> = words.collect();
    Value::Parts(words.chunks_exact(4).map(|texel| Value::Parts(texel.to_vec())).collect())
}

/// Runs the shader of a prepared scene for all rays.
fn run(prepared: &Prepared, rays: &Rays) -> Found {
    let key = prepared.shader_key(Wants::default());
    let shader = compile(&key).unwrap_or_else(|error| panic!("{error}"));
    let module = &shader.module;
    let ty = |name: &str| {
        let global = module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some(name));
        global.map(|(_, variable)| variable.ty)
    };
    let mut globals = HashMap::new();
    let (spheres, planes) = prepared.objects.bytes();
    for (name, bytes) in [("spheres", spheres), ("planes", planes)] {
        if let Some(ty) = ty(name) {
            globals.insert(name, Machine::decode(module, ty, bytes));
        }
    }
    let mut width = rays.len();
    let mut of_camera: HashMap<&str, Value> = HashMap::new();
    match rays {
        Rays::Pixels(pixels) => {
            width = pixels.width as usize;
            let camera = Frame::<f32>::of_pixels(pixels);
            let (i, j) = pixels.offset2(pixels.x, pixels.y);
            of_camera.insert("forward", Value::vector(camera.forward.0));
            of_camera.insert("right", Value::vector(camera.right.0));
            of_camera.insert("true_up", Value::vector(camera.true_up.0));
            of_camera.insert("step", Value::F32(1.0));
            of_camera.insert("offset_i", Value::I32(i as i32));
            of_camera.insert("offset_j", Value::I32(j as i32));
        }
        Rays::List(list) => {
            let record = |ray| RayRecord::new(prepared.coordinates(), ray).bytes(Float::F32);
            let bytes: Vec<u8> = list.iter().flat_map(record).collect();
            globals.insert("rays", Machine::decode(module, ty("rays").unwrap(), &bytes));
        }
    }
    of_camera.insert("n_spheres", Value::U32(prepared.scene.spheres.len() as u32));
    of_camera.insert("n_rays", Value::U32(rays.len() as u32));
    of_camera.insert("width", Value::U32(width as u32));
    let params = &module.types[ty("params").unwrap()].inner;
    let naga::TypeInner::Struct { members, .. } = params else { panic!("the parameters") };
    let member = |m: &naga::StructMember| {
        let given = of_camera.get(m.name.as_deref().unwrap());
        // The others are not read.
        given.cloned().unwrap_or_else(|| Value::vector([0.0; 3]))
    };
    globals.insert("params", Value::Parts(members.iter().map(member).collect()));
    globals.insert("ids", Value::Parts(vec![Value::U32(7); rays.len()]));
    if let Some(hierarchy) = &prepared.hierarchy {
        let InSpace { boxes, beside } = prepared.in_space().unwrap().expect("a tree");
        let mut rest: Vec<[u32; 4]> = hierarchy.rest.iter().map(|&id| [id, 0, 0, 0]).collect();
        rest.resize(hierarchy.n_places_of_rest(), [0; 4]);
        let texels_of_boxes = [bytemuck::cast_slice(&boxes), bytemuck::cast_slice(&rest)].concat();
        globals.insert("boxes", texels(&texels_of_boxes));
        globals.insert("leaves", texels(bytemuck::cast_slice(&hierarchy.leaves.words())));
        let beside = Value::F32(LEAST_SLACK + beside);
        globals.insert("walk", Value::Parts(vec![Value::U32(boxes.len() as u32), beside]));
    }
    let mut machine = Machine::new(module, &globals);
    for index in 0..rays.len() {
        let [x, y] = [index % width, index / width].map(|k| Value::U32(k as u32));
        machine.enter(vec![Value::Parts(vec![x, y, Value::U32(0)])]);
    }
    let Value::Parts(ids) = machine.global("ids") else { panic!("no ids") };
    let id = |id: &Value| match id {
        Value::U32(id) => *id,
        other => panic!("{other:?}"),
    };
    let proposals = ids.iter().map(id).collect();
    Found { not_finite: machine.not_finite, operations: machine.operations, proposals }
}

/// Runs, compares with the twin, and returns the number of float operations.
fn check(scene: &Arc<Scene>, rays: &Rays) -> (u64, bool) {
    let prepared = Prepared::new(Arc::clone(scene), Kernel::Certified, rays).unwrap();
    let has_no_way = prepared.hierarchy.is_some() && prepared.in_space().unwrap().is_none();
    if has_no_way || !prepared.in_range {
        return (0, false);
    }
    let found = run(&prepared, rays);
    let what = || format!("{:?} {:?} {rays:?}", scene.spheres, scene.planes);
    if let Some(first) = found.not_finite.first() {
        panic!("{} operations, the first: {first}; {}", found.not_finite.len(), what());
    }
    assert_eq!(found.proposals, propose_alone(&prepared, rays).unwrap(), "{}", what());
    (found.operations, prepared.hierarchy.is_some())
}

/// `2ˣ` for a whole `x` between these, or a few units beside it.
fn power(rng: &mut ChaCha8Rng, low: i32, high: i32) -> f64 {
    let power = 2f64.powi(rng.random_range(low..=high));
    match rng.random_range(0..3) {
        0 => power,
        1 => power * (1.0 + f64::from(rng.random_range(-4..=4)) * 2f64.powi(-24)),
        _ => power * rng.random_range(1.0..2.0),
    }
}

fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
    match rng.random_range(0..3) {
        0 => DVec3::AXES[rng.random_range(0..3)] * if rng.random() { 1.0 } else { -1.0 },
        _ => in_cube(rng).normalize_or(DVec3::X),
    }
}

/// A size at an end of the range, beyond it, or ordinary.
fn size(rng: &mut ChaCha8Rng) -> f64 {
    match rng.random_range(0..8) {
        0 => power(rng, -41, -38),
        1 => power(rng, 57, 61),
        2 => power(rng, -1074, 1022),
        3 => power(rng, -130, 130),
        _ => power(rng, -4, 4),
    }
}

fn any_sphere(rng: &mut ChaCha8Rng, eye: DVec3) -> Sphere {
    let mut radius = size(rng);
    let toward = unit(rng);
    let distance = match rng.random_range(0..6) {
        0 => radius,
        1 => radius * (1.0 + power(rng, -52, -1)),
        2 => radius * (1.0 - power(rng, -52, -1)).abs(),
        3 => radius * power(rng, 0, 30),
        4 => 0.0,
        _ => size(rng),
    };
    if rng.random_bool(0.05) {
        radius = 0.0;
    }
    let center = eye + toward * distance;
    if center.is_finite() { sphere(center, radius) } else { sphere(eye, radius) }
}

fn any_plane(rng: &mut ChaCha8Rng, eye: DVec3) -> Plane {
    let normal = unit(rng) * size(rng);
    let across = normal.normalize_or(DVec3::Z).any_orthonormal_vector();
    let point = match rng.random_range(0..4) {
        0 => eye,
        1 => eye + across * size(rng),
        2 => eye + across + unit(rng) * power(rng, -130, -20),
        _ => eye + unit(rng) * size(rng),
    };
    let normal = if normal == DVec3::ZERO { DVec3::Y } else { normal };
    plane(if point.is_finite() { point } else { eye }, normal)
}

/// With more than a few spheres, none is so far away that a device has no slabs for it.
fn any_scene(rng: &mut ChaCha8Rng, eye: DVec3, most_spheres: usize) -> Arc<Scene> {
    let spheres = (0..rng.random_range(0..=most_spheres)).map(|_| any_sphere(rng, eye));
    let is_near = |sphere: &Sphere| {
        most_spheres <= 4 || sphere.center.distance(eye) + sphere.radius < REACH / 8.0
    };
    let spheres = spheres.filter(is_near).collect();
    let planes = (0..rng.random_range(0..3)).map(|_| any_plane(rng, eye)).collect();
    Arc::new(kugelblitz_tests::scene(spheres, planes))
}

fn any_eye(rng: &mut ChaCha8Rng) -> DVec3 {
    match rng.random_range(0..3) {
        0 => DVec3::ZERO,
        1 => unit(rng) * power(rng, -3, 3),
        _ => unit(rng) * power(rng, 10, 50),
    }
}

#[test]
fn pictures_have_only_finite_numbers() {
    finite_pictures(1171, Lens::Perspective);
}

#[test]
fn orthographic_pictures_have_only_finite_numbers() {
    finite_pictures(1173, Lens::Orthographic);
}

fn finite_pictures(seed: u64, lens: Lens) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut operations, mut hierarchies) = (0, 0);
    for case in 0..600 {
        let eye = any_eye(&mut rng);
        let most = if case % 10 == 0 { 60 } else { 4 };
        let scene = any_scene(&mut rng, eye, most);
        let look_at = match scene.spheres.first() {
            Some(sphere) if sphere.center != eye && rng.random_bool(0.7) => sphere.center,
            _ => eye + unit(&mut rng) * eye.length().max(1.0),
        };
        let up = in_cube(&mut rng);
        let projection = Projection::Perspective { fov_degrees: 45.0 };
        let camera = Camera { position: eye, look_at, up, projection };
        let mut view = View { lens, ..View::new(&camera) };
        view.h = match rng.random_range(0..3) {
            0 if lens == Lens::Orthographic => power(&mut rng, 30, 58),
            0 => power(&mut rng, 20, 29),
            1 => power(&mut rng, -1070, -10),
            _ => power(&mut rng, -3, 1),
        };
        let rays = Rays::Pixels(Pixels::whole(view, 5, 3));
        let (n, hierarchy) = check(&scene, &rays);
        operations += n;
        hierarchies += u32::from(hierarchy);
    }
    println!("{operations} operations, {hierarchies} hierarchies");
    assert!(operations > 200_000 && hierarchies > 20);
}

fn any_ray(rng: &mut ChaCha8Rng, scene: &Scene, middle: DVec3) -> Ray {
    let mut origin = middle + unit(rng) * size(rng).min(2f64.powi(55));
    let mut direction = unit(rng) * size(rng);
    if let Some(sphere) = scene.spheres.first()
        && rng.random_bool(0.6)
        && sphere.center.length() + sphere.radius < 2f64.powi(58)
    {
        let normal = unit(rng);
        let off = match rng.random_range(0..4) {
            0 => 1.0,
            1 => 1.0 + power(rng, -30, -18),
            2 => 1.0 - power(rng, -30, -18),
            _ => power(rng, -20, 3),
        };
        origin = sphere.center + normal * (sphere.radius * off);
        direction = match rng.random_range(0..3) {
            0 => normal.any_orthonormal_vector(),
            1 => -normal,
            _ => unit(rng),
        };
    }
    if let Some(plane) = scene.planes.first()
        && rng.random_bool(0.3)
        && plane.point.length() < 2f64.powi(58)
    {
        let normal = plane.normal.normalize_or(DVec3::Y);
        origin = plane.point + normal.any_orthonormal_vector() * power(rng, -4, 4);
        origin += normal * power(rng, -120, -15);
    }
    match rng.random_range(0..20) {
        0 => direction = DVec3::ZERO,
        1 => direction = unit(rng) * power(rng, -1074, -1020),
        _ => {}
    }
    Ray { origin, direction }
}

#[test]
fn lists_of_rays_have_only_finite_numbers() {
    let mut rng = ChaCha8Rng::seed_from_u64(1172);
    let mut operations = 0;
    for _ in 0..600 {
        let middle = any_eye(&mut rng);
        let scene = any_scene(&mut rng, middle, 4);
        let rays = (0..8).map(|_| any_ray(&mut rng, &scene, middle)).collect();
        operations += check(&scene, &Rays::List(rays)).0;
    }
    println!("{operations} operations");
    assert!(operations > 200_000);
}

/// Of many spheres, the tree has those that f32 has boxes for.
#[test]
fn lists_of_rays_into_many_spheres_have_only_finite_numbers() {
    let mut rng = ChaCha8Rng::seed_from_u64(1174);
    let (mut operations, mut trees) = (0, 0);
    for case in 0..60 {
        let middle = any_eye(&mut rng) * if case % 2 == 0 { 0.0 } else { 1.0 };
        let mut spheres = Vec::new();
        while spheres.len() <= LISTED_SPHERES {
            let sphere = any_sphere(&mut rng, middle);
            let reach = (sphere.center - middle).length() + sphere.radius;
            if case % 4 == 3 || reach < 2f64.powi(38) {
                spheres.push(sphere);
            }
        }
        let planes = (0..rng.random_range(0..2)).map(|_| any_plane(&mut rng, middle)).collect();
        let scene = Arc::new(kugelblitz_tests::scene(spheres, planes));
        let near = |rng: &mut ChaCha8Rng| loop {
            let ray = any_ray(rng, &scene, middle);
            if (ray.origin - middle).length() < 2f64.powi(38) {
                return ray;
            }
        };
        let rays = (0..4).map(|_| near(&mut rng)).collect();
        let (n, tree) = check(&scene, &Rays::List(rays));
        operations += n;
        trees += u32::from(tree);
    }
    println!("{operations} operations, {trees} trees");
    assert!(operations > 200_000 && trees > 30);
}

/// Each of these would be a division by zero, an overflow or `∞ · 0`: what must not be looked at
/// is noticed where it is.
#[test]
fn sabotage_an_infinity_is_noticed() {
    let scene = Arc::new(kugelblitz_tests::scene(
        vec![sphere(DVec3::NEG_Z * 3.0, 1.0)],
        vec![plane(DVec3::NEG_Y, DVec3::Y)],
    ));
    let ray = Ray { origin: DVec3::ZERO, direction: DVec3::NEG_Z };
    let rays = Rays::List(vec![ray; 2]);
    type Change = fn(&mut Prepared);
    fn lists(prepared: &mut Prepared, what: impl Fn(&mut [f32])) {
        let Objects::Certified { lists, .. } = &mut prepared.objects else { panic!("certified") };
        what(&mut lists.spheres[0]);
    }
    let changes: [(&str, bool, Change); 4] = [
        ("nothing", false, |_| {}),
        ("an infinite centre", true, |p| lists(p, |s| s[2] = f32::INFINITY)),
        ("a chord that overflows", true, |p| lists(p, |s| s[4] = f32::INFINITY)),
        ("a centre that overflows when squared", true, |p| lists(p, |s| s[0] = 1e30)),
    ];
    for (what, is_noticed, change) in changes {
        let mut prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
        change(&mut prepared);
        let found = run(&prepared, &rays);
        assert_eq!(!found.not_finite.is_empty(), is_noticed, "{what}: {:?}", found.not_finite);
    }
}

/// A direction of zero is no ray, a radius of zero no sphere: both are missed.
#[test]
fn zero_directions_and_radii_are_missed() {
    let spheres = vec![sphere(DVec3::ZERO, 0.0), sphere(DVec3::ZERO, 2.0)];
    let scene =
        Arc::new(kugelblitz_tests::scene(spheres, vec![plane(DVec3::NEG_Y * 9.0, DVec3::Y)]));
    // On both sides of the reference point, so that a record of zeros lies before a ray.
    let ray = |x: f64, direction| Ray { origin: DVec3::X * x, direction };
    let rays = Rays::List(vec![
        ray(0.25, DVec3::ZERO),
        ray(0.25, DVec3::X),
        ray(0.75, DVec3::NEG_X),
        ray(0.5, DVec3::NEG_X),
    ]);
    let prepared = Arc::new(Prepared::new(scene, Kernel::Certified, &rays).unwrap());
    let mut hits = Hits::default();
    let wants = Wants { surface: true, level: true };
    Tracer::on_cpu(prepared, wants).trace(&rays, &Control::default(), &mut hits).unwrap();
    assert_eq!((hits.id, hits.t), (vec![0, 2, 2, 2], vec![f32::INFINITY, 1.75, 2.75, 2.5]));
}
