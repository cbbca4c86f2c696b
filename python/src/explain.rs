//! One ray in numbers.

use std::sync::Arc;

use kugelblitz::device::Device;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Kernel, Rays};
use kugelblitz_judge::explain::{self, Lang, latex, text};
use pyo3::prelude::*;

use crate::argument::named;
use crate::error::NoAdapterError;
use crate::table::to_python;
use crate::work;

/// One ray in numbers: the lecture's formulas at work, and what f32 makes of them. `str()` is the text that
/// `kugelblitz explain` prints, and a notebook shows the formulas.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Explanation {
    pub of: explain::Explanation,
}

#[pymethods]
impl Explanation {
    /// All numbers, under the keys that `kugelblitz explain --json` has in `explanation`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.of)
    }

    /// The text for LaTeX with amsmath that `kugelblitz explain --latex` prints.
    fn latex(&self) -> String {
        latex::latex(&self.of)
    }

    /// Id of the object that the ray sees, exactly; 0 is the background.
    #[getter]
    fn id(&self) -> u32 {
        self.of.winner.as_ref().map_or(0, |winner| winner.id)
    }

    fn _repr_latex_(&self) -> String {
        latex::math(&self.of)
    }

    fn __str__(&self) -> String {
        text::text(&self.of)
    }

    fn __repr__(&self) -> String {
        let sees = self.of.winner.as_ref().map_or("the background", |winner| &winner.label);
        let what = match &self.of.pixel {
            Some(pixel) => {
                format!("pixel {}, {} of {}×{}", pixel.x, pixel.y, pixel.width, pixel.height)
            }
            None => "a ray".into(),
        };
        format!("<Explanation: {what} sees {sees}; print() it for the numbers>")
    }
}

/// One ray in numbers; on a device as well, where there is one.
pub fn explained(
    py: Python<'_>,
    scene: &Arc<Scene>,
    ray: &Rays,
    all: bool,
    lang: &str,
    digits: usize,
    device: Option<&dyn Fn(Kernel) -> PyResult<Device>>,
) -> PyResult<Explanation> {
    let style = explain::Style {
        limit: (!all).then_some(explain::DEFAULT_OBJECTS),
        lang: self::lang(lang)?,
        digits,
    };
    let mut devices = Vec::new();
    for kernel in Kernel::ALL {
        match device.map(|device| device(kernel)).transpose() {
            Ok(device) => devices.extend(device.map(|device| (kernel, device))),
            // A device may lack the types of a kernel.
            Err(error)
                if kernel != Kernel::Certified && error.is_instance_of::<NoAdapterError>(py) => {}
            Err(error) => return Err(error),
        }
    }
    let of = work::run(py, |control| {
        let mut of = explain::explain_as(scene, ray, &style)?;
        control.check()?;
        of.add_device(scene, ray, |prepared, wants| {
            match devices.iter().find(|(kernel, _)| *kernel == prepared.kernel) {
                Some((_, device @ Device::Gpu(_))) => {
                    Ok(Some(device.tracer(prepared, wants)?.tracer))
                }
                Some((_, Device::Cpu)) | None => Ok(None),
            }
        })?;
        Ok(of)
    })?;
    Ok(Explanation { of })
}

/// The language of this name.
pub fn lang(name: &str) -> PyResult<Lang> {
    named("lang", name, Lang::ALL, Lang::name)
}
