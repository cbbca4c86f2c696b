//! Pictures and results as channels of numbers: out of arrays and files, and into arrays.

use std::path::PathBuf;

use kugelblitz::memory;
use kugelblitz::picture::{Channel, Image, Samples, read_image};
use numpy::{Element, PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice, PyString};

use crate::array::untyped;
use crate::error;
use crate::picture::Picture;
use crate::table::to_python;
use crate::work;

/// Adds the channels of an array to those of others: `names` has one, or three along the array's last axis.
///
/// # Errors
/// `TypeError` for what is no array of numbers, `ValueError` for another shape than the others have, or than a
/// picture's or a list's.
pub fn add_channels(
    image: &mut Option<Image>,
    name: &str,
    given: &Bound<'_, PyAny>,
    names: &[&str],
) -> PyResult<()> {
    let array = untyped(name, given)?;
    let last = if names.len() > 1 { &[names.len()][..] } else { &[] };
    let axes = array.shape();
    let wrong = |expected: String| {
        PyValueError::new_err(format!("{name}: the shape is {axes:?}, but {expected}"))
    };
    let (width, height, is_list) = match axes.strip_suffix(last) {
        Some(&[height, width]) => (width, height, false),
        Some(&[n]) => (n, 1, true),
        _ => {
            let parts = if last.is_empty() { "" } else { ", 3" };
            return Err(wrong(format!(
                "it is (height, width{parts}) for a picture, (N{parts}) for rays"
            )));
        }
    };
    let image = image.get_or_insert_with(|| Image {
        format: "array",
        width,
        height,
        is_list,
        whole: [width, height],
        ..Image::default()
    });
    if (image.width, image.height, image.is_list) != (width, height, is_list) {
        return Err(wrong(match image.is_list {
            true => format!("there are {} rays", image.width),
            false => format!("there are {} rows and {} columns", image.height, image.width),
        }));
    }
    let n = image.len();
    let bytes = (n as u64).saturating_mul(16 * names.len() as u64);
    memory::require(format!("{name}: {n} numbers"), bytes, "give fewer").map_err(error::of(""))?;
    let flat = array.call_method1("reshape", ((n, names.len()),))?;
    for (column, name) in names.iter().enumerate() {
        let all = flat.get_item((PySlice::full(flat.py()), column))?;
        image.channels.push(Channel { name: (*name).into(), samples: samples(&all)? });
    }
    Ok(())
}

/// The numbers of an array with one axis, in its own type.
fn samples(array: &Bound<'_, PyAny>) -> PyResult<Samples> {
    let descr = array.getattr("dtype")?;
    let (kind, size): (String, usize) =
        (descr.getattr("kind")?.extract()?, descr.getattr("itemsize")?.extract()?);
    fn numbers<T: Element + Copy>(array: &Bound<'_, PyAny>, dtype: &str) -> PyResult<Vec<T>> {
        let array = array.call_method1("astype", (dtype,))?.cast_into::<PyArray1<T>>()?;
        Ok(array.readonly().as_array().to_vec())
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
/// As [`add_channels`], and [`read_image`] for a path.
pub fn image_of(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Image> {
    if given.is_instance_of::<PyString>() || given.hasattr("__fspath__")? {
        let path: PathBuf = given.extract()?;
        return work::run(given.py(), |_| read_image(&path));
    }
    let picture = given.cast::<Picture>().ok();
    let fields = match given.getattr("dtype").and_then(|dtype| dtype.getattr("names")) {
        _ if picture.is_some() => ["rgb8", "id", "t", "normal"].map(String::from).to_vec(),
        Ok(names) if !names.is_none() => names.extract()?,
        _ => Vec::new(),
    };
    let mut image = None;
    if fields.is_empty() {
        add_channels(&mut image, name, given, &["R", "G", "B"])?;
    }
    for field in fields {
        let names: &[&str] = match &*field {
            "t" => &["Z"],
            "normal" => &["N.X", "N.Y", "N.Z"],
            "rgb" | "rgb8" => &["R", "G", "B"],
            other => &[other],
        };
        let part = match picture {
            Some(picture) => picture.getattr(&*field)?,
            None => given.get_item(&*field)?,
        };
        add_channels(&mut image, &format!("{name}[{field:?}]"), &part, names)?;
    }
    let image = image.ok_or_else(|| PyTypeError::new_err(format!("{name}: no fields")))?;
    Ok(match picture {
        Some(picture) => picture.get().placed(image),
        None => image,
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
