//! Rays with exact numbers.

use super::number::{Real, integer, product3, real, real3};
use crate::camera::Pixels;
use crate::trace::Ray;

/// A ray in exact numbers: `o + t·d`, kept as the multiple `H·d` of its direction for which all
/// numbers are dyadic.
///
/// A root `τ` for the direction `H·d` is the root `t = H·τ` for `d`; [`super::Root`] carries the
/// factor. A ray with a number that is not finite gets a zero direction and hits nothing.
#[derive(Clone, Debug)]
pub struct ExactRay {
    origin: [Real; 3],
    direction: [Real; 3],
    norm_squared: Real,
    t_factor: u32,
}

fn zero3() -> [Real; 3] {
    std::array::from_fn(|_| Real::zero())
}

impl ExactRay {
    /// A ray as it stands: `H = 1`.
    pub fn new(ray: &Ray) -> ExactRay {
        match (real3(ray.origin), real3(ray.direction)) {
            (Some(origin), Some(direction)) => ExactRay::from_parts(origin, direction, 1),
            _ => ExactRay::from_parts(zero3(), zero3(), 1),
        }
    }

    /// The centre ray of pixel `(x, y)` of the picture. [`ExactPixels`] saves work where there
    /// are many.
    pub fn from_pixel(pixels: &Pixels, x: u32, y: u32) -> ExactRay {
        ExactPixels::new(pixels).ray(x, y)
    }

    fn from_parts(origin: [Real; 3], direction: [Real; 3], t_factor: u32) -> ExactRay {
        ExactRay { norm_squared: product3(&direction, &direction), origin, direction, t_factor }
    }

    /// `o`.
    pub fn origin(&self) -> &[Real; 3] {
        &self.origin
    }

    /// `H·d`.
    pub fn direction(&self) -> &[Real; 3] {
        &self.direction
    }

    /// `‖H·d‖²`.
    pub fn norm_squared(&self) -> &Real {
        &self.norm_squared
    }

    /// `H`: the picture's height for a pixel's ray, else 1.
    pub fn t_factor(&self) -> u32 {
        self.t_factor
    }
}

/// The exact centre rays of a picture's pixels.
///
/// Contract §1: `d = forward + (2(x+½)/W − 1)·h·(W/H)·right + (1 − 2(y+½)/H)·h·true_up`. With
/// `(2(x+½)/W − 1)·(W/H) = (2x+1−W)/H = i/H` and `1 − 2(y+½)/H = (H−2y−1)/H = j/H`
/// (`(i, j)` as [`Pixels::offset2`] gives them), `H·d = H·forward + i·h·right + j·h·true_up` is
/// dyadic, though `d` itself is not.
#[derive(Clone, Debug)]
pub struct ExactPixels {
    pixels: Pixels,
    origin: [Real; 3],
    forward: [Real; 3],
    right: [Real; 3],
    up: [Real; 3],
    finite: bool,
}

impl ExactPixels {
    /// The camera of `pixels` in exact numbers.
    pub fn new(pixels: &Pixels) -> ExactPixels {
        let view = &pixels.view;
        let height = integer(i64::from(pixels.image_height));
        let parts = || {
            let h = real(view.h)?;
            Some((
                real3(view.position)?,
                real3(view.forward)?.map(|f| f * &height),
                real3(view.right)?.map(|r| r * &h),
                real3(view.true_up)?.map(|u| u * &h),
            ))
        };
        let found = parts();
        let finite = found.is_some() && pixels.image_height > 0;
        let (origin, forward, right, up) =
            found.unwrap_or_else(|| (zero3(), zero3(), zero3(), zero3()));
        ExactPixels { pixels: *pixels, origin, forward, right, up, finite }
    }

    /// The centre ray of pixel `(x, y)` of the picture.
    pub fn ray(&self, x: u32, y: u32) -> ExactRay {
        if !self.finite {
            return ExactRay::from_parts(zero3(), zero3(), 1);
        }
        let (i, j) = self.pixels.offset2(x, y);
        let (i, j) = (integer(i), integer(j));
        let direction = std::array::from_fn(|axis| {
            &self.forward[axis] + &self.right[axis] * &i + &self.up[axis] * &j
        });
        ExactRay::from_parts(self.origin.clone(), direction, self.pixels.image_height)
    }
}
