//! Bounds of light: what a light gives to a point, what an object makes of it, and the mean of some samples.

use super::Bounds;
use super::shadow::Occlusion;
use crate::num::fields::numbers;
use crate::num::{Real, V3};

/// Bounds of light, or of a colour.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightBounds<R> {
    /// Lower bounds.
    pub low: V3<R>,
    /// Upper bounds.
    pub high: V3<R>,
}

numbers! { LightBounds { low: vec, high: vec } }

impl<R: Real> LightBounds<R> {
    /// With what is given of a light of this weight.
    #[inline(always)]
    pub fn with(self, weight: V3<R>, given: Bounds<R>) -> LightBounds<R> {
        LightBounds { low: self.low + weight * given.low, high: self.high + weight * given.high }
    }

    /// What an object of this colour makes of it.
    #[inline(always)]
    pub fn on(self, color: V3<R>) -> LightBounds<R> {
        LightBounds { low: color.times(self.low), high: color.times(self.high) }
    }

    /// The sum of two.
    #[inline(always)]
    pub fn plus(self, other: LightBounds<R>) -> LightBounds<R> {
        LightBounds { low: self.low + other.low, high: self.high + other.high }
    }

    /// The mean of `n` samples whose sum this is, with what all roundings take: the factors `width`.
    #[inline(always)]
    pub fn mean(self, n: R, width: Bounds<R>) -> LightBounds<R> {
        LightBounds { low: self.low * width.low / n, high: self.high * width.high / n }
    }
}

impl<R: Real> Bounds<R> {
    /// What a light gives, where something may be in its way.
    #[inline(always)]
    pub fn behind(self, verdict: &Occlusion<R>) -> Bounds<R> {
        let zero = R::lit(0.0);
        Bounds {
            low: R::select(zero.lt(verdict.clear), self.low, zero),
            high: R::select(zero.lt(verdict.blocked), zero, self.high),
        }
    }
}
