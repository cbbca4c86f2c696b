//! Pictures and results as channels of numbers: out of arrays and files, and into arrays.

use std::path::PathBuf;

use kugelblitz::memory;
use kugelblitz::picture::{Channel, Image, Samples, read_image};
use numpy::{Element, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::error;
use crate::picture::Picture;
use crate::table::{helpers, to_python};
use crate::work;

/// Arrays of one shape as channels: what each is called in errors, and in its picture; and the array.
///
/// # Errors
/// `TypeError` for what is no array of numbers, `ValueError` for another shape than the others have, or than a
/// picture's or a list's; `MemoryError` where they don't fit.
pub fn image_of_parts<'py>(py: Python<'py>, parts: impl IntoPyObject<'py>) -> PyResult<Image> {
    let found = helpers(py)?.call_method1("channels", (parts,))?;
    let (axes, channels): (Vec<usize>, Vec<(String, Bound<'_, PyAny>)>) = found.extract()?;
    let is_list = axes.len() < 2;
    let [height, width] = if is_list { [1, axes[0]] } else { [axes[0], axes[1]] };
    let n = width.saturating_mul(height).saturating_mul(channels.len());
    memory::require(format!("{n} numbers"), (n as u64).saturating_mul(16), "give fewer")
        .map_err(error::of(""))?;
    let channel = |(name, numbers)| Ok(Channel { name, samples: samples(&numbers)? });
    Ok(Image {
        format: "array",
        width,
        height,
        is_list,
        whole: [width, height],
        channels: channels.into_iter().map(channel).collect::<PyResult<_>>()?,
        ..Image::default()
    })
}

/// The numbers of an array, row by row, in its own type.
fn samples(array: &Bound<'_, PyAny>) -> PyResult<Samples> {
    let descr = array.getattr("dtype")?;
    let (kind, size): (String, usize) =
        (descr.getattr("kind")?.extract()?, descr.getattr("itemsize")?.extract()?);
    fn numbers<T: Element + Copy>(array: &Bound<'_, PyAny>, dtype: &str) -> PyResult<Vec<T>> {
        let array = array.call_method1("astype", (dtype,))?.cast_into::<PyArrayDyn<T>>()?;
        Ok(array.readonly().as_array().iter().copied().collect())
    }
    Ok(match (&*kind, size) {
        ("u", 1) => Samples::U8(numbers(array, "u1")?),
        ("u", 2) => Samples::U16(numbers(array, "=u2")?),
        ("u", 4) => Samples::U32(numbers(array, "=u4")?),
        ("u" | "i", _) => Samples::I64(numbers(array, "=i8")?),
        ("f", 2) => Samples::F16(numbers(array, "=f4")?),
        ("f", 4) => Samples::F32(numbers(array, "=f4")?),
        _ => Samples::F64(numbers(array, "=f8")?),
    })
}

/// A channel as an array of shape (height, width), or (N,).
fn array_of<'py>(py: Python<'py>, image: &Image, samples: &Samples) -> PyResult<Bound<'py, PyAny>> {
    let flat = match samples {
        Samples::U8(all) => PyArray1::from_slice(py, all).into_any(),
        Samples::U16(all) => PyArray1::from_slice(py, all).into_any(),
        Samples::U32(all) => PyArray1::from_slice(py, all).into_any(),
        Samples::I64(all) => PyArray1::from_slice(py, all).into_any(),
        Samples::F16(all) => {
            PyArray1::from_slice(py, all).into_any().call_method1("astype", ("f2",))?
        }
        Samples::F32(all) => PyArray1::from_slice(py, all).into_any(),
        Samples::F64(all) => PyArray1::from_slice(py, all).into_any(),
    };
    match image.is_list {
        true => Ok(flat),
        false => flat.call_method1("reshape", ((image.height, image.width),)),
    }
}

/// Colours, where they are one array; ids, depths and normals of a structured array, a picture or hits.
///
/// # Errors
/// As [`image_of_parts`], and [`read_image`] for a path.
pub fn image_of(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Image> {
    let py = given.py();
    if given.is_instance_of::<PyString>() || given.hasattr("__fspath__")? {
        let path: PathBuf = given.extract()?;
        return work::run(py, |_| read_image(&path));
    }
    let parts = helpers(py)?.call_method1("parts", (name, given))?;
    let image = image_of_parts(py, parts)?;
    Ok(match given.cast::<Picture>() {
        Ok(picture) => picture.get().placed(image),
        Err(_) => image,
    })
}

/// What a picture's file says of itself, as `kugelblitz info --json` does: a dictionary.
#[pyfunction]
pub fn info<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let facts = work::run(py, |_| Ok(read_image(&path)?.facts(&path)))?;
    to_python(py, &facts)
}

/// Reads a picture or hits: a dictionary of arrays, one for each channel, named as the file names it.
#[pyfunction]
pub fn read<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyDict>> {
    let image = work::run(py, |_| read_image(&path))?;
    let dict = PyDict::new(py);
    for channel in &image.channels {
        dict.set_item(&channel.name, array_of(py, &image, &channel.samples)?)?;
    }
    Ok(dict)
}

/// The indices of pixels or rays as an array of int64.
pub fn indices(py: Python<'_>, all: impl Iterator<Item = usize>) -> Bound<'_, PyArray1<i64>> {
    PyArray1::from_iter(py, all.map(|index| index as i64))
}
