//! Numbers that a formula can be written in: one by one, or side by side in lanes.
//!
//! A [`Real`] has masks and no order, so that a formula cannot say `if`, which lanes could not follow. So one text
//! serves f32, f64 and lanes of both, with the same operations in the same order: what is calculated side by side is what
//! is calculated alone, bit by bit.

pub mod fields;
mod lanes;
mod ray;
mod scaled;
pub(crate) mod typical;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use bytemuck::Zeroable;
use glam::DVec3;

pub use lanes::{LaneBits, Lanes, dispatch, one_by_one};
pub use ray::Ray;
pub use scaled::{ScaledInteger, exponent_of, power_of_two};

/// The id of a ray that bounds leave open.
pub const UNDECIDED: u32 = u32::MAX;

/// Number of f32 values from one to the other; equal values are 0 apart, and so are ±0.
pub fn ulp_distance(a: f32, b: f32) -> u64 {
    if a.is_nan() || b.is_nan() {
        return u64::from(a.to_bits() != b.to_bits()) * u64::MAX;
    }
    let ordered = |x: f32| {
        let magnitude = i64::from(x.to_bits() & 0x7fff_ffff);
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    ordered(a).abs_diff(ordered(b))
}

/// The number so many steps away in the order of all f32, where `−0` comes before `0`. No branch, which would be mispredicted.
#[inline(always)]
fn stepped(x: f32, steps: i32) -> f32 {
    // A function and its inverse: of negative numbers the larger bits are the smaller number.
    let ordered = |bits: i32| bits ^ ((bits >> 31).cast_unsigned() >> 1).cast_signed();
    let place = ordered(x.to_bits().cast_signed()) + steps;
    f32::from_bits(ordered(place).cast_unsigned())
}

/// The largest f32 not above `x`.
#[inline(always)]
pub fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    stepped(nearest, -i32::from(f64::from(nearest) > x))
}

/// The smallest f32 not below `x`.
#[inline(always)]
pub fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    stepped(nearest, i32::from(f64::from(nearest) < x))
}

/// What a comparison of [`Real`] numbers gives: a truth, or one a lane. `&`, `|` and `!` look at every lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// False where surely no lane is true. For early exits alone: no result may depend on it.
    fn any(self) -> bool;
}

/// A number that formulas are written in. `+ - * /` and `sqrt` round once; nothing is fused.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// What records hold, the same for all lanes.
    type One: Float;
    /// What comparisons give.
    type Mask: Mask;
    /// An id, or one a lane.
    type Id: Copy;

    /// `x` in all lanes.
    fn splat(x: Self::One) -> Self;
    /// `id` in all lanes.
    fn splat_id(id: u32) -> Self::Id;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// `self < other`
    fn lt(self, other: Self) -> Self::Mask;
    /// `self ≤ other`
    fn le(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The id `yes` where the mask holds, `no` elsewhere.
    fn select_id(mask: Self::Mask, yes: Self::Id, no: Self::Id) -> Self::Id;

    /// A constant: the nearest number.
    #[inline(always)]
    fn lit(x: f64) -> Self {
        Self::splat(Self::One::near(x))
    }

    /// The larger of two numbers; `self` where one is none.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.lt(other), other, self)
    }

    /// The smaller of two numbers; `self` where one is none.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.lt(self), other, self)
    }
}

/// A number of the machine.
pub trait Float: Real<One = Self, Mask = bool, Id = u32> + Default + Send + Sync + 'static {
    /// As wide as the number: a lane of a mask, or an id.
    type Bits: Bits;
    /// Relative error of a faithful rounding (either neighbour), the worst of all devices.
    const UNIT: f64;
    /// Distances and radii up to this keep formulas in range,
    const FARTHEST: f64;
    /// and radii down to this.
    const SMALLEST: f64;
    /// More than what a dozen operations lose below the normal numbers.
    const TINY: f64;
    /// [`Float::near_or_least`] makes no number but 0 smaller. 0 where all numbers are what they are.
    const LEAST: f64;
    /// Beyond every `t` that is looked at, and no infinity: devices may assume that there is none.
    const BEYOND: f64;
    /// Points are known that are off by less. As an error is at least 3 units of the way `t·d`
    /// ([`POINT`](crate::bounds::steps::POINT)), such a point is less than `1.4 + 1` times [`Float::FARTHEST`] from the reference
    /// point: squares of its distances stay in range, and it is closer to every object than what stands for "anywhere".
    const KNOWN: f64;
    /// What a number that comes from f64 is off by, in units.
    const ROUNDED: f64;
    /// Numbers up to this and above its inverse have squares in range, and these inverses. No test sees it halved: the range may
    /// be smaller.
    const LARGEST_ROOT: f64;
    /// The largest number. No bound.
    const LARGEST: f64;
    /// An error that leaves all open that lies within [`Float::FARTHEST`], with a square in range. No test sees it halved: half of
    /// it is still twice the range.
    const UNKNOWN: f64;

    /// The nearest number.
    fn near(x: f64) -> Self;
    /// The nearest number, but for what is smaller than [`Float::LEAST`] and not 0: that becomes as large. So only a 0 becomes 0.
    #[inline(always)]
    fn near_or_least(x: f64) -> Self {
        let is_lost = x != 0.0 && x.abs() < Self::LEAST;
        Self::near(if is_lost { Self::LEAST.copysign(x) } else { x })
    }
    /// The largest number not above.
    fn down(x: f64) -> Self;
    /// The smallest number not below.
    fn up(x: f64) -> Self;
    /// The number itself.
    fn to_f64(self) -> f64;
}

/// A lane of a mask, all bits or none, or an id.
pub trait Bits:
    Copy
    + PartialEq
    + Default
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + Not<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// All bits, or none.
    fn from_bool(holds: bool) -> Self;
    /// An id.
    fn from_id(id: u32) -> Self;
    /// The id.
    fn to_id(self) -> u32;
}

/// A power of two; 0 for −1023.
const fn two_to(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

macro_rules! machine_number {
    ($float:ident, $bits:ident, $down:expr, $up:expr, $($name:ident: $exponent:literal),*) => {
        impl Bits for $bits {
            #[inline(always)]
            fn from_bool(holds: bool) -> $bits {
                $bits::from(holds).wrapping_neg()
            }

            #[inline(always)]
            fn from_id(id: u32) -> $bits {
                id.into()
            }

            #[inline(always)]
            fn to_id(self) -> u32 {
                self as u32
            }
        }

        impl Real for $float {
            type One = $float;
            type Mask = bool;
            type Id = u32;

            #[inline(always)]
            fn splat(x: $float) -> $float {
                x
            }

            #[inline(always)]
            fn splat_id(id: u32) -> u32 {
                id
            }

            #[inline(always)]
            fn sqrt(self) -> $float {
                $float::sqrt(self)
            }

            #[inline(always)]
            fn abs(self) -> $float {
                $float::abs(self)
            }

            #[inline(always)]
            fn lt(self, other: $float) -> bool {
                self < other
            }

            #[inline(always)]
            fn le(self, other: $float) -> bool {
                self <= other
            }

            #[inline(always)]
            fn select(mask: bool, yes: $float, no: $float) -> $float {
                if mask { yes } else { no }
            }

            #[inline(always)]
            fn select_id(mask: bool, yes: u32, no: u32) -> u32 {
                if mask { yes } else { no }
            }
        }

        impl Float for $float {
            type Bits = $bits;
            $(const $name: f64 = two_to($exponent);)*
            const LARGEST: f64 = $float::MAX as f64;

            #[inline(always)]
            fn near(x: f64) -> $float {
                x as $float
            }

            #[inline(always)]
            fn down(x: f64) -> $float {
                $down(x)
            }

            #[inline(always)]
            fn up(x: f64) -> $float {
                $up(x)
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                self.into()
            }
        }
    };
}

machine_number!(f32, u32, round_down, round_up, UNIT: -23,
    FARTHEST: 60, SMALLEST: -40, TINY: -90, LEAST: -100, BEYOND: 100, KNOWN: 39, ROUNDED: -1, LARGEST_ROOT: 50, UNKNOWN: 62);
machine_number!(f64, u64, std::convert::identity, std::convert::identity, UNIT: -52,
    FARTHEST: 240, SMALLEST: -160, TINY: -720, LEAST: -1023, BEYOND: 400, KNOWN: 190, ROUNDED: -1023, LARGEST_ROOT: 200,
    UNKNOWN: 242);

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

/// Three numbers. Operations know where they are written: who prints a formula takes names from there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Zeroable)]
pub struct V3<R>(pub [R; 3]);

impl<R> V3<R> {
    /// These numbers, each made into another one.
    #[inline(always)]
    #[track_caller]
    pub fn map<Q>(self, of: impl Fn(R) -> Q) -> V3<Q> {
        let V3([x, y, z]) = self;
        V3([of(x), of(y), of(z)])
    }
}

impl<R: Real> V3<R> {
    /// One vector in all lanes.
    #[inline(always)]
    #[track_caller]
    pub fn splat(v: V3<R::One>) -> V3<R> {
        v.map(R::splat)
    }

    /// The nearest vector, in all lanes.
    #[inline(always)]
    #[track_caller]
    pub fn lit(v: DVec3) -> V3<R> {
        V3([R::lit(v.x), R::lit(v.y), R::lit(v.z)])
    }

    /// `yes` where the mask holds, `no` elsewhere.
    #[inline(always)]
    #[track_caller]
    pub fn select(mask: R::Mask, yes: V3<R>, no: V3<R>) -> V3<R> {
        let (V3([a, b, c]), V3([x, y, z])) = (yes, no);
        V3([R::select(mask, a, x), R::select(mask, b, y), R::select(mask, c, z)])
    }

    /// Absolute values.
    #[inline(always)]
    #[track_caller]
    pub fn abs(self) -> V3<R> {
        let V3([a, b, c]) = self;
        V3([a.abs(), b.abs(), c.abs()])
    }

    /// The smaller numbers of two vectors.
    #[inline(always)]
    #[track_caller]
    pub fn min(self, other: V3<R>) -> V3<R> {
        let (V3([a, b, c]), V3([x, y, z])) = (self, other);
        V3([a.min(x), b.min(y), c.min(z)])
    }

    /// The larger numbers of two vectors.
    #[inline(always)]
    #[track_caller]
    pub fn max(self, other: V3<R>) -> V3<R> {
        let (V3([a, b, c]), V3([x, y, z])) = (self, other);
        V3([a.max(x), b.max(y), c.max(z)])
    }

    /// Component by component, as a colour with light.
    #[inline(always)]
    #[track_caller]
    pub fn times(self, other: V3<R>) -> V3<R> {
        let (V3([a, b, c]), V3([x, y, z])) = (self, other);
        V3([a * x, b * y, c * z])
    }

    /// `(x + y) + z`: the order of rounding is part of the formula.
    #[inline(always)]
    #[track_caller]
    pub fn dot(self, other: V3<R>) -> R {
        let (V3([a, b, c]), V3([x, y, z])) = (self, other);
        (a * x + b * y) + c * z
    }
}

impl<R: Real> Add for V3<R> {
    type Output = V3<R>;
    #[inline(always)]
    #[track_caller]
    fn add(self, other: V3<R>) -> V3<R> {
        let (V3([a, b, c]), V3([x, y, z])) = (self, other);
        V3([a + x, b + y, c + z])
    }
}

impl<R: Real> Neg for V3<R> {
    type Output = V3<R>;
    #[inline(always)]
    #[track_caller]
    fn neg(self) -> V3<R> {
        let V3([a, b, c]) = self;
        V3([-a, -b, -c])
    }
}

impl<R: Real> Sub for V3<R> {
    type Output = V3<R>;
    #[inline(always)]
    #[track_caller]
    fn sub(self, other: V3<R>) -> V3<R> {
        let (V3([a, b, c]), V3([x, y, z])) = (self, other);
        V3([a - x, b - y, c - z])
    }
}

impl<R: Real> Mul<R> for V3<R> {
    type Output = V3<R>;
    #[inline(always)]
    #[track_caller]
    fn mul(self, scale: R) -> V3<R> {
        let V3([a, b, c]) = self;
        V3([a * scale, b * scale, c * scale])
    }
}

impl<R: Real> Div<R> for V3<R> {
    type Output = V3<R>;
    #[inline(always)]
    #[track_caller]
    fn div(self, divisor: R) -> V3<R> {
        let V3([a, b, c]) = self;
        V3([a / divisor, b / divisor, c / divisor])
    }
}

/// A bound of a vector's length, a few roundings above it; `v·v` may underflow.
#[inline(always)]
pub fn length_bound(v: DVec3) -> f64 {
    length_bounds(V3(v.to_array()))
}

/// [`length_bound`] of vectors side by side.
#[inline(always)]
pub(crate) fn length_bounds<R: Real<One = f64>>(v: V3<R>) -> R {
    let [x, y, z] = v.0;
    let largest = x.abs().max(y.abs()).max(z.abs());
    // Halving the 16 is not covered by a test: 2 would do.
    let length = v.dot(v).sqrt() * R::lit(1.0 + 16.0 * f64::UNIT);
    let is_tiny = largest.lt(R::lit(1.0 / LARGEST_F64));
    R::select(is_tiny, R::lit(1.8) * largest, length)
}

/// Below the inverse of this, the square of a vector may underflow in f64. Halving it is not covered by a test: the range may be
/// smaller.
const LARGEST_F64: f64 = (1u128 << 120) as f64 * (1u128 << 120) as f64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::random::SplitMix;

    #[test]
    fn the_nearest_numbers_on_both_sides() {
        let mut random = SplitMix::new(1126);
        let edges = [0.0, 1e-300, 1e-46, 1e-45, 1e-38, 1.0, f32::MAX.into(), 1e39, f64::INFINITY];
        let any = (0..100_000).map(|_| f64::from_bits(random.bits())).filter(|x| !x.is_nan());
        let words = any.flat_map(|x| [x, f64::from(x as f32)]);
        for x in edges.into_iter().chain(words).flat_map(|x| [x, -x]) {
            let [low, high] = [round_down(x), round_up(x)].map(f64::from);
            assert!(low <= x && x <= high, "{x:e}: {low:e} {high:e}");
            let within = [(low as f32).next_up(), (high as f32).next_down()].map(f64::from);
            let is_end = x.is_infinite();
            assert!(is_end || within[0] > x && within[1] < x, "{x:e}: {low:e} {high:e}");
        }
        assert!(round_down(f64::NAN).is_nan() && round_up(f64::NAN).is_nan());
    }
}
