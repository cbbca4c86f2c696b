//! Long work: without the interpreter's lock, stopped by Ctrl-C, with progress, in a pool of threads of this
//! process.

use std::any::Any;
use std::process;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use kugelblitz::Session;
use kugelblitz::control::Control;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::exception;
use crate::session::Shared;

/// How often signals and progress are looked at.
const LOOK: Duration = Duration::from_millis(50);

/// The pool, and the process that its threads run in: a fork leaves them behind.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The threads of this process. The interpreter's lock must be held, so that no fork comes while the pool is
/// locked.
pub fn pool(_: Python<'_>) -> PyResult<Arc<ThreadPool>> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    match &*pool {
        Some((process, pool)) if *process == process::id() => return Ok(Arc::clone(pool)),
        // Its threads are not in this process, so that dropping it would wait for nobody.
        Some(_) => std::mem::forget(pool.take()),
        None => {}
    }
    let made = ThreadPoolBuilder::new()
        .thread_name(|n| format!("kugelblitz {n}"))
        .build()
        .map_err(|error| PyRuntimeError::new_err(format!("no threads: {error}")))?;
    let made = Arc::new(made);
    *pool = Some((process::id(), Arc::clone(&made)));
    Ok(made)
}

/// Does `work` in the pool, with what the user gave to see the progress of so many steps, see `_progress.py`.
///
/// # Errors
/// Those of [`run`], and `TypeError` for something else.
pub fn run_with_progress<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    n_steps: u64,
    work: impl FnOnce(&Control) -> kugelblitz::Result<T> + Send,
) -> PyResult<T> {
    with_progress(py, progress, "step", Steps::Rays(n_steps), in_pool(work))
}

/// As [`run_with_progress`], with a session, which is waited for outside the pool: those who have it need the
/// pool's threads.
///
/// # Errors
/// As [`run_with_progress`].
pub fn run_with_session<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    n_steps: u64,
    session: &Shared,
    work: impl FnOnce(&mut Session, &Control) -> kugelblitz::Result<T> + Send,
) -> PyResult<T> {
    with_progress(py, progress, "step", Steps::Rays(n_steps), |pool, control| {
        let mut session = session.lock(control)?;
        let session = &mut *session;
        pool.install(|| work(session, control))
    })
}

/// All of `work` in the pool.
fn in_pool<T: Send>(
    work: impl FnOnce(&Control) -> kugelblitz::Result<T> + Send,
) -> impl FnOnce(&ThreadPool, &Control) -> kugelblitz::Result<T> + Send {
    |pool, control| pool.install(|| work(control))
}

fn with_progress<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    unit: &str,
    steps: Steps,
    work: impl FnOnce(&ThreadPool, &Control) -> kugelblitz::Result<T> + Send,
) -> PyResult<T> {
    let helper = py.import("kugelblitz._progress")?;
    let bar = helper.call_method1("steps", (progress, unit))?;
    let on_progress = bar.call_method0("__enter__")?;
    let result = run_in_steps(py, Some(&on_progress).filter(|it| !it.is_none()), steps, work);
    let none = py.None();
    bar.call_method1("__exit__", (&none, &none, &none))?;
    result
}

/// What progress is counted in.
#[derive(Clone, Copy)]
enum Steps {
    /// So many rays and ways to lights.
    Rays(u64),
    /// Bytes of files, which are known while they are read.
    Bytes,
}

impl Steps {
    /// Steps done, and all.
    fn done(self, control: &Control) -> (u64, u64) {
        match self {
            Steps::Rays(all) => (control.rays_done().min(all), all),
            Steps::Bytes => {
                let (done, all) = control.bytes();
                (done.min(all), all)
            }
        }
    }
}

/// Does `work` that counts the bytes that it reads, with what the user gave to see its progress.
///
/// # Errors
/// As [`run_with_progress`].
pub fn run_of_bytes<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> kugelblitz::Result<T> + Send,
) -> PyResult<T> {
    with_progress(py, progress, "B", Steps::Bytes, in_pool(work))
}

/// An exception in place of a panic, which is a mistake of the library.
fn of_panic(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    PyRuntimeError::new_err(format!("a mistake in kugelblitz itself, please report it: {text}"))
}

/// Does `work` in the pool. `progress` is called with the steps done and `n_steps`, now and then and in the
/// end.
///
/// # Errors
/// Those of `work` as exceptions, and what a signal's handler or `progress` raises; the work is then stopped.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    n_steps: u64,
    work: impl FnOnce(&Control) -> kugelblitz::Result<T> + Send,
) -> PyResult<T> {
    run_in_steps(py, progress, Steps::Rays(n_steps), in_pool(work))
}

fn run_in_steps<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    steps: Steps,
    work: impl FnOnce(&ThreadPool, &Control) -> kugelblitz::Result<T> + Send,
) -> PyResult<T> {
    let pool = pool(py)?;
    let progress = progress.map(|progress| progress.clone().unbind());
    let control = Control::default();
    let report = |py: Python<'_>, done: (u64, u64)| match &progress {
        Some(progress) => progress.call1(py, done).map(drop),
        None => Ok(()),
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
    if let Some(raised) = raised {
        return Err(raised);
    }
    let result = match outcome {
        Ok(result) => result.map_err(|error| exception(error, ""))?,
        Err(panic) => return Err(of_panic(&*panic)),
    };
    let (_, all) = steps.done(&control);
    report(py, (all, all))?;
    Ok(result)
}
