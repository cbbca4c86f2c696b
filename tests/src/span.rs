//! f32 arithmetic of any device that keeps to Vulkan's table of precision, as intervals.
//!
//! # What is assumed
//! The table of [`kugelblitz::guard`], and nothing else: `+`, `−` and `×` give one of the two neighbours of the
//! exact result, or that result itself where f32 has it; a quotient is off by at most
//! [`QUOTIENT_ULP`], where the divisor's magnitude is in `2⁻¹²⁶..2¹²⁶`; a root, inherited from
//! `1/inverseSqrt(x)` with 2 units for `inverseSqrt` and 2.5 for the division, by at most [`ROOT_ULP`]; a
//! subnormal counts as it is or as 0. A product may be fused with a sum: the exact product lies in the
//! interval of the rounded one.
//!
//! # Why the ends are bounds
//! The exact sum, product, quotient or root of numbers from intervals lies between those of their ends;
//! this is found in f64, which holds products of f32 numbers exactly and sums up to an error that two-sum
//! tells. The device's result is an f32 number, so that an end moves out by the operation's error, and
//! then *in* to the next f32 number. A unit is that of the largest magnitude in the interval, as units
//! grow with it.
//!
//! What leaves f32's range, or has no result, may become anything: [`Span::ANY`].

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use kugelblitz::num::{Real, round_down, round_up};

/// Largest error of a quotient, in units of the last place.
pub const QUOTIENT_ULP: f64 = 2.5;

/// Largest error of a square root, in units of the last place.
pub const ROOT_ULP: f64 = 4.5;

/// Divisors between this and its inverse have a quotient.
const LEAST_DIVISOR: f64 = f32::MIN_POSITIVE as f64;

/// The f32 numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The least of them.
    pub low: f64,
    /// The largest of them.
    pub high: f64,
}

impl Span {
    /// 0.
    pub const ZERO: Span = Span { low: 0.0, high: 0.0 };

    /// 1.
    pub const ONE: Span = Span { low: 1.0, high: 1.0 };

    /// Any number, ∞ and NaN too.
    pub const ANY: Span = Span { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// A number that a device is given.
    pub fn new(x: f32) -> Span {
        Span { low: x.into(), high: x.into() }.or_flushed()
    }

    /// Whether a device may have this number.
    pub fn has(&self, x: f32) -> bool {
        self.is_any() || self.low <= x.into() && f64::from(x) <= self.high
    }

    /// Whether nothing is known.
    pub fn is_any(&self) -> bool {
        !(self.low.is_finite() && self.high.is_finite())
    }

    /// The part that is above 0.
    pub fn above_zero(self) -> Option<Span> {
        let low = self.low.max(f32::from_bits(1).into());
        (self.high > 0.0).then_some(Span { low, ..self })
    }

    /// The part that is not above 0.
    pub fn not_above_zero(self) -> Option<Span> {
        (self.low <= 0.0).then_some(Span { high: self.high.min(0.0), ..self })
    }

    /// The part that is not below 0.
    pub fn not_below_zero(self) -> Option<Span> {
        (self.high >= 0.0).then_some(Span { low: self.low.max(0.0), ..self })
    }

    /// The same times a power of two, where numbers that leave the normal range are rounded anyhow.
    pub fn scaled(self, by: f64) -> Span {
        Span::rounded(self.low * by, self.high * by, 0.0)
    }

    /// What a device may make of exact results from `low` to `high` if it is off by at most this many units,
    /// or takes a neighbour.
    fn rounded(low: f64, high: f64, units: f64) -> Span {
        let largest = low.abs().max(high.abs());
        let error = units * ulp(largest);
        let (low, high) = match units > 0.0 {
            // f64's own rounding is what the steps are for.
            true => (round_up((low - error).next_down()), round_down((high + error).next_up())),
            false => (round_down(low), round_up(high)),
        };
        match low.is_finite() && high.is_finite() {
            true => Span { low: low.into(), high: high.into() }.or_flushed(),
            false => Span::ANY,
        }
    }

    /// The same with 0, if there may be a subnormal.
    fn or_flushed(self) -> Span {
        const LEAST: f64 = f32::MIN_POSITIVE as f64;
        match self.low < LEAST && self.high > -LEAST {
            true => Span { low: self.low.min(0.0), high: self.high.max(0.0) },
            false => self,
        }
    }

    /// What `f` gives at the four pairs of ends.
    fn ends(self, other: Span, f: impl Fn(f64, f64) -> f64) -> (f64, f64) {
        let ends = [
            f(self.low, other.low),
            f(self.low, other.high),
            f(self.high, other.low),
            f(self.high, other.high),
        ];
        (
            ends.into_iter().fold(f64::INFINITY, f64::min),
            ends.into_iter().fold(f64::NEG_INFINITY, f64::max),
        )
    }
}

/// The distance of f32 numbers at `x`, and not less than the least subnormal.
fn ulp(x: f64) -> f64 {
    let exponent = ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    2f64.powi(exponent.max(-126) - 23)
}

/// A sum in f64, and its rounding error (Knuth's two-sum).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

impl Add for Span {
    type Output = Span;

    fn add(self, other: Span) -> Span {
        if self.is_any() || other.is_any() {
            return Span::ANY;
        }
        let ((low, low_error), (high, high_error)) =
            (two_sum(self.low, other.low), two_sum(self.high, other.high));
        let low = if low_error < 0.0 { low.next_down() } else { low };
        let high = if high_error > 0.0 { high.next_up() } else { high };
        Span::rounded(low, high, 0.0)
    }
}

impl Sub for Span {
    type Output = Span;

    fn sub(self, other: Span) -> Span {
        self + -other
    }
}

impl Mul for Span {
    type Output = Span;

    fn mul(self, other: Span) -> Span {
        if self.is_any() || other.is_any() {
            return Span::ANY;
        }
        let (low, high) = self.ends(other, |a, b| a * b);
        Span::rounded(low, high, 0.0)
    }
}

impl Div for Span {
    type Output = Span;

    fn div(self, other: Span) -> Span {
        let divisors = [other.low.abs(), other.high.abs()];
        let has_quotient = other.low.signum() == other.high.signum()
            && divisors.iter().all(|d| (LEAST_DIVISOR..=1.0 / LEAST_DIVISOR).contains(d));
        if self.is_any() || !has_quotient {
            return Span::ANY;
        }
        let (low, high) = self.ends(other, |a, b| a / b);
        Span::rounded(low, high, QUOTIENT_ULP)
    }
}

impl Neg for Span {
    type Output = Span;

    fn neg(self) -> Span {
        Span { low: -self.high, high: -self.low }
    }
}

/// Certain orders alone.
impl PartialOrd for Span {
    fn partial_cmp(&self, other: &Span) -> Option<Ordering> {
        if self.is_any() || other.is_any() {
            None
        } else if self.high < other.low {
            Some(Ordering::Less)
        } else if self.low > other.high {
            Some(Ordering::Greater)
        } else {
            (self.low == self.high && self == other).then_some(Ordering::Equal)
        }
    }
}

impl Real for Span {
    type One = f32;
    type Mask = bool;
    type Id = u32;

    fn splat(x: f32) -> Span {
        Span::new(x)
    }

    fn splat_id(id: u32) -> u32 {
        id
    }

    fn lt(self, other: Span) -> bool {
        self.partial_cmp(&other) == Some(Ordering::Less)
    }

    fn le(self, other: Span) -> bool {
        matches!(self.partial_cmp(&other), Some(Ordering::Less | Ordering::Equal))
    }

    fn select(mask: bool, yes: Span, no: Span) -> Span {
        if mask { yes } else { no }
    }

    fn select_id(mask: bool, yes: u32, no: u32) -> u32 {
        if mask { yes } else { no }
    }

    /// Of the part that is not below 0. The root of a subnormal is at most `2⁻⁶³`.
    fn sqrt(self) -> Span {
        match self.not_below_zero() {
            Some(Span { low, high }) if high.is_finite() => {
                let low = if low < LEAST_DIVISOR { 0.0 } else { low.sqrt() };
                Span::rounded(low, high.max(LEAST_DIVISOR).sqrt(), ROOT_ULP).not_negative()
            }
            _ => Span::ANY,
        }
    }

    fn abs(self) -> Span {
        match self {
            Span { low, .. } if low >= 0.0 => self,
            Span { high, .. } if high <= 0.0 => -self,
            Span { low, high } => Span { low: 0.0, high: high.max(-low) },
        }
    }

    fn min(self, other: Span) -> Span {
        Span { low: self.low.min(other.low), high: self.high.min(other.high) }
    }

    fn max(self, other: Span) -> Span {
        Span { low: self.low.max(other.low), high: self.high.max(other.high) }
    }
}

impl Span {
    fn not_negative(self) -> Span {
        Span { low: self.low.max(0.0), ..self }
    }
}
