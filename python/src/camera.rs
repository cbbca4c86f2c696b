//! The camera.

use kugelblitz::scene::{self, Projection};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use toml::{Table, Value};

use crate::table::scene_of;

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
    #[pyo3(signature = (position, look_at, up = [0.0, 1.0, 0.0], fov = None, height = None))]
    fn new(
        position: [f64; 3],
        look_at: [f64; 3],
        up: [f64; 3],
        fov: Option<f64>,
        height: Option<f64>,
    ) -> PyResult<Camera> {
        let vector = |v: [f64; 3]| Value::from(v.to_vec());
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
