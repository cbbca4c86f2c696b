//! The light of a picture as the kernel `certified` takes it, on the CPU and on a device.

use crate::num::V3;
use crate::shape::shadow::Aim;
use crate::shape::{Bounds, Contact, LightBounds, Occluder, SurfaceErrorTerms};

/// What bounds of a picture's colours in numbers of `F` rest on, relative to the eye.
#[derive(Clone)]
pub struct CertifiedLighting<F: Copy = f32> {
    /// Samples across and down a pixel.
    pub n_samples: u32,
    /// The background's colour, as samples count it; the objects have those of the scene.
    pub background: V3<F>,
    /// The objects that may be in the way of light and are in no tree, and their ids.
    pub occluders: Vec<(u32, Occluder<F>)>,
    /// Lights and suns of the sky.
    pub lamps: Vec<CertifiedLamp<F>>,
    /// Bounds of the light from nowhere.
    pub ambient: LightBounds<F>,
    /// What a mean is multiplied with for its bounds.
    pub width: Bounds<F>,
    /// What the samples' rays share where they meet an object.
    pub lengths: SurfaceErrorTerms<F>,
}

/// Contacts of a lamp that a device knows. It leaves more to the CPU: a lamp touches few objects.
const MOST_CONTACTS: usize = 4;

impl<F> CertifiedLamp<F> {
    /// The contacts that a device knows.
    pub fn contacts_on_device(&self) -> &[Contact] {
        &self.contacts[..self.contacts.len().min(MOST_CONTACTS)]
    }
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
    /// The objects that it is close to.
    pub contacts: Vec<Contact>,
}
