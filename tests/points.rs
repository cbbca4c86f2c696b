//! Points of objects in f32, from which a device shades, against exact ones, in arithmetic as bad as their bounds allow.
//! `tests/lemmas.rs` looks at the steps of these bounds one by one.

#[path = "common/adversarial.rs"]
mod adversarial;

use adversarial::{Adversarial, Rounding, set_rounding};
use glam::DVec3;
use kugelblitz::exact::{ExactHit, ExactPoint, ExactRay, Shape, visible_root};
use kugelblitz::gpu::before::narrow::{NarrowSphereOf, narrow_sphere};
use kugelblitz::gpu::before::point::{
    PointFinder, PointOf, PointRoom, SeenFrom, SeenPlaneOf, SeenSphereOf,
};
use kugelblitz::guard::input_of;
use kugelblitz::kernel::RayOf;
use kugelblitz::rays::{CameraF32, Lens, Pixels, View};
use kugelblitz::scene::{Camera, Plane, Sphere};
use kugelblitz::vec3::{Number, Real, Vec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn bad(x: f32) -> Adversarial {
    Adversarial(x)
}

fn bad3(v: Vec3<f32>) -> Vec3<Adversarial> {
    Vec3(v.0.map(Adversarial))
}

fn to_f64(v: Vec3<Adversarial>) -> DVec3 {
    DVec3::from(v.0.map(|x| f64::from(x.0)))
}

/// The room with this share of all bounds that errors are made of.
fn room(lens: Lens, share: f64) -> PointRoom<Adversarial> {
    let room = PointRoom::f32(input_of(lens));
    let cut = |x: f32| bad((f64::from(x) * share) as f32);
    PointRoom {
        foot: cut(room.foot),
        across: cut(room.across),
        square: cut(room.square),
        half: bad(room.half),
        chord: cut(room.chord),
        normal: cut(room.normal),
        sum: cut(room.sum),
        slope: cut(room.slope),
        apart: bad(room.apart),
        ray: cut(room.ray),
        origin: cut(room.origin),
        room: bad(room.room),
        unit: cut(room.unit),
        least: bad(room.least),
        reach: bad(room.reach),
    }
}

/// A camera at the origin, and a sphere and a plane that it sees: from far, from near, or from inside.
fn scene(rng: &mut ChaCha8Rng, lens: Lens) -> (Pixels, Sphere, Plane) {
    let mut vector = || DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
    let (aside, normal, up) = (vector(), vector(), vector());
    let toward = vector().normalize();
    let distance = 2f64.powi(rng.random_range(-3..12));
    let radius = distance * [0.3, 0.01, 1e-4, 1.5][rng.random_range(0..4)];
    let center = (toward + aside * 0.05) * distance;
    let camera = Camera { up, ..Camera::new(DVec3::ZERO, toward) };
    let mut view = View { lens, ..View::new(&camera) };
    // The sphere fills the picture, or goes beyond it.
    let size = radius * rng.random_range(0.05..1.2);
    let (right, up) = (center.dot(view.right).abs(), center.dot(view.true_up).abs());
    view.h = match lens {
        Lens::Perspective => (size + right.max(up)) / distance,
        Lens::Orthographic => size + right.max(up),
    };
    let point = toward * (distance * 2.0);
    let normal = normal + toward * rng.random_range(0.0..0.5);
    let color = kugelblitz::scene::Color([0.5; 3]);
    let plane = Plane { name: None, point, normal, color };
    (Pixels::whole(view, 640, 480), Sphere { center, radius }, plane)
}

/// Where `up` is nearly along the view axis, the picture's plane leans, and its rays may start in a sphere that lies
/// before its middle.
#[test]
fn leaning_planes_of_pictures_may_lie_in_spheres() {
    let forward = DVec3::new(0.3, 0.5, -1.0).normalize();
    let up = forward + DVec3::new(0.2, -0.9, 0.4) * 1e-11;
    let camera = Camera { up, ..Camera::new(DVec3::ZERO, forward) };
    let view = View { lens: Lens::Orthographic, h: 1.0, ..View::new(&camera) };
    let pixels = Pixels::whole(view, 640, 480);
    let seen = SeenFrom::new(&pixels, DVec3::ZERO);
    let sphere = |before: f64| Sphere { center: forward * (0.1 + before), radius: 0.1 };
    let leans = view.forward.dot(view.right).abs().max(view.forward.dot(view.true_up).abs());
    assert!(leans > 1e-8, "{leans:e}");
    assert_eq!(seen.sphere(&sphere(5e-7)).side, 0.0);
    assert_eq!(seen.sphere(&sphere(1e-2)).side, 1.0);
}

/// What is wrong of a point.
fn fault(point: &PointOf<Adversarial>, exact: &ExactPoint, shape: &Shape) -> Option<String> {
    let (at, normal) = (to_f64(point.at), to_f64(point.normal));
    let [error, normal_error] = [point.error, point.normal_error].map(|x| f64::from(x.0));
    if exact.is_within(error, at) != Some(true) {
        return Some(format!("a point is off by more than {error:e}"));
    }
    let is_right = match *shape {
        // The normal leads from its centre to the point.
        Shape::Sphere { center, radius } => {
            let turn = if point.is_inside { -radius } else { radius };
            exact.is_within(normal_error * radius, center + normal * turn) == Some(true)
        }
        Shape::Plane { normal: n, .. } => {
            let n = n.normalize();
            n.distance(normal).min(n.distance(-normal)) <= normal_error
        }
    };
    (!is_right).then(|| format!("a normal is off by more than {normal_error:e}"))
}

/// Of the points of `n` scenes with this share of the bounds: how many of spheres and planes are known, and what is wrong.
fn look(n: usize, share: f64) -> ([usize; 2], Vec<String>) {
    let mut rng = ChaCha8Rng::seed_from_u64(1431);
    let (mut n_known, mut wrong) = ([0; 2], Vec::new());
    for case in 0..n {
        let lens = [Lens::Perspective, Lens::Orthographic][case % 2];
        let (pixels, sphere, plane) = scene(&mut rng, lens);
        let seen = SeenFrom::new(&pixels, DVec3::ZERO);
        let camera = CameraF32::new(&pixels);
        let [right_step, true_up_step] = [camera.right_step, camera.true_up_step].map(bad3);
        let finder = PointFinder { right_step, true_up_step, lens, room: room(lens, share) };
        let of_sphere = SeenSphereOf::from(&seen.sphere(&sphere));
        let of_plane = SeenPlaneOf::from(&seen.plane(&plane));
        let narrow = narrow_sphere(sphere.center.to_array(), sphere.radius);
        let narrow = NarrowSphereOf::from(&narrow);
        for rounding in Rounding::ALL {
            let center = of_sphere.place.map(|x| f64::from(x) / 2.0);
            let near = rng.random_bool(0.5) && of_sphere.depth > 0.0;
            let x = if near { center[0] + 320.0 } else { 320.0 };
            let y = if near { 240.0 - center[1] } else { 240.0 };
            let place = |middle: f64, end: u32, rng: &mut ChaCha8Rng| {
                (middle + rng.random_range(-200.0..200.0)).clamp(0.0, f64::from(end - 1)) as u32
            };
            let (x, y) = (place(x, 640, &mut rng), place(y, 480, &mut rng));
            let (i, j) = pixels.offset2(x, y);
            let [i, j] = [i as f32, j as f32].map(bad);
            set_rounding(rounding, rng.random());
            // As `ray_from_position` does.
            let forward = bad3(camera.forward);
            let (across, up) = (right_step * i, true_up_step * j);
            let zero = Vec3([bad(0.0); 3]);
            let ray = match lens {
                Lens::Perspective => RayOf::new(zero, zero, (forward + across) + up),
                Lens::Orthographic => RayOf::new(across + up, zero, forward),
            };
            let exact_ray = ExactRay::from_pixel(&pixels, x, y);
            let ball = Shape::Sphere { center: sphere.center, radius: sphere.radius };
            let wall = Shape::Plane { point: plane.point, normal: plane.normal };
            for (at, shape) in [ball, wall].into_iter().enumerate() {
                let Some((root, side)) = visible_root(&exact_ray, &shape) else { continue };
                let exact = ExactPoint::new(&exact_ray, &ExactHit { id: 1, root, side });
                let point = match at {
                    0 => {
                        let of_sphere = SeenSphereOf {
                            place: of_sphere.place.map(bad),
                            place_low: of_sphere.place_low.map(bad),
                            depth: bad(of_sphere.depth),
                            error: bad(of_sphere.error),
                            inverse_radius: bad(of_sphere.inverse_radius),
                            side: bad(of_sphere.side),
                        };
                        let narrow = NarrowSphereOf {
                            center: bad3(narrow.center),
                            radius: bad(narrow.radius),
                            center_low: bad3(narrow.center_low),
                        };
                        let aside = finder.sphere_aside(&of_sphere, i, j);
                        finder.sphere_point(&ray, aside, &of_sphere, &narrow)
                    }
                    _ => {
                        let of_plane = SeenPlaneOf {
                            slope: bad3(of_plane.slope),
                            offset: bad(of_plane.offset),
                            unit: bad3(of_plane.unit),
                            error: bad(of_plane.error),
                        };
                        finder.plane_point(&ray, &of_plane, i, j)
                    }
                };
                if point.is_known {
                    n_known[at] += 1;
                    let what = fault(&point, &exact, &shape);
                    wrong.extend(what.map(|what| {
                        format!("{what}: {lens:?} {rounding:?} {pixels:?} ({x}, {y}) {shape:?}")
                    }));
                }
            }
        }
    }
    (n_known, wrong)
}

#[test]
fn points_are_within_their_bounds() {
    let ([spheres, planes], wrong) = look(2000, 1.0);
    println!("{spheres} points of spheres, {planes} of planes");
    assert!(wrong.is_empty(), "{} wrong, the first: {}", wrong.len(), wrong[0]);
    assert!(spheres.min(planes) > 4000, "{spheres} {planes}");
}

/// Bounds that are half of what they should be.
#[test]
fn sabotage_halved_bounds_are_noticed() {
    assert!(!look(2000, 0.5).1.is_empty());
}

/// f32 that keeps to the finite numbers.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Finite(f32);

impl Finite {
    fn of(x: f32) -> Finite {
        assert!(x.is_finite(), "{x}");
        Finite(x)
    }
}

macro_rules! operators {
    ($($name:ident $function:ident),+) => {$(
        impl std::ops::$name for Finite {
            type Output = Finite;
            fn $function(self, other: Finite) -> Finite {
                Finite::of(std::ops::$name::$function(self.0, other.0))
            }
        }
    )+};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl std::ops::Neg for Finite {
    type Output = Finite;
    fn neg(self) -> Finite {
        Finite(-self.0)
    }
}

impl std::ops::MulAssign for Finite {
    fn mul_assign(&mut self, other: Finite) {
        *self = *self * other;
    }
}

impl Number for Finite {}

impl Real for Finite {
    const ZERO: Finite = Finite(0.0);
    const ONE: Finite = Finite(1.0);
    const TWO: Finite = Finite(2.0);
    const FOUR: Finite = Finite(4.0);
    const INFINITY: Finite = Finite(f32::INFINITY);
    const LARGEST: Finite = Finite(f32::MAX);
    const SMALL: Finite = Finite(<f32 as Real>::SMALL);
    fn from_f64(x: f64) -> Finite {
        Finite::of(x as f32)
    }
    fn sqrt(self) -> Finite {
        Finite::of(self.0.sqrt())
    }
    fn abs(self) -> Finite {
        Finite(self.0.abs())
    }
    fn min(self, other: Finite) -> Finite {
        Finite(self.0.min(other.0))
    }
    fn max(self, other: Finite) -> Finite {
        Finite(self.0.max(other.0))
    }
}

/// A size at an end of the range, beyond it, or ordinary.
fn size(rng: &mut ChaCha8Rng) -> f64 {
    let exponent = match rng.random_range(0..6) {
        0 => rng.random_range(-42..=-28),
        1 => rng.random_range(46..=62),
        2 => rng.random_range(-1070..=1020),
        3 => rng.random_range(-130..=130),
        _ => rng.random_range(-6..=6),
    };
    2f64.powi(exponent) * rng.random_range(1.0..2.0)
}

/// Neither for what is near the ends of the range, nor for what is beyond.
#[test]
fn no_number_leaves_the_finite_ones() {
    let mut rng = ChaCha8Rng::seed_from_u64(1432);
    let mut n_known = [0; 2];
    for case in 0..40_000 {
        let lens = [Lens::Perspective, Lens::Orthographic][case % 2];
        let (mut pixels, ..) = scene(&mut rng, lens);
        pixels.view.h = match lens {
            Lens::Perspective => 2f64.powi(rng.random_range(-100..=12)),
            Lens::Orthographic => size(&mut rng).clamp(2f64.powi(-100), 2f64.powi(40)),
        };
        let [x, y] = [640, 480].map(|end| rng.random_range(0..end));
        let ray = pixels.ray(x, y);
        if !pixels.is_in_range() || ray.origin.length() > 2f64.powi(50) {
            continue;
        }
        // What the ray meets.
        let at = ray.origin + ray.direction * size(&mut rng);
        let mut vector = || DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let (aside, normal) = (vector().normalize(), vector());
        let radius = size(&mut rng);
        let sphere = Sphere { center: at + aside * radius, radius };
        let color = kugelblitz::scene::Color([0.5; 3]);
        let plane = Plane { name: None, point: at, normal: normal * size(&mut rng), color };
        let (exact_ray, seen) =
            (ExactRay::from_pixel(&pixels, x, y), SeenFrom::new(&pixels, DVec3::ZERO));
        let finite = |v: Vec3<f32>| Vec3(v.0.map(Finite::of));
        let camera = CameraF32::new(&pixels);
        let [right_step, true_up_step] = [camera.right_step, camera.true_up_step].map(finite);
        let room = PointRoom::f32(input_of(lens));
        let room = PointRoom {
            foot: Finite(room.foot),
            across: Finite(room.across),
            square: Finite(room.square),
            half: Finite(room.half),
            chord: Finite(room.chord),
            normal: Finite(room.normal),
            sum: Finite(room.sum),
            slope: Finite(room.slope),
            apart: Finite(room.apart),
            ray: Finite(room.ray),
            origin: Finite(room.origin),
            room: Finite(room.room),
            unit: Finite(room.unit),
            least: Finite(room.least),
            reach: Finite(room.reach),
        };
        let finder = PointFinder { right_step, true_up_step, lens, room };
        let (i, j) = pixels.offset2(x, y);
        let [i, j] = [i as f32, j as f32].map(Finite);
        let (across, up) = (right_step * i, true_up_step * j);
        let zero = Vec3([Finite(0.0); 3]);
        let forward = finite(camera.forward);
        let ray = match lens {
            Lens::Perspective => RayOf::new(zero, zero, (forward + across) + up),
            Lens::Orthographic => RayOf::new(across + up, zero, forward),
        };
        let ball = Shape::Sphere { center: sphere.center, radius };
        if sphere.center.is_finite() && visible_root(&exact_ray, &ball).is_some() {
            let of_sphere = seen.sphere(&sphere);
            let narrow = narrow_sphere(sphere.center.to_array(), radius);
            let of_sphere = SeenSphereOf {
                place: of_sphere.place.map(Finite::of),
                place_low: of_sphere.place_low.map(Finite::of),
                depth: Finite::of(of_sphere.depth),
                error: Finite::of(of_sphere.error),
                inverse_radius: Finite::of(of_sphere.inverse_radius),
                side: Finite::of(of_sphere.side),
            };
            let narrow = NarrowSphereOf {
                center: finite(Vec3(narrow.center)),
                radius: Finite::of(narrow.radius),
                center_low: finite(Vec3(narrow.center_low)),
            };
            let aside = finder.sphere_aside(&of_sphere, i, j);
            let point = finder.sphere_point(&ray, aside, &of_sphere, &narrow);
            n_known[0] += usize::from(point.is_known);
        }
        let wall = Shape::Plane { point: plane.point, normal: plane.normal };
        let is_there = plane.point.is_finite() && plane.normal != DVec3::ZERO;
        if is_there && visible_root(&exact_ray, &wall).is_some() {
            let of_plane = seen.plane(&plane);
            let of_plane = SeenPlaneOf {
                slope: finite(Vec3(of_plane.slope)),
                offset: Finite::of(of_plane.offset),
                unit: finite(Vec3(of_plane.unit)),
                error: Finite::of(of_plane.error),
            };
            n_known[1] += usize::from(finder.plane_point(&ray, &of_plane, i, j).is_known);
        }
    }
    println!("{n_known:?} points");
    assert!(n_known.iter().all(|&n| n > 2000), "{n_known:?}");
}
