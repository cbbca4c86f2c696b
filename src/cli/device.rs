//! Choosing where the rays are traced.

use std::sync::Arc;
use std::time::{Duration, Instant};

use kugelblitz::cpu::CpuTracer;
use kugelblitz::gpu::{AdapterFacts, Gpu, GpuTracer};
use kugelblitz::prepare::Prepared;
use kugelblitz::trace::{Kernel, Tracer, Wants};
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
    /// Opens what --device asks for. With a `kernel`, the device must be able to run it.
    ///
    /// # Errors
    /// [`Error::NoAdapter`], but for `auto`, which then takes the CPU and says so.
    pub fn open(choice: &DeviceChoice, kernel: Option<Kernel>, talk: &TalkArgs) -> Result<Device> {
        let Some(pick) = choice.pick() else { return Ok(Device::Cpu) };
        let start = Instant::now();
        let (opened, noise) = quietly(|| Gpu::open(&pick));
        let opened = opened.and_then(|gpu| for_kernel(gpu, kernel));
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

    /// Whether the arithmetic of `kernel` is that of the CPU, bit by bit.
    ///
    /// # Errors
    /// Those of [`Gpu::is_ieee`].
    pub fn is_ieee(&self, kernel: Kernel) -> Result<bool> {
        match self {
            Device::Gpu(gpu) => gpu.is_ieee(kernel),
            Device::Cpu => Ok(true),
        }
    }

    /// The device for one kernel of several: the CPU, with a warning, where this can't run it.
    pub fn or_cpu(&self, kernel: Kernel, talk: &TalkArgs) -> &Device {
        match self {
            Device::Gpu(gpu) => match gpu.facts.check_kernel(kernel) {
                Ok(()) => self,
                Err(reason) => {
                    talk.warn(&format!("`{}` on the CPU alone: {reason}", kernel.name()));
                    &Device::Cpu
                }
            },
            Device::Cpu => self,
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

fn for_kernel(gpu: Gpu, kernel: Option<Kernel>) -> Result<Gpu> {
    if let Some(kernel) = kernel {
        gpu.facts.check_kernel(kernel)?;
    }
    Ok(gpu)
}

#[cfg(test)]
mod tests {
    use kugelblitz::gpu::Pick;

    use super::*;

    /// No adapter here lacks f64, so one is made to.
    #[test]
    fn an_adapter_without_f64_leaves_the_f64_kernel_to_the_cpu() {
        let talk = TalkArgs { json: false, quiet: true, verbose: false };
        let open = |f64| {
            let mut gpu =
                Gpu::open(&Pick::Best).expect("a Vulkan device; ci/setup.sh installs one");
            gpu.facts.f64 = f64;
            gpu
        };
        for (f64, kernel) in
            [(false, Kernel::Double), (false, Kernel::Certified), (true, Kernel::Double)]
        {
            let runs = f64 || kernel != Kernel::Double;
            let refusal = for_kernel(open(f64), Some(kernel)).err();
            assert_eq!(refusal.as_ref().map(Error::exit_code), (!runs).then_some(4));
            let device = Device::Gpu(Arc::new(open(f64)));
            assert_eq!(matches!(device.or_cpu(kernel, &talk), Device::Gpu(_)), runs);
        }
        assert!(for_kernel(open(false), None).is_ok());
    }
}
