//! `t` of a hit with fewer quotients and roots than [`super`] takes for a filter.
//!
//! # Spheres
//! `t = s ∓ h` cancels no more than [`super`] says of parallel rays: the slack bounds the sum of the errors of
//! `s`, of `h` and of two sums. Here `h = √((r² − m)ι)`. As the rounded `r²` lies between `inner2` and
//! `outer2`, the true half of the chord and `h` are both between the halves `h_in` and `h_out` that these give,
//! and no farther from each other than they are. Let `b = outer2 − inner2` and `r² − m ≥ 4b` ([`LEAST_WIDTHS`]). Then
//! `inner2 − m ≥ ¾(r² − m)`, so that `h_in ≥ √¾·h`, and
//! `h_out − h_in = bι/(h_out + h_in) ≤ bι/((1 + √¾)h) = 0.536·b·√(ι/(r² − m))`: [`CHORD`]. Times `|d|` it is a length; as `|d| ≥ 1`,
//! it is no less without.
//!
//! # Planes
//! `t = N·(1/M)` with `|N̂ − N| ≤ e` and `|M̂ − M| ≤ e_d|d|`. Let `e_d|d| ≤ 2⁻⁷|M̂|`. Then the quotient of the
//! true numbers is off by at most `(e + |t|·e_d|d|)/(|M̂| − e_d|d|)`, 1.008 times what it would be with
//! `|M̂|` below: [`QUOTIENT`], with its own rounding. The inverse takes 2.5 units of
//! `t`, the product and the sum with this error one each: [`INVERSE`].

/// How far half a chord may be off, in units of `b·√(ι/(r² − m))`.
pub const CHORD: f64 = 0.54;

/// Error of a quotient, in units of `(e + |t|·e_d|d|)/|M̂|`.
pub const QUOTIENT: f64 = 1.01;

/// Rounding of a quotient as a product and a sum, in units of `t`.
pub const INVERSE: f64 = 4.51;

/// Part of `|M|` that its error may be. Half of it is as right, for fewer rays: no test sees it.
pub const MOST_OF_SLOPE: f64 = 1.0 / (1u64 << 7) as f64;

/// Bounds `(N ± e)/(M ± e)` of a quotient that a filter takes, in units: two sums, a quotient 2.5, and the product that widens
/// with its factor.
pub const BOUNDS: f64 = 8.0;

/// What `r² − m` is at least where [`CHORD`] holds, in units of the difference `b` of the squared radii.
pub const LEAST_WIDTHS: f64 = 4.0;
