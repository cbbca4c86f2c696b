//! What the program asks of Windows about its own process.

use std::fs::File;
use std::io;
use std::process::Command;

/// The standard error of the process stays where it is.
pub struct Stderr;

impl Stderr {
    /// There is no safe way.
    pub fn redirect(_: &File) -> Option<Stderr> {
        None
    }

    /// Nothing was changed.
    pub fn restore(self) {}
}

/// Ends the process.
pub fn exit_at_once(code: u8) -> ! {
    std::process::exit(code.into())
}

/// Runs another program in place of this one; returns only where it can't be started. Ctrl-C reaches both.
pub fn become_program(mut program: Command) -> io::Error {
    match program.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}
