//! Pictures and results as channels of numbers: out of arrays and files, and into arrays.

use std::path::PathBuf;

use kugelblitz::picture::{Channel, ChannelValues, Image, channel_name, read_image};
use kugelblitz::support::memory;
use numpy::{Element, PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error;
use crate::picture::PyPicture;
use crate::table::{PyValue, helpers, to_python};
use crate::work;

/// The numbers of a channel as an array.
fn array_of<'py>(py: Python<'py>, samples: &ChannelValues) -> PyValue<'py> {
    fn array<'py, T: Element>(py: Python<'py>, numbers: &[T]) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, numbers).into_any()
    }
    Ok(match samples {
        ChannelValues::U8(all) => array(py, all),
        ChannelValues::U16(all) => array(py, all),
        ChannelValues::U32(all) => array(py, all),
        ChannelValues::I64(all) => array(py, all),
        ChannelValues::F16(all) => array(py, all).call_method1("astype", ("f2",))?,
        ChannelValues::F32(all) => array(py, all),
        ChannelValues::F64(all) => array(py, all),
    })
}

/// The numbers of an array, row by row.
#[derive(FromPyObject)]
enum BorrowedNumbers<'py> {
    U8(PyReadonlyArrayDyn<'py, u8>),
    U16(PyReadonlyArrayDyn<'py, u16>),
    U32(PyReadonlyArrayDyn<'py, u32>),
    I64(PyReadonlyArrayDyn<'py, i64>),
    F32(PyReadonlyArrayDyn<'py, f32>),
    F64(PyReadonlyArrayDyn<'py, f64>),
    /// Floats of 16 bits.
    F16(Bound<'py, PyAny>),
}

impl BorrowedNumbers<'_> {
    /// Returns the element at this place of each pixel, which has `n_elements`.
    fn channel(&self, place: usize, n_elements: usize) -> PyResult<ChannelValues> {
        fn every<T: Element + Copy>(
            all: &PyReadonlyArrayDyn<'_, T>,
            place: usize,
            n_elements: usize,
        ) -> PyResult<Vec<T>> {
            Ok(all.as_slice()?.iter().skip(place).step_by(n_elements).copied().collect())
        }
        Ok(match self {
            BorrowedNumbers::U8(all) => ChannelValues::U8(every(all, place, n_elements)?),
            BorrowedNumbers::U16(all) => ChannelValues::U16(every(all, place, n_elements)?),
            BorrowedNumbers::U32(all) => ChannelValues::U32(every(all, place, n_elements)?),
            BorrowedNumbers::I64(all) => ChannelValues::I64(every(all, place, n_elements)?),
            BorrowedNumbers::F32(all) => ChannelValues::F32(every(all, place, n_elements)?),
            BorrowedNumbers::F64(all) => ChannelValues::F64(every(all, place, n_elements)?),
            BorrowedNumbers::F16(all) => {
                let all = all.call_method1("astype", ("f4",))?.extract()?;
                ChannelValues::F16(every(&all, place, n_elements)?)
            }
        })
    }
}

/// Arrays as `_given.channels` returns them: height and width, or the number of rays; and name, numbers and elements per
/// pixel of each field, `None` for a single number.
#[derive(FromPyObject)]
pub struct Arrays<'py>(Vec<usize>, Vec<(String, BorrowedNumbers<'py>, Option<usize>)>);

impl Arrays<'_> {
    /// Returns the fields as channels.
    pub fn image(&self) -> PyResult<Image> {
        let Arrays(shape, fields) = self;
        let mut channels = Vec::new();
        for (field, numbers, n_elements) in fields {
            for place in 0..n_elements.unwrap_or(1) {
                let name = channel_name(field, n_elements.map(|_| place));
                let samples = numbers.channel(place, n_elements.unwrap_or(1))?;
                channels.push(Channel { name, samples });
            }
        }
        let (width, height, is_list) = match shape[..] {
            [height, width] => (width, height, false),
            _ => (shape.iter().product(), 1, true),
        };
        let whole = [width, height];
        Ok(Image { format: "array", width, height, is_list, whole, channels, ..Image::default() })
    }
}

/// Returns the channels of a `Picture`, of a file, or of an array.
///
/// # Errors
/// Returns the errors of [`read_image`], and `TypeError` or `ValueError` for an array that is no picture.
pub fn image_of(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Image> {
    let py = given.py();
    if let Ok(picture) = given.cast::<PyPicture>() {
        return picture.get().image(py);
    }
    if let Ok(path) = given.extract::<PathBuf>() {
        return work::run(py, |_| read_image(&path));
    }
    helpers(py)?.call_method1("picture", (name, given))?.extract::<Arrays<'_>>()?.image()
}

/// Refuses what needs more memory than there is.
#[pyfunction]
pub fn require(what: String, n_bytes: u64) -> PyResult<()> {
    memory::require(what, n_bytes, "give fewer").map_err(error::of(""))
}

/// What a picture's file says of itself, as `kugelblitz info --json` does: a dictionary.
#[pyfunction]
pub fn info<'py>(py: Python<'py>, path: PathBuf) -> PyValue<'py> {
    let facts = work::run(py, |_| Ok(read_image(&path)?.facts(&path)))?;
    to_python(py, &facts)
}

/// Reads a picture or hits: a dictionary of arrays, one for each channel, named as the file names it.
#[pyfunction]
pub fn read<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyDict>> {
    let image = work::run(py, |_| read_image(&path))?;
    let shape = if image.is_list { vec![image.width] } else { vec![image.height, image.width] };
    let dict = PyDict::new(py);
    for channel in &image.channels {
        let numbers = array_of(py, &channel.samples)?.call_method1("reshape", (&shape,))?;
        dict.set_item(&channel.name, numbers)?;
    }
    Ok(dict)
}

/// The indices of pixels or rays as an array of int64.
pub fn indices(py: Python<'_>, all: impl Iterator<Item = usize>) -> Bound<'_, PyArray1<i64>> {
    PyArray1::from_iter(py, all.map(|index| index as i64))
}
