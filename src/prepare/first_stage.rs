//! The stage that a scene's rays begin in.
//!
//! Where guard radii are wide against what a pixel sees, or where objects are closer to each other than
//! f32 can tell, f32 leaves nearly every ray open, and is a detour. The picture itself says so: some of
//! its rays are tried.

use super::Prepared;
use crate::num::UNDECIDED;
use crate::rays::{Frame, Rays, WorldRay};
use crate::shape::Objects;
use crate::visibility::{ListSearch, RayBatch};

/// Columns and rows of a picture's rays that are tried; of a list, their product.
const TRIED: u32 = 16;

/// Share of the tried rays that f32 leaves open from which on f64 begins: f32 takes about half the time
/// of f64, so that it pays where it decides every other ray.
const MOST_OPEN: f64 = 0.5;

/// Whether f32 leaves too many of these rays open to be of use, for objects that are tested one after
/// the other. Only the CPU's f32 is asked, so that all devices begin in the same stage.
pub(super) fn is_left_open(prepared: &Prepared, rays: &Rays) -> bool {
    let n_tried = (TRIED * TRIED) as usize;
    let ids = match rays {
        Rays::Pixels(pixels) => {
            let mut tile = RayBatch::default();
            for y in 0..TRIED {
                for x in 0..TRIED {
                    let [x, y] = [middle(x, pixels.image_width), middle(y, pixels.image_height)];
                    tile.push(pixels.offset2(x, y));
                }
            }
            let objects = Objects::new(prepared.listed(None), &prepared.eye);
            tile.find_f32(&Frame::of_pixels(pixels), &objects);
            tile.ids
        }
        Rays::List(rays) => {
            // As far apart as they can be.
            let places = (0..n_tried).map(|k| k * rays.len() / n_tried);
            let tried: Vec<WorldRay> = places.filter_map(|at| rays.get(at).copied()).collect();
            let mut ids = vec![UNDECIDED; tried.len()];
            ListSearch::new(prepared).look(&tried, &mut ids);
            ids
        }
    };
    let n_open = ids.iter().filter(|&&id| id == UNDECIDED).count();
    n_open as f64 > MOST_OPEN * n_tried as f64
}

/// The middle of the `k`-th of [`TRIED`] parts that a picture's side is cut into.
fn middle(k: u32, side: u32) -> u32 {
    ((2 * u64::from(k) + 1) * u64::from(side) / (2 * u64::from(TRIED))) as u32
}
