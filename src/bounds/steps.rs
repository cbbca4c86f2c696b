//! The bounds of the single steps of the derivation, in units `ε` of [`crate::bounds`]. Each has a
//! search for its worst case in `tests/library/lemmas.rs`, which half of it would not survive.

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

/// `k/a` over a root, relative, but for `2δ` and for `k` and the root themselves: `1/a` 3 + 2.5, a sum, a product, a
/// quotient 2.5, and 2 for the product that widens.
pub const RELATIVE: f64 = 12.1;

/// Two sums of a root, of `ℓ + r`.
pub const TWO_SUMS: f64 = 2.01;

/// A dot product, of the product of the lengths.
pub const DOT: f64 = 3.01;

/// A normal's rounding to f32 on the host, relative.
pub const NORMAL: f64 = 0.501;

/// `P` of a normal: `ŝ` and step 3; of `ℓ`.
pub const NORMAL_FOOT: f64 = 10.6;

/// A radius of a sphere from `P` and half its chord, but for `P` and for what half the chord may be between its bounds; of `r`:
/// half the chord (1 + 5.5 + 1)/2 + 4.5, the mean of its bounds 1, `h·d` and the sum 2, the radius' inverse ½, as it is rounded,
/// and the product with it 1; and 1 for a sum with its error.
pub const CHORD_MIDDLE: f64 = 13.8;

/// `(t·d − l)/r` but for `t·d` and `l`, of 1: the difference 1, the inverse, which is rounded, and the product 1 each.
pub const NORMAL_OF_POINT: f64 = 3.01;

/// `v/‖v‖` in f64, of 1: 3/2 + 1 + 1 + 1.
pub const NORMALIZED: f64 = 4.6;

/// A point `o + t·d` for the middle of two bounds of `t`, of `t|d|`: the middle, the product and the sum.
pub const POINT: f64 = 3.0;

/// A point `o + t·d` for the middle of two bounds of `t`, of `|o|`: the sum.
pub const POINT_ORIGIN: f64 = 1.0;
