//! What random and constructed cases of tests against exact arithmetic are made of.

use glam::{DVec3, dvec3};
use kugelblitz::exact::Shape;
use rand::{Rng, RngExt};

pub fn sphere(center: DVec3, radius: f64) -> Shape {
    Shape::Sphere { center, radius }
}

pub fn plane(point: DVec3, normal: DVec3) -> Shape {
    Shape::Plane { point, normal }
}

fn integer(rng: &mut impl Rng, limit: i32) -> f64 {
    f64::from(rng.random_range(-limit..=limit))
}

fn nonzero(rng: &mut impl Rng, limit: i32) -> f64 {
    loop {
        let n = integer(rng, limit);
        if n != 0.0 {
            return n;
        }
    }
}

/// Three orthogonal integer vectors of the same integer length (the columns of a rotation by an
/// integer quaternion, times its norm; Pythagorean quadruples), and that length.
pub fn integer_frame(rng: &mut impl Rng, limit: i32) -> ([DVec3; 3], f64) {
    let [a, b, c, d]: [f64; 4] =
        [nonzero(rng, limit), integer(rng, limit), integer(rng, limit), integer(rng, limit)];
    let columns = [
        dvec3(a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)),
        dvec3(2.0 * (b * c - a * d), a * a - b * b + c * c - d * d, 2.0 * (c * d + a * b)),
        dvec3(2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a - b * b - c * c + d * d),
    ];
    (columns, a * a + b * b + c * c + d * d)
}

/// One ulp up or down, or not at all, half of the time.
pub fn nudged(rng: &mut impl Rng, x: f64) -> f64 {
    match rng.random_range(0..4) {
        0 => x.next_up(),
        1 => x.next_down(),
        _ => x,
    }
}
