//! Arguments of few numbers, out of any sequence, and names of things.

use pyo3::Borrowed;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};

/// Columns and rows of a picture.
#[derive(Clone, Copy)]
pub struct Size(pub [u32; 2]);

/// Left column, top row, width and height of a part of a picture.
#[derive(Clone, Copy)]
pub struct Crop(pub [u32; 4]);

/// Column and row of a pixel.
#[derive(Clone, Copy)]
pub struct Pixel(pub [i64; 2]);

/// A point or a direction.
#[derive(Clone, Copy)]
pub struct Vector(pub [f64; 3]);

impl<'py> FromPyObject<'_, 'py> for Size {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Size> {
        whole("size", "(columns, rows)", &given).map(Size)
    }
}

impl<'py> FromPyObject<'_, 'py> for Crop {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Crop> {
        whole("crop", "(left column, top row, width, height)", &given).map(Crop)
    }
}

impl<'py> FromPyObject<'_, 'py> for Pixel {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Pixel> {
        let wrong = |_| PyTypeError::new_err("pixel: it is (column, row)");
        refuse_bytes("pixel", &given)?;
        given.extract().map(Pixel).map_err(wrong)
    }
}

impl<'py> FromPyObject<'_, 'py> for Vector {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Vector> {
        // Notes of the exception name the argument.
        let wrong = |_| PyTypeError::new_err("a point or a direction is three numbers");
        refuse_bytes("a point or a direction", &given)?;
        given.extract().map(Vector).map_err(wrong)
    }
}

/// Whole numbers of 32 bits.
fn whole<const N: usize>(name: &str, what: &str, given: &Bound<'_, PyAny>) -> PyResult<[u32; N]> {
    let wrong = |_| PyTypeError::new_err(format!("{name}: it is {what}, whole numbers"));
    refuse_bytes(name, given)?;
    let numbers: [i128; N] = given.extract().map_err(wrong)?;
    match numbers.map(u32::try_from) {
        all if all.iter().all(Result::is_ok) => Ok(all.map(Result::unwrap_or_default)),
        _ => Err(PyValueError::new_err(format!(
            "{name}: {numbers:?}, but {what} are whole numbers of 32 bits"
        ))),
    }
}

/// A text in bytes is a sequence of whole numbers, but nobody means it.
fn refuse_bytes(name: &str, given: &Bound<'_, PyAny>) -> PyResult<()> {
    match given.is_instance_of::<PyBytes>() || given.is_instance_of::<PyByteArray>() {
        true => Err(PyTypeError::new_err(format!("{name}: it is numbers, not bytes"))),
        false => Ok(()),
    }
}

/// The one of `all` that is called `given`; `argument` is what the user gave it by.
///
/// # Errors
/// `ValueError` names those that there are.
pub fn named<T: Copy>(
    argument: &str,
    given: &str,
    all: impl IntoIterator<Item = T>,
    name: fn(T) -> &'static str,
) -> PyResult<T> {
    let all: Vec<T> = all.into_iter().collect();
    all.iter().copied().find(|known| name(*known) == given).ok_or_else(|| {
        let names: Vec<&str> = all.iter().copied().map(name).collect();
        PyValueError::new_err(format!(
            "{argument}: there is no {given:?}; give one of {}",
            names.join(", ")
        ))
    })
}
