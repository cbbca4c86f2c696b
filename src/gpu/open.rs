//! An open device with all that is kept for it: its programs, and how its arithmetic behaves.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::adapter::{AdapterFacts, adapters, choose};
use super::compile::{Edit, compile};
use super::device::DeviceFailure;
use super::drivers::install_hint;
use super::pipeline::Program;
use super::self_test::{self, Arithmetic};
use crate::error::{Error, Message, Result};
use crate::kernel::{FloatType, Kernel};
use crate::prepare::ShaderKey;
use crate::support::memory;

/// Programs that a device keeps: four kernels, with and without surfaces, near and far, and some more
/// for scenes that are edited and for cameras among many spheres.
const MOST_PROGRAMS: usize = 16;

/// A test's change of every shader that is passed through.
type EditSpirv = Box<dyn Fn(&[u32]) -> Vec<u32> + Send + Sync>;

/// An open device.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(super) errors: Arc<Mutex<Vec<DeviceFailure>>>,
    /// The adapter's own account of itself.
    pub facts: AdapterFacts,
    /// The last programs, compiled for scenes that need the same; the most recent one last.
    programs: Mutex<Vec<(ShaderKey, Arc<Program>)>>,
    arithmetic: OnceLock<Arithmetic>,
    arithmetic_f64: OnceLock<Option<Arithmetic>>,
    /// See [`Gpu::edit_shaders`].
    edit: Option<Edit>,
    /// See [`Gpu::edit_spirv`].
    edit_spirv: Option<EditSpirv>,
    /// See [`Gpu::always_lights`].
    always_lights: bool,
}

impl Gpu {
    /// Opens every Vulkan device, the best first; one that can't be opened comes with the reason.
    pub fn open_all() -> Vec<(AdapterFacts, Result<Gpu>)> {
        adapters()
            .into_iter()
            .map(|(adapter, facts)| {
                (facts.clone(), Gpu::open_within(&adapter, facts, adapter.limits()))
            })
            .collect()
    }

    /// Opens the best Vulkan device with `name` in its name, case ignored: the best of all where that is empty.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] when none fits, with the names of those that are there;
    /// [`Error::TooLarge`] where a limit of the address space leaves too little for a driver.
    pub fn open(name: &str) -> Result<Gpu> {
        memory::require_device()?;
        let (adapter, facts) = choose(adapters(), name)?;
        Gpu::open_within(&adapter, facts, adapter.limits())
    }

    /// Opens an adapter, with no more than these of its limits.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] when it can't be opened.
    pub(super) fn open_within(
        adapter: &wgpu::Adapter,
        facts: AdapterFacts,
        limits: wgpu::Limits,
    ) -> Result<Gpu> {
        let max_storage_buffers = limits.max_storage_buffers_per_shader_stage;
        let facts = AdapterFacts { max_storage_buffers, ..facts };
        let wanted = wgpu::Features::PASSTHROUGH_SHADERS | wgpu::Features::SHADER_F64;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("kugelblitz"),
            required_features: adapter.features() & wanted,
            required_limits: limits,
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|error| {
            let text = format!("`{}` cannot be opened: {error}", facts.name);
            Error::NoAdapter(Message::new(text, install_hint()))
        })?;
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&errors);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if let Ok(mut errors) = sink.lock() {
                errors.push(match error {
                    wgpu::Error::OutOfMemory { .. } => DeviceFailure::OutOfMemory,
                    error => DeviceFailure::Other(error.to_string()),
                });
            }
        }));
        let sink = Arc::clone(&errors);
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed
                && let Ok(mut errors) = sink.lock()
            {
                errors.push(DeviceFailure::Other(format!("device lost: {message}")));
            }
        });
        Ok(Gpu {
            device,
            queue,
            errors,
            facts,
            programs: Mutex::default(),
            arithmetic: OnceLock::new(),
            arithmetic_f64: OnceLock::new(),
            edit: None,
            edit_spirv: None,
            always_lights: false,
        })
    }

    fn programs(&self) -> MutexGuard<'_, Vec<(ShaderKey, Arc<Program>)>> {
        self.programs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn kept_program(&self, key: &ShaderKey) -> Option<Arc<Program>> {
        let mut programs = self.programs();
        let position = programs.iter().position(|(known, _)| known == key)?;
        let found = programs.remove(position);
        let program = Arc::clone(&found.1);
        programs.push(found);
        Some(program)
    }

    /// The program for `key`, compiled where it isn't kept. Other threads don't wait for that.
    ///
    /// # Errors
    /// Those of [`Program::new`].
    pub(super) fn program(&self, key: &ShaderKey) -> Result<Arc<Program>> {
        if let Some(program) = self.kept_program(key) {
            return Ok(program);
        }
        let shader = compile(key, self.edit.as_ref())?;
        let program = Arc::new(Program::new(self, &shader, "render")?);
        let mut programs = self.programs();
        if programs.len() == MOST_PROGRAMS {
            programs.remove(0);
        }
        programs.push((*key, Arc::clone(&program)));
        Ok(program)
    }

    /// Compiles every shader anew from now on, for those who measure that.
    pub fn forget_programs(&self) {
        self.programs().clear();
    }

    /// Puts the WGSL text of every scene's shader through `edit` from now on: tests spoil one, and
    /// see that it is noticed.
    #[doc(hidden)]
    pub fn edit_shaders(self, edit: impl Fn(&str) -> String + Send + Sync + 'static) -> Gpu {
        Gpu { edit: Some(Box::new(edit)), ..self }
    }

    /// Puts the words of every shader that is passed through, the self-test's too, through `edit` from now
    /// on: a stand-in for a driver that does otherwise than it should.
    #[doc(hidden)]
    pub fn edit_spirv(self, edit: impl Fn(&[u32]) -> Vec<u32> + Send + Sync + 'static) -> Gpu {
        Gpu { edit_spirv: Some(Box::new(edit)), ..self }
    }

    /// The words of a shader that is passed through, as they are but for a test's change.
    pub(super) fn edited(&self, words: Vec<u32>) -> Vec<u32> {
        match &self.edit_spirv {
            Some(edit) => edit(&words),
            None => words,
        }
    }

    /// Has the device light all pictures from now on that it can, also where the CPU would be quicker: tests see that it is
    /// right.
    #[doc(hidden)]
    pub fn always_lights(self) -> Gpu {
        Gpu { always_lights: true, ..self }
    }

    /// Whether a picture that a card would light sooner than the CPU is lit here: by a device in software the CPU would be quicker.
    pub(super) fn lights(&self, is_quicker: bool) -> bool {
        is_quicker && !self.facts.is_software() || self.always_lights
    }

    /// Takes this for what the device's f32 does.
    #[cfg(test)]
    pub(super) fn tell_arithmetic(self, arithmetic: Arithmetic) -> Gpu {
        Gpu { arithmetic: arithmetic.into(), ..self }
    }

    /// The behaviour of the device's f32, measured at the first call (a few milliseconds).
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails the test's run.
    pub fn arithmetic(&self) -> Result<Arithmetic> {
        if let Some(known) = self.arithmetic.get() {
            return Ok(*known);
        }
        let measured = self_test::measure::<f32>(self)?;
        Ok(*self.arithmetic.get_or_init(|| measured))
    }

    /// The behaviour of the device's f64, measured at the first call; `None` where it has none.
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails the test's run.
    pub fn arithmetic_f64(&self) -> Result<Option<Arithmetic>> {
        if let Some(known) = self.arithmetic_f64.get() {
            return Ok(*known);
        }
        let measured = self.facts.f64.then(|| self_test::measure::<f64>(self)).transpose()?;
        Ok(*self.arithmetic_f64.get_or_init(|| measured))
    }

    /// True where the arithmetic of `kernel` is the CPU's on this device, operation by operation, so
    /// that its results are bit-equal.
    ///
    /// # Errors
    /// [`Error::Device`] when the device fails the test's run.
    pub fn is_ieee(&self, kernel: Kernel) -> Result<bool> {
        match kernel.about().float {
            FloatType::F32 => Ok(self.arithmetic()?.is_ieee()),
            FloatType::F64 => Ok(self.arithmetic_f64()?.is_some_and(|found| found.is_ieee())),
        }
    }
}
