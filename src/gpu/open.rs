//! An open device with all that is kept for it: its programs, and how its arithmetic behaves.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, OnceLock};

use super::adapter::{AdapterFacts, adapters, choose};
use super::device::OpenDevice;
use super::program::{Program, Programs};
use super::self_test::{self, Arithmetic};
use crate::error::Result;
use crate::kernel::{FloatType, Kernel};
use crate::memory;
use crate::prepare::ShaderKey;

/// An open device.
pub struct Gpu {
    bare: OpenDevice,
    programs: Programs,
    arithmetic: OnceLock<Arithmetic>,
    arithmetic_f64: OnceLock<Option<Arithmetic>>,
    /// See [`Gpu::always_lights`].
    always_lights: bool,
}

impl Deref for Gpu {
    type Target = OpenDevice;

    fn deref(&self) -> &OpenDevice {
        &self.bare
    }
}

impl DerefMut for Gpu {
    fn deref_mut(&mut self) -> &mut OpenDevice {
        &mut self.bare
    }
}

impl Gpu {
    /// Opens every Vulkan device, the best first; one that can't be opened comes with the reason.
    pub fn open_all() -> Vec<(AdapterFacts, Result<Gpu>)> {
        adapters()
            .into_iter()
            .map(|(adapter, facts)| (facts.clone(), Gpu::open_adapter(&adapter, facts)))
            .collect()
    }

    /// Opens the best Vulkan device with `name` in its name, case ignored: the best of all where that is empty.
    ///
    /// # Errors
    /// [`crate::Error::NoAdapter`] when none fits, with the names of those that are there;
    /// [`crate::Error::TooLarge`] where a limit of the address space leaves too little for a driver.
    pub fn open(name: &str) -> Result<Gpu> {
        memory::require_device()?;
        let (adapter, facts) = choose(adapters(), name)?;
        Gpu::open_adapter(&adapter, facts)
    }

    pub(super) fn open_adapter(adapter: &wgpu::Adapter, facts: AdapterFacts) -> Result<Gpu> {
        let bare = OpenDevice::open(adapter, facts)?;
        Ok(Gpu {
            bare,
            programs: Programs::default(),
            arithmetic: OnceLock::new(),
            arithmetic_f64: OnceLock::new(),
            always_lights: false,
        })
    }

    /// The program for `key`, compiled where it isn't kept. Other threads don't wait for that.
    ///
    /// # Errors
    /// [`crate::Error::Shader`] when the device refuses the shader.
    pub(super) fn program(&self, key: &ShaderKey) -> Result<Arc<Program>> {
        self.programs.program(&self.bare, key)
    }

    /// Compiles every shader anew from now on, for those who measure that.
    pub fn forget_programs(&self) {
        self.programs.forget();
    }

    /// Puts the WGSL text of every scene's shader through `edit` from now on: tests spoil one, and
    /// see that it is noticed.
    #[doc(hidden)]
    pub fn edit_shaders(self, edit: impl Fn(&str) -> String + Send + Sync + 'static) -> Gpu {
        Gpu { programs: self.programs.edited(Box::new(edit)), ..self }
    }

    /// Puts the words of every shader that is passed through, the self-test's too, through `edit` from now
    /// on: a stand-in for a driver that does otherwise than it should.
    #[doc(hidden)]
    pub fn edit_spirv(mut self, edit: impl Fn(&[u32]) -> Vec<u32> + Send + Sync + 'static) -> Gpu {
        self.bare.edit_spirv = Some(Box::new(edit));
        self
    }

    /// Has the device light all pictures from now on that it can, also where the CPU would be quicker: tests see that it is
    /// right.
    #[doc(hidden)]
    pub fn always_lights(self) -> Gpu {
        Gpu { always_lights: true, ..self }
    }

    /// Whether pictures are lit here: by a device in software the CPU would be quicker.
    pub(super) fn lights(&self) -> bool {
        !self.facts.is_software() || self.always_lights
    }

    /// Takes this for what the device's f32 does.
    #[cfg(test)]
    pub(super) fn tell_arithmetic(self, arithmetic: Arithmetic) -> Gpu {
        Gpu { arithmetic: arithmetic.into(), ..self }
    }

    /// The behaviour of the device's f32, measured at the first call (a few milliseconds).
    ///
    /// # Errors
    /// [`crate::Error::Device`] when the device fails the test's run.
    pub fn arithmetic(&self) -> Result<Arithmetic> {
        if let Some(known) = self.arithmetic.get() {
            return Ok(*known);
        }
        let measured = self_test::measure::<f32>(&self.bare)?;
        Ok(*self.arithmetic.get_or_init(|| measured))
    }

    /// The behaviour of the device's f64, measured at the first call; `None` where it has none.
    ///
    /// # Errors
    /// [`crate::Error::Device`] when the device fails the test's run.
    pub fn arithmetic_f64(&self) -> Result<Option<Arithmetic>> {
        if let Some(known) = self.arithmetic_f64.get() {
            return Ok(*known);
        }
        let measured = self.facts.f64.then(|| self_test::measure::<f64>(&self.bare)).transpose()?;
        Ok(*self.arithmetic_f64.get_or_init(|| measured))
    }

    /// True where the arithmetic of `kernel` is the CPU's on this device, operation by operation, so
    /// that its results are bit-equal.
    ///
    /// # Errors
    /// [`crate::Error::Device`] when the device fails the test's run.
    pub fn is_ieee(&self, kernel: Kernel) -> Result<bool> {
        match kernel.about().float {
            FloatType::F32 => Ok(self.arithmetic()?.is_ieee()),
            FloatType::F64 => Ok(self.arithmetic_f64()?.is_some_and(|found| found.is_ieee())),
        }
    }
}
