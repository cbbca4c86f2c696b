//! Real numbers between two dyadic ones, for what has no simple sign rule.

use dashu_int::ops::{BitTest, SquareRoot};

use super::number::{Dyadic, power_of_two, signum};

/// A number of which only bounds are known: `low ≤ x ≤ high`, both at least 0.
#[derive(Clone, Debug)]
pub struct Enclosure {
    /// Lower bound.
    pub low: Dyadic,
    /// Upper bound.
    pub high: Dyadic,
}

impl Enclosure {
    /// A number that is known exactly; a negative one counts as 0.
    pub fn of(x: &Dyadic) -> Enclosure {
        Enclosure::between(x.clone(), x.clone())
    }

    /// Numbers from `low` to `high`; what is below 0 is cut off.
    pub fn between(low: Dyadic, high: Dyadic) -> Enclosure {
        let positive = |x: Dyadic| if signum(&x) < 0 { Dyadic::zero() } else { x };
        Enclosure { low: positive(low), high: positive(high) }
    }

    /// The sum.
    pub fn plus(&self, other: &Enclosure) -> Enclosure {
        Enclosure { low: &self.low + &other.low, high: &self.high + &other.high }
    }

    /// The product, to `n_bits` bits.
    pub fn times(&self, other: &Enclosure, n_bits: usize) -> Enclosure {
        Enclosure { low: &self.low * &other.low, high: &self.high * &other.high }.to_bits(n_bits)
    }

    /// The quotient, to `n_bits` bits; `None` where the divisor may be 0.
    pub fn over(&self, divisor: &Enclosure, n_bits: usize) -> Option<Enclosure> {
        if signum(&divisor.low) == 0 {
            return None;
        }
        let low = quotient(&self.low, &divisor.high, n_bits).low;
        Some(Enclosure { low, high: quotient(&self.high, &divisor.low, n_bits).high })
    }

    /// The square root, to `n_bits` bits.
    pub fn sqrt(&self, n_bits: usize) -> Enclosure {
        let low = square_root(&self.low, n_bits).low;
        Enclosure { low, high: square_root(&self.high, n_bits).high }
    }

    /// Wider bounds of `n_bits` bits.
    pub fn to_bits(&self, n_bits: usize) -> Enclosure {
        Enclosure { low: cut(&self.low, n_bits).low, high: cut(&self.high, n_bits).high }
    }
}

/// The neighbours of `x ≥ 0` with up to `n_bits` bits, `x` itself where it has no more.
fn cut(x: &Dyadic, n_bits: usize) -> Enclosure {
    match x.mantissa.bit_len().saturating_sub(n_bits) {
        0 => Enclosure::of(x),
        excess => unit_from(Dyadic::new(&x.mantissa >> excess, x.exponent + excess as isize)),
    }
}

/// Bounds of `x/y`, one unit of the last of about `n_bits` bits apart; `x ≥ 0`, `y > 0`.
pub(super) fn quotient(x: &Dyadic, y: &Dyadic, n_bits: usize) -> Enclosure {
    if signum(x) == 0 {
        return Enclosure::of(&Dyadic::zero());
    }
    let shift = (n_bits + y.mantissa.bit_len()).saturating_sub(x.mantissa.bit_len());
    let quotient = (&x.mantissa << shift) / &y.mantissa;
    unit_from(Dyadic::new(quotient, x.exponent - y.exponent - shift as isize))
}

/// Bounds of `√x`, one unit of the last of about `n_bits` bits apart; `x ≥ 0`.
pub(super) fn square_root(x: &Dyadic, n_bits: usize) -> Enclosure {
    if signum(x) == 0 {
        return Enclosure::of(&Dyadic::zero());
    }
    let mut shift = (2 * n_bits).saturating_sub(x.mantissa.bit_len());
    shift += usize::from((x.exponent - shift as isize) % 2 != 0);
    unit_from(Dyadic::new((&x.mantissa << shift).sqrt().into(), (x.exponent - shift as isize) / 2))
}

/// From a number to one unit of its last bit above it.
fn unit_from(low: Dyadic) -> Enclosure {
    Enclosure { high: &low + &power_of_two(low.exponent), low }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::exact::real;

    fn number(rng: &mut ChaCha8Rng) -> f64 {
        match rng.random_range(0..12) {
            0 => 0.0,
            1 => f64::from(rng.random_range(1..9_u8)),
            _ => rng.random_range(1.0..2.0) * 2f64.powi(rng.random_range(-300..300)),
        }
    }

    /// `low ≤ x ≤ high` by what defines `x`, and no wider than `n_bits` bits.
    #[test]
    fn bounds_hold_and_are_narrow() {
        let mut rng = ChaCha8Rng::seed_from_u64(1401);
        let all = |x: &Dyadic| Enclosure::of(x);
        for _ in 0..20_000 {
            let n_bits = [53, 64, 200][rng.random_range(0..3)];
            let (x, y) = (number(&mut rng), number(&mut rng));
            let case = format!("{x:e} {y:e} {n_bits}");
            let (x, y) = (real(x).unwrap(), real(y).unwrap());
            let narrow = |e: &Enclosure| {
                let width = (&e.high - &e.low) * power_of_two(n_bits as isize - 2);
                assert!(e.low <= e.high && width <= e.high, "{case} {e:?}");
            };
            let root = all(&x).sqrt(n_bits);
            assert!(&root.low * &root.low <= x && x <= &root.high * &root.high, "{case}");
            let product = all(&x).times(&all(&y), n_bits);
            let xy = &x * &y;
            assert!(product.low <= xy && xy <= product.high, "{case}");
            narrow(&product);
            match all(&x).over(&all(&y), n_bits) {
                Some(e) => {
                    assert!(&e.low * &y <= x && x <= &e.high * &y, "{case}");
                    narrow(&e);
                    narrow(&root);
                }
                None => assert_eq!(signum(&y), 0),
            }
        }
    }
}
