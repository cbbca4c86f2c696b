//! A scene's parts out of Python's arguments.

use kugelblitz::scene::{Color, Coloring, ImageSize, Scene, Spheres, schema};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::argument::Size;
use crate::array::Numbers;
use crate::camera::Camera;
use crate::error::{self, wrong_value};
use crate::table::{Keywords, helpers, scene_of, value, value_of};

/// The keyword arguments that say what a scene has beside spheres.
pub const OF_SCENE: [&str; 8] =
    ["camera", "size", "samples", "planes", "lights", "sky", "ambient", "background"];

/// Gives a scene what these arguments say; None takes it away.
pub fn change(scene: &mut Scene, keys: &Keywords<'_>) -> PyResult<()> {
    for (name, given) in keys.each() {
        match name {
            "camera" => {
                let wrong = |_| PyTypeError::new_err("camera: give a Camera");
                let camera = given.map(|given| given.cast::<Camera>()).transpose();
                scene.camera = camera.map_err(wrong)?.map(|camera| camera.get().of_scene.clone());
            }
            "size" => {
                let size = given.map(|given| given.extract()).transpose()?;
                scene.image = size.map(|Size([width, height])| ImageSize { width, height });
            }
            "samples" => scene.samples = keys.value(name, schema::samples)?,
            "planes" => scene.planes = each(name, "plane", given, |scene| scene.planes)?,
            "lights" => scene.lights = each(name, "light", given, |scene| scene.lights)?,
            "sky" => {
                let sky = given.map(|sky| scene_of(name, name, &value(name, sky)?)).transpose()?;
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
fn each<T>(
    name: &str,
    key: &str,
    given: Option<&Bound<'_, PyAny>>,
    of: fn(Scene) -> Vec<T>,
) -> PyResult<Vec<T>> {
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

/// The spheres of a scene, and how numbers became their colours.
pub fn spheres_of(
    py: Python<'_>,
    rows: Option<&Bound<'_, PyAny>>,
    keys: &Keywords<'_>,
) -> PyResult<(Spheres, Option<Coloring>)> {
    let has = |names: &[&str]| names.iter().any(|name| keys.get(name).is_some());
    if keys.get("color_by").is_none() && has(&["colormap", "range", "missing_color"]) {
        return wrong_value(
            "colormap, range, missing_color: they say how numbers are coloured; give them by `color_by`",
        );
    }
    let Some(rows) = rows else {
        let needed = "radius, color, color_by, names: there are no spheres that they are of";
        return match has(&["radius", "color", "color_by", "names"]) {
            true => wrong_value(needed),
            false => Ok((Spheres::default(), None)),
        };
    };
    let (color, color_by) = (keys.get("color"), keys.get("color_by"));
    if color.is_some() && color_by.is_some() {
        return wrong_value("color: `color_by` gives each sphere its own; leave one of them out");
    }
    let (mut spheres, mut coloring) =
        (colored(rows_of(py, rows, keys.get("radius"))?, color)?, None);
    if let Some(numbers) = color_by {
        let (colored, made) = colored_by(spheres, numbers, keys)?;
        (spheres, coloring) = (colored, Some(made));
    }
    if let Some(names) = keys.get("names") {
        let names = helpers(py)?.call_method1("names", (names, spheres.len()))?;
        let names: Vec<(u32, String)> = names.extract()?;
        names.into_iter().for_each(|(row, name)| spheres.set_name(row, name));
    }
    Ok((spheres, coloring))
}

/// Spheres with the colours of their numbers.
fn colored_by(
    spheres: Spheres,
    numbers: &Bound<'_, PyAny>,
    keys: &Keywords<'_>,
) -> PyResult<(Spheres, Coloring)> {
    let map = keys.value("colormap", schema::colormap)?.unwrap_or_default();
    let range = keys.value("range", schema::range)?;
    let missing_color = keys.value("missing_color", schema::color)?;
    // A series of pandas says what it is called.
    let name = numbers.getattr("name").and_then(|name| name.extract::<String>());
    let name = name.unwrap_or_else(|_| "color_by".into());
    // What is masked is missing.
    let filled = helpers(numbers.py())?.call_method1("filled", (numbers,))?;
    let numbers = Numbers::new("color_by", &filled)?;
    let numbers = numbers.list("one number for each sphere")?;
    let missing_color = missing_color.unwrap_or(Coloring::MISSING_COLOR);
    spheres.with_numbers(&name, &numbers, map, range, missing_color).map_err(error::of("color_by"))
}

/// Spheres of rows of centres, with radii in the fourth column or apart.
pub fn rows_of(
    py: Python<'_>,
    spheres: &Bound<'_, PyAny>,
    radius: Option<&Bound<'_, PyAny>>,
) -> PyResult<Spheres> {
    let expected = "centres are (N, 3), and with radii (N, 4)";
    let spheres = Numbers::new("spheres", spheres)?;
    let rows: Vec<[f64; 4]> = match (spheres.shape(), radius) {
        ([_, 4], None) => spheres.rows(expected, |_, row| row)?,
        ([_, 4], Some(_)) => {
            return wrong_value(
                "radius: `spheres` has radii already, in its fourth column; leave one of them out",
            );
        }
        ([n, 3], Some(radius)) => {
            let radii = Numbers::new("radius", radius)?;
            let radii = match radii.shape() {
                [] => Radii::One(radius.extract()?),
                [length] if length == n => Radii::Each(radii.list("one radius for each sphere")?),
                _ => return Err(radii.wrong_shape(&format!("there are {n} spheres"))),
            };
            spheres.rows(expected, |row, [x, y, z]| [x, y, z, radii.of(row)])?
        }
        ([_, 3], None) => {
            return wrong_value(
                "radius: `spheres` has three columns, so give the radius of all, or one of each",
            );
        }
        _ => return Err(spheres.wrong_shape(expected)),
    };
    py.detach(|| Spheres::from_rows(rows)).map_err(error::of("spheres"))
}

/// Spheres with one colour, or one for each.
pub fn colored(spheres: Spheres, color: Option<&Bound<'_, PyAny>>) -> PyResult<Spheres> {
    let Some(color) = color else { return Ok(spheres) };
    if color.is_instance_of::<PyString>() || Numbers::new("color", color)?.shape().len() == 1 {
        let color = value_of("color", color, schema::color)?;
        return spheres.with_color(color).map_err(error::of("color"));
    }
    let colors = Numbers::new("color", color)?;
    let linear: [f64; 256] = std::array::from_fn(|byte| Color::from_srgb8([byte as u8; 3]).0[0]);
    let colors = colors.rows("colours are (N, 3)", |_, row| match colors.is_bytes {
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
