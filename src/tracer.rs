//! The one interface of all backends.

use std::sync::Arc;

use crate::certify;
use crate::control::Control;
use crate::error::Result;
use crate::prepare::{PlainLighting, Prepared};
use crate::rays::Pixels;
use crate::trace::{Hits, Rays, SampleIds, Timing, Wants};

/// [`Tracer::trace_samples`] of a backend that traces each sample.
///
/// # Errors
/// Those of [`Tracer::trace`].
pub fn trace_all_samples<T: Tracer + ?Sized>(
    tracer: &mut T,
    pixels: &Pixels,
    n: u32,
    control: &Control,
    hits: &mut Hits,
    samples: &mut SampleIds,
) -> Result<Timing> {
    let timing = tracer.trace(&Rays::Pixels(pixels.samples(n)), control, hits)?;
    samples.gather(hits, pixels.width as usize, n as usize);
    Ok(timing)
}

/// A backend with a scene, made for certain [`Wants`]: takes rays, gives hits.
pub trait Tracer: Send {
    /// Writes what the kernel itself sees of all `rays` into `hits`. The kernel `certified` proposes ids
    /// alone, in f32: an object, 0, or [`OPEN`](crate::num::OPEN); its `t` and
    /// normals mean nothing yet. Levels and counts are not yet filled in.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`].
    fn propose(&mut self, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<Timing>;

    /// The scene and the outputs that [`Tracer::certify`] decides for; without them, what is proposed is
    /// the result.
    fn target(&self) -> Option<(&Prepared, Wants)>;

    /// Decides what [`Tracer::propose`] left open in `hits`, and completes them. Adds its time to
    /// `timing`.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    fn certify(
        &mut self,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
        timing: Timing,
    ) -> Result<Timing> {
        match self.target() {
            Some((prepared, wants)) => {
                certify::resolve(prepared, rays, wants, control, hits, timing)
            }
            None => Ok(timing),
        }
    }

    /// Traces all `rays` into `hits`, whose values mean nothing after an error. Nothing is proposed where
    /// [`Prepared::starts_in_f64`].
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled, [`crate::Error::Device`] when the
    /// device failed or timed out, [`crate::Error::TooLarge`] when the rays don't fit its limits,
    /// [`crate::Error::Usage`] when the scene was prepared for other rays.
    fn trace(&mut self, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<Timing> {
        let timing = match self.target() {
            Some((prepared, wants)) if prepared.starts_in_f64() => {
                certify::leave_open(prepared, rays, wants, control, hits)?;
                Timing::default()
            }
            _ => self.propose(rays, control, hits)?,
        };
        self.certify(rays, control, hits, timing)
    }

    /// What the samples of `pixels` see, `n` × `n` of each. The scene is prepared for the picture of the samples,
    /// [`Pixels::samples`]; `hits` are room for them.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`].
    fn trace_samples(
        &mut self,
        pixels: &Pixels,
        n: u32,
        control: &Control,
        hits: &mut Hits,
        samples: &mut SampleIds,
    ) -> Result<Timing> {
        trace_all_samples(self, pixels, n, control, hits, samples)
    }

    /// Replaces `lights` by the light that each of a picture's rays finds on what it hits, in the arithmetic of the
    /// kernel, which is one without a proof. False where that is left to the CPU; `lights` then mean nothing.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`].
    fn light_plainly(
        &mut self,
        _lighting: &PlainLighting,
        _samples: &Pixels,
        _control: &Control,
        _lights: &mut Vec<[f64; 3]>,
    ) -> Result<bool> {
        Ok(false)
    }

    /// Takes another prepared scene, with the same [`Wants`]. After an
    /// error it can trace no more.
    ///
    /// # Errors
    /// Those of making a tracer.
    fn retarget(&mut self, prepared: Arc<Prepared>) -> Result<()>;

    /// Bytes held on the device for the scene.
    fn bytes_device(&self) -> u64;

    /// Asks for [`Timing::on_device`] from now on; a device without a clock leaves it out.
    fn use_device_clock(&mut self) {}
}
