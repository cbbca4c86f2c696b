//! Kugelblitz for Python. Everything is computed by the crate `kugelblitz`; here arrays become its rows and
//! its results arrays, without the interpreter's lock while it works.
#![allow(clippy::too_many_arguments, reason = "Python's arguments have names")]

mod argument;
mod camera;
mod compare;
mod drawing;
mod error;
mod explain;
mod given;
mod image;
mod judge;
mod pickle;
mod picture;
mod place;
mod process;
mod rays;
mod scene;
mod session;
mod table;
mod verdict;
mod verify;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _kugelblitz {
    #[pymodule_export]
    use super::camera::Camera;
    #[pymodule_export]
    use super::compare::{Compared, compare};
    #[pymodule_export]
    use super::drawing::{figure, png, write};
    #[pymodule_export]
    use super::error::{DeviceError, NoAdapterError, SceneError};
    #[pymodule_export]
    use super::explain::Explanation;
    #[pymodule_export]
    use super::image::{info, read, require};
    #[pymodule_export]
    use super::judge::Judged;
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
