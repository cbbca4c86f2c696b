//! Rationals of another make than the numbers of the exact module.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::One;

pub type Q = BigRational;

/// Exact value of a finite f64.
pub fn q(x: f64) -> Q {
    Q::from_float(x).expect("finite")
}

/// `2^exponent`
pub fn power(exponent: i64) -> Q {
    let two = BigInt::one() << exponent.unsigned_abs();
    if exponent < 0 { Q::new_raw(BigInt::one(), two) } else { Q::from_integer(two) }
}
