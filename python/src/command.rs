//! The command-line program, which the package installs as `kugelblitz`.

use std::ffi::OsString;

use kugelblitz_cli::{Cli, main_with};
use pyo3::prelude::*;

/// Runs the program with a command line, starting with its name. Returns its exit code. It handles Ctrl-C from
/// then on, so the interpreter is expected to do nothing else.
#[pyfunction]
pub fn run_command(py: Python<'_>, command_line: Vec<OsString>) -> u8 {
    py.detach(|| main_with::<Cli>(command_line))
}
