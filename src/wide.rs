//! Numbers side by side: as many as one register of the processor holds, with the operations of
//! [`Real`](crate::vec3::Real). Each is one correctly rounded operation, so that what is calculated is
//! what plain numbers would give, bit by bit.

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::Simd;

use crate::vec3::{Number, Real};

/// Where something holds: for one number, or for each of several.
pub trait Holds: Copy {
    /// Where either holds.
    fn or(self, other: Self) -> Self;
}

impl Holds for bool {
    #[inline(always)]
    fn or(self, other: bool) -> bool {
        self | other
    }
}

/// One number, or several side by side, with steps that have no branches.
pub trait SideBySide: Number {
    /// One number.
    type Plain: Real;
    /// What comparisons give.
    type Mask: Holds;
    /// The same number in all places.
    fn like(self, number: Self::Plain) -> Self;
    /// `self < other`
    fn lt(self, other: Self) -> Self::Mask;
    /// `self ≤ other`
    fn le(self, other: Self) -> Self::Mask;
    /// `a` where the mask holds, `b` elsewhere.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// The smaller of two numbers.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.lt(self), other, self)
    }

    /// The larger of two numbers.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.lt(other), other, self)
    }
}

macro_rules! plain_lanes {
    ($float:ident) => {
        impl SideBySide for $float {
            type Plain = $float;
            type Mask = bool;
            #[inline(always)]
            fn like(self, number: $float) -> $float {
                number
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
            fn select(mask: bool, a: $float, b: $float) -> $float {
                if mask { a } else { b }
            }
        }
    };
}
plain_lanes!(f32);
plain_lanes!(f64);

macro_rules! wide {
    (
        $Wide:ident, $Mask:ident, $float:ident, $floats:ident, $masks:ident,
        $splat:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $neg:ident,
        $less:ident, $less_or_equal:ident, $or:ident,
        $select:ident
    ) => {
        #[doc = concat!("A register of ", stringify!($float), ".")]
        #[derive(Clone, Copy)]
        pub struct $Wide<S: Simd> {
            simd: S,
            lanes: S::$floats,
        }

        /// What holds for which of the numbers.
        #[derive(Clone, Copy)]
        pub struct $Mask<S: Simd> {
            simd: S,
            lanes: S::$masks,
        }

        #[allow(dead_code, reason = "both sorts have the same operations")]
        impl<S: Simd> $Wide<S> {
            /// How many numbers there are.
            pub const LANES: usize = size_of::<S::$floats>() / size_of::<$float>();

            /// The same number in all places.
            #[inline(always)]
            pub fn splat(simd: S, number: $float) -> Self {
                $Wide { simd, lanes: simd.$splat(number) }
            }

            /// The first numbers of a slice, which has at least as many.
            #[inline(always)]
            pub fn load(simd: S, numbers: &[$float]) -> Self {
                let lanes =
                    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&numbers[..Self::LANES]));
                $Wide { simd, lanes }
            }

            /// Puts them into the first places of a slice.
            #[inline(always)]
            pub fn store(self, numbers: &mut [$float]) {
                let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut numbers[..Self::LANES]);
                bytes.copy_from_slice(bytemuck::bytes_of(&self.lanes));
            }
        }

        impl<S: Simd> SideBySide for $Wide<S> {
            type Plain = $float;
            type Mask = $Mask<S>;
            #[inline(always)]
            fn like(self, number: $float) -> Self {
                $Wide::splat(self.simd, number)
            }

            #[inline(always)]
            fn lt(self, other: Self) -> $Mask<S> {
                let simd = self.simd;
                $Mask { simd, lanes: simd.$less(self.lanes, other.lanes) }
            }

            #[inline(always)]
            fn le(self, other: Self) -> $Mask<S> {
                let simd = self.simd;
                $Mask { simd, lanes: simd.$less_or_equal(self.lanes, other.lanes) }
            }

            #[inline(always)]
            fn select(mask: $Mask<S>, a: Self, b: Self) -> Self {
                mask.select(a, b)
            }
        }

        #[allow(dead_code, reason = "both sorts have the same operations")]
        impl<S: Simd> $Mask<S> {
            /// `a` where it holds, `b` elsewhere.
            #[inline(always)]
            pub fn select(self, a: $Wide<S>, b: $Wide<S>) -> $Wide<S> {
                let lanes = self.simd.$select(self.lanes, a.lanes, b.lanes);
                $Wide { simd: self.simd, lanes }
            }

            /// A bit for each place, the lowest for the first one.
            #[inline(always)]
            pub fn bits(self) -> u32 {
                let bytes = bytemuck::bytes_of(&self.lanes);
                let n_bytes = size_of::<S::$masks>() / $Wide::<S>::LANES;
                match n_bytes {
                    // One bit a place. Read byte by byte, they would wait for the store.
                    0 => match *bytes {
                        [byte] => u32::from(byte),
                        [low, high] => u32::from(u16::from_le_bytes([low, high])),
                        _ => bytes.iter().rev().fold(0, |bits, &byte| bits << 8 | u32::from(byte)),
                    },
                    _ => {
                        let set = |bits, byte: &u8| bits << 1 | u32::from(*byte != 0);
                        bytes.iter().step_by(n_bytes).rev().fold(0, set)
                    }
                }
            }

            /// True where it holds somewhere.
            #[inline(always)]
            pub fn any(self) -> bool {
                bytemuck::bytes_of(&self.lanes).iter().fold(0, |any, byte| any | byte) != 0
            }
        }

        impl<S: Simd> Holds for $Mask<S> {
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                $Mask { lanes: self.simd.$or(self.lanes, other.lanes), ..self }
            }
        }

        impl<S: Simd> Add for $Wide<S> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                $Wide { lanes: self.simd.$add(self.lanes, other.lanes), ..self }
            }
        }

        impl<S: Simd> Sub for $Wide<S> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                $Wide { lanes: self.simd.$sub(self.lanes, other.lanes), ..self }
            }
        }

        impl<S: Simd> Mul for $Wide<S> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                $Wide { lanes: self.simd.$mul(self.lanes, other.lanes), ..self }
            }
        }

        impl<S: Simd> Div for $Wide<S> {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                $Wide { lanes: self.simd.$div(self.lanes, other.lanes), ..self }
            }
        }

        impl<S: Simd> Neg for $Wide<S> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                $Wide { lanes: self.simd.$neg(self.lanes), ..self }
            }
        }

        impl<S: Simd> Number for $Wide<S> {}
    };
}

wide!(
    WideF32,
    MaskF32,
    f32,
    f32s,
    m32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    div_f32s,
    neg_f32s,
    less_than_f32s,
    less_than_or_equal_f32s,
    or_m32s,
    select_f32s
);
wide!(
    WideF64,
    MaskF64,
    f64,
    f64s,
    m64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    div_f64s,
    neg_f64s,
    less_than_f64s,
    less_than_or_equal_f64s,
    or_m64s,
    select_f64s
);

#[cfg(test)]
mod tests {
    use pulp::WithSimd;

    use super::*;

    /// Each operation for numbers of all sorts, against the plain one.
    struct Operations;

    impl pulp::WithSimd for Operations {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let some = [0.0, -0.0, 1.0, -1.5, 1e-40, f32::MAX, f32::INFINITY, 0.1];
            let n = WideF32::<S>::LANES;
            for shift in 0..some.len() {
                let a: Vec<f32> = (0..n).map(|lane| some[lane % some.len()]).collect();
                let b: Vec<f32> = (0..n).map(|lane| some[(lane + shift) % some.len()]).collect();
                let (x, y) = (WideF32::load(simd, &a), WideF32::load(simd, &b));
                let check = |wide: WideF32<S>, plain: fn(f32, f32) -> f32| {
                    let mut found = vec![0.0; n];
                    wide.store(&mut found);
                    for lane in 0..n {
                        let expected = plain(a[lane], b[lane]);
                        let is_same = found[lane].to_bits() == expected.to_bits();
                        assert!(is_same || expected.is_nan(), "{} {}", a[lane], b[lane]);
                    }
                };
                check(x + y, |a, b| a + b);
                check(x - y, |a, b| a - b);
                check(x * y, |a, b| a * b);
                check(x / y, |a, b| a / b);
                check(-x, |a, _| -a);
                check(x.max(y), crate::vec3::Real::max);
                check(x.min(y), crate::vec3::Real::min);
                check(x.lt(y).select(x, y), |a, b| if a < b { a } else { b });
                for (mask, holds) in [
                    (x.lt(y), (|a, b| a < b) as fn(f32, f32) -> bool),
                    (x.le(y), |a, b| a <= b),
                    (x.lt(y).or(y.lt(x)), |a, b| a != b),
                ] {
                    let bit = |lane: usize| u32::from(holds(a[lane], b[lane])) << lane;
                    let expected = (0..n).fold(0, |bits, lane| bits | bit(lane));
                    assert_eq!((mask.bits(), mask.any()), (expected, expected != 0));
                }
            }
        }
    }

    #[test]
    fn what_is_side_by_side_is_what_is_alone() {
        pulp::Arch::new().dispatch(Operations);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            Simd::vectorize(simd, Operations);
        }
        Operations.with_simd(pulp::Scalar);
    }
}
