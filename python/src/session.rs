//! Sessions that several threads ask for, and that a fork leaves behind.

use std::collections::HashMap;
use std::mem;
use std::process;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::Duration;

use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::scene::Scene;
use kugelblitz::trace::Kernel;
use kugelblitz::{Result, Session};

/// How often a session that another thread has is asked for again.
const AGAIN: Duration = Duration::from_millis(2);

/// A session that several threads may ask for. Its device's driver is a matter of the process that opened it:
/// in another one, which a fork made, it is never touched, and not ended either.
#[derive(Clone)]
pub struct Shared {
    process: u32,
    session: Arc<Mutex<Session>>,
}

impl Shared {
    pub fn new(session: Session) -> Shared {
        Shared { process: process::id(), session: Arc::new(Mutex::new(session)) }
    }

    /// The session for work, whatever a panic left of it, as soon as no other thread has it.
    ///
    /// # Errors
    /// [`kugelblitz::Error::Interrupted`] while it waits.
    pub fn lock(&self, control: &Control) -> Result<MutexGuard<'_, Session>> {
        loop {
            match self.session.try_lock() {
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

impl Drop for Shared {
    fn drop(&mut self) {
        if self.process != process::id() {
            // One owner more than there are, so that the last one does not end it.
            mem::forget(Arc::clone(&self.session));
        }
    }
}

/// The sessions of a scene.
#[derive(Default)]
pub struct Sessions(Mutex<OfProcess>);

/// Sessions by the device's name and the kernel, and the process that they are of.
#[derive(Default)]
struct OfProcess {
    process: u32,
    all: HashMap<(String, Kernel), Shared>,
}

impl Sessions {
    /// The session of the scene on a device, made when it is first asked for.
    pub fn get(&self, scene: &Arc<Scene>, device: Device, kernel: Kernel) -> Shared {
        let mut sessions = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if sessions.process != process::id() {
            *sessions = OfProcess { process: process::id(), all: HashMap::new() };
        }
        let name = match &device {
            Device::Cpu => String::new(),
            Device::Gpu(gpu) => gpu.facts.name.clone(),
        };
        let make = || Shared::new(Session::new(Arc::clone(scene), device, kernel));
        sessions.all.entry((name, kernel)).or_insert_with(make).clone()
    }
}
