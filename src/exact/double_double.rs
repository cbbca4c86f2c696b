//! A ray in numbers of some 100 bits, for the `t` and the normal of a hit that is known to exist: what f64 leaves open, but for
//! numbers on or very near the middle of two f32. Exact arithmetic in its place takes ten times as long for
//! `hard/distant_1e6`, five for `hard/coincident_far`.
//!
//! A pixel's ray is multiplied with the picture's height `H`, as in [`crate::exact::ExactPixels`]: then its numbers are
//! products and sums of the camera's, and nothing is rounded before a [`Ball`] is.

use std::array::from_fn;

use glam::DVec3;

use super::Ball;
use crate::rays::{Lens, Pixels, Rays, WorldRay};
use crate::scene::Object;

/// A vector of such numbers.
pub(super) type Ball3 = [Ball; 3];

/// A ray as a multiple of what it is: `F` times its direction, in a world that is `S` times as large.
pub(crate) struct DoubleDoubleRay {
    /// Where it starts, but for `across`.
    from: DVec3,
    /// `S·(o − from)`, where that is not 0.
    across: Option<Ball3>,
    /// `F·d`
    pub(super) direction: Ball3,
    /// `S`
    world_scale: f64,
    /// `F/S`, which a root is multiplied with.
    t_factor: f64,
}

pub(super) fn ball_dot(x: &Ball3, y: &Ball3) -> Ball {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

impl DoubleDoubleRay {
    /// The ray with an index.
    pub(crate) fn new(rays: &Rays, index: usize) -> DoubleDoubleRay {
        match rays {
            Rays::Pixels(pixels) => DoubleDoubleRay::of_pixel(pixels, index),
            Rays::List(rays) => DoubleDoubleRay::of_ray(&rays[index]),
        }
    }

    fn of_pixel(pixels: &Pixels, index: usize) -> DoubleDoubleRay {
        let (x, y) = pixels.xy(index);
        let (i, j) = pixels.offset2(x, y);
        let view = &pixels.view;
        let [i, j, height] = [i as f64, j as f64, f64::from(pixels.image_height)].map(Ball::from);
        let h = Ball::from(view.h);
        let forward: Ball3 = from_fn(|axis| Ball::from(view.forward[axis]) * height);
        let across: Ball3 = from_fn(|axis| {
            h * (Ball::from(view.right[axis]) * i + Ball::from(view.true_up[axis]) * j)
        });
        let from = view.position;
        match view.lens {
            Lens::Perspective => DoubleDoubleRay {
                from,
                across: None,
                direction: from_fn(|axis| forward[axis] + across[axis]),
                world_scale: 1.0,
                t_factor: height.high,
            },
            Lens::Orthographic => DoubleDoubleRay {
                from,
                across: Some(across),
                direction: forward,
                world_scale: height.high,
                t_factor: 1.0,
            },
        }
    }

    fn of_ray(&WorldRay { origin: from, direction }: &WorldRay) -> DoubleDoubleRay {
        let direction = from_fn(|axis| Ball::from(direction[axis]));
        DoubleDoubleRay { from, across: None, direction, world_scale: 1.0, t_factor: 1.0 }
    }

    /// `S·(p − o)`
    pub(super) fn to_point(&self, point: DVec3) -> Ball3 {
        from_fn(|axis| {
            let way = Ball::difference(point[axis], self.from[axis]);
            self.across.map_or(way, |across| way * Ball::from(self.world_scale) - across[axis])
        })
    }

    /// `S·x`
    pub(super) fn to_scale(&self, x: f64) -> Ball {
        Ball::from(x) * Ball::from(self.world_scale)
    }

    /// `t` times a power of two and the normal of an object that it is known to see, each rounded to the nearest f32; `None` where
    /// that is open.
    pub(crate) fn surface(&self, object: Object, unit: f64) -> Option<(f32, [f32; 3])> {
        let (root, normal) = object.exact().surface_in_balls(self)?;
        // It is never 0.
        let t = (root * Ball::from(self.t_factor * unit)).nearest_f32().filter(|t| *t > 0.0)?;
        Some((t, normal))
    }
}
