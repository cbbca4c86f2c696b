//! Few numbers out of any sequence, pixels, rays, rows of arrays, and names of things.

use std::iter;
use std::path::Path;

use kugelblitz::query::{Rays, WorldRay};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{self, Scene, SceneOverrides, place_camera, schema};
use numpy::ndarray::Dimension;
use numpy::{Element, PyReadonlyArray, PyReadonlyArrayDyn};
use pyo3::Borrowed;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};

use crate::camera::PyCamera;
use crate::error::{wrong_type, wrong_value};
use crate::table::{helpers, value_of};
use crate::work;

/// Columns and rows that a picture can have.
#[derive(Clone, Copy)]
pub struct Size(pub [u32; 2]);

/// Left column, top row, width and height of a part of a picture.
#[derive(Clone, Copy)]
pub struct Crop(pub [u32; 4]);

/// Column and row of a pixel.
#[derive(Clone, Copy)]
pub struct PixelArgument(pub [i64; 2]);

/// Samples across and down a pixel.
#[derive(Clone, Copy)]
pub struct SamplesArgument(pub scene::Samples);

impl<'py> FromPyObject<'_, 'py> for Size {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Size> {
        let [width, height]: [Bound<'_, PyAny>; 2] = parts("size", "(columns, rows)", &given)?;
        let side = |given| value_of("size", given, schema::pixels);
        Ok(Size([side(&width)?, side(&height)?]))
    }
}

impl<'py> FromPyObject<'_, 'py> for Crop {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Crop> {
        let what = "(left column, top row, width, height)";
        let numbers: [i128; 4] = parts("crop", what, &given)?;
        match numbers.map(u32::try_from) {
            [Ok(x), Ok(y), Ok(width), Ok(height)] => Ok(Crop([x, y, width, height])),
            _ => wrong_value(format!("crop: {numbers:?}, but {what} are whole numbers of 32 bits")),
        }
    }
}

impl<'py> FromPyObject<'_, 'py> for PixelArgument {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<PixelArgument> {
        parts("pixel", "(column, row)", &given).map(PixelArgument)
    }
}

impl<'py> FromPyObject<'_, 'py> for SamplesArgument {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<SamplesArgument> {
        value_of("samples", &given, schema::samples).map(SamplesArgument)
    }
}

/// The parts of a short sequence. A text in bytes is a sequence of whole numbers, but nobody means it.
fn parts<'py, T: FromPyObjectOwned<'py>, const N: usize>(
    name: &str,
    what: &str,
    given: &Bound<'py, PyAny>,
) -> PyResult<[T; N]> {
    let wrong = || PyTypeError::new_err(format!("{name}: it is {what}, whole numbers"));
    if given.is_instance_of::<PyBytes>() || given.is_instance_of::<PyByteArray>() {
        return Err(wrong());
    }
    given.extract().map_err(|_| wrong())
}

/// Numbers that lie one behind the other.
pub type Floats<'py> = PyReadonlyArrayDyn<'py, f64>;

/// Rows of `N` numbers of an array that `_given.py` has put in order. The interpreter's lock is held while they are
/// read, so that no other thread writes to it meanwhile.
///
/// # Errors
/// `ValueError` for an array that is not in order.
pub fn in_rows<'a, T: Element, D: Dimension, const N: usize>(
    array: &'a PyReadonlyArray<'_, T, D>,
) -> PyResult<&'a [[T; N]]> {
    Ok(array.as_slice()?.as_chunks().0)
}

/// The one of `all` that is called `given`; `argument` is what the user gave it by.
///
/// # Errors
/// `ValueError` names those that there are.
pub fn named<T: Copy>(
    argument: &str,
    given: &str,
    all: impl IntoIterator<Item = T>,
    name: fn(T) -> &'static str,
) -> PyResult<T> {
    let all: Vec<T> = all.into_iter().collect();
    all.iter().copied().find(|known| name(*known) == given).ok_or_else(|| {
        let names: Vec<&str> = all.iter().copied().map(name).collect();
        PyValueError::new_err(format!(
            "{argument}: there is no {given:?}; give one of {}",
            names.join(", ")
        ))
    })
}

/// Returns the camera that is given, or the scene's own, or one that frames all spheres in a picture of this size.
///
/// # Errors
/// `ValueError` if there are no spheres either, or they cannot be framed.
pub fn camera_of(
    py: Python<'_>,
    scene: &Scene,
    camera: Option<&PyCamera>,
    size: Option<Size>,
) -> PyResult<scene::Camera> {
    if let Some(camera) = camera.map(|camera| &camera.of_scene).or(scene.camera.as_ref()) {
        return Ok(camera.clone());
    }
    if scene.spheres.is_empty() {
        return wrong_value(
            "camera: the scene has none, and no spheres that one could frame; give one, for example \
             Camera((0, 1, 6), (0, 0, 0))",
        );
    }
    let overrides =
        SceneOverrides { size: size.map(|Size(size)| size), ..SceneOverrides::default() };
    let path = Path::new("the scene");
    work::run(py, |control| place_camera(scene, &overrides, path, control))
}

/// The pixels of a picture of [`camera_of`], or of a part of it.
pub fn pixels_of(
    py: Python<'_>,
    scene: &Scene,
    camera: Option<&PyCamera>,
    size: Option<Size>,
    crop: Option<Crop>,
) -> PyResult<Pixels> {
    pixels_of_camera(scene, &camera_of(py, scene, camera, size)?, size, crop)
}

/// The pixels of a picture of this camera, or of a part of it.
pub fn pixels_of_camera(
    scene: &Scene,
    camera: &scene::Camera,
    size: Option<Size>,
    crop: Option<Crop>,
) -> PyResult<Pixels> {
    let of_scene = scene.image.map(Size);
    let Size([width, height]) = size.or(of_scene).unwrap_or(Size([1280, 720]));
    let whole = Pixels::whole(View::new(camera), width, height);
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
    py: Python<'_>,
    scene: &Scene,
    camera: Option<&PyCamera>,
    size: Option<Size>,
    pixel: Option<PixelArgument>,
    ray: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
) -> PyResult<Rays> {
    match (pixel, ray) {
        (Some(PixelArgument([x, y])), None) => {
            let whole = pixels_of(py, scene, camera, size, None)?;
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
            Ok(Rays::List(vec![WorldRay { origin, direction }]))
        }
        _ => wrong_type("give a pixel (column, row) of a camera, or a ray (origin, direction)"),
    }
}

/// Rays from two arrays.
///
/// # Errors
/// `ValueError` names the first row that is no ray.
pub fn rays_of(
    origins: &Bound<'_, PyAny>,
    directions: &Bound<'_, PyAny>,
) -> PyResult<Vec<WorldRay>> {
    let rays = helpers(origins.py())?.call_method1("rays", (origins, directions))?;
    let (origins, directions): (Floats<'_>, Floats<'_>) = rays.extract()?;
    let rays = iter::zip(in_rows(&origins)?, in_rows(&directions)?);
    Ok(rays.map(|(&o, &d)| WorldRay { origin: o.into(), direction: d.into() }).collect())
}
