//! Where rays are traced: a Vulkan device or the CPU.

#[cfg(feature = "gpu")]
mod choice;

use std::sync::Arc;
use std::time::Duration;

use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::gpu::{AdapterFacts, Gpu, GpuTracer};
use crate::prepare::Prepared;
#[cfg(feature = "gpu")]
use crate::query::Kernel;
use crate::query::Outputs;
use crate::tracer::Tracer;

#[cfg(feature = "gpu")]
pub use choice::{ADAPTER_VARIABLE, DeviceChoice, rays_of_picture, why_auto_takes_the_cpu};

/// The place where rays are traced.
#[derive(Clone)]
pub enum Device {
    /// A Vulkan device.
    #[cfg(feature = "gpu")]
    Gpu(Arc<Gpu>),
    /// The CPU reference.
    Cpu,
}

/// A tracer and what it took to make it.
pub struct Made {
    /// The tracer.
    pub tracer: Tracer,
    /// Time to put together and compile the shader; zero on the CPU.
    pub compile: Duration,
    /// Time to hand the scene to the device; zero on the CPU.
    pub upload: Duration,
}

impl Device {
    /// The best Vulkan device where there is one, else the CPU. To choose, open a
    /// `gpu::Gpu`.
    pub fn best() -> Device {
        #[cfg(feature = "gpu")]
        if let Ok(gpu) = Gpu::open("") {
            return Device::Gpu(Arc::new(gpu));
        }
        Device::Cpu
    }

    /// A tracer for a prepared scene.
    ///
    /// # Errors
    /// Those of [`GpuTracer::new`].
    pub fn tracer(&self, prepared: &Arc<Prepared>, wants: Outputs) -> Result<Made> {
        let prepared = Arc::clone(prepared);
        match self {
            #[cfg(feature = "gpu")]
            Device::Gpu(gpu) => {
                let backend = GpuTracer::new(Arc::clone(gpu), Arc::clone(&prepared), wants)?;
                let (compile, upload) = (backend.compile_time, backend.upload_time);
                Ok(Made { tracer: Tracer::on(backend, prepared, wants), compile, upload })
            }
            Device::Cpu => Ok(Made {
                tracer: Tracer::on_cpu(prepared, wants),
                compile: Duration::ZERO,
                upload: Duration::ZERO,
            }),
        }
    }

    /// The adapter's own account of itself; `None` for the CPU.
    #[cfg(feature = "gpu")]
    pub fn facts(&self) -> Option<&AdapterFacts> {
        match self {
            Device::Gpu(gpu) => Some(&gpu.facts),
            Device::Cpu => None,
        }
    }

    /// The kernels that it runs: all but those in f64 where shaders have none.
    #[cfg(feature = "gpu")]
    pub fn kernels(&self) -> Vec<Kernel> {
        let runs = |kernel| self.facts().is_none_or(|facts| facts.check_kernel(kernel).is_ok());
        Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)).collect()
    }

    /// True where the arithmetic of `kernel` is that of the CPU, bit by bit.
    ///
    /// # Errors
    /// Those of [`Gpu::is_ieee`].
    #[cfg(feature = "gpu")]
    pub fn is_ieee(&self, kernel: Kernel) -> Result<bool> {
        match self {
            Device::Gpu(gpu) => gpu.is_ieee(kernel),
            Device::Cpu => Ok(true),
        }
    }

    /// `gpu` or `cpu`.
    pub fn kind(&self) -> &'static str {
        match self {
            #[cfg(feature = "gpu")]
            Device::Gpu(_) => "gpu",
            Device::Cpu => "cpu",
        }
    }

    /// For a line of talk; a software adapter is called one.
    pub fn label(&self) -> String {
        match self {
            #[cfg(feature = "gpu")]
            Device::Gpu(gpu) if gpu.facts.is_software() => format!("{} (software)", gpu.facts.name),
            #[cfg(feature = "gpu")]
            Device::Gpu(gpu) => gpu.facts.name.clone(),
            Device::Cpu => "the CPU".into(),
        }
    }
}
