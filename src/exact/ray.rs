//! Rays with exact numbers.

use glam::DVec3;

use super::number::{Dyadic, integer, product3, real, real3};
use crate::rays::{Lens, Pixels, Rays, WorldRay};

/// A ray in exact numbers: `o + t·d`, kept as the multiples `S·o` of its origin and `F·d` of its
/// direction for which all numbers are dyadic. It then stands in a world that is `S` times as
/// large.
///
/// A root `τ` for these is the root `t = (F/S)·τ`; [`super::QuadraticSurd`] carries the factor. A ray with a
/// number that is not finite gets a zero direction and hits nothing.
#[derive(Clone, Debug)]
pub struct ExactRay {
    origin: [Dyadic; 3],
    direction: [Dyadic; 3],
    norm_squared: Dyadic,
    world_scale: u32,
    direction_scale: u32,
}

impl ExactRay {
    /// A ray as it stands: `S = F = 1`.
    pub fn new(ray: &WorldRay) -> ExactRay {
        match (real3(ray.origin), real3(ray.direction)) {
            (Some(origin), Some(direction)) => ExactRay::from_parts(origin, direction, 1, 1),
            _ => ExactRay::nowhere(),
        }
    }

    /// A ray that hits nothing.
    fn nowhere() -> ExactRay {
        let zero = || std::array::from_fn(|_| Dyadic::zero());
        ExactRay::from_parts(zero(), zero(), 1, 1)
    }

    /// `direction_scale` is a multiple of `world_scale`.
    fn from_parts(
        origin: [Dyadic; 3],
        direction: [Dyadic; 3],
        world_scale: u32,
        direction_scale: u32,
    ) -> ExactRay {
        let norm_squared = product3(&direction, &direction);
        ExactRay { origin, direction, norm_squared, world_scale, direction_scale }
    }

    /// `S·o`.
    pub fn origin(&self) -> &[Dyadic; 3] {
        &self.origin
    }

    /// `F·d`.
    pub fn direction(&self) -> &[Dyadic; 3] {
        &self.direction
    }

    /// `‖F·d‖²`.
    pub fn norm_squared(&self) -> &Dyadic {
        &self.norm_squared
    }

    /// `S`: the picture's height for an orthographic camera's ray, else 1.
    pub fn world_scale(&self) -> u32 {
        self.world_scale
    }

    /// `F`: the picture's height for a pixel's ray, else 1.
    pub fn direction_scale(&self) -> u32 {
        self.direction_scale
    }

    /// `F/S`, an integer.
    pub fn t_factor(&self) -> u32 {
        self.direction_scale / self.world_scale
    }

    /// `S·x`
    pub(crate) fn to_scale(&self, x: Dyadic) -> Dyadic {
        match self.world_scale {
            1 => x,
            scale => x * integer(i64::from(scale)),
        }
    }

    /// `S·(p − o)`, or `None` where a number is not finite.
    pub(crate) fn to_point(&self, point: DVec3) -> Option<[Dyadic; 3]> {
        let [px, py, pz] = real3(point)?.map(|p| self.to_scale(p));
        let [ox, oy, oz] = &self.origin;
        Some([px - ox, py - oy, pz - oz])
    }
}

/// The exact centre rays of a picture's pixels.
///
/// Contract §1, perspective: `d = forward + (2(x+½)/W − 1)·h·(W/H)·right + (1 − 2(y+½)/H)·h·true_up`. With
/// `(2(x+½)/W − 1)·(W/H) = (2x+1−W)/H = i/H` and `1 − 2(y+½)/H = (H−2y−1)/H = j/H`
/// (`(i, j)` as [`Pixels::offset2`] gives them), `H·d = H·forward + i·h·right + j·h·true_up` is
/// dyadic, though `d` itself is not. Orthographic: so is `H·o` with
/// `o = position + (i/H)·h·right + (j/H)·h·true_up`; the direction is scaled with it, so that `t`
/// stays what it is.
#[derive(Clone, Debug)]
pub struct ExactPixels {
    pixels: Pixels,
    /// Origin and direction of the ray through the picture's centre, and the steps to the right and to the top, scaled as all of
    /// them; `None` where a number is not finite.
    camera: Option<[[Dyadic; 3]; 4]>,
}

impl ExactPixels {
    /// The camera of `pixels` in exact numbers.
    pub fn new(pixels: &Pixels) -> ExactPixels {
        let view = &pixels.view;
        let [one, height] = [1, pixels.image_height].map(|x| integer(x.into()));
        let camera = || {
            let h = real(view.h)?;
            let world_scale = match view.lens {
                Lens::Perspective => &one,
                Lens::Orthographic => &height,
            };
            let scaled = |v: DVec3, scale: &Dyadic| Some(real3(v)?.map(|x| x * scale));
            Some([
                scaled(view.position, world_scale)?,
                scaled(view.forward, &height)?,
                scaled(view.right, &h)?,
                scaled(view.true_up, &h)?,
            ])
        };
        ExactPixels { pixels: *pixels, camera: camera().filter(|_| pixels.image_height > 0) }
    }

    /// The centre ray of pixel `(x, y)` of the picture.
    pub fn ray(&self, x: u32, y: u32) -> ExactRay {
        let Some([origin, direction, right, up]) = &self.camera else {
            return ExactRay::nowhere();
        };
        let (i, j) = self.pixels.offset2(x, y);
        let (i, j) = (integer(i), integer(j));
        let moved = |from: &[Dyadic; 3]| {
            std::array::from_fn(|axis| &from[axis] + &right[axis] * &i + &up[axis] * &j)
        };
        let height = self.pixels.image_height;
        match self.pixels.view.lens {
            Lens::Perspective => ExactRay::from_parts(origin.clone(), moved(direction), 1, height),
            Lens::Orthographic => {
                ExactRay::from_parts(moved(origin), direction.clone(), height, height)
            }
        }
    }
}

/// Rays, a picture's with its camera in exact numbers.
#[derive(Clone, Debug)]
pub enum ExactRays<'a> {
    /// The centre rays of a picture's pixels.
    Pixels(Box<ExactPixels>),
    /// A list.
    List(&'a [WorldRay]),
}

impl<'a> From<&'a Rays> for ExactRays<'a> {
    fn from(rays: &'a Rays) -> ExactRays<'a> {
        match rays {
            Rays::Pixels(pixels) => ExactRays::Pixels(Box::new(ExactPixels::new(pixels))),
            Rays::List(rays) => ExactRays::List(rays),
        }
    }
}

impl ExactRays<'_> {
    /// The ray with this index, exactly.
    pub fn ray(&self, index: usize) -> ExactRay {
        match self {
            ExactRays::Pixels(exact) => {
                let (x, y) = exact.pixels.xy(index);
                exact.ray(x, y)
            }
            ExactRays::List(rays) => ExactRay::new(&rays[index]),
        }
    }
}
