//! The camera.

use std::path::{Path, PathBuf};

use kugelblitz::frames;
use kugelblitz::scene::{
    self, Framing, ImageSize, Projection, SceneOverrides, Viewpoint, place_camera, schema,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use toml::{Table, Value};

use crate::argument::{Size, Vector, named};
use crate::scene::Scene;
use crate::table::{key, scene_of};
use crate::work;

/// A camera: `Camera(position, look_at, up=(0, 1, 0), fov=45)`, or with `height` in place of `fov` for an
/// orthographic one.
///
/// `fov` is the vertical field of view in degrees, `height` the height of the picture in world units.
#[pyclass(frozen, module = "kugelblitz", eq)]
#[derive(Clone, PartialEq)]
pub struct Camera {
    pub of_scene: scene::Camera,
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (position, look_at, up = Vector([0.0, 1.0, 0.0]), fov = None, height = None))]
    fn new(
        position: Vector,
        look_at: Vector,
        up: Vector,
        fov: Option<f64>,
        height: Option<f64>,
    ) -> PyResult<Camera> {
        let vector = |Vector(v)| Value::from(v.to_vec());
        let mut table = Table::from_iter([
            ("position".into(), vector(position)),
            ("look_at".into(), vector(look_at)),
            ("up".into(), vector(up)),
        ]);
        for (key, number) in [("fov", fov), ("height", height)] {
            if let Some(number) = number {
                table.insert(key.into(), number.into());
            }
        }
        let scene = scene_of("camera", "camera", Value::Table(table))?;
        let no_camera = || PyValueError::new_err("camera: nothing was given");
        scene.camera.map(|of_scene| Camera { of_scene }).ok_or_else(no_camera)
    }

    /// A camera that has all spheres of a scene in its picture, as near as can be.
    ///
    /// `view` is the side that it looks from: "quarter", "iso", "x", "-x", "y", "-y", "z" or "-z"; without
    /// one it is that of the scene's camera, or "quarter". `up` is what appears upward. `fov` makes a
    /// perspective camera, `height` an orthographic one, "auto" as high as all needs. `margin` is the part of
    /// the picture's shorter side that is free at each edge, `look_at` the point in its middle, `size`
    /// (columns, rows) its shape. With `n_turns`, all cameras of a `turntable` of so many see all.
    #[staticmethod]
    #[pyo3(signature = (
        scene, view = None, *, up = None, fov = None, height = None, margin = None, look_at = None,
        size = None, n_turns = 1
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn frame(
        py: Python<'_>,
        scene: &Scene,
        view: Option<&str>,
        up: Option<&Bound<'_, PyAny>>,
        fov: Option<&Bound<'_, PyAny>>,
        height: Option<&Bound<'_, PyAny>>,
        margin: Option<f64>,
        look_at: Option<&Bound<'_, PyAny>>,
        size: Option<Size>,
        n_turns: u32,
    ) -> PyResult<Camera> {
        if scene.of.spheres.is_empty() {
            let message = "scene: there is no sphere to be framed; give Camera(position, look_at)";
            return Err(PyValueError::new_err(message));
        }
        let margin = margin.or(Some(Framing::MARGIN));
        let mut overrides = framing(view, margin, [up, fov, height], size)?;
        overrides.camera.look_at = key("look_at", look_at, schema::point)?;
        overrides.n_turns = n_turns;
        let path = Path::new("the scene");
        let of_scene =
            work::run(py, None, 0, |control| place_camera(&scene.of, &overrides, path, control))?;
        Ok(Camera { of_scene })
    }

    /// Cameras that go once around the point that is looked at, in `n` equal steps, the first of them this
    /// one: a film that is a loop.
    fn turntable(&self, n: u32) -> PyResult<Vec<Camera>> {
        if !(1..=frames::MAX_FRAMES).contains(&n) {
            let most = frames::MAX_FRAMES;
            return Err(PyValueError::new_err(format!(
                "n: {n}, but a film has 1 to {most} frames"
            )));
        }
        Ok(all(frames::turntable(&self.of_scene, n)))
    }

    /// The cameras of a path in a .csv file: each line is a frame.
    /// The header names x, y, z and perhaps look_at_x …, up_x …, fov or height; what it does not name is as in
    /// this camera.
    fn path(&self, py: Python<'_>, path: PathBuf) -> PyResult<Vec<Camera>> {
        work::run(py, None, 0, |_| frames::read_path(&path, &self.of_scene)).map(all)
    }

    /// The eye, or the middle of an orthographic picture; world units.
    #[getter]
    fn position(&self) -> [f64; 3] {
        self.of_scene.position.to_array()
    }

    /// A point on the view axis.
    #[getter]
    fn look_at(&self) -> [f64; 3] {
        self.of_scene.look_at.to_array()
    }

    /// The direction that appears upward.
    #[getter]
    fn up(&self) -> [f64; 3] {
        self.of_scene.up.to_array()
    }

    /// The vertical field of view in degrees; `None` for an orthographic camera.
    #[getter]
    fn fov(&self) -> Option<f64> {
        match self.of_scene.projection {
            Projection::Perspective { fov_degrees } => Some(fov_degrees),
            Projection::Orthographic { .. } => None,
        }
    }

    /// The height of an orthographic camera's picture, world units.
    #[getter]
    fn height(&self) -> Option<f64> {
        match self.of_scene.projection {
            Projection::Perspective { .. } => None,
            Projection::Orthographic { height } => Some(height),
        }
    }

    #[allow(clippy::type_complexity, reason = "the arguments, as pickle takes them")]
    fn __getnewargs__(&self) -> ([f64; 3], [f64; 3], [f64; 3], Option<f64>, Option<f64>) {
        (self.position(), self.look_at(), self.up(), self.fov(), self.height())
    }

    fn __repr__(&self) -> String {
        let [position, look_at, up] = [self.position(), self.look_at(), self.up()];
        let lens = match self.of_scene.projection {
            Projection::Perspective { fov_degrees } => format!("fov={fov_degrees:?}"),
            Projection::Orthographic { height } => format!("height={height:?}"),
        };
        format!("Camera(position={position:?}, look_at={look_at:?}, up={up:?}, {lens})")
    }
}

fn all(cameras: Vec<scene::Camera>) -> Vec<Camera> {
    cameras.into_iter().map(|of_scene| Camera { of_scene }).collect()
}

/// What a camera that frames everything is asked for; a height may be "auto".
pub fn framing(
    view: Option<&str>,
    margin: Option<f64>,
    [up, fov, height]: [Option<&Bound<'_, PyAny>>; 3],
    size: Option<Size>,
) -> PyResult<SceneOverrides> {
    if fov.is_some() && height.is_some() {
        let message = "fov, height: a camera has one of them; leave the other out";
        return Err(PyValueError::new_err(message));
    }
    let most = Framing::MAX_MARGIN;
    if let Some(margin) = margin.filter(|margin| !(0.0..=most).contains(margin)) {
        let message = format!("margin: {margin:?}, but it goes from 0 to {most}");
        return Err(PyValueError::new_err(message));
    }
    let view = view.map(|view| named("view", view, Viewpoint::ALL, Viewpoint::name)).transpose()?;
    let is_auto =
        |height: &&Bound<'_, PyAny>| height.extract::<String>().is_ok_and(|h| h == "auto");
    let is_height_chosen = height.as_ref().is_some_and(is_auto);
    let camera = schema::CameraKeys {
        up: key("up", up, schema::direction)?,
        fov: key("fov", fov, schema::fov)?,
        height: key("height", height.filter(|_| !is_height_chosen), schema::height)?,
        ..schema::CameraKeys::default()
    };
    let size = size.map(usable_size).transpose()?;
    Ok(SceneOverrides { view, margin, is_height_chosen, camera, size, ..SceneOverrides::default() })
}

/// A size that a picture can have.
pub fn usable_size(Size([width, height]): Size) -> PyResult<[u32; 2]> {
    let most = ImageSize::MAX_SIDE;
    match (1..=most).contains(&width) && (1..=most).contains(&height) {
        true => Ok([width, height]),
        false => Err(PyValueError::new_err(format!(
            "size: ({width}, {height}), but a picture has 1 to {most} pixels a side"
        ))),
    }
}
