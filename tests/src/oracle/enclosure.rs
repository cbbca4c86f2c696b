//! Enclosures of real numbers: intervals of f64, and intervals of big integers with as many bits as
//! asked. An operation gives an interval that holds every result of numbers in its operands.
//!
//! # When a number is 0
//! An interval that reaches across 0 says nothing, however narrow. Here is how narrow it must be to
//! say 0. Take an expression of integers, `+`, `−`, `×` and at most two square roots, one of which may
//! lie below the other. Choose the sign of each root in all ways: up to [`DEGREE`] numbers. Their
//! polynomial `Π (z − zᵢ)` does not change when a sign does, so no root is left in its coefficients:
//! it has integer coefficients, and 1 in front. Divide it by `z` as often as 0 is a root: the
//! last coefficient, the product of those `zᵢ` that are not 0, is then an integer other than 0, at
//! least 1 in magnitude. If all `|zᵢ| ≤ U` with `U ≥ 1`, each of them is at least `U^(1 − DEGREE)`.
//!
//! So a number below `U^(1 − DEGREE)` in magnitude is 0. `U` follows the expression: `|x|` for an
//! integer, the sum for a sum or difference, the product for a product, the square root for a root; no
//! choice of signs gives more (below a root the number may then be negative; its root is as large).

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_traits::{Signed, Zero};

/// The most choices of signs of square roots in an expression whose sign is asked.
pub const DEGREE: u64 = 4;

/// The enclosure does not tell; more bits are needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undecided;

/// An enclosure of a real number.
pub trait Number: Clone {
    /// `x·2^shift` with this many bits. An interval of f64 leaves the shift away: it is for questions
    /// that do not change when all numbers of a kind are shifted.
    fn new(x: f64, shift: i64, bits: u64) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn negative(&self) -> Self;
    fn times(&self, other: &Self) -> Self;
    fn squared(&self) -> Self;
    /// The square root of a number that is known not to be negative.
    fn root(&self) -> Self;
    /// The quotient of a number that is known not to be negative and one that is known to be positive.
    fn over(&self, positive: &Self) -> Result<Self, Undecided>;
    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negative())
    }
    /// The order of the number and 0.
    fn sign(&self) -> Result<Ordering, Undecided>;
    fn to_big(&self, bits: u64) -> Result<Big, Undecided>;
}

/// `u·v`.
pub fn dot<N: Number>(u: &[N; 3], v: &[N; 3]) -> N {
    u[0].times(&v[0]).plus(&u[1].times(&v[1])).plus(&u[2].times(&v[2]))
}

/// `v·v`.
pub fn norm2<N: Number>(v: &[N; 3]) -> N {
    v[0].squared().plus(&v[1].squared()).plus(&v[2].squared())
}

/// An interval of f64. No operation is trusted beyond its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Narrow {
    low: f64,
    high: f64,
}

const ZERO: Narrow = Narrow { low: 0.0, high: 0.0 };

impl Narrow {
    /// Rounded outward. A lower end is never +∞, an upper one never −∞, so that sums of ends are
    /// numbers.
    fn around(low: f64, high: f64) -> Narrow {
        if low.is_nan() || high.is_nan() {
            return Narrow { low: f64::NEG_INFINITY, high: f64::INFINITY };
        }
        Narrow { low: low.next_down(), high: high.next_up() }
    }

    fn is_zero(self) -> bool {
        self.low == 0.0 && self.high == 0.0
    }
}

impl Number for Narrow {
    fn new(x: f64, _: i64, _: u64) -> Narrow {
        Narrow { low: x, high: x }
    }

    fn plus(&self, other: &Narrow) -> Narrow {
        match (self.is_zero(), other.is_zero()) {
            (true, _) => *other,
            (_, true) => *self,
            _ => Narrow::around(self.low + other.low, self.high + other.high),
        }
    }

    fn negative(&self) -> Narrow {
        Narrow { low: -self.high, high: -self.low }
    }

    fn times(&self, other: &Narrow) -> Narrow {
        if self.is_zero() || other.is_zero() {
            return ZERO;
        }
        let products = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        if products.iter().any(|product| product.is_nan()) {
            return Narrow::around(f64::NAN, f64::NAN);
        }
        let low = products.iter().copied().fold(f64::INFINITY, f64::min);
        let high = products.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Narrow::around(low, high)
    }

    fn squared(&self) -> Narrow {
        let square = self.times(self);
        Narrow { low: square.low.max(0.0), high: square.high }
    }

    fn root(&self) -> Narrow {
        if self.is_zero() {
            return ZERO;
        }
        let root = Narrow::around(self.low.max(0.0).sqrt(), self.high.sqrt());
        Narrow { low: root.low.max(0.0), high: root.high }
    }

    fn over(&self, positive: &Narrow) -> Result<Narrow, Undecided> {
        if !(positive.low > 0.0) {
            return Err(Undecided);
        }
        if self.is_zero() {
            return Ok(ZERO);
        }
        let quotient = Narrow::around(self.low.max(0.0) / positive.high, self.high / positive.low);
        Ok(Narrow { low: quotient.low.max(0.0), high: quotient.high })
    }

    fn sign(&self) -> Result<Ordering, Undecided> {
        if self.low > 0.0 {
            Ok(Ordering::Greater)
        } else if self.high < 0.0 {
            Ok(Ordering::Less)
        } else if self.is_zero() {
            Ok(Ordering::Equal)
        } else {
            Err(Undecided)
        }
    }

    fn to_big(&self, bits: u64) -> Result<Big, Undecided> {
        if !self.low.is_finite() || !self.high.is_finite() {
            return Err(Undecided);
        }
        Ok(Big::new(self.low, 0, bits).joined(&Big::new(self.high, 0, bits)))
    }
}

/// All numbers from `low·2^exponent` to `high·2^exponent`.
#[derive(Clone, Debug)]
pub struct Big {
    low: BigInt,
    high: BigInt,
    exponent: i64,
    /// Longer ends are rounded outward.
    bits: u64,
    /// log₂ of the `U` above, rounded up; none where the number need not be such an expression.
    bound: Option<u64>,
}

/// Mantissa and exponent of a finite f64.
fn parts(x: f64) -> (i64, i64) {
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i64, (bits & ((1 << 52) - 1)) as i64);
    assert!(field < 0x7ff, "finite");
    let mantissa = if field == 0 { fraction } else { fraction | 1 << 52 };
    (if x.is_sign_negative() { -mantissa } else { mantissa }, field.max(1) - 1075)
}

/// The least shift that makes integers of all of them.
pub fn integer_shift(numbers: impl IntoIterator<Item = f64>) -> i64 {
    let shift = |x: f64| {
        let (mantissa, exponent) = parts(x);
        if mantissa == 0 { 0 } else { -(exponent + i64::from(mantissa.trailing_zeros())) }
    };
    numbers.into_iter().map(shift).fold(0, i64::max)
}

/// The integer above `x / 2^shift`.
fn ceil_shift(x: &BigInt, shift: u64) -> BigInt {
    -(-x >> shift)
}

impl Big {
    fn rounded(self) -> Big {
        let excess = self.low.bits().max(self.high.bits()).saturating_sub(self.bits);
        if excess == 0 {
            return self;
        }
        Big {
            low: self.low >> excess,
            high: ceil_shift(&self.high, excess),
            exponent: self.exponent + excess as i64,
            ..self
        }
    }

    /// Ends of both with the same exponent.
    fn aligned(&self, other: &Big) -> ([BigInt; 2], [BigInt; 2], i64) {
        let exponent = self.exponent.min(other.exponent);
        let ends = |x: &Big| {
            let shift = (x.exponent - exponent) as u64;
            [&x.low << shift, &x.high << shift]
        };
        (ends(self), ends(other), exponent)
    }

    fn joined(&self, other: &Big) -> Big {
        let ([low, _], [_, high], exponent) = self.aligned(other);
        Big { low, high, exponent, bits: self.bits, bound: None }.rounded()
    }

    fn sum_bound(&self, other: &Big) -> Option<u64> {
        Some(self.bound?.max(other.bound?) + 1)
    }

    /// The f64 next to an end, toward 0, and whether it is the end itself. Beyond the largest: that.
    fn end_f64(&self, end: &BigInt) -> (f64, bool) {
        let length = end.bits() as i64;
        // The last place of the f64, which may be a subnormal one.
        let place = (self.exponent + length - 53).max(-1074);
        let shift = place - self.exponent;
        let magnitude = end.magnitude();
        let mantissa =
            if shift >= 0 { magnitude >> shift as u64 } else { magnitude << -shift as u64 };
        let is_exact = shift <= 0 || &(&mantissa << shift as u64) == magnitude;
        let mantissa = u64::try_from(&mantissa).expect("53 bits");
        if mantissa == 0 {
            return (0.0, is_exact);
        }
        if place > 971 {
            return (f64::MAX.copysign(if end.is_negative() { -1.0 } else { 1.0 }), false);
        }
        // Both factors and the product are f64 numbers.
        let value = if place < -1000 {
            mantissa as f64 * 2f64.powi(-1000) * 2f64.powi((place + 1000) as i32)
        } else {
            mantissa as f64 * 2f64.powi(place as i32)
        };
        (if end.is_negative() { -value } else { value }, is_exact)
    }

    /// The largest f64 that is not above the lower and the upper end, of numbers that are not negative.
    pub fn floors(&self) -> [f64; 2] {
        [&self.low, &self.high].map(|end| self.end_f64(end).0)
    }

    /// The f32 nearest to the lower and to the upper end, of numbers that are not negative.
    pub fn nearest_f32(&self) -> [f32; 2] {
        [&self.low, &self.high].map(|end| {
            let (toward_zero, is_exact) = self.end_f64(end);
            // An f64 with an odd last place where something was cut off is on no edge between two f32:
            // it rounds as the number does.
            let odd = f64::from_bits(toward_zero.to_bits() | u64::from(!is_exact));
            odd as f32
        })
    }
}

impl Number for Big {
    fn new(x: f64, shift: i64, bits: u64) -> Big {
        let (mantissa, exponent) = parts(x);
        let (mantissa, zeros) = match mantissa {
            0 => (0, 0),
            _ => (mantissa >> mantissa.trailing_zeros(), i64::from(mantissa.trailing_zeros())),
        };
        let exponent = if mantissa == 0 { 0 } else { exponent + zeros + shift };
        let mantissa = BigInt::from(mantissa);
        let bound = (exponent >= 0).then(|| mantissa.bits() + exponent as u64);
        Big { low: mantissa.clone(), high: mantissa, exponent, bits, bound }.rounded()
    }

    fn plus(&self, other: &Big) -> Big {
        let (a, b, exponent) = self.aligned(other);
        let ([a_low, a_high], [b_low, b_high]) = (a, b);
        let (low, high) = (a_low + b_low, a_high + b_high);
        Big { low, high, exponent, bits: self.bits, bound: self.sum_bound(other) }.rounded()
    }

    fn negative(&self) -> Big {
        Big { low: -&self.high, high: -&self.low, ..*self }
    }

    fn times(&self, other: &Big) -> Big {
        let exponent = self.exponent + other.exponent;
        let bound = self.bound.zip(other.bound).map(|(a, b)| a + b);
        let (low, high) = if !self.low.is_negative() && !other.low.is_negative() {
            (&self.low * &other.low, &self.high * &other.high)
        } else {
            let mut products = [
                &self.low * &other.low,
                &self.low * &other.high,
                &self.high * &other.low,
                &self.high * &other.high,
            ];
            products.sort();
            let [low, _, _, high] = products;
            (low, high)
        };
        Big { low, high, exponent, bits: self.bits, bound }.rounded()
    }

    fn squared(&self) -> Big {
        let square = self.times(self);
        Big { low: square.low.max(BigInt::ZERO), ..square }
    }

    fn root(&self) -> Big {
        let bound = self.bound.map(|bound| bound.div_ceil(2));
        if !self.high.is_positive() {
            return Big { low: BigInt::ZERO, high: BigInt::ZERO, bound, ..*self };
        }
        // Twice the bits below the root, and an even exponent.
        let mut shift = (2 * self.bits).saturating_sub(self.high.bits()) as i64;
        shift += (self.exponent - shift).rem_euclid(2);
        let low = (self.low.clone().max(BigInt::ZERO) << shift).sqrt();
        let high_square = &self.high << shift;
        let mut high = high_square.sqrt();
        if &high * &high < high_square {
            high += 1;
        }
        Big { low, high, exponent: (self.exponent - shift) / 2, bits: self.bits, bound }.rounded()
    }

    fn over(&self, positive: &Big) -> Result<Big, Undecided> {
        if !positive.low.is_positive() {
            return Err(Undecided);
        }
        let shift = self.bits + positive.high.bits();
        let low = (self.low.clone().max(BigInt::ZERO) << shift) / &positive.high;
        let high = (&self.high << shift) / &positive.low + 1;
        let high = if self.high.is_zero() { BigInt::ZERO } else { high };
        let exponent = self.exponent - positive.exponent - shift as i64;
        Ok(Big { low, high, exponent, bits: self.bits, bound: None }.rounded())
    }

    fn sign(&self) -> Result<Ordering, Undecided> {
        if self.low.is_positive() {
            return Ok(Ordering::Greater);
        }
        if self.high.is_negative() {
            return Ok(Ordering::Less);
        }
        let length = self.low.bits().max(self.high.bits()) as i64;
        let is_zero = length == 0
            || self
                .bound
                .is_some_and(|bound| length + self.exponent <= -(((DEGREE - 1) * bound) as i64));
        if is_zero { Ok(Ordering::Equal) } else { Err(Undecided) }
    }

    fn to_big(&self, _: u64) -> Result<Big, Undecided> {
        Ok(self.clone())
    }
}
