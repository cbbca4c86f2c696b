//! The sign of the discriminant, as each kernel's arithmetic has it.

use crate::exact::{ExactPixels, signum_of_discriminant};
use crate::guard::{self, Guard};
use crate::kernel::RayOf;
use crate::kernel::arithmetic::Arithmetic;
use crate::kernel::lecture::quadratic;
use crate::kernel::relative::{RelativeSphere, approach};
use crate::num::Float;
use crate::prepare::{Objects, Prepared};
use crate::rays::{Bundle, CameraF32, Pixels, View};
use crate::vec3::{Real, Vec3, dot3};

/// Most spheres among which the one that a line comes nearest to is looked for: each line would look at
/// all of them.
const MOST_SEARCHED: usize = 4096;

/// The discriminants of some rows of a picture.
pub struct Discriminants<'a> {
    prepared: &'a Prepared,
    pixels: &'a Pixels,
    exact: ExactPixels,
    camera: CameraF32,
    /// Of [`Pixels::spread`].
    spread: f64,
}

impl<'a> Discriminants<'a> {
    /// For a scene prepared for the kernel whose arithmetic is looked at.
    pub fn new(prepared: &'a Prepared, pixels: &'a Pixels) -> Discriminants<'a> {
        Discriminants {
            prepared,
            pixels,
            exact: ExactPixels::new(pixels),
            camera: f32::camera(&prepared.coordinates(), pixels),
            spread: pixels.spread(),
        }
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
            let l = Vec3::from(sphere.center - self.pixels.view.position) - ray.origin;
            let p = l - direction_times(&ray, l);
            let m = dot3(p, p);
            (m, 1.0 - m / (sphere.radius * sphere.radius))
        };
        let n_spheres = self.prepared.scene.spheres.len();
        let chosen = match (id as usize).checked_sub(1).filter(|&i| i < n_spheres) {
            Some(i) => Some(i),
            None if n_spheres > MOST_SEARCHED => None,
            None => (0..n_spheres).max_by(|&a, &b| nearness(a).1.total_cmp(&nearness(b).1)),
        };
        let i = chosen?;
        let (m, value) = nearness(i);
        let (column, row) = self.pixels.offset2(x, y);
        let single = f32::pixel_ray(&self.camera, column, row);
        let sign = match &self.prepared.objects {
            Objects::Lecture(lists) => {
                let sphere = &lists.spheres[i];
                let RayOf { origin, direction, .. } = single;
                let equation = quadratic(origin, direction, Vec3(sphere.center), sphere.radius);
                sign(equation.discriminant)
            }
            Objects::Stable(lists) => self.sign_of_delta(&lists.spheres[i], &single),
            Objects::Double(lists) => self.sign_of_delta(&lists.spheres[i], &ray),
            Objects::Certified(_) => self.exact_sign(i, m, x, y),
        };
        Some((sign, value))
    }

    fn sign_of_delta<S: RelativeSphere>(&self, sphere: &S, ray: &RayOf<S::Float>) -> i32 {
        let l = match self.prepared.bundle() {
            Bundle::Point => sphere.sphere_offset::<true>(ray),
            Bundle::Parallel | Bundle::Free => sphere.sphere_offset::<false>(ray),
        };
        sign(approach(ray, l, sphere.radius()).delta)
    }

    /// The sign of D: in f64 where its bounds allow, else exactly.
    fn exact_sign(&self, i: usize, m: f64, x: u32, y: u32) -> i32 {
        let sphere = &self.prepared.scene.spheres[i];
        let View { position, lens, .. } = self.pixels.view;
        let distance = guard::length_bound(sphere.center - position) + self.spread;
        let input = guard::input_of(lens);
        let guard = Guard::new(sphere.radius, distance, f64::UNIT, input);
        if m < guard.inner2 {
            return 1;
        }
        if m > guard.outer2 {
            return -1;
        }
        signum_of_discriminant(&self.exact.ray(x, y), sphere.center, sphere.radius).unwrap_or(-1)
    }
}

fn direction_times(ray: &RayOf<f64>, l: Vec3<f64>) -> Vec3<f64> {
    ray.direction * (dot3(ray.direction, l) * ray.inv_a)
}

fn sign<R: Real>(discriminant: R) -> i32 {
    if discriminant > R::ZERO {
        1
    } else if discriminant == R::ZERO {
        0
    } else {
        -1
    }
}
