//! One ray in numbers.

use std::sync::Arc;

use kugelblitz::query::{Kernel, Rays};
use kugelblitz::scene::Scene;
use kugelblitz_judge::explain::{self, Lang, latex, text};
use pyo3::prelude::*;

use crate::argument::named;
use crate::place;
use crate::table::{PyValue, to_python};
use crate::work;

/// One ray in numbers: the lecture's formulas at work, and what f32 makes of them. `str()` is the text that
/// `kugelblitz explain` prints, and a notebook shows the formulas.
#[pyclass(frozen, name = "Explanation", module = "kugelblitz")]
pub struct PyExplanation {
    pub of: explain::Explanation,
}

#[pymethods]
impl PyExplanation {
    /// All numbers, under the keys that `kugelblitz explain --json` has in `explanation`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyValue<'py> {
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
    device: &str,
) -> PyResult<PyExplanation> {
    let style = explain::ExplainStyle {
        limit: (!all).then_some(explain::DEFAULT_OBJECTS),
        lang: self::lang(lang)?,
        digits,
    };
    let devices = place::devices(py, device, &Kernel::ALL, scene.spheres.len(), 1)?;
    let of = work::run(py, |control| {
        let mut of = explain::explain(scene, ray, &style)?;
        control.check()?;
        of.add_device(scene, ray, |kernel| &devices[&kernel])?;
        Ok(of)
    })?;
    Ok(PyExplanation { of })
}

/// The language of this name.
pub fn lang(name: &str) -> PyResult<Lang> {
    named("lang", name, Lang::ALL, Lang::name)
}
