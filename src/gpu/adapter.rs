//! The Vulkan adapters of this machine.

use std::sync::{Mutex, PoisonError};

use super::drivers::no_device;
use crate::error::{Error, Hint, Message, Result, Setting};
use crate::kernel::{FloatType, Kernel};
use crate::plain::Shown;
use crate::support::memory;

/// Name, driver and limits of a Vulkan adapter, as it reports them.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AdapterFacts {
    /// Name of the adapter.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Name and version of the driver.
    pub driver: String,
    /// Whether shaders can be passed to the driver unchanged, which `NoContraction` needs.
    pub passthrough: bool,
    /// Whether shaders support f64.
    pub f64: bool,
    /// Maximum size of a storage binding, bytes.
    pub max_binding_bytes: u64,
    /// Maximum size of a buffer, bytes.
    pub max_buffer_bytes: u64,
    /// Maximum number of storage buffers of a shader.
    pub max_storage_buffers: u32,
    /// Maximum number of workgroups of a dispatch along one axis.
    pub max_workgroups: u32,
    /// Maximum number of columns or rows of a texture.
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
            max_storage_buffers: limits.max_storage_buffers_per_shader_stage,
            max_workgroups: limits.max_compute_workgroups_per_dimension,
            max_texture_side: limits.max_texture_dimension_2d,
        }
    }

    /// True where the "GPU" is a program on the CPU.
    pub fn is_software(&self) -> bool {
        self.kind == "software"
    }

    /// Makes sure that shaders of `kernel` run on this adapter.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] when they need what it lacks.
    pub fn check_kernel(&self, kernel: Kernel) -> Result<()> {
        if kernel.about().float == FloatType::F64 && !self.f64 {
            let text = format!(
                "the kernel `{}` needs f64 in shaders, which `{}` does not support",
                kernel.name(),
                self.name
            );
            let hint = Hint::new("use {} or another kernel", [Setting::text("device", "cpu")]);
            return Err(Error::NoAdapter(Message::new(text, hint)));
        }
        Ok(())
    }

    fn rank(&self) -> Option<usize> {
        ["discrete", "integrated", "virtual", "software", "other"]
            .iter()
            .position(|kind| *kind == self.kind)
    }
}

/// The Vulkan instance of this process: with one for each device, NVIDIA's driver is loaded and unloaded each time, and after
/// some forty times found no more. A fork makes its own, as the threads of a driver are not in it, and must not end the other.
/// `WGPU_VALIDATION=1` asks for Vulkan's validation layers, as in every program that uses wgpu.
fn instance() -> wgpu::Instance {
    static KEPT: Mutex<Option<(u32, wgpu::Instance)>> = Mutex::new(None);
    let process = std::process::id();
    let kept = || KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((owner, instance)) = &*kept()
        && *owner == process
    {
        return instance.clone();
    }
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN;
    descriptor.flags = descriptor.flags.with_env();
    let new = wgpu::Instance::new(descriptor);
    std::mem::forget(kept().replace((process, new.clone())));
    new
}

pub(super) fn adapters() -> Vec<(wgpu::Adapter, AdapterFacts)> {
    let found = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::VULKAN));
    let mut adapters: Vec<_> = found
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

/// Returns the adapter that [`Gpu::open`](super::Gpu::open) opens for `name` and `kernel`, without opening it.
///
/// # Errors
/// Returns the errors of [`Gpu::open`](super::Gpu::open) and [`AdapterFacts::check_kernel`].
pub fn find_adapter(name: &str, kernel: Kernel) -> Result<AdapterFacts> {
    memory::require_device()?;
    let (_, facts) = choose(adapters(), name)?;
    facts.check_kernel(kernel)?;
    Ok(facts)
}

/// True where a Vulkan adapter of this machine could only be a program on the CPU. Where no file of a
/// graphics card is there, no driver is asked: that alone takes longer than drawing a small picture.
pub fn has_software_alone() -> bool {
    let files = ["/dev/dri", "/dev/nvidiactl", "/dev/kfd", "/dev/dxg"];
    let may_have_hardware =
        !cfg!(target_os = "linux") || files.iter().any(|path| std::path::Path::new(path).exists());
    if !may_have_hardware {
        return true;
    }
    let adapters = adapters();
    !adapters.is_empty() && adapters.iter().all(|(_, facts)| facts.is_software())
}

/// The best adapter with `name` in its name, case ignored: of all where that is empty. The best one is discrete, then
/// integrated, virtual, software.
///
/// # Errors
/// [`Error::NoAdapter`] when none fits, with the names of those that are there.
pub(super) fn choose(
    mut adapters: Vec<(wgpu::Adapter, AdapterFacts)>,
    name: &str,
) -> Result<(wgpu::Adapter, AdapterFacts)> {
    let names: Vec<String> = adapters.iter().map(|(_, f)| format!("`{}`", f.name)).collect();
    if adapters.is_empty() {
        return Err(no_device());
    }
    let wanted = name.to_lowercase();
    let fits = |facts: &AdapterFacts| facts.name.to_lowercase().contains(&wanted);
    let position = adapters.iter().position(|(_, facts)| fits(facts)).ok_or_else(|| {
        Error::NoAdapter(
            format!(
                "no Vulkan device has `{}` in its name; there is {}",
                name.shown(),
                names.join(", ")
            )
            .into(),
        )
    })?;
    Ok(adapters.swap_remove(position))
}
