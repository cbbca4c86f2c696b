//! Drawings and pictures that no camera took, see `_drawings.py`.

use std::path::PathBuf;
use std::sync::Arc;

use kugelblitz::Error;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::rgb8_file;
use kugelblitz::scene::parse_scene;
use kugelblitz_judge::figure::Figure;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::argument::{Size, named, pixels_of};
use crate::camera::PyCamera;
use crate::error;
use crate::scene::PyScene;
use crate::table::PyValue;
use crate::work;

/// A `Drawing`.
pub fn drawing(py: Python<'_>, svg: String) -> PyValue<'_> {
    py.import("kugelblitz._drawings")?.call_method1("Drawing", (svg,))
}

/// Colour, meaning, and how many pixels have it where they are counted.
type Legend = Vec<(String, String, Option<u64>)>;

/// A `Tinted`.
pub fn tinted<'py>(
    py: Python<'py>,
    size: [u32; 2],
    colors: &[[u8; 3]],
    legend: Legend,
) -> PyValue<'py> {
    let [width, height] = size.map(|n| n as usize);
    let rgb8 = PyArray1::from_slice(py, colors.as_flattened()).reshape([height, width, 3])?;
    py.import("kugelblitz._drawings")?.call_method1("Tinted", (rgb8, legend))
}

/// The PNG file of a picture of bytes.
#[pyfunction]
pub fn png<'py>(py: Python<'py>, size: [u32; 2], colors: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
    let (colors, _) = colors.as_chunks();
    let file = rgb8_file(size, colors).map_err(Error::io("picture")).map_err(error::of(""))?;
    Ok(PyBytes::new(py, &file))
}

/// Writes a file that appears whole or not at all.
#[pyfunction]
pub fn write(py: Python<'_>, path: PathBuf, content: &[u8]) -> PyResult<()> {
    work::run(py, |control| {
        let file = OutputFile::create(&path, false)?.filled(content)?;
        output::commit([file], control)
    })
}

/// Draws one of the lecture's figures: 3, a plane, and 4, a sphere, as the camera sees them; 2, rays of the camera, and 5, the
/// discriminants of one, as plans.
///
/// `scene` is the lecture's unless one is given, and `object` the id of all that is drawn of it; without one, 3 and 4 show the first
/// plane or sphere. `size` is (columns, rows), `lang` "en" or "de". Figures 3 and 4 fit over the picture of their size.
#[pyfunction]
#[pyo3(signature = (number, scene = None, camera = None, *, size = None, object = None, lang = "en"))]
pub fn figure<'py>(
    py: Python<'py>,
    number: &Bound<'py, PyAny>,
    scene: Option<&PyScene>,
    camera: Option<&PyCamera>,
    size: Option<Size>,
    object: Option<u32>,
    lang: &str,
) -> PyValue<'py> {
    let number = number.str()?.to_string();
    let figure = named("number", &number, Figure::ALL, Figure::number)?;
    let scene = match scene {
        Some(scene) => Arc::clone(&scene.of),
        None => {
            let (name, text) = figure.scene();
            Arc::new(parse_scene(text, name.as_ref()).map_err(error::of(""))?)
        }
    };
    let pixels = pixels_of(py, &scene, camera, size, None)?;
    let drawn = figure.draw(&scene, object, &pixels, crate::explain::lang(lang)?);
    let argument = if object.is_some() { "object" } else { "scene" };
    drawing(py, drawn.map_err(error::of(argument))?)
}
