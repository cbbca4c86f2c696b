//! Arguments of few numbers, out of any sequence, and names of things.

use kugelblitz::scene::{self, schema};
use numpy::ndarray::Dimension;
use numpy::{Element, PyReadonlyArray, PyReadonlyArrayDyn};
use pyo3::Borrowed;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};

use crate::error::wrong_value;
use crate::table::value_of;

/// Columns and rows that a picture can have.
#[derive(Clone, Copy)]
pub struct Size(pub [u32; 2]);

/// Left column, top row, width and height of a part of a picture.
#[derive(Clone, Copy)]
pub struct Crop(pub [u32; 4]);

/// Column and row of a pixel.
#[derive(Clone, Copy)]
pub struct Pixel(pub [i64; 2]);

/// Samples across and down a pixel.
#[derive(Clone, Copy)]
pub struct Samples(pub scene::Samples);

impl<'py> FromPyObject<'_, 'py> for Size {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Size> {
        let [width, height]: [Bound<'_, PyAny>; 2] = parts("size", "(columns, rows)", &given)?;
        let side = |given| value_of("size", given, schema::pixels);
        Ok(Size([side(&width)?, side(&height)?]))
    }
}

impl<'py> FromPyObject<'_, 'py> for Crop {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Crop> {
        let what = "(left column, top row, width, height)";
        let numbers: [i128; 4] = parts("crop", what, &given)?;
        match numbers.map(u32::try_from) {
            [Ok(x), Ok(y), Ok(width), Ok(height)] => Ok(Crop([x, y, width, height])),
            _ => wrong_value(format!("crop: {numbers:?}, but {what} are whole numbers of 32 bits")),
        }
    }
}

impl<'py> FromPyObject<'_, 'py> for Pixel {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Pixel> {
        parts("pixel", "(column, row)", &given).map(Pixel)
    }
}

impl<'py> FromPyObject<'_, 'py> for Samples {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Samples> {
        value_of("samples", &given, schema::samples).map(Samples)
    }
}

/// The parts of a short sequence. A text in bytes is a sequence of whole numbers, but nobody means it.
fn parts<'py, T: FromPyObjectOwned<'py>, const N: usize>(
    name: &str,
    what: &str,
    given: &Bound<'py, PyAny>,
) -> PyResult<[T; N]> {
    let wrong = || PyTypeError::new_err(format!("{name}: it is {what}, whole numbers"));
    match given.is_instance_of::<PyBytes>() || given.is_instance_of::<PyByteArray>() {
        true => Err(wrong()),
        false => given.extract().map_err(|_| wrong()),
    }
}

/// Numbers that lie one behind the other.
pub type Floats<'py> = PyReadonlyArrayDyn<'py, f64>;

/// Rows of `N` numbers of an array that `_given.py` has put in order. The interpreter's lock is held while they are
/// read, so that no other thread writes to it meanwhile.
///
/// # Errors
/// `ValueError` for an array that is not in order.
pub fn in_rows<'a, T: Element, D: Dimension, const N: usize>(
    array: &'a PyReadonlyArray<'_, T, D>,
) -> PyResult<&'a [[T; N]]> {
    Ok(array.as_slice()?.as_chunks().0)
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
