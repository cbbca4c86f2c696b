//! Arithmetic with [`QuadraticSurd`]s, and their decimal digits.
//!
//! Results that are no [`QuadraticSurd`] are replaced by a number of a thousand bits, far more than an explanation prints.

use std::cmp::Ordering;

use dashu_int::IBig;
use dashu_int::ops::BitTest;
use kugelblitz::exact::{Dyadic, QuadraticSurd, dyadic_root, integer, signum};

/// Bits of an approximation that replaces a number.
const ENOUGH_BITS: usize = 1024;

/// Sums, products and decimals of [`QuadraticSurd`]s.
///
/// A result is exact if it is a [`QuadraticSurd`], otherwise its relative error is below `2^-1000`.
pub(crate) trait Calculator: Sized {
    /// Returns the sum; exact if the square roots are multiples of each other.
    fn plus(&self, other: &Self) -> Self;

    /// Returns the product.
    fn times(&self, other: &Self) -> Self;

    /// Returns the quotient; 0 for a divisor of 0.
    fn over(&self, divisor: &Self) -> Self;

    /// Returns the square root of a number of at least 0.
    fn sqrt(&self) -> Self;

    /// Parses a decimal such as `-12.5` or `1.25e-30`; `None` for other text, and for exponents beyond the range of an `i16`.
    fn parse(text: &str) -> Option<Self>;

    /// Formats the number, correctly rounded to `digits` significant digits (half to even), without trailing zeros: `-12.5`,
    /// or `1.25e-30` if it is very large or small.
    fn to_decimal(&self, digits: usize) -> String;
}

impl Calculator for QuadraticSurd {
    fn plus(&self, other: &QuadraticSurd) -> QuadraticSurd {
        let (x, y) = (CalculatorFields::of(self), CalculatorFields::of(other));
        let [by_x, by_y] =
            if x.a == y.a { [Dyadic::one(), Dyadic::one()] } else { [y.a.clone(), x.a.clone()] };
        let surds = [(x.s, &x.d * &by_x * &by_x), (y.s, &y.d * &by_y * &by_y)];
        match sum_of_surds(surds) {
            Some((s, d)) => QuadraticSurd::new(&x.b * &by_x + &y.b * &by_y, s, d, &x.a * &by_x, 1),
            None => rational(self).plus(&rational(other)),
        }
    }

    fn times(&self, other: &QuadraticSurd) -> QuadraticSurd {
        let (x, y) = (CalculatorFields::of(self), CalculatorFields::of(other));
        let across =
            [(x.s * signum(&y.b), &y.b * &y.b * &x.d), (y.s * signum(&x.b), &x.b * &x.b * &y.d)];
        match (dyadic_root(&(&x.d * &y.d)), sum_of_surds(across)) {
            (Some(both), Some((s, d))) => QuadraticSurd::new(
                &x.b * &y.b + both * integer((x.s * y.s).into()),
                s,
                d,
                &x.a * &y.a,
                1,
            ),
            _ => rational(self).times(&rational(other)),
        }
    }

    /// `A/(B + s√D) = A·(B − s√D)/(B² − D)`
    fn over(&self, divisor: &QuadraticSurd) -> QuadraticSurd {
        let y = CalculatorFields::of(divisor);
        let norm = &y.b * &y.b - &y.d;
        let inverse = |b: Dyadic, s: i32, norm: Dyadic| {
            QuadraticSurd::new(b * &y.a, s, &y.d * &y.a * &y.a, norm, 1)
        };
        match signum(&norm) {
            0 => QuadraticSurd::from(Dyadic::zero()),
            1 => self.times(&inverse(y.b.clone(), -y.s, norm)),
            _ => self.times(&inverse(-y.b.clone(), y.s, -norm)),
        }
    }

    fn sqrt(&self) -> QuadraticSurd {
        let x = CalculatorFields::of(&rational(self));
        QuadraticSurd::new(Dyadic::zero(), 1, &x.b * &x.a, x.a, 1)
    }

    fn parse(text: &str) -> Option<QuadraticSurd> {
        let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
        let (whole, part) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits: IBig = format!("{whole}{part}").parse().ok()?;
        let exponent = isize::from(exponent.parse::<i16>().ok()?) - part.len() as isize;
        Some(times_power_of_ten(&QuadraticSurd::from(Dyadic::from(digits)), exponent))
    }

    /// `q·10^e` with `10^(digits−1) ≤ q < 10^digits`: the exponent is guessed from the binary one
    /// and corrected by what `q` turns out to be, and `q`, the integer nearest to the number
    /// scaled by `10^−e`, is guessed and then moved by exact comparisons.
    fn to_decimal(&self, digits: usize) -> String {
        let digits = digits.max(1);
        let sign = self.signum();
        if sign == 0 {
            return "0".to_owned();
        }
        let magnitude = self.magnitude();
        let precision = 4 * digits + 32;
        let estimate = magnitude.approximate(precision);
        let binary_exponent = estimate.exponent() + estimate.mantissa().bit_len() as isize - 1;
        let mut leading = (binary_exponent as f64 * std::f64::consts::LOG10_2).floor() as isize;
        let ten = |n: usize| IBig::from(10).pow(n);
        // Never turns back: q ≥ 10^n means a scaled number of at least 10^n − ½, so a tenth of it
        // rounds to 10^(n−1) or more; q < 10^(n−1) one below 10^(n−1) − ½, ten times it to less
        // than 10^n.
        let q = loop {
            let scaled = times_power_of_ten(&magnitude, digits as isize - 1 - leading);
            let q = nearest_integer(&scaled, precision);
            if q >= ten(digits) {
                leading += 1;
            } else if q < ten(digits - 1) {
                leading -= 1;
            } else {
                break q;
            }
        };
        let text = q.to_string();
        let mantissa = text.trim_end_matches('0');
        layout(sign < 0, mantissa, leading, digits)
    }
}

/// The number `(b + s·√d)/a`, without a square root that is dyadic.
struct CalculatorFields {
    b: Dyadic,
    s: i32,
    d: Dyadic,
    a: Dyadic,
}

impl CalculatorFields {
    fn of(root: &QuadraticSurd) -> CalculatorFields {
        let f = integer(root.factor().into());
        let (b, a) = (root.rational_part() * &f, root.denominator().clone());
        let (s, d) = (root.root_sign(), root.radicand() * &f * &f);
        match dyadic_root(&d) {
            Some(root) => {
                CalculatorFields { b: b + root * integer(s.into()), s: 0, d: Dyadic::zero(), a }
            }
            None => CalculatorFields { b, s, d, a },
        }
    }
}

/// Returns the number itself if it is a quotient, otherwise one with a relative error below `2^-1000`.
fn rational(root: &QuadraticSurd) -> QuadraticSurd {
    if dyadic_root(root.radicand()).is_some() {
        let CalculatorFields { b, a, .. } = CalculatorFields::of(root);
        return QuadraticSurd::new(b, 0, Dyadic::zero(), a, 1);
    }
    let magnitude = root.magnitude().approximate(ENOUGH_BITS);
    QuadraticSurd::from(magnitude * integer(root.signum().into()))
}

/// Returns `s·√x + t·√y` as one square root with a sign, if it is one.
fn sum_of_surds([(s, x), (t, y)]: [(i32, Dyadic); 2]) -> Option<(i32, Dyadic)> {
    if s == 0 || t == 0 {
        return Some(if s == 0 { (t, y) } else { (s, x) });
    }
    let root = dyadic_root(&(&x * &y))?;
    let (twice, sum) = (&root + &root, &x + &y);
    Some(if s == t { (s, sum + twice) } else { (s * signum(&(&x - &y)), sum - twice) })
}

/// Returns `root·10^exponent`.
fn times_power_of_ten(root: &QuadraticSurd, exponent: isize) -> QuadraticSurd {
    let power = Dyadic::from(IBig::from(10).pow(exponent.unsigned_abs()));
    let (b, s, d) = (root.rational_part(), root.root_sign(), root.radicand());
    let (a, factor) = (root.denominator(), root.factor());
    if exponent < 0 {
        QuadraticSurd::new(b.clone(), s, d.clone(), a * power, factor)
    } else {
        QuadraticSurd::new(b * &power, s, d * &power * &power, a.clone(), factor)
    }
}

/// Returns the integer nearest to a number of at least 0, half to even.
fn nearest_integer(root: &QuadraticSurd, precision: usize) -> IBig {
    let estimate = root.approximate(precision);
    let mut q = match estimate.exponent() {
        exponent @ 0.. => estimate.mantissa() << exponent as usize,
        exponent => estimate.mantissa() >> exponent.unsigned_abs(),
    };
    let half = Dyadic::new(IBig::ONE, -1);
    let even = |q: &IBig| q.trailing_zeros() != Some(0);
    loop {
        let here = Dyadic::from(q.clone());
        match root.cmp_real(&(&here + &half)) {
            Ordering::Greater => q += 1,
            Ordering::Equal if !even(&q) => q += 1,
            Ordering::Equal => return q,
            Ordering::Less => match root.cmp_real(&(&here - &half)) {
                Ordering::Less => q -= 1,
                Ordering::Equal if !even(&q) => q -= 1,
                _ => return q,
            },
        }
    }
}

/// Formats `d.ddd·10^leading`, where `mantissa` is `dddd`: without an exponent if that takes few zeros.
fn layout(negative: bool, mantissa: &str, leading: isize, digits: usize) -> String {
    let sign = if negative { "-" } else { "" };
    let n = mantissa.len() as isize;
    if leading < -5 || leading >= (digits as isize).max(6) {
        let (first, rest) = mantissa.split_at(1);
        let point = if rest.is_empty() { "" } else { "." };
        format!("{sign}{first}{point}{rest}e{leading}")
    } else if leading < 0 {
        format!("{sign}0.{}{mantissa}", "0".repeat((-leading - 1) as usize))
    } else if leading >= n - 1 {
        format!("{sign}{mantissa}{}", "0".repeat((leading + 1 - n) as usize))
    } else {
        let (whole, fraction) = mantissa.split_at((leading + 1) as usize);
        format!("{sign}{whole}.{fraction}")
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec3;
    use kugelblitz::exact::{ExactRay, nearest, real, sphere_numbers};
    use kugelblitz::query::WorldRay;
    use kugelblitz::scene::{Object, Sphere};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Each operation is undone by its reverse; with two square roots, to a thousand bits.
    #[test]
    fn arithmetic_is_that_of_numbers() {
        let mut rng = ChaCha8Rng::seed_from_u64(3101);
        let apart =
            |x: &QuadraticSurd, y: &QuadraticSurd| x.plus(&y.clone().negated()).to_f64().abs();
        for round in 0..400 {
            let mut whole = |from| integer(rng.random_range(from..90));
            let [d, a, b] = [whole(0), whole(1), whole(-90)];
            let (sign, c, e, f) =
                (if signum(&b) < 0 { 1 } else { -1 }, whole(1), whole(-90), whole(1));
            let of = |b, y: &Dyadic, a| QuadraticSurd::new(b, sign, &d * y * y, a, 3);
            let x = of(b, &a, f.clone());
            let y = match round % 4 {
                0 => of(e, &Dyadic::zero(), c),
                1 => QuadraticSurd::new(e, 1, whole(0), c, 1),
                _ => of(e, &whole(0), c),
            };
            let (sum, product) = (x.plus(&y), x.times(&y));
            let [f, g] = [x.to_f64(), y.to_f64()];
            assert!(
                (sum.to_f64() - (f + g)).abs() < 1e-10 && (product.to_f64() - f * g).abs() < 1e-6
            );
            if round % 4 != 1 {
                assert!(sum.plus(&y.clone().negated()) == x, "{x:?} {y:?}");
                assert!(y.signum() == 0 || product.over(&y) == x, "{x:?} {y:?}");
            }
            assert!(apart(&sum.plus(&y.clone().negated()), &x) < 1e-290, "{x:?} {y:?}");
            assert!(y.signum() == 0 || apart(&product.over(&y), &x) < 1e-290, "{x:?} {y:?}");
            let square = x.times(&x);
            assert!(apart(&square.sqrt(), &x).min(apart(&square.sqrt(), &x.negated())) < 1e-290);
        }
        for (text, expected) in [("-12.5", -12.5), ("1.25e-3", 0.00125), ("7e2", 700.0)] {
            assert_eq!(QuadraticSurd::parse(text).map(|x| x.to_f64()), Some(expected));
        }
    }

    #[test]
    fn decimals() {
        let short = |value: f64, n: usize| QuadraticSurd::from(real(value).unwrap()).to_decimal(n);
        let decimal = |value: f64| short(value, 20);
        assert_eq!(decimal(0.0), "0");
        assert_eq!(decimal(-0.0), "0");
        assert_eq!(decimal(1.0), "1");
        assert_eq!(decimal(-12.5), "-12.5");
        assert_eq!(decimal(0.1), "0.10000000000000000555");
        assert_eq!(decimal(100.0), "100");
        assert_eq!(decimal(1e19), "10000000000000000000");
        assert_eq!(decimal(1e20), "1e20");
        assert_eq!(decimal(1.25e-30), "1.249999999999999929e-30");
        assert_eq!(decimal(0.5f64.powi(10)), "0.0009765625");
        assert_eq!(decimal(f64::from_bits(1)), "4.9406564584124654418e-324");
        assert_eq!(decimal(f64::MAX), "1.7976931348623157081e308");
        assert_eq!(short(0.125, 2), "0.12");
        assert_eq!(short(0.375, 2), "0.38");
        assert_eq!(short(9.96875, 2), "10");
        assert_eq!(short(0.00099999, 3), "0.001");
        // √2: a unit sphere seen from outside, off its centre, by a long way round.
        let (origin, direction) = (dvec3(-2.0, 0.0, 0.0), dvec3(1.0, 1.0, 0.0));
        let ray = ExactRay::new(&WorldRay { origin, direction });
        let sphere = Sphere { center: dvec3(0.0, 2.0, 0.0), radius: 2.0 };
        let hit = nearest(&ray, [(1, Object::Sphere(&sphere))]).unwrap();
        assert_eq!(hit.root.to_decimal(20), "0.5857864376269049512");
        let numbers = sphere_numbers(&ray, &sphere).unwrap();
        assert_eq!(numbers.discriminant.to_decimal(20), "32", "D = 4·(4² − 2·4)");
    }
}
