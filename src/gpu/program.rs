//! Compiled shaders, kept for scenes that need the same.

use std::sync::{Arc, Mutex, PoisonError};

use super::adapter::Gpu;
use super::compile::compile_edited;
use super::pipeline::{bind_group_layout, pipeline};
use crate::error::Result;
use crate::prepare::Needs;

/// Programs that a device keeps: four kernels, with and without surfaces, near and far, and some more
/// for scenes that are edited and for cameras among many spheres.
const MOST_PROGRAMS: usize = 16;

/// The shader for some needs, ready to run.
pub struct Program {
    pub bind_group_layout: wgpu::BindGroupLayout,
    pub pipeline: wgpu::ComputePipeline,
}

/// The last programs of a device, the most recent one last.
#[derive(Default)]
pub struct Programs(Mutex<Vec<(Needs, Arc<Program>)>>);

impl Programs {
    fn get(&self, needs: &Needs) -> Option<Arc<Program>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let position = kept.iter().position(|(known, _)| known == needs)?;
        let found = kept.remove(position);
        let program = Arc::clone(&found.1);
        kept.push(found);
        Some(program)
    }

    fn keep(&self, needs: Needs, program: &Arc<Program>) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() == MOST_PROGRAMS {
            kept.remove(0);
        }
        kept.push((needs, Arc::clone(program)));
    }
}

impl Gpu {
    /// Compiles every shader anew from now on, for those who measure that.
    pub fn forget_programs(&self) {
        self.programs.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// The program for `needs`, compiled where it isn't kept. Other threads don't wait for that.
    ///
    /// # Errors
    /// [`crate::Error::Shader`] when the device refuses the shader.
    pub(super) fn program(&self, needs: &Needs) -> Result<Arc<Program>> {
        if let Some(program) = self.programs.get(needs) {
            return Ok(program);
        }
        let shader = compile_edited(needs, self.edit.as_ref())?;
        let bind_group_layout = bind_group_layout(&self.device, &shader);
        let pipeline = pipeline(self, &shader, "render", &bind_group_layout)?;
        let program = Arc::new(Program { bind_group_layout, pipeline });
        self.programs.keep(*needs, &program);
        Ok(program)
    }
}
