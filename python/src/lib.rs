//! Kugelblitz for Python. Everything is computed by the crate `kugelblitz`; here arrays become its rows and
//! its results arrays, without the interpreter's lock while it works.
#![allow(clippy::too_many_arguments, reason = "Python's arguments have names")]

mod argument;
mod camera;
mod command;
mod compare;
mod drawing;
mod error;
mod explain;
mod given;
mod image;
mod pickle;
mod picture;
mod place;
mod process;
mod scene;
mod session;
mod table;
mod verdict;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _kugelblitz {
    #[pymodule_export]
    use super::{
        camera::PyCamera,
        command::run_command,
        compare::compare,
        drawing::{figure, png, write},
        error::{DeviceError, NoAdapterError, SceneError},
        explain::PyExplanation,
        image::{info, read, require},
        pickle::scene_of_state,
        picture::PyPicture,
        place::adapters,
        scene::PyScene,
        verdict::{HitOutcome, KernelOutcome, Outcome, PictureOutcome, SceneOutcome},
    };

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
