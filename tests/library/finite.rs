//! No operation of the formulas that find objects on a device takes or gives ∞ or NaN, which Vulkan lets a compiler
//! assume away; neither for objects and rays at the ends of the range, nor for those beyond it.
//!
//! Here they run on the records that a device has, in a number that notes what is not finite, and leave nothing out, as
//! shaders don't: also what is selected away is calculated. They must propose what a device's twin does.

use std::cell::{Cell, RefCell};
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::panic::Location;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::bvh::REACH;
use kugelblitz::control::Control;
use kugelblitz::num::{Mask, Real};
use kugelblitz::prepare::{LISTED_SPHERES, Objects, Prepared};
use kugelblitz::rays::{Lens, Pixels, View};
use kugelblitz::scene::{Camera, Plane, Projection, Scene, Sphere};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::twins::{Twin, propose_alone};
use kugelblitz_tests::{in_cube, plane, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// An f32 that is looked at.
#[derive(Clone, Copy, Debug)]
struct Watched(f32);

/// What a comparison gives. Shaders leave nothing out where it does not hold.
#[derive(Clone, Copy)]
struct Truth(bool);

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
    /// Places in the source, operations and operands.
    static NOT_FINITE: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Notes an operation whose operands or result are not finite.
#[track_caller]
fn look(what: &str, operands: &[f32]) {
    OPERATIONS.set(OPERATIONS.get() + 1);
    if !operands.iter().all(|x| x.is_finite()) {
        let found = format!("{}: {what} {operands:?}", Location::caller());
        NOT_FINITE.with_borrow_mut(|all| all.push(found));
    }
}

macro_rules! watched {
    ($($trait:ident $function:ident $sign:tt),*) => {$(
        impl $trait for Watched {
            type Output = Watched;
            #[track_caller]
            fn $function(self, other: Watched) -> Watched {
                let result = self.0 $sign other.0;
                look(stringify!($sign), &[self.0, other.0, result]);
                Watched(result)
            }
        }
    )*};
}

watched!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Watched {
    type Output = Watched;
    fn neg(self) -> Watched {
        Watched(-self.0)
    }
}

impl Mask for Truth {
    fn and(self, other: Truth) -> Truth {
        Truth(self.0 & other.0)
    }
    fn or(self, other: Truth) -> Truth {
        Truth(self.0 | other.0)
    }
    fn not(self) -> Truth {
        Truth(!self.0)
    }
    fn any(self) -> bool {
        true
    }
}

impl Real for Watched {
    type One = f32;
    type Mask = Truth;
    type Id = u32;
    #[track_caller]
    fn splat(x: f32) -> Watched {
        look("the number", &[x]);
        Watched(x)
    }
    fn splat_id(id: u32) -> u32 {
        id
    }
    #[track_caller]
    fn sqrt(self) -> Watched {
        look("√", &[self.0, self.0.sqrt()]);
        Watched(self.0.sqrt())
    }
    fn abs(self) -> Watched {
        Watched(self.0.abs())
    }
    #[track_caller]
    fn lt(self, other: Watched) -> Truth {
        look("<", &[self.0, other.0]);
        Truth(self.0 < other.0)
    }
    #[track_caller]
    fn le(self, other: Watched) -> Truth {
        look("≤", &[self.0, other.0]);
        Truth(self.0 <= other.0)
    }
    fn select(mask: Truth, yes: Watched, no: Watched) -> Watched {
        if mask.0 { yes } else { no }
    }
    fn select_id(mask: Truth, yes: u32, no: u32) -> u32 {
        if mask.0 { yes } else { no }
    }
}

/// What rays see, and what was not finite; `None` where a device finds no way.
fn watch(prepared: &Prepared, rays: &Rays) -> Option<(Vec<u32>, Vec<String>)> {
    let twin = Twin::new(prepared)?;
    NOT_FINITE.take();
    let decide = |index| twin.decide::<Watched>(&twin.ray(rays, index));
    Some(((0..rays.len()).map(decide).collect(), NOT_FINITE.take()))
}

/// Numbers of operations, and of scenes with a tree, that are looked at in a test.
#[derive(Debug, Default)]
struct Looked {
    operations: u64,
    trees: u32,
}

impl Looked {
    /// Watches a scene, and compares with the twin.
    fn at(&mut self, scene: &Arc<Scene>, rays: &Rays) {
        let prepared = Prepared::new(Arc::clone(scene), Kernel::Certified, rays).unwrap();
        if !prepared.in_range {
            return;
        }
        OPERATIONS.set(0);
        let Some((proposals, not_finite)) = watch(&prepared, rays) else { return };
        let what = || format!("{:?} {:?} {rays:?}", scene.spheres, scene.planes);
        if let Some(first) = not_finite.first() {
            panic!("{} operations, the first: {first}; {}", not_finite.len(), what());
        }
        assert_eq!(Some(proposals), propose_alone(&prepared, rays), "{}", what());
        self.operations += OPERATIONS.get();
        self.trees += u32::from(prepared.hierarchy.is_some());
    }
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
    for (seed, lens) in [(1171, Lens::Perspective), (1173, Lens::Orthographic)] {
        let (mut rng, mut looked) = (ChaCha8Rng::seed_from_u64(seed), Looked::default());
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
            looked.at(&scene, &Rays::Pixels(Pixels::whole(view, 5, 3)));
        }
        println!("{looked:?}");
        assert!(looked.operations > 200_000 && looked.trees > 20, "{looked:?}");
    }
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

/// Of many spheres, the tree has those that f32 has boxes for.
#[test]
fn lists_of_rays_have_only_finite_numbers() {
    let (mut rng, mut looked) = (ChaCha8Rng::seed_from_u64(1172), Looked::default());
    for _ in 0..600 {
        let middle = any_eye(&mut rng);
        let scene = any_scene(&mut rng, middle, 4);
        let rays = (0..8).map(|_| any_ray(&mut rng, &scene, middle)).collect();
        looked.at(&scene, &Rays::List(rays));
    }
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
        looked.at(&scene, &Rays::List(rays));
    }
    println!("{looked:?}");
    assert!(looked.operations > 400_000 && looked.trees > 30, "{looked:?}");
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
        let (_, not_finite) = watch(&prepared, &rays).unwrap();
        assert_eq!(!not_finite.is_empty(), is_noticed, "{what}: {not_finite:?}");
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
