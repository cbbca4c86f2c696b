//! Choosing where the rays are traced.

use std::sync::Arc;
use std::time::Instant;

use kugelblitz::device::Device;
use kugelblitz::gpu::Gpu;
use kugelblitz::{Error, Result};

use super::TalkArgs;
use super::options::DeviceChoice;
use super::output::human;
use super::quiet::{self, quietly};

/// Opens what --device asks for.
///
/// # Errors
/// [`Error::NoAdapter`], but for `auto`, which then takes the CPU and says so.
pub fn open(choice: &DeviceChoice, talk: &TalkArgs) -> Result<Device> {
    let Some(pick) = choice.pick() else { return Ok(Device::Cpu) };
    let start = Instant::now();
    let (opened, noise) = quietly(|| Gpu::open(&pick));
    let falls_back = *choice == DeviceChoice::Auto;
    if talk.verbose || opened.is_err() && !falls_back {
        quiet::show(&noise, talk.verbose);
    }
    match opened {
        Ok(gpu) => {
            talk.note(&format!(
                "opened {} ({}, {}) in {}",
                gpu.facts.name,
                gpu.facts.kind,
                gpu.facts.driver,
                human(start.elapsed())
            ));
            if !gpu.arithmetic()?.suits_filter() {
                talk.warn(&format!(
                    "the arithmetic of {} does not suit the proof of `certified`: the CPU takes \
                     its f32 stage (see `kugelblitz probe`)",
                    gpu.facts.name
                ));
            }
            Ok(Device::Gpu(Arc::new(gpu)))
        }
        Err(Error::NoAdapter(reason)) if falls_back => {
            talk.warn(&format!("tracing on the CPU: {reason}"));
            Ok(Device::Cpu)
        }
        Err(error) => Err(error),
    }
}
