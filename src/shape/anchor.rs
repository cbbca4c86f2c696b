//! Points beside spheres that a picture's rays start anew at, in f32.
//!
//! A normal of a sphere is off by as much as the way to its centre, over its radius: of a small sphere that is far away f32 tells
//! few bytes. But how far the rays of two pixels are apart f32 knows as well as any number, as their places are whole numbers. So
//! such a sphere's numbers are relative to a point near its centre on the ray of a pixel `(i₀, j₀)`, its *anchor*
//! `A = s·(f + i₀R + j₀T)`, of parallel rays `s·f + i₀R + j₀T`. The ray of the pixel `(i, j)` passes it at
//! `o' = s·((i − i₀)R + (j − j₀)T)`, of parallel rays without the `s`. From there on it is a ray from `o'` that meets a sphere with
//! the centre `c' = c − A`.
//!
//! # How far from the anchor
//! A hit is within `ρ = r + |c'|` of the anchor. As all directions have one component along the view axis, its `t` differs from `s` by
//! `1.01ρ` at most, for a frame that is orthonormal to `2⁻¹⁰`, and so `|o'| ≤ ρ(1 + 1.01|d|)`.
//!
//! # The point
//! From the anchor the hit is `o' + t'·d`, with errors as in [`super::SurfaceErrorTerms`], all of them in proportion to `ρ`. `t'` may be
//! negative, and what it counts of an error is taken from its bound then: it is granted twice more. The anchor is rounded, ½,
//! and so is the sum with it, 1.

use super::{Bounds, Ray, RayOrigin, SphereRecord, Surface, record};
use crate::bounds::{self, Footprint, InputError, ROOM, length_bounds, steps};
use crate::num::{Float, Real, V3};
use crate::rays::{Frame, Lens, Pixels, camera_origin};
use crate::scene::Sphere;

record! {
    /// A point of a pixel's ray that a sphere's numbers are relative to.
    Anchor {
        /// From the eye's reference point.
        base: vec near,
        /// What points on the sphere are off by beside what they are off by from here.
        error: num up,
        /// The pixel's place, in steps from the picture's centre: whole numbers.
        across: num near,
        /// To the top.
        above: num near,
        /// Length of a step here, in those of the picture.
        scale: num near,
    }
}

impl<R: Real> Anchor<R> {
    /// The ray through a place of the picture as the anchor sees it; `t` counts from another point.
    #[inline(always)]
    pub fn ray(
        &self,
        (right, up): (V3<R>, V3<R>),
        [across, above]: [R; 2],
        ray: &Ray<R>,
    ) -> Ray<R> {
        let aside = camera_origin(right, up, across - self.across, above - self.above);
        Ray { origin: aside * self.scale, ..*ray }
    }

    /// What the anchor's ray meets, as the eye sees it; its `t` is not known.
    #[inline(always)]
    pub fn to_eye(&self, surface: Surface<R>) -> Surface<R> {
        Surface {
            t: Bounds { low: R::lit(0.0), high: R::lit(R::One::BEYOND) },
            point: self.base + surface.point,
            point_error: surface.point_error + self.error,
            ..surface
        }
    }
}

/// Radii that a sphere with an anchor is before the camera at least, so that all rays start outside. No test sees it halved: one
/// would do, and closer spheres are seen as well without.
const LEAST_RADII: f64 = 4.0;

/// Radii that it is away at most: f64 finds its anchor, off by 10 units of the way at most, and that is 0.01 units of f32 of the
/// radius. No test sees it halved: the range may be smaller.
const MOST_RADII: f64 = (1u64 << 18) as f64;

/// Steps from the picture's centre to an anchor's pixel at most: differences of places are exact in f32. No test sees it halved: the
/// range may be smaller.
const MOST_STEPS: f64 = (1u64 << 22) as f64;

/// The nearest whole number to one below `2⁵¹`.
#[inline(always)]
fn whole<R: Real<One = f64>>(x: R) -> R {
    let shift = R::lit(1.5 / f64::EPSILON);
    (x + shift) - shift
}

/// Makes the anchors of a picture's spheres.
#[derive(Clone, Copy, Debug)]
pub struct Anchors {
    camera: Frame<f64>,
    eye: RayOrigin,
    longest: f64,
}

impl Anchors {
    /// The anchors of a picture's spheres.
    pub fn new(pixels: &Pixels) -> Anchors {
        let eye = RayOrigin::of_pixels(pixels, Footprint::default(), f32::UNIT);
        Anchors { camera: Frame::of_pixels(pixels), eye, longest: pixels.longest_direction() }
    }

    /// Spheres with their anchors, and which of them suit that: the others' numbers mean nothing.
    #[inline(always)]
    pub fn seen<R: Real<One = f64>>(
        &self,
        center: V3<R>,
        r: R,
    ) -> (SphereRecord<R>, Anchor<R>, R::Mask) {
        let lit = R::lit;
        let Frame { forward, right, true_up, lens } = self.camera;
        let step2 = right.dot(right);
        let (forward, right, up) = (V3::splat(forward), V3::splat(right), V3::splat(true_up));
        let depth = center.dot(forward);
        let scale = match lens {
            Lens::Perspective => depth,
            Lens::Orthographic => lit(1.0),
        };
        let to_steps = lit(1.0) / (scale * lit(step2));
        let across = whole(center.dot(right) * to_steps);
        let above = whole(center.dot(up) * to_steps);
        let base = forward * depth + camera_origin(right, up, across, above) * scale;
        let from_base = center - base;
        let away = length_bounds(center);
        let around = r + length_bounds(from_base);
        let spread = lit(ROOM * (1.0 + 1.01 * self.longest)) * around;
        let suits = (lit(LEAST_RADII) * r).lt(depth)
            & away.lt(lit(MOST_RADII) * r)
            & across.abs().max(above.abs()).le(lit(MOST_STEPS))
            & spread.le(lit(f32::FARTHEST));
        let InputError { direction, .. } = self.eye.input;
        let input = InputError { offset: bounds::ANCHORED, direction };
        // All rays start outside, whatever their origin says.
        let l = around + spread;
        let outside = (lit(4.0) * l * l, lit(0.0));
        // Its rays start apart: `spread` says how far those of each sphere do.
        let apart = RayOrigin { spread: f32::FARTHEST, ..self.eye };
        let seen = SphereRecord::of::<f32>(from_base, r, outside, spread, input, &apart);
        let of_way = 2.0 * (direction + steps::POINT) * self.longest;
        let of_around = input.offset + steps::POINT_ORIGIN + 1.0 + of_way;
        // The anchor is closer than the centre and what is around it.
        let error = lit(1.5) * away + lit(1.5 + of_around) * l;
        let error = lit(ROOM * f32::UNIT) * error;
        let anchor = Anchor { base, error, across, above, scale };
        (SphereRecord { is_close: lit(0.0), ..seen }, anchor, suits)
    }

    /// A sphere with its anchor: the eye where none suits it.
    pub fn of(&self, sphere: &Sphere) -> (SphereRecord<f64>, Anchor<f64>) {
        let center = V3((sphere.center - self.eye.reference).to_array());
        let (seen, anchor, suits) = self.seen(center, sphere.radius.abs());
        if suits {
            return (seen, anchor);
        }
        let scale = match self.camera.lens {
            Lens::Perspective => 0.0,
            Lens::Orthographic => 1.0,
        };
        let eye = Anchor { base: V3([0.0; 3]), error: 0.0, across: 0.0, above: 0.0, scale };
        (SphereRecord::new::<f32>(sphere, &self.eye), eye)
    }
}
