//! The sign of the discriminant, as each kernel's arithmetic has it.

use kugelblitz::bounds::{self, FilterBounds};
use kugelblitz::exact::{ExactPixels, signum_of_discriminant};
use kugelblitz::kernel::baseline::{BaselineRay, BaselineRays};
use kugelblitz::kernel::lecture::quadratic;
use kugelblitz::kernel::relative::approach;
use kugelblitz::num::{Float, V3};
use kugelblitz::prepare::{ObjectRecords, Prepared};
use kugelblitz::rays::{Pixels, View};

/// Most spheres among which the one that a line comes nearest to is looked for: each line would look at
/// all of them.
const MOST_SEARCHED: usize = 4096;

/// The discriminants of some rows of a picture.
pub struct Discriminants<'a> {
    prepared: &'a Prepared,
    pixels: &'a Pixels,
    exact: ExactPixels,
    /// The pixels' [`Pixels::spread`].
    spread: f64,
}

impl<'a> Discriminants<'a> {
    /// For a scene prepared for the kernel whose arithmetic is looked at.
    pub fn new(prepared: &'a Prepared, pixels: &'a Pixels) -> Discriminants<'a> {
        Discriminants { prepared, pixels, exact: ExactPixels::new(pixels), spread: pixels.spread() }
    }

    /// The sign of D in the kernel's arithmetic at the pixel with this index, where object `id` is seen,
    /// and D/(4ar²), which is 1 where the line meets the sphere's centre. Of the visible sphere, else of the
    /// one that the line comes nearest to; `None` without a sphere, or where there are too many to look
    /// through.
    pub fn at(&self, index: usize, id: u32) -> Option<(i32, f64)> {
        let (x, y) = self.pixels.xy(index);
        let ray = self.pixels.ray_from_position(x, y);
        // ‖P‖² and 1 − ‖P‖²/r² = D/(4ar²).
        let nearness = |i: usize| {
            let sphere = &self.prepared.scene.spheres[i];
            let l = V3::lit(sphere.center - self.pixels.view.position) - ray.origin;
            let p = approach(&ray, l, sphere.radius).p;
            let m = p.dot(p);
            (m, 1.0 - m / (sphere.radius * sphere.radius))
        };
        let n_spheres = self.prepared.scene.spheres.len();
        let i = match (id as usize).checked_sub(1).filter(|&i| i < n_spheres) {
            Some(i) => i,
            None if n_spheres > MOST_SEARCHED => return None,
            None => (0..n_spheres).max_by(|&a, &b| nearness(a).1.total_cmp(&nearness(b).1))?,
        };
        let (m, value) = nearness(i);
        let sign = match &self.prepared.objects {
            ObjectRecords::Lecture(lists) => {
                let (sphere, BaselineRay { ray, .. }) = (&lists.spheres[i], self.ray::<f32>(index));
                let center = V3(sphere.center);
                let q = quadratic(ray.origin, ray.direction, center, sphere.radius);
                sign(q.discriminant.into())
            }
            ObjectRecords::Stable(lists) => {
                let (sphere, ray) = (&lists.spheres[i], self.ray(index));
                sign(approach(&ray.ray, sphere.offset(&ray), sphere.radius).delta.into())
            }
            ObjectRecords::Double(lists) => {
                let (sphere, ray) = (&lists.spheres[i], self.ray(index));
                sign(approach(&ray.ray, sphere.offset(&ray), sphere.radius).delta)
            }
            ObjectRecords::Certified { .. } => self.exact_sign(i, m, x, y),
        };
        Some((sign, value))
    }

    /// A pixel's ray in the kernel's arithmetic.
    fn ray<F: Float>(&self, index: usize) -> BaselineRay<F> {
        BaselineRays::of_pixels(self.prepared.coordinates(), self.pixels).one(index)
    }

    /// The sign of D: in f64 where its bounds allow, else exactly.
    fn exact_sign(&self, i: usize, m: f64, x: u32, y: u32) -> i32 {
        let sphere = &self.prepared.scene.spheres[i];
        let View { position, lens, .. } = self.pixels.view;
        let distance = bounds::length_bound(sphere.center - position) + self.spread;
        let guard = FilterBounds::new(sphere.radius, distance, f64::UNIT, bounds::input_of(lens));
        if m < guard.inner2 {
            return 1;
        }
        if m > guard.outer2 {
            return -1;
        }
        signum_of_discriminant(&self.exact.ray(x, y), sphere).unwrap_or(-1)
    }
}

/// The sign; −1 of what is no number.
fn sign(discriminant: f64) -> i32 {
    discriminant.partial_cmp(&0.0).map_or(-1, |order| order as i32)
}
