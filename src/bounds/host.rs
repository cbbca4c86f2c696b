//! What the host's numbers are off by.
//!
//! A formula in f32 may run on a device: its unit `ε`, its quotients and its roots are those of [`super`], wherever it runs, and a
//! number that comes from f64 is off by half a unit. In f64, which is the host's alone, what comes from f64 is what it is. The
//! host rounds to nearest ([`crate::support::fpu_check`]), so that all its operations take half a unit.

use super::InputError;
use crate::num::Float;
use crate::rays::Lens;

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
