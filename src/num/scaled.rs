//! Vectors times powers of two.

use glam::DVec3;

/// The binary exponent of the largest component of `v`, `−1074` for the smallest subnormal; 0 for the
/// zero vector.
pub fn exponent_of(v: DVec3) -> i32 {
    let largest = v.abs().max_element();
    if largest == 0.0 || !largest.is_finite() {
        return 0;
    }
    match (largest.to_bits() >> 52) as i32 {
        0 => largest.to_bits().ilog2() as i32 - 1074,
        biased => biased - 1023,
    }
}

/// A vector times the power of two that brings its largest component into `1..2`; the zero vector as it is.
///
/// Scaled down, components that are far below the largest may leave f64's normal range: these are rounded, away from 0, to
/// `±2⁻¹⁰²²`. So a component is 0 only where the vector's is, and no other is off by more than `2⁻¹⁰²²`, less than a
/// thousandth of what every bound grants a single rounding.
#[derive(Clone, Copy, Debug)]
pub struct ScaledInteger {
    vector: DVec3,
    exponent: i32,
}

impl ScaledInteger {
    /// Scales any finite vector.
    pub fn new(v: DVec3) -> ScaledInteger {
        let exponent = exponent_of(v);
        let half = -exponent / 2;
        let mut vector = v * power_of_two(half) * power_of_two(-exponent - half);
        for axis in 0..3 {
            let is_kept = exponent <= 0 || vector[axis].abs() >= f64::MIN_POSITIVE;
            if !is_kept && v[axis] != 0.0 {
                vector[axis] = f64::MIN_POSITIVE.copysign(v[axis]);
            }
        }
        ScaledInteger { vector, exponent }
    }

    /// The vector times `2^−exponent`, but for what is rounded.
    pub fn rounded(self) -> DVec3 {
        self.vector
    }

    /// [`exponent_of`] the vector.
    pub fn exponent(self) -> i32 {
        self.exponent
    }
}

/// `2^exponent`
#[inline(always)]
pub fn power_of_two(exponent: i32) -> f64 {
    match exponent {
        -1022..=1023 => f64::from_bits(((1023 + exponent) as u64) << 52),
        _ => power_of_two_far(exponent),
    }
}

/// `2^exponent` beyond the normal numbers. It is called: inlined, it would be worked out for every exponent.
#[cold]
#[inline(never)]
fn power_of_two_far(exponent: i32) -> f64 {
    2f64.powi(exponent)
}
