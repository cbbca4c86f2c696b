//! `t` and the normal of a hit that is known to exist, with some 100 bits: what f64 leaves open, but for numbers on or very
//! near the middle of two f32. Exact arithmetic in its place takes ten times as long for `hard/distant_1e6`, five for
//! `hard/coincident_far`.
//!
//! A pixel's ray is multiplied with the picture's height `H`, as in [`crate::exact::ExactPixels`]: then its numbers are
//! products and sums of the camera's, and nothing is rounded before a [`Ball`] is.

use std::array::from_fn;

use super::Stage;
use super::surfaces::{TAndNormal, unit_f32};
use crate::exact::Ball;
use crate::rays::{Lens, Pixels, Rays, WorldRay};
use crate::scene::Object;
use glam::DVec3;

type Ball3 = [Ball; 3];

/// A ray to a point, both as multiples of what they are.
struct Sight {
    /// `S·(p − o)`
    to_point: Ball3,
    /// `F·d`
    direction: Ball3,
    /// `S`
    world_scale: f64,
    /// `F/S`, which a root is multiplied with.
    t_factor: f64,
}

fn dot(x: &Ball3, y: &Ball3) -> Ball {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

fn difference(x: DVec3, y: DVec3) -> Ball3 {
    from_fn(|axis| Ball::difference(x[axis], y[axis]))
}

impl Sight {
    fn of_pixel(pixels: &Pixels, index: usize, point: DVec3) -> Sight {
        let (x, y) = pixels.xy(index);
        let (i, j) = pixels.offset2(x, y);
        let view = &pixels.view;
        let [i, j, height] = [i as f64, j as f64, f64::from(pixels.image_height)].map(Ball::from);
        let h = Ball::from(view.h);
        let forward: Ball3 = from_fn(|axis| Ball::from(view.forward[axis]) * height);
        let across: Ball3 = from_fn(|axis| {
            h * (Ball::from(view.right[axis]) * i + Ball::from(view.true_up[axis]) * j)
        });
        let to_point = difference(point, view.position);
        match view.lens {
            Lens::Perspective => Sight {
                to_point,
                direction: from_fn(|axis| forward[axis] + across[axis]),
                world_scale: 1.0,
                t_factor: height.high,
            },
            Lens::Orthographic => Sight {
                to_point: from_fn(|axis| to_point[axis] * height - across[axis]),
                direction: forward,
                world_scale: height.high,
                t_factor: 1.0,
            },
        }
    }

    fn of_ray(&WorldRay { origin, direction }: &WorldRay, point: DVec3) -> Sight {
        let direction = from_fn(|axis| Ball::from(direction[axis]));
        Sight { to_point: difference(point, origin), direction, world_scale: 1.0, t_factor: 1.0 }
    }

    /// Root and facing normal of a sphere around the point. With `a = d·d`, `b = d·l`, `k = l·l − r²` and `w = √(b² − ak)` the
    /// visible root is `k/(b + w)` from outside, and `(b + w)/a` or `−k/(w − b)` from inside, whichever does not cancel.
    fn sphere(&self, radius: f64) -> Option<(Ball, Ball3)> {
        let Sight { to_point: l, direction: d, world_scale, .. } = self;
        let r = Ball::from(radius) * Ball::from(*world_scale);
        let (a, b, k) = (dot(d, d), dot(d, l), dot(l, l) - r * r);
        let w = (b * b - a * k).sqrt();
        let is_inside = (-k).is_positive();
        let root = match is_inside {
            false if !(k.is_positive() && b.is_positive()) => return None,
            false => k.over(b + w),
            true if b.is_positive() => (b + w).over(a),
            true => (-k).over(w - b),
        };
        let outward = |axis: usize| (d[axis] * root - l[axis]).over(r);
        Some((root, from_fn(|axis| if is_inside { -outward(axis) } else { outward(axis) })))
    }

    /// `t`, rounded. It is never 0.
    fn t_f32(&self, root: Ball) -> Option<f32> {
        (root * Ball::from(self.t_factor)).nearest_f32().filter(|t| *t > 0.0)
    }
}

impl Stage<'_> {
    pub fn surface_in_balls(&self, index: usize, object: Object) -> Option<TAndNormal> {
        let sight = |point: DVec3| match self.rays {
            Rays::Pixels(pixels) => Sight::of_pixel(pixels, index, point),
            Rays::List(rays) => Sight::of_ray(&rays[index], point),
        };
        match object {
            Object::Sphere(sphere) => {
                let sight = sight(sphere.center);
                let (root, normal) = sight.sphere(sphere.radius.abs())?;
                let [x, y, z] = normal.map(|component| component.nearest_f32());
                Some((sight.t_f32(root)?, [x?, y?, z?]))
            }
            Object::Plane(plane) => {
                let sight = sight(plane.point);
                let n = from_fn(|axis| Ball::from(plane.normal[axis]));
                let slope = dot(&n, &sight.direction);
                let is_along = slope.is_positive();
                if !(is_along || (-slope).is_positive()) {
                    return None;
                }
                let t = sight.t_f32(dot(&n, &sight.to_point).over(slope))?;
                let unit = unit_f32(plane);
                Some((t, unit.map(|x| if is_along { 0.0 - x } else { x })))
            }
        }
    }
}
