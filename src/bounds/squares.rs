//! Bounds for the rays of a square of pixels, which the ray of its middle stands for.
//!
//! They are the true rays, and `d̂` is the direction that approximates them: with `x` a bound of
//! `|d' − d|/|d'|` for all of them, `|d̂ − d'| ≤ (δε(1 + x) + x)|d'|`, and likewise `L̂` is off by `λη` and by
//! how far their origins are apart. So `δ + x/ε` and `λ + apart/η` are the errors of the input ([`Footprint`]), and
//! what is decided holds for every one of them. Nothing in [`super`] takes `δ` for small but for the second
//! digits:
//! - A direction that is off by `x` is turned by an angle of `x(1 + x²/5)` at most.
//! - `d/|d|²` is an inversion, which takes `d'` and `d̂` to vectors that are `|d̂ − d'|/(|d̂||d'|)` apart: `s` is off
//!   by `x(1 + x)ℓ`, as `|d'| ≥ 1`.
//! - `1/|d̂|` is off by `x(1 + x)`, relative. Half the chord is bounded for whatever `κ` is.
//! - `a = 1 + ρ²` with the distance `ρ` from the middle of the picture, which `x` changes: `ι` is off by
//!   `(2ρx + x²)/(1 + ρ²) ≤ x(1 + x)`. A root by the product takes `ι` itself, for which `2δ` is granted.
//!
//! With `x ≤ 2⁻⁵` ([`LARGEST_TURN`]) and a frame that is orthonormal to `2⁻¹⁰` the second digits are below 0.07.

use super::InputError;
use crate::num::Real;
use crate::rays::{Lens, Pixels};

/// How far the rays of a square of pixels may be from that of its middle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Between their origins.
    pub apart: f64,
    /// Between their directions, relative.
    pub turned: f64,
}

/// Largest [`Footprint::turned`] that its derivation holds for. Half of it is as right: no test sees it.
pub const LARGEST_TURN: f64 = 1.0 / (1u64 << 5) as f64;

impl Footprint {
    /// That of rays through squares of `side` × `side` pixels, for an orthonormal frame: half a diagonal, and no
    /// direction is shorter than 1. The 0.07 are for the second digits.
    pub fn new(pixels: &Pixels, side: f64) -> Footprint {
        let half_side = side * pixels.view.h / f64::from(pixels.image_height);
        let half_diagonal = 1.07 * half_side * std::f64::consts::SQRT_2;
        match pixels.view.lens {
            Lens::Perspective => Footprint { apart: 0.0, turned: half_diagonal },
            Lens::Orthographic => Footprint { apart: half_diagonal, turned: 0.0 },
        }
    }

    /// That of the samples of squares of `side` × `side` pixels, `n` × `n` of each: the outermost ones are half
    /// the way between two from the edges.
    pub fn of_samples(pixels: &Pixels, side: u32, n: u32) -> Footprint {
        Footprint::new(pixels, f64::from(side) - 1.0 / f64::from(n))
    }

    /// The error of inputs, in this unit, for what is at distance up to `l`.
    #[inline(always)]
    pub fn widen<R: Real<One = f64>>(&self, input: InputError, l: R, unit: f64) -> InputError<R> {
        let InputError { offset, direction } = input;
        let offset = match self.apart > 0.0 {
            true => R::lit(offset) + R::lit(self.apart / unit) / l,
            false => R::lit(offset),
        };
        InputError { offset, direction: direction + self.turned / unit }
    }
}
