//! The stage that a scene's rays begin in.
//!
//! Where guard radii are wide against what a pixel sees, or where objects are closer to each other than
//! f32 can tell, f32 leaves nearly every ray open, and is a detour. The picture itself says so: some of
//! its rays are tried.

use crate::kernel::arithmetic::Arithmetic;
use crate::kernel::coordinates::Coordinates;
use crate::kernel::twin::{Twin, WithTwin};
use crate::kernel::{Objects, RayOf};
use crate::num::OPEN;
use crate::rays::{Bundle, Rays};

/// Columns and rows of a picture's rays that are tried; of a list, their product.
const TRIED: usize = 16;

/// Share of the tried rays that f32 leaves open from which on f64 begins: f32 takes about half the time
/// of f64, so that it pays where it decides every other ray.
const MOST_OPEN: f64 = 0.5;

/// Whether f32 leaves too many of these rays open to be of use, for objects that are tested one after
/// the other. Only the CPU's f32 is asked, so that all devices begin in the same stage.
pub(super) fn is_left_open(
    objects: &Objects,
    coordinates: &Coordinates,
    rays: &Rays,
    bundle: Bundle,
) -> bool {
    objects.with_twin(bundle, ShareOpen { coordinates, rays }) > MOST_OPEN
}

/// The share of the tried rays that are left open.
struct ShareOpen<'a> {
    coordinates: &'a Coordinates,
    rays: &'a Rays,
}

impl WithTwin for ShareOpen<'_> {
    type Output = f64;

    fn with<T: Twin>(self, twin: &T) -> f64 {
        let ShareOpen { coordinates, rays } = self;
        let is_open = |ray: &RayOf<T::Float>| twin.closest(ray).id == OPEN;
        let n_open = match rays {
            Rays::Pixels(pixels) => {
                let camera = T::Float::camera(coordinates, pixels);
                // In the middle of each of the parts that a side is cut into.
                let place = |k: usize, side: u32| {
                    ((2 * k as u64 + 1) * u64::from(side) / (2 * TRIED as u64)) as u32
                };
                let is_open = |k: &usize| {
                    let x = place(k % TRIED, pixels.image_width);
                    let (i, j) = pixels.offset2(x, place(k / TRIED, pixels.image_height));
                    is_open(&T::Float::pixel_ray(&camera, i, j))
                };
                (0..TRIED * TRIED).filter(is_open).count()
            }
            Rays::List(rays) => {
                let is_open = |k: &usize| {
                    rays.get(k * rays.len() / (TRIED * TRIED))
                        .is_some_and(|ray| is_open(&T::Float::list_ray(coordinates, ray).0))
                };
                (0..TRIED * TRIED).filter(is_open).count()
            }
        };
        n_open as f64 / (TRIED * TRIED) as f64
    }
}
