//! Two pictures, held against each other, and what comparisons come to, see `_verdicts.py`.

use kugelblitz::picture::Image;
use kugelblitz_judge::compare::{Allowed, PictureDifference, compare_pictures};
use numpy::PyArray1;
use pyo3::prelude::*;
use serde::Serialize;

use crate::drawing::tinted;
use crate::error;
use crate::image::{image_of, indices};
use crate::table::{Given, Object, helpers, to_python};
use crate::work;

/// A `Verdict` of this kind: what is not as it may be, what the program prints as JSON and in words, and, where there
/// is one, an object that knows the rest.
pub fn verdict<'py>(
    py: Python<'py>,
    kind: &str,
    broken: &[String],
    summary: &impl Serialize,
    words: String,
    of: Given<'py>,
) -> Object<'py> {
    let arguments = (broken, to_python(py, summary)?, words, of);
    py.import("kugelblitz._verdicts")?.call_method1(kind, arguments)
}

/// What a `Difference` knows of its pixels.
#[pyclass(frozen, module = "kugelblitz._kugelblitz")]
pub struct Compared {
    a: Image,
    of: PictureDifference,
}

#[pymethods]
impl Compared {
    fn beyond<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        indices(py, self.of.pixels_beyond())
    }

    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Given<'py>> {
        let size = [self.a.width as u32, self.a.height as u32];
        let tinted = || tinted(py, size, &self.of.picture(&self.a), Vec::new());
        (self.of.pixels > 0).then(tinted).transpose()
    }
}

/// Compares two pictures channel by channel: `Picture`s, arrays of colours (height, width, 3), structured
/// arrays, or paths of files.
///
/// Bytes and 16 bits are sRGB, floats linear; numbers of different types are compared as the one that has fewer
/// of them. `allow` is what may differ, e.g. "levels=1,ulp=4,difference=1e-6,pixels=0.1%"; nothing without it.
#[pyfunction]
#[pyo3(signature = (a, b, *, allow = ""))]
pub fn compare<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
    allow: &str,
) -> Object<'py> {
    let picture = |name, given| helpers(py)?.call_method1("picture", (name, given))?.extract();
    let allowed = Allowed::of_pictures(allow).map_err(error::of("allow"))?;
    let [a, b] = [image_of(picture("a", a)?)?, image_of(picture("b", b)?)?];
    let of = work::run(py, |_| compare_pictures(["a", "b"], [&a, &b], &allowed))?;
    let compared = Bound::new(py, Compared { a, of })?;
    let of = &compared.get().of;
    let known = Some(compared.clone().into_any());
    verdict(py, "Difference", &of.broken, of, of.in_words(), known)
}
