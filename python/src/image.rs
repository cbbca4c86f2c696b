//! Pictures and results as channels of numbers: out of arrays and files, and into arrays.

use std::path::PathBuf;

use kugelblitz::memory;
use kugelblitz::picture::{ChannelValues, Image, read_bytes, read_image};
use numpy::{Element, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error;
use crate::picture::Picture;
use crate::table::{Object, to_python};
use crate::work;

/// The numbers of a channel as an array.
fn array_of<'py>(py: Python<'py>, samples: &ChannelValues) -> Object<'py> {
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

/// A picture as `_given.picture` gives it: the path of its file, or the bytes of an NPY file of arrays, and the
/// [`Picture`] that they are of.
pub type Found<'py> = (Bound<'py, PyAny>, Option<Bound<'py, Picture>>);

/// The channels of a picture that was given.
///
/// # Errors
/// Those of [`read_image`].
pub fn image_of((found, picture): Found<'_>) -> PyResult<Image> {
    let py = found.py();
    let Ok(file) = found.cast::<PyBytes>() else {
        let path: PathBuf = found.extract()?;
        return work::run(py, |_| read_image(&path));
    };
    let image = read_bytes(file.as_bytes(), "array".as_ref()).map_err(error::of(""))?;
    let image = Image { format: "array", ..image };
    Ok(match picture {
        Some(picture) => picture.get().placed(image),
        None => image,
    })
}

/// Refuses what needs more memory than there is.
#[pyfunction]
pub fn require(what: String, n_bytes: u64) -> PyResult<()> {
    memory::require(what, n_bytes, "give fewer").map_err(error::of(""))
}

/// What a picture's file says of itself, as `kugelblitz info --json` does: a dictionary.
#[pyfunction]
pub fn info<'py>(py: Python<'py>, path: PathBuf) -> Object<'py> {
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
