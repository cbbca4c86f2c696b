//! Finding and opening a Vulkan device.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use super::compile::Edit;
use super::program::Programs;
use super::self_test::{self, Arithmetic};
use crate::error::{Error, Result};
use crate::memory;
use crate::trace::Kernel;

/// What to say when no device is there.
const INSTALL_HINT: &str = "install a Vulkan driver (Debian: `apt install mesa-vulkan-drivers` \
                            brings a software one) or use `--device cpu`";

/// Which adapter to open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pick {
    /// The best one: discrete, then integrated, virtual, software.
    Best,
    /// One whose name contains this text, case ignored.
    Named(String),
}

/// What an adapter says about itself.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AdapterFacts {
    /// The adapter's name.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Driver name and version.
    pub driver: String,
    /// Whether shaders can be passed through, which `NoContraction` needs.
    pub passthrough: bool,
    /// Whether shaders may use f64.
    pub f64: bool,
    /// Largest storage buffer that one binding takes, bytes.
    pub max_binding_bytes: u64,
    /// Largest buffer, bytes.
    pub max_buffer_bytes: u64,
    /// Workgroups that one dispatch takes along one axis.
    pub max_workgroups: u32,
    /// Columns or rows of a texture.
    pub max_texture_side: u32,
}

impl AdapterFacts {
    fn new(adapter: &wgpu::Adapter) -> AdapterFacts {
        let info = adapter.get_info();
        let limits = adapter.limits();
        let features = adapter.features();
        AdapterFacts {
            name: info.name,
            kind: match info.device_type {
                wgpu::DeviceType::DiscreteGpu => "discrete",
                wgpu::DeviceType::IntegratedGpu => "integrated",
                wgpu::DeviceType::VirtualGpu => "virtual",
                wgpu::DeviceType::Cpu => "software",
                wgpu::DeviceType::Other => "other",
            },
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
            passthrough: features.contains(wgpu::Features::PASSTHROUGH_SHADERS),
            f64: features.contains(wgpu::Features::SHADER_F64),
            max_binding_bytes: limits.max_storage_buffer_binding_size,
            max_buffer_bytes: limits.max_buffer_size,
            max_workgroups: limits.max_compute_workgroups_per_dimension,
            max_texture_side: limits.max_texture_dimension_2d,
        }
    }

    /// Whether the "GPU" is a program on the CPU.
    pub fn is_software(&self) -> bool {
        self.kind == "software"
    }

    /// Whether shaders of `kernel` run on this adapter.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] when they need what it lacks.
    pub fn check_kernel(&self, kernel: Kernel) -> Result<()> {
        if kernel == Kernel::Double && !self.f64 {
            return Err(Error::NoAdapter(format!(
                "`{}` has no f64 in its shaders, which the kernel `{}` needs: use `--device cpu`, \
                 or another kernel",
                self.name,
                kernel.name()
            )));
        }
        Ok(())
    }

    fn rank(&self) -> u8 {
        match self.kind {
            "discrete" => 0,
            "integrated" => 1,
            "virtual" => 2,
            "software" => 3,
            _ => 4,
        }
    }
}

/// What a device reported on its own.
enum Failure {
    OutOfMemory,
    Other(String),
}

/// An open device.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    errors: Arc<Mutex<Vec<Failure>>>,
    arithmetic: OnceLock<Arithmetic>,
    /// Held while commands are handed over: a surface must not be configured meanwhile.
    handing_over: Mutex<()>,
    pub(super) programs: Programs,
    pub(super) edit: Option<Edit>,
    /// What the adapter says about itself.
    pub facts: AdapterFacts,
}

/// `WGPU_VALIDATION=1` asks for Vulkan's validation layers, as in every program that uses wgpu.
pub(super) fn instance(descriptor: wgpu::InstanceDescriptor) -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::VULKAN,
        flags: descriptor.flags.with_env(),
        ..descriptor
    })
}

fn adapters() -> Vec<(wgpu::Adapter, AdapterFacts)> {
    adapters_of(&instance(wgpu::InstanceDescriptor::new_without_display_handle()))
}

pub(super) fn adapters_of(instance: &wgpu::Instance) -> Vec<(wgpu::Adapter, AdapterFacts)> {
    let mut adapters: Vec<_> =
        pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN))
            .into_iter()
            .map(|adapter| {
                let facts = AdapterFacts::new(&adapter);
                (adapter, facts)
            })
            .collect();
    adapters.sort_by_key(|(_, facts)| facts.rank());
    adapters
}

/// All Vulkan adapters, the best first.
pub fn list_adapters() -> Vec<AdapterFacts> {
    adapters().into_iter().map(|(_, facts)| facts).collect()
}

impl Gpu {
    /// Opens every Vulkan device, the best first; one that can't be opened comes with the reason.
    pub fn open_all() -> Vec<(AdapterFacts, Result<Gpu>)> {
        adapters()
            .into_iter()
            .map(|(adapter, facts)| (facts.clone(), Gpu::from_adapter(&adapter, facts)))
            .collect()
    }

    /// Opens a Vulkan device.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] when none fits, with the names of those that are there;
    /// [`Error::TooLarge`] where a limit of the address space leaves too little for a driver.
    pub fn open(pick: &Pick) -> Result<Gpu> {
        memory::require_device()?;
        let (adapter, facts) = Gpu::choose(adapters(), pick)?;
        Gpu::from_adapter(&adapter, facts)
    }

    pub(super) fn choose(
        mut adapters: Vec<(wgpu::Adapter, AdapterFacts)>,
        pick: &Pick,
    ) -> Result<(wgpu::Adapter, AdapterFacts)> {
        let names: Vec<String> = adapters.iter().map(|(_, f)| format!("`{}`", f.name)).collect();
        if adapters.is_empty() {
            return Err(Error::NoAdapter(format!("no Vulkan device found: {INSTALL_HINT}")));
        }
        let position = match pick {
            Pick::Best => 0,
            Pick::Named(name) => {
                let wanted = name.to_lowercase();
                let fits = |facts: &AdapterFacts| facts.name.to_lowercase().contains(&wanted);
                adapters.iter().position(|(_, facts)| fits(facts)).ok_or_else(|| {
                    Error::NoAdapter(format!(
                        "no Vulkan device has `{name}` in its name; there is {}",
                        names.join(", ")
                    ))
                })?
            }
        };
        Ok(adapters.swap_remove(position))
    }

    pub(super) fn from_adapter(adapter: &wgpu::Adapter, facts: AdapterFacts) -> Result<Gpu> {
        let wanted = wgpu::Features::PASSTHROUGH_SHADERS
            | wgpu::Features::SHADER_F64
            | wgpu::Features::TIMESTAMP_QUERY;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("kugelblitz"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|error| {
            Error::NoAdapter(format!("`{}` can't be opened: {error}; {INSTALL_HINT}", facts.name))
        })?;
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&errors);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if let Ok(mut errors) = sink.lock() {
                errors.push(match error {
                    wgpu::Error::OutOfMemory { .. } => Failure::OutOfMemory,
                    error => Failure::Other(error.to_string()),
                });
            }
        }));
        let sink = Arc::clone(&errors);
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed
                && let Ok(mut errors) = sink.lock()
            {
                errors.push(Failure::Other(format!("device lost: {message}")));
            }
        });
        Ok(Gpu {
            device,
            queue,
            errors,
            arithmetic: OnceLock::new(),
            handing_over: Mutex::new(()),
            programs: Programs::default(),
            edit: None,
            facts,
        })
    }

    /// While this is held, no other thread hands over commands.
    pub(crate) fn hold(&self) -> MutexGuard<'_, ()> {
        self.handing_over.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands commands over to the device.
    pub(crate) fn submit(&self, commands: wgpu::CommandBuffer) -> wgpu::SubmissionIndex {
        let _held = self.hold();
        self.queue.submit([commands])
    }

    /// Fails with the first error that the device has reported since it was opened.
    ///
    /// # Errors
    /// [`Error::Device`]
    pub(crate) fn check(&self) -> Result<()> {
        let errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        match errors.first() {
            Some(Failure::Other(error)) => {
                Err(Error::Device(format!("`{}`: {error}", self.facts.name)))
            }
            Some(Failure::OutOfMemory) => Err(Error::TooLarge(format!(
                "`{}` has too little memory for this; use fewer objects or `--device cpu`",
                self.facts.name
            ))),
            None => Ok(()),
        }
    }

    /// Puts the WGSL text of every scene's shader through `edit` from now on: tests spoil one, and
    /// see that it is noticed.
    #[doc(hidden)]
    pub fn edit_shaders(self, edit: impl Fn(&str) -> String + Send + Sync + 'static) -> Gpu {
        Gpu { edit: Some(Box::new(edit)), ..self }
    }

    /// Takes this for what the device's f32 does.
    #[cfg(test)]
    pub(super) fn tell_arithmetic(self, arithmetic: Arithmetic) -> Gpu {
        Gpu { arithmetic: arithmetic.into(), ..self }
    }

    /// What the device's f32 really does, measured at the first call (a few milliseconds).
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails the test's run.
    pub fn arithmetic(&self) -> Result<Arithmetic> {
        if let Some(known) = self.arithmetic.get() {
            return Ok(*known);
        }
        let measured = self_test::test_f32(self)?;
        Ok(*self.arithmetic.get_or_init(|| measured))
    }

    /// What the device's f64 really does; `None` where it has none.
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails the test's run.
    pub fn arithmetic_f64(&self) -> Result<Option<Arithmetic>> {
        self.facts.f64.then(|| self_test::test_f64(self)).transpose()
    }

    /// Whether the arithmetic of `kernel` is the CPU's on this device, operation by operation, so
    /// that its results are bit-equal.
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails the test's run.
    pub fn is_ieee(&self, kernel: Kernel) -> Result<bool> {
        match kernel {
            Kernel::Lecture | Kernel::Stable | Kernel::Certified => {
                Ok(self.arithmetic()?.is_ieee())
            }
            Kernel::Double => Ok(self.arithmetic_f64()?.is_some_and(|found| found.is_ieee())),
        }
    }

    /// Waits until the device is done with `submission`.
    pub(crate) fn wait(
        &self,
        submission: wgpu::SubmissionIndex,
        timeout: Duration,
    ) -> Result<(), String> {
        let wait =
            wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(timeout) };
        self.device.poll(wait).map(drop).map_err(|error| error.to_string())
    }

    /// Waits for everything submitted and maps the first `bytes` of a buffer.
    pub(crate) fn map(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        timeout: Duration,
    ) -> Result<wgpu::BufferView, String> {
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            // The receiver is gone only when the wait below has failed already.
            let _ = sender.send(result);
        });
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(timeout) };
        self.device.poll(wait).map_err(|error| error.to_string())?;
        // Another thread that polls the same device may be the one that runs the callback.
        let mapped = receiver.recv_timeout(timeout).map_err(|error| error.to_string())?;
        mapped.map_err(|error| error.to_string())?;
        buffer.get_mapped_range(..bytes).map_err(|error| error.to_string())
    }
}
