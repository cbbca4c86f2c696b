//! A scene ready to be traced: by the CPU, or with a device before it.

use std::sync::Arc;

use crate::cpu;
use crate::error::Result;
use crate::prepare::{CertifiedLighting, Lighting, Prepared};
use crate::query::{Hits, Outputs, Rays, SampleIds, Timing};
use crate::rays::Pixels;
use crate::support::control::Control;

/// What a device does of tracing a scene. The CPU does the rest, and all that a device leaves to it.
pub trait Backend: Send {
    /// Writes what the kernel itself sees of all `rays` into `hits`; `None` where the CPU has to. The kernel `certified` proposes
    /// ids alone, in f32: an object, 0, or [`UNDECIDED`](crate::num::UNDECIDED); its `t` and normals mean nothing yet. Levels and counts
    /// are not yet filled in.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`].
    fn propose(
        &mut self,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<Option<Timing>>;

    /// Replaces `lights` by the light that each of a picture's rays finds on what it hits, in the arithmetic of the
    /// kernel, which is one without a proof. Shadow rays start `epsilon` away from a surface, world units. False where that is left to the CPU; `lights` then mean nothing.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`].
    fn light_plainly(
        &mut self,
        _lighting: &Lighting,
        _epsilon: f64,
        _samples: &Pixels,
        _control: &Control,
        _lights: &mut Vec<[f64; 3]>,
    ) -> Result<bool> {
        Ok(false)
    }

    /// The bytes of a picture's pixels in this light, each `r | g << 8 | b << 16`, or [`UNDECIDED`](crate::num::UNDECIDED) where f32 leaves one
    /// of them open. The scene is prepared for the picture of their samples. `None` where that is left to the CPU.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`].
    fn light(
        &mut self,
        _lighting: &CertifiedLighting,
        _pixels: &Pixels,
        _control: &Control,
    ) -> Result<Option<&[u32]>> {
        Ok(None)
    }

    /// Takes another prepared scene, with the same [`Outputs`]. After an
    /// error it is for the one before.
    ///
    /// # Errors
    /// Those of making a backend.
    fn retarget(&mut self, prepared: &Arc<Prepared>) -> Result<()>;

    /// Bytes held on the device for the scene.
    fn bytes(&self) -> u64;

    /// Lights from now on every picture that the device can light, even if the CPU would be faster. Does nothing by default.
    fn force_light(&mut self) {}
}

/// Traces a scene for certain [`Outputs`]: takes rays, gives hits.
pub struct Tracer {
    prepared: Arc<Prepared>,
    wants: Outputs,
    backend: Option<Box<dyn Backend>>,
}

impl Tracer {
    /// One that needs no device.
    pub fn on_cpu(prepared: Arc<Prepared>, wants: Outputs) -> Tracer {
        Tracer { prepared, wants, backend: None }
    }

    /// One with a device, which was made for the same.
    pub fn on(backend: impl Backend + 'static, prepared: Arc<Prepared>, wants: Outputs) -> Tracer {
        Tracer { prepared, wants, backend: Some(Box::new(backend)) }
    }

    /// The scene.
    pub fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
    }

    /// The outputs.
    pub fn wants(&self) -> Outputs {
        self.wants
    }

    /// Traces all `rays` into `hits`, whose values mean nothing after an error. Nothing is proposed where
    /// [`Prepared::starts_in_f64`].
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled, [`crate::Error::Device`] when the
    /// device failed or timed out, [`crate::Error::TooLarge`] when the rays don't fit its limits,
    /// [`crate::Error::Usage`] when the scene was prepared for other rays.
    pub fn trace(&mut self, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<Timing> {
        let proposed = match &mut self.backend {
            Some(backend) if !self.prepared.starts_in_f64() => {
                backend.propose(rays, control, hits)?
            }
            _ => None,
        };
        cpu::trace(&self.prepared, self.wants, rays, proposed, control, hits)
    }

    /// What the samples of `pixels` see, `n` × `n` of each. The scene is prepared for the picture of the samples,
    /// [`Pixels::samples`]; `hits` are room for them.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`].
    pub fn trace_samples(
        &mut self,
        pixels: &Pixels,
        n: u32,
        control: &Control,
        hits: &mut Hits,
        samples: &mut SampleIds,
    ) -> Result<Timing> {
        if self.backend.is_none()
            && let Some(timing) = cpu::trace_samples(&self.prepared, pixels, n, control, samples)?
        {
            return Ok(timing);
        }
        let timing = self.trace(&Rays::Pixels(pixels.samples(n)), control, hits)?;
        samples.gather(hits, pixels.width as usize, n as usize);
        Ok(timing)
    }

    /// What a device does of tracing the scene; `None` where the CPU does all.
    pub fn backend(&mut self) -> Option<&mut (dyn Backend + 'static)> {
        self.backend.as_deref_mut()
    }

    /// Takes another prepared scene, with the same [`Outputs`]. After an error it is for the one before.
    ///
    /// # Errors
    /// Those of making a tracer.
    pub fn retarget(&mut self, prepared: Arc<Prepared>) -> Result<()> {
        if let Some(backend) = &mut self.backend {
            backend.retarget(&prepared)?;
        }
        self.prepared = prepared;
        Ok(())
    }

    /// Bytes held for the scene where its rays are traced.
    pub fn bytes_device(&self) -> u64 {
        match &self.backend {
            Some(backend) => backend.bytes(),
            None => self.prepared.bytes(),
        }
    }
}
