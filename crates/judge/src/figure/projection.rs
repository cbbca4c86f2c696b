//! The way back from a point of the world to the eye.

use glam::DVec3;
use kugelblitz::rays::{Lens, Pixels};

/// From a point towards the eye, not of any length.
pub fn towards_eye(pixels: &Pixels, point: DVec3) -> DVec3 {
    match pixels.view.lens {
        Lens::Perspective => pixels.view.position - point,
        Lens::Orthographic => -pixels.view.forward,
    }
}
