//! A ray in numbers of any kind.

use super::fields::numbers;
use super::{Real, V3};

/// A ray `origin + t·direction`, with what formulas ask of its direction.
#[derive(Clone, Copy, Debug)]
pub struct Ray<R> {
    /// The ray's origin.
    pub origin: V3<R>,
    /// The ray's direction.
    pub direction: V3<R>,
    /// `d·d`
    pub a: R,
    /// `1/a`
    pub inv_a: R,
}

numbers! { Ray { origin: vec, direction: vec, a: num, inv_a: num } }

impl<R: Real> Ray<R> {
    /// A ray with its derived numbers.
    #[inline(always)]
    pub fn new(origin: V3<R>, direction: V3<R>) -> Ray<R> {
        let a = direction.dot(direction);
        Ray { origin, direction, a, inv_a: R::lit(1.0) / a }
    }
}
