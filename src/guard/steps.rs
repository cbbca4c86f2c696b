//! The bounds of the single steps of the derivation, in units `ε` of [`crate::guard`]. Each has a
//! search for its worst case in `tests/lemmas.rs`, which half of it would not survive.

/// Step 2: `|ŝ − s|·|d|`, of `ℓ`: 3 + 3 + 2.5 + 1.
pub const CLOSEST: f64 = 9.51;

/// Step 3: rounding `ŝ·d̂`, of `ℓ`.
pub const FOOT: f64 = 1.01;

/// Steps 3 and 5: the subtraction, twice, and the dot product; of `m`.
pub const SQUARE: f64 = 5.1;

/// Step 4, of `η²` in units of 1: `9.51² + 2·9.51 + 1` and what is of higher order.
pub const ASIDE: f64 = 111.0;

/// Half the chord, relative, without `δ`: (1 + 5.5 + 1)/2 + 4.5.
pub const HALF_CHORD: f64 = 8.26;

/// Two sums of a root, of `ℓ + r`.
pub const TWO_SUMS: f64 = 2.01;

/// A dot product, of the product of the lengths.
pub const DOT: f64 = 3.01;

/// The subtraction in `k = L·L − r²`, of `ℓ²`.
pub const DIFFERENCE: f64 = 1.01;

/// The same of `r²`, with `r²` rounded: 1 + ½, and ½ for a host that rounds otherwise.
pub const R2: f64 = 2.01;

/// A normal's rounding to f32 on the host, relative.
pub const NORMAL: f64 = 0.501;

/// [`crate::kernel::certified::half_chord_normal`] in f64, whose division and root are faithful as
/// well: `P` rounds by `ŝ` (3 + 3 + 1 + 1) and step 3; of `ℓ`. The rest is of second order in
/// `ℓ/r`, which [`crate::guard::normal_error`] keeps below `2⁻²⁵/ε`.
pub const NORMAL_FOOT: f64 = 10.6;

/// There, of `r`: half the chord (1 + 1 + 4 + 1)/2 + 1, `h·d` and the sum 2, the normalisation
/// 3/2 + 1 + 1 + 1.
pub const NORMAL_CHORD: f64 = 12.0;
