//! What parallel rays' f32 filter and footprints rest on: the filter in arithmetic as bad as its
//! proof allows, the bound of its input, and the pixels that a sphere may cover, all against exact
//! arithmetic.

use glam::DVec3;
use kugelblitz::exact::{ExactPixels, ExactRay, Shape, real, sphere_numbers, visible_root};
use kugelblitz::guard::{self, Guard, WIDENING};
use kugelblitz::kernel::RayOf;
use kugelblitz::kernel::certified::{GuardOf, Nearness, Widening, parallel_nearness};
use kugelblitz::num::Float;
use kugelblitz::rays::{CameraF32, Lens, Pixels, View};
use kugelblitz::trace::Ray;
use kugelblitz::tree::footprint::Projection;
use kugelblitz::vec3::Vec3;
use kugelblitz_tests::adversarial::{Adversarial, Rounding, set_rounding};
use kugelblitz_tests::{in_cube, log_uniform};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A picture of an orthographic camera at the origin of coordinates, in any direction.
fn picture(rng: &mut ChaCha8Rng, h: f64) -> Pixels {
    let forward = in_cube(rng).normalize();
    let right = forward.cross(in_cube(rng)).normalize();
    let true_up = right.cross(forward);
    let lens = Lens::Orthographic;
    let view = View { position: DVec3::ZERO, forward, right, true_up, h, lens };
    let [width, height] = [rng.random_range(1..3000), rng.random_range(1..3000)];
    Pixels::whole(view, width, height)
}

/// A pixel and a sphere close to where it is hard.
#[derive(Debug)]
struct Case {
    pixels: Pixels,
    pixel: [u32; 2],
    center: DVec3,
    radius: f64,
}

impl Case {
    /// Silhouettes, roots at 0, and any.
    fn new(rng: &mut ChaCha8Rng) -> Case {
        let h = log_uniform(rng, 1e-3, 1e3).abs();
        let pixels = picture(rng, h);
        let (width, height) = (pixels.image_width, pixels.image_height);
        // In a corner the bounds, which are for all pixels, have the least to spare.
        let pixel = match rng.random() {
            true => [0, height - 1],
            false => [rng.random_range(0..width), rng.random_range(0..height)],
        };
        let origin = pixels.origin_offset(pixel[0], pixel[1]);
        let View { forward, right, true_up, .. } = pixels.view;
        let radius = log_uniform(rng, 1e-3, 10.0).abs() * h;
        let angle = rng.random_range(0.0..std::f64::consts::TAU);
        let aside = right * angle.cos() + true_up * angle.sin();
        let off = 2f64.powi(rng.random_range(-30..-2)) * if rng.random() { 1.0 } else { -1.0 };
        let distance = match rng.random_range(0..3) {
            0 => radius * rng.random_range(0.0..1.3),
            _ => radius * (1.0 + off),
        };
        let half_chord = (radius * radius - distance * distance).max(0.0).sqrt();
        let depth = match rng.random_range(0..4) {
            0 => half_chord * (1.0 + off),
            1 => -half_chord * (1.0 + off),
            2 => log_uniform(rng, 1e-2, 1.0).abs() * origin.length(),
            _ => log_uniform(rng, 1e-2, 1e4) * h,
        };
        Case { pixels, pixel, center: origin + aside * distance + forward * depth, radius }
    }

    /// `1/(a·t)` to f64's rounding; 0 for a miss.
    fn nearness(&self) -> f64 {
        let [x, y] = self.pixel;
        let ray = ExactPixels::new(&self.pixels).ray(x, y);
        let shape = Shape::Sphere { center: self.center, radius: self.radius };
        let a = self.pixels.view.forward.length_squared();
        visible_root(&ray, &shape).map_or(0.0, |(root, _)| 1.0 / (a * root.to_f64()))
    }

    /// The ray's origin as the device finds it.
    fn origin(&self) -> Vec3<Adversarial> {
        let camera = CameraF32::new(&self.pixels);
        let [right, up] =
            [camera.right_step, camera.true_up_step].map(|v| Vec3(v.0.map(Adversarial)));
        let (i, j) = self.pixels.offset2(self.pixel[0], self.pixel[1]);
        let [i, j] = [i, j].map(|offset| Adversarial(offset as f32));
        right * i + up * j
    }

    fn offset(&self, origin: Vec3<Adversarial>) -> Vec3<Adversarial> {
        Vec3(self.center.as_vec3().to_array().map(Adversarial)) - origin
    }

    /// What the filter says, with these parts of its radii and of its slack.
    fn filtered(&self, of_radii: f64, of_slack: f64) -> Nearness<Adversarial> {
        let (r, l) = (self.radius, self.center.length() + self.pixels.spread());
        let guard = Guard::new(r, l, f32::UNIT, guard::PARALLEL);
        let toward = |bound2: f64| r * r + (bound2 - r * r) * of_radii;
        let inner2 = if guard.inner2 > 0.0 { toward(guard.inner2) } else { guard.inner2 };
        let (outer2, slack) = (toward(guard.outer2), guard.slack * of_slack);
        let [inner2, outer2, slack, _] =
            Guard { inner2, outer2, slack, ..guard }.round_to_f32().map(Adversarial);
        let origin = self.origin();
        let forward = CameraF32::new(&self.pixels).forward;
        let ray = RayOf::new(origin, Vec3::ZERO, Vec3(forward.0.map(Adversarial)));
        let width = WIDENING * f32::UNIT;
        let widening = Widening {
            narrower: Adversarial(guard::round_down(1.0 - width)),
            wider: Adversarial(guard::round_up(1.0 + width)),
            far_narrower: Adversarial(0.0),
        };
        let guard = GuardOf { inner2, outer2, slack };
        parallel_nearness(&ray, self.offset(origin), &guard, &widening)
    }
}

/// The first case of `n` a rounding mode about which the filter is wrong.
fn first_wrong(seed: u64, n: usize, of_radii: f64, of_slack: f64) -> Option<String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut n_known = 0;
    for rounding in Rounding::ALL {
        set_rounding(rounding, rng.random());
        for _ in 0..n {
            let case = Case::new(&mut rng);
            let exact = case.nearness();
            let Nearness { low, high } = case.filtered(of_radii, of_slack);
            let (low, high) = (f64::from(low.0), f64::from(high.0));
            assert!(low.is_finite() && high.is_finite(), "{low:e} {high:e} {case:?}");
            n_known += usize::from(low > 0.0 && high < 1.1 * low);
            if low > exact * (1.0 + 1e-12) || high < exact * (1.0 - 1e-12) {
                return Some(format!("{rounding:?}: {exact:e} not in {low:e}..{high:e}, {case:?}"));
            }
        }
    }
    assert!(n_known > n, "{n_known} of {} are known", n * Rounding::ALL.len());
    None
}

#[test]
fn no_statement_is_wrong_in_any_rounding() {
    assert_eq!(first_wrong(1210, 40_000, 1.0, 1.0), None);
}

/// A fifth of the radii's room is too little. A third is silent as long as there is the slack, which
/// the width between the radii covers otherwise.
#[test]
fn sabotage_a_smaller_bound_is_noticed() {
    assert!(first_wrong(1211, 40_000, 0.2, 1.0).is_some(), "the radii");
    assert_eq!(first_wrong(1212, 40_000, 0.33, 1.0), None);
    assert!(first_wrong(1212, 40_000, 0.33, 0.0).is_some(), "the slack");
}

/// `λ`: the offset as the device computes it.
#[test]
fn offsets_are_within_their_bound() {
    let mut rng = ChaCha8Rng::seed_from_u64(1213);
    let mut largest = 0.0;
    for rounding in Rounding::ALL {
        set_rounding(rounding, rng.random());
        for _ in 0..50_000 {
            let mut case = Case::new(&mut rng);
            // Where the origin is most of it.
            case.center *= log_uniform(&mut rng, 1e-3, 1.0).abs();
            let [x, y] = case.pixel;
            let origin = case.pixels.origin_offset(x, y);
            let found = case.offset(case.origin()).0.map(|component| f64::from(component.0));
            let error = DVec3::from(found).distance(case.center - origin);
            let most = f32::UNIT * (case.center.length() + origin.length());
            largest = f64::max(largest, error / most);
        }
    }
    println!("λ of parallel rays: {largest:.3} of {}", guard::PARALLEL.offset);
    assert!(largest <= guard::PARALLEL.offset);
    assert!(largest > guard::PARALLEL.offset / 2.0, "half the bound would do: {largest}");
}

/// No pixel outside of a sphere's footprint sees it, none sees it nearer, and next to the footprint's
/// edges, inside, the sphere begins.
#[test]
fn footprints_hold_what_is_seen_and_little_else() {
    let mut rng = ChaCha8Rng::seed_from_u64(1214);
    let (mut n_seen, mut n_tight) = (0, 0);
    for turn in 0..4000 {
        let h = log_uniform(&mut rng, 1e-3, 1e3).abs();
        let mut pixels = picture(&mut rng, h);
        let [width, height] = [rng.random_range(1..14), rng.random_range(1..14)];
        (pixels.image_width, pixels.image_height) = (width, height);
        (pixels.width, pixels.height) = (width, height);
        // Frames are orthonormal to 2⁻¹⁰ only.
        if turn % 2 == 0 {
            pixels.view.right += in_cube(&mut rng) * 2f64.powi(-13);
            pixels.view.forward += in_cube(&mut rng) * 2f64.powi(-13);
        }
        assert!(pixels.is_in_range());
        let pixel = 2.0 * h / f64::from(height);
        let radius = log_uniform(&mut rng, 0.1, 20.0).abs() * pixel;
        let (x, y) = (rng.random_range(0..width), rng.random_range(0..height));
        let aside = in_cube(&mut rng) * radius * 1.5;
        let center = pixels.origin_offset(x, y) + aside + pixels.view.forward * radius * 1.2;
        let found = Projection::new(&pixels).footprint(center, radius);
        let exact = ExactPixels::new(&pixels);
        let shape = Shape::Sphere { center, radius };
        let mut extent: Option<[u32; 4]> = None;
        for index in 0..pixels.len() {
            let (x, y) = pixels.xy(index);
            let Some((root, _)) = visible_root(&exact.ray(x, y), &shape) else { continue };
            let footprint = found.unwrap_or_else(|| panic!("turn {turn}: nothing is seen"));
            let [columns, rows] =
                [footprint.columns, footprint.rows].map(|ends| ends.map(u32::from));
            let is_within =
                (columns[0]..=columns[1]).contains(&x) && (rows[0]..=rows[1]).contains(&y);
            assert!(is_within, "turn {turn}: pixel {x}, {y} not in {footprint:?}");
            assert!(root.to_f64() >= f64::from(footprint.t), "turn {turn}: {footprint:?}");
            let [left, right, top, bottom] = extent.unwrap_or([x, x, y, y]);
            extent = Some([left.min(x), right.max(x), top.min(y), bottom.max(y)]);
            n_seen += 1;
        }
        // A large sphere's edge is seen in the column that it touches, or in the next one.
        if let (Some([left, right, top, bottom]), Some(footprint)) = (extent, found)
            && radius > 5.0 * pixel
            && right - left > 2
            && bottom - top > 2
        {
            let [columns, rows] =
                [footprint.columns, footprint.rows].map(|ends| ends.map(u32::from));
            let ends = [columns[0] + 1 >= left, columns[1] <= right + 1];
            let others = [rows[0] + 1 >= top, rows[1] <= bottom + 1];
            n_tight += usize::from(ends.iter().chain(&others).filter(|&&tight| tight).count() >= 2);
        }
    }
    assert!(n_seen > 20_000 && n_tight > 200, "{n_seen} seen, {n_tight} tight");
}

/// `k` of a pixel's origin in f64, moved from the camera's position, is within its bound of the exact
/// one, and on the ground of a huge sphere far better than `l·l − r²`.
#[test]
fn moved_k_is_within_its_bound() {
    let mut rng = ChaCha8Rng::seed_from_u64(1215);
    let mut largest = 0.0;
    for turn in 0..20_000 {
        let h = log_uniform(&mut rng, 1e-3, 1e3).abs();
        let pixels = picture(&mut rng, h);
        let (x, y) =
            (rng.random_range(0..pixels.image_width), rng.random_range(0..pixels.image_height));
        let o = pixels.origin_offset(x, y);
        let radius = h * log_uniform(&mut rng, 1e-2, 1e6).abs();
        let center =
            in_cube(&mut rng).normalize() * (radius + h * log_uniform(&mut rng, 0.1, 10.0));
        let exact_ray = ExactPixels::new(&pixels).ray(x, y);
        let exact = sphere_numbers(&exact_ray, center, radius).unwrap().k;
        let at_eye = ExactRay::new(&Ray { origin: DVec3::ZERO, direction: DVec3::X });
        let k = sphere_numbers(&at_eye, center, radius).unwrap().k.to_f64();
        let error = k.abs() * f64::UNIT;
        let moved = k - o.dot(center + (center - o));
        let bound = guard::moved_k_error(k, error, center.length(), o.length());
        let off = exact.minus(&real(moved).unwrap()).to_f64().abs();
        assert!(off <= bound, "turn {turn}: {off:e} above {bound:e}");
        largest = f64::max(largest, off / bound);
        if radius > 1e4 * pixels.spread() {
            let direct = 4.0 * f64::UNIT * 2.0 * radius * radius;
            assert!(bound < direct / 100.0, "{bound:e}, directly {direct:e}");
        }
    }
    println!("moved k: {largest:.3} of the bound");
    // The host rounds to the nearest: half of a faithful rounding in each of a dozen steps.
    assert!(largest > 0.03, "{largest}");
}
