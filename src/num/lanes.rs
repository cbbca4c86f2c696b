//! Numbers side by side in a plain array, which the compiler puts into registers.
//!
//! Loops over lanes alone: `map` of an array and closures become calls, and go through memory.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use pulp::WithSimd;

use super::{Bits, Float, Mask, Real};

/// A loop over the first lanes, at least one. It is tested at its end: those that are tested at their beginning the compiler
/// turns around, which for the thousands of them that are in a loop over packs takes it a seventh of its time.
macro_rules! each_lane {
    ($n:expr, |$lane:ident| $work:expr) => {{
        let mut $lane = 0;
        loop {
            $work;
            $lane += 1;
            if $lane == $n {
                break;
            }
        }
    }};
}

/// `N` numbers, one a lane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Lanes<F, const N: usize>(pub [F; N]);

/// A mask, or ids, of numbers of `F`: as wide as these.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct LaneBits<F: Float, const N: usize>(pub [F::Bits; N]);

impl<F: Float, const N: usize> Default for Lanes<F, N> {
    #[inline(always)]
    fn default() -> Self {
        Lanes([F::default(); N])
    }
}

impl<F: Float, const N: usize> Lanes<F, N> {
    /// The first `N` of some numbers.
    #[inline(always)]
    pub fn load(numbers: &[F]) -> Self {
        let mut lanes = [F::default(); N];
        lanes.copy_from_slice(&numbers[..N]);
        Lanes(lanes)
    }

    /// Joins the numbers of all lanes, by halves. `N` is a power of two.
    #[inline(always)]
    pub fn joined(mut self, join: impl Fn(F, F) -> F) -> F {
        let mut n = N;
        while n > 1 {
            n /= 2;
            each_lane!(n, |lane| self.0[lane] = join(self.0[lane], self.0[lane + n]));
        }
        self.0[0]
    }

    /// A number for each of these.
    #[inline(always)]
    pub fn each<G: Float>(self, of: impl Fn(F) -> G) -> Lanes<G, N> {
        let mut lanes = Lanes::default();
        each_lane!(N, |lane| lanes.0[lane] = of(self.0[lane]));
        lanes
    }
}

/// Packs of lanes one after another: else the compiler would put the same lane of several packs into a register, where the
/// lanes of one belong.
#[inline(always)]
pub fn one_by_one<I: IntoIterator>(packs: I) -> impl Iterator<Item = I::Item> {
    packs.into_iter().map(std::hint::black_box)
}

/// Runs loops over lanes, compiled for each instruction set that the processor may have. What it runs is compiled once, not for
/// each caller and each type that a caller is generic over.
///
/// The library's own tests have one of them: the bits are the same, and what is tested through the library has all.
#[inline(never)]
pub fn dispatch<W: WithSimd>(work: W) -> W::Output {
    #[cfg(test)]
    return work.with_simd(pulp::Scalar::new());
    #[cfg(not(test))]
    pulp::Arch::new().dispatch(work)
}

macro_rules! lane_by_lane {
    ($lanes:ident: $($trait:ident $function:ident $sign:tt),*) => {$(
        impl<F: Float, const N: usize> $trait for $lanes<F, N> {
            type Output = Self;
            #[inline(always)]
            fn $function(mut self, other: Self) -> Self {
                each_lane!(N, |lane| self.0[lane] = self.0[lane] $sign other.0[lane]);
                self
            }
        }
    )*};
}

lane_by_lane!(Lanes: Add add +, Sub sub -, Mul mul *, Div div /);
lane_by_lane!(LaneBits: BitAnd bitand &, BitOr bitor |);

impl<F: Float, const N: usize> Neg for Lanes<F, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        each_lane!(N, |lane| self.0[lane] = -self.0[lane]);
        self
    }
}

macro_rules! compare {
    ($($function:ident),*) => {$(
        #[inline(always)]
        fn $function(self, other: Self) -> LaneBits<F, N> {
            let mut mask = LaneBits([F::Bits::default(); N]);
            each_lane!(N, |lane| mask.0[lane] = F::Bits::from_bool(self.0[lane].$function(other.0[lane])));
            mask
        }
    )*};
}

impl<F: Float, const N: usize> Real for Lanes<F, N> {
    type One = F;
    type Mask = LaneBits<F, N>;
    type Id = LaneBits<F, N>;

    #[inline(always)]
    fn splat(x: F) -> Self {
        Lanes([x; N])
    }

    #[inline(always)]
    fn splat_id(id: u32) -> LaneBits<F, N> {
        LaneBits([F::Bits::from_id(id); N])
    }

    #[inline(always)]
    fn sqrt(mut self) -> Self {
        each_lane!(N, |lane| self.0[lane] = self.0[lane].sqrt());
        self
    }

    #[inline(always)]
    fn abs(mut self) -> Self {
        each_lane!(N, |lane| self.0[lane] = self.0[lane].abs());
        self
    }

    compare!(lt, le);

    #[inline(always)]
    fn select(mask: LaneBits<F, N>, yes: Self, mut no: Self) -> Self {
        each_lane!(N, |lane| {
            let holds = mask.0[lane] != F::Bits::default();
            no.0[lane] = if holds { yes.0[lane] } else { no.0[lane] };
        });
        no
    }

    #[inline(always)]
    fn select_id(
        mask: LaneBits<F, N>,
        yes: LaneBits<F, N>,
        mut no: LaneBits<F, N>,
    ) -> LaneBits<F, N> {
        each_lane!(N, |lane| {
            let holds = mask.0[lane] != F::Bits::default();
            no.0[lane] = if holds { yes.0[lane] } else { no.0[lane] };
        });
        no
    }
}

impl<F: Float, const N: usize> Not for LaneBits<F, N> {
    type Output = Self;
    #[inline(always)]
    fn not(mut self) -> Self {
        each_lane!(N, |lane| self.0[lane] = !self.0[lane]);
        self
    }
}

impl<F: Float, const N: usize> Mask for LaneBits<F, N> {
    #[inline(always)]
    fn any(self) -> bool {
        let mut any = F::Bits::default();
        each_lane!(N, |lane| any = any | self.0[lane]);
        any != F::Bits::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::random::SplitMix;

    #[test]
    fn lanes_are_numbers_side_by_side() {
        let mut random = SplitMix::new(1);
        let mut numbers = || -> [f32; 16] {
            std::array::from_fn(|_| {
                (random.unit() - 0.5) as f32 * 2f32.powi((random.bits() % 9) as i32)
            })
        };
        for _ in 0..1000 {
            let [a, b, c] = [numbers(), numbers(), numbers()];
            let some = Lanes(a) * Lanes(b) - Lanes(c).abs().sqrt() / -Lanes(b);
            let mask = (Lanes(a).lt(Lanes(b)) & !Lanes(c).le(Lanes(b))) | Lanes(a).lt(Lanes(c));
            let found = Lanes::select(mask, some.max(Lanes(a)), Lanes(c).min(Lanes(b)) + Lanes(a));
            for lane in 0..16 {
                let (a, b, c) = (a[lane], b[lane], c[lane]);
                let some = a * b - c.abs().sqrt() / -b;
                let holds = a < b && c > b || a < c;
                let expected = if holds { Real::max(some, a) } else { Real::min(c, b) + a };
                assert_eq!(found.0[lane].to_bits(), expected.to_bits());
            }
        }
    }
}
