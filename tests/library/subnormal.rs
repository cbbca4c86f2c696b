//! Directions and normals of any length, below f64's normal range as well, are scaled to about one.

use glam::{DVec3, dvec3};
use kugelblitz::prepare::{ScaledInteger, exponent_of, power_of_two};
use kugelblitz_tests::in_cube;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn times_power_of_two(v: DVec3, exponent: i32) -> DVec3 {
    v * power_of_two(exponent / 2) * power_of_two(exponent - exponent / 2)
}

/// `1 ≤ |d|`, as the bounds of the slack assume, whatever the length was; and exactly.
#[test]
fn directions_are_scaled_to_at_least_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(1181);
    for _ in 0..20_000 {
        let length = 2f64.powi(rng.random_range(-1074..=1023));
        let direction = in_cube(&mut rng) * length;
        if direction == DVec3::ZERO {
            continue;
        }
        let scaled = ScaledInteger::new(direction);
        let (scaled, exponent) = (scaled.rounded(), scaled.exponent());
        let largest = scaled.abs().max_element();
        assert!((1.0..2.0).contains(&largest), "{direction:?}: 2^{exponent}, {scaled:?}");
        if exponent < 0 {
            assert_eq!(times_power_of_two(scaled, exponent), direction);
        }
    }
    for (v, is_exact) in [
        (dvec3(0.5, 5e-324, 0.0), true),
        (dvec3(2f64.powi(-1000), 0.0, -5e-324), true),
        (dvec3(4.0, -5e-324, 0.0), false),
        (dvec3(1e300, 1e-100, 0.0), false),
        (dvec3(1e300, 1e-7, 0.0), true),
    ] {
        let scaled = ScaledInteger::new(v);
        let back = times_power_of_two(scaled.rounded(), scaled.exponent());
        assert_eq!(back == v, is_exact, "{v}");
        for axis in 0..3 {
            let (of, x) = (v[axis], scaled.rounded()[axis]);
            assert!((x == 0.0) == (of == 0.0) && x.is_sign_negative() == of.is_sign_negative());
        }
    }
    assert_eq!(
        [0.0, 5e-324, f64::MIN_POSITIVE].map(|x| exponent_of(DVec3::X * x)),
        [0, -1074, -1022]
    );
}
