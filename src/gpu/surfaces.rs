//! `t` and normals of hits on the device.

use std::sync::Arc;

use super::before::{self, InF64};
use super::hierarchy::DeviceHierarchy;
use super::objects::{fits_in_f64, params_buffer, storage_in_f64};
use super::open::Gpu;
use super::pipeline::Named;
use super::program::Program;
use crate::error::{Error, Result};
use crate::kernel::Float;
use crate::prepare::Prepared;
use crate::rays::Bundle;
use crate::trace::Wants;

/// The second step of a dispatch where hits are completed.
pub struct Surfaces {
    pub program: Arc<Program>,
    pub params: wgpu::Buffer,
    pub objects: Vec<Named>,
}

impl Surfaces {
    /// `None` where the CPU completes hits.
    pub fn new(
        gpu: &Gpu,
        prepared: &Prepared,
        wants: Wants,
        hierarchy: Option<&DeviceHierarchy>,
    ) -> Result<Option<Surfaces>> {
        let is_picture = prepared.bundle() != Bundle::Free;
        let is_wanted = wants.surface && is_picture && before::suits_device(prepared);
        if !(is_wanted && fits_in_f64(gpu, prepared) && gpu.completes()?) {
            return Ok(None);
        }
        let numbers = InF64::new(prepared);
        let mut objects = storage_in_f64(gpu, prepared, &numbers, hierarchy);
        if !prepared.scene.planes.is_empty() {
            let units = numbers.units(prepared);
            objects.push(("units", gpu.storage("units", bytemuck::cast_slice(&units))));
        }
        let program = match gpu.program(&numbers.surface_key(prepared)) {
            // The device binds too few buffers at once.
            Err(Error::TooLarge(_)) => return Ok(None),
            program => program?,
        };
        Ok(Some(Surfaces { program, params: params_buffer(gpu, Float::F64), objects }))
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.params.size() + self.objects.iter().map(|(_, buffer)| buffer.size()).sum::<u64>()
    }
}
