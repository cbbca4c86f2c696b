//! Rays and pixels out of Python's arguments.

use glam::DVec3;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, schema};
use kugelblitz::trace::{Ray, Rays};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::argument::{Crop, Pixel, Size};
use crate::array::Numbers;
use crate::camera::Camera;
use crate::error::{wrong_type, wrong_value};
use crate::table::value_of;

/// The camera that is given, or the scene's own.
pub fn camera_of<'a>(
    scene: &'a Scene,
    camera: Option<&'a Camera>,
) -> PyResult<&'a kugelblitz::scene::Camera> {
    camera.map(|camera| &camera.of_scene).or(scene.camera.as_ref()).ok_or_else(|| {
        PyValueError::new_err(
            "camera: the scene has none; give one, e.g. Camera((0, 1, 6), (0, 0, 0)), or \
             Camera.frame(scene)",
        )
    })
}

/// The pixels of a picture, or of a part of it.
pub fn pixels_of(
    scene: &Scene,
    camera: Option<&Camera>,
    size: Option<Size>,
    crop: Option<Crop>,
) -> PyResult<Pixels> {
    let of_scene = scene.image.map(|image| Size([image.width, image.height]));
    let Size([width, height]) = size.or(of_scene).unwrap_or(Size([1280, 720]));
    let whole = Pixels::whole(View::new(camera_of(scene, camera)?), width, height);
    let Some(Crop(crop @ [x, y, width, height])) = crop else { return Ok(whole) };
    whole.part(crop).ok_or_else(|| {
        PyValueError::new_err(format!(
            "crop: ({x}, {y}, {width}, {height}) is not a part of the picture of {}x{} pixels",
            whole.image_width, whole.image_height
        ))
    })
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
            whole.pixel([x, y]).map(Rays::Pixels).ok_or_else(|| {
                PyValueError::new_err(format!(
                    "pixel: ({x}, {y}) is not in the picture of {}×{} pixels",
                    whole.width, whole.height
                ))
            })
        }
        (None, Some((origin, direction))) => {
            let origin = value_of("ray", &origin, schema::point)?;
            let direction = value_of("ray", &direction, schema::direction)?;
            Ok(Rays::List(vec![Ray { origin, direction }]))
        }
        _ => wrong_type("give a pixel (column, row) of a camera, or a ray (origin, direction)"),
    }
}

/// Rays from two arrays.
///
/// # Errors
/// `ValueError` names the first row that is no ray.
pub fn rays_of(origins: &Bound<'_, PyAny>, directions: &Bound<'_, PyAny>) -> PyResult<Vec<Ray>> {
    let origins = Numbers::new("origins", origins)?;
    let directions = Numbers::new("directions", directions)?;
    let ways: Vec<[f64; 3]> = directions.rows("directions are (N, 3)", |_, way| way)?;
    if let [n, _] = origins.shape()
        && *n != ways.len()
    {
        return Err(directions.wrong_shape(&format!("`origins` has {n} rows")));
    }
    let rays = origins.rows("origins are (N, 3)", |row, origin| Ray {
        origin: DVec3::from_array(origin),
        direction: DVec3::from_array(ways[row]),
    })?;
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
    wrong_value(format!("{name}: row {row} (counted from 0) is ({x:?}, {y:?}, {z:?}): {why}"))
}
