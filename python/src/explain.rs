//! One ray in numbers.

use kugelblitz::explain::{self, Lang, latex, text};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::table::to_python;

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

/// The language of this name.
pub fn lang(name: &str) -> PyResult<Lang> {
    Lang::ALL.into_iter().find(|lang| lang.name() == name).ok_or_else(|| {
        let names = Lang::ALL.map(Lang::name).join(", ");
        PyValueError::new_err(format!("lang: there is no {name:?}; give one of {names}"))
    })
}
