//! Choosing where rays are traced.

use std::env;

use super::Device;
use crate::error::{Error, Message, Result};
use crate::gpu::{Gpu, are_at_hand, has_software_alone};
use crate::prepare::FEW_SPHERES;
use crate::query::Kernel;
use crate::scene::{Samples, Scene};

/// Names an adapter, as it does for other programs that use wgpu.
pub const ADAPTER_VARIABLE: &str = "WGPU_ADAPTER_NAME";

/// What a user may ask for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum DeviceChoice {
    /// A GPU in hardware, else the quicker one of the CPU and a device in software.
    Auto,
    /// The best adapter.
    Gpu,
    /// The CPU.
    Cpu,
    /// The adapter with this in its name.
    Named(String),
}

impl DeviceChoice {
    /// Reads `auto`, `gpu`, `cpu`, or a part of an adapter's name.
    ///
    /// # Errors
    /// [`Error::Usage`] for an empty text.
    pub fn parse(text: &str) -> Result<DeviceChoice> {
        Ok(match text {
            "auto" => DeviceChoice::Auto,
            "gpu" => DeviceChoice::Gpu,
            "cpu" => DeviceChoice::Cpu,
            "" => {
                let message = "give auto, gpu, cpu, or a part of an adapter's name";
                return Err(Error::Usage(message.into()));
            }
            name => DeviceChoice::Named(name.into()),
        })
    }

    /// True for `auto` where [`ADAPTER_VARIABLE`] names no adapter either.
    pub fn is_free(&self) -> bool {
        let is_named = env::var(ADAPTER_VARIABLE).is_ok_and(|name| !name.is_empty());
        *self == DeviceChoice::Auto && !is_named
    }

    /// The name of the adapter to open, as [`Gpu::open`] takes it; `None` for the CPU.
    pub fn adapter(&self) -> Option<String> {
        match self {
            DeviceChoice::Cpu => None,
            DeviceChoice::Named(name) => Some(name.clone()),
            DeviceChoice::Auto | DeviceChoice::Gpu => {
                Some(env::var(ADAPTER_VARIABLE).unwrap_or_default())
            }
        }
    }

    /// Why the CPU is taken for so many rays into so many spheres, if this is a free `auto` and
    /// [`why_auto_takes_the_cpu`].
    pub fn why_the_cpu(&self, kernel: Kernel, n_spheres: usize, n_rays: usize) -> Option<String> {
        self.is_free().then(|| why_auto_takes_the_cpu(kernel, n_spheres, n_rays)).flatten()
    }

    /// The device, which runs `kernel` where one is given, and has looked at its arithmetic: what that can't bind, no
    /// kernel can. `auto` takes the CPU where there is no such adapter; the text says why.
    ///
    /// # Errors
    /// Those of [`Gpu::open`] and [`Gpu::arithmetic`]; [`Error::NoAdapter`] for a kernel that the device can't run.
    pub fn open(&self, kernel: Option<Kernel>) -> Result<(Device, Option<Message>)> {
        let Some(name) = self.adapter() else { return Ok((Device::Cpu, None)) };
        let open = || {
            let gpu = Gpu::open(&name)?;
            kernel.map_or(Ok(()), |kernel| gpu.facts.check_kernel(kernel))?;
            gpu.arithmetic()?;
            Ok(gpu)
        };
        match open() {
            Ok(gpu) => Ok((Device::Gpu(gpu.into()), None)),
            Err(Error::NoAdapter(why) | Error::TooLarge(why)) if *self == DeviceChoice::Auto => {
                Ok((Device::Cpu, Some(why)))
            }
            Err(error) => Err(error),
        }
    }
}

/// Why `auto` takes the CPU for so many rays into so many spheres, if it does without opening anything:
/// there is no GPU in hardware, and the CPU is quicker than a device in software.
pub fn why_auto_takes_the_cpu(kernel: Kernel, n_spheres: usize, n_rays: usize) -> Option<String> {
    why_the_cpu(kernel, n_spheres, n_rays).filter(|_| has_software_alone())
}

/// Rays of a kernel without a proof from which on a device in software makes up for the time that it
/// takes to open, with shaders to be compiled: it saves 5 to 10 ns a ray, for 0.1 to 0.3 s.
const MANY_RAYS: usize = 1 << 25;

/// As many rays as one way from a sample to a lamp counts there: it saves 10 to 15 ns where there are few objects.
const RAYS_OF_WAY: usize = 2;

/// The rays that take as long as a picture of `n_pixels` with `n_samples` by `n_samples` each, where a device in
/// software draws it.
pub fn rays_of_picture(scene: &Scene, n_pixels: usize, n_samples: Samples) -> usize {
    if !scene.is_lit() {
        return n_pixels;
    }
    let n_lamps = scene.lights.len() + scene.sky.map_or(0, |sky| sky.directions as usize);
    let of_ways = if are_at_hand(scene, n_lamps) { RAYS_OF_WAY * n_lamps } else { 0 };
    n_pixels.saturating_mul(n_samples.of_pixel() as usize).saturating_mul(1 + of_ways)
}

/// Why the CPU traces these rays sooner than a device in software, if it does: over many spheres it is
/// quicker by itself, and so it is in f64 and with `certified`, whose rays it takes side by side.
fn why_the_cpu(kernel: Kernel, n_spheres: usize, n_rays: usize) -> Option<String> {
    if n_spheres > FEW_SPHERES {
        Some(format!("{n_spheres} spheres"))
    } else if kernel == Kernel::Double {
        Some("f64".into())
    } else if kernel == Kernel::Certified {
        Some("`certified`".into())
    } else if n_rays < MANY_RAYS {
        Some(format!("{n_rays} rays"))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_weighs_a_device_in_software_against_the_cpu() {
        let takes_cpu =
            |kernel, n_spheres, n_rays| why_the_cpu(kernel, n_spheres, n_rays).is_some();
        assert!(takes_cpu(Kernel::Stable, 2, 1920 * 1080));
        assert!(!takes_cpu(Kernel::Stable, 2, MANY_RAYS));
        assert!(takes_cpu(Kernel::Double, 2, MANY_RAYS));
        assert!(takes_cpu(Kernel::Certified, 2, MANY_RAYS));
        assert!(takes_cpu(Kernel::Certified, FEW_SPHERES + 1, usize::MAX));

        let opened = |choice: DeviceChoice, n_rays| {
            let kernel = Kernel::Stable;
            let why = choice.why_the_cpu(kernel, 0, n_rays);
            why.map_or_else(|| choice.open(Some(kernel)).unwrap().0, |_| Device::Cpu).kind()
        };
        let by_default = if has_software_alone() { "cpu" } else { "gpu" };
        if DeviceChoice::Auto.is_free() {
            assert_eq!(opened(DeviceChoice::Auto, 1), by_default);
        }
        assert_eq!(opened(DeviceChoice::Auto, MANY_RAYS), "gpu");
        assert_eq!([DeviceChoice::Gpu, DeviceChoice::Cpu].map(|c| opened(c, 1)), ["gpu", "cpu"]);
    }
}
