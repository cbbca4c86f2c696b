//! What floats are off by, and how large they may become.
//!
//! A formula in f32 may run on a device: its unit `ε`, its quotients and its roots are those of [`super`], wherever it runs, and a
//! number that comes from f64 is off by half a unit. In f64, which is the host's alone, what comes from f64 is what it is. The
//! host rounds to nearest ([`crate::host`]), so that all its operations take half a unit.

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
    /// An error that leaves all open that lies within [`Float::FARTHEST`], with a square in range.
    const UNKNOWN: f64;
}

impl Bounded for f32 {
    const ROUNDING: f64 = f32::UNIT;
    const ROUNDED: f64 = 0.5;
    // No test sees it halved: the range may be smaller.
    const LARGEST_ROOT: f64 = (1u64 << 50) as f64;
    // No bound.
    const LARGEST: f64 = f32::MAX as f64;
    // No test sees it halved: half of it is still twice the range.
    const UNKNOWN: f64 = (1u64 << 62) as f64;
}

impl Bounded for f64 {
    const ROUNDING: f64 = f64::UNIT;
    const ROUNDED: f64 = 0.0;
    const LARGEST_ROOT: f64 = (1u128 << 100) as f64 * (1u128 << 100) as f64;
    // No bound.
    const LARGEST: f64 = f64::MAX;
    // No test sees it halved: half of it is still twice the range.
    const UNKNOWN: f64 = (1u128 << 121) as f64 * (1u128 << 121) as f64;
}

/// Unit of the host's rounding of f64, which is to the nearest.
pub const HOST_UNIT_F64: f64 = 0.5 * f64::UNIT;

/// [`super::input_of`] for rays in f64, in units of [`HOST_UNIT_F64`]: the view axis is what it is, a step to the side takes two
/// roundings.
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
