//! Compiled shaders, kept for scenes that need the same.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::compile::{Edit, Shader, compile_edited};
use super::device::OpenDevice;
use super::pipeline::{Bindings, pipeline};
use crate::error::Result;
use crate::prepare::ShaderKey;

/// Programs that a device keeps: four kernels, with and without surfaces, near and far, and some more
/// for scenes that are edited and for cameras among many spheres.
const MOST_PROGRAMS: usize = 16;

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
    pub fn new(device: &OpenDevice, shader: &Shader, entry_point: &str) -> Result<Program> {
        let bindings = Bindings::new(device, shader)?;
        let pipeline = pipeline(device, shader, entry_point, &bindings.layout)?;
        Ok(Program { bindings, pipeline })
    }
}

/// The last programs of a device.
#[derive(Default)]
pub struct Programs {
    /// The most recent one last.
    kept: Mutex<Vec<(ShaderKey, Arc<Program>)>>,
    edit: Option<Edit>,
}

impl Programs {
    /// Puts the WGSL text of all programs through `edit` from now on.
    pub fn edited(self, edit: Edit) -> Programs {
        Programs { edit: Some(edit), ..self }
    }

    /// Forgets all programs.
    pub fn forget(&self) {
        self.lock().clear();
    }

    /// The program for `key`, compiled where it isn't kept. Other threads don't wait for that.
    ///
    /// # Errors
    /// Those of [`Program::new`].
    pub fn program(&self, device: &OpenDevice, key: &ShaderKey) -> Result<Arc<Program>> {
        if let Some(program) = self.get(key) {
            return Ok(program);
        }
        let shader = compile_edited(key, self.edit.as_ref())?;
        let program = Arc::new(Program::new(device, &shader, "render")?);
        self.keep(*key, &program);
        Ok(program)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<(ShaderKey, Arc<Program>)>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn get(&self, key: &ShaderKey) -> Option<Arc<Program>> {
        let mut kept = self.lock();
        let position = kept.iter().position(|(known, _)| known == key)?;
        let found = kept.remove(position);
        let program = Arc::clone(&found.1);
        kept.push(found);
        Some(program)
    }

    fn keep(&self, key: ShaderKey, program: &Arc<Program>) {
        let mut kept = self.lock();
        if kept.len() == MOST_PROGRAMS {
            kept.remove(0);
        }
        kept.push((key, Arc::clone(program)));
    }
}
