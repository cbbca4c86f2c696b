//! A scene's parts out of Python's arguments.

use std::mem;

use kugelblitz::scene::{self, Color, ColorMap, Coloring, Scene, Spheres, linear_of_bytes, schema};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use rayon::prelude::*;

use crate::argument::{Floats, Size, in_rows};
use crate::camera::Camera;
use crate::error::{self, wrong_value};
use crate::table::{Given, Keywords, helpers, scene_of, value_of};
use crate::work;

/// The keyword arguments that say what a scene has beside spheres.
pub const OF_SCENE: [&str; 8] =
    ["camera", "size", "samples", "planes", "lights", "sky", "ambient", "background"];

/// The arguments of [`OF_SCENE`], and of spheres, that are one colour.
pub const COLORS: [&str; 3] = ["background", "ambient", "missing_color"];

/// Applies these arguments, whose colours are linear, to a scene; None takes a part away.
pub fn change(scene: &mut Scene, keys: &Keywords<'_>) -> PyResult<()> {
    let lines = helpers(keys.0.py())?.call_method1("scene", (&keys.0,))?;
    let mut said = scene_of(&lines.extract::<Vec<(String, String)>>()?)?;
    for name in OF_SCENE {
        if !keys.0.contains(name)? {
            continue;
        }
        match name {
            "camera" => {
                let wrong = |_| PyTypeError::new_err("camera: give a Camera");
                let camera = keys.get(name).map(|given| given.cast_into::<Camera>()).transpose();
                scene.camera = camera.map_err(wrong)?.map(|camera| camera.get().of_scene.clone());
            }
            "size" => {
                let size = keys.extract(name)?;
                scene.image = size.map(|Size(size)| size);
            }
            "samples" => scene.samples = keys.value(name, schema::samples)?,
            "planes" => scene.planes = mem::take(&mut said.planes),
            "lights" => scene.lights = mem::take(&mut said.lights),
            "sky" => scene.sky = said.sky.take(),
            "ambient" => scene.ambient = said.ambient,
            _ => scene.background = said.background,
        }
    }
    Ok(())
}

/// The keyword arguments that are of spheres.
pub const OF_SPHERES: [&str; 7] =
    ["radius", "color", "color_by", "colormap", "range", "missing_color", "names"];

/// What `_given.spheres` makes of arguments: rows, colours, the name and the numbers of `color_by`, and names.
type OfSpheres<'py> =
    (Floats<'py>, Option<Colors<'py>>, Option<(String, Floats<'py>)>, Vec<(u32, String)>);

/// The colour of each sphere, or of all.
#[derive(FromPyObject)]
pub enum Colors<'py> {
    Bytes(PyReadonlyArray2<'py, u8>),
    Linear(PyReadonlyArray2<'py, f64>),
    One(Bound<'py, PyAny>),
}

/// The spheres of a scene, and how numbers became their colours. Floats of `color` are encoded in sRGB unless `is_linear`.
pub fn spheres_of(
    py: Python<'_>,
    rows: Given<'_>,
    keys: &Keywords<'_>,
    is_linear: bool,
) -> PyResult<(Spheres, Option<Coloring>)> {
    let made = helpers(py)?.call_method("spheres", (rows, is_linear), Some(&keys.0))?;
    let Some((rows, colors, numbers, names)) = made.extract::<Option<OfSpheres<'_>>>()? else {
        return Ok((Spheres::default(), None));
    };
    let (mut spheres, mut coloring) = (colored(py, in_rows(&rows)?, colors)?, None);
    if let Some((name, numbers)) = numbers {
        let map = match named_map(keys)? {
            Some(map) => map,
            None => match keys.get("colormap") {
                Some(map) => sampled(&map, is_linear)?,
                None => ColorMap::default(),
            },
        };
        let range = keys.value("range", schema::range)?;
        let missing_color = keys.value("missing_color", schema::color)?;
        let missing_color = missing_color.unwrap_or(Coloring::MISSING_COLOR);
        let (colored, made) = spheres
            .with_numbers(&name, numbers.as_slice()?, map, range, missing_color)
            .map_err(error::of("color_by"))?;
        (spheres, coloring) = (colored, Some(made));
    }
    names.into_iter().for_each(|(row, name)| spheres.set_name(row, name));
    Ok((spheres, coloring))
}

/// Returns the map that `colormap` names, or whose `name` the library knows; `None` for a map that is called with numbers,
/// and without the argument.
///
/// # Errors
/// [`crate::error::SceneError`] for a name that is not known.
pub fn named_map(keys: &Keywords<'_>) -> PyResult<Option<ColorMap>> {
    let Some(given) = keys.get("colormap") else { return Ok(None) };
    let name = given.getattr("name").and_then(|name| name.extract::<String>());
    if let Some(map) = name.ok().and_then(|name| ColorMap::from_name(&name)) {
        return Ok(Some(map));
    }
    if given.is_callable() && !given.is_instance_of::<PyString>() {
        return Ok(None);
    }
    keys.value("colormap", schema::colormap)
}

/// Returns the map of the colours that `map` gives for numbers from 0 to 1.
fn sampled(map: &Bound<'_, PyAny>, is_linear: bool) -> PyResult<ColorMap> {
    let colors = helpers(map.py())?.call_method1("sampled", (map, ColorMap::LEN, is_linear))?;
    let colors: [[f64; 3]; ColorMap::LEN] = colors.extract()?;
    Ok(ColorMap::from_srgb8(colors.map(|linear| Color(linear).to_srgb8())))
}

/// Returns the linear colours of colours in sRGB, a row each.
///
/// # Errors
/// `ValueError` names the first row with numbers that are not from 0 to 1.
#[pyfunction]
pub fn linear_from_srgb<'py>(
    py: Python<'py>,
    encoded: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let mut rows: Vec<[f64; 3]> = in_rows(&encoded)?.to_vec();
    let n = rows.len();
    let (rows, wrong) = work::run(py, |_| {
        let is_wrong = |row: &[f64; 3]| !row.iter().all(|number| (0.0..=1.0).contains(number));
        let wrong = rows.iter().position(is_wrong);
        rows.par_iter_mut().for_each(|row| *row = row.map(scene::linear_from_srgb));
        Ok((rows, wrong))
    })?;
    if let Some(row) = wrong {
        let found = in_rows::<_, _, 3>(&encoded)?[row];
        let is_byte = |number: f64| number == number.trunc() && (0.0..=255.0).contains(&number);
        let advice = if found.into_iter().all(is_byte) { ", or bytes (uint8)" } else { "" };
        let [red, green, blue] = found;
        return wrong_value(format!(
            "color: row {row} (counted from 0): expected red, green and blue from 0 to 1{advice}, found \
             ({red:?}, {green:?}, {blue:?})"
        ));
    }
    PyArray1::from_vec(py, rows.into_flattened()).reshape([n, 3])
}

/// Spheres of rows of centres and radii, with their colours.
pub fn colored(py: Python<'_>, rows: &[[f64; 4]], colors: Option<Colors<'_>>) -> PyResult<Spheres> {
    let spheres = py.detach(|| Spheres::from_rows(rows)).map_err(error::of("spheres"))?;
    let colored = match colors {
        None => return Ok(spheres),
        Some(Colors::One(color)) => spheres.with_color(value_of("color", &color, schema::color)?),
        Some(Colors::Linear(rows)) => {
            spheres.with_colors(in_rows::<_, _, 3>(&rows)?.iter().copied())
        }
        Some(Colors::Bytes(rows)) => {
            let linear = linear_of_bytes();
            let row = |row: &[u8; 3]| row.map(|byte| linear[usize::from(byte)]);
            spheres.with_colors(in_rows(&rows)?.iter().map(row))
        }
    };
    colored.map_err(error::of("color"))
}
