//! Long work: without the interpreter's lock, stopped by Ctrl-C, with progress, in a pool of threads of this
//! process.

use std::any::Any;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use kugelblitz::Control;
use kugelblitz::{Result, Session};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::exception;
use crate::process::OfProcess;
use crate::session::Shared;
use crate::table::Given;

/// How often signals and progress are looked at.
const LOOK: Duration = Duration::from_millis(50);

/// The threads that work, once there was work.
static POOL: OfProcess<Option<Arc<ThreadPool>>> = OfProcess::new();

fn pool(py: Python<'_>) -> PyResult<Arc<ThreadPool>> {
    POOL.with(py, |pool| match pool {
        Some(pool) => Ok(Arc::clone(pool)),
        None => {
            let made = ThreadPoolBuilder::new().thread_name(|n| format!("kugelblitz {n}")).build();
            let made =
                made.map_err(|error| PyRuntimeError::new_err(format!("no threads: {error}")))?;
            Ok(Arc::clone(pool.insert(Arc::new(made))))
        }
    })
}

/// What progress is counted in.
#[derive(Clone, Copy)]
pub enum Steps {
    /// So many rays and ways to lights.
    Rays(u64),
    /// Bytes of files, which are known while they are read.
    Bytes,
}

impl Steps {
    /// Steps done, and all.
    fn done(self, control: &Control) -> (u64, u64) {
        let (done, all) = match self {
            Steps::Rays(all) => (control.rays_done(), all),
            Steps::Bytes => control.bytes(),
        };
        (done.min(all), all)
    }

    fn unit(self) -> &'static str {
        match self {
            Steps::Rays(_) => "step",
            Steps::Bytes => "B",
        }
    }
}

/// Does `work` in the pool.
///
/// # Errors
/// Those of `work` as exceptions, and what a signal's handler raises; the work is then stopped.
pub fn run<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Control) -> Result<T> + Send,
) -> PyResult<T> {
    run_with_progress(py, None, Steps::Rays(0), work)
}

/// Does `work` in the pool, with what the user gave to see its progress, see `_progress.py`.
///
/// # Errors
/// Those of [`run`], what `progress` raises, and `TypeError` where it is something else.
pub fn run_with_progress<T: Send>(
    py: Python<'_>,
    progress: Given<'_>,
    steps: Steps,
    work: impl FnOnce(&Control) -> Result<T> + Send,
) -> PyResult<T> {
    work_beside(py, progress, steps, |pool, control| pool.install(|| work(control)))
}

/// Does `work` as [`run_with_progress`] does, with a session, which is waited for outside the pool: those who have it need the
/// pool's threads.
///
/// # Errors
/// As [`run_with_progress`].
pub fn run_with_session<T: Send>(
    py: Python<'_>,
    progress: Given<'_>,
    n_steps: u64,
    session: &Shared,
    work: impl FnOnce(&mut Session, &Control) -> Result<T> + Send,
) -> PyResult<T> {
    work_beside(py, progress, Steps::Rays(n_steps), |pool, control| {
        let mut session = session.lock(control)?;
        let session = &mut *session;
        pool.install(|| work(session, control))
    })
}

/// An exception in place of a panic, which is a mistake of the library.
fn of_panic(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    PyRuntimeError::new_err(format!("a mistake in kugelblitz itself, please report it: {text}"))
}

/// Does `work` on a thread of its own, while this one looks at signals and tells of progress.
fn work_beside<T: Send>(
    py: Python<'_>,
    progress: Given<'_>,
    steps: Steps,
    work: impl FnOnce(&ThreadPool, &Control) -> Result<T> + Send,
) -> PyResult<T> {
    let (pool, control) = (pool(py)?, Control::default());
    let helper = py.import("kugelblitz._progress")?;
    let progress = helper.call_method1("steps", (progress, steps.unit()))?.unbind();
    let report = |py: Python<'_>, done: (u64, u64)| {
        if progress.is_none(py) { Ok(()) } else { progress.call1(py, done).map(drop) }
    };
    let look =
        || Python::attach(|py| py.check_signals().and_then(|()| report(py, steps.done(&control))));
    let (outcome, raised) = py.detach(|| {
        thread::scope(|scope| {
            let (done, is_done) = channel::<()>();
            let worker = scope.spawn(|| {
                let _done = done;
                work(&pool, &control)
            });
            let mut raised = None;
            while is_done.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                if raised.is_none()
                    && let Err(error) = look()
                {
                    control.cancel();
                    raised = Some(error);
                }
            }
            (worker.join(), raised)
        })
    });
    let result = match (raised, outcome) {
        (Some(raised), _) => Err(raised),
        (None, Ok(result)) => result.map_err(|error| exception(error, "")),
        (None, Err(panic)) => Err(of_panic(&*panic)),
    };
    let (_, all) = steps.done(&control);
    result.and_then(|result| report(py, (all, all)).map(|()| result))
}
