//! Where rays are traced, and by which kernel.

use std::collections::HashMap;

use kugelblitz::device::{Device, DeviceChoice};
use kugelblitz::gpu::list_adapters;
use kugelblitz::query::Kernel;
use pyo3::exceptions::{PyRuntimeWarning, PyUserWarning};
use pyo3::prelude::*;

use crate::argument::named;
use crate::error::{self, NoAdapterError};
use crate::process::OfProcess;
use crate::table::{PyValue, to_python};

/// The devices that are open, by what was asked for.
static OPEN: OfProcess<HashMap<(DeviceChoice, Kernel), Device>> = OfProcess::new();

/// The device that `name` asks for, for so many rays into so many spheres.
///
/// # Errors
/// Those of [`DeviceChoice::open`].
pub fn device(
    py: Python<'_>,
    name: &str,
    kernel: Kernel,
    n_spheres: usize,
    n_rays: usize,
) -> PyResult<Device> {
    let choice = DeviceChoice::parse(name).map_err(error::of("device"))?;
    if choice.why_the_cpu(kernel, n_spheres, n_rays).is_some() {
        return Ok(Device::Cpu);
    }
    let key = (choice.clone(), kernel);
    if let Some(device) = OPEN.with(py, |open| open.get(&key).cloned()) {
        return Ok(device);
    }
    let (device, why) = py.detach(|| choice.open(Some(kernel))).map_err(error::of("device"))?;
    if let Some(why) = why {
        error::warn::<PyRuntimeWarning>(py, &format!("tracing on the CPU: {why}"))?;
    }
    Ok(OPEN.with(py, |open| open.entry(key).or_insert(device).clone()))
}

/// The devices of several kernels.
///
/// # Errors
/// As [`device`]; but where an adapter lacks the types of a kernel without a proof, that has the CPU.
pub fn devices(
    py: Python<'_>,
    name: &str,
    kernels: &[Kernel],
    n_spheres: usize,
    n_rays: usize,
) -> PyResult<HashMap<Kernel, Device>> {
    let device_of = |&kernel: &Kernel| match device(py, name, kernel, n_spheres, n_rays) {
        Err(error)
            if kernels.len() > 1
                && kernel != Kernel::Certified
                && error.is_instance_of::<NoAdapterError>(py) =>
        {
            let why = error.value(py);
            error::warn::<PyUserWarning>(
                py,
                &format!("{} on the CPU alone: {why}", kernel.name()),
            )?;
            Ok((kernel, Device::Cpu))
        }
        device => Ok((kernel, device?)),
    };
    // The certified kernel is the last one: where there is no adapter at all, nobody is warned of others.
    kernels.iter().rev().map(device_of).collect()
}

/// The kernel of this name.
///
/// # Errors
/// `ValueError` names those that there are.
pub fn kernel(name: &str) -> PyResult<Kernel> {
    named("kernel", name, Kernel::ALL, Kernel::name)
}

/// The Vulkan adapters of this machine, the best first: a dictionary each.
#[pyfunction]
pub fn adapters(py: Python<'_>) -> PyValue<'_> {
    to_python(py, &py.detach(list_adapters))
}
