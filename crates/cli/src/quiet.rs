//! Keeping what drivers print out of the user's sight.
//!
//! Mesa writes lines such as "error: XDG_RUNTIME_DIR is invalid or not set in the environment."
//! straight to the standard error of the process, whether or not anything is wrong.

use std::fs::File;
use std::io::{Read, Seek};
use std::sync::{Mutex, PoisonError};

use crate::output::talk;
use crate::process::Stderr;

/// The standard error of the process while a [`Quiet`] lives.
static STDERR: Mutex<Option<Stderr>> = Mutex::new(None);

/// While this lives, standard error goes to a file; dropped, it is as it was, also on a panic.
pub struct Quiet {
    caught: File,
}

impl Quiet {
    /// `None` where the system does not allow it: noise is no reason to fail.
    pub fn start() -> Option<Quiet> {
        let caught = tempfile::tempfile().ok()?;
        let stderr = Stderr::redirect(&caught)?;
        *STDERR.lock().unwrap_or_else(PoisonError::into_inner) = Some(stderr);
        Some(Quiet { caught })
    }

    /// Gives what was printed meanwhile; standard error is as it was.
    pub fn end(mut self) -> String {
        self.caught()
    }

    fn caught(&mut self) -> String {
        let mut bytes = Vec::new();
        let read = self.caught.rewind().and_then(|()| self.caught.read_to_end(&mut bytes));
        read.map_or_else(|_| String::new(), |_| String::from_utf8_lossy(&bytes).into_owned())
    }
}

impl Drop for Quiet {
    fn drop(&mut self) {
        break_off();
        if std::thread::panicking() {
            talk(self.caught().trim_end());
        }
    }
}

/// Makes standard error what it was, for last words while a [`Quiet`] lives.
pub fn break_off() {
    if let Some(stderr) = STDERR.lock().unwrap_or_else(PoisonError::into_inner).take() {
        stderr.restore();
    }
}

/// Runs `work` and gives its result, with what was printed to standard error meanwhile.
pub fn quietly<T>(work: impl FnOnce() -> T) -> (T, String) {
    let quiet = Quiet::start();
    let result = work();
    (result, quiet.map_or_else(String::new, Quiet::end))
}

/// A message of Mesa on machines without a desktop, where nothing is wrong.
const HARMLESS: &str = "XDG_RUNTIME_DIR is invalid or not set";

/// Shows what was caught: all of it, or what may explain a failure.
pub fn show(noise: &str, all: bool) {
    for line in noise.lines().filter(|line| all || !line.contains(HARMLESS)) {
        talk(&format!("driver: {line}"));
    }
}
