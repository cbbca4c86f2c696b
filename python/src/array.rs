//! Arrays of numbers.

use kugelblitz::memory;
use numpy::ndarray::{ArrayView2, Ix2};
use numpy::{
    PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::error;

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

/// Anything that numpy makes an array of numbers of, as an array.
///
/// # Errors
/// `TypeError` for anything else.
pub fn untyped<'py>(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    let numpy = given.py().import("numpy")?;
    if let Some(n) = n_masked(given)? {
        return Err(PyValueError::new_err(format!(
            "{name}: {n} values are masked, and nothing can stand for them; leave these rows out, or fill \
             them with .filled(…)"
        )));
    }
    let array = numpy.call_method1("asarray", (given,)).map_err(|error| {
        PyTypeError::new_err(format!("{name}: this is no array of numbers: {error}"))
    })?;
    let array = array.cast_into::<PyUntypedArray>()?;
    let descr = array.dtype();
    let kind: String = descr.getattr("kind")?.extract()?;
    match matches!(&*kind, "f" | "i" | "u") {
        true => Ok(array),
        false => Err(PyTypeError::new_err(format!(
            "{name}: the array has the dtype {}, but numbers are wanted: float64, float32 or integers",
            descr.str()?
        ))),
    }
}

/// How many values of one of numpy's masked arrays are masked, where any are.
pub fn n_masked(given: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    let masked = given.py().import("numpy.ma")?;
    if !given.is_instance(&masked.getattr("MaskedArray")?)? {
        return Ok(None);
    }
    let n: usize = masked.call_method1("count_masked", (given,))?.extract()?;
    Ok(Some(n).filter(|n| *n > 0))
}

enum Kind<'py> {
    F64(PyReadonlyArrayDyn<'py, f64>),
    F32(PyReadonlyArrayDyn<'py, f32>),
}

impl<'py> Numbers<'py> {
    /// Anything that numpy makes an array of numbers of.
    ///
    /// # Errors
    /// `TypeError` for anything else.
    pub fn new(name: &'static str, given: &Bound<'py, PyAny>) -> PyResult<Numbers<'py>> {
        let array = untyped(name, given)?;
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

    /// Its rows, of `n` columns each.
    ///
    /// # Errors
    /// `ValueError` for another shape than (rows, `n`).
    pub fn table(&self, n: usize, expected: &str) -> PyResult<Table<'_>> {
        let table = match &self.kind {
            Kind::F64(array) => array.as_array().into_dimensionality::<Ix2>().map(Table::F64),
            Kind::F32(array) => array.as_array().into_dimensionality::<Ix2>().map(Table::F32),
        };
        match table {
            Ok(table) if self.shape()[1] == n => Ok(table),
            _ => Err(self.wrong_shape(expected)),
        }
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

/// Rows of numbers, wherever they lie.
pub enum Table<'a> {
    F64(ArrayView2<'a, f64>),
    F32(ArrayView2<'a, f32>),
}

impl Table<'_> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Table::F64(rows) => rows.nrows(),
            Table::F32(rows) => rows.nrows(),
        }
    }

    /// The first `N` numbers of a row.
    pub fn row<const N: usize>(&self, row: usize) -> [f64; N] {
        match self {
            Table::F64(rows) => std::array::from_fn(|column| rows[[row, column]]),
            Table::F32(rows) => std::array::from_fn(|column| rows[[row, column]].into()),
        }
    }

    /// What `make` makes of each row and its place. It takes about as long as copying them, and waits for nobody: the
    /// interpreter's lock is held, so that no other thread writes to the array meanwhile.
    ///
    /// # Errors
    /// `MemoryError` where that does not fit.
    pub fn map<T, const N: usize>(
        &self,
        what: &str,
        make: impl Fn(usize, [f64; N]) -> T,
    ) -> PyResult<Vec<T>> {
        let n = self.len();
        require::<T>(what, n)?;
        Ok((0..n).map(|row| make(row, self.row(row))).collect())
    }
}
