//! Rays and pixels out of Python's arguments, and counts of rays for Python.

use glam::DVec3;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, schema};
use kugelblitz::trace::{Ray, Rays, StageCounts};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::argument::{Crop, Pixel, Size};
use crate::array::Numbers;
use crate::camera::{Camera, usable_size};
use crate::table::value_of;

/// What is wrong where a picture has no camera.
pub fn no_camera() -> PyErr {
    PyValueError::new_err(
        "camera: the scene has none; give one, e.g. Camera((0, 1, 6), (0, 0, 0)), or Camera.frame(scene)",
    )
}

/// The pixels of a picture, or of a part of it.
pub fn pixels_of(
    scene: &Scene,
    camera: Option<&Camera>,
    size: Option<Size>,
    crop: Option<Crop>,
) -> PyResult<Pixels> {
    let camera = match (camera, &scene.camera) {
        (Some(camera), _) => &camera.of_scene,
        (None, Some(camera)) => camera,
        (None, None) => return Err(no_camera()),
    };
    let of_scene = scene.image.map(|image| Size([image.width, image.height]));
    let [width, height] = usable_size(size.or(of_scene).unwrap_or(Size([1280, 720])))?;
    let whole = Pixels::whole(View::new(camera), width, height);
    let Some(Crop([x, y, width, height])) = crop else { return Ok(whole) };
    let part = Pixels { x, y, width, height, ..whole };
    if part.is_empty() || !part.is_in_picture() {
        return Err(PyValueError::new_err(format!(
            "crop: ({x}, {y}, {width}, {height}) is not a part of the picture of {}x{} pixels",
            part.image_width, part.image_height
        )));
    }
    Ok(part)
}

/// The ray of a pixel (column, row), or the one given as (origin, direction).
pub fn one_ray(
    scene: &Scene,
    camera: Option<&Camera>,
    size: Option<Size>,
    pixel: Option<Pixel>,
    ray: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
) -> PyResult<Rays> {
    match (pixel, ray) {
        (Some(Pixel([x, y])), None) => {
            let whole = pixels_of(scene, camera, size, None)?;
            let inside = |at: i64, n: u32| u32::try_from(at).ok().filter(|at| *at < n);
            let (Some(x), Some(y)) = (inside(x, whole.width), inside(y, whole.height)) else {
                return Err(PyValueError::new_err(format!(
                    "pixel: ({x}, {y}) is not in the picture of {}×{} pixels",
                    whole.width, whole.height
                )));
            };
            Ok(Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..whole }))
        }
        (None, Some((origin, direction))) => {
            let origin = value_of("ray", &origin, schema::point)?;
            let direction = value_of("ray", &direction, schema::direction)?;
            Ok(Rays::List(vec![Ray { origin, direction }]))
        }
        _ => {
            let message = "give a pixel (column, row) of a camera, or a ray (origin, direction)";
            Err(PyTypeError::new_err(message))
        }
    }
}

/// Rays from two arrays.
///
/// # Errors
/// `ValueError` names the first row that is no ray.
pub fn rays_of(origins: &Bound<'_, PyAny>, directions: &Bound<'_, PyAny>) -> PyResult<Vec<Ray>> {
    let origins = Numbers::new("origins", origins)?;
    let directions = Numbers::new("directions", directions)?;
    let of_origins = origins.table(3, "origins are (N, 3)")?;
    let of_directions = directions.table(3, "directions are (N, 3)")?;
    if of_origins.len() != of_directions.len() {
        let expected = format!("`origins` has {} rows", of_origins.len());
        return Err(directions.wrong_shape(&expected));
    }
    let ray = |row, origin| {
        let direction = of_directions.row(row);
        Ray { origin: DVec3::from_array(origin), direction: DVec3::from_array(direction) }
    };
    let rays = of_origins.map("rays", ray)?;
    let is_ray = |ray: &Ray| {
        ray.origin.is_finite() && ray.direction.is_finite() && ray.direction != DVec3::ZERO
    };
    let Some(row) = rays.iter().position(|ray| !is_ray(ray)) else { return Ok(rays) };
    let Ray { origin, direction } = rays[row];
    let (name, numbers, why) = match (origin.is_finite(), direction.is_finite()) {
        (false, _) => ("origins", origin, "not all numbers are finite"),
        (_, false) => ("directions", direction, "not all numbers are finite"),
        _ => ("directions", direction, "it points nowhere"),
    };
    let [x, y, z] = numbers.to_array();
    Err(PyValueError::new_err(format!(
        "{name}: row {row} (counted from 0) is ({x:?}, {y:?}, {z:?}): {why}"
    )))
}

/// A dictionary of how many rays each stage decided.
pub fn counts_of(py: Python<'_>, counts: StageCounts) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("f32", counts.f32)?;
    dict.set_item("f64", counts.f64)?;
    dict.set_item("exact", counts.exact)?;
    Ok(dict)
}
