//! Choosing where the rays are traced.

use std::sync::Arc;
use std::time::{Duration, Instant};

use kugelblitz::cpu::CpuTracer;
use kugelblitz::gpu::{AdapterFacts, Gpu, GpuTracer};
use kugelblitz::prepare::Prepared;
use kugelblitz::trace::{Tracer, Wants};
use kugelblitz::{Error, Result};

use super::TalkArgs;
use super::options::DeviceChoice;
use super::output::human;
use super::quiet::{self, quietly};

/// What traces the rays.
pub enum Device {
    /// A Vulkan device.
    Gpu(Arc<Gpu>),
    /// The CPU reference.
    Cpu,
}

/// A tracer and what it took to make it.
pub struct Made {
    pub tracer: Box<dyn Tracer>,
    pub compile: Duration,
    pub upload: Duration,
}

impl Device {
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
                        "the arithmetic of {} does not suit the proof of `certified`: the CPU \
                         takes its f32 stage (see `kugelblitz probe`)",
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

    /// A tracer for a prepared scene.
    ///
    /// # Errors
    /// Those of [`GpuTracer::new`].
    pub fn tracer(&self, prepared: &Arc<Prepared>, wants: Wants) -> Result<Made> {
        let prepared = Arc::clone(prepared);
        match self {
            Device::Gpu(gpu) => {
                let tracer = GpuTracer::new(Arc::clone(gpu), prepared, wants)?;
                let (compile, upload) = (tracer.compile_time, tracer.upload_time);
                Ok(Made { tracer: Box::new(tracer), compile, upload })
            }
            Device::Cpu => Ok(Made {
                tracer: Box::new(CpuTracer::new(prepared, wants)),
                compile: Duration::ZERO,
                upload: Duration::ZERO,
            }),
        }
    }

    /// What the adapter says about itself; `None` for the CPU.
    pub fn facts(&self) -> Option<&AdapterFacts> {
        match self {
            Device::Gpu(gpu) => Some(&gpu.facts),
            Device::Cpu => None,
        }
    }

    /// Whether the device's f32 is that of the CPU, bit by bit.
    ///
    /// # Errors
    /// Those of [`Gpu::arithmetic`].
    pub fn is_ieee(&self) -> Result<bool> {
        match self {
            Device::Gpu(gpu) => Ok(gpu.arithmetic()?.is_ieee()),
            Device::Cpu => Ok(true),
        }
    }

    /// `gpu` or `cpu`.
    pub fn kind(&self) -> &'static str {
        match self {
            Device::Gpu(_) => "gpu",
            Device::Cpu => "cpu",
        }
    }

    /// For a line of talk; a software adapter is called one.
    pub fn label(&self) -> String {
        match self.facts() {
            Some(facts) if facts.is_software() => format!("{} (software)", facts.name),
            Some(facts) => facts.name.clone(),
            None => "the CPU".into(),
        }
    }
}
