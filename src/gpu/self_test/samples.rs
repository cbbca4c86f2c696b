//! The self-test's samples, and the outcome of each by IEEE 754. Twin of
//! `shaders/self_test.wgsl`.

use bytemuck::Pod;

use crate::num::{Float, ulp_distance};
use crate::support::random::SplitMix;

/// A constant that is divided by numbers, for which a driver may take a reciprocal.
pub const NUMERATOR: f32 = 1.0 + 1.0 / (1 << 19) as f32;

/// Samples of each sort.
const OF_EACH_SORT: usize = 1024;

/// Which operands a sample has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    /// Exponents −10 … 9: sums cancel, and nothing leaves the range.
    Near,
    /// The exponents that the kernels can meet.
    Wide,
    /// Operands or results below the normal range.
    Tiny,
    /// The largest numbers, ∞ and 0, to be compared.
    Large,
}

impl Sort {
    const ALL: [Sort; 4] = [Sort::Near, Sort::Wide, Sort::Tiny, Sort::Large];
}

/// All samples, with one texel each.
pub const N_SAMPLES: usize = Sort::ALL.len() * OF_EACH_SORT;

/// Least and largest exponent of [`Sort::Wide`], for f64 too.
const WIDE: [i32; 2] = [-104, 120];

/// Quotients are looked at up to this: beyond, Vulkan promises nothing of their denominators'
/// neighbourhood.
pub const LARGEST_RESULT: f64 = (1u128 << 126) as f64;

/// Operations that round, as places in [`SampledFloat::expected`].
pub const SUM: usize = 0;
pub const PRODUCT: usize = 1;
pub const QUOTIENT: usize = 2;
pub const ROOT: usize = 3;
pub const INVERSE: usize = 4;
pub const CONSTANT_OVER: usize = 5;
pub const N_ROUNDED: usize = 6;

/// Results that are selected or exact.
pub const LARGER: usize = 6;
pub const SUM_ERROR: usize = 7;
pub const FMA_REMAINDER: usize = 8;
pub const PRODUCT_SUM: usize = 9;
pub const N_RESULTS: usize = 10;

/// The whole words of a sample.
pub const NARROWED: usize = 0;
pub const COMPARED: usize = 1;
pub const CONVERTED: usize = 2;
pub const KEPT: usize = 3;
pub const SCALED: usize = 4;
pub const N_WORDS: usize = 5;

/// One input: two numbers, and a texel.
#[derive(Clone, Copy, Debug)]
pub struct Sample<F> {
    pub sort: Sort,
    pub a: F,
    pub b: F,
    /// An integer, any word, and a number with a power of two to multiply it with.
    pub texel: [u32; 4],
}

/// One output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleOutcome<F> {
    pub results: [F; N_RESULTS],
    pub words: [u32; N_WORDS],
}

/// All samples of a type.
pub fn samples<F: SampledFloat>() -> Vec<Sample<F>> {
    let mut random = SplitMix::new(1);
    let sorts = Sort::ALL.into_iter().flat_map(|sort| std::iter::repeat_n(sort, OF_EACH_SORT));
    sorts
        .map(|sort| {
            let [a, b] = F::operands(&mut random, sort);
            Sample { sort, a, b, texel: texel(&mut random) }
        })
        .collect()
}

/// Integers up to `2²⁴` either way, words that would be subnormals, NaNs or anything, subnormal and
/// normal numbers.
fn texel(random: &mut SplitMix) -> [u32; 4] {
    let bits = random.bits();
    let mantissa = (bits as u32) & 0x007f_ffff;
    let integer = match bits >> 60 {
        0 => 1 << 24,
        1 => -(1 << 24),
        _ => (bits >> 30) as i32 >> (7 + (bits >> 25) % 25),
    };
    let word = match (bits >> 58) & 3 {
        0 => mantissa,
        1 => 0x7f80_0000 | mantissa,
        2 => 0xff80_0000 | mantissa,
        _ => (bits >> 20) as u32,
    };
    let exponent = match (bits >> 56) & 1 {
        0 => 0,
        _ => 100 + (bits >> 40) as u32 % 50,
    };
    let factor = 127 + (bits >> 46) as u32 % 100;
    [integer as u32, word, exponent << 23 | mantissa, factor << 23]
}

/// A float type that the self-test can look at.
pub trait SampledFloat: Float + Pod + PartialOrd {
    /// WGSL's name of the type.
    const WGSL: &'static str;
    /// Two operands, none of them 0 but for [`Sort::Large`].
    fn operands(random: &mut SplitMix, sort: Sort) -> [Self; 2];
    /// The outcome of a sample by IEEE 754.
    fn expected(sample: &Sample<Self>) -> SampleOutcome<Self>;
    /// Distance in steps of the type.
    fn steps(a: Self, b: Self) -> u64;
    /// True if `found` is a neighbour of the exact sum or product on the side where that result
    /// lies, or the `nearest` number itself. `remainder` is the exact result less that.
    fn is_faithful(found: Self, nearest: Self, remainder: Self) -> bool;
    /// What an operand may count as: itself, and a subnormal as a 0 of either sign.
    fn readings(self) -> [Self; 3];
    fn is_normal(self) -> bool;
    /// True if remainders of a product of this magnitude are themselves in range.
    fn has_remainder(self) -> bool;
}

macro_rules! float {
    ($float:ident, $bits:ident, $mantissa:literal, $bias:literal, $steps:path) => {
        impl SampledFloat for $float {
            const WGSL: &'static str = stringify!($float);

            fn operands(random: &mut SplitMix, sort: Sort) -> [Self; 2] {
                let mut number = |low: i32, high: i32| {
                    let bits = random.bits();
                    let mantissa = bits as $bits & ((1 << $mantissa) - 1);
                    let span = (high - low + 1) as u64;
                    let exponent = (low + $bias + ((bits >> 53) % span) as i32) as $bits;
                    let magnitude = $float::from_bits(exponent << $mantissa | mantissa.max(1));
                    if random.bits() & 1 == 0 { magnitude } else { -magnitude }
                };
                match sort {
                    Sort::Near => [number(-10, 9), number(-10, 9)],
                    Sort::Wide => [number(WIDE[0], WIDE[1]), number(WIDE[0], WIDE[1])],
                    Sort::Tiny => {
                        // From the subnormals on, whose exponent is written as 0.
                        let a = match number(0, 1) > 0.0 {
                            true => number(-$bias, -$bias),
                            false => number(-$bias, 10 - $bias / 2),
                        };
                        let b = match number(0, 1) > 0.0 {
                            true => number(-$bias, 10 - $bias / 2),
                            false => number(-20, WIDE[1]),
                        };
                        [a, b]
                    }
                    Sort::Large => {
                        let mut one = || {
                            let bits = random.bits();
                            let magnitude = [
                                $float::MAX,
                                $float::MAX.next_down(),
                                $float::MAX / 2.0,
                                $float::INFINITY,
                                1.0,
                                0.0,
                            ][(bits >> 8) as usize % 6];
                            if bits & 1 == 0 { magnitude } else { -magnitude }
                        };
                        [one(), one()]
                    }
                }
            }

            fn expected(sample: &Sample<Self>) -> SampleOutcome<Self> {
                let &Sample { a, b, texel: [integer, word, number, factor], .. } = sample;
                let sum = a + b;
                let b_part = sum - a;
                let a_part = sum - b_part;
                let sum_error = (a - a_part) + (b - b_part);
                let product = a * b;
                let larger = if a < b { b } else { a };
                let (inverse, constant_over) = (1.0 / a, $float::from(NUMERATOR) / a);
                let (root, remainder) = (a.abs().sqrt(), a.mul_add(b, -product));
                let results = [
                    sum,
                    product,
                    a / b,
                    root,
                    inverse,
                    constant_over,
                    larger,
                    sum_error,
                    remainder,
                    product + b,
                ];
                let compared = [a < b, a <= b, a == b, a >= b, a > b];
                let compared = (0..).zip(compared).map(|(bit, holds)| u32::from(holds) << bit);
                let words = [
                    (a as f32).to_bits(),
                    compared.sum(),
                    (integer as i32 as f32).to_bits(),
                    word,
                    (f32::from_bits(number) * f32::from_bits(factor)).to_bits(),
                ];
                SampleOutcome { results, words }
            }

            fn steps(a: Self, b: Self) -> u64 {
                $steps(a, b)
            }

            fn is_faithful(found: Self, nearest: Self, remainder: Self) -> bool {
                found == nearest
                    || (remainder > 0.0 && found == nearest.next_up())
                    || (remainder < 0.0 && found == nearest.next_down())
            }

            fn readings(self) -> [Self; 3] {
                if self.is_subnormal() { [self, 0.0, -0.0] } else { [self; 3] }
            }

            fn is_normal(self) -> bool {
                $float::is_normal(self)
            }

            fn has_remainder(self) -> bool {
                self.abs() >= $float::MIN_POSITIVE * (2.0 as $float).powi($mantissa + 1)
            }
        }
    };
}
float!(f32, u32, 23, 127, ulp_distance);
float!(f64, u64, 52, 1023, steps_f64);

fn steps_f64(a: f64, b: f64) -> u64 {
    if a == b { 0 } else { a.to_bits().abs_diff(b.to_bits()) }
}
