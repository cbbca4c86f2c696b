//! Quotients of dyadic numbers.

use std::cmp::Ordering;

use dashu_int::IBig;
use dashu_int::ops::{Gcd, SquareRoot};

use super::enclosure::Enclosure;
use super::number::{Dyadic, signum};

/// A rational number: a dyadic one over a positive odd integer, in lowest terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Rational {
    numerator: Dyadic,
    denominator: IBig,
}

impl From<&Dyadic> for Rational {
    fn from(x: &Dyadic) -> Rational {
        Rational { numerator: x.clone(), denominator: IBig::ONE }
    }
}

impl Rational {
    /// 0.
    pub fn zero() -> Rational {
        Rational::from(&Dyadic::zero())
    }

    /// `numerator/denominator`; `denominator > 0`.
    pub(super) fn new(numerator: &Dyadic, denominator: &Dyadic) -> Rational {
        let zeros = denominator.mantissa.trailing_zeros().unwrap_or(0);
        let odd = &denominator.mantissa >> zeros;
        let exponent = numerator.exponent - denominator.exponent - zeros as isize;
        Rational::reduced(numerator.mantissa.clone(), exponent, odd)
    }

    fn reduced(mantissa: IBig, exponent: isize, odd: IBig) -> Rational {
        if odd == IBig::ONE {
            return Rational { numerator: Dyadic::new(mantissa, exponent), denominator: odd };
        }
        let common = IBig::from((&mantissa).gcd(&odd));
        Rational { numerator: Dyadic::new(mantissa / &common, exponent), denominator: odd / common }
    }

    /// The product with a dyadic number.
    pub fn times(&self, x: &Dyadic) -> Rational {
        let Dyadic { mantissa, exponent } = &self.numerator * x;
        Rational::reduced(mantissa, exponent, self.denominator.clone())
    }

    /// The sum.
    pub fn plus(&self, other: &Rational) -> Rational {
        let over = |x: &Rational, by: &IBig| &x.numerator * &Dyadic::new(by.clone(), 0);
        if self.denominator == other.denominator {
            let Dyadic { mantissa, exponent } = &self.numerator + &other.numerator;
            return Rational::reduced(mantissa, exponent, self.denominator.clone());
        }
        let sum = over(self, &other.denominator) + over(other, &self.denominator);
        let denominator = &self.denominator * &other.denominator;
        Rational::reduced(sum.mantissa, sum.exponent, denominator)
    }

    /// The order of this number and `x`.
    pub fn cmp_real(&self, x: &Dyadic) -> Ordering {
        self.numerator.cmp(&(x * &self.denominator()))
    }

    /// Bounds of a number that is at least 0, the number itself where it is dyadic.
    pub fn enclose(&self, n_bits: usize) -> Enclosure {
        let numerator = Enclosure::of(&self.numerator);
        if self.denominator == IBig::ONE {
            return numerator;
        }
        let quotient = numerator.over(&Enclosure::of(&self.denominator()), n_bits);
        quotient.unwrap_or(numerator)
    }

    fn denominator(&self) -> Dyadic {
        Dyadic::new(self.denominator.clone(), 0)
    }
}

/// Returns `√x` if it is dyadic; `x ≥ 0`.
pub fn dyadic_root(x: &Dyadic) -> Option<Dyadic> {
    if signum(x) == 0 {
        return Some(Dyadic::zero());
    }
    let odd = x.exponent.rem_euclid(2) as usize;
    let radicand = &x.mantissa << odd;
    let root = IBig::from(radicand.sqrt());
    (&root * &root == radicand).then(|| Dyadic::new(root, (x.exponent - odd as isize) / 2))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::exact::{integer, real};

    #[test]
    fn fractions_are_those_of_integers() {
        let mut rng = ChaCha8Rng::seed_from_u64(2401);
        for _ in 0..5000 {
            let mut number = || rng.random_range(1..400);
            let [a, b, c, d, x] = std::array::from_fn(|_| number());
            let of = |a: i64, b: i64| Rational::new(&integer(a), &integer(b));
            assert_eq!(of(a, b), of(a * c, b * c), "{a}/{b}, {c}");
            assert_eq!(of(a, b).plus(&of(c, d)), of(a * d + c * b, b * d), "{a}/{b} + {c}/{d}");
            assert_eq!(of(a, b).times(&integer(c)), of(a * c, b), "{a}/{b} × {c}");
            assert_eq!(of(a, b).cmp_real(&integer(x)), a.cmp(&(x * b)), "{a}/{b}, {x}");
        }
    }

    #[test]
    fn roots_of_squares_alone_are_dyadic() {
        let mut rng = ChaCha8Rng::seed_from_u64(2402);
        for _ in 0..5000 {
            let x = rng.random_range(1.0..2.0) * 2f64.powi(rng.random_range(-500..500));
            let x = real(x).unwrap();
            let square = &x * &x;
            assert_eq!(dyadic_root(&square), Some(x.clone()));
            for other in [integer(2), integer(3)] {
                assert_eq!(dyadic_root(&(&square * &other)), None);
            }
        }
        assert_eq!(dyadic_root(&Dyadic::zero()), Some(Dyadic::zero()));
    }
}
