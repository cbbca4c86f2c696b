//! Two pictures, channel by channel.

use kugelblitz::control::Control;
use kugelblitz::picture::Image;
use kugelblitz_judge::compare::{Allowed, PictureDifference, compare_pictures};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::drawing::Tinted;
use crate::error;
use crate::image::{image_of, indices};
use crate::table::to_python;
use crate::work;

/// How two pictures differ. True where they differ by no more than is allowed; `str()` is the text that
/// `kugelblitz compare` prints.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Difference {
    first: Image,
    of: PictureDifference,
}

#[pymethods]
impl Difference {
    /// Whether they differ by no more than is allowed.
    #[getter]
    fn kept(&self) -> bool {
        self.of.broken.is_empty()
    }

    fn __bool__(&self) -> bool {
        self.kept()
    }

    /// What is more than allowed, a sentence each.
    #[getter]
    fn broken(&self) -> Vec<String> {
        self.of.broken.clone()
    }

    /// Pixels that were compared; 0 where the sizes differ.
    #[getter]
    fn n_pixels(&self) -> u64 {
        self.of.pixels
    }

    /// Pixels with any difference.
    #[getter]
    fn n_differing(&self) -> u64 {
        self.of.differing
    }

    /// Column and row of the first pixel with any difference.
    #[getter]
    fn first(&self) -> Option<[usize; 2]> {
        self.of.first
    }

    /// Indices of the pixels, row by row, that differ by more than is allowed of one.
    #[getter]
    fn beyond<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        indices(py, self.of.pixels_beyond())
    }

    /// The channels that both have: a dictionary each, with `name`, `differing`, `largest`, `pixel` and others.
    #[getter]
    fn channels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.of.channels)
    }

    /// The differences as colours: equal pixels dark, allowed differences blue, others red to yellow; `None`
    /// where the sizes differ.
    #[getter]
    fn picture(&self) -> Option<Tinted> {
        let Image { width, height, .. } = self.first;
        let (size, colors) = ([width as u32, height as u32], self.of.picture(&self.first));
        (self.of.pixels > 0).then_some(Tinted { size, colors, legend: Vec::new() })
    }

    /// All of it, under the keys of `kugelblitz compare --json`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.of)
    }

    fn __str__(&self) -> String {
        self.of.in_words()
    }

    fn __repr__(&self) -> String {
        match self.of.broken.as_slice() {
            [] => {
                let PictureDifference { pixels, differing, .. } = self.of;
                format!(
                    "<Difference: {differing} of {pixels} pixels differ, no more than is allowed>"
                )
            }
            broken => format!("<Difference: {}>", broken.join("; ")),
        }
    }
}

/// Compares two pictures channel by channel: `Picture`s, arrays of colours (height, width, 3), structured
/// arrays, or paths of files.
///
/// Bytes and 16 bits are sRGB, floats linear; numbers of different types are compared as the one that has fewer
/// of them. `allow` is what may differ, e.g. "levels=1,ulp=4,difference=1e-6,pixels=0.1%"; nothing without it.
#[pyfunction]
#[pyo3(signature = (a, b, *, allow = ""))]
pub fn compare(
    py: Python<'_>,
    a: &Bound<'_, PyAny>,
    b: &Bound<'_, PyAny>,
    allow: &str,
) -> PyResult<Difference> {
    let allowed = Allowed::of_pictures(allow).map_err(error::of("allow"))?;
    let [first, second] = [image_of("a", a)?, image_of("b", b)?];
    let compared = |_: &Control| compare_pictures(["a", "b"], [&first, &second], &allowed);
    let of = work::run(py, None, 0, compared)?;
    Ok(Difference { first, of })
}
