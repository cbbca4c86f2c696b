//! Choosing where the rays are traced.

use std::sync::Arc;
use std::time::Instant;

use kugelblitz::device::{self, Device, DeviceChoice};
use kugelblitz::gpu::{Gpu, find_adapter};
use kugelblitz::query::Kernel;
use kugelblitz::scene::Scene;
use kugelblitz::words::duration;
use kugelblitz::{Result, Session};

use crate::Run;
use crate::args::DeviceArgs;
use crate::quiet::{self, quietly};

/// Opens what --device asks for. With a `kernel`, the device must be able to run it.
///
/// # Errors
/// Those of [`DeviceChoice::open`].
pub fn open(choice: &DeviceChoice, kernel: Option<Kernel>, run: &Run) -> Result<Device> {
    if *choice == DeviceChoice::Cpu {
        return Ok(Device::Cpu);
    }
    let start = Instant::now();
    let (opened, noise) = quietly(|| choice.open(kernel));
    if run.talk.verbose || opened.is_err() && *choice != DeviceChoice::Auto {
        quiet::show(&noise, run.talk.verbose);
    }
    let (device, why) = opened?;
    if let Some(why) = why {
        run.warn(&format!("tracing on the CPU: {}", why.text));
    }
    if let Device::Gpu(gpu) = &device {
        run.note(&format!(
            "opened {} ({}, {}) in {}",
            gpu.facts.name,
            gpu.facts.kind,
            gpu.facts.driver,
            duration(start.elapsed())
        ));
        let line = filter_line(gpu)?;
        if gpu.arithmetic()?.suits_filter() {
            run.note(&line)
        } else {
            run.warn(&format!("{line} (see `kugelblitz probe`)"))
        }
    }
    Ok(device)
}

/// Where the f32 stage of `certified` runs, in a line.
fn filter_line(gpu: &Gpu) -> Result<String> {
    Ok(format!("{}, `certified`: {}", gpu.facts.name, gpu.arithmetic()?.filter_in_words()))
}

/// Opens what --device asks for to trace these rays of a scene: `auto` takes a real GPU, else the quicker
/// one of the CPU and a device in software.
///
/// # Errors
/// Those of [`open`].
pub fn session(
    DeviceArgs { device: choice }: &DeviceArgs,
    kernel: Kernel,
    scene: &Arc<Scene>,
    n_rays: usize,
    run: &Run,
) -> Result<Session> {
    let n_spheres = scene.spheres.len();
    let because = |why: &str| {
        format!(
            "there is no GPU in hardware here, and for {why} the CPU is quicker than a device in software"
        )
    };
    if let Some(why) = choice.why_the_cpu(kernel, n_spheres, n_rays) {
        // No driver has been asked yet. Asking takes time, so only the note does it.
        if run.talk.verbose {
            let name = DeviceChoice::Gpu.adapter().unwrap_or_default();
            let (found, noise) = quietly(|| find_adapter(&name, kernel));
            quiet::show(&noise, true);
            run.note(&match found {
                Ok(facts) => format!(
                    "tracing on the CPU: {}; `--device gpu` takes {}",
                    because(&why),
                    facts.name
                ),
                Err(error) => format!("tracing on the CPU: {error}"),
            });
        }
        return Ok(Session::new(Arc::clone(scene), Device::Cpu, kernel));
    }
    if run.talk.verbose
        && *choice == DeviceChoice::Gpu
        && let Some(why) = device::why_auto_takes_the_cpu(kernel, n_spheres, n_rays)
    {
        run.note(&format!("`--device auto` would trace on the CPU: {}", because(&why)));
    }
    Ok(Session::new(Arc::clone(scene), open(choice, Some(kernel), run)?, kernel))
}

/// The device for one kernel of several: the CPU, with a warning, where this can't run it.
pub fn or_cpu<'a>(device: &'a Device, kernel: Kernel, run: &Run) -> &'a Device {
    match device.facts().map(|facts| facts.check_kernel(kernel)) {
        Some(Err(reason)) => {
            run.warn(&format!("`{}` on the CPU alone: {reason}", kernel.name()));
            &Device::Cpu
        }
        _ => device,
    }
}

#[cfg(test)]
mod tests {
    use kugelblitz::Error;

    use super::*;
    use crate::args::TalkArgs;

    /// No adapter here lacks f64, so one is made to.
    #[test]
    fn an_adapter_without_f64_leaves_the_f64_kernel_to_the_cpu() {
        let talk = TalkArgs { quiet: true, ..TalkArgs::default() };
        let run = Run { start: Instant::now(), control: Arc::default(), talk };
        let open = |f64| {
            let mut gpu = Gpu::open("").expect("a Vulkan device; ci/setup.sh installs one");
            gpu.facts.f64 = f64;
            gpu
        };
        for (f64, kernel) in
            [(false, Kernel::Double), (false, Kernel::Certified), (true, Kernel::Double)]
        {
            let runs = f64 || kernel != Kernel::Double;
            let refusal = open(f64).facts.check_kernel(kernel).err();
            assert_eq!(refusal.as_ref().map(Error::exit_code), (!runs).then_some(4));
            let device = Device::Gpu(Arc::new(open(f64)));
            assert_eq!(matches!(or_cpu(&device, kernel, &run), Device::Gpu(_)), runs);
        }
    }

    /// No adapter here lacks passthrough, so one is told that it does.
    #[test]
    fn an_adapter_without_passthrough_says_that_the_cpu_takes_the_f32_stage() {
        for (passthrough, expected) in
            [(true, "f32 stage on this device"), (false, "f32 stage on the CPU: shaders can't be")]
        {
            let mut gpu = Gpu::open("").expect("a Vulkan device; ci/setup.sh installs one");
            gpu.facts.passthrough = passthrough;
            let line = filter_line(&gpu).unwrap();
            assert!(line.contains(&gpu.facts.name) && line.contains(expected), "{line}");
        }
    }
}
