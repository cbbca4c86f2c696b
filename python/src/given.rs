//! A scene's parts out of Python's arguments.

use std::collections::HashMap;

use kugelblitz::scene::{Color, Coloring, Light, Plane, Samples, Scene, Sky, Spheres, schema};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use toml::Value;

use crate::array::{Numbers, n_masked};
use crate::error;
use crate::table::{key, scene_of, value, value_of};

pub fn planes_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Plane>> {
    Ok(scenes_of("planes", "plane", given)?.into_iter().flat_map(|scene| scene.planes).collect())
}

pub fn lights_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Light>> {
    Ok(scenes_of("lights", "light", given)?.into_iter().flat_map(|scene| scene.lights).collect())
}

/// A scene for each entry of the list argument `name`, which alone stands in it, under `key`.
fn scenes_of(name: &str, key: &str, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Scene>> {
    let scene = |(n, entry): (usize, Bound<'_, PyAny>)| {
        let subject = format!("{name}[{n}]");
        scene_of(&subject, key, Value::Array(vec![value(&subject, &entry)?]))
    };
    each(name, given)?.into_iter().enumerate().map(scene).collect()
}

pub fn sky_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Sky>> {
    let Some(sky) = given else { return Ok(None) };
    Ok(scene_of("sky", "sky", value("sky", sky)?)?.sky)
}

pub fn ambient_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Color>> {
    Ok(key("ambient", given, schema::ambient)?.map(|ambient| ambient.value))
}

pub fn usable_samples(samples: u32) -> PyResult<Samples> {
    Samples::new(samples).map_err(|_| {
        let most = Samples::MOST;
        PyValueError::new_err(format!(
            "samples: {samples}, but there are 1 to {most} across a pixel"
        ))
    })
}

/// Names for some or all of the spheres: a list with a name or None for each, or a dictionary by row.
pub fn name_all(spheres: &mut Spheres, names: &Bound<'_, PyAny>) -> PyResult<()> {
    let n = spheres.len();
    let rows: Vec<(usize, String)> = match names.extract::<HashMap<usize, String>>() {
        Ok(by_row) => by_row.into_iter().collect(),
        Err(_) => {
            let list: Vec<Option<String>> = names.extract().map_err(|_| {
                PyTypeError::new_err("names: give a name or None for each sphere, or {row: name}")
            })?;
            if list.len() != n {
                let message = format!("names: {} of them for {n} spheres", list.len());
                return Err(PyValueError::new_err(message));
            }
            list.into_iter().enumerate().filter_map(|(row, name)| Some((row, name?))).collect()
        }
    };
    for (row, name) in rows {
        if row >= n {
            let message = format!("names: row {row} (counted from 0), but there are {n} spheres");
            return Err(PyValueError::new_err(message));
        }
        spheres.set_name(row as u32, name);
    }
    Ok(())
}

/// Spheres with the colours of their numbers.
pub fn colored_by(
    spheres: Spheres,
    numbers: &Bound<'_, PyAny>,
    [colormap, range, missing_color]: [Option<&Bound<'_, PyAny>>; 3],
) -> PyResult<(Spheres, Coloring)> {
    let map = key("colormap", colormap, schema::colormap)?.map(|map| map.value).unwrap_or_default();
    let range = key("range", range, schema::range)?.map(|range| range.value);
    let missing_color =
        key("missing_color", missing_color, schema::color)?.map(|color| color.value);
    // A series of pandas says what it is called.
    let name = numbers.getattr("name").and_then(|name| name.extract::<String>());
    let name = name.unwrap_or_else(|_| "color_by".into());
    // What is masked is missing.
    let filled = n_masked(numbers)?
        .map(|_| numbers.call_method1("astype", ("f8",))?.call_method1("filled", (f64::NAN,)));
    let filled = filled.transpose()?;
    let numbers = Numbers::new("color_by", filled.as_ref().unwrap_or(numbers))?;
    let numbers = numbers.list("one number for each sphere")?;
    let missing_color = missing_color.unwrap_or(Coloring::MISSING_COLOR);
    spheres.with_numbers(&name, &numbers, map, range, missing_color).map_err(error::of("color_by"))
}

/// The entries of a list argument.
fn each<'py>(name: &str, given: Option<&Bound<'py, PyAny>>) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    if given.is_instance_of::<PyDict>() || given.is_instance_of::<PyString>() {
        let message = format!("{name}: give a list of dictionaries, also for one");
        return Err(PyTypeError::new_err(message));
    }
    let entries = given
        .try_iter()
        .map_err(|_| PyTypeError::new_err(format!("{name}: give a list of dictionaries")))?;
    entries.collect()
}

pub fn spheres_of(
    py: Python<'_>,
    spheres: &Bound<'_, PyAny>,
    radius: Option<&Bound<'_, PyAny>>,
    color: Option<&Bound<'_, PyAny>>,
) -> PyResult<Spheres> {
    let expected = "centres are (N, 3), and with radii (N, 4)";
    let spheres = Numbers::new("spheres", spheres)?;
    let n = spheres.shape().first().copied().unwrap_or(0);
    let rows: Vec<[f64; 4]> = match (spheres.shape(), radius) {
        ([_, 4], None) => spheres.table(4, expected)?.map("spheres", |_, row| row)?,
        ([_, 4], Some(_)) => {
            return Err(PyValueError::new_err(
                "radius: `spheres` has radii already, in its fourth column; leave one of them out",
            ));
        }
        ([_, 3], Some(radius)) => {
            let radii = Numbers::new("radius", radius)?;
            let radii = match radii.shape() {
                [] => Radii::One(radius.extract()?),
                [length] if *length == n => Radii::Each(radii.list("one radius for each sphere")?),
                _ => return Err(radii.wrong_shape(&format!("there are {n} spheres"))),
            };
            spheres.table(3, expected)?.map("spheres", |row, [x, y, z]| [x, y, z, radii.of(row)])?
        }
        ([_, 3], None) => {
            return Err(PyValueError::new_err(
                "radius: `spheres` has three columns, so give the radius of all, or one of each",
            ));
        }
        _ => return Err(spheres.wrong_shape(expected)),
    };
    let spheres = py.detach(|| Spheres::from_rows(rows)).map_err(error::of("spheres"))?;
    let Some(color) = color else { return Ok(spheres) };
    let one_for_all =
        color.is_instance_of::<PyString>() || { Numbers::new("color", color)?.shape().len() == 1 };
    if one_for_all {
        return spheres
            .with_color(value_of("color", color, schema::color)?)
            .map_err(error::of("color"));
    }
    let colors = Numbers::new("color", color)?;
    let is_bytes = colors.is_bytes;
    let linear: [f64; 256] = std::array::from_fn(|byte| Color::from_srgb8([byte as u8; 3]).0[0]);
    let colors = colors.table(3, "colours are (N, 3)")?.map("color", |_, row| match is_bytes {
        true => Color(row.map(|byte| linear[usize::from(byte as u8)])),
        false => Color(row),
    })?;
    spheres.with_colors(colors).map_err(error::of("color"))
}

/// Radii of spheres.
enum Radii {
    One(f64),
    Each(Vec<f64>),
}

impl Radii {
    fn of(&self, row: usize) -> f64 {
        match self {
            Radii::One(radius) => *radius,
            Radii::Each(radii) => radii[row],
        }
    }
}
