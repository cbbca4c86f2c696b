//! What belongs to one process: a fork leaves threads and the drivers of devices behind.

use std::process;
use std::sync::{Mutex, OnceLock, PoisonError};

use pyo3::{PyResult, Python};

/// A value that each process makes for itself. In a process that a fork made, that of the parent is neither used nor
/// ended, for its threads are not there.
pub struct OfProcess<T>(Mutex<Option<(u32, T)>>);

impl<T: Default> OfProcess<T> {
    pub const fn new() -> OfProcess<T> {
        OfProcess(Mutex::new(None))
    }

    /// Does something with the value. The interpreter's lock is held, so that no fork comes meanwhile.
    pub fn with<R>(&self, _: Python<'_>, act: impl FnOnce(&mut T) -> R) -> R {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        forget_that_of_a_parent(&mut slot);
        act(&mut slot.get_or_insert_with(|| (process::id(), T::default())).1)
    }
}

/// A value that is made when it is first wanted, perhaps by several threads at once: none waits for another one, which a
/// fork may have left behind.
///
/// # Errors
/// Those of `make`.
pub fn once<T>(slot: &OnceLock<T>, make: impl FnOnce() -> PyResult<T>) -> PyResult<&T> {
    if let Some(known) = slot.get() {
        return Ok(known);
    }
    let made = make()?;
    Ok(slot.get_or_init(|| made))
}

impl<T> Drop for OfProcess<T> {
    fn drop(&mut self) {
        forget_that_of_a_parent(self.0.get_mut().unwrap_or_else(PoisonError::into_inner));
    }
}

fn forget_that_of_a_parent<T>(slot: &mut Option<(u32, T)>) {
    if slot.as_ref().is_some_and(|(owner, _)| *owner != process::id()) {
        std::mem::forget(slot.take());
    }
}
