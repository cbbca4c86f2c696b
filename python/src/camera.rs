//! The camera.

use std::iter;
use std::path::Path;

use kugelblitz::frames;
use kugelblitz::scene::schema::{CameraKeys, Section};
use kugelblitz::scene::{self, Framing, SceneOverrides, Viewpoint, place_camera};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::argument::{Size, named};
use crate::error::wrong_value;
use crate::scene::PyScene;
use crate::table::{Given, Keywords, wrong_argument};
use crate::work;

/// A camera: `Camera(position, look_at, up=(0, 1, 0), fov=45)`, or with `height` in place of `fov` for an
/// orthographic one.
///
/// `fov` is the vertical field of view in degrees, `height` the height of the picture in world units.
#[pyclass(frozen, name = "Camera", module = "kugelblitz", eq)]
#[derive(Clone, PartialEq)]
pub struct PyCamera {
    pub of_scene: scene::Camera,
}

#[pymethods]
impl PyCamera {
    #[new]
    #[pyo3(signature = (position, look_at, up = None, fov = None, height = None))]
    fn new(
        py: Python<'_>,
        position: Bound<'_, PyAny>,
        look_at: Bound<'_, PyAny>,
        up: Given<'_>,
        fov: Given<'_>,
        height: Given<'_>,
    ) -> PyResult<PyCamera> {
        let names = CameraKeys::INFO.keys.iter().map(|key| key.name);
        let given = [Some(position), Some(look_at), up, fov, height];
        let keys = Keywords { given: iter::zip(names, given).into_py_dict(py)?, is_linear: false };
        let camera = keys.section::<CameraKeys>("camera", &[])?.camera();
        let of_scene = camera.map_err(|fault| wrong_argument("camera", &fault))?;
        Ok(PyCamera { of_scene })
    }

    /// A camera that has all spheres of a scene in its picture, as near as can be.
    ///
    /// `view` is the side that it looks from: "quarter", "iso", "x", "-x", "y", "-y", "z" or "-z"; without
    /// one it is that of the scene's camera, or "quarter". `up` is what appears upward. `fov` makes a
    /// perspective camera, `height` an orthographic one, "auto" as high as all needs. `margin` is the part of
    /// the picture's shorter side that is free at each edge, `look_at` the point in its middle, `size`
    /// (columns, rows) its shape. With `n_turns`, all cameras of a `turntable` of so many see all.
    #[staticmethod]
    #[pyo3(
        signature = (scene, view = None, *, n_turns = 1, **keys),
        text_signature = "(scene, view=None, *, up=None, fov=None, height=None, margin=None, \
                          look_at=None, size=None, n_turns=1)"
    )]
    fn frame(
        py: Python<'_>,
        scene: &PyScene,
        view: Option<&str>,
        n_turns: u32,
        keys: Option<Bound<'_, PyDict>>,
    ) -> PyResult<PyCamera> {
        if scene.of.spheres.is_empty() {
            return wrong_value(
                "scene: there is no sphere to be framed; give Camera(position, look_at)",
            );
        }
        let known = [&FRAMING[..], &["look_at"]].concat();
        let mut overrides = framing(view, &Keywords::new(py, keys, &known)?)?;
        overrides.margin.get_or_insert(Framing::MARGIN);
        overrides.n_turns = n_turns;
        let path = Path::new("the scene");
        let of_scene = work::run(py, |control| place_camera(&scene.of, &overrides, path, control))?;
        Ok(PyCamera { of_scene })
    }

    /// Cameras that go once around the point that is looked at, in `n` equal steps, the first of them this
    /// one: a film that is a loop.
    fn turntable(&self, n: u32) -> PyResult<Vec<PyCamera>> {
        if !(1..=frames::MAX_FRAMES).contains(&n) {
            let most = frames::MAX_FRAMES;
            return wrong_value(format!("n: {n}, but a film has 1 to {most} frames"));
        }
        Ok(all(frames::turntable(&self.of_scene, n)))
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
        CameraKeys::from(&self.of_scene).fov
    }

    /// The height of an orthographic camera's picture, world units.
    #[getter]
    fn height(&self) -> Option<f64> {
        CameraKeys::from(&self.of_scene).height
    }

    #[allow(clippy::type_complexity, reason = "the arguments, as pickle takes them")]
    fn __getnewargs__(&self) -> ([f64; 3], [f64; 3], [f64; 3], Option<f64>, Option<f64>) {
        (self.position(), self.look_at(), self.up(), self.fov(), self.height())
    }

    fn __repr__(&self) -> String {
        let mut keys = Vec::new();
        CameraKeys::from(&self.of_scene)
            .each(&mut |key, value| keys.push(format!("{key}={}", value.toml())));
        format!("Camera({})", keys.join(", "))
    }
}

fn all(cameras: Vec<scene::Camera>) -> Vec<PyCamera> {
    cameras.into_iter().map(|of_scene| PyCamera { of_scene }).collect()
}

/// The arguments of [`framing`].
pub const FRAMING: [&str; 5] = ["up", "fov", "height", "margin", "size"];

/// What a camera that frames everything is asked for; a height may be "auto".
pub fn framing(view: Option<&str>, keys: &Keywords<'_>) -> PyResult<SceneOverrides> {
    let margin: Option<f64> = keys.extract("margin")?;
    let most = Framing::MAX_MARGIN;
    if let Some(margin) = margin.filter(|margin| !(0.0..=most).contains(margin)) {
        return wrong_value(format!("margin: {margin:?}, but it goes from 0 to {most}"));
    }
    let is_height_chosen =
        keys.get("height").is_some_and(|height| height.eq("auto").unwrap_or(false));
    if is_height_chosen && keys.get("fov").is_some() {
        return wrong_value("fov, height: a camera has one of them; leave the other out");
    }
    let without: &[&str] = if is_height_chosen { &["height"] } else { &[] };
    Ok(SceneOverrides {
        view: view.map(|view| named("view", view, Viewpoint::ALL, Viewpoint::name)).transpose()?,
        margin,
        is_height_chosen,
        camera: keys.section("", without)?,
        size: keys.extract("size")?.map(|Size(size)| size),
        ..SceneOverrides::default()
    })
}
