//! Compiled shaders.

use super::compile::Shader;
use super::open::Gpu;
use super::pipeline::{Bindings, pipeline};
use crate::error::Result;

/// A shader, ready to run.
pub struct Program {
    pub bindings: Bindings,
    pub pipeline: wgpu::ComputePipeline,
}

impl Program {
    /// Makes the program of a shader with this entry point.
    ///
    /// # Errors
    /// [`Error::Shader`](crate::Error::Shader) when the device refuses it, [`Error::TooLarge`](crate::Error::TooLarge) when it
    /// has too few bindings for it.
    pub fn new(device: &Gpu, shader: &Shader, entry_point: &str) -> Result<Program> {
        let bindings = Bindings::new(device, shader)?;
        let pipeline = pipeline(device, shader, entry_point, &bindings.layout)?;
        Ok(Program { bindings, pipeline })
    }
}
