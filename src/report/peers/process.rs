//! Another program, run with a limit and ended with everything that it started.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::control::Control;
use crate::error::Error;

/// Time between two looks at it, and so the error of its time.
const STEP: Duration = Duration::from_micros(500);

/// A program that did its work.
pub struct Ended {
    /// From its start to its end.
    pub wall: Duration,
    /// What it printed, to both its streams.
    pub talk: String,
}

/// A program that did not.
pub enum Failure {
    /// There is no such program.
    NotFound,
    /// It can't be started.
    Start(io::Error),
    /// It went on beyond the limit.
    TooSlow,
    /// It failed, saying this.
    Status(ExitStatus, String),
    /// The work was stopped, or this machine failed.
    Stopped(Error),
}

/// Runs `command`, whose output goes to the file `talk`, for at most `limit`.
pub fn run(
    mut command: Command,
    talk: &Path,
    limit: Duration,
    control: &Control,
) -> Result<Ended, Failure> {
    let stopped = |error: io::Error| Failure::Stopped(Error::io(talk)(error));
    let output = File::create(talk).map_err(stopped)?;
    command.stdin(Stdio::null()).stderr(output.try_clone().map_err(stopped)?).stdout(output);
    // Its own group can be ended with whatever it started, and the terminal's Ctrl-C comes to us
    // alone.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);

    let start = Instant::now();
    let child = command.spawn().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Failure::NotFound,
        _ => Failure::Start(error),
    })?;
    let mut running = Running(Some(child));
    let status = loop {
        if let Some(status) = running.look().map_err(stopped)? {
            break status;
        }
        control.check().map_err(Failure::Stopped)?;
        if start.elapsed() > limit {
            return Err(Failure::TooSlow);
        }
        std::thread::sleep(STEP);
    };
    let wall = start.elapsed();
    let talk = fs::read(talk).map_err(stopped)?;
    let talk = String::from_utf8_lossy(&talk).into_owned();
    match status.success() {
        true => Ok(Ended { wall, talk }),
        false => Err(Failure::Status(status, talk)),
    }
}

/// Ends the program when dropped, unless it has ended.
struct Running(Option<Child>);

impl Running {
    fn look(&mut self) -> io::Result<Option<ExitStatus>> {
        let Some(child) = &mut self.0 else { return Ok(None) };
        let status = child.try_wait()?;
        if status.is_some() {
            self.0 = None;
        }
        Ok(status)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let Some(child) = &mut self.0 else { return };
        #[cfg(unix)]
        {
            use rustix::process::{Pid, Signal, kill_process_group};
            let _ = kill_process_group(Pid::from_child(child), Signal::KILL);
        }
        let _ = child.kill();
        let _ = child.wait();
    }
}
