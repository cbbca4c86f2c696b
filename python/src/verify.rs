//! Kernels and devices, held against exact arithmetic.

use kugelblitz::device::Device;
use kugelblitz::rays::Pixels;
use kugelblitz::trace::Kernel;
use kugelblitz_judge::verify::{self, Verified};
use pyo3::prelude::*;

use crate::error;
use crate::place;
use crate::scene::Scene;
use crate::table::Given;
use crate::verdict::verdict;
use crate::work::{self, Steps};

/// Holds a kernel, or all, against exact arithmetic at so many of these pixels, drawn by a seed.
pub fn verify<'py>(
    py: Python<'py>,
    scene: &Scene,
    pixels: &Pixels,
    (n_samples, seed): (Option<usize>, u64),
    (kernel, device): (&str, &str),
    progress: Given<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let kernels = match kernel {
        "all" => Kernel::ALL.to_vec(),
        name => vec![place::kernel(name)?],
    };
    let verification =
        verify::Verification::new(&scene.of, pixels, n_samples, seed).map_err(error::of(""))?;
    let open = |kernel| place::device(py, device, kernel, scene.of.spheres.len(), pixels.len());
    let device_of = |&kernel: &Kernel| match open(kernel) {
        Err(error) if kernels.len() > 1 && error.is_instance_of::<error::NoAdapterError>(py) => {
            let why = error.value(py);
            error::warn(py, &format!("{} on the CPU alone: {why}", kernel.name()))?;
            Ok((kernel, Device::Cpu))
        }
        device => Ok((kernel, device?)),
    };
    let devices = kernels.iter().map(device_of).collect::<PyResult<Vec<_>>>()?;
    let has_gpu = devices.iter().any(|(_, device)| device.facts().is_some());
    let steps = Steps::Rays(verification.n_steps(kernels.len(), has_gpu));
    let of = work::run_with_progress(py, progress, steps, |control| {
        let device_of = |kernel| {
            let own = devices.iter().find(|(of, _)| *of == kernel);
            own.map_or(&Device::Cpu, |(_, device)| device)
        };
        verification.run(&kernels, device_of, control)
    })?;
    let Verified { size: [width, height], samples, seed, .. } = of;
    let head =
        format!("{width}×{height}, {samples} pixels (seed {seed}) against exact arithmetic\n");
    verdict(py, "Verification", &of.broken(), &of, head + &of.in_words(), None)
}
