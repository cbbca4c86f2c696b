//! Arrays of numbers.

use std::array::from_fn;

use kugelblitz::memory;
use numpy::ndarray::{ArrayViewD, Ix2};
use numpy::{
    PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error;
use crate::table::helpers;

/// An array argument, read where it lies if it has native f64 or f32, else through a copy in f64.
pub struct Numbers<'py> {
    name: &'static str,
    kind: Kind<'py>,
    /// True where the elements were bytes: colours as sRGB.
    pub is_bytes: bool,
}

/// Refuses so many numbers, or rows of them, where they do not fit the memory.
fn require<T>(name: &str, n: usize) -> PyResult<()> {
    let bytes = (n as u64).saturating_mul(size_of::<T>() as u64);
    memory::require(format!("{name}: {n} rows"), bytes, "give fewer").map_err(error::of(""))
}

enum Kind<'py> {
    F64(PyReadonlyArrayDyn<'py, f64>),
    F32(PyReadonlyArrayDyn<'py, f32>),
}

impl<'py> Numbers<'py> {
    /// Anything that numpy makes an array of numbers of.
    ///
    /// # Errors
    /// `TypeError` for anything else, `ValueError` where values are masked.
    pub fn new(name: &'static str, given: &Bound<'py, PyAny>) -> PyResult<Numbers<'py>> {
        let array = helpers(given.py())?.call_method1("array", (name, given))?;
        let array = array.cast_into::<PyUntypedArray>()?;
        let descr = array.dtype();
        let is_bytes = descr.getattr("name")?.extract::<String>()? == "uint8";
        if let Ok(floats) = array.cast::<PyArrayDyn<f32>>()
            && let Ok(floats) = floats.try_readonly()
        {
            return Ok(Numbers { name, kind: Kind::F32(floats), is_bytes });
        }
        let array = match array.cast::<PyArrayDyn<f64>>() {
            Ok(array) => array.clone(),
            // Other widths, other byte orders.
            Err(_) => {
                let n: usize = array.shape().iter().copied().fold(1, usize::saturating_mul);
                require::<f64>(name, n)?;
                array.call_method1("astype", ("=f8",))?.cast_into::<PyArrayDyn<f64>>()?
            }
        };
        let floats = array.try_readonly().map_err(|error| {
            PyValueError::new_err(format!("{name}: the array can't be read: {error}"))
        })?;
        Ok(Numbers { name, kind: Kind::F64(floats), is_bytes })
    }

    /// Lengths of its axes.
    pub fn shape(&self) -> &[usize] {
        match &self.kind {
            Kind::F64(array) => array.shape(),
            Kind::F32(array) => array.shape(),
        }
    }

    /// An error about the shape.
    pub fn wrong_shape(&self, expected: &str) -> PyErr {
        let shape = self.shape();
        PyValueError::new_err(format!("{}: the shape is {shape:?}, but {expected}", self.name))
    }

    /// What `make` makes of each row of `N` numbers and its place. It takes about as long as copying them, and waits for
    /// nobody: the interpreter's lock is held, so that no other thread writes to the array meanwhile.
    ///
    /// # Errors
    /// `ValueError` for another shape than (rows, `N`), `MemoryError` where that does not fit.
    pub fn rows<T, const N: usize>(
        &self,
        expected: &str,
        make: impl Fn(usize, [f64; N]) -> T,
    ) -> PyResult<Vec<T>> {
        require::<T>(self.name, self.shape().first().copied().unwrap_or(0))?;
        let all = match &self.kind {
            Kind::F64(array) => each_row(array.as_array(), make),
            Kind::F32(array) => each_row(array.as_array(), make),
        };
        all.ok_or_else(|| self.wrong_shape(expected))
    }

    /// The numbers of an array with one axis.
    ///
    /// # Errors
    /// `ValueError` for more axes or less.
    pub fn list(&self, expected: &str) -> PyResult<Vec<f64>> {
        if self.shape().len() != 1 {
            return Err(self.wrong_shape(expected));
        }
        require::<f64>(self.name, self.shape()[0])?;
        Ok(match &self.kind {
            Kind::F64(array) => array.as_array().iter().copied().collect(),
            Kind::F32(array) => array.as_array().iter().map(|&x| x.into()).collect(),
        })
    }
}

/// What `make` makes of the rows of a table of `N` columns; `None` of another one.
fn each_row<E: Copy + Into<f64>, T, const N: usize>(
    array: ArrayViewD<'_, E>,
    make: impl Fn(usize, [f64; N]) -> T,
) -> Option<Vec<T>> {
    let table = array.into_dimensionality::<Ix2>().ok().filter(|table| table.ncols() == N)?;
    let row = |row| make(row, from_fn(|column| table[[row, column]].into()));
    Some((0..table.nrows()).map(row).collect())
}
