//! Where rays are traced, and by which kernel.

use std::collections::HashMap;
use std::ffi::CString;
use std::process;
use std::sync::{Mutex, PoisonError};

use kugelblitz::device::{Device, DeviceChoice};
use kugelblitz::gpu::list_adapters;
use kugelblitz::trace::Kernel;
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::argument::named;
use crate::error;

/// Devices by what was asked for.
type Devices = HashMap<(DeviceChoice, Kernel), Device>;

/// Devices that are open, and the process that opened them: a fork leaves their drivers' threads behind.
static OPEN: Mutex<Option<(u32, Devices)>> = Mutex::new(None);

/// Does something with the open devices. The interpreter's lock is held, so that no fork comes meanwhile.
fn with_open<T>(_: Python<'_>, act: impl FnOnce(&mut Devices) -> T) -> T {
    let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    if open.as_ref().is_some_and(|(process, _)| *process != process::id()) {
        // Another process's drivers can't be asked to close.
        std::mem::forget(open.take());
    }
    act(&mut open.get_or_insert_with(|| (process::id(), HashMap::new())).1)
}

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
    if let Some(device) = with_open(py, |open| open.get(&key).cloned()) {
        return Ok(device);
    }
    let (device, why) =
        py.detach(|| choice.open(kernel, n_spheres, n_rays)).map_err(error::of("device"))?;
    if let Some(why) = why {
        let text = CString::new(format!("tracing on the CPU: {why}")).unwrap_or_default();
        PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 2)?;
    }
    Ok(with_open(py, |open| open.entry(key).or_insert(device).clone()))
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
pub fn adapters(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let facts = py.detach(list_adapters);
    facts
        .iter()
        .map(|facts| {
            let dict = PyDict::new(py);
            dict.set_item("name", &facts.name)?;
            dict.set_item("type", facts.kind)?;
            dict.set_item("driver", &facts.driver)?;
            dict.set_item("f64", facts.f64)?;
            dict.set_item("max_binding_bytes", facts.max_binding_bytes)?;
            Ok(dict)
        })
        .collect()
}
