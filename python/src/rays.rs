//! Rays and pixels out of Python's arguments.

use std::iter;

use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, schema};
use kugelblitz::trace::{Ray, Rays};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::argument::{Crop, Floats, Pixel, Size, in_rows};
use crate::camera::Camera;
use crate::error::wrong_type;
use crate::table::{helpers, value_of};

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
    let rays = helpers(origins.py())?.call_method1("rays", (origins, directions))?;
    let (origins, directions): (Floats<'_>, Floats<'_>) = rays.extract()?;
    let rays = iter::zip(in_rows(&origins)?, in_rows(&directions)?);
    Ok(rays.map(|(&o, &d)| Ray { origin: o.into(), direction: d.into() }).collect())
}
