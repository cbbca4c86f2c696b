//! Compiled shaders, kept for scenes that need the same.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::compile::{Edit, Shader, compile_edited};
use super::device::OpenDevice;
use super::pipeline::{bind_group_layout, pipeline};
use crate::error::{Error, Result};
use crate::prepare::ShaderKey;

/// Programs that a device keeps: four kernels, with and without surfaces, near and far, and some more
/// for scenes that are edited and for cameras among many spheres.
const MOST_PROGRAMS: usize = 16;

/// A shader, ready to run.
pub struct Program {
    pub bind_group_layout: wgpu::BindGroupLayout,
    pub pipeline: wgpu::ComputePipeline,
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
    /// [`Error::Shader`] when the device refuses the shader, [`Error::TooLarge`] when it has too few bindings
    /// for it.
    pub fn program(&self, device: &OpenDevice, key: &ShaderKey) -> Result<Arc<Program>> {
        if let Some(program) = self.get(key) {
            return Ok(program);
        }
        let shader = compile_edited(key, self.edit.as_ref())?;
        check_bindings(device, &shader)?;
        let bind_group_layout = bind_group_layout(&device.device, &shader);
        let pipeline = pipeline(device, &shader, "render", &bind_group_layout)?;
        let program = Arc::new(Program { bind_group_layout, pipeline });
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

/// Refuses a shader with more storage buffers than the device takes; Vulkan asks for four of it.
fn check_bindings(device: &OpenDevice, shader: &Shader) -> Result<()> {
    let is_storage = |variable: &naga::GlobalVariable| {
        matches!(variable.space, naga::AddressSpace::Storage { .. })
    };
    let variables = shader.module.global_variables.iter();
    let needed = variables.filter(|(_, variable)| is_storage(variable)).count();
    let most = device.facts.max_storage_buffers as usize;
    if needed > most {
        return Err(Error::TooLarge(format!(
            "a shader of this scene reads and writes {needed} buffers; `{}` binds at most {most} at \
             once: use `--device cpu`",
            device.facts.name
        )));
    }
    Ok(())
}
