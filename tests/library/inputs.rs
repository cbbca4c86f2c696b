//! What the numbers of rays are off by on a device, in arithmetic as bad as the proof allows.

use glam::DVec3;
use kugelblitz::guard;
use kugelblitz::num::{Float, V3};
use kugelblitz::rays::{Frame, Lens, Pixels, View};
use kugelblitz_tests::adversarial::{Adversarial, Rounding, set_rounding};
use kugelblitz_tests::{in_cube, log_uniform};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
    in_cube(rng).normalize_or(DVec3::X)
}

/// Largest error of the input in units `ε`, over `n` cases a rounding mode.
fn largest_error(n: usize, error: impl Fn(&mut ChaCha8Rng) -> f64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(1213);
    let mut largest = 0.0;
    for rounding in Rounding::ALL {
        set_rounding(rounding, rng.random());
        largest = (0..n).map(|_| error(&mut rng)).fold(largest, f64::max);
    }
    largest
}

fn to_f64(v: V3<Adversarial>) -> DVec3 {
    DVec3::from(v.0.map(|x| f64::from(x.0)))
}

fn rounded(v: DVec3) -> V3<Adversarial> {
    V3(v.as_vec3().to_array().map(Adversarial))
}

/// No error is above its bound, and half of that would not do.
fn assert_needed(name: &str, largest: f64, bound: f64) {
    println!("{name}: {largest:.3} of {bound}");
    assert!(largest <= bound && largest > bound / 2.0, "{name}: {largest} of {bound}");
}

fn picture(rng: &mut ChaCha8Rng, lens: Lens) -> Pixels {
    let along = unit(rng);
    let up = along.cross(unit(rng)).normalize_or(along.any_orthonormal_vector());
    let size = 2 * rng.random_range(1..2000) + 1;
    let view = View {
        position: DVec3::ZERO,
        forward: along,
        right: along.cross(up),
        true_up: up,
        h: log_uniform(rng, 1e-3, 100.0).abs(),
        lens,
    };
    Pixels::whole(view, size, size)
}

/// The step to a pixel from the middle of a picture, as the device computes it, and that along the view axis.
fn across(pixels: &Pixels, [x, y]: [u32; 2]) -> (V3<Adversarial>, V3<Adversarial>) {
    let camera = Frame::<f32>::of_pixels(pixels);
    let [forward, right, up] =
        [camera.forward, camera.right, camera.true_up].map(|v| V3(v.0.map(Adversarial)));
    let (i, j) = pixels.offset2(x, y);
    let [i, j] = [i, j].map(|offset| Adversarial(offset as f32));
    ((forward + right * i) + up * j, right * i + up * j)
}

/// `δ` of pixels: the direction `f + i·R + j·T`. The bound is Cauchy's, for the worst frame.
#[test]
fn directions_of_pixels_are_within_their_bound() {
    let largest = largest_error(50_000, |rng| {
        let pixels = picture(rng, Lens::Perspective);
        let [x, y] = [0; 2].map(|_| rng.random_range(0..pixels.image_width));
        let exact = pixels.direction(x, y);
        to_f64(across(&pixels, [x, y]).0).distance(exact) / (f32::UNIT * exact.length())
    });
    assert_needed("δ of pixels", largest, guard::PIXELS.direction);
}

/// `λ` of lists.
#[test]
fn offsets_of_lists_are_within_their_bound() {
    let largest = largest_error(50_000, |rng| {
        let [center, origin] = [0; 2].map(|_| unit(rng) * log_uniform(rng, 1e-3, 1e3));
        let found = to_f64(rounded(center) - rounded(origin));
        found.distance(center - origin) / (f32::UNIT * (center.length() + origin.length()))
    });
    assert_needed("λ of lists", largest, guard::LIST.offset);
}

/// `λ` of parallel rays, in corners of their picture.
#[test]
fn offsets_of_parallel_rays_are_within_their_bound() {
    let largest = largest_error(50_000, |rng| {
        let pixels = picture(rng, Lens::Orthographic);
        let corner = [0, pixels.image_height - 1];
        let origin = pixels.origin_offset(corner[0], corner[1]);
        // Where the origin is most of it.
        let center = in_cube(rng) * origin.length() * log_uniform(rng, 1e-4, 0.3);
        let found = to_f64(rounded(center) - across(&pixels, corner).1);
        found.distance(center - origin) / (f32::UNIT * (center.length() + origin.length()))
    });
    assert_needed("λ of parallel rays", largest, guard::PARALLEL.offset);
}
