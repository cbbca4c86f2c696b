//! Sessions that several threads ask for.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::Duration;

use kugelblitz::Control;
use kugelblitz::device::Device;
use kugelblitz::query::Kernel;
use kugelblitz::scene::Scene;
use kugelblitz::{Result, Session};
use pyo3::Python;

use crate::process::OfProcess;

/// How often a session that another thread has is asked for again.
const AGAIN: Duration = Duration::from_millis(2);

/// A session that several threads may ask for.
#[derive(Clone)]
pub struct Shared(Arc<Mutex<Session>>);

impl Shared {
    /// The session for work, whatever a panic left of it, as soon as no other thread has it.
    ///
    /// # Errors
    /// [`kugelblitz::Error::Interrupted`] while it waits.
    pub fn lock(&self, control: &Control) -> Result<MutexGuard<'_, Session>> {
        loop {
            match self.0.try_lock() {
                Ok(session) => return Ok(session),
                Err(TryLockError::Poisoned(session)) => {
                    return Ok(PoisonError::into_inner(session));
                }
                Err(TryLockError::WouldBlock) => {
                    control.check()?;
                    thread::sleep(AGAIN);
                }
            }
        }
    }
}

/// The sessions of a scene, by the device's name and the kernel.
pub struct Sessions(OfProcess<HashMap<(String, Kernel), Shared>>);

impl Sessions {
    pub const fn new() -> Sessions {
        Sessions(OfProcess::new())
    }

    /// The session of the scene on a device, made when it is first asked for.
    pub fn get(
        &self,
        py: Python<'_>,
        scene: &Arc<Scene>,
        device: Device,
        kernel: Kernel,
    ) -> Shared {
        let name = device.facts().map_or(String::new(), |facts| facts.name.clone());
        let make = || Shared(Arc::new(Mutex::new(Session::new(Arc::clone(scene), device, kernel))));
        self.0.with(py, |all| all.entry((name, kernel)).or_insert_with(make).clone())
    }
}
