//! Proven bounds for the filter of the certified kernel.
//!
//! # What is proven
//! Let `ε` be the unit of a *faithful* rounding (either neighbour of the true result): `2⁻²³` for
//! f32 and `2⁻⁵²` for f64. Division may be off by 2.5 units, the square root by 4.5, any
//! contraction of products and sums is allowed. So the bounds hold on every Vulkan device that
//! keeps to WGSL's accuracy table and does not reorder (`NoContraction`), whatever its rounding
//! direction.
//!
//! Notation: true offset `L = c − o`, true direction `d`, `ℓ ≥ |L|`, `η = ε·ℓ`; hats are computed
//! values. The inputs of the filter are not exact either:
//! `|L̂ − L| ≤ λ·η` and `|d̂ − d| ≤ δ·ε·|d|` with the [`InputError`] of each source of rays.
//!
//! # Distance of the line from the centre
//! The filter computes `â = d̂·d̂`, `ι = 1/â`, `ŝ = (d̂·L̂)·ι`, `P̂ = L̂ − ŝ·d̂`, `m = P̂·P̂`.
//! With `p` the true distance and `p̂` that of `L̂` from the line along `d̂`:
//! 1. `|p̂ − p| ≤ (λ + δ)·η`: moving the point by `λη`, turning the line by `δε`.
//! 2. `ŝ` is off its exact value by at most `9.5·η/|d̂|`: `3` for the dot product, `3 + 2.5` for
//!    `ι`, `1` for the product, each relative to `|ŝ||d̂| ≤ ℓ`. Call the bound `τ = 9.5η`.
//! 3. Rounding `ŝ·d̂` and the subtraction: `|P̂ − (L̂ − ŝd̂)| ≤ η + ε|P̂|`.
//! 4. `|L̂ − ŝd̂|² = p̂² + τ'²` with `τ' ≤ τ`, because `P ⟂ d`: an error of `ŝ` counts only
//!    squared. This is why the projected form wins over `b² − 4ac`.
//! 5. `m = |P̂|²(1 ± 3ε)`.
//!
//! From 3–5, `√m (1 + 2.51ε) + η ≥ p̂`, so with `κ = 1.01 + λ + δ`:
//! **`m ≤ (r − κη)²(1 − 5.1ε)` implies `p < r`: a certain hit** ([`Guard::inner2`]).
//! Likewise `√m (1 − 2.51ε) − η ≤ √(p̂² + τ²)`; squaring and collecting gives:
//! **`m > ((r + κη)² + 111η²)(1 + 5.1ε)` implies `p > r`: a certain miss** ([`Guard::outer2`]),
//! where 111 covers `9.5² = 90.3` and the cross terms `2·9.51 + 1`.
//!
//! # Half the chord
//! `p²` as a function of `√m` grows at least and at most like the two bounds above, so their
//! widths at the silhouette hold inside as well: `inner2 − m ≤ r² − p² ≤ outer2 − m`. For the first,
//! `p ≤ √m(1 + 2.51ε) + κη` with `√m ≤ r − κη` gives `p² − m ≤ 5.03εr² + 2κη(r − κη) + κ²η²`, which is
//! at most `r² − inner2`. Half the
//! chord lies between `√((inner2 − m)·ι)` and `√((outer2 − m)·ι)`, up to the rounding of these two
//! expressions: `((1 + 5.5 + 2δ + 1)/2 + 4.5)ε = (8.25 + δ)ε` relative, at most `(8.25 + δ)ε·r`.
//!
//! # The root
//! Roots are compared by their nearness `w = 1/(a·t)`. Let `u = |s| + h`, which does not cancel.
//! Outside (`k = |L|² − r² > 0`) both roots have the sign of `s`, and `w = (s + h)/k`, at most 0
//! where the sphere lies behind. Inside, the far root has `w = 1/(a·u)` where `s > 0` and `u/|k|`
//! elsewhere. The absolute error of `u` and of `s + h` is at most [`Guard::slack`]:
//! `ε·((9.5 + λ + δ)ℓ + (8.25 + δ)r + 2(ℓ + r))` for `|d| ≥ 1`, the last term for two sums.
//! The relative error of the rest (`k` 2, `ι` 5.5 + 2δ, two products 2, quotient 2.5) is below
//! [`WIDENING`].
//!
//! Where the eye is far from all spheres, the slack can be a relative one: from
//! `(s + h)(s − h) = k/a` and `s + h ≥ s − h` follows `s + h ≥ √(k/a)`, so that the slack is at
//! most the part `ρ = slack·|d|/√k` of it. If `ρ ≤` [`FAR`] for every sphere and ray, then
//! `(ŝ + ĥ)/(1 − ρ)` and `(ŝ + ĥ)/(1 + ρ)` bound `s + h`. This saves two loads a sphere.
//!
//! A far sphere behind the eye stays behind: there `|s| − h = (k/a)/(|s| + h)` is at least
//! `k/((ℓ + r)|d|)`. The slack is above `14ε(ℓ + r)`, so `ρ ≤ 2⁻¹⁵` gives `ℓ + r ≤ 18.3√k` and
//! `|s| − h ≥ √k/(18.3|d|)`, a thousand times the slack `ρ√k/|d|`. That needs `FAR` to be small
//! against `1/18.3`.
//!
//! # Planes
//! `w = M/(a·N)` with `M = n·d` and `N = n·L`.
//! `M` is off by at most `(3 + ½ + δ)ε|n||d|`, the ½ for rounding `n`; `N` for lists of rays
//! by `(3 + ½ + λ)ε|n|ℓ`.
//!
//! # Parallel rays
//! Relative to the camera's position, a ray of an orthographic camera starts at `o = i·R + j·T` with
//! `R = (h/H)·right`, `T = (h/H)·true_up`, and the offset is `L = c − o`. Let `ℓ = |c| + |o|`, or
//! anything above it: the device takes the largest `|o|` of the picture, [`Pixels::spread`].
//!
//! Input. `R` and `T` are rounded (½ each; in f64 `h/H` and its product instead), then two products
//! and a sum: component by component `|e| ≤ ε(1.5|iR| + 1.5|jT| + |o|)`. As `R ⟂ T` to `2⁻¹⁰`, that is
//! at most `(1.5·√2·1.0005 + 1)ε|o| = 3.13ε|o|`. `c` is rounded (½), and so is the difference (1):
//! `λ·ℓ = 0.5|c| + 3.13|o| + 1.001(|c| + |o|) ≤ 4.14ℓ`. A low part of `c` would save ½ of `|c|` and
//! cost another rounding. The direction is the view axis, rounded once.
//!
//! Root. `k` is another one for each origin, and `l·l − r²` would cost it `ε·ℓ²`. But `t = s ∓ h`
//! cancels no more than `c − o` has done before: what slack says of `|s| + h` holds for `s − h` as
//! well, as it bounds the sum of the absolute errors of `s`, of `h` and of two sums. So
//! `(s − h_out) − slack ≤ near ≤ (s − h_in) + slack`, and the far root likewise, with `h_in` and
//! `h_out` from the two radii, 0 below 0. Where the near root is certainly positive, it is the one
//! that is seen; where it is certainly 0 or less, the far one is, if it is positive; else either may
//! be. `1/(a·t)` from there on as from inside: `ι` 5.5 + 2δ, product 1, quotient 2.5. The bounds of
//! `t` that are divided by are above `2⁻¹⁰⁰`, and the slack of a sphere in range is above `2⁻⁶⁰`, so
//! that no quotient overflows.
//!
//! In f64 a `t` must be good to f32's last digit on the ground of a huge sphere, too, where `εℓ` is
//! too much. There `k` is found once for the camera's position, exactly if need be, and moved:
//! `k − o·(c + L)`, as `|c − o|² − |c|² = −o·(2c − o)`. With `|c + L| ≤ 2ℓ` the errors are, in units
//! of `ε|o|ℓ`: `o` 3.13·2, `c + L` ½ + 4.14 + ½·2, the dot product 3·2, and the difference
//! `ε(|k| + 2|o|ℓ)`: 19.9 in all, and `ε|k|` ([`moved_k_error`]). The rest is the filter of lists.
//!
//! # Range
//! Underflow adds at most `2⁻¹²⁶` (f32) a step. With `r ≥ 2⁻⁴⁰`, `ℓ ≤ 2⁶⁰`, `1 ≤ |d| ≤ 2³⁰` this is
//! below the slack of the constants, and nothing overflows. Under a square root it is more: `2⁻⁶³`.
//! But `outer2 − m` is 0 or at least `2⁻¹⁰⁴` for `r ≥ 2⁻⁴⁰`, so that its product with `ι` underflows
//! only for `|d| > 2¹¹`, where the error is at most `slack/|d|` and all of the slack, above `2⁻⁶⁰`,
//! is granted. This is why far spheres take the longest `|d|` into account although `ρ` itself does
//! not depend on it. Objects outside that range are undecided, never wrong.
//!
//! # Nothing rests on ∞ or NaN
//! Vulkan lets a compiler assume that there are none (without `SignedZeroInfNanPreserve`, which is
//! declared nowhere here). So no operation of the f32 stage takes or gives one, not even where its
//! result is selected away; `tests/library/finite.rs` looks at each of them:
//! - Pixels: `2⁻¹⁰⁰ ≤ |k| ≤ 2¹²⁰` and `ℓ + r ≤ 2⁹⁰|k|`, or `k = 0`; `|N| ≥ 2⁻⁹⁰` or 0. So a nearness
//!   is at most `2⁹²/|d|`, and `a·w = 1/t` at most `2¹²²`.
//! - Lists: `1/(|k| − error)` is looked at only where `|k| > error`, and is 1 elsewhere. As `error`
//!   is above `2ε(ℓ² + r²)`, the difference is then above `2⁻⁴⁶(ℓ² + r²) ≥ 2⁻¹²⁶` and a nearness
//!   below `2⁸⁸`. Of planes `error ≥` [`TINY_F32`], the difference above `2⁻⁹⁰`.
//! - From inside, `u − slack` is not positive, and another number stands in its place, or above
//!   `2⁻²⁴·slack`; `u + slack ≥ slack > 2⁻⁶³`.
//! - `T_ROOM/(1/t)` has a denominator of at least [`LEAST_NEARNESS`]: a `t` beyond all nodes.
//! - An object that is out of range is left open by numbers that are large enough: for pixels its
//!   nearness is at most `2¹²⁰` and at least `2¹²⁰/|d|`, above all others; for lists its `k` and `N`
//!   are known up to [`UNKNOWN`] only.
//! - Parallel rays divide by bounds of `t` that are at least `2⁻¹⁰⁰`. A sphere that is out of range
//!   is one of radius 2⁶² about the reference point, with a slack of `2⁶⁰`.
//! - A list's direction of zero is replaced by another in its record, and its ray is undecided.
//!
//! Rays for which [`crate::prepare::Prepared::in_range`] is false may overflow: whatever comes out
//! is overwritten by "undecided". On the host ∞ is an ordinary number: see [`crate::host`].
//!
//! # Other rays than those of pixels' centres
//! [`squares`] has what changes where one ray stands for all samples of a square of pixels.
//!
//! # What is assumed of a device
//! Each assumption is *specified*, by Vulkan's table of precision or by WGSL, or *measured* before the
//! first use, by `src/gpu/self_test.rs` on the way that the kernels' shaders take, or both, as a driver
//! may have a defect. What is measured holds for some thousand samples and is no proof. Where it fails,
//! the CPU takes the f32 stage
//! ([`Arithmetic::suits_filter`](crate::gpu::Arithmetic::suits_filter)).
//!
//! | of f32 on the device | |
//! | --- | --- |
//! | Operations are done as written; none is reordered, or left out because real numbers would not need it. Contraction would be allowed. | specified for results decorated `NoContraction`; measured by two-sum. Only shaders that are passed through can be decorated: without, the CPU takes the stage, whatever was measured. |
//! | `+`, `−`, `×` give one of the two neighbours of the exact result. | specified as correctly rounded in either direction; measured |
//! | `x/y` is within 2.5 units for `2⁻¹²⁶ ≤ \|y\| ≤ 2¹²⁶`, with a constant numerator, for which drivers may take a reciprocal, too. | specified; measured for both at exponents from −104 to 120 |
//! | `√x` is within 4.5 units. | specified as that of `1/inverseSqrt(x)`; measured at the same exponents |
//! | A subnormal counts as it is or as 0 of either sign, as an operand and as a result. A product, quotient or root of one is nothing else; `√` of one is at most `2⁻⁶³`, and a quotient by one is `2¹²⁶` or more, or ∞. | specified, but for the root and the quotient; measured |
//! | An integer of magnitude up to `2²⁴` becomes that number. | specified; measured |
//! | A texel's words arrive bit by bit, whatever they would be as floats, and `bitcast` gives that number, a subnormal one perhaps as 0. No word that is a NaN or ∞ is used as a float. | specified; measured |
//! | `<`, `≤`, `=`, `≥`, `>` and `max` are right for finite numbers that are not subnormal. | specified; measured up to the largest number |
//! | `select`, `abs`, a changed sign and integer arithmetic are exact. | specified |
//! | Comparisons with ∞ are right. | not assumed, as Vulkan lets a compiler take ∞ and NaN for impossible; measured for the kernels without a proof |
//!
//! An `fma` may round once or twice, as the kernels have none.
//!
//! A flushed subnormal changes no statement. The steps up to `m` and `s` lose at most `2⁻¹²⁶` each,
//! see above. A lower bound that is flushed is 0, "not certain". An upper bound of 0 would be a
//! certain miss, but wherever there is a visible root, its upper bound is normal:
//! - spheres from outside: `w = (s + h)/k ≥ 1/√(k·a)`, at least `2⁻⁹¹` with `k ≤ 2¹²⁰`, `a ≤ 2⁶⁰`;
//!   from inside the same, or `1/(a·u)` with `|d|·u ≤ ℓ + r + 2³⁰·slack`, above `2⁻¹¹⁰`;
//! - planes: with `M > 0`, `slope + error` is at least what the third digit of
//!   [`plane_direction_error`] leaves, `0.01·ε|n||d| ≥ 2⁻³⁰|d|`. Times `ι ≥ 2⁻³⁰/|d|` and
//!   `1/N ≥ 2⁻⁶²` this is above `2⁻¹²⁶`. [`TINY_F32`] has room for what `N` loses.
//!
//! So `1/t ≥ a·w`, which a hierarchy's walk divides by, is normal or 0, too; and a node's nearest `t`
//! that is flushed only becomes smaller.
//!
//! # What tests can see of it
//! `tests/library/lemmas.rs` looks at each step by itself, in a rounding chosen for each operation by a
//! search for the worst case: it comes to more than half of every constant of [`steps`], of
//! [`InputError`], [`WIDENING`] and [`T_ROOM`], so that none can be halved. `tests/library/guards.rs` runs
//! the whole filter in seven roundings and finds wrong statements once a bound is cut to about a
//! third: the largest errors of all steps don't meet in one ray.
//!
//! Not seen are, each with its reason beside it: [`FAR`], [`TINY_F32`], [`TINY_F64`], the third digits
//! of all constants (second order: `ε` times the first), [`LIST_F64`]'s `δ`, and the margins of
//! [`crate::tree`]'s boxes with its least slacks, which are powers of two far above what their derivation
//! asks for.

pub mod host;
pub mod rows;
pub mod squares;
pub mod steps;
#[cfg(test)]
pub(crate) mod tests;

use glam::DVec3;

use crate::kernel::certified::Widening;
use crate::num::{Float, Real, V3};
use crate::rays::{Lens, Pixels, View};
pub use crate::vec3::{round_down, round_up};
pub use squares::{LARGEST_TURN, Reach};

/// Error of the filter's inputs, in units `ε`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputError {
    /// `λ`: of the offset, relative to `ℓ`.
    pub offset: f64,
    /// `δ`: of the direction, relative to `|d|`.
    pub direction: f64,
}

/// Pixels. The offset is formed in f64 and rounded once: ½ and a little.
///
/// The direction `f + i·R + j·T` has rounded `f`, `R`, `T` (½ each; nothing in f64, but there
/// `h/H` and its product are rounded instead), two products and two sums. Component by component
/// `|e| ≤ ε(1.5|f| + 2.5|iR| + 1.5|jT| + |d|)`. The frame is orthonormal
/// ([`Pixels::is_in_range`]), so by Cauchy's inequality the first three are at most
/// `√(1.5² + 2.5² + 1.5²)·|d| = 3.28|d|`.
pub const PIXELS: InputError = InputError { offset: 0.501, direction: 4.3 };

/// Lists of rays: `(c_high − o_high) + (c_low − o_low)` takes two roundings of at most `ℓ` and
/// leaves out `2⁻⁴⁸`; the direction is rounded once.
pub const LIST: InputError = InputError { offset: 2.01, direction: 0.501 };

/// Rays whose f64 numbers are used as they are: one rounded subtraction. Their direction is scaled
/// by a power of two, exact but for components below `2⁻¹⁰²²` of the largest; the 0.001 is room, of which no test sees anything.
pub const LIST_F64: InputError = InputError { offset: 0.501, direction: 0.001 };

/// Pixels of an orthographic camera, f32 and f64; see the head of this module.
pub const PARALLEL: InputError = InputError { offset: 4.15, direction: 0.501 };

/// The error of a camera's rays.
pub fn input_of(lens: Lens) -> InputError {
    match lens {
        Lens::Perspective => PIXELS,
        Lens::Orthographic => PARALLEL,
    }
}

/// Relative widening of a root's interval, in units `ε`: 2 + 5.5 + 2·4.3 + 2 + 2.5, and one for
/// the widening itself, is below it.
pub const WIDENING: f64 = 24.0;

/// Largest relative slack of a sphere that counts as far. The same number is the condition and what
/// the intervals are widened by: half of it is as right, for fewer spheres, and no test sees it. The one condition on its
/// size, small against `1/18.3`, it keeps by a factor of 1800.
pub const FAR: f64 = 1.0 / (1u64 << 15) as f64;

/// Whether a sphere with `k > 0` is far for rays up to `longest` long.
#[inline(always)]
pub fn is_far(guard: &Guard, k: f64, longest: f64) -> bool {
    k > 0.0 && guard.slack * longest <= FAR * k.sqrt()
}

/// For what is of higher order in a bound in f64.
pub const ROOM: f64 = 1.01;

/// Longest direction of a picture whose light is found in f32. No test sees it halved: the range may be smaller.
pub const LONGEST_IN_F32: f64 = 1024.0;

/// What the filter needs to know about a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guard {
    /// `m` up to this is a certain hit; −1 where there is none.
    pub inner2: f64,
    /// `m` above this is a certain miss.
    pub outer2: f64,
    /// Absolute error of `u = |s| + h` for `|d| ≥ 1`.
    pub slack: f64,
    /// Absolute error of `k = L·L − r²` computed by the device.
    pub k_error: f64,
}

impl Guard {
    /// The guard of a sphere of radius `r` at distance at most `l`, for arithmetic of unit
    /// `unit`. The constants are derived at the head of this module; the host's own rounding
    /// (f64) is covered by their third digit, or by [`Guard::round_to_f32`].
    #[inline(always)]
    pub fn new(r: f64, l: f64, unit: f64, input: InputError) -> Guard {
        let [inner2, outer2, slack, k_error] = Guard::numbers(r, l, unit, input);
        Guard { inner2, outer2, slack, k_error }
    }

    /// The numbers of guards, in the order of their fields.
    #[inline(always)]
    pub(crate) fn numbers<R: Real<One = f64>>(r: R, l: R, unit: f64, input: InputError) -> [R; 4] {
        let InputError { offset, direction } = input;
        let eta = R::lit(unit) * l;
        let kappa_eta = R::lit(steps::FOOT + offset + direction) * eta;
        // No test sees the 8 halved: that is nothing in f32, and in f64 the host's rounding is half of a unit.
        let relative = steps::SQUARE * unit + 8.0 * f64::UNIT;
        let inner = r - kappa_eta;
        let outer = r + kappa_eta;
        let inner2 = inner * inner * R::lit(1.0 - relative);
        let outer2 = (outer * outer + R::lit(steps::ASIDE) * eta * eta) * R::lit(1.0 + relative);
        let of_distance = R::lit(steps::CLOSEST + offset + direction + steps::TWO_SUMS);
        let of_radius = R::lit(steps::HALF_CHORD + direction + steps::TWO_SUMS);
        let slack = R::lit(unit) * (of_distance * l + of_radius * outer);
        let of_distance2 = R::lit(steps::DOT + 2.0 * offset + steps::DIFFERENCE);
        let k_error = R::lit(unit) * (of_distance2 * l * l + R::lit(steps::R2) * r * r);
        [R::select(R::lit(0.0).lt(inner), inner2, R::lit(-1.0)), outer2, slack, k_error]
    }

    /// The guard in f32: the inner radius rounded down, everything else up.
    #[inline(always)]
    pub fn round_to_f32(&self) -> [f32; 4] {
        [
            round_down(self.inner2),
            round_up(self.outer2),
            round_up(self.slack),
            round_up(self.k_error),
        ]
    }
}

/// Error of `k` in units of `l·l + r²`, all rounded to nearest: ½ for the offset, doubled by squaring, 1½ for
/// the dot product, ½ each for `r²` and the difference.
pub(crate) const K_ERROR: f64 = 4.0;

/// The same of `(a − o)·n` in units of the product of the lengths, for faithful rounding: 1 for the offset, 3 for the dot
/// product.
pub(crate) const N_ERROR: f64 = 4.0;

/// Bound of `|M̂ − M|/|d̂|` for a plane with the normal's length `n`.
pub fn plane_direction_error(n: f64, unit: f64, input: InputError) -> f64 {
    // No test sees the 16 halved: that is of second order.
    unit * (steps::DOT + steps::NORMAL + input.direction) * n * (1.0 + 16.0 * unit)
}

/// Bound of `|N̂ − N|` for a plane with the normal's length `n` and a point at distance up to `l`.
/// `tiny` is for what underflows: the distance itself may be as small as it likes.
#[inline(always)]
pub fn plane_offset_error(n: f64, l: f64, unit: f64, input: InputError, tiny: f64) -> f64 {
    unit * (steps::DOT + steps::NORMAL + input.offset) * n * l + tiny
}

/// More than a dozen f32 operations lose when each flushes up to `2⁻¹²⁶` to zero, and so much more
/// that `1/(|N| − error)` stays finite with room for the rest: `ulp(2⁻⁶⁷) = 2⁻⁹⁰`. No test sees it
/// cut, as it is `2⁵⁵` times what is lost.
pub const TINY_F32: f64 = LARGEST_F32 / LARGEST_NEARNESS / (1u64 << 37) as f64;

/// Most that `1/N` and `(ℓ + r)/k` of a pixel's objects may be in f32. No test sees it halved: the range may be smaller.
pub const LARGEST_NEARNESS: f64 = (1u128 << 90) as f64;

/// An error in f32 above every `k` and `N`, and so far below the largest number that they can be added.
/// No test sees it halved: they are up to `2¹²⁰`.
pub const UNKNOWN: f32 = (1u128 << 124) as f32;

/// The same for f64, which keeps subnormals, and so far above `2⁻¹⁰²²` that `1/N` stays finite. No test
/// sees it cut.
pub const TINY_F64: f64 = 1.0 / (LARGEST_F64 * LARGEST_F64 * LARGEST_F64);

/// A bound of a vector's length, a few roundings above it; `v·v` may underflow.
#[inline(always)]
pub fn length_bound(v: DVec3) -> f64 {
    length_bounds(V3(v.to_array()))
}

/// [`length_bound`] of vectors side by side.
#[inline(always)]
pub(crate) fn length_bounds<R: Real<One = f64>>(v: V3<R>) -> R {
    let [x, y, z] = v.0;
    let largest = x.abs().max(y.abs()).max(z.abs());
    // No test sees the 16 halved: 2 would do.
    let length = v.dot(v).sqrt() * R::lit(1.0 + 16.0 * f64::UNIT);
    let is_tiny = largest.lt(R::lit(1.0 / LARGEST_F64));
    R::select(is_tiny, R::lit(1.8) * largest, length)
}

/// Largest distance and radius with which the filter's f32 stays in range. No test sees it halved: the range may be smaller.
pub const LARGEST_F32: f64 = (1u64 << 60) as f64;

/// Smallest radius with which it does. No test sees it halved: its square's last digit is `2²³` times what is lost.
pub(crate) const SMALLEST_RADIUS_F32: f64 = 1.0 / (1u64 << 40) as f64;

/// Largest distance, and inverse of the smallest radius, with which f64 stays in range. No test sees it halved: the range may be smaller.
const LARGEST_F64: f64 = LARGEST_F32 * LARGEST_F32 * LARGEST_F32 * LARGEST_F32;

/// Whether the filter's f32 stays in range for a sphere of radius `r` at distance up to `l`.
#[inline(always)]
pub fn sphere_in_range_f32(r: f64, l: f64) -> bool {
    (SMALLEST_RADIUS_F32..=LARGEST_F32).contains(&r) && l <= LARGEST_F32
}

/// Whether it does for a plane through a point at distance up to `l`.
pub fn plane_in_range_f32(l: f64) -> bool {
    l <= LARGEST_F32
}

/// Whether f64 stays in range for a sphere of radius `r` at distance `l`.
#[inline(always)]
pub fn sphere_in_range_f64(r: f64, l: f64) -> bool {
    (1.0 / LARGEST_F64..=LARGEST_F64).contains(&r) && l <= LARGEST_F64
}

/// Whether it does for a plane through a point at distance `l`.
pub fn plane_in_range_f64(l: f64) -> bool {
    l <= LARGEST_F64
}

/// Largest picture side, px: twice a pixel's offset from the centre is exact in f32.
const LARGEST_SIDE: u32 = 1 << 23;

/// Largest `|d|` of a camera's ray. No test sees it halved: the range may be smaller.
const LARGEST_DIRECTION: f64 = (1u64 << 30) as f64;

impl Pixels {
    /// Whether the bounds hold for these rays: a frame orthonormal to `2⁻¹⁰`, as the direction's
    /// bound assumes, pixel offsets that f32 holds exactly, no direction longer than `2³⁰`.
    pub fn is_in_range(&self) -> bool {
        let View { forward, right, true_up, .. } = self.view;
        let tolerance = 2f64.powi(-10);
        let frame = [forward, right, true_up];
        let orthonormal = frame.iter().all(|v| (v.length_squared() - 1.0).abs() < tolerance)
            && [forward.dot(right), right.dot(true_up), true_up.dot(forward)]
                .iter()
                .all(|dot| dot.abs() < tolerance);
        let exact_offsets = self.image_width.max(self.image_height) <= LARGEST_SIDE;
        orthonormal && exact_offsets && self.longest_direction() <= LARGEST_DIRECTION
    }

    /// A bound of `|d|` over the whole picture, for an orthonormal frame.
    pub fn longest_direction(&self) -> f64 {
        match self.view.lens {
            Lens::Perspective => 1.01 * 1f64.hypot(self.half_diagonal()),
            Lens::Orthographic => 1.01,
        }
    }

    /// A bound of the distance of an origin from the camera's position, for an orthonormal frame.
    pub fn spread(&self) -> f64 {
        match self.view.lens {
            Lens::Perspective => 0.0,
            Lens::Orthographic => 1.01 * self.half_diagonal(),
        }
    }

    fn half_diagonal(&self) -> f64 {
        let aspect = f64::from(self.image_width) / f64::from(self.image_height);
        self.view.h * 1f64.hypot(aspect)
    }
}

/// Relative room for the rounding of `1/(a·w)` in f32, 16 units `2⁻²³`: `a` takes 3 + 2·4.3, the
/// product and the quotient 1 + 2.5. What leaves f32's normal range belongs to a `t` below `2⁻¹²⁰` or
/// above `2⁶⁰`, where no far sphere is seen.
pub const T_ROOM: f32 = 1.0 + 1.0 / (1 << 19) as f32;

/// The least `1/t` that is looked at: no node is as far away as its inverse, nor as twice that, so
/// that no test sees it halved.
pub const LEAST_NEARNESS: f32 = 1.0 / (1u128 << 100) as f32;

/// An upper bound of `t = 1/(a·w)` from a lower bound of `a·w` in f32; beyond all nodes for 0 and
/// below.
#[inline(always)]
pub fn t_bound_f32(nearness: f32) -> f32 {
    t_bound_in(T_ROOM, nearness)
}

/// The same with another room than [`T_ROOM`].
#[inline(always)]
pub fn t_bound_in(room: f32, nearness: f32) -> f32 {
    room / nearness.max(LEAST_NEARNESS)
}

/// Largest exponent of a list's direction, either way, with which `t` surely stays in f32's range.
pub const LARGEST_EXPONENT: i32 = 30;

/// Relative error of `k` that still lets nearly every `t` be rounded to f32. No bound: it weighs an
/// exact `k` once a sphere against an exact `t` for one ray in `2⁴²/2²⁸`.
pub(crate) const K_TOLERANCE: f64 = 1.0 / (1u64 << 42) as f64;

/// `k = l·l − r²` in f64, for `l` rounded once, and a bound of its error; `None` where that is not
/// good enough to round `t`.
#[inline(always)]
pub fn k_f64(l: DVec3, r: f64) -> Option<(f64, f64)> {
    let (l2, r2) = (l.length_squared(), r * r);
    let (k, error) = (l2 - r2, K_ERROR * f64::UNIT * (l2 + r2));
    (error <= K_TOLERANCE * k.abs()).then_some((k, error))
}

/// What a bound `error` of the error of `k` grows to when it is moved from a point at distance `l`
/// to one `from` away, as the head of this module says.
#[inline(always)]
pub fn moved_k_error(k: f64, error: f64, l: f64, from: f64) -> f64 {
    1.001 * (error + f64::UNIT * (k.abs() + 20.0 * from * (l + from)))
}

/// The relative factors of the filter for arithmetic of unit `unit`, rounded by `down` and `up`.
#[inline(always)]
fn widening<R>(
    unit: f64,
    n_units: f64,
    down: impl Fn(f64) -> R,
    up: impl Fn(f64) -> R,
) -> Widening<R> {
    let width = n_units * unit;
    Widening {
        narrower: down(1.0 - width),
        wider: up(1.0 + width),
        // The upper bound's own widening is taken back as well, with 2 for its rounding. No test sees these cut: it has as
        // much room.
        far_narrower: down((1.0 - FAR) / (1.0 + FAR) * (1.0 - 2.0 * width - 2.0 * unit)),
    }
}

/// The relative factors of the filter in f32, rounded away from 1.
pub fn widening_f32() -> Widening<f32> {
    widening(f32::UNIT, WIDENING, round_down, round_up)
}

/// The same in f64.
#[inline(always)]
pub fn widening_f64() -> Widening<f64> {
    widening(f64::UNIT, WIDENING, f64::next_down, f64::next_up)
}

/// `1/k` of a far sphere, to be rounded up to f32: the widening and the relative slack are in it.
#[inline(always)]
pub fn far_inverse<R: Real<One = f64>>(k: R) -> R {
    R::lit(1.0 + WIDENING * f32::UNIT) / (k * R::lit(1.0 - FAR))
}

/// Bounds in f32 of `1/x` with the widening in it, magnitudes rounded away from each other, with
/// the sign of `x`; 0 for 0.
pub fn inverse_f32(x: f64) -> (f32, f32) {
    inverse(x, WIDENING * f32::UNIT)
}

fn inverse(x: f64, width: f64) -> (f32, f32) {
    if x == 0.0 {
        return (0.0, 0.0);
    }
    let inverse = 1.0 / x.abs();
    let sign = if x < 0.0 { -1.0 } else { 1.0 };
    (sign * round_down(inverse * (1.0 - width)), sign * round_up(inverse * (1.0 + width)))
}
