//! Dyadic numbers.

use std::borrow::Borrow;
use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

use dashu_int::ops::{Abs, Gcd};
use dashu_int::{IBig, Sign};
use glam::DVec3;

/// A dyadic number `m·2^e` with `m` of any size; `+ − ×` and comparisons are exact.
///
/// Big integers by dashu, and on top of them the one thing that dyadic numbers need: shifting to
/// a common exponent.
///
/// A number has many representations (only those that come from f64 are the shortest). Exponents
/// of the polynomials here stay within `±2^20`, so sums of exponents can't overflow.
#[derive(Clone, Debug)]
pub struct Dyadic {
    pub(super) mantissa: IBig,
    pub(super) exponent: isize,
}

/// The exact value of an f64, or `None` if it is not finite.
pub fn real(value: f64) -> Option<Dyadic> {
    if !value.is_finite() {
        return None;
    }
    let bits = value.to_bits();
    let field = (bits >> 52) & 0x7ff;
    let fraction = bits & ((1 << 52) - 1);
    // Subnormal numbers have no hidden bit and the exponent of field 1.
    let magnitude = if field == 0 { fraction } else { fraction | (1 << 52) };
    if magnitude == 0 {
        return Some(Dyadic::zero());
    }
    let zeros = magnitude.trailing_zeros();
    let magnitude = (magnitude >> zeros) as i64;
    Some(Dyadic {
        mantissa: IBig::from(if value < 0.0 { -magnitude } else { magnitude }),
        exponent: field.max(1) as isize - 1075 + zeros as isize,
    })
}

/// The exact value of a number of a scene, which is finite; else 0.
pub fn exact(x: f64) -> Dyadic {
    real(x).unwrap_or_else(Dyadic::zero)
}

/// -1, 0 or 1.
pub fn signum(x: &Dyadic) -> i32 {
    if x.mantissa.is_zero() {
        0
    } else if x.mantissa.sign() == Sign::Negative {
        -1
    } else {
        1
    }
}

impl Dyadic {
    /// 0.
    pub fn zero() -> Dyadic {
        Dyadic::new(IBig::ZERO, 0)
    }

    /// 1.
    pub fn one() -> Dyadic {
        Dyadic::new(IBig::ONE, 0)
    }

    /// Returns `mantissa·2^exponent`.
    pub fn new(mantissa: IBig, exponent: isize) -> Dyadic {
        Dyadic { mantissa, exponent }
    }

    /// Returns the mantissa of this representation.
    pub fn mantissa(&self) -> &IBig {
        &self.mantissa
    }

    /// Returns the exponent of this representation.
    pub fn exponent(&self) -> isize {
        self.exponent
    }

    /// An f64 near this number.
    pub(super) fn near(&self) -> f64 {
        let half = self.exponent / 2;
        let [one, other] = [half, self.exponent - half].map(|part| 2f64.powi(part as i32));
        self.mantissa.to_f64().value() * one * other
    }

    fn is_zero(&self) -> bool {
        self.mantissa.is_zero()
    }

    /// Mantissa and exponent, the same for equal numbers: the mantissa is odd, or both are 0.
    pub(crate) fn shortest(&self) -> (IBig, isize) {
        match self.mantissa.trailing_zeros() {
            None => (IBig::ZERO, 0),
            Some(zeros) => (&self.mantissa >> zeros, self.exponent + zeros as isize),
        }
    }
}

/// Brings two mantissas to the lower exponent and combines them. A zero takes part with the other
/// one's exponent, whatever its own is.
fn aligned(x: &Dyadic, y: &Dyadic, combine: impl FnOnce(&IBig, &IBig) -> IBig) -> Dyadic {
    let (exponent, mantissa) = match x.exponent.cmp(&y.exponent) {
        Ordering::Equal => (x.exponent, combine(&x.mantissa, &y.mantissa)),
        _ if x.is_zero() => (y.exponent, combine(&x.mantissa, &y.mantissa)),
        _ if y.is_zero() => (x.exponent, combine(&x.mantissa, &y.mantissa)),
        Ordering::Greater => {
            let shifted = &x.mantissa << (x.exponent - y.exponent) as usize;
            (y.exponent, combine(&shifted, &y.mantissa))
        }
        Ordering::Less => {
            let shifted = &y.mantissa << (y.exponent - x.exponent) as usize;
            (x.exponent, combine(&x.mantissa, &shifted))
        }
    };
    Dyadic { mantissa, exponent }
}

/// Operators for operands that are borrowed, and that are not.
macro_rules! operators {
    ($($operator:ident $function:ident $result:expr),*) => {$(
        impl<D: Borrow<Dyadic>> $operator<D> for &Dyadic {
            type Output = Dyadic;
            fn $function(self, other: D) -> Dyadic {
                $result(self, other.borrow())
            }
        }
        impl<D: Borrow<Dyadic>> $operator<D> for Dyadic {
            type Output = Dyadic;
            fn $function(self, other: D) -> Dyadic {
                $result(&self, other.borrow())
            }
        }
    )*};
}

operators!(
    Add add |x, y| aligned(x, y, |x, y| x + y),
    Sub sub |x, y| aligned(x, y, |x, y| x - y),
    Mul mul |x: &Dyadic, y: &Dyadic| {
        Dyadic::new(&x.mantissa * &y.mantissa, x.exponent + y.exponent)
    }
);

impl Neg for Dyadic {
    type Output = Dyadic;
    fn neg(self) -> Dyadic {
        Dyadic { mantissa: -self.mantissa, ..self }
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Dyadic) -> Ordering {
        if self.exponent == other.exponent {
            return self.mantissa.cmp(&other.mantissa);
        }
        signum(&(self - other)).cmp(&0)
    }
}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Dyadic) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Dyadic) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Dyadic {}

/// The components of a vector.
pub(crate) fn real3(v: DVec3) -> Option<[Dyadic; 3]> {
    Some([real(v.x)?, real(v.y)?, real(v.z)?])
}

/// An integer.
pub fn integer(value: i64) -> Dyadic {
    Dyadic::new(IBig::from(value), 0)
}

/// Whole numbers without a common divisor in the ratio of these, the first of which that is not 0 is positive; `None` where all
/// are 0.
pub(crate) fn primitive(numbers: &[Dyadic; 3]) -> Option<[IBig; 3]> {
    let exponent = numbers.iter().filter(|x| !x.is_zero()).map(|x| x.exponent).min()?;
    let whole = numbers.each_ref().map(|x| match x.is_zero() {
        true => IBig::ZERO,
        false => &x.mantissa << (x.exponent - exponent) as usize,
    });
    let [x, y, z] = &whole;
    let divisor =
        IBig::from(if x.is_zero() && y.is_zero() { z.gcd(z) } else { IBig::from(x.gcd(y)).gcd(z) });
    let first = numbers.iter().map(signum).find(|sign| *sign != 0)?;
    let divisor = if first < 0 { -divisor } else { divisor };
    Some(whole.map(|x| x / &divisor))
}

impl From<IBig> for Dyadic {
    fn from(x: IBig) -> Dyadic {
        Dyadic::new(x, 0)
    }
}

/// `2^exponent`.
pub(super) fn power_of_two(exponent: isize) -> Dyadic {
    Dyadic::new(IBig::ONE, exponent)
}

/// `|x|`.
pub(super) fn magnitude(x: &Dyadic) -> Dyadic {
    Dyadic::new((&x.mantissa).abs(), x.exponent)
}

/// `2x`.
pub(crate) fn double(x: &Dyadic) -> Dyadic {
    Dyadic { mantissa: x.mantissa.clone(), exponent: x.exponent + 1 }
}

/// The dot product.
pub(crate) fn product3(u: &[Dyadic; 3], v: &[Dyadic; 3]) -> Dyadic {
    &u[0] * &v[0] + &u[1] * &v[1] + &u[2] * &v[2]
}

/// The smallest number that rounds (to nearest, ties to even) beyond the largest f32: half an ulp
/// above it, `2^128 − 2^103`; the tie goes up because the last bit of the largest f32 is 1.
pub(super) fn f32_overflow() -> Dyadic {
    power_of_two(128) - power_of_two(103)
}
