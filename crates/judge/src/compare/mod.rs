//! The comparison of results: of rays with each other or with exact arithmetic, and of two pictures.
//!
//! A [`RayResult`] is what a result says of a ray. [`RayError`] is how it differs from what another result says of the same
//! ray; `t` and normals count where the ids agree. [`RayDifferences`] counts these errors as they come,
//! [`ErrorStats`] has their spread. [`Allowed`] says how much of it is still right.

mod allowed;
mod paint;
mod pictures;
mod rays;

pub(crate) use allowed::short;
pub use allowed::{Allowed, Tolerance, Unit};
pub(crate) use paint::between;
pub use paint::error_picture;
pub use pictures::{ChannelDifference, PictureDifference, PictureSide, compare_pictures};
pub use rays::{
    ErrorSpread, ErrorStats, NormalError, RayDifferences, RayError, RayResult, TError, compare,
};

/// A format of IEEE 754.
#[derive(Clone, Copy)]
pub(crate) enum Precision {
    Single,
    Double,
}

impl Precision {
    /// The distance of the format's numbers at `x`, and not less than its smallest subnormal.
    pub fn ulp(self, x: f64) -> f64 {
        let (epsilon, least) = match self {
            Precision::Single => (f32::EPSILON.into(), f32::from_bits(1).into()),
            Precision::Double => (f64::EPSILON, f64::from_bits(1)),
        };
        // The sign and the fraction taken away, it is a power of two; from infinity all is far.
        let power = f64::from_bits(x.to_bits() & f64::INFINITY.to_bits()).min(f64::MAX);
        (power * epsilon).max(least)
    }
}
