//! Kugelblitz for Python. Everything is computed by the crate `kugelblitz`; here arrays become its rows and
//! its results arrays, without the interpreter's lock while it works.

mod array;
mod camera;
mod error;
mod picture;
mod place;
mod scene;
mod table;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _kugelblitz {
    #[pymodule_export]
    use super::camera::Camera;
    #[pymodule_export]
    use super::error::{DeviceError, NoAdapterError, SceneError};
    #[pymodule_export]
    use super::picture::Picture;
    #[pymodule_export]
    use super::place::adapters;
    #[pymodule_export]
    use super::scene::Scene;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
