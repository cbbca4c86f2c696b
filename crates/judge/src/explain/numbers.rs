//! Numbers beside the exact ones.

use kugelblitz::exact::{Dyadic, Enclosure, QuadraticSurd, exact, real};
use serde::Serialize;

use super::calculator::Calculator as _;
use crate::compare::Precision;

/// Digits of an exact number.
pub const DIGITS: usize = 20;

/// Digits that tell a rounded number from one that is written out whole; none in a formula has more.
pub const MANY_DIGITS: usize = 60;

/// A number rounded for a formula.
#[derive(Clone, Debug)]
pub struct Short {
    /// Six digits at most, or as many as are asked for.
    pub text: String,
    /// True where digits are missing.
    pub rounded: bool,
}

impl Short {
    /// A number to so many digits.
    pub fn new(root: &QuadraticSurd, digits: usize) -> Short {
        Short::of(root, root.to_decimal(digits))
    }

    /// A number of a scene, as someone has written it.
    pub(super) fn given(x: f64) -> Short {
        Short::of(&QuadraticSurd::from(exact(x)), decimal_f64(x))
    }

    fn of(root: &QuadraticSurd, text: String) -> Short {
        Short {
            rounded: QuadraticSurd::parse(&text)
                != QuadraticSurd::parse(&root.to_decimal(MANY_DIGITS)),
            text,
        }
    }
}

/// An exact number. Unstable in JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Exact {
    /// The number to 20 digits.
    pub decimal: String,
    /// Sign: -1, 0 or 1.
    pub signum: i32,
    #[serde(skip)]
    pub(super) root: QuadraticSurd,
}

impl From<QuadraticSurd> for Exact {
    fn from(root: QuadraticSurd) -> Exact {
        Exact { decimal: root.to_decimal(DIGITS), signum: root.signum(), root }
    }
}

/// Error of `value` in steps at the exact number; +∞ where `value` is not finite, and where it should be 0 and
/// isn't.
pub fn error_ulp(value: f64, exact: &QuadraticSurd, precision: Precision) -> f64 {
    let Some(value) = real(value) else { return f64::INFINITY };
    let error = exact.plus(&QuadraticSurd::from(-value)).to_f64().abs();
    if error == 0.0 {
        return 0.0;
    }
    if exact.signum() == 0 {
        return f64::INFINITY;
    }
    error / precision.ulp(exact.to_f64())
}

/// Bits of the bounds of a number, ever narrower.
const BITS: [usize; 4] = [512, 1024, 2048, 4096];

/// Stands for a number, at least 0, of which bounds are known that `n_bits` bits make narrow, unless they are too few for
/// any: the middle of bounds that are equal in all digits that are looked at.
pub fn enclosed(bounds: impl Fn(usize) -> Option<Enclosure>) -> QuadraticSurd {
    let digits = |x: &Dyadic| QuadraticSurd::from(x.clone()).to_decimal(MANY_DIGITS);
    let mut number = zero();
    for Enclosure { low, high } in BITS.into_iter().filter_map(bounds) {
        number = QuadraticSurd::from(simplest(&low, &high));
        if digits(&low) == digits(&high) {
            break;
        }
    }
    number
}

/// The number 0.
pub fn zero() -> QuadraticSurd {
    QuadraticSurd::from(Dyadic::zero())
}

/// The middle of bounds, or a number of few bits that lies within them: it is the exact one, if that has
/// so few.
fn simplest(low: &Dyadic, high: &Dyadic) -> Dyadic {
    let middle = (low + high) * exact(0.5);
    let near = Enclosure::of(&middle).to_bits(BITS[0] / 2);
    [near.low, near.high].into_iter().find(|x| low <= x && x <= high).unwrap_or(middle)
}

/// `x·2^exponent`: a number for a scaled direction as one for the ray's own.
pub fn scaled(x: f32, exponent: i32) -> f64 {
    libm::ldexp(x.into(), exponent)
}

/// A number in one arithmetic. Unstable in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Approximation {
    /// The number; `null` if this arithmetic has none, such as the root of a line that counts as a miss.
    pub value: Option<f64>,
    /// Error of `value` at the exact number, in f32 steps; in the column `f64`, in f64 steps. `null` if one of the two numbers
    /// does not exist, and in JSON if it is infinite: if `value` is not finite, or if only the exact number is 0.
    pub error_ulp: Option<f64>,
    /// Whether the sign differs from the sign of the exact number.
    pub wrong_sign: bool,
}

/// A number of a formula, in each arithmetic. Unstable in JSON.
#[derive(Clone, Debug, Serialize)]
pub struct FormulaNumber {
    /// Symbol in the formula.
    pub symbol: &'static str,
    /// The number in f32, as in the kernel `lecture`; `null` if it has no such number.
    pub lecture: Option<Approximation>,
    /// The number in f32, as in the kernel `stable`; `null` if it has no such number.
    pub stable: Option<Approximation>,
    /// The number in f64, with the lecture's formula; `null` if it has no such number.
    pub f64: Option<Approximation>,
    /// The exact number; `null` if there is none.
    pub exact: Option<Exact>,
}

/// The names of the columns of a table, with the kernel of each, but for the exact one.
pub const COLUMNS: [&str; 3] = ["f32 lecture", "f32 stable", "f64"];

impl FormulaNumber {
    /// The number in each of the [`COLUMNS`].
    pub(super) fn columns(&self) -> [Option<Approximation>; 3] {
        [self.lecture, self.stable, self.f64]
    }
}

/// The numbers of a row, in the order of its columns: `None` for no such number in this column, `Some(None)` for no root.
pub type Columns = [Option<Option<f64>>; 3];

/// A number in every column.
pub fn in_all(lecture: f32, stable: f64, double: f64) -> Columns {
    [f64::from(lecture), stable, double].map(|x| Some(Some(x)))
}

/// The shortest decimal that gives this f32 back. A number beyond f32's range, which stands for
/// one of a scaled direction, has 24 bits as well: nine digits tell it.
pub fn decimal_f32(x: f64) -> String {
    let single = x as f32;
    let text = if f64::from(single) == x { format!("{single:e}") } else { format!("{x:.8e}") };
    decimal(&text, 9)
}

/// The shortest decimal that gives this f64 back.
pub fn decimal_f64(x: f64) -> String {
    decimal(&format!("{x:e}"), 17)
}

/// Six digits, without zeros that say nothing.
pub fn six_digits(x: f64) -> String {
    digits(x, 6)
}

/// So many digits, without zeros that say nothing.
pub fn digits(x: f64, n: usize) -> String {
    format!("{x:.*e}", n - 1).parse().map_or_else(|_| String::new(), decimal_f64)
}

/// Rust's `d.ddde±n`, written as the exact numbers are.
fn decimal(scientific: &str, digits: usize) -> String {
    let number = QuadraticSurd::parse(scientific);
    number.map_or_else(|| scientific.replace("inf", "∞"), |number| number.to_decimal(digits))
}
