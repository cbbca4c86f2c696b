//! The light of a picture for a device that finds bytes as the kernel `certified` does.

use crate::num::V3;
use crate::seen::shadow::Aim;
use crate::seen::{Bounds, Lengths, LightBounds, Met};

/// What bounds of a picture's colours in f32 rest on, relative to the eye.
pub struct CertifiedLighting {
    /// Samples across and down a pixel.
    pub n_samples: u32,
    /// The background's colour, as samples count it; the objects have those of the scene.
    pub background: V3<f32>,
    /// The objects that may be in the way of light and are in no tree, and their ids.
    pub occluders: Vec<(u32, Met<f32>)>,
    /// Lights and suns of the sky.
    pub lamps: Vec<CertifiedLamp<f32>>,
    /// Bounds of the light from nowhere.
    pub ambient: LightBounds<f32>,
    /// What a mean is multiplied with for its bounds.
    pub width: Bounds<f32>,
    /// What the samples' rays share where they meet an object.
    pub lengths: Lengths<f32>,
}

/// A light, or a sun of the sky, in numbers of `F`.
#[derive(Clone)]
pub struct CertifiedLamp<F> {
    /// Where its light comes from.
    pub aim: Aim<F>,
    /// Linear light that a surface across its rays gets.
    pub weight: V3<F>,
    /// Whether objects may be in its way.
    pub casts_shadows: bool,
}
