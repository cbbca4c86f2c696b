//! What the program asks of Linux, macOS and their kin about its own process.

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// The standard error of the process while it goes elsewhere.
pub struct Stderr(OwnedFd);

impl Stderr {
    /// Sends it to `file`. `None` where the system does not allow it.
    pub fn redirect(file: &File) -> Option<Stderr> {
        let stderr = rustix::io::fcntl_dupfd_cloexec(rustix::stdio::stderr(), 3).ok()?;
        rustix::stdio::dup2_stderr(file).ok()?;
        Some(Stderr(stderr))
    }

    /// Makes it what it was.
    pub fn restore(self) {
        let _ = rustix::stdio::dup2_stderr(self.0);
    }
}

/// Ends the process without what [`std::process::exit`] does before: drivers wait there for their
/// threads.
#[allow(unsafe_code)]
pub fn exit_at_once(code: u8) -> ! {
    // SAFETY: `_exit` has no preconditions and doesn't return.
    unsafe { libc::_exit(code.into()) }
}

/// Makes the process another program; returns only where it can't be started.
pub fn become_program(mut program: Command) -> io::Error {
    program.exec()
}
