//! The tree over many spheres, as a device takes it in f32.

use glam::DVec3;

use super::Prepared;
use crate::bounds;
use crate::bvh::{FlatBox, REACH};
use crate::error::{Hint, Result, Setting};
use crate::num::{Float, round_up};
use crate::rays::{Lens, View};
use crate::shape::shadow::BEND_IN_BOXES;
use crate::support::memory;

/// Boxes relative to [`Prepared::reference`].
pub struct DeviceBvh {
    /// In depth-first order, as a picture's rays meet them.
    pub boxes: Vec<FlatBox>,
    /// Upper bound of the distance between the true ray and the device's ray, except for the rounding of single numbers and for the error of
    /// a perspective picture's directions, which the boxes contain.
    pub beside: f32,
}

/// Bytes a sphere: a box and its share of those above, both twice while parts are put together, and its numbers.
const BYTES: u64 = 4 * size_of::<FlatBox>() as u64;

impl Prepared {
    /// What a device needs to trace rays into many spheres; `None` for all else, and where
    /// spheres or rays are so far away that f32 has no slabs for them.
    ///
    /// # Errors
    /// [`crate::Error::TooLarge`] where there is no memory for it.
    pub fn in_space(&self) -> Result<Option<DeviceBvh>> {
        let Some(hierarchy) = &self.hierarchy else { return Ok(None) };
        let bvh = &hierarchy.bvh;
        let n_spheres = bvh.spheres.len();
        memory::require(
            format!("{n_spheres} spheres on a device"),
            n_spheres as u64 * BYTES,
            Hint::new("use fewer spheres, or {}", [Setting::text("device", "cpu")]),
        )?;
        let spread = self.eye.spread;
        if spread > REACH {
            return Ok(None);
        }
        let view = self.picture.map(|picture| picture.view);
        let order = |middle: DVec3| match view {
            None => 0.0,
            Some(View { lens: Lens::Perspective, .. }) => middle.length_squared(),
            Some(View { lens: Lens::Orthographic, forward, .. }) => middle.dot(forward),
        };
        // The reference point of a perspective picture is the eye, from where all rays start.
        // Shadow rays to far lights ask for more than a pixel's direction.
        let [turn, beside] = match view.map(|view| view.lens) {
            None => [0.0, 0.0],
            Some(Lens::Perspective) => [BEND_IN_BOXES.max(bounds::PIXELS.direction), 0.0],
            Some(Lens::Orthographic) => [BEND_IN_BOXES, bounds::PARALLEL.offset * spread],
        };
        // Halving `turn` is not covered by a test: rounding boxes outward to f32 hides it. Without it, some rays miss their spheres.
        // The 1.01 covers terms of second order. Halving the 1.01 is not covered by a test: it is about 10⁴ times as large as needed.
        let [turn, beside] = [turn, beside].map(|error| 1.01 * f32::UNIT * error);
        let Some(boxes) = bvh.boxes_from(self.reference, turn, order) else { return Ok(None) };
        Ok(Some(DeviceBvh { boxes, beside: round_up(beside) }))
    }
}
