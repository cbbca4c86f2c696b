//! Printed numbers as a calculator reads them.

use std::str::FromStr;

use dashu_float::round::mode::HalfAway;
use dashu_float::{Context, DBig};

use super::numbers::{MANY_DIGITS, Short};
use crate::exact::Root;

/// A decimal number. Operations on it keep [`PRECISION`] digits.
pub type Decimal = DBig;

/// Digits of a calculator whose own rounding doesn't matter: twice those of a number at most, and as many
/// more for what cancels.
const PRECISION: usize = 4 * MANY_DIGITS;

/// A number as it is printed; 0 for none.
pub fn read(text: &str) -> Decimal {
    let number = Decimal::from_str(text).unwrap_or(Decimal::ZERO);
    number.with_precision(PRECISION).value()
}

/// A small number.
pub fn integer(n: i32) -> Decimal {
    Decimal::from(n).with_precision(PRECISION).value()
}

/// The square root; 0 of a negative number.
pub fn sqrt(x: &Decimal) -> Decimal {
    let root = Context::<HalfAway>::new(PRECISION).sqrt(x.repr());
    root.map_or_else(|_| integer(0), |root| root.value())
}

/// The fewest digits, `digits` or more, with which `value` of the numbers rounds to what is printed of
/// the results. A result of 0 has no digits to be wrong in.
pub fn digits_for(
    numbers: &[&Root],
    value: fn(&[Decimal]) -> Vec<Decimal>,
    results: &[&Short],
    digits: usize,
) -> usize {
    let agree = |n_digits: &usize| {
        let numbers: Vec<_> =
            numbers.iter().map(|number| read(&number.to_decimal(*n_digits))).collect();
        let mut pairs = value(&numbers).into_iter().zip(results);
        pairs.all(|(value, result)| rounds_to(&value, &result.text, digits))
    };
    (digits..MANY_DIGITS).find(agree).unwrap_or(MANY_DIGITS)
}

/// Whether a number is at most half a unit of the last of so many digits away from a printed one.
fn rounds_to(value: &Decimal, printed: &str, digits: usize) -> bool {
    let printed = read(printed);
    let repr = printed.repr();
    if repr.significand().is_zero() {
        return true;
    }
    let leading = repr.exponent() + repr.digits() as isize - 1;
    let half_unit = Decimal::from_parts(5.into(), leading - digits as isize);
    let error = value - &printed;
    -&half_unit <= error && error <= half_unit
}
