//! `t` of a hit with fewer quotients and roots than [`super`] takes for a filter: for neighbours in a row of
//! pixels, side by side.
//!
//! # Spheres
//! `t = s ∓ h` cancels no more than [`super`] says of parallel rays: the slack bounds the sum of the errors of
//! `s`, of `h` and of two sums. Here `h = √((r² − m)ι)`. As the rounded `r²` lies between `inner2` and
//! `outer2`, the true half of the chord and `h` are both between the halves `h_in` and `h_out` that these give,
//! and no farther from each other than they are. Let `b = outer2 − inner2` and `r² − m ≥ 4b`. Then
//! `inner2 − m ≥ ¾(r² − m)`, so that `h_in ≥ √¾·h`, and
//! `h_out − h_in = bι/(h_out + h_in) ≤ bι/((1 + √¾)h) = 0.536·b·√(ι/(r² − m))`: [`CHORD`]. Times `|d|`, that
//! is what [`super::most_width`] limits; as `|d| ≥ 1`, it is no less without.
//!
//! # Planes
//! `t = N·(1/M)` with `|N̂ − N| ≤ e` and `|M̂ − M| ≤ e_d|d|`. Let `e_d|d| ≤ 2⁻⁷|M̂|`. Then the quotient of the
//! true numbers is off by at most `(e + |t|·e_d|d|)/(|M̂| − e_d|d|)`, 1.008 times what it would be with
//! `|M̂|` below: [`QUOTIENT`], with its own rounding. The inverse, the product and the sum with this error take
//! one unit of `t` each: [`INVERSE`].
//!
//! `N = n·c − n·o` with a point `c` of the plane and a ray's origin `o`, both from the camera's position. In f64 the first
//! product is off by `(3 + ½ + ½)ε|n||c|` and the second one by `(3 + ½)ε|n||o|` and what `o` is off by; with the difference,
//! a unit of both, that is less than [`super::plane_offset_error`] has for `|c| + |o|`. In f32 the first one comes from f64, with
//! its error there and `ε` of it, and the difference takes another. The second one and the difference take
//! `(3 + 1 + 3.84 + 1)ε|n||o|`, see [`super::host::input_in_f32`]: [`ACROSS`]. `n` has unit length there, up to `ε`.

use super::{Guard, InputError, most_width};

/// Of `b·√(ι/(r² − m))`: how far half a chord may be off.
pub const CHORD: f64 = 0.54;

/// Of the error of a quotient.
pub const QUOTIENT: f64 = 1.01;

/// Of the rounding of a quotient as a product and a sum, in units.
pub const INVERSE: f64 = 3.01;

/// Part of `|M|` that its error may be.
pub const MOST_OF_SLOPE: f64 = 1.0 / (1u64 << 7) as f64;

/// Of `|n||o|` in the error of `N` in f32, in units.
pub const ACROSS: f64 = 8.9;

/// Part of `r²` that `r² − m` is at least. No bound: it weighs the rays at the silhouette that are left open
/// against an error that grows towards it.
const LEAST: f64 = 1.0 / (1u64 << 14) as f64;

/// What half a chord tells of a root and of a normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChordGuard {
    /// `r² − m` from here on.
    pub least2: f64,
    /// Of `t`, then, for `|d| ≥ 1`.
    pub error: f64,
    /// The part of that which is the same for all rays.
    pub slack: f64,
    /// Over half a chord, as the `t` between its ends, it bounds how far that half is off, as a length:
    /// `h|d| = √(r² − m)`, which is at least `h`.
    pub of_chord: f64,
    /// With what half a chord is off by, over the radius, it bounds what a normal is off by:
    /// [`super::most_width`] solved for the tolerance. A normal that is divided by the radius is off by less
    /// than one by its own length.
    pub of_normal: f64,
}

impl ChordGuard {
    /// For a sphere of radius `r` at distance up to `l`, in arithmetic of this unit on the host. The normal is then
    /// off by at most `tolerance`; `None` where that can't be.
    pub fn new(r: f64, l: f64, unit: f64, input: InputError, tolerance: f64) -> Option<ChordGuard> {
        let Guard { inner2, outer2, slack, .. } = Guard::new(r, l, unit, input);
        let most_width = most_width(r, l, unit, input, tolerance);
        if inner2 <= 0.0 || most_width <= 0.0 {
            return None;
        }
        // The host's rounding of this, and of what it is compared with, is in the hundredths.
        let width2 = 1.01 * (outer2 - inner2);
        let for_normal = 1.01 * CHORD * width2 / most_width;
        let least2 = (LEAST * r * r).max(4.0 * width2).max(for_normal * for_normal);
        Some(ChordGuard {
            least2,
            error: 1.01 * (slack + CHORD * width2 / least2.sqrt()),
            slack: 1.01 * slack,
            of_chord: 1.01 * CHORD * width2,
            of_normal: 1.01 * (tolerance * r - most_width),
        })
    }
}
