//! What comparisons come to, see `_verdicts.py`.

use pyo3::prelude::*;
use serde::Serialize;

use crate::table::json;

/// A `Verdict` of this kind: what is not as it may be, what the program prints as JSON and in words, and, where there
/// is one, an object that knows the rest.
pub fn verdict<'py>(
    py: Python<'py>,
    kind: &str,
    broken: &[String],
    summary: &impl Serialize,
    words: String,
    of: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let arguments = (broken, json(summary)?, words, of);
    py.import("kugelblitz._verdicts")?.call_method1(kind, arguments)
}
