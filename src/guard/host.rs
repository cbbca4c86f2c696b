//! What the host's own floats are off by.
//!
//! The host rounds to nearest ([`crate::host`]), so that in f32 the unit `ε` of [`super`] may be half a faithful one:
//! each operation then is off by one unit at most, and so is each number that comes from f64, of which the
//! derivations for devices count a half. In f64 the unit is a faithful one, of which the host's operations take
//! half, and what comes from f64 is what it is.

use super::InputError;
use crate::num::Float;
use crate::rays::Lens;

/// A float that the host finds bounds in.
pub trait Bounded: Float {
    /// `ε`
    const ROUNDING: f64;
    /// What a number that comes from f64 is off by, in units.
    const ROUNDED: f64;
    /// Numbers up to this and above its inverse have squares in range, and these inverses.
    const LARGEST_ROOT: f64;
    /// The largest number.
    const LARGEST: f64;
}

impl Bounded for f32 {
    const ROUNDING: f64 = 1.0 / (1u64 << 24) as f64;
    const ROUNDED: f64 = 1.0;
    // No test sees it halved: the range may be smaller.
    const LARGEST_ROOT: f64 = (1u64 << 50) as f64;
    // No bound.
    const LARGEST: f64 = f32::MAX as f64;
}

impl Bounded for f64 {
    const ROUNDING: f64 = f64::UNIT;
    const ROUNDED: f64 = 0.0;
    const LARGEST_ROOT: f64 = (1u128 << 100) as f64 * (1u128 << 100) as f64;
    // No bound.
    const LARGEST: f64 = f64::MAX;
}

/// [`super::input_of`] for pixels in the host's f32, in its units: [`super::PIXELS`] and [`super::PARALLEL`] with 1 for
/// each ½.
///
/// - A direction has `|e| ≤ ε(2|f| + 3|iR| + 2|jT| + |d|)`, by Cauchy's inequality at most `(√(2² + 3² + 2²) + 1)ε|d|`; the
///   offset is rounded once.
/// - Parallel rays start at an `o` that is off by `ε(2|iR| + 2|jT| + |o|)`, at most `(2·√2·1.0005 + 1)ε|o| = 3.84ε|o|`:
///   `λ·ℓ = |c| + 3.84|o| + 1.001(|c| + |o|) ≤ 4.85ℓ`. Their direction is rounded once.
pub fn input_in_f32(lens: Lens) -> InputError {
    match lens {
        Lens::Perspective => InputError { offset: 1.001, direction: 5.2 },
        Lens::Orthographic => InputError { offset: 4.85, direction: 1.001 },
    }
}

/// Unit of the host's rounding of f64, which is to the nearest.
pub const HOST_UNIT_F64: f64 = 0.5 * f64::UNIT;

/// The same in f64, in units of [`HOST_UNIT_F64`]: the view axis is what it is, a step to the side takes two roundings.
///
/// - A direction has `|e| ≤ ε(|f| + 4|iR| + 3|jT| + |d|)`: `(√(1 + 4² + 3²) + 1)ε|d|`.
/// - Parallel rays start at an `o` that is off by `ε(3|iR| + 3|jT| + |o|)`, at most `5.25ε|o|`:
///   `λ·ℓ = |c| + 5.25|o| + 1.001(|c| + |o|) ≤ 6.26ℓ`.
/// - Rays of a list are what they are but for the difference to a centre; components of a direction below `2⁻¹⁰²²` of the
///   largest are in the 0.002.
pub fn input_in_f64(lens: Option<Lens>) -> InputError {
    match lens {
        Some(Lens::Perspective) => InputError { offset: 1.001, direction: 6.11 },
        // No test sees the 0.001 and the 0.002 cut, which are room.
        Some(Lens::Orthographic) => InputError { offset: 6.26, direction: 0.001 },
        // No test sees it cut: see above.
        None => InputError { offset: 1.001, direction: 0.002 },
    }
}
