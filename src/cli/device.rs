//! Choosing where the rays are traced.

use std::sync::Arc;
use std::time::Instant;

use kugelblitz::device::Device;
#[cfg(feature = "view")]
use kugelblitz::gpu::Pick;
use kugelblitz::gpu::{Gpu, has_software_alone};
use kugelblitz::prepare::{FEW_SPHERES, PlainLighting};
use kugelblitz::scene::Scene;
use kugelblitz::trace::Kernel;
use kugelblitz::{Error, Result};

use super::TalkArgs;
use super::options::DeviceChoice;
use super::output::human;
use super::quiet::{self, quietly};

/// Opens what --device asks for. With a `kernel`, the device must be able to run it.
///
/// # Errors
/// [`Error::NoAdapter`], and [`Error::TooLarge`] within a limit that no driver keeps, but for
/// `auto`, which then takes the CPU and says so.
pub fn open(choice: &DeviceChoice, kernel: Option<Kernel>, talk: &TalkArgs) -> Result<Device> {
    let Some(pick) = choice.pick() else { return Ok(Device::Cpu) };
    let start = Instant::now();
    let (opened, noise) = quietly(|| Gpu::open(&pick));
    // What the self-test can't bind, no kernel can.
    let opened = opened
        .and_then(|gpu| for_kernel(gpu, kernel))
        .and_then(|gpu| gpu.arithmetic().map(|_| gpu));
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
            match gpu.arithmetic()?.suits_filter() {
                true => talk.note(&filter_line(&gpu)?),
                false => talk.warn(&format!("{} (see `kugelblitz probe`)", filter_line(&gpu)?)),
            }
            Ok(Device::Gpu(Arc::new(gpu)))
        }
        Err(Error::NoAdapter(reason) | Error::TooLarge(reason)) if falls_back => {
            talk.warn(&format!("tracing on the CPU: {reason}"));
            Ok(Device::Cpu)
        }
        Err(error) => Err(error),
    }
}

/// Where the f32 stage of `certified` runs, in a line.
fn filter_line(gpu: &Gpu) -> Result<String> {
    Ok(format!("{}, `certified`: {}", gpu.facts.name, gpu.arithmetic()?.filter_in_words()))
}

/// Rays of a kernel without a proof from which on a device in software makes up for the time that it
/// takes to open, with shaders to be compiled: it saves 5 to 10 ns a ray, for 0.1 to 0.3 s.
const MANY_RAYS: usize = 1 << 25;

/// As many rays as one way from a sample to a lamp counts there: it saves 10 to 15 ns where there are few objects.
const RAYS_OF_WAY: usize = 2;

/// The samples of a lit picture as rays that take as long, where a device in software lights them.
pub fn rays_of_light(scene: &Scene, n_samples: usize) -> usize {
    let n_lamps = scene.lights.len() + scene.sky.map_or(0, |sky| sky.directions as usize);
    let are_few =
        scene.n_objects() <= PlainLighting::FEW_OBJECTS && n_lamps <= PlainLighting::FEW_LAMPS;
    let of_ways = if are_few { RAYS_OF_WAY * n_lamps } else { 0 };
    n_samples.saturating_mul(1 + of_ways)
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

/// Opens what --device asks for to trace these rays: `auto` takes a real GPU, else the quicker one of
/// the CPU and a device in software.
///
/// # Errors
/// Those of [`open`].
pub fn open_for(
    choice: &DeviceChoice,
    kernel: Kernel,
    scene: &Scene,
    n_rays: usize,
    talk: &TalkArgs,
) -> Result<Device> {
    if choice.is_free()
        && let Some(why) = why_the_cpu(kernel, scene.spheres.len(), n_rays)
        && has_software_alone()
    {
        talk.note(&format!(
            "tracing on the CPU: there is no GPU in hardware here, and for {why} the CPU is quicker \
             than a device in software; `--device gpu` takes that"
        ));
        return Ok(Device::Cpu);
    }
    open(choice, Some(kernel), talk)
}

/// The device for a window: `auto` lets the CPU trace many spheres where there is no GPU in hardware. Few
/// of them stay on the device that shows the picture, whose shaders are there by then.
#[cfg(feature = "view")]
pub fn pick_for_window(choice: &DeviceChoice, kernel: Kernel, scene: &Scene) -> Option<Pick> {
    let is_quicker = scene.spheres.len() > FEW_SPHERES || kernel == Kernel::Double;
    choice.pick().filter(|_| !(choice.is_free() && is_quicker && has_software_alone()))
}

/// The device for one kernel of several: the CPU, with a warning, where this can't run it.
pub fn or_cpu<'a>(device: &'a Device, kernel: Kernel, talk: &TalkArgs) -> &'a Device {
    match device {
        Device::Gpu(gpu) => match gpu.facts.check_kernel(kernel) {
            Ok(()) => device,
            Err(reason) => {
                talk.warn(&format!("`{}` on the CPU alone: {reason}", kernel.name()));
                &Device::Cpu
            }
        },
        Device::Cpu => device,
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

    #[test]
    fn auto_weighs_a_device_in_software_against_the_cpu() {
        let takes_cpu =
            |kernel, n_spheres, n_rays| why_the_cpu(kernel, n_spheres, n_rays).is_some();
        assert!(takes_cpu(Kernel::Stable, 2, 1920 * 1080));
        assert!(!takes_cpu(Kernel::Stable, 2, MANY_RAYS));
        assert!(takes_cpu(Kernel::Double, 2, MANY_RAYS));
        assert!(takes_cpu(Kernel::Certified, 2, MANY_RAYS));
        assert!(takes_cpu(Kernel::Certified, FEW_SPHERES + 1, usize::MAX));

        let talk = TalkArgs { json: false, quiet: true, verbose: false };
        let opened = |choice, n_rays| {
            open_for(&choice, Kernel::Stable, &Scene::default(), n_rays, &talk).unwrap().kind()
        };
        let by_default = if has_software_alone() { "cpu" } else { "gpu" };
        if DeviceChoice::Auto.is_free() {
            assert_eq!(opened(DeviceChoice::Auto, 1), by_default);
        }
        assert_eq!(opened(DeviceChoice::Auto, MANY_RAYS), "gpu");
        assert_eq!([DeviceChoice::Gpu, DeviceChoice::Cpu].map(|c| opened(c, 1)), ["gpu", "cpu"]);
    }

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
            assert_eq!(matches!(or_cpu(&device, kernel, &talk), Device::Gpu(_)), runs);
        }
        assert!(for_kernel(open(false), None).is_ok());
    }

    /// No adapter here lacks passthrough, so one is told that it does.
    #[test]
    fn an_adapter_without_passthrough_says_that_the_cpu_takes_the_f32_stage() {
        for (passthrough, expected) in
            [(true, "f32 stage on this device"), (false, "f32 stage on the CPU: shaders can't be")]
        {
            let mut gpu =
                Gpu::open(&Pick::Best).expect("a Vulkan device; ci/setup.sh installs one");
            gpu.facts.passthrough = passthrough;
            let line = filter_line(&gpu).unwrap();
            assert!(line.contains(&gpu.facts.name) && line.contains(expected), "{line}");
        }
    }
}
