//! A scene's parts out of Python's arguments.

use kugelblitz::scene::schema::{self, Argument, LightKeys, PlaneKeys, SkyKeys, read_argument};
use kugelblitz::scene::{ColorMap, Coloring, Scene, Spheres, linear_from_srgb, linear_of_bytes};
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use rayon::prelude::*;

use crate::argument::{Floats, Size, in_rows};
use crate::camera::PyCamera;
use crate::error::{self, wrong_value};
use crate::table::{Given, Keywords, color_of, helpers, wrong_argument};
use crate::work;

/// The keyword arguments that say what a scene has beside spheres.
pub const OF_SCENE: [&str; 8] =
    ["camera", "size", "samples", "planes", "lights", "sky", "ambient", "background"];

/// Applies these arguments to a scene; None takes a part away.
pub fn change(scene: &mut Scene, keys: &Keywords<'_>) -> PyResult<()> {
    // The camera of a picture may be another one than the scene's.
    let eye = Default::default();
    for name in OF_SCENE {
        if !keys.given.contains(name)? {
            continue;
        }
        match name {
            "camera" => {
                let wrong = |_| PyTypeError::new_err("camera: give a Camera");
                let camera = keys.get(name).map(|given| given.cast_into::<PyCamera>()).transpose();
                scene.camera = camera.map_err(wrong)?.map(|camera| camera.get().of_scene.clone());
            }
            "size" => {
                let size = keys.extract(name)?;
                scene.image = size.map(|Size(size)| size);
            }
            "samples" => scene.samples = keys.value(name, schema::samples)?,
            "planes" => scene.planes = keys.sections(name, |plane: PlaneKeys| plane.plane(eye))?,
            "lights" => scene.lights = keys.sections(name, |light: LightKeys| light.light(eye))?,
            "sky" => {
                let sky: Option<SkyKeys> = keys.value(name, schema::table)?;
                let sky = sky.map(|sky| sky.sky()).transpose();
                scene.sky = sky.map_err(|fault| wrong_argument(name, &fault))?;
            }
            "ambient" => scene.ambient = keys.color(name)?,
            _ => scene.background = keys.color(name)?.unwrap_or_default(),
        }
    }
    Ok(())
}

/// The keyword arguments that are of spheres.
pub const OF_SPHERES: [&str; 7] =
    ["radius", "color", "color_by", "colormap", "range", "missing_color", "names"];

/// What `_given.spheres` makes of arguments: rows, colours, the name and the numbers of `color_by`, and names.
type OfSpheres<'py> =
    (Floats<'py>, Option<GivenColors<'py>>, Option<(String, Floats<'py>)>, Vec<(u32, String)>);

/// The colour of each sphere, or of all.
#[derive(FromPyObject)]
pub enum GivenColors<'py> {
    Bytes(PyReadonlyArray2<'py, u8>),
    Floats(PyReadonlyArray2<'py, f64>),
    Names(Vec<String>),
    One(Bound<'py, PyAny>),
}

/// The spheres of a scene, and how numbers became their colours.
pub fn spheres_of(
    py: Python<'_>,
    rows: Given<'_>,
    keys: &Keywords<'_>,
) -> PyResult<(Spheres, Option<Coloring>)> {
    let made = helpers(py)?.call_method("spheres", (rows,), Some(&keys.given))?;
    let Some((rows, colors, numbers, names)) = made.extract::<Option<OfSpheres<'_>>>()? else {
        return Ok((Spheres::default(), None));
    };
    let spheres = colored(py, in_rows(&rows)?, colors, keys.is_linear)?;
    let (mut spheres, mut coloring) = (spheres, None);
    if let Some((name, numbers)) = numbers {
        let map = match named_map(keys)? {
            Some(map) => map,
            None => match keys.get("colormap") {
                Some(map) => sampled(&map, keys.is_linear)?,
                None => ColorMap::default(),
            },
        };
        let range = keys.value("range", schema::range)?;
        let missing_color = keys.color("missing_color")?.unwrap_or(Coloring::MISSING_COLOR);
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

/// Samples a colour map that is called with numbers from 0 to 1, like the colour maps of matplotlib.
fn sampled(map: &Bound<'_, PyAny>, is_linear: bool) -> PyResult<ColorMap> {
    let mut colors = [[0; 3]; ColorMap::LEN];
    for (place, color) in colors.iter_mut().enumerate() {
        let number = place as f64 / (ColorMap::LEN - 1) as f64;
        let subject = format!("colormap: called with {number:?}");
        let found = map.call1((number,)).map_err(|error| {
            let raised = PyTypeError::new_err(format!("{subject}, it raised {error}"));
            raised.set_cause(map.py(), Some(error));
            raised
        })?;
        *color = color_of(&subject, &found, is_linear)?.to_srgb8();
    }
    Ok(ColorMap::from_srgb8(colors))
}

/// Converts rows of floats in sRGB to linear colours.
///
/// # Errors
/// `ValueError` names the first row with numbers that are not from 0 to 1.
fn linear_of_floats(py: Python<'_>, rows: &[[f64; 3]]) -> PyResult<Vec<[f64; 3]>> {
    let is_wrong = |row: &[f64; 3]| !row.iter().all(|number| (0.0..=1.0).contains(number));
    if let Some(row) = rows.iter().position(is_wrong) {
        let is_byte = |number: f64| number == number.trunc() && (0.0..=255.0).contains(&number);
        let advice = if rows[row].into_iter().all(is_byte) { ", or bytes (uint8)" } else { "" };
        let [red, green, blue] = rows[row];
        return wrong_value(format!(
            "color: row {row} (counted from 0): expected red, green and blue from 0 to 1{advice}, found \
             ({red:?}, {green:?}, {blue:?})"
        ));
    }
    work::run(py, |_| Ok(rows.par_iter().map(|row| row.map(linear_from_srgb)).collect()))
}

/// Creates spheres from rows of centres and radii, with colours whose floats are encoded in sRGB unless `is_linear`.
pub fn colored(
    py: Python<'_>,
    rows: &[[f64; 4]],
    colors: Option<GivenColors<'_>>,
    is_linear: bool,
) -> PyResult<Spheres> {
    let spheres = py.detach(|| Spheres::from_rows(rows)).map_err(error::of("spheres"))?;
    let colored = match colors {
        None => return Ok(spheres),
        Some(GivenColors::One(color)) => spheres.with_color(color_of("color", &color, is_linear)?),
        Some(GivenColors::Names(names)) => {
            let color = |(row, name): (usize, &String)| {
                let value = Argument::Text(name.clone());
                let color = read_argument("color", &value, schema::srgb_color);
                let subject = format!("color: row {row} (counted from 0)");
                color.map_err(|fault| wrong_argument(&subject, &fault)).map(|color| color.0)
            };
            let colors: Vec<[f64; 3]> =
                names.iter().enumerate().map(color).collect::<PyResult<_>>()?;
            spheres.with_colors(colors)
        }
        Some(GivenColors::Floats(rows)) if is_linear => {
            spheres.with_colors(in_rows::<_, _, 3>(&rows)?.iter().copied())
        }
        Some(GivenColors::Floats(rows)) => {
            spheres.with_colors(linear_of_floats(py, in_rows(&rows)?)?)
        }
        Some(GivenColors::Bytes(rows)) => {
            let fractions = || std::array::from_fn(|byte| byte as f64 / 255.0);
            let linear: [f64; 256] = if is_linear { fractions() } else { linear_of_bytes() };
            let row = |row: &[u8; 3]| row.map(|byte| linear[usize::from(byte)]);
            spheres.with_colors(in_rows(&rows)?.iter().map(row))
        }
    };
    colored.map_err(error::of("color"))
}
