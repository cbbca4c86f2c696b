//! Numbers of some 100 bits with a bound of their error, between f64 and exact arithmetic.

use std::ops::{Add, Mul, Neg, Sub};

/// Half a step of f64 at 1, squared: what the operations here are off by is a small multiple of it.
const UNIT2: f64 = 1.0 / (1u128 << 106) as f64;

/// Error of a sum, of `|x| + |y|`. The low parts' sum is off by `u²(|x| + |y|)`, its sum with the high parts' rest by twice that.
/// Tests see 0.3 of it, and no test half: low parts that are as large as they may be sum to just below a power of two, where a
/// rounding is half as much.
pub const SUM: f64 = 3.1 * UNIT2;

/// Error of a product, of `|xy|`: Muller and Rideau, Formalization of double-word arithmetic (2022), theorem for `DWTimesDW1`.
pub const PRODUCT: f64 = 5.01 * UNIT2;

/// Error of a quotient, of `|x/y|`. The rest of the high parts is exact and at most `u|x|`. With `x`'s low part it is rounded
/// (2), the product with `y`'s is (1), so is their difference (3), its quotient (3), and that is by `y`'s high part alone (3).
pub const QUOTIENT: f64 = 12.1 * UNIT2;

/// Error of a root, of `√x`: Lefèvre, Louvet, Muller, Picot and Rideau, Accurate calculation of Euclidean norms using double-word
/// arithmetic (2023), theorem for `SQRTDWtoDW`, 25/8.
pub const ROOT: f64 = 3.13 * UNIT2;

/// More than the bounds' own rounding, in one operation. No test sees it halved: that is a few `2⁻⁵³`.
const ROOM: f64 = 1.0 + 1.0 / (1u64 << 40) as f64;

/// What leaves f64's normal range on the way. No test sees it halved: that is a few of the `2⁵²` subnormals below it.
const TINY: f64 = f64::MIN_POSITIVE;

/// `high + low`, off by `error` at most. Numbers that leave f64's range have an error that is infinite or not a number, and
/// then nothing is known.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// The number that is nearest to the middle.
    pub high: f64,
    /// The rest.
    pub low: f64,
    /// Bound of the error.
    pub error: f64,
}

/// `x + y` and what its rounding lost.
#[inline(always)]
fn two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let of_y = sum - x;
    (sum, (x - (sum - of_y)) + (y - of_y))
}

/// The upper 26 bits and the rest.
#[inline(always)]
fn split(x: f64) -> (f64, f64) {
    let moved = x * ((1u64 << 27) + 1) as f64;
    let upper = moved - (moved - x);
    (upper, x - upper)
}

/// `xy` and what its rounding lost (Dekker 1971).
#[inline(always)]
fn two_product(x: f64, y: f64) -> (f64, f64) {
    let product = x * y;
    let ((a, b), (c, d)) = (split(x), split(y));
    (product, ((a * c - product) + a * d + b * c) + b * d)
}

impl From<f64> for Ball {
    fn from(x: f64) -> Ball {
        Ball { high: x, low: 0.0, error: 0.0 }
    }
}

impl Ball {
    /// Returns `x − y`, exactly, unless it overflows. Then `high` is infinite, `low` is NaN, and `error` is still 0.
    ///
    /// A bound of 0 is safe there, as nothing is decided from such a number unless it is true:
    /// 1. [`Ball::is_positive`] of it is true only if `high` is `+∞`. Then `x − y` is larger than every f64.
    /// 2. [`Ball::nearest_f32`] compares `∞ − ∞` with the error. That is NaN, so the answer is `None`.
    /// 3. A sum, a product, a root, or a quotient with it as the numerator adds a multiple of the infinite result to the error,
    ///    which is then infinite or NaN.
    /// 4. A quotient with it as the denominator has a NaN in `low`, which makes its `high` NaN.
    /// 5. If the error is infinite or NaN, or `high` is NaN, then [`Ball::is_positive`] is false and [`Ball::nearest_f32`] is
    ///    `None`. Every number computed from such a number is of this kind, too.
    /// 6. A false [`Ball::is_positive`] decides nothing: a shape then reports that its surface is undecided, or takes a formula
    ///    that holds for both signs.
    pub fn difference(x: f64, y: f64) -> Ball {
        let (high, low) = two_sum(x, -y);
        Ball { high, low, error: 0.0 }
    }

    #[inline(always)]
    fn of((high, low): (f64, f64), error: f64) -> Ball {
        let (high, low) = two_sum(high, low);
        Ball { high, low, error: ROOM * error }
    }

    /// Whether it surely is above 0.
    pub fn is_positive(&self) -> bool {
        self.high > ROOM * self.error
    }

    /// `√x`, of a number that is not surely negative.
    pub fn sqrt(self) -> Ball {
        let root = self.high.max(0.0).sqrt();
        // No test sees the 2 halved: what follows holds for `e ≤ x` as well.
        if self.high <= 2.0 * self.error {
            // Between 0 and the root of what is three times as much.
            return Ball {
                high: root,
                low: 0.0,
                // No test sees the 2 halved: 1 would do.
                error: 2.0 * (self.high.abs() + self.error).sqrt(),
            };
        }
        let (square, rest) = two_product(root, root);
        let low = ((self.high - square) - rest + self.low) / (2.0 * root);
        // `√(x + e) − √x` is at most `e/√x` on both sides, as `e ≤ x/2`.
        Ball::of((root, low), ROOT * root + (self.error + TINY) / root + TINY)
    }

    /// `x/y`.
    pub fn over(self, y: Ball) -> Ball {
        let quotient = self.high / y.high;
        let (product, rest) = two_product(quotient, y.high);
        let rest = (self.high - product) - rest + self.low - quotient * y.low;
        let least = y.high.abs() - ROOM * y.error;
        let error = (self.error + quotient.abs() * y.error * ROOM + TINY) / least;
        let error = if least > 0.0 { error + QUOTIENT * quotient.abs() } else { f64::INFINITY };
        Ball::of((quotient, rest / y.high), error + TINY)
    }

    /// The f32 that every number in it is nearest to, where there is one in the normal range.
    pub fn nearest_f32(&self) -> Option<f32> {
        let nearest = self.high as f32;
        let edge = |next: f32| (f64::from(nearest) + f64::from(next)) / 2.0;
        let above = (edge(nearest.next_up()) - self.high) - self.low;
        let below = (self.high - edge(nearest.next_down())) + self.low;
        let error = ROOM * self.error;
        let is_one = above > error && below > error && nearest.next_up().is_finite();
        (is_one && nearest.is_normal()).then_some(nearest)
    }
}

impl Add for Ball {
    type Output = Ball;
    #[inline(always)]
    fn add(self, y: Ball) -> Ball {
        let (sum, rest) = two_sum(self.high, y.high);
        let size = self.high.abs() + y.high.abs();
        Ball::of((sum, rest + (self.low + y.low)), self.error + y.error + SUM * size)
    }
}

impl Neg for Ball {
    type Output = Ball;
    #[inline(always)]
    fn neg(self) -> Ball {
        Ball { high: -self.high, low: -self.low, ..self }
    }
}

impl Sub for Ball {
    type Output = Ball;
    #[inline(always)]
    fn sub(self, y: Ball) -> Ball {
        self + -y
    }
}

impl Mul for Ball {
    type Output = Ball;
    #[inline(always)]
    fn mul(self, y: Ball) -> Ball {
        let (product, rest) = two_product(self.high, y.high);
        let rest = rest + (self.high * y.low + self.low * y.high);
        let carried = self.high.abs() * y.error + (y.high.abs() + y.error) * self.error;
        Ball::of((product, rest), carried + PRODUCT * product.abs() + TINY)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::exact::{Dyadic, QuadraticSurd, real, signum};

    fn exact(x: &Ball) -> Dyadic {
        real(x.high).unwrap() + real(x.low).unwrap()
    }

    fn is_within(found: &Ball, error: f64, middle: &QuadraticSurd) -> bool {
        let (here, error) = (exact(found), real(error).unwrap());
        middle.cmp_real(&(&here - &error)).is_ge() && middle.cmp_real(&(&here + &error)).is_le()
    }

    /// Every other one a little above a power of two, where a rounding costs most.
    fn drawn(rng: &mut ChaCha8Rng) -> Ball {
        let mut part = |scale: i32| rng.random_range(-1.0..1.0f64) * 2f64.powi(scale);
        let (any, above, low) = (part(0), part(-4).abs(), part(-53));
        let (high, low) = two_sum(if rng.random() { any } else { 1.0 + above.powi(3) }, low);
        let scale = 2f64.powi(rng.random_range(-90..90));
        Ball { high: high * scale, low: low * scale, error: 0.0 }
    }

    type Operation =
        (&'static str, f64, fn(Ball, Ball) -> Ball, fn(Dyadic, Dyadic) -> QuadraticSurd, f64);

    const OPERATIONS: [Operation; 4] = [
        ("sum", SUM, |x, y| x + y, |x, y| QuadraticSurd::from(x + y), 0.3),
        ("product", PRODUCT, |x, y| x * y, |x, y| QuadraticSurd::from(x * y), 0.5),
        ("quotient", QUOTIENT, Ball::over, quotient, 0.4),
        (
            "root",
            ROOT,
            |x, _| x.sqrt(),
            |x, _| QuadraticSurd::new(Dyadic::zero(), 1, x, Dyadic::one(), 1),
            0.5,
        ),
    ];

    fn quotient(x: Dyadic, y: Dyadic) -> QuadraticSurd {
        match signum(&y) {
            1 => QuadraticSurd::quotient(x, y, 1),
            _ => QuadraticSurd::quotient(-x, -y, 1),
        }
    }

    /// Every operation is within its bound, and not within a part of it: half of it for products and roots, less for
    /// quotients and sums, whose worst cases are rarer.
    #[test]
    fn operations_are_within_their_bounds() {
        for (name, bound, operation, truth, part) in OPERATIONS {
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            let mut n_beyond = 0;
            for _ in 0..200_000 {
                let (mut x, mut y) = (drawn(&mut rng), drawn(&mut rng));
                if name == "sum" {
                    // Of one sign and size.
                    (x.high, x.low) = (x.high.abs(), x.low.abs());
                    y = Ball { error: 0.0, ..y * Ball::from(x.high / y.high) };
                }
                if name == "root" {
                    x = if x.high < 0.0 { -x } else { x };
                }
                let (found, middle) = (operation(x, y), truth(exact(&x), exact(&y)));
                assert!(
                    is_within(&found, found.error, &middle),
                    "{name} of {x:?} and {y:?}: {found:?}"
                );
                n_beyond += usize::from(!is_within(&found, part * found.error, &middle));
            }
            assert!(n_beyond > 0, "{name}: {bound:e} is more than {}-fold", 1.0 / part);
        }
    }

    /// What the numbers are off by goes through all operations.
    #[test]
    fn errors_are_carried() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        for (name, _, operation, truth, _) in OPERATIONS {
            for _ in 0..50_000 {
                let off = |x: Ball, rng: &mut ChaCha8Rng| {
                    let error = x.high.abs() * 2f64.powi(-rng.random_range(1..100));
                    let moved = real(error).unwrap() * real(rng.random_range(-1.0..1.0)).unwrap();
                    (Ball { error, ..x }, exact(&x) + moved)
                };
                let (x, y) = (drawn(&mut rng), drawn(&mut rng));
                let x = if name == "root" && x.high < 0.0 { -x } else { x };
                let ((x, moved_x), (y, moved_y)) = (off(x, &mut rng), off(y, &mut rng));
                if signum(&moved_y) == 0 || name == "root" && signum(&moved_x) < 0 {
                    continue;
                }
                let (found, middle) = (operation(x, y), truth(moved_x, moved_y));
                let is_right =
                    found.error == f64::INFINITY || is_within(&found, found.error, &middle);
                assert!(is_right, "{name} of {x:?} and {y:?}: {found:?}");
            }
        }
    }

    /// Whether nothing is known of a number.
    fn is_unknown(found: &Ball) -> bool {
        let has_no_bound = !found.error.is_finite() || found.high.is_nan();
        has_no_bound && !found.is_positive() && found.nearest_f32().is_none()
    }

    #[test]
    fn a_difference_that_overflows_decides_nothing() {
        let most = f64::MAX;
        for (x, y) in [(most, -most), (-most, most), (0.75 * most, -0.5 * most)] {
            let endless = Ball::difference(x, y);
            assert!(endless.high.is_infinite() && endless.error == 0.0, "{endless:?}");
            assert_eq!((endless.is_positive(), endless.nearest_f32()), (x > 0.0, None));
            for other in [0.0, 1e-300, -2.5, most, f64::INFINITY].map(Ball::from) {
                for (name, _, operation, ..) in OPERATIONS {
                    // A root has one operand.
                    let n_orders = if name == "root" { 1 } else { 2 };
                    let found = [operation(endless, other), operation(other, endless)];
                    for found in &found[..n_orders] {
                        assert!(is_unknown(found), "{name} of {endless:?}, {other:?}: {found:?}");
                        for (name, _, operation, ..) in OPERATIONS {
                            let next = operation(*found, Ball::from(3.0));
                            assert!(is_unknown(&next), "{name} of {found:?}: {next:?}");
                        }
                    }
                }
            }
        }
    }

    /// Differences near the largest f64, where the rounding error of the sum may overflow.
    #[test]
    fn a_difference_next_to_the_largest_number_is_exact_or_unknown() {
        let most = f64::MAX;
        let step = most - most.next_down();
        for part in [0.25, 0.49, 0.5, 0.75, 1.0, 1.5] {
            for (x, y) in [(most, part * step), (most, -part * step), (-part * step, most)] {
                let found = Ball::difference(x, y);
                if found.high.is_finite() && found.low.is_finite() {
                    assert_eq!(exact(&found), real(x).unwrap() - real(y).unwrap(), "{x:e} {y:e}");
                } else {
                    assert!(is_unknown(&(found * Ball::from(1.0))), "{x:e} {y:e}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn numbers_near_the_middle_of_two_have_no_nearest_one() {
        let middle = 1.0 + f64::from(f32::EPSILON) / 2.0;
        let at = |low: f64, error: f64| Ball { high: middle, low, error }.nearest_f32();
        assert_eq!(at(1e-20, 1e-21), None);
        assert_eq!(at(-1e-20, 1e-21), Some(1.0));
        assert_eq!(at(-1e-20, 2e-20), None);
        let at = |high: f64, error: f64| Ball { high, low: 0.0, error }.nearest_f32();
        assert_eq!(at(middle + 1e-9, 1e-10), Some(1.0 + f32::EPSILON));
        assert_eq!(at(1.0, 0.0), Some(1.0));
        for unknown in [f64::NAN, f64::INFINITY] {
            assert_eq!(at(1.0, unknown), None);
            assert_eq!(at(unknown, 0.0), None);
        }
        assert_eq!((at(0.0, 1e-30), at(1e-40, 1e-50), at(1e39, 1.0)), (None, None, None));
    }
}
