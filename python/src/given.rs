//! A scene's parts out of Python's arguments.

use kugelblitz::scene::{Color, Coloring, ImageSize, Scene, Spheres, schema};
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::argument::{Floats, Size, in_rows};
use crate::camera::Camera;
use crate::error;
use crate::table::{Given, Keywords, helpers, scene_of, value, value_of};

/// The keyword arguments that say what a scene has beside spheres.
pub const OF_SCENE: [&str; 8] =
    ["camera", "size", "samples", "planes", "lights", "sky", "ambient", "background"];

/// Gives a scene what these arguments say; None takes it away.
pub fn change(scene: &mut Scene, keys: &Keywords<'_>) -> PyResult<()> {
    for name in OF_SCENE {
        if !keys.0.contains(name)? {
            continue;
        }
        let given = &keys.get(name);
        match name {
            "camera" => {
                let wrong = |_| PyTypeError::new_err("camera: give a Camera");
                let camera = given.as_ref().map(|given| given.cast::<Camera>()).transpose();
                scene.camera = camera.map_err(wrong)?.map(|camera| camera.get().of_scene.clone());
            }
            "size" => {
                scene.image =
                    keys.extract(name)?.map(|Size([width, height])| ImageSize { width, height });
            }
            "samples" => scene.samples = keys.value(name, schema::samples)?,
            "planes" => scene.planes = each(name, "plane", given, |scene| scene.planes)?,
            "lights" => scene.lights = each(name, "light", given, |scene| scene.lights)?,
            "sky" => {
                let sky = given
                    .as_ref()
                    .map(|sky| scene_of(name, name, &value(name, sky)?))
                    .transpose()?;
                scene.sky = sky.and_then(|scene| scene.sky);
            }
            "ambient" => scene.ambient = keys.value(name, schema::ambient)?,
            "background" => {
                scene.background = keys.value(name, schema::color)?.unwrap_or_default();
            }
            _ => {}
        }
    }
    Ok(())
}

/// What the entries of the list argument `name` say, of which each alone stands under `key` of a scene.
fn each<T>(name: &str, key: &str, given: &Given<'_>, of: fn(Scene) -> Vec<T>) -> PyResult<Vec<T>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    let entries = helpers(given.py())?.call_method1("entries", (name, given))?;
    let mut all = Vec::new();
    for (n, entry) in entries.extract::<Vec<String>>()?.iter().enumerate() {
        all.extend(of(scene_of(&format!("{name}[{n}]"), key, &format!("[{entry}]"))?));
    }
    Ok(all)
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
            let linear = |byte| Color::from_srgb8([byte as u8; 3]).0[0];
            let linear: [f64; 256] = std::array::from_fn(linear);
            let row = |row: &[u8; 3]| row.map(|byte| linear[usize::from(byte)]);
            spheres.with_colors(in_rows(&rows)?.iter().map(row))
        }
    };
    colored.map_err(error::of("color"))
}
