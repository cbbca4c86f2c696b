//! Proven bounds for the formulas of [`crate::shape`] in the certified kernel.
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
//! **`m ≤ (r − κη)²(1 − 5.1ε)` implies `p < r`: a certain hit** ([`FilterBounds::inner2`]).
//! Likewise `√m (1 − 2.51ε) − η ≤ √(p̂² + τ²)`; squaring and collecting gives:
//! **`m > ((r + κη)² + 111η²)(1 + 5.1ε)` implies `p > r`: a certain miss** ([`FilterBounds::outer2`]),
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
//! Roots are compared by bounds of `t = s ∓ h`. What cancels there has cancelled in `c − o` before: the absolute error of
//! `s`, of `h` and of two sums together is at most [`FilterBounds::slack`]:
//! `ε·((9.5 + λ + δ)ℓ + (8.25 + δ)r + 2(ℓ + r))` for `|d| ≥ 1`, the last term for two sums. So
//! `(s − h_out) − slack ≤ near ≤ (s − h_in) + slack`, and the far root likewise, with `h_in` and
//! `h_out` from the two radii, 0 below 0. Where the near root is certainly positive, it is the one
//! that is seen; where it is certainly 0 or less, the far one is, if it is positive; else either may
//! be. From inside or from the surface, of which `k = |L|² − r²` is sure for rays from one point, the near one is at most 0.
//!
//! On the ground of a huge sphere the slack hides the root. There the roots' product tells it, `k/a` over the one that does not
//! cancel, `u = |s| + h`: `ι` 5.5 + 2δ, `k` 2, product 1, quotient 2.5 and the product that widens, [`steps::RELATIVE`]` + 2δ`.
//!
//! # Planes
//! `t = N/M` with `M = n·d` and `N = n·L`. `M` is off by at most `(3 + ½ + δ)ε|n||d|`, the ½ for rounding `n`
//! ([`plane_direction_error`]). `N` is found in f64 for the reference point, rounded, and moved to where a ray starts: its error
//! stands beside it in [`crate::shape::PlaneRecord`]. The quotient of their bounds is widened by [`rows::BOUNDS`].
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
//! # Range
//! Underflow adds at most `2⁻¹²⁶` (f32) a step. With `r ≥ 2⁻⁴⁰`, `ℓ ≤ 2⁶⁰`, `1 ≤ |d| ≤ 2³⁰` this is
//! below the slack of the constants, and nothing overflows. Under a square root it is more: `2⁻⁶³`.
//! But `outer2 − m` is 0 or at least `2⁻¹⁰⁴` for `r ≥ 2⁻⁴⁰`, so that its product with `ι` underflows
//! only for `|d| > 2¹¹`, where the error is at most `slack/|d|` and all of the slack, above `2⁻⁶⁰`,
//! is granted. Of objects outside that range only misses and lower bounds of `t` are known, never wrong: [`crate::shape`].
//!
//! # Nothing rests on ∞ or NaN
//! Vulkan lets a compiler assume that there are none (without `SignedZeroInfNanPreserve`, which is
//! declared nowhere here). So no operation of the f32 stage takes or gives one, not even where its
//! result is selected away; `tests/device/matrix/finite.rs` looks at each of them in the formulas that shaders find objects by, and
//! `src/shape/tests.rs` at surfaces and shadow rays, in numbers that refuse ∞:
//! - Radii squared are at most `2¹²¹`, and so are `k` and its error. Of an object in range `k ≤ ℓ²` and the slack is above
//!   `14ε(ℓ + r)`, so that `k/a` over a number that is at least the slack is below `2⁸⁰`. One that is out of range has a slack
//!   of `2⁶⁰`.
//! - Of a plane the divisor is at least `2⁻⁹⁰` and `2⁻¹⁰⁰` times the dividend: no quotient is above `2¹⁰⁰`, beyond every `t`.
//! - An object that is out of range is left open by numbers that are large enough: it is a sphere of radius 2⁶⁰ about the
//!   reference point, or a plane whose `N` is known up to `2¹⁰²` only. A tiny sphere has a larger radius, and a far one is scaled
//!   down to a distance of `2⁵⁸`.
//! - A point is known where it is off by less than [`Float::KNOWN`]: then squares of distances from it
//!   are below `2¹²⁶`. What is not known is put at the reference point before light is looked for.
//! - A list's direction of zero is replaced by another in its record, and its ray is undecided.
//!
//! Rays for which [`crate::prepare::Prepared::in_range`] is false may overflow: whatever comes out
//! is overwritten by "undecided". On the host ∞ is an ordinary number: see [`crate::support::fpu_check`].
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
//! see above. A lower bound of `t` that is flushed is 0, and says nothing. An upper one is normal: of a sphere it is above the
//! slack where it is positive, of a plane at least `2⁻⁹⁰/|M|` with `|M| < 2³³`.
//!
//! # What tests can see of it
//! `tests/library/lemmas.rs` looks at each step by itself, in a rounding chosen for each operation by a
//! search for the worst case: it comes to more than half of every constant of [`steps`] and of
//! [`InputError`], so that none can be halved. The tests of [`crate::shape`] run whole formulas in numbers whose roundings
//! are as bad as a device's may be.
//!
//! Not seen are, each with its reason beside it, the third digits
//! of all constants (second order: `ε` times the first), [`LIST_F64`]'s `δ`, and the margins of
//! [`crate::bvh`]'s boxes with its least widths, which are powers of two far above what their derivation
//! asks for.

pub mod host;
pub mod rows;
pub mod squares;
pub mod steps;
#[cfg(test)]
pub(crate) mod tests;

pub use crate::num::length_bound;
pub(crate) use crate::num::length_bounds;
use crate::num::{Float, Real, V3};
use crate::rays::{Lens, Pixels, View};
pub use squares::{Footprint, LARGEST_TURN};

/// Error of a ray's numbers, in units `ε`; that of offsets may differ from lane to lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputError<R = f64> {
    /// `λ`: of the offset, relative to `ℓ`.
    pub offset: R,
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

/// Lists of rays: centre and origin are rounded, ½ each of their distances from the reference point, and so is their
/// difference, by 1; the direction is rounded once.
pub const LIST: InputError = InputError { offset: 1.51, direction: 0.501 };

/// Rays whose f64 numbers are used as they are: one rounded subtraction. Their direction is scaled
/// by a power of two, exact but for components below `2⁻¹⁰²²` of the largest; the 0.001 is room, of which no test sees anything.
pub const LIST_F64: InputError = InputError { offset: 0.501, direction: 0.001 };

/// Pixels of an orthographic camera, f32 and f64; see the head of this module.
pub const PARALLEL: InputError = InputError { offset: 4.15, direction: 0.501 };

/// Offsets from anchors, `λ`; [`crate::shape::Anchor`] says what these are. Steps are rounded (½), two products and a sum make the
/// way to another pixel, as for parallel rays, whose scale is rounded, ½, and its product, 1: `(1.5·√2·1.0005 + 2.5)ε|o'|`. `c'` is
/// rounded (½), and so is the difference (1): `0.5|c'| + 4.63|o'| + 1.001(|c'| + |o'|)`, and 0.01 for f64.
pub const ANCHORED: f64 = 5.65;

/// The error of a camera's rays.
pub fn input_of(lens: Lens) -> InputError {
    match lens {
        Lens::Perspective => PIXELS,
        Lens::Orthographic => PARALLEL,
    }
}

/// For what is of higher order in a bound in f64.
pub const ROOM: f64 = 1.01;

/// Longest direction of a picture whose light is found in f32. No test sees it halved: the range may be smaller.
pub const LONGEST_IN_F32: f64 = 1024.0;

/// What the formulas need to know about a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterBounds<R> {
    /// `m` up to this is a certain hit; −1 where there is none.
    pub inner2: R,
    /// `m` above this is a certain miss.
    pub outer2: R,
    /// Absolute error of `u = |s| + h` for `|d| ≥ 1`.
    pub slack: R,
}

impl<R: Real<One = f64>> FilterBounds<R> {
    /// The guard of a sphere of radius `r` at distance at most `l`, for arithmetic of unit `unit` and inputs that are off by
    /// `input`. The constants are derived at the head of this module; the host's own rounding (f64) is covered
    /// by their third digit.
    #[inline(always)]
    pub fn new(r: R, l: R, unit: f64, input: InputError<R>) -> FilterBounds<R> {
        let InputError { offset, direction } = input;
        let eta = R::lit(unit) * l;
        let kappa_eta = (R::lit(steps::FOOT + direction) + offset) * eta;
        // No test sees the 8 halved: that is nothing in f32, and in f64 the host's rounding is half of a unit.
        let relative = steps::SQUARE * unit + 8.0 * f64::UNIT;
        let inner = r - kappa_eta;
        let outer = r + kappa_eta;
        let inner2 = inner * inner * R::lit(1.0 - relative);
        let outer2 = (outer * outer + R::lit(steps::ASIDE) * eta * eta) * R::lit(1.0 + relative);
        let of_distance = R::lit(steps::CLOSEST + direction + steps::TWO_SUMS) + offset;
        let of_radius = R::lit(steps::HALF_CHORD + direction + steps::TWO_SUMS);
        let slack = R::lit(unit) * (of_distance * l + of_radius * outer);
        let inner2 = R::select(R::lit(0.0).lt(inner), inner2, R::lit(-1.0));
        FilterBounds { inner2, outer2, slack }
    }
}

/// Error of `k` in units of `l·l + r²`, all rounded to nearest: ½ for the offset, doubled by squaring, 1½ for
/// the dot product, ½ each for `r²` and the difference.
pub(crate) const K_ERROR: f64 = 4.0;

/// Error of `(a − o)·n` in units of the product of the lengths, for faithful rounding: 1 for the offset, 3 for the dot
/// product.
pub(crate) const N_ERROR: f64 = 4.0;

/// Bound of `|M̂ − M|/|d̂|` for a plane with the normal's length `n`.
pub fn plane_direction_error(n: f64, unit: f64, input: InputError) -> f64 {
    // No test sees the 16 halved: that is of second order.
    unit * (steps::DOT + steps::NORMAL + input.direction) * n * (1.0 + 16.0 * unit)
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

/// Largest exponent of a list's direction, either way, with which f32 looks at its ray. No bound.
pub const LARGEST_EXPONENT: i32 = 30;

/// Largest exponent of what `t` in f32 is multiplied with: a scene's unit, over the length of a direction. A `t` that f32 decides is
/// below `2⁶⁶`, so that the product is in f32's range.
pub const LARGEST_SHIFT: i32 = 60;

/// `k = l·l − r²` in f64, for `l` rounded once, and a bound of its error.
#[inline(always)]
pub(crate) fn k_in_f64<R: Real<One = f64>>(l: V3<R>, r: R) -> (R, R) {
    let (l2, r2) = (l.dot(l), r * r);
    (l2 - r2, R::lit(K_ERROR * f64::UNIT) * (l2 + r2))
}
