//! Statements about what is in the way of light, against exact arithmetic.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::bounds::tests::worst::{UNIT, Worst, assert_tight, worst};
use crate::exact::{ExactBeam, ExactPoint, ExactRay, visible_hit};
use crate::rays::WorldRay;
use crate::scene::{Color, Object, Plane, Sphere};
use crate::shape::ground::OF_POWER;
use crate::shape::{Contact, GroundOccluder, Occluder, PlaneOccluder, SphereOccluder};

/// A shape of its own.
#[derive(Clone, Debug)]
enum Shape {
    Sphere(Sphere),
    Plane(Plane),
}

impl Shape {
    fn sphere(center: DVec3, radius: f64) -> Shape {
        Shape::Sphere(Sphere { center, radius })
    }

    fn plane(point: DVec3, normal: DVec3) -> Shape {
        Shape::Plane(Plane { name: None, point, normal, color: Color::BLACK })
    }

    fn object(&self) -> Object<'_> {
        match self {
            Shape::Sphere(sphere) => Object::Sphere(sphere),
            Shape::Plane(plane) => Object::Plane(plane),
        }
    }
}

/// Does something with a point in a plane across the x axis, where a ray along that meets it: a point of f64, exactly.
fn with_exact_point<T>(at: DVec3, then: impl FnOnce(&ExactPoint) -> T) -> T {
    let ray = ExactRay::new(&WorldRay { origin: at - DVec3::X, direction: DVec3::X });
    let plane = Shape::plane(at, DVec3::X);
    let point = ExactPoint::new(&ray, &visible_hit(&ray, 1, plane.object()).unwrap());
    assert_eq!(point.is_within(0.0, at), Some(true), "{at}");
    then(&point)
}

/// A point near this one that [`with_exact_point`] takes: its x keeps its digits when 1 is taken away and added again.
fn exact_start(at: DVec3) -> DVec3 {
    DVec3::new((at.x - 1.0) + 1.0, at.y, at.z)
}

fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
}

/// A lamp at a point, or the direction of a sun's light.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    at: DVec3,
    is_sun: bool,
}

impl Lamp {
    /// A sun's direction with a largest component from 1 to 2.
    fn origin(self) -> Origin {
        let largest = self.at.abs().max_element().log2().floor() as i32;
        match self.is_sun {
            true => Origin::Sun(self.at * 2f64.powi(-largest)),
            false => Origin::Point(self.at),
        }
    }

    fn is_blocked(self, from: DVec3, shape: &Shape) -> bool {
        with_exact_point(from, |point| {
            let ray = match self.is_sun {
                true => ExactBeam::against(point, self.at),
                false => ExactBeam::to_position(point, self.at),
            };
            ray.unwrap().is_blocked_by(shape.object())
        })
    }
}

/// What is said of an object in the way of a ray.
fn said<F: Float>(ray: &ShadowRay<F>, shape: &Shape) -> Occlusion<F> {
    Occluder::new(shape.object(), DVec3::ZERO).occlude(ray, None)
}

/// Whether it is in the way, and whether it is not.
fn says<F: Float>(verdict: Occlusion<F>) -> [bool; 2] {
    [verdict.blocked, verdict.clear].map(|margin| F::default().lt(margin))
}

const BLOCKED: [bool; 2] = [true, false];
const CLEAR: [bool; 2] = [false, true];
const OPEN: [bool; 2] = [false, false];

/// Spheres and planes that a ray touches, begins at, or ends at, within some units.
fn case(rng: &mut ChaCha8Rng, unit: f64) -> (DVec3, Lamp, Shape) {
    let size = 2f64.powi(rng.random_range(-12..12));
    let from = DVec3::new(rng.random_range(-8..8).into(), 0.0, 0.0)
        + vector(rng) * DVec3::new(0.0, 1.0, 1.0) * 2f64.powi(rng.random_range(-6..6));
    let lamp = Lamp { at: vector(rng) * size, is_sun: rng.random_bool(0.3) };
    let way = if lamp.is_sun { -lamp.at } else { lamp.at - from };
    let s = [0.0, 1.0, rng.random_range(0.0..1.0)][rng.random_range(0..3)];
    let on_ray = from + way * s;
    let aside = way.cross(vector(rng)).normalize();
    let near = 1.0 + f64::from(rng.random_range(-24..=24)) * unit;
    let shape = if rng.random_bool(0.7) {
        let radius = way.length() * rng.random_range(0.01..1.0);
        let across = if s > 0.0 && s < 1.0 { aside } else { vector(rng).normalize() };
        Shape::sphere(on_ray + across * radius * near, radius)
    } else {
        let point = on_ray + aside * way.length();
        Shape::plane(point, way.cross(aside) + way * 1e-3)
    };
    (from, lamp, shape)
}

/// Wrong statements about `n` cases with this part of the bounds' unit, and statements at all.
fn statements<F: Float>(n: usize, part: f64) -> (Vec<String>, usize) {
    let mut rng = ChaCha8Rng::seed_from_u64(1404);
    let (mut wrong, mut n_said) = (Vec::new(), 0);
    for _ in 0..n {
        let (from, lamp, shape) = case(&mut rng, F::UNIT);
        // The computed point is the true one.
        let start = V3::lit(from);
        let from = DVec3::from_array(start.0.map(F::to_f64));
        let ray = ShadowRay::new(&Aim::<F>::new(lamp.origin()), start, F::default());
        let ray = ShadowRay { unit: ray.unit * F::near(part), ..ray };
        let said = says(said(&ray, &shape));
        if said == OPEN {
            continue;
        }
        n_said += 1;
        let expected = if lamp.is_blocked(from, &shape) { BLOCKED } else { CLEAR };
        if said != expected {
            wrong.push(format!("{from:?} {lamp:?} {shape:?}: {said:?}"));
        }
    }
    (wrong, n_said)
}

#[test]
fn what_is_said_is_right() {
    for (wrong, n_said) in [statements::<f64>(100_000, 1.0), statements::<f32>(100_000, 1.0)] {
        assert_eq!(wrong.len(), 0, "{}", wrong[0]);
        assert!(n_said > 20_000, "{n_said}");
    }
}

/// The unit is twice what rounding to nearest takes, the largest errors of all steps don't meet in one
/// ray, and coordinates are rarely as large as their sums.
#[test]
fn sabotage_smaller_bounds_are_noticed() {
    assert!(!statements::<f64>(100_000, 1.0 / 48.0).0.is_empty());
    assert!(!statements::<f32>(100_000, 1.0 / 48.0).0.is_empty());
}

/// A ball about the reference point and a plane through it are where they are: all that is left to be bounded are the
/// operations on the way from a point to them.
#[test]
fn what_is_said_of_objects_at_the_reference_point_is_right() {
    let mut rng = ChaCha8Rng::seed_from_u64(1446);
    let mut n_said = 0;
    for round in 0..40_000 {
        let mut from = exact_start(vector(&mut rng) * 2f64.powi(rng.random_range(-6..6)));
        let (shape, way) = if round % 2 == 0 {
            let aside = from.cross(vector(&mut rng)).normalize() * from.length();
            let way = aside * 2f64.powi(rng.random_range(-12..-2)) - from;
            let away = from.cross(way).length() / way.length();
            let near = rng.random_range(-40.0..40.0) * f64::UNIT * from.length();
            (Shape::sphere(DVec3::ZERO, away + near), way)
        } else {
            let mut whole = || f64::from(rng.random_range(1..9));
            let normal = DVec3::new(whole(), whole(), whole());
            let near = rng.random_range(-20.0..20.0) * f64::UNIT * from.length();
            from.z = near - (normal.x * from.x + normal.y * from.y) / normal.z;
            (Shape::plane(DVec3::ZERO, normal), normal + vector(&mut rng))
        };
        let lamp = Lamp { at: -way, is_sun: true };
        let ray = ShadowRay::new(&Aim::<f64>::new(lamp.origin()), V3(from.to_array()), 0.0);
        let said = says(said(&ray, &shape));
        if said != OPEN {
            let expected = if lamp.is_blocked(from, &shape) { BLOCKED } else { CLEAR };
            assert_eq!(said, expected, "{from:?} {lamp:?} {shape:?}");
            n_said += 1;
        }
    }
    assert!(n_said > 1000, "{n_said}");
}

/// So near that the squares of lengths underflow, the rounding of a dot product is as large as ever: this one has the wrong
/// sign.
#[test]
fn planes_nearer_than_squares_tell_are_open() {
    let normal = DVec3::new(1.6980664066748499, -1.592633229472514, -0.7121360615149421);
    let point = DVec3::new(-3.324926991026493e-166, 6.670777831146176e-166, -2.28468268181911e-165);
    let plane = Shape::plane(point, normal);
    for sun in [normal, -normal] {
        let ray = ShadowRay::new(&Aim::<f64>::new(Origin::Sun(sun)), V3([0.0; 3]), 0.0);
        assert_eq!(says(said(&ray, &plane)), OPEN, "{sun:?}");
    }
}

/// A sun at the horizon of a floor, which is often exactly there.
#[test]
fn suns_along_a_plane_are_known() {
    /// Of a sun that stands so much below the horizon of a floor that leans as much.
    fn found<F: Float>(below: f64, lean: f64) -> Occlusion<f64> {
        let point = DVec3::new(0.0, -1.0, 3.0);
        let floor = Shape::plane(point, DVec3::new(lean, 1.0, 0.0));
        // Its light comes from there.
        let aim = Aim::<F>::new(Origin::Sun(DVec3::new(1.0, below, -0.5)));
        let ray = ShadowRay::new(&aim, V3([0.1, 0.7, 0.3].map(F::near)), F::near(1e-6));
        let Occlusion { clear, blocked } = said(&ray, &floor);
        Occlusion { clear: clear.to_f64(), blocked: blocked.to_f64() }
    }
    assert_eq!([found::<f32>(0.0, 0.0), found::<f64>(0.0, 0.0)].map(says), [CLEAR; 2]);
    // What is nearly 0 is not, also where f32 does not have it.
    for little in [1e-20, 1e-40, 1e-60, 1e-300, 1e-320] {
        for (below, lean) in [(little, 0.0), (-little, 0.0), (0.0, little), (0.0, -little)] {
            let says = [found::<f32>(below, lean), found::<f64>(below, lean)].map(says);
            assert_eq!(says, [OPEN; 2], "{below:e} {lean:e}");
        }
    }
    assert_eq!([1e-9, -1e-9].map(|below| says(found::<f64>(below, 0.0))), [BLOCKED, CLEAR]);
    assert_eq!([1e-3, -1e-3].map(|below| says(found::<f32>(below, 0.0))), [BLOCKED, CLEAR]);
}

/// Wrong statements about spheres that touch rays, where lamp and centre are off by as much as their differences to the
/// reference point may be, `ε|L|` and `ε|c|` with their own rounding, with this part of what is granted.
fn statements_of_moved_lamps(n: usize, part: f64) -> Vec<String> {
    let mut rng = ChaCha8Rng::seed_from_u64(1431);
    let mut wrong = Vec::new();
    for _ in 0..n {
        // Along a diagonal, where the largest component says least of the length.
        let at = DVec3::splat(2f64.powi(rng.random_range(-6..48))) * rng.random_range(0.5..1.0);
        let lamp = Lamp { at, is_sun: false };
        let way = vector(&mut rng) * at.length() * 2f64.powi(rng.random_range(-20..0));
        let from = exact_start(at - way);
        let way = at - from;
        let aside = way.cross(vector(&mut rng)).normalize();
        let off = 0.7 * f64::UNIT * [1.0, -1.0][rng.random_range(0..2)];
        let s = [0.99, 1e-6, rng.random_range(0.0..1.0)][rng.random_range(0..3)];
        let radius = way.length() * s * rng.random_range(0.01..1.0);
        let near = 1.0 + rng.random_range(-1.0..1.0) * 4.0 * f64::UNIT * at.length() / radius;
        let center = from + way * s + aside * radius * near;
        let moved_lamp = Origin::Point(at + aside * off * at.length());
        let moved_center = center - aside * off * center.length();
        let ray = ShadowRay::new(&Aim::<f64>::new(moved_lamp), V3(from.to_array()), 0.0);
        let (end_error, bend) = (ray.end_error * part, ray.bend * part);
        let ray = ShadowRay { end_error, bend, unit: part * f64::UNIT, ..ray };
        let shape = Shape::sphere(center, radius);
        let said = says(said(&ray, &Shape::sphere(moved_center, radius)));
        let expected = if lamp.is_blocked(from, &shape) { BLOCKED } else { CLEAR };
        if said != OPEN && said != expected {
            wrong.push(format!("{from:?} {lamp:?} {off:e} {shape:?}: {said:?}"));
        }
    }
    wrong
}

#[test]
fn what_is_said_of_far_lamps_is_right() {
    let wrong = statements_of_moved_lamps(100_000, 1.0);
    assert_eq!(wrong.len(), 0, "{}", wrong[0]);
}

#[test]
fn sabotage_half_of_what_far_lamps_are_granted_is_noticed() {
    assert!(!statements_of_moved_lamps(100_000, 0.5).is_empty());
}

/// A ball near a floor is as open as its distance says, however far its lamp is.
#[test]
fn near_objects_are_judged_as_well_in_the_light_of_far_lamps() {
    for far in [1e1, 1e8, 1e25, 1e60] {
        let lamp = Aim::<f64>::new(Origin::Point(DVec3::new(0.4, 0.8, 0.3) * far));
        let ray = ShadowRay::new(&lamp, V3([0.1, 0.0, 0.2]), 1e-15);
        for (center, known) in [
            (DVec3::new(0.9, 1.6, 0.8), BLOCKED),
            (DVec3::new(-0.9, 1.6, 0.8), CLEAR),
            (DVec3::new(-0.4, -0.8, -0.3), CLEAR),
        ] {
            assert_eq!(says(said(&ray, &Shape::sphere(center, 0.5))), known, "{far:e} {center:?}");
        }
        let floor = Shape::plane(DVec3::new(0.0, -1.0, 0.0), DVec3::Y);
        assert_eq!(says(said(&ray, &floor)), CLEAR, "{far:e}");
    }
}

/// Wrong bounds of `n·ω` with this part of what is granted.
fn wrong_cosines<F: Float>(n: usize, part: f64) -> usize {
    let mut rng = ChaCha8Rng::seed_from_u64(1438);
    let mut n_wrong = 0;
    for _ in 0..n {
        let start = V3::<F>::lit(vector(&mut rng));
        let from = DVec3::from_array(start.0.map(F::to_f64));
        // Close to a lamp its own rounding counts.
        let at = match rng.random_range(0..3) {
            0 => from + vector(&mut rng) * 2f64.powi(rng.random_range(-16..0)),
            _ => vector(&mut rng) * 3.0,
        };
        let lamp = Lamp { at, is_sun: rng.random_bool(0.5) };
        let normal = vector(&mut rng);
        // The rounding of a unit normal.
        let unit = V3::<F>::lit(normal.normalize());
        let normal_error = F::near(F::UNIT);
        let ray = ShadowRay::new(&Aim::<F>::new(lamp.origin()), start, F::default());
        let (low, high) = ray.cosine(unit, normal_error);
        let (middle, half) =
            ((high.to_f64() + low.to_f64()) / 2.0, (high.to_f64() - low.to_f64()) / 2.0);
        // In more digits than these numbers have: as good as exact for f32.
        let way = if lamp.is_sun { -lamp.at } else { lamp.at - from };
        let exact = normal.normalize().dot(way.normalize());
        if low.to_f64() > 0.0 && high.to_f64() < 1.0 {
            n_wrong += usize::from((exact - middle).abs() > part * half);
        }
        n_wrong += usize::from(exact > high.to_f64() + 1e-15);
    }
    n_wrong
}

#[test]
fn cosines_are_within_their_bounds() {
    assert_eq!(wrong_cosines::<f32>(100_000, 1.0), 0);
    assert!(wrong_cosines::<f32>(100_000, 1.0 / 32.0) > 0);
}

/// What is not in the way of rays from a ball is in the way of none of theirs, and the same of what is in the way; of a ball
/// of half the radius it says what is wrong.
#[test]
fn a_ball_speaks_for_the_points_in_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(1424);
    let (mut n_said, mut n_wrong, mut n_wrong_of_half) = (0, 0, 0);
    for round in 0..40_000 {
        let (at, lamp) = (vector(&mut rng), vector(&mut rng) * 4.0);
        let is_sun = round % 3 == 0;
        let aim = Aim::<f64>::new(Lamp { at: lamp, is_sun }.origin());
        let size = [0.3, 0.01][round % 2];
        // Mostly about as far away as the ball is thick.
        let r = 0.5 + 0.4 * vector(&mut rng).x;
        let middle = at + (lamp - at) * (0.5 + 0.5 * vector(&mut rng).x);
        let center = middle + vector(&mut rng) * r;
        let sphere = Shape::sphere(center, r);
        let of_reach = |reach| says(said(&ShadowRay::new(&aim, V3(at.to_array()), reach), &sphere));
        let points: Vec<DVec3> = (0..8).map(|_| at + vector(&mut rng).normalize() * size).collect();
        let is_wrong = |of_ball: [bool; 2]| {
            points.iter().any(|point| {
                let ray = ShadowRay::new(&aim, V3(point.to_array()), 1e-9);
                let here = says(said(&ray, &sphere));
                of_ball != OPEN && here != OPEN && here != of_ball
            })
        };
        n_said += usize::from(of_reach(size + 1e-9) != OPEN);
        n_wrong += usize::from(is_wrong(of_reach(size + 1e-9)));
        n_wrong_of_half += usize::from(is_wrong(of_reach(size / 2.0)));
    }
    assert_eq!(n_wrong, 0);
    assert!(n_said > 5000 && n_wrong_of_half > 10, "{n_said} {n_wrong_of_half}");
}

/// A lamp on a surface or some roundings away from it, and a point that it lights: anywhere, or near the tangent plane at the lamp.
fn lamp_in_contact(rng: &mut ChaCha8Rng, unit: f64) -> (DVec3, Lamp, Shape) {
    const QUADRUPLES: [([f64; 3], f64); 4] = [
        ([2.0, 3.0, 6.0], 7.0),
        ([-4.0, 1.0, 8.0], 9.0),
        ([2.0, -6.0, 9.0], 11.0),
        ([0.0, 0.0, -1.0], 1.0),
    ];
    let (at, length) = QUADRUPLES[rng.random_range(0..4)];
    let (size, far) = (2f64.powi(rng.random_range(-12..6)), 2f64.powi(rng.random_range(0..9)));
    let (outward, center) = (DVec3::from(at) * size, (vector(rng) * far).round());
    let on_surface = center + outward;
    let off = [0.0, f64::EPSILON, 3.0 * unit][rng.random_range(0..3)];
    let lamp = Lamp { at: on_surface + on_surface * vector(rng) * off, is_sun: false };
    let distance = length * size * 2f64.powi(rng.random_range(-3..6));
    let from = match rng.random_bool(0.5) {
        true => on_surface + vector(rng) * distance,
        false => {
            let along = outward.cross(vector(rng)).normalize() * distance;
            on_surface + along + outward * rng.random_range(-9.0..9.0) * unit
        }
    };
    // Its x keeps its digits in f32, and in `with_exact_point`.
    let from = from.with_x((from.x * 1024.0).round() / 1024.0);
    let shape = match rng.random_bool(0.7) {
        true => Shape::sphere(center, length * size),
        false => Shape::plane(on_surface, outward),
    };
    (from, lamp, shape)
}

/// Wrong statements about lamps in contact, with this part of all errors and with the side times a factor; and how many cases are
/// undecided, with the side and without it, of those with a lamp exactly on the surface.
fn statements_in_contact<F: Float>(n: usize, part: f64, turn: f64) -> (Vec<String>, [usize; 3]) {
    let mut rng = ChaCha8Rng::seed_from_u64(1451);
    let (mut wrong, mut n_on, mut n_open, mut n_open_without) = (Vec::new(), 0, 0, 0);
    for _ in 0..n {
        let (from, lamp, shape) = lamp_in_contact(&mut rng, F::UNIT);
        let start = V3::lit(from);
        let from = DVec3::from_array(start.0.map(F::to_f64));
        let contact = Contact::new((1, shape.object()), lamp.at, DVec3::ZERO);
        let side = contact.expect("a lamp close to the surface").side;
        let ray = ShadowRay::new(&Aim::<F>::new(lamp.origin()), start, F::default());
        let cut = |error: F| F::near(error.to_f64() * part);
        let [unit, turned, end_error] = [ray.unit, ray.turned, ray.end_error].map(cut);
        let ray = ShadowRay { unit, turned, end_error, ..ray };
        let met = Occluder::new(shape.object(), DVec3::ZERO);
        let said_with = says(met.occlude(&ray, Some(side * turn)));
        if side == 0.0 {
            n_on += 1;
            n_open += usize::from(said_with == OPEN);
            n_open_without += usize::from(says(met.occlude(&ray, None)) == OPEN);
        }
        let expected = if lamp.is_blocked(from, &shape) { BLOCKED } else { CLEAR };
        if said_with != OPEN && said_with != expected {
            wrong.push(format!("{from:?} {lamp:?} {shape:?} {side}: {said_with:?}"));
        }
    }
    (wrong, [n_on, n_open, n_open_without])
}

/// With the side of a lamp on a surface, most shadow rays are decided. Without it, only occluded ones are.
#[test]
fn what_is_said_of_lamps_on_surfaces_is_right() {
    for (wrong, [n_on, n_open, n_open_without]) in [
        statements_in_contact::<f64>(60_000, 1.0, 1.0),
        statements_in_contact::<f32>(60_000, 1.0, 1.0),
    ] {
        println!("{n_on} on a surface: {n_open} undecided, {n_open_without} without the side");
        assert_eq!(wrong.len(), 0, "{}", wrong[0]);
        assert!(n_on > 10_000 && 2 * n_open < n_open_without, "{n_open}, {n_open_without}");
    }
}

#[test]
fn sabotage_wrong_sides_and_smaller_errors_of_lamps_on_surfaces_are_noticed() {
    for (part, turn) in [(1.0, -1.0), (1.0 / 256.0, 1.0)] {
        assert!(!statements_in_contact::<f64>(60_000, part, turn).0.is_empty(), "{part} {turn}");
        assert!(!statements_in_contact::<f32>(60_000, part, turn).0.is_empty(), "{part} {turn}");
    }
}

/// A large sphere under a point and a lamp or a sun: low ones, whose light touches it, ones on it, and some below.
fn over_ground(rng: &mut ChaCha8Rng) -> (DVec3, Lamp, Shape) {
    let radius = 2f64.powf(rng.random_range(2.0..40.0)).round();
    let below = 2f64.powi(rng.random_range(-9..4));
    let center = DVec3::new(0.0, -radius - below.min(radius / 1024.0), 0.0);
    let place = |rng: &mut ChaCha8Rng| {
        let across = 2f64.powf(rng.random_range(-6.0..(radius.log2() - 1.0).min(24.0)));
        let at = vector(rng).with_y(0.0) * across;
        // The height of the ground there, and a little.
        let fall = at.length_squared() / (radius + (radius * radius - at.length_squared()).sqrt());
        let height = 2f64.powi(rng.random_range(-24..6)) * [1.0, 1.0, -1.0][rng.random_range(0..3)];
        at.with_y(center.y + radius - fall + height)
    };
    let from = place(rng);
    let from = from.with_x((from.x * 1024.0).round() / 1024.0);
    let lamp = match rng.random_bool(0.6) {
        true => Lamp { at: place(rng), is_sun: false },
        false => {
            let tilt = 10f64.powf(rng.random_range(-7.0..0.0)) * rng.random_range(-1.0..1.0);
            Lamp { at: -(vector(rng).with_y(0.0).normalize() + DVec3::Y * tilt), is_sun: true }
        }
    };
    (from, lamp, Shape::sphere(center, radius))
}

/// A way that touches a large sphere, in the plane across the x axis, but for some roundings.
fn tangent_to_ground(rng: &mut ChaCha8Rng, unit: f64) -> (DVec3, Lamp, Shape) {
    let radius = 2f64.powf(rng.random_range(6.0..30.0)).round();
    let (angle, below) =
        (2f64.powf(rng.random_range(-20.0..-4.0)), 2f64.powi(rng.random_range(-9..0)));
    let (sine, cosine) = angle.sin_cos();
    let fall = 2.0 * radius * (0.5 * angle).sin().powi(2);
    let touched = DVec3::new(0.0, -below - fall, radius * sine);
    let (along, up) = (DVec3::new(0.0, -sine, cosine), DVec3::new(0.0, cosine, sine));
    let off = up * (touched.length() * unit * rng.random_range(-4.0..4.0));
    let mut away = || along * 2f64.powf(rng.random_range(-3.0..6.0));
    let (from, to) = (touched - away(), touched + away() + off);
    let is_sun = rng.random_bool(0.3);
    let lamp = Lamp { at: if is_sun { from - to } else { to }, is_sun };
    (from, lamp, Shape::sphere(DVec3::Y * (-radius - below), radius))
}

/// Wrong statements about large spheres with this part of all errors, and the shares that are decided in f32 or f64, and how many
/// are by [`SphereOccluder`].
fn statements_over_ground<F: Float>(n: usize, part: f64) -> (Vec<String>, [usize; 3]) {
    let mut rng = ChaCha8Rng::seed_from_u64(1461);
    let (mut wrong, mut n_all, mut n_said, mut n_said_before) = (Vec::new(), 0, 0, 0);
    for _ in 0..n {
        let (from, lamp, shape) = match rng.random() {
            true => over_ground(&mut rng),
            false => tangent_to_ground(&mut rng, F::UNIT),
        };
        let start = V3::lit(from);
        let from = DVec3::from_array(start.0.map(F::to_f64));
        let Shape::Sphere(sphere) = &shape else { continue };
        let Some(met) = GroundOccluder::<F>::new(sphere, DVec3::ZERO) else { continue };
        let ray = ShadowRay::new(&Aim::<F>::new(lamp.origin()), start, F::default());
        let side = match lamp.is_sun {
            true => None,
            false => Contact::new((1, shape.object()), lamp.at, DVec3::ZERO),
        };
        let before = SphereOccluder::<F>::new(sphere, DVec3::ZERO);
        let side = side.map(|contact| F::near(contact.side));
        n_said_before += usize::from(says(before.occlude(&ray, side)) != OPEN);
        let cut = |error: F| F::near(error.to_f64() * part);
        let [unit, turned, end_error] = [ray.unit, ray.turned, ray.end_error].map(cut);
        let ray = ShadowRay { unit, turned, end_error, ..ray };
        let met = GroundOccluder { k_error: cut(met.k_error), ..met };
        let said = says(met.occlude(&ray, side));
        n_all += 1;
        n_said += usize::from(said != OPEN);
        let expected = if lamp.is_blocked(from, &shape) { BLOCKED } else { CLEAR };
        if said != OPEN && said != expected {
            wrong.push(format!("{from:?} {lamp:?} {shape:?} {:?}: {said:?}", side.map(F::to_f64)));
        }
    }
    (wrong, [n_all, n_said, n_said_before])
}

/// The power of a point decides its side of a large sphere more often than its distance from the center does.
#[test]
fn what_is_said_of_large_spheres_is_right() {
    for (wrong, [n_all, n_said, n_said_before]) in
        [statements_over_ground::<f64>(60_000, 1.0), statements_over_ground::<f32>(60_000, 1.0)]
    {
        println!("{n_said} of {n_all} decided, {n_said_before} as an ordinary sphere");
        assert_eq!(wrong.len(), 0, "{}", wrong[0]);
        assert!(n_all > 20_000 && 3 * n_said > n_all && n_said > n_said_before, "{n_said}");
    }
}

#[test]
fn sabotage_smaller_errors_of_large_spheres_are_noticed() {
    assert!(!statements_over_ground::<f64>(60_000, 1.0 / 256.0).0.is_empty());
    assert!(!statements_over_ground::<f32>(60_000, 1.0 / 64.0).0.is_empty());
}

/// The squares of a way to a lamp beyond `10¹⁵⁴` are infinite. Then nothing is said, whichever the side.
#[test]
fn nothing_is_said_where_squares_are_infinite() {
    let sphere = Shape::sphere(DVec3::X * 1e9, 1e8);
    let met = Occluder::<f64>::new(sphere.object(), DVec3::ZERO);
    for far in [1e150, 1e155, 1e200, 1e300, 1e307] {
        let at = DVec3::X * far;
        let ray = ShadowRay::new(&Aim::<f64>::new(Origin::Point(at)), V3([0.0; 3]), 0.0);
        for side in [-1.0, 0.0, 1.0] {
            assert!(!met.occlude(&ray, Some(side)).is_clear(), "{far:e} {side}");
        }
        assert!(far < 1e60 || Contact::new((1, sphere.object()), at, DVec3::ZERO).is_none());
    }
}

/// How far a point is from a ray that goes along `way` from 0.
fn distance(point: DVec3, way: DVec3) -> f64 {
    (point - way * (point.dot(way) / way.length_squared()).max(0.0)).length()
}

/// What each constant is for, where it is at its worst.
#[test]
fn every_constant_is_needed() {
    let vector = |x: &[f64]| DVec3::from_slice(x).as_vec3().as_dvec3();
    let number = |v: DVec3| V3(v.to_array().map(Worst));
    // The way is what it is, and no error is granted.
    let sun = |from: DVec3, way: DVec3| {
        let ray = ShadowRay::new(&Aim::new(Origin::Sun(-way)), number(from), Worst(0.0));
        ShadowRay { unit: Worst(0.0), way: number(way), ..ray }
    };
    let met = |point: DVec3, normal: DVec3| PlaneOccluder {
        point: number(point),
        normal: number(normal),
        length: Worst(1.0),
        place: Worst(0.0),
    };
    // Of both numbers that have to have a sign the smaller one.
    let least = |met: &PlaneOccluder<Worst>, ray: &ShadowRay<Worst>| {
        let Occlusion { blocked, clear } = PlaneOccluder::occlude(met, ray, None);
        f64::max(blocked.0, clear.0)
    };
    let of_offset = worst(|x: [f64; 10]| {
        // A centre near the ray, where an error of the foot counts.
        let (from, way) = (vector(&x), vector(&x[3..]));
        let center = from + way * x[6] + vector(&x[7..]) * UNIT;
        let [r, place] = [Worst(0.0); 2];
        let met = SphereOccluder { center: number(center), r, place };
        let found = SphereOccluder::occlude(&met, &sun(from, way), None).clear.0.sqrt();
        let l = center - from;
        // Half of what its square is off by beside.
        let error = (found - distance(l, way)).abs() - 1.5 * UNIT * found;
        error / (UNIT * l.length())
    });
    let moved = |x: &[f64]| {
        let (way, off) = (vector(x), vector(&x[3..]).normalize());
        (way, off * way.length() / APART * x[6].abs().min(1.0))
    };
    let of_lever = worst(|x: [f64; 10]| {
        let ((way, off), l) = (moved(&x), vector(&x[7..]));
        let part = l.length() / way.length();
        let error = (distance(l, way + off) - distance(l, way)).abs();
        // Nearer to the end that of the end is less.
        if part * OF_LEVER < 1.0 { error / (off.length() * part) } else { 0.0 }
    });
    let of_turn = worst(|x: [f64; 7]| {
        let (way, off) = moved(&x);
        let angle = (way + off).cross(way).length().atan2((way + off).dot(way));
        angle * way.length() / off.length()
    });
    let of_place = worst(|x: [f64; 3]| vector(&x).length() / vector(&x).abs().max_element());
    let of_plane = worst(|x: [f64; 12]| {
        let [from, way, point, normal] = [0, 3, 6, 9].map(|at| vector(&x[at..]));
        let ray = ShadowRay { from_point: Worst(1.0), ..sun(from, way) };
        let (l, n) = (point - from, normal.length());
        let (start, stop) = (normal.dot(l).abs(), normal.dot(l - way).abs());
        let error = (least(&met(point, normal), &ray) - start.min(stop)).abs();
        let lengths = if start < stop { l.length() } else { l.length() + way.length() };
        // What is of higher order has its room where the bound is taken.
        error / (ROOM * UNIT * n * lengths)
    });
    let of_slope = worst(|x: [f64; 6]| {
        let (way, normal) = (vector(&x), vector(&x[3..]));
        let slope = normal.dot(way).abs();
        let found = least(&met(normal * 1e9, normal), &sun(DVec3::ZERO, way));
        (found - slope).abs() / (UNIT * normal.length() * way.length())
    });
    let of_power = worst(|x: [f64; 9]| {
        let (center, point) = (vector(&x), vector(&x[3..]));
        // The center is rounded, too.
        let off = DVec3::from_slice(&x[6..]).normalize_or_zero() * (UNIT * center.length());
        let zero = Worst(0.0);
        let met = GroundOccluder { center: number(center), k: zero, k_error: zero, length: zero };
        let (found, _) = met.power(number(point), zero, zero);
        let exact = -point.dot(2.0 * (center + off) - point);
        let lengths = center.length() + (center - point).length();
        ((found.0 - exact).abs() - UNIT * exact.abs()) / (UNIT * point.length() * lengths)
    });
    for (name, constant, found) in [
        ("OF_POWER", OF_POWER, of_power),
        ("OF_OFFSET", OF_OFFSET, of_offset),
        ("OF_LEVER", OF_LEVER, of_lever),
        ("OF_TURN", OF_TURN, of_turn),
        ("OF_PLACE", OF_PLACE, of_place),
        ("OF_PLANE", OF_PLANE, of_plane),
        ("OF_SLOPE", OF_SLOPE, of_slope),
    ] {
        assert_tight(name, constant, found);
    }
}
