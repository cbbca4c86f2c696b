//! The filter's bounds against arithmetic as bad as they allow: with the derived constants no
//! statement is ever wrong; with one of them made smaller, wrong statements appear.
//!
//! What a bound covers is the sum of the worst cases of a dozen roundings, which no ray meets all
//! at once: [`CAUGHT`] says from which fraction on a smaller bound is noticed. `tests/library/lemmas.rs` looks
//! at the steps one by one.

use glam::DVec3;
use kugelblitz::exact::{ExactHit, ExactRay, Shape, nearest};
use kugelblitz::guard::{self, Guard, InputError, WIDENING};
use kugelblitz::kernel::RayOf;
use kugelblitz::kernel::certified::{
    GuardOf, Nearness, Widening, far_nearness, inside_nearness, outside_nearness, plane_nearness,
    plane_nearness_at, sphere_nearness,
};
use kugelblitz::num::Float;
use kugelblitz::rays::{CameraF32, Lens, Pixels, View};
use kugelblitz::trace::Ray;
use kugelblitz::vec3::Vec3;
use kugelblitz_tests::adversarial::{Adversarial, Rounding, set_rounding};
use kugelblitz_tests::{cases, in_cube, log_uniform};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// One rounding of f64 numbers to f32, as the host does it, and nothing more.
const ROUNDED_ONCE: InputError = InputError { offset: 0.501, direction: 0.501 };

/// What is made smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bound {
    Inner,
    Outer,
    Slack,
    KError,
    Widening,
    PlaneDirection,
    PlaneOffset,
}

/// One bound at a fraction of what is derived, the others as they are.
#[derive(Clone, Copy)]
struct Sabotage {
    bound: Bound,
    fraction: f64,
}

impl Sabotage {
    const NONE: Sabotage = Sabotage { bound: Bound::Inner, fraction: 1.0 };

    fn of(self, bound: Bound) -> f64 {
        if bound == self.bound { self.fraction } else { 1.0 }
    }

    fn widening(self) -> f64 {
        WIDENING * f32::UNIT * self.of(Bound::Widening)
    }

    fn guard(self, r: f64, l: f64, input: InputError) -> (GuardOf<Adversarial>, Adversarial) {
        let Guard { inner2, outer2, slack, k_error } = Guard::new(r, l, f32::UNIT, input);
        let toward = |bound2: f64, fraction: f64| r * r + (bound2 - r * r) * fraction;
        let guard = Guard {
            inner2: match inner2 > 0.0 {
                true => toward(inner2, self.of(Bound::Inner)),
                false => inner2,
            },
            outer2: toward(outer2, self.of(Bound::Outer)),
            slack: slack * self.of(Bound::Slack),
            k_error: k_error * self.of(Bound::KError),
        };
        let [inner2, outer2, slack, k_error] = guard.round_to_f32().map(Adversarial);
        (GuardOf { inner2, outer2, slack }, k_error)
    }

    /// As [`guard::inverse_f32`].
    fn inverse(self, x: f64) -> Nearness<Adversarial> {
        if x == 0.0 {
            return Nearness { low: Adversarial(0.0), high: Adversarial(0.0) };
        }
        let inverse = 1.0 / x.abs();
        Nearness {
            low: Adversarial(guard::round_down(inverse * (1.0 - self.widening()))),
            high: Adversarial(guard::round_up(inverse * (1.0 + self.widening()))),
        }
    }

    /// As [`guard::widening_f32`].
    fn widening_of_lists(self) -> Widening<Adversarial> {
        Widening {
            narrower: Adversarial(guard::round_down(1.0 - self.widening())),
            wider: Adversarial(guard::round_up(1.0 + self.widening())),
            far_narrower: Adversarial(guard::widening_f32().far_narrower),
        }
    }
}

fn rounded(v: DVec3) -> Vec3<Adversarial> {
    Vec3(v.as_vec3().to_array().map(Adversarial))
}

/// A ray from 0, and one object.
#[derive(Clone, Copy, Debug)]
struct Case {
    direction: DVec3,
    shape: Shape,
}

impl Case {
    fn exact(&self) -> Option<ExactHit> {
        let ray = Ray { origin: DVec3::ZERO, direction: self.direction };
        nearest(&ExactRay::new(&ray), [(1, self.shape)])
    }

    /// The nearness that the filter must bound, to f64 rounding; 0 for a miss.
    fn nearness(&self) -> f64 {
        let a = self.direction.length_squared();
        self.exact().map_or(0.0, |hit| 1.0 / (a * hit.t_f64()))
    }

    /// What the filter says: as for pixels near to and far from all spheres, and as for lists.
    fn filtered(&self, sabotage: Sabotage) -> [Nearness<Adversarial>; 3] {
        let direction = rounded(self.direction);
        let ray = RayOf::new(Vec3::ZERO, Vec3::ZERO, direction);
        let widening = sabotage.widening_of_lists();
        match self.shape {
            Shape::Sphere { center, radius } => {
                let (r, l) = (radius, center.length());
                let (guard, k_error) = sabotage.guard(r, l, ROUNDED_ONCE);
                let offset = rounded(center);
                // Products of f32 numbers, and exact sums up to f64's rounding.
                let k = exact_k(center, r);
                let q = sabotage.inverse(k);
                let pixel = match k > 0.0 {
                    true => outside_nearness(&ray, offset, &guard, q),
                    false => inside_nearness(&ray, offset, &guard, q, &widening),
                };
                let longest = self.direction.length();
                let is_far = guard::is_far(&Guard::new(r, l, f32::UNIT, ROUNDED_ONCE), k, longest);
                let far = match is_far {
                    true => {
                        let q = Adversarial(guard::round_up(guard::far_inverse(k)));
                        let root = far_nearness(&ray, offset, guard.inner2, guard.outer2, q);
                        Nearness { low: root.low * widening.far_narrower, ..root }
                    }
                    false => pixel,
                };
                let r2 = Adversarial((r * r) as f32);
                let k = kugelblitz::vec3::dot3(offset, offset) - r2;
                let list = sphere_nearness(&ray, offset, &guard, k, k_error, &widening);
                [pixel, far, list]
            }
            Shape::Plane { point, normal } => {
                let n_offset = exact_offset(point, normal);
                let (n, l) = (normal.length(), point.length());
                let toward = if n_offset < 0.0 { -normal } else { normal };
                let bound =
                    |error: f64, bound| Adversarial(guard::round_up(error * sabotage.of(bound)));
                let error = guard::plane_direction_error(n, f32::UNIT, ROUNDED_ONCE);
                let direction_error = bound(error, Bound::PlaneDirection);
                let error =
                    guard::plane_offset_error(n, l, f32::UNIT, ROUNDED_ONCE, guard::TINY_F32);
                let offset_error = bound(error, Bound::PlaneOffset);
                let away = kugelblitz::vec3::dot3(direction, rounded(toward));
                let q = sabotage.inverse(n_offset);
                let pixel = plane_nearness(&ray, away, direction_error, q);
                let normal = rounded(normal);
                let n_offset = kugelblitz::vec3::dot3(rounded(point), normal);
                let list = plane_nearness_at(
                    &ray,
                    n_offset,
                    offset_error,
                    normal,
                    direction_error,
                    &widening,
                );
                [pixel, pixel, list]
            }
        }
    }

    /// Whether a statement of the filter is wrong.
    fn is_wrong(&self, sabotage: Sabotage) -> bool {
        let truth = self.nearness();
        // `truth` is an f64.
        let (least, most) = (truth * (1.0 - 1e-14), truth * (1.0 + 1e-14));
        self.filtered(sabotage).iter().any(|root| {
            let (low, high) = (f64::from(root.low.0), f64::from(root.high.0));
            if truth == 0.0 { low > 0.0 } else { low > most || high < least }
        })
    }
}

fn exact_k(center: DVec3, r: f64) -> f64 {
    let ray = ExactRay::new(&Ray { origin: DVec3::ZERO, direction: DVec3::X });
    kugelblitz::exact::sphere_numbers(&ray, center, r).expect("finite").k.to_f64()
}

fn exact_offset(point: DVec3, normal: DVec3) -> f64 {
    let ray = ExactRay::new(&Ray { origin: DVec3::ZERO, direction: DVec3::X });
    kugelblitz::exact::plane_numbers(&ray, point, normal).expect("finite").numerator.to_f64()
}

fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
    in_cube(rng).normalize_or(DVec3::X)
}

/// A ray that passes a few `ε·ℓ` beside the silhouette, or anywhere; largest component in 1..2.
fn sphere_case(rng: &mut ChaCha8Rng) -> Case {
    if rng.random_bool(0.2) {
        return on_surface_case(rng);
    }
    let r = log_uniform(rng, 1e-3, 1e3).abs();
    let ratio = match rng.random_range(0..8) {
        0 => 1.0 + log_uniform(rng, 1e-6, 1.0).abs(),
        1 => 1.0 - log_uniform(rng, 1e-6, 1.0).abs(),
        2 => rng.random_range(0.0..1.0),
        _ => log_uniform(rng, 1.0, 1e5).abs(),
    };
    let distance = (r * ratio).max(1e-9 * r);
    let toward = unit(rng);
    let center = toward * distance;
    let aside = toward.cross(unit(rng)).normalize_or(toward.any_orthonormal_vector());
    let unit_of_guard = f32::UNIT * distance / r;
    let off = match rng.random_range(0..4) {
        0 => rng.random_range(-1.0..0.2),
        _ => unit_of_guard * rng.random_range(-3.0..3.0),
    };
    let sine = (1.0 + off) * r / distance;
    let direction = match sine.abs() < 1.0 {
        true => toward * (1.0 - sine * sine).sqrt() + aside * sine,
        false => unit(rng),
    };
    Case { direction: stretched(rng, direction), shape: Shape::Sphere { center, radius: r } }
}

/// A ray from a point of the sphere, nearly along its surface.
fn on_surface_case(rng: &mut ChaCha8Rng) -> Case {
    let ([center, ..], radius) = cases::integer_frame(rng, 12);
    let along = center.normalize();
    let few = f32::UNIT * rng.random_range(-8.0..8.0);
    let direction = along.cross(unit(rng)).normalize_or(DVec3::X) + along * few;
    Case { direction: stretched(rng, direction), shape: Shape::Sphere { center, radius } }
}

/// A power of two brings the largest component into 1..2, after any length.
fn stretched(rng: &mut ChaCha8Rng, direction: DVec3) -> DVec3 {
    let direction = direction * rng.random_range(1.0..2.0);
    kugelblitz::prepare::Scaled::new(direction).rounded()
}

/// A plane that the ray meets head-on, or grazes by a few `ε`, or that passes near the origin.
fn plane_case(rng: &mut ChaCha8Rng) -> Case {
    let few = |rng: &mut ChaCha8Rng| f32::UNIT * rng.random_range(-4.0..4.0);
    let normal = unit(rng);
    let normal = stretched(rng, normal);
    let across = |rng: &mut ChaCha8Rng| normal.cross(unit(rng)).normalize_or(DVec3::X);
    let along = normal.normalize();
    let direction = match rng.random_range(0..3) {
        0 => along + across(rng) * log_uniform(rng, 1e-9, 1.0),
        1 => across(rng) + along * few(rng),
        _ => unit(rng),
    };
    let point = match rng.random_range(0..3) {
        0 => along + across(rng) * log_uniform(rng, 1e-9, 1.0),
        1 => across(rng) + along * few(rng),
        _ => unit(rng),
    } * log_uniform(rng, 1e-3, 1e3);
    Case { direction: stretched(rng, direction), shape: Shape::Plane { point, normal } }
}

fn case(rng: &mut ChaCha8Rng, bound: Option<Bound>) -> Case {
    let planes = match bound {
        Some(Bound::PlaneDirection | Bound::PlaneOffset | Bound::Widening) => 1.0,
        Some(_) => 0.0,
        None => 0.3,
    };
    if rng.random_bool(planes) { plane_case(rng) } else { sphere_case(rng) }
}

/// Cases that one task looks at, in one rounding mode.
const CASES_PER_TASK: usize = 1000;

/// The first wrong statement of a task.
fn first_wrong(seed: u64, task: usize, bound: Option<Bound>, sabotage: Sabotage) -> Option<String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(task as u64);
    let rounding = Rounding::ALL[task % Rounding::ALL.len()];
    set_rounding(rounding, rng.random());
    let wrong =
        (0..CASES_PER_TASK).map(|_| case(&mut rng, bound)).find(|case| case.is_wrong(sabotage))?;
    Some(format!(
        "seed {seed}, {rounding:?}: {wrong:?}: {:?} for {:e}",
        wrong.filtered(sabotage),
        wrong.nearness()
    ))
}

/// Largest error of the input in units `ε`, over `n` cases a rounding mode.
fn largest_error(n: usize, error: impl Fn(&mut ChaCha8Rng) -> f64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(cases::seed());
    let mut largest = 0.0;
    for rounding in Rounding::ALL {
        set_rounding(rounding, rng.random());
        largest = (0..n).map(|_| error(&mut rng)).fold(largest, f64::max);
    }
    largest
}

fn to_f64(v: Vec3<Adversarial>) -> DVec3 {
    DVec3::from(v.0.map(|x| f64::from(x.0)))
}

/// `δ` of pixels: the direction `f + i·R + j·T` as the device computes it.
#[test]
fn directions_of_pixels_are_within_their_bound() {
    let largest = largest_error(50_000, |rng| {
        let along = unit(rng);
        let up = along.cross(unit(rng)).normalize_or(along.any_orthonormal_vector());
        let size = 2 * rng.random_range(1..2000) + 1;
        let view = View {
            position: DVec3::ZERO,
            forward: along,
            right: along.cross(up),
            true_up: up,
            h: log_uniform(rng, 1e-3, 100.0).abs(),
            lens: Lens::Perspective,
        };
        let pixels = Pixels::whole(view, size, size);
        let (x, y) = (rng.random_range(0..size), rng.random_range(0..size));
        let camera = CameraF32::new(&pixels);
        let [forward, right, up] = [camera.forward, camera.right_step, camera.true_up_step]
            .map(|v| Vec3(v.0.map(Adversarial)));
        let (i, j) = pixels.offset2(x, y);
        let [i, j] = [i, j].map(|offset| Adversarial(offset as f32));
        let direction = to_f64((forward + right * i) + up * j);
        let exact = pixels.direction(x, y);
        direction.distance(exact) / (f32::UNIT * exact.length())
    });
    println!("δ of pixels: {largest:.3} of {}", guard::PIXELS.direction);
    assert!(largest <= guard::PIXELS.direction);
    // The bound is Cauchy's, for the worst frame.
    assert!(largest > guard::PIXELS.direction / 2.0, "half the bound would do: {largest}");
}

/// `λ` of lists: the offset from two halves.
#[test]
fn offsets_of_lists_are_within_their_bound() {
    let largest = largest_error(50_000, |rng| {
        let center = unit(rng) * log_uniform(rng, 1e-3, 1e3);
        let origin = unit(rng) * log_uniform(rng, 1e-3, 1e3);
        let [center_parts, origin_parts] = [center, origin].map(|v| {
            let (high, low) = kugelblitz::prepare::split(v);
            [high, low].map(|part| Vec3(part.map(Adversarial)))
        });
        let [high, low] = [0, 1].map(|part| center_parts[part] - origin_parts[part]);
        let exact = center - origin;
        to_f64(high + low).distance(exact) / (f32::UNIT * (center.length() + origin.length()))
    });
    println!("λ of lists: {largest:.3} of {}", guard::LIST.offset);
    assert!(largest <= guard::LIST.offset);
    assert!(largest > guard::LIST.offset / 2.0, "half the bound would do: {largest}");
}

/// More than a million cases, in all roundings.
#[test]
fn no_statement_is_wrong_in_any_rounding() {
    let seed = cases::seed();
    let tasks = (0..1050).into_par_iter();
    let found = tasks.find_map_any(|task| first_wrong(seed, task, None, Sabotage::NONE));
    assert_eq!(found, None);
}

/// Each bound, and the fraction at which wrong statements appear.
const CAUGHT: [(Bound, f64); 7] = [
    (Bound::Inner, 0.35),
    (Bound::Outer, 0.35),
    // From outside the widening covers it: only from a point on the sphere it stands alone.
    (Bound::Slack, 0.0),
    (Bound::KError, 0.3),
    // The slack covers a wider interval of most spheres, and what a plane's direction costs hides
    // the rest: only without any widening do statements become wrong.
    (Bound::Widening, 0.0),
    (Bound::PlaneDirection, 0.3),
    (Bound::PlaneOffset, 0.3),
];

#[test]
fn sabotage_a_smaller_bound_is_noticed() {
    let mut unnoticed = Vec::new();
    for (bound, fraction) in CAUGHT {
        let sabotage = Sabotage { bound, fraction };
        let search = |sabotage| {
            (0..210)
                .into_par_iter()
                .find_map_any(|task| first_wrong(7, task, Some(bound), sabotage))
        };
        assert_eq!(search(Sabotage::NONE), None, "{bound:?} as it is");
        let found = search(sabotage);
        if found.is_none() {
            unnoticed.push((bound, fraction));
        }
    }
    assert!(unnoticed.is_empty(), "not noticed: {unnoticed:?}");
}
