//! Pictures and results as channels of numbers: out of arrays and files, and into arrays.

use std::path::{Path, PathBuf};

use kugelblitz::memory;
use kugelblitz::picture::{Channel, Image, Samples, read_image};
use numpy::{Element, PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice, PyString};
use serde_json::json;

use crate::array::untyped;
use crate::error;
use crate::picture::Picture;
use crate::table::to_python;
use crate::work;

/// The lengths of the axes of pixels, or of a list.
#[derive(Clone, Copy, PartialEq)]
pub enum Shape {
    /// Rows and columns.
    Picture([usize; 2]),
    /// Results of rays.
    List(usize),
}

impl Shape {
    fn n(self) -> usize {
        match self {
            Shape::Picture([height, width]) => height * width,
            Shape::List(n) => n,
        }
    }

    fn in_words(self) -> String {
        match self {
            Shape::Picture([height, width]) => format!("{height} rows and {width} columns"),
            Shape::List(n) => format!("{n} rays"),
        }
    }

    /// Nothing yet of a picture or a list of this shape.
    pub fn image(self) -> Image {
        let (width, height, is_list) = match self {
            Shape::Picture([height, width]) => (width, height, false),
            Shape::List(n) => (n, 1, true),
        };
        Image {
            format: "array",
            width,
            height,
            is_list,
            whole: [width, height],
            ..Image::default()
        }
    }
}

/// The channels of an array: `names` has one, or three along the array's last axis.
///
/// # Errors
/// `TypeError` for what is no array of numbers, `ValueError` for another shape than `shape`, where it is
/// known, or than a picture's or a list's.
pub fn channels(
    name: &str,
    given: &Bound<'_, PyAny>,
    names: &[&str],
    shape: Option<Shape>,
) -> PyResult<(Shape, Vec<Channel>)> {
    let array = untyped(name, given)?;
    let last = if names.len() > 1 { &[names.len()][..] } else { &[] };
    let axes = array.shape().to_vec();
    let found = match axes.strip_suffix(last) {
        Some([height, width]) => Shape::Picture([*height, *width]),
        Some([n]) => Shape::List(*n),
        _ => {
            let parts = if last.is_empty() { "" } else { ", 3" };
            let expected = format!("(height, width{parts}) for a picture, (N{parts}) for rays");
            let message = format!("{name}: the shape is {axes:?}, but it is {expected}");
            return Err(PyValueError::new_err(message));
        }
    };
    if let Some(shape) = shape.filter(|shape| *shape != found) {
        let shape = shape.in_words();
        return Err(PyValueError::new_err(format!(
            "{name}: the shape is {axes:?}, but there are {shape}"
        )));
    }
    let bytes = (found.n() as u64).saturating_mul(16 * names.len() as u64);
    memory::require(format!("{name}: {} numbers", found.n()), bytes, "give fewer")
        .map_err(error::of(""))?;
    let flat = array.call_method1("reshape", ((found.n(), names.len()),))?;
    let channel = |(column, name): (usize, &&str)| {
        let all = flat.get_item((PySlice::full(flat.py()), column))?;
        Ok(Channel { name: (*name).into(), samples: samples(&all)? })
    };
    let channels = names.iter().enumerate().map(channel).collect::<PyResult<_>>()?;
    Ok((found, channels))
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
/// As [`channels`], and [`read_image`] for a path.
pub fn image_of(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Image> {
    if let Ok(picture) = given.cast::<Picture>() {
        return picture.get().image(given.py());
    }
    if given.is_instance_of::<PyString>() || given.hasattr("__fspath__")? {
        let path: PathBuf = given.extract()?;
        return work::run(given.py(), None, 0, |_| read_image(&path));
    }
    let fields = match given.getattr("dtype").and_then(|dtype| dtype.getattr("names")) {
        Ok(names) if !names.is_none() => names.extract::<Vec<String>>()?,
        _ => Vec::new(),
    };
    if fields.is_empty() {
        let (shape, channels) = channels(name, given, &["R", "G", "B"], None)?;
        return Ok(Image { channels, ..shape.image() });
    }
    let mut image: Option<(Shape, Image)> = None;
    for field in fields {
        let part = given.get_item(&*field)?;
        let names: &[&str] = match &*field {
            "t" => &["Z"],
            "normal" => &["N.X", "N.Y", "N.Z"],
            "rgb" | "rgb8" => &["R", "G", "B"],
            other => &[other],
        };
        let what = format!("{name}[{field:?}]");
        let (shape, channels) =
            channels(&what, &part, names, image.as_ref().map(|(shape, _)| *shape))?;
        let (_, image) = image.get_or_insert_with(|| (shape, shape.image()));
        image.channels.extend(channels);
    }
    image.map(|(_, image)| image).ok_or_else(|| PyTypeError::new_err(format!("{name}: no fields")))
}

/// What a picture's file says of itself, as `kugelblitz info --json` does: a dictionary.
#[pyfunction]
pub fn info<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let image = work::run(py, None, 0, |_| read_image(&path))?;
    facts(py, &image, &path)
}

fn facts<'py>(py: Python<'py>, image: &Image, path: &Path) -> PyResult<Bound<'py, PyAny>> {
    let is_part = image.whole != [image.width, image.height] || image.first != [0, 0];
    let [x, y] = image.first;
    let channel = |c: &Channel| json!({ "name": c.name, "type": c.samples.kind() });
    let metadata: serde_json::Map<String, serde_json::Value> =
        image.texts.iter().map(|(name, text)| (name.clone(), text.clone().into())).collect();
    to_python(
        py,
        &json!({
            "file": path.display().to_string(),
            "format": image.format,
            "size": [image.width, image.height],
            "window": is_part.then_some((x, y, image.width, image.height)),
            "whole": image.whole,
            "is_list": image.is_list,
            "channels": image.channels.iter().map(channel).collect::<Vec<_>>(),
            "metadata": metadata,
            "levels": image.stage_counts(),
        }),
    )
}

/// Reads a picture or hits: a dictionary of arrays, one for each channel, named as the file names it.
#[pyfunction]
pub fn read<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyDict>> {
    let image = work::run(py, None, 0, |_| read_image(&path))?;
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
