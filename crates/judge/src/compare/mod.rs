//! The comparison of results: of rays with each other or with exact arithmetic, and of two pictures.
//!
//! A [`RayResult`] is the result of a ray: id, `t` and normal. A [`RayError`] is its difference from another result of the same
//! ray; `t` and normals count where the ids agree. [`RayDifferences`] counts these errors as they come,
//! [`ErrorStats`] has their spread. [`Allowed`] has the limits of allowed errors.
//!
//! A [`HitComparison`] compares the results of another renderer with exact arithmetic, and finds the [`Transform`]s that explain
//! the errors. [`compare_pictures`] compares two pictures channel by channel.

mod allowed;
mod claims;
mod exact;
mod hits;
mod objects;
mod paint;
mod pictures;
mod rays;
mod search;
mod transform;
mod window;
mod words;

pub(crate) use allowed::short;
pub use allowed::{Allowed, AllowedKey, LimitUnit, Tolerance};
pub use claims::{Claims, Quantity, quantities_of};
pub use exact::{ColorKind, ExactChannels, camera_of, exact_picture, has_camera, samples_of};
pub use hits::{HitComparison, HitDifference, HitErrors, HitSummary};
pub use objects::ObjectErrors;
pub(crate) use paint::between;
pub use paint::error_picture;
pub use pictures::{
    ChannelDifference, PictureDifference, PictureSide, compare_pictures, explain_pictures,
};
pub use rays::{
    ErrorSpread, ErrorStats, NormalError, RayDifferences, RayError, RayResult, TError, compare,
};
pub use search::TransformMatch;
pub use transform::{TRANSFORMS, Transform};
pub use window::{pixels_of, whole_size};
pub use words::Finding;

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

#[cfg(test)]
mod tests;
