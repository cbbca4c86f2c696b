//! A scene's parts out of Python's arguments.

use std::mem;

use kugelblitz::scene::{Coloring, Scene, Spheres, linear_of_bytes, schema};
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::argument::{Floats, Size, in_rows};
use crate::camera::Camera;
use crate::error;
use crate::table::{Given, Keywords, helpers, scene_of, value_of};

/// The keyword arguments that say what a scene has beside spheres.
pub const OF_SCENE: [&str; 8] =
    ["camera", "size", "samples", "planes", "lights", "sky", "ambient", "background"];

/// Gives a scene what these arguments say; None takes it away.
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

/// The spheres of a scene, and how numbers became their colours.
pub fn spheres_of(
    py: Python<'_>,
    rows: Given<'_>,
    keys: &Keywords<'_>,
) -> PyResult<(Spheres, Option<Coloring>)> {
    let made = helpers(py)?.call_method("spheres", (rows,), Some(&keys.0))?;
    let Some((rows, colors, numbers, names)) = made.extract::<Option<OfSpheres<'_>>>()? else {
        return Ok((Spheres::default(), None));
    };
    let (mut spheres, mut coloring) = (colored(py, in_rows(&rows)?, colors)?, None);
    if let Some((name, numbers)) = numbers {
        let map = keys.value("colormap", schema::colormap)?.unwrap_or_default();
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
