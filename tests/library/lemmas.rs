//! The steps of the derivation in `src/bounds.rs`, one by one: a search climbs to the numbers and the
//! roundings, chosen for each operation, that need the largest constant. The constant must be enough,
//! and half of it must not be.

use glam::DVec3;
use kugelblitz::bounds::host::input_in_f64;
use kugelblitz::bounds::{
    self, FilterBounds, Footprint, InputError, LIST, LIST_F64, PARALLEL, PIXELS, ROOM,
};
use kugelblitz::bounds::{rows, steps};
use kugelblitz::gpu::slabs::{self, LEAST_SLACK, Slabs};
use kugelblitz::num::{Float, Ray, Real, V3, round_down, round_up};
use kugelblitz::rays::{Frame, Lens, Pixels, View};
use kugelblitz::scene::{Camera, Projection};
use kugelblitz::shape::shadow::OF_COSINE;
use kugelblitz_tests::adversarial::{Adversarial, set_choices};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

const UNIT_F32: f64 = f32::UNIT;
const UNIT_F64: f64 = f64::UNIT;

const ROUNDED_ONCE: InputError = InputError { offset: 0.501, direction: 0.501 };

/// Parameter of the point of a line that is closest to the centre, and its squared distance, as `Foot` of `src/shape/sphere.rs`
/// has them.
fn closest_approach<R: Real>(direction: V3<R>, inv_a: R, l: V3<R>) -> (R, R) {
    let s = direction.dot(l) * inv_a;
    let p = l - direction * s;
    (s, p.dot(p))
}

/// `v / ‖v‖`
fn normalized<R: Real>(v: V3<R>) -> V3<R> {
    v * (R::lit(1.0) / v.dot(v).sqrt())
}

/// A number of any size near 1, often just above a power of two, where a rounding costs most.
fn any_number(rng: &mut ChaCha8Rng) -> f64 {
    let sign = if rng.random() { 1.0 } else { -1.0 };
    let power = sign * 2f64.powi(rng.random_range(-3..=3));
    match rng.random_range(0..4) {
        0 => power * rng.random_range(1.0..2.0),
        1 => power * 2f64.powi(-rng.random_range(4..30)),
        _ => power * (1.0 + f64::from(rng.random_range(0..8)) * UNIT_F32),
    }
}

fn mutated(rng: &mut ChaCha8Rng, numbers: &[f64], choices: u64) -> (Vec<f64>, u64) {
    let (mut numbers, mut choices) = (numbers.to_vec(), choices);
    for _ in 0..rng.random_range(1..4) {
        if rng.random_bool(0.4) {
            choices ^= 1 << rng.random_range(0..40);
            continue;
        }
        let index = rng.random_range(0..numbers.len());
        let x = &mut numbers[index];
        match rng.random_range(0..6) {
            0 => *x = any_number(rng),
            1 => *x = -*x,
            2 => *x *= 2f64.powi(rng.random_range(-2..=2)),
            3 => *x *= 1.0 + rng.random_range(-0.1..0.1),
            _ => *x *= 1.0 + f64::from(rng.random_range(-9..=9)) * UNIT_F32 / 2.0,
        }
    }
    (numbers, choices)
}

/// The largest value of `needed` that a climb from many starts finds.
fn worst(n_numbers: usize, needed: impl Fn(&[f64], u64) -> Option<f64> + Sync) -> f64 {
    let climb = |start: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(1102);
        rng.set_stream(start);
        let mut best = (f64::NEG_INFINITY, vec![1.0; n_numbers], 0);
        for step in 0..6000 {
            let (numbers, choices): (Vec<f64>, u64) = match step {
                0..500 => ((0..n_numbers).map(|_| any_number(&mut rng)).collect(), rng.random()),
                _ => mutated(&mut rng, &best.1, best.2),
            };
            // Nothing under- or overflows.
            let is_ordinary = numbers.iter().all(|x| (1e-8..1e8).contains(&x.abs()));
            let value = is_ordinary.then(|| needed(&numbers, choices)).flatten();
            let value = value.unwrap_or(f64::NEG_INFINITY);
            assert!(!value.is_nan(), "{numbers:?} {choices:#x}");
            if value >= best.0 {
                best = (value, numbers, choices);
            }
        }
        best
    };
    let climbs = (0..24).into_par_iter().map(climb);
    let (value, numbers, choices) =
        climbs.reduce_with(|a, b| if a.0 >= b.0 { a } else { b }).unwrap();
    println!("  at {numbers:?} {choices:#x}");
    value
}

/// Half of the constant would not do.
fn assert_tight(name: &str, constant: f64, found: f64) {
    println!("{name}: {found:.4} of {constant}");
    assert!(found <= constant, "{name}: {found} is needed, {constant} granted");
    assert!(found > constant / 2.0, "{name}: half of {constant} would do for all that is found");
}

/// So much of a constant is needed, and not half of it would do.
fn needs(
    name: &str,
    constant: f64,
    n_numbers: usize,
    needed: impl Fn(&[f64], u64) -> Option<f64> + Sync,
) {
    assert_tight(name, constant, worst(n_numbers, needed));
}

/// As f32, and that in f64.
fn vector(x: &[f64]) -> (V3<Adversarial>, DVec3) {
    let x: [f32; 3] = std::array::from_fn(|k| x[k] as f32);
    (V3(x.map(Adversarial)), DVec3::from(x.map(f64::from)))
}

fn number(x: f64) -> (Adversarial, f64) {
    (Adversarial(x as f32), f64::from(x as f32))
}

fn to_f64(v: V3<Adversarial>) -> DVec3 {
    DVec3::from(v.0.map(|x| f64::from(x.0)))
}

fn ray(direction: V3<Adversarial>) -> Ray<Adversarial> {
    Ray::new(V3([Adversarial(0.0); 3]), direction)
}

/// Distance of a point from a line through 0; from the part across it, which loses less than the
/// square root of a difference.
fn distance(l: DVec3, d: DVec3) -> f64 {
    l.cross(d).length() / d.length()
}

#[test]
fn dot_products() {
    needs("DOT", steps::DOT, 6, |x, choices| {
        let ((a, exact_a), (b, exact_b)) = (vector(x), vector(&x[3..]));
        set_choices(choices, true);
        let error = (f64::from(a.dot(b).0) - exact_a.dot(exact_b)).abs();
        Some(error / (UNIT_F32 * exact_a.length() * exact_b.length()))
    });
}

#[test]
fn parameters_of_the_closest_point() {
    needs("CLOSEST", steps::CLOSEST, 6, |x, choices| {
        let ((d, exact_d), (l, exact_l)) = (vector(x), vector(&x[3..]));
        set_choices(choices, true);
        let (s, _) = closest_approach(d, ray(d).inv_a, l);
        let error = (f64::from(s.0) - exact_d.dot(exact_l) / exact_d.length_squared()).abs();
        Some(error * exact_d.length() / (UNIT_F32 * exact_l.length()))
    });
}

#[test]
fn feet_of_perpendiculars() {
    needs("FOOT", steps::FOOT, 6, |x, choices| {
        let ((d, exact_d), (l, exact_l)) = (vector(x), vector(&x[3..]));
        let (s, exact_s) = number(exact_d.dot(exact_l) / exact_d.length_squared());
        set_choices(choices, true);
        let p = to_f64(l - d * s);
        let error = p.distance(exact_l - exact_s * exact_d) - UNIT_F32 * p.length();
        Some(error / (UNIT_F32 * exact_l.length()))
    });
}

#[test]
fn squared_distances() {
    needs("SQUARE", steps::SQUARE, 7, |x, choices| {
        let ((d, exact_d), (l, exact_l)) = (vector(x), vector(&x[3..]));
        let (s, exact_s) = number(x[6] * 1e-6);
        set_choices(choices, true);
        let p = l - d * s;
        let root = f64::from(p.dot(p).0).sqrt();
        let foot = exact_s * exact_d;
        let error = (root - (exact_l - foot).length()).abs();
        let rest = steps::FOOT * UNIT_F32 * foot.length();
        Some(2.0 * (error - rest) / (UNIT_F32 * root))
    });
}

/// Where the line passes through the centre, only what is of second order keeps `m` from 0.
#[test]
fn lines_through_the_centre() {
    needs("ASIDE", steps::ASIDE, 4, |x, choices| {
        let (d, exact_d) = vector(x);
        let (l, exact_l) = vector(&(exact_d * x[3]).to_array());
        set_choices(choices, true);
        let (_, m) = closest_approach(d, ray(d).inv_a, l);
        let eta = UNIT_F32 * exact_l.length();
        let reach = distance(exact_l, exact_d) + steps::FOOT * eta;
        Some((f64::from(m.0) * (1.0 - steps::SQUARE * UNIT_F32) - reach * reach) / (eta * eta))
    });
}

#[test]
fn half_chords() {
    needs("HALF_CHORD", steps::HALF_CHORD, 5, |x, choices| {
        let (d, exact_d) = vector(x);
        let ((r2, exact_r2), (m, exact_m)) = (number(x[3].abs()), number(x[4].abs()));
        if exact_m >= exact_r2 {
            return None;
        }
        set_choices(choices, true);
        let h = f64::from(((r2 - m) * ray(d).inv_a).sqrt().0);
        let exact = ((exact_r2 - exact_m) / exact_d.length_squared()).sqrt();
        Some((h / exact - 1.0).abs() / UNIT_F32)
    });
}

#[test]
fn sums_of_roots() {
    needs("TWO_SUMS", steps::TWO_SUMS, 3, |x, choices| {
        let ((s, exact_s), (h, exact_h)) = (number(x[0].abs()), number(x[1].abs()));
        let (slack, exact_slack) = number(x[2] * 1e-6 * exact_s.max(exact_h));
        set_choices(choices, true);
        let u = f64::from(((s + slack) + h).0);
        let error = (u - (exact_s + exact_h + exact_slack)).abs();
        Some(error / (UNIT_F32 * (exact_s + exact_h + exact_slack.abs())))
    });
}

/// What the host rounds once, to the nearest.
#[test]
fn inputs_that_are_rounded_once() {
    let found = worst(3, |x, choices| {
        // Digits beyond f32.
        let v = DVec3::from_slice(x) * (1.0 + (choices % 1024) as f64 * 2f64.powi(-34));
        Some(v.as_vec3().as_dvec3().distance(v) / (UNIT_F32 * v.length()))
    });
    for (name, constant) in
        [("NORMAL", steps::NORMAL), ("λ of pixels", PIXELS.offset), ("δ of lists", LIST.direction)]
    {
        assert_tight(name, constant, found);
    }
    needs("λ of lists in f64", LIST_F64.offset, 6, |x, _| {
        let (c, o) = (DVec3::from_slice(x), DVec3::from_slice(&x[3..]) * (1.0 + UNIT_F64 * 9.0));
        let l = c - o;
        // Knuth's two-sum: what the subtraction lost, exactly.
        let part = c - l;
        let lost = (c - (l + part)) + (part - o);
        Some(lost.length() / (UNIT_F64 * l.length()))
    });
    needs("λ of lists", LIST.offset, 6, |x, choices| {
        let (c, o) = (DVec3::from_slice(x), DVec3::from_slice(&x[3..]));
        let [center, origin] = [c, o].map(|v| V3::<Adversarial>::splat(V3::lit(v)));
        set_choices(choices, true);
        let error = to_f64(center - origin).distance(c - o);
        Some(error / (UNIT_F32 * (c.length() + o.length())))
    });
}

/// Rays of pixels in f32.
#[test]
fn rays_of_pixels() {
    let camera = |x: &[f64], lens| {
        let forward = DVec3::from_slice(x).normalize();
        let right = forward.cross(DVec3::from_slice(&x[3..])).normalize();
        let (right_step, true_up_step) = (right * x[6].abs(), right.cross(forward) * x[6].abs());
        let narrow = V3::<f32>::lit;
        let camera = Frame {
            forward: narrow(forward),
            right: narrow(right_step),
            true_up: narrow(true_up_step),
            lens,
        };
        (camera, forward, right_step, true_up_step)
    };
    let offsets = |choices: u64| {
        let of = |bits: u64| f64::from((bits % 2048) as i32 - 1024);
        (of(choices), of(choices >> 20))
    };
    needs("δ of pixels", PIXELS.direction, 7, |x, choices| {
        let (camera, forward, right, up) = camera(x, Lens::Perspective);
        let (i, j) = offsets(choices);
        let exact = forward + right * i + up * j;
        set_choices(choices, true);
        let found = to_f64(camera.ray(number(i).0, number(j).0).direction);
        Some(found.distance(exact) / (UNIT_F32 * exact.length()))
    });
    needs("λ of parallel rays", PARALLEL.offset, 10, |x, choices| {
        let (camera, _, right, up) = camera(x, Lens::Orthographic);
        let (i, j) = offsets(choices);
        let (exact_c, exact_o) = (DVec3::from_slice(&x[7..]), right * i + up * j);
        let c = V3::splat(V3::lit(exact_c));
        set_choices(choices, true);
        let l = c - camera.ray(number(i).0, number(j).0).origin;
        let distance = exact_c.length() + exact_o.length();
        Some(to_f64(l).distance(exact_c - exact_o) / (UNIT_F32 * distance))
    });
    // A dot product with a rounded normal and an origin, and the difference.
    let granted = steps::DOT + steps::NORMAL + 1.0 + PARALLEL.offset;
    needs("an origin's part of N", granted, 11, |x, choices| {
        let (camera, _, right, up) = camera(x, Lens::Orthographic);
        let (i, j) = offsets(choices);
        let exact_o = right * i + up * j;
        let normal = DVec3::from_slice(&x[7..]).normalize();
        let ((offset, exact_offset), rounded) = (number(x[10]), V3::splat(V3::lit(normal)));
        set_choices(choices, true);
        let origin = camera.ray(number(i).0, number(j).0).origin;
        let found = f64::from((offset - origin.dot(rounded)).0);
        let error = (found - (exact_offset - normal.dot(exact_o))).abs();
        Some((error - UNIT_F32 * exact_offset.abs()) / (UNIT_F32 * exact_o.length().max(1e-30)))
    });
}

/// Rays of pixels in f64, for which f32 stands in, with the unit of rounding to nearest: the frame is what it is, and a step
/// takes a quotient and a product.
#[test]
fn rays_in_f64() {
    let unit = 0.5 * UNIT_F32;
    let narrow = V3::<f32>::lit;
    let wide = |v: V3<f32>| DVec3::from(v.0.map(f64::from));
    let camera = |x: &[f64], choices: u64, lens| {
        let forward = DVec3::from_slice(x).normalize();
        let right = forward.cross(DVec3::from_slice(&x[3..])).normalize();
        let frame = [forward, right, right.cross(forward)].map(narrow);
        let [h, rows] = [x[6].abs() as f32, (1 + choices % 2000) as f32];
        let [forward, right, true_up] = [frame[0], frame[1] * (h / rows), frame[2] * (h / rows)];
        let camera = Frame { forward, right, true_up, lens };
        let (i, j) =
            (f64::from((choices >> 20) as u16 % 2048), f64::from((choices >> 40) as u16 % 2048));
        let exact = f64::from(h) / f64::from(rows);
        let aside = wide(frame[1]) * (exact * i) + wide(frame[2]) * (exact * j);
        (camera.ray(i as f32, j as f32), wide(forward), aside)
    };
    let found = worst(7, |x, choices| {
        let (ray, forward, aside) = camera(x, choices, Lens::Perspective);
        let exact = forward + aside;
        Some(wide(ray.direction).distance(exact) / (unit * exact.length()))
    });
    println!("δ: {found:.4}");
    let granted = input_in_f64(Some(Lens::Perspective)).direction;
    assert!(found <= granted && found > granted / 3.0, "{found} of {granted}");
    let found = worst(10, |x, choices| {
        let (ray, _, origin) = camera(x, choices, Lens::Orthographic);
        let (center, exact_center) =
            (narrow(DVec3::from_slice(&x[7..])), DVec3::from_slice(&x[7..]));
        let found = wide(center - ray.origin).distance(exact_center - origin);
        Some(found / (unit * (exact_center.length() + origin.length())))
    });
    println!("λ: {found:.4}");
    let granted = input_in_f64(Some(Lens::Orthographic)).offset;
    assert!(found <= granted && found > granted / 3.0, "{found} of {granted}");
}

/// A vector, and the same off by at most `by` of a length.
fn moved(exact: DVec3, toward: &[f64], by: f64) -> DVec3 {
    exact + DVec3::from_slice(toward).normalize_or_zero() * by
}

/// How far the filter's `m` is from the square of a true distance, as part of what the guard of a
/// sphere with that radius grants: within (below it) and without.
fn part_of_guard(x: &[f64], choices: u64, within: bool) -> Option<f64> {
    let ((d, rounded_d), (l, rounded_l)) = (vector(x), vector(&x[3..]));
    let length = rounded_l.length();
    let input = ROUNDED_ONCE;
    let exact_d = moved(rounded_d, &x[6..], input.direction * UNIT_F32 * rounded_d.length());
    let exact_l = moved(rounded_l, &x[9..], input.offset * UNIT_F32 * length * (1.0 - 1e-6));
    let r = distance(exact_l, exact_d);
    let l_bound = bounds::length_bound(exact_l);
    set_choices(choices, true);
    let (_, m) = closest_approach(d, ray(d).inv_a, l);
    let m = f64::from(m.0);
    let guard = FilterBounds::new(r, l_bound, UNIT_F32, input);
    match within {
        true => (guard.inner2 > 0.0).then(|| (r * r - m) / (r * r - guard.inner2)),
        false => Some((m - r * r) / (guard.outer2 - r * r)),
    }
}

#[test]
fn the_guard_radii() {
    let near_the_centre = |x: &[f64]| {
        // A small part of the distance, and large against its rounding.
        let mut x = x.to_vec();
        let along = DVec3::from_slice(&x) * x[12];
        let l = along + along.length() * DVec3::from_slice(&x[3..]) * 1e-3;
        x[3..6].copy_from_slice(&l.to_array());
        x
    };
    needs("inner2", 1.0, 13, |x, choices| part_of_guard(&near_the_centre(x), choices, true));
    needs("outer2", 1.0, 13, |x, choices| part_of_guard(&near_the_centre(x), choices, false));
    // Far from the centre of the picture all is relative.
    needs("inner2 anywhere", 1.0, 13, |x, choices| part_of_guard(x, choices, true));
}

/// The slack alone: of `s + h`, where half the chord is that of the bounds and of the
/// computed `m`.
#[test]
fn the_slack() {
    for above in [false, true] {
        let name = if above { "slack above" } else { "slack below" };
        needs(name, 1.0, 13, |x, choices| {
            let ((d, rounded_d), (l, rounded_l)) = (vector(x), vector(&x[3..]));
            let input = ROUNDED_ONCE;
            let error = input.direction * UNIT_F32 * rounded_d.length();
            let exact_d = moved(rounded_d, &x[6..], error);
            let error = input.offset * UNIT_F32 * rounded_l.length() * (1.0 - 1e-6);
            let exact_l = moved(rounded_l, &x[9..], error);
            let a = exact_d.length_squared();
            let s = exact_d.dot(exact_l) / a;
            if rounded_d.length() < 1.0 || s <= 0.0 {
                return None;
            }
            let r = distance(exact_l, exact_d) + x[12].abs();
            let guard = FilterBounds::new(r, bounds::length_bound(exact_l), UNIT_F32, input);
            let radius2 = match above {
                true => round_up(guard.outer2),
                false => round_down(guard.inner2),
            };
            let slack = Adversarial(round_up(guard.slack));
            set_choices(choices, true);
            let inv_a = ray(d).inv_a;
            let (found_s, m) = closest_approach(d, inv_a, l);
            let chord2 = Adversarial(radius2) - m;
            if chord2.0 < 0.0 {
                return None;
            }
            let sum = found_s + (chord2 * inv_a).sqrt();
            let u = s + ((f64::from(radius2) - f64::from(m.0)) / a).sqrt();
            let off = match above {
                true => u - f64::from((sum + slack).0),
                false => f64::from((sum - slack).0) - u,
            };
            Some(1.0 + off / f64::from(slack.0))
        });
    }
}

/// The rays of the corners of squares of pixels, against that of the middle: the parts of what is said
/// that their directions and their origins take at most.
fn part_of_reach(rng: &mut ChaCha8Rng) -> [f64; 2] {
    let fov_degrees = rng.random_range(5.0..150.0);
    let projection = match rng.random_bool(0.3) {
        true => Projection::Orthographic { height: rng.random_range(0.1..100.0) },
        false => Projection::Perspective { fov_degrees },
    };
    let look_at = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
    let pixels = Pixels::whole(
        View::new(&Camera { projection, ..Camera::new(DVec3::ZERO, look_at) }),
        rng.random_range(64..2000),
        rng.random_range(64..2000),
    );
    let side = 1 << rng.random_range(0..5);
    let reach = Footprint::new(&pixels, f64::from(side));
    if reach.turned > bounds::LARGEST_TURN {
        return [0.0; 2];
    }
    let camera = Frame::<f64>::of_pixels(&pixels);
    let mut at = |size: u32| f64::from(rng.random_range(0..=size) as i32 * 2 - size as i32);
    let (i, j) = (at(pixels.image_width), at(pixels.image_height));
    let middle = camera.ray(i, j);
    let vector = |v: V3<f64>| DVec3::from_array(v.0);
    let mut parts: [f64; 2] = [0.0; 2];
    for (x, y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let half = f64::from(side);
        let corner = camera.ray(i + x * half, j + y * half);
        let turned = (vector(corner.direction) - vector(middle.direction)).length();
        let apart = (vector(corner.origin) - vector(middle.origin)).length();
        let of = |needed: f64, said: f64| if needed == 0.0 { 0.0 } else { needed / said };
        for (part, new) in parts.iter_mut().zip([
            of(turned / vector(corner.direction).length(), reach.turned),
            of(apart, reach.apart),
        ]) {
            *part = part.max(new);
        }
    }
    parts
}

#[test]
fn squares_of_pixels() {
    let mut rng = ChaCha8Rng::seed_from_u64(1425);
    let mut worst: [f64; 2] = [0.0; 2];
    for _ in 0..20_000 {
        for (worst, part) in worst.iter_mut().zip(part_of_reach(&mut rng)) {
            *worst = worst.max(part);
        }
    }
    println!("turned, apart: {worst:.3?} of what is said");
    assert!(worst.iter().all(|&part| part <= 1.0 && part > 0.5), "{worst:?}");
}

#[test]
fn the_errors_of_planes() {
    // A direction and an offset that are off alike, an f64 normal that is rounded.
    let input = InputError { offset: 0.501, direction: 0.501 };
    let product = |x: &[f64], choices: u64| {
        let (v, rounded_v) = vector(x);
        let exact_v =
            moved(rounded_v, &x[6..], 0.501 * UNIT_F32 * rounded_v.length() * (1.0 - 1e-6));
        let normal = DVec3::from_slice(&x[3..]);
        let rounded_n = V3(normal.as_vec3().to_array().map(Adversarial));
        set_choices(choices, true);
        let error = (f64::from(v.dot(rounded_n).0) - exact_v.dot(normal)).abs();
        (error, bounds::length_bound(normal), rounded_v.length())
    };
    needs("plane_direction_error", 1.0, 9, |x, choices| {
        let (error, n, d) = product(x, choices);
        Some(error / (bounds::plane_direction_error(n, UNIT_F32, input) * d))
    });
}

#[test]
fn normals_from_half_chords() {
    needs("NORMAL_FOOT", steps::NORMAL_FOOT, 6, |x, choices| {
        let ((d, exact_d), (l, exact_l)) = (vector(x), vector(&x[3..]));
        set_choices(choices, true);
        let p = to_f64(l - d * (d.dot(l) * ray(d).inv_a));
        let s = exact_d.dot(exact_l) / exact_d.length_squared();
        let error = p.distance(exact_l - s * exact_d) - UNIT_F32 * p.length();
        Some(error / (UNIT_F32 * exact_l.length()))
    });

    // f32 stands in for f64 here: its division and root, too, are off by one unit only.
    needs("NORMALIZED", steps::NORMALIZED, 3, |x, choices| {
        let (v, exact_v) = vector(x);
        set_choices(choices, false);
        Some(to_f64(normalized(v)).distance(exact_v.normalize()) / UNIT_F32)
    });
}

/// A normal from half a chord between its bounds: from the centre there is no `P`, and both bounds are the radius.
#[test]
fn normals_from_bounds_of_half_chords() {
    needs("CHORD_MIDDLE", steps::CHORD_MIDDLE, 5, |x, choices| {
        let (d, exact_d) = vector(x);
        let [(r, exact_r), (error, exact_error)] = [x[3].abs(), x[4] * 1e-6].map(number);
        let (inverse, _) = number(1.0 / exact_r);
        set_choices(choices, true);
        let half = (r * r * ray(d).inv_a).sqrt();
        let middle = (half + half) * Adversarial(0.5);
        let normal = (V3([Adversarial(0.0); 3]) - d * middle) * inverse;
        let bound = to_f64(normal - V3([error; 3]));
        let exact = -exact_d.normalize() - DVec3::splat(exact_error);
        (exact_r > 0.0).then(|| bound.distance(exact) / UNIT_F32)
    });
}

/// How steep light falls on a surface, with the sum that bounds it.
#[test]
fn cosines_of_light() {
    needs("OF_COSINE", OF_COSINE, 7, |x, choices| {
        let (way, exact_way) = vector(x);
        let unit = DVec3::from_slice(&x[3..]).normalize();
        let (normal, exact_normal) = vector(&unit.to_array());
        let (error, exact_error) = number(x[6] * 1e-6);
        set_choices(choices, true);
        let inverse = Adversarial(1.0) / way.dot(way).sqrt();
        let bound = f64::from((normal.dot(way) * inverse - error).0);
        let exact = exact_normal.dot(exact_way) / exact_way.length() - exact_error;
        Some((bound - exact).abs() / UNIT_F32)
    });
}

/// `k` and the root are what they are; the direction's own error is granted beside.
#[test]
fn roots_from_their_product() {
    needs("RELATIVE", steps::RELATIVE, 5, |x, choices| {
        let ((d, exact_d), (k, exact_k), (root, exact_root)) =
            (vector(x), number(x[3].abs()), number(x[4].abs()));
        set_choices(choices, true);
        let none = Adversarial(0.0);
        let one = Adversarial(1.0);
        let t = f64::from((((k - none) * ray(d).inv_a) / root * (one - none)).0);
        let exact = exact_k / exact_d.length_squared() / exact_root;
        Some((t - exact).abs() / (UNIT_F32 * exact))
    });
}

#[test]
fn normals_of_points() {
    needs("NORMAL_OF_POINT", steps::NORMAL_OF_POINT, 3, |x, choices| {
        let [(at, exact_at), (l, exact_l), (r, exact_r)] = [x[0], x[1], x[2]].map(number);
        set_choices(choices, false);
        let normal = f64::from(((at - l) * (Adversarial(1.0) / r)).0);
        let exact = (exact_at - exact_l) / exact_r;
        (exact != 0.0).then(|| (normal - exact).abs() / (UNIT_F32 * exact.abs()))
    });
}

/// How far half a chord is from that of another squared radius in the guard, where it is shortest.
#[test]
fn half_chords_of_rows() {
    needs("CHORD", rows::CHORD, 2, |x, _| {
        let (width, within) = (1.0, x[1].abs());
        let chord2 = rows::LEAST_WIDTHS * width + x[0].abs();
        if within > width {
            return None;
        }
        let (inner, outer) = (chord2 + within - width, chord2 + within);
        Some((outer.sqrt() - inner.sqrt()) * chord2.sqrt() / width)
    });
}

/// A point from two bounds of `t`, beside half their distance: where the ray's origin is near, then where the point
/// is near the origin.
#[test]
fn points_from_bounds_of_t() {
    for (name, constant, scale) in
        [("POINT", steps::POINT, 1e-6), ("POINT_ORIGIN", steps::POINT_ORIGIN, 1e6)]
    {
        needs(name, constant, 8, |x, choices| {
            let (direction, exact_direction) = vector(x);
            let (low, exact_low) = number(x[6].abs());
            let length = exact_direction.length();
            let origin = DVec3::from_slice(&x[3..]).normalize() * (exact_low * length * scale);
            let (origin, exact_origin) = vector(&origin.to_array());
            let (high, exact_high) = number(exact_low * (1.0 + x[7].abs() * 1e-4));
            set_choices(choices, false);
            let half = (high - low) * Adversarial(0.5);
            let point = to_f64(origin + direction * (low + half));
            let ends = [exact_low, exact_high].map(|t| exact_origin + t * exact_direction);
            let farthest = ends.map(|end| point.distance(end)).into_iter().fold(0.0, f64::max);
            // What is of higher order has its room, as where the bound is taken.
            let rounding = farthest / ROOM - length * f64::from(half.0);
            let of = if scale < 1.0 { exact_high * length } else { exact_origin.length() };
            Some(rounding / (UNIT_F32 * of))
        });
    }
}

#[test]
fn quotients_of_planes_in_rows() {
    needs("QUOTIENT", rows::QUOTIENT, 4, |x, _| {
        let (offset, slope, offset_error) = (x[0].abs(), x[1].abs(), x[2].abs());
        let slope_error = rows::MOST_OF_SLOPE * slope * x[3].abs().min(1.0);
        let exact = (offset + offset_error) / (slope - slope_error);
        let granted = (offset_error + offset / slope * slope_error) / slope;
        Some((exact - offset / slope) / granted)
    });

    needs("INVERSE", rows::INVERSE, 3, |x, choices| {
        let ((n, exact_n), (m, exact_m)) = (number(x[0].abs()), number(x[1].abs()));
        let (error, exact_error) = number(x[2].abs() * 1e-6 * exact_n / exact_m);
        set_choices(choices, true);
        let bound = f64::from((n * (Adversarial(1.0) / m) - error).0);
        let t = exact_n / exact_m;
        Some((bound - (t - exact_error)).abs() / (UNIT_F32 * t))
    });

    needs("BOUNDS", rows::BOUNDS, 4, |x, choices| {
        let [(n, exact_n), (m, exact_m), (e, exact_e), (g, exact_g)] =
            [x[0].abs(), x[1].abs(), x[2].abs() * 1e-3, x[3].abs() * 1e-3].map(number);
        set_choices(choices, true);
        let factor = Adversarial(1.0) - Adversarial((rows::BOUNDS * UNIT_F32) as f32);
        let bound = f64::from((((n + e) / (m - g)) * factor).0);
        let factor = 1.0 - rows::BOUNDS * UNIT_F32;
        let exact = (exact_n + exact_e) / (exact_m - exact_g) * factor;
        (exact > 0.0).then(|| (bound - exact).abs() / (UNIT_F32 * exact))
    });
}

/// `t` of a sphere as neighbours in a row find it, of all that is granted for it. The slack in that is for a
/// device's division and root.
#[test]
fn roots_of_rows() {
    for is_outside in [true, false] {
        needs(if is_outside { "t outside" } else { "t inside" }, 1.0, 13, |x, choices| {
            let ((d, rounded_d), (l, rounded_l)) = (vector(x), vector(&x[3..]));
            let input = ROUNDED_ONCE;
            let exact_d =
                moved(rounded_d, &x[6..], input.direction * UNIT_F32 * rounded_d.length());
            let error = input.offset * UNIT_F32 * rounded_l.length() * (1.0 - 1e-6);
            let exact_l = moved(rounded_l, &x[9..], error);
            let a = exact_d.length_squared();
            let (r, exact_r) = number(distance(exact_l, exact_d) + x[12].abs());
            let guard = FilterBounds::new(exact_r, bounds::length_bound(exact_l), UNIT_F32, input);
            set_choices(choices, true);
            let (s, m) = closest_approach(d, ray(d).inv_a, l);
            let chord2 = r * r - m;
            let (width2, found2) = (guard.outer2 - guard.inner2, f64::from(chord2.0));
            if rounded_d.length() < 1.0 || found2 < 4.0 * width2 {
                return None;
            }
            let half = (chord2 * ray(d).inv_a).sqrt();
            let t = if is_outside { s - half } else { s + half };
            let exact_half = ((exact_r.powi(2) - distance(exact_l, exact_d).powi(2)) / a).sqrt();
            let exact_s = exact_d.dot(exact_l) / a;
            let exact = if is_outside { exact_s - exact_half } else { exact_s + exact_half };
            let granted = guard.slack + rows::CHORD * width2 / found2.sqrt();
            Some((f64::from(t.0) - exact).abs() / granted)
        });
    }
}

/// Slabs along one axis: the ray does not move away from the origins of the others.
fn slabs(origin: Adversarial, way: Adversarial, beside: f32) -> Slabs<Adversarial> {
    let zero = Adversarial(0.0);
    let direction = V3([way, Adversarial(1.0), Adversarial(1.0)]);
    let ray = Ray { origin: V3([origin, zero, zero]), direction, a: zero, inv_a: zero };
    Slabs::new(&ray, Adversarial(beside))
}

/// The origin is so small that its own room doesn't count.
#[test]
fn slabs_of_boxes() {
    let [nearer, farther] =
        [round_down(1.0 - slabs::SLAB * UNIT_F32), round_up(1.0 + slabs::SLAB * UNIT_F32)];
    needs("SLAB", slabs::SLAB, 3, |x, choices| {
        let ((side, exact_side), (origin, exact_origin)) = (number(x[0]), number(x[1] * 1e-6));
        let (way, _) = number(x[2]);
        let exact = (exact_side - exact_origin) / x[2];
        if exact <= 0.0 {
            return None;
        }
        set_choices(choices, true);
        let sides = V3([side, Adversarial(0.0), Adversarial(0.0)]);
        let t = slabs(origin, way, 0.0).between(sides, sides);
        let later = f64::from(t.enter.0[0].0) / exact / f64::from(nearer) - 1.0;
        let sooner = 1.0 - f64::from(t.leave.0[0].0) / exact / f64::from(farther);
        Some(later.max(sooner) / UNIT_F32)
    });
}

#[test]
fn origins_of_slabs() {
    needs("ASIDE", slabs::ASIDE, 2, |x, choices| {
        let (V3([origin, ..]), _) = vector(&[x[0], 0.0, 0.0]);
        let (V3([way, ..]), _) = vector(&[x[1], 1.0, 1.0]);
        set_choices(choices, true);
        let slabs = slabs(origin, way, LEAST_SLACK);
        let ahead = if x[1] < 0.0 { -1.0 } else { 1.0 };
        let near = (f64::from(slabs.near_origin.0[0].0) - x[0]) * ahead;
        let far = (x[0] - f64::from(slabs.far_origin.0[0].0)) * ahead;
        Some(slabs::ASIDE - near.min(far) / (UNIT_F32 * x[0].abs()))
    });
}
