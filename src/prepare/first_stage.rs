//! The stage that a scene's rays begin in.
//!
//! Where guard radii are wide against what a pixel sees, or where objects are closer to each other than
//! f32 can tell, f32 leaves nearly every ray open, and is a detour. The picture itself says so: some of
//! its rays are tried.

use super::Prepared;
use crate::engine::Tile;
use crate::num::OPEN;
use crate::rays::{Frame, List, Pixels, Rays};
use crate::seen::Objects;

/// Columns and rows of a picture's rays that are tried; of a list, their product.
const TRIED: u32 = 16;

/// Share of the tried rays that f32 leaves open from which on f64 begins: f32 takes about half the time
/// of f64, so that it pays where it decides every other ray.
const MOST_OPEN: f64 = 0.5;

/// Whether f32 leaves too many of these rays open to be of use, for objects that are tested one after
/// the other. Only the CPU's f32 is asked, so that all devices begin in the same stage.
pub(super) fn is_left_open(prepared: &Prepared, rays: &Rays) -> bool {
    let objects = Objects::new(prepared.listed(None), &prepared.eye);
    let n_open = match rays {
        Rays::Pixels(pixels) => n_open_pixels(&objects, pixels),
        Rays::List(rays) => n_open_of_list(&objects, &List::new(rays, prepared.reference)),
    };
    n_open as f64 > MOST_OPEN * f64::from(TRIED * TRIED)
}

/// How many pixels f32 leaves open, of those in the middle of each of the parts that a picture's sides are cut into.
fn n_open_pixels(objects: &Objects<f32>, pixels: &Pixels) -> usize {
    let middle = |k: u32, side: u32| {
        ((2 * u64::from(k) + 1) * u64::from(side) / (2 * u64::from(TRIED))) as u32
    };
    let mut tile = Tile::default();
    for y in 0..TRIED {
        for x in 0..TRIED {
            let [x, y] = [middle(x, pixels.image_width), middle(y, pixels.image_height)];
            tile.push(pixels.offset2(x, y));
        }
    }
    tile.find_f32(&Frame::of_pixels(pixels), objects);
    tile.ids.iter().filter(|&&id| id == OPEN).count()
}

/// How many rays f32 leaves open, of some that are as far apart in a list as they can be.
fn n_open_of_list(objects: &Objects<f32>, list: &List) -> usize {
    let n = (TRIED * TRIED) as usize;
    let places = (0..n).map(|k| k * list.rays.len() / n);
    let is_open =
        |&at: &usize| at < list.rays.len() && objects.nearest(&list.one(at)).decide().0 == OPEN;
    places.filter(is_open).count()
}
