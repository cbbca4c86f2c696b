//! What a device does: hand over, wait, map, and tell its errors.

use std::sync::PoisonError;
use std::time::Duration;

use super::open::Gpu;
use crate::error::{Error, Hint, Message, Result, Setting};

/// What takes a device longer than this is given up.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(60);

/// An error that a device reported on its own.
pub(super) enum DeviceFailure {
    OutOfMemory,
    Other(String),
}

impl Gpu {
    /// Hands commands over to the device.
    pub(crate) fn submit(&self, commands: wgpu::CommandBuffer) -> wgpu::SubmissionIndex {
        self.queue.submit([commands])
    }

    /// Fails with the first error that the device has reported since it was opened. A lack of memory
    /// is told once, with what followed from it: less may fit.
    ///
    /// # Errors
    /// [`Error::Device`], [`Error::TooLarge`]
    pub(crate) fn check(&self) -> Result<()> {
        let mut errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        match errors.first() {
            Some(DeviceFailure::OutOfMemory) => {
                errors.clear();
                let text = format!("`{}` has too little memory for this", self.facts.name);
                let hint = Hint::new("use fewer objects, or {}", [Setting::text("device", "cpu")]);
                Err(Error::TooLarge(Message::new(text, hint)))
            }
            Some(DeviceFailure::Other(error)) => {
                Err(Error::Device(format!("`{}`: {error}", self.facts.name).into()))
            }
            None => Ok(()),
        }
    }

    /// A buffer of `n_bytes`.
    pub(super) fn buffer(
        &self,
        label: &str,
        n_bytes: usize,
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: n_bytes as u64,
            usage,
            mapped_at_creation: false,
        })
    }

    /// A buffer with `bytes` that shaders read, as a uniform or as a list.
    pub(super) fn filled(&self, label: &str, bytes: &[u8]) -> wgpu::Buffer {
        use wgpu::BufferUsages as Usage;
        let usage = Usage::UNIFORM | Usage::STORAGE | Usage::COPY_DST;
        let buffer = self.buffer(label, bytes.len(), usage);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// An encoder without commands.
    pub(super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Waits until the device is done with `submission`, or with everything submitted.
    pub(crate) fn wait(&self, submission: Option<wgpu::SubmissionIndex>) -> Result<(), String> {
        let wait = wgpu::PollType::Wait { submission_index: submission, timeout: Some(TIMEOUT) };
        self.device.poll(wait).map(drop).map_err(|error| error.to_string())
    }

    /// Waits for everything submitted and maps the first `bytes` of a buffer.
    pub(crate) fn map(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
    ) -> Result<wgpu::BufferView, String> {
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            // The receiver is gone only when the wait below has failed already.
            let _ = sender.send(result);
        });
        self.wait(None)?;
        // Another thread that polls the same device may be the one that runs the callback.
        let mapped = receiver.recv_timeout(TIMEOUT).map_err(|error| error.to_string())?;
        mapped.map_err(|error| error.to_string())?;
        buffer.get_mapped_range(..bytes).map_err(|error| error.to_string())
    }
}
