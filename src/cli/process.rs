//! What the program asks of Linux, macOS and their kin about its own process.

use std::fs::File;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, Ordering};

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

/// Beyond the limit of `ulimit -f`, the system ends a program that doesn't ignore this signal before
/// the write can fail.
#[allow(unsafe_code)]
pub fn fail_writes_beyond_the_file_size_limit() {
    // SAFETY: ignoring a signal runs no code of ours in a handler, and no other thread is there yet
    // that could set it at the same time.
    unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
}

/// True where standard output was closed before the program began.
static STDOUT_WAS_CLOSED: AtomicBool = AtomicBool::new(false);

/// True where standard output was closed when the program was started, as by `>&-`.
pub fn stdout_was_closed() -> bool {
    STDOUT_WAS_CLOSED.load(Ordering::Relaxed)
}

/// Makes every write to a standard output that was closed fail, as if its reader had gone.
pub fn fail_writes_to_a_closed_stdout() {
    if stdout_was_closed()
        && let Ok((_, nobody_reads)) = std::io::pipe()
    {
        let _ = rustix::stdio::dup2_stdout(nobody_reads);
    }
}

/// Before `main`, Rust's runtime opens `/dev/null` in the place of what is closed, and takes a write to
/// what is closed nevertheless for done.
#[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
#[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
#[allow(unsafe_code)]
#[used]
static BEFORE_MAIN: extern "C" fn() = {
    extern "C" fn look_at_stdout() {
        // SAFETY: asking for a descriptor's flags changes nothing, whatever it is.
        let flags = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFD) };
        STDOUT_WAS_CLOSED.store(flags == -1, Ordering::Relaxed);
    }
    look_at_stdout
};
