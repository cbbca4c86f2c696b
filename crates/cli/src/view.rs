//! `kugelblitz view`

use std::env;
use std::io::ErrorKind;
use std::process::Command;

use kugelblitz::error::Message;
use kugelblitz::{Error, Result};

use crate::arguments;
use crate::process::become_program;
use crate::wrong_usage;

/// The program of the window.
const PROGRAM: &str = "kugelblitz-view";

/// Becomes the program of the window, which takes the same arguments: the one beside this program, else that in PATH.
///
/// # Errors
/// [`Error::Usage`] where there is none, and [`Error::Io`] where it can't be started.
pub fn run() -> Result<()> {
    let beside = env::current_exe()
        .map(|own| own.with_file_name(PROGRAM).with_extension(env::consts::EXE_EXTENSION));
    let program = beside.ok().filter(|beside| beside.is_file()).unwrap_or_else(|| PROGRAM.into());
    let mut window = Command::new(&program);
    // The first word is the command: no option before it has a value.
    let mut is_command = true;
    window.args(
        arguments().iter().filter(|word| *word != "view" || !std::mem::take(&mut is_command)),
    );
    let error = become_program(window);
    match error.kind() {
        ErrorKind::NotFound => wrong_usage(Message::new(
            format!("the window is a separate program, `{PROGRAM}`, which is not installed"),
            "put its file next to `kugelblitz`, or run `cargo install kugelblitz-view` (in a checkout: `cargo install \
             --path crates/view`)",
        )),
        _ => Err(Error::io(program)(error)),
    }
}
