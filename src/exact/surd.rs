//! Roots of linear and quadratic equations, compared and rounded exactly.

use std::cmp::Ordering;

use super::enclosure::{quotient, square_root};
use super::number::{Dyadic, double, integer, magnitude, power_of_two, real, signum};

/// The real number `f·(B + s·√D)/A` with dyadic `A > 0`, `B`, `D ≥ 0`, a sign `s ∈ {−1, 0, 1}` and
/// a positive integer `f`.
///
/// `s = 0` exactly where `D = 0`. Roots of a sphere and of a plane have this form, and so have the
/// components of their unit normals and all quotients of dyadic numbers.
///
/// Order and equality are those of the numbers, not of the way they are written.
#[derive(Clone, Debug)]
pub struct QuadraticSurd {
    b: Dyadic,
    s: i32,
    d: Dyadic,
    a: Dyadic,
    factor: u32,
}

impl From<Dyadic> for QuadraticSurd {
    fn from(x: Dyadic) -> QuadraticSurd {
        QuadraticSurd::quotient(x, Dyadic::one(), 1)
    }
}

impl QuadraticSurd {
    /// Returns `factor·(b + sign·√d)/a`, for `a > 0`, `d ≥ 0`, `factor > 0` and a `sign` of −1, 0 or 1.
    pub fn new(b: Dyadic, sign: i32, d: Dyadic, a: Dyadic, factor: u32) -> QuadraticSurd {
        debug_assert!(signum(&a) > 0 && signum(&d) >= 0 && factor > 0);
        let s = if signum(&d) == 0 { 0 } else { sign };
        let d = if s == 0 { Dyadic::zero() } else { d };
        QuadraticSurd { b, s, d, a, factor }
    }

    /// `factor·numerator/denominator`; `denominator > 0`.
    pub(crate) fn quotient(numerator: Dyadic, denominator: Dyadic, factor: u32) -> QuadraticSurd {
        QuadraticSurd::new(numerator, 0, Dyadic::zero(), denominator, factor)
    }

    /// The number times `2^exponent`.
    pub(crate) fn times_power_of_two(&self, exponent: isize) -> QuadraticSurd {
        let power = power_of_two(exponent);
        QuadraticSurd { b: &self.b * &power, d: &self.d * &power * &power, ..self.clone() }
    }

    /// The number with the other sign.
    pub fn negated(self) -> QuadraticSurd {
        QuadraticSurd { b: -self.b, s: -self.s, ..self }
    }

    /// Returns `B`, the rational part of the numerator.
    pub fn rational_part(&self) -> &Dyadic {
        &self.b
    }

    /// Returns `s`, the sign of the square root: −1, 0 or 1.
    pub fn root_sign(&self) -> i32 {
        self.s
    }

    /// Returns `D`, the number under the square root.
    pub fn radicand(&self) -> &Dyadic {
        &self.d
    }

    /// Returns `A`, the denominator.
    pub fn denominator(&self) -> &Dyadic {
        &self.a
    }

    /// Returns `f`, the factor.
    pub fn factor(&self) -> u32 {
        self.factor
    }

    /// -1, 0 or 1: the sign of the number.
    pub fn signum(&self) -> i32 {
        sign_of_sum(&self.b, self.s, &self.d)
    }

    /// The numerator `f·B` and the radicand `f²·D` that goes with it.
    fn folded(&self) -> (Dyadic, Dyadic) {
        if self.factor == 1 {
            return (self.b.clone(), self.d.clone());
        }
        let f = integer(i64::from(self.factor));
        (&self.b * &f, &self.d * &f * &f)
    }

    /// The order of this number and `x`: the sign of `(f·B − x·A) + s·√(f²D)`, as `A > 0`.
    pub fn cmp_real(&self, x: &Dyadic) -> Ordering {
        let (b, d) = self.folded();
        sign_of_sum(&(b - x * &self.a), self.s, &d).cmp(&0)
    }

    /// `numerator/denominator`; a denominator of 0 counts as 1.
    pub fn ratio(numerator: Dyadic, denominator: u32) -> QuadraticSurd {
        QuadraticSurd::quotient(numerator, integer(i64::from(denominator.max(1))), 1)
    }

    /// Returns an approximation of a number of at least 0, with a relative error below `2^(4 − n_bits)`; 0 only for 0.
    ///
    /// Where `B` and `s` have opposite signs the numerator is rewritten as
    /// `B + s√D = (B² − D)/(B − s√D)` with an exact `B² − D`, so nothing cancels: what is left are
    /// one square root, a quotient and a sum of terms of one sign, each within `2^(1 − n_bits)`.
    pub fn approximate(&self, n_bits: usize) -> Dyadic {
        let sum = magnitude(&self.b) + square_root(&self.d, n_bits).low;
        let factor = integer(i64::from(self.factor));
        let is_difference = self.s != 0 && signum(&self.b) == -self.s;
        let (numerator, denominator) = match is_difference {
            true => (magnitude(&(&self.b * &self.b - &self.d)), sum * &self.a),
            false => (sum, self.a.clone()),
        };
        quotient(&(numerator * factor), &denominator, n_bits).low
    }

    /// The nearest f32, ties to even; infinite from `2^128 − 2^103` on.
    pub fn to_f32(&self) -> f32 {
        let magnitude = self.magnitude();
        let guess = magnitude.approximate(96).near() as f32;
        // Not `−0`.
        nearest_f32(guess, |x| magnitude.cmp_real(x)) * self.signum() as f32 + 0.0
    }

    /// The nearest f64, ties to even; infinite from `2^1024 − 2^970` on.
    pub fn to_f64(&self) -> f64 {
        let magnitude = self.magnitude();
        let guess = magnitude.approximate(96).near().to_bits();
        let (infinity, order) = (f64::INFINITY.to_bits(), |x: &Dyadic| magnitude.cmp_real(x));
        let nearest = nearest(guess, infinity, f64::from_bits, 1024, order);
        f64::from_bits(nearest) * f64::from(self.signum())
    }

    /// The number without its sign.
    pub fn magnitude(&self) -> QuadraticSurd {
        if self.signum() < 0 { self.clone().negated() } else { self.clone() }
    }
}

/// The f32 that is nearest to a number of at least 0, ties to even, searched from a guess; `order` gives the number's order to
/// others.
pub(crate) fn nearest_f32(guess: f32, order: impl Fn(&Dyadic) -> Ordering) -> f32 {
    // The guess may be no number.
    let guess = if guess > 0.0 { guess.to_bits() } else { 0 };
    let (infinity, value) = (f32::INFINITY.to_bits(), |u: u64| f32::from_bits(u as u32).into());
    f32::from_bits(nearest(guess.into(), infinity.into(), value, 128, order) as u32)
}

/// The bit pattern of the number of a binary format that is nearest to one of at least 0, ties to even, searched from a guess.
/// The patterns `0..=infinity` are in the order of their values; `2^beyond` is what would follow the largest one if exponents
/// went on.
///
/// The number rounds to `u` or below exactly where it lies below the midpoint of `u` and its successor, or on it if `u` is even.
/// That is monotone in `u`; the pattern sought is the lowest for which it holds.
fn nearest(
    guess: u64,
    infinity: u64,
    value: impl Fn(u64) -> f64,
    beyond: isize,
    order: impl Fn(&Dyadic) -> Ordering,
) -> u64 {
    let value = |u| real(value(u)).unwrap_or_else(|| power_of_two(beyond));
    let half = power_of_two(-1);
    let at_most = |u: u64| {
        if u >= infinity {
            return true;
        }
        match order(&((value(u) + value(u + 1)) * &half)) {
            Ordering::Less => true,
            Ordering::Equal => u & 1 == 0,
            Ordering::Greater => false,
        }
    };
    lowest(guess.min(infinity), infinity, at_most)
}

/// The lowest `u ≤ last` with `holds(u)`, which is monotone and holds at `last`, searched from a guess. It is confirmed,
/// however it was guessed; a guess that fails, as of subnormal numbers, costs a bisection.
pub(crate) fn lowest(guess: u64, last: u64, holds: impl Fn(u64) -> bool) -> u64 {
    if holds(guess) && (guess == 0 || !holds(guess - 1)) {
        return guess;
    }
    let (mut low, mut high) = (0, last);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

/// The sign of `p + s·√x`; `x > 0` unless `s = 0`.
///
/// If `p` is 0 or has the sign `s`, that is the sign; else the larger magnitude decides, and
/// magnitudes compare as their squares do: `p²` with `x`.
pub(super) fn sign_of_sum(p: &Dyadic, s: i32, x: &Dyadic) -> i32 {
    let sign_p = signum(p);
    if s == 0 || sign_p == s {
        return sign_p;
    }
    if sign_p == 0 {
        return s;
    }
    sign_p * order(&(p * p), x)
}

/// The sign of `p + s·√x + u·√y`; `x > 0` unless `s = 0`, `y > 0` unless `u = 0`.
///
/// 1. `q = s√x + u√y` has the sign `s` if `u` is 0 or equal to it (and the other way round), else
///    that of the one with the larger radicand; 0 if these are equal.
/// 2. If `p` and `q` don't have opposite signs, the one that isn't 0 decides.
/// 3. Else the larger magnitude does: the sign is `sgn(p)·sgn(p² − q²)`, and with
///    `e = p² − x − y`, `p² − q² = e − 2·s·u·√(xy)`: the sign of a sum with one square root,
///    `e + (−su)·√(4xy)`, as above.
fn sign_of_sum2(p: &Dyadic, s: i32, x: &Dyadic, u: i32, y: &Dyadic) -> i32 {
    let sign_q = if s == 0 || u == 0 || s == u { (s + u).signum() } else { s * order(x, y) };
    let sign_p = signum(p);
    if sign_q == 0 || sign_p == sign_q {
        return sign_p;
    }
    if sign_p == 0 {
        return sign_q;
    }
    let e = p * p - x - y;
    let cross = -s * u;
    if cross == 0 {
        return sign_p * signum(&e);
    }
    // Skips the product where it can't matter.
    if signum(&e) == cross {
        return sign_p * cross;
    }
    sign_p * sign_of_sum(&e, cross, &double(&double(&(x * y))))
}

/// The sign of `x − y`.
fn order(x: &Dyadic, y: &Dyadic) -> i32 {
    x.cmp(y) as i32
}

impl Ord for QuadraticSurd {
    /// The order of the numbers.
    ///
    /// `f₁(B₁ + s₁√D₁)/A₁ − f₂(B₂ + s₂√D₂)/A₂`, multiplied by `A₁·A₂ > 0`, is
    /// `(f₁A₂B₁ − f₂A₁B₂) + s₁√(f₁²A₂²D₁) − s₂√(f₂²A₁²D₂)`, see `sign_of_sum2`.
    ///
    /// Spheres that one ray meets share `A` and `f`: then multiplying by `A/f > 0` is enough.
    fn cmp(&self, other: &QuadraticSurd) -> Ordering {
        let sign = if self.factor == other.factor && self.a == other.a {
            sign_of_sum2(&(&self.b - &other.b), self.s, &self.d, -other.s, &other.d)
        } else {
            let left = integer(i64::from(self.factor)) * &other.a;
            let right = integer(i64::from(other.factor)) * &self.a;
            sign_of_sum2(
                &(&left * &self.b - &right * &other.b),
                self.s,
                &(&left * &left * &self.d),
                -other.s,
                &(&right * &right * &other.d),
            )
        };
        sign.cmp(&0)
    }
}

impl PartialOrd for QuadraticSurd {
    fn partial_cmp(&self, other: &QuadraticSurd) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for QuadraticSurd {
    fn eq(&self, other: &QuadraticSurd) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for QuadraticSurd {}

#[cfg(test)]
mod tests {
    use super::*;

    /// However bad the guess, the rounded number is right.
    #[test]
    fn rounding_does_not_depend_on_the_guess() {
        let infinity = f32::INFINITY.to_bits();
        for exponent in [-151, -150, -149, -100, -1, 0, 1, 60, 127, 128, 129] {
            for d in [1, 2, 3, 5, 0xfff_ffff] {
                for (b, s) in [(0, 1), (-1, 1), (100_000, -1), (7, 0)] {
                    let root = QuadraticSurd::new(
                        Dyadic::new(b.into(), exponent),
                        s,
                        Dyadic::new(d.into(), 2 * exponent),
                        integer(3),
                        5,
                    );
                    let (expected, magnitude) = (root.to_f32(), root.magnitude());
                    for guess in [0, 1, 0x3f80_0000, infinity - 1, infinity, u32::MAX] {
                        let guess = f32::from_bits(guess);
                        let found = nearest_f32(guess, |x| magnitude.cmp_real(x));
                        assert_eq!(found * root.signum() as f32, expected);
                    }
                    // 53 bits are more than twice 24: rounding twice is innocuous, except where
                    // f32 is subnormal or the first rounding meets a midpoint.
                    let twice = root.to_f64() as f32;
                    let apart = twice.to_bits().abs_diff(expected.to_bits());
                    assert!(apart <= 1, "{root:?}");
                }
            }
        }
    }
}
