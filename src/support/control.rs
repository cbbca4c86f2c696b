//! How the caller watches and stops long work.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use crate::error::{Error, Result};

/// Stops work and counts what is done. One serves one piece of work, from its start to its outputs.
///
/// Work that was cancelled changes no output file: outputs are put in their places last of all, and
/// [`Control::commit`] decides once whether a [`Control::cancel`] came before that or too late.
#[derive(Debug, Default)]
pub struct Control {
    stage: AtomicU8,
    rays_done: AtomicU64,
    bytes_done: AtomicU64,
    bytes_expected: AtomicU64,
}

/// The stages of [`Control`]. From `WORKING` one way or the other, and never back.
const WORKING: u8 = 0;
const CANCELLED: u8 = 1;
const COMMITTED: u8 = 2;

impl Control {
    /// Asks the work to stop at its next step. Returns whether it will: it is too late once the
    /// outputs are being put in their places.
    pub fn cancel(&self) -> bool {
        self.leave_working(CANCELLED)
    }

    /// The point of no return, after all that can fail or take long: from here on nothing is
    /// cancelled. It may be passed again.
    ///
    /// # Errors
    /// [`Error::Interrupted`] once [`Control::cancel`] was called.
    pub fn commit(&self) -> Result<()> {
        if self.leave_working(COMMITTED) { Ok(()) } else { Err(Error::Interrupted) }
    }

    /// True where `stage` is the one that is reached.
    fn leave_working(&self, stage: u8) -> bool {
        match self.stage.compare_exchange(WORKING, stage, Ordering::SeqCst, Ordering::SeqCst) {
            Ok(_) => true,
            Err(reached) => reached == stage,
        }
    }

    /// Fails with [`Error::Interrupted`] once [`Control::cancel`] was called.
    #[inline]
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::Interrupted) } else { Ok(()) }
    }

    /// True where [`Control::cancel`] was called in time.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.stage.load(Ordering::Relaxed) == CANCELLED
    }

    /// Rays traced so far.
    pub fn rays_done(&self) -> u64 {
        self.rays_done.load(Ordering::Relaxed)
    }

    /// Counts finished rays.
    pub fn advance(&self, n_rays: u64) {
        self.rays_done.fetch_add(n_rays, Ordering::Relaxed);
    }

    /// Bytes of large files read or written so far, and expected in all.
    pub fn bytes(&self) -> (u64, u64) {
        let [done, expected] =
            [&self.bytes_done, &self.bytes_expected].map(|n| n.load(Ordering::Relaxed));
        (done, expected)
    }

    /// Begins to read or write `n_bytes`.
    pub fn expect_bytes(&self, n_bytes: u64) {
        self.bytes_done.store(0, Ordering::Relaxed);
        self.bytes_expected.store(n_bytes, Ordering::Relaxed);
    }

    /// Counts bytes read or written.
    pub fn advance_bytes(&self, n_bytes: u64) {
        self.bytes_done.fetch_add(n_bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_first_of_cancel_and_commit_stays() {
        let control = Control::default();
        assert!(control.check().is_ok());
        assert!(control.cancel() && control.cancel());
        assert!(matches!(control.check(), Err(Error::Interrupted)));
        assert!(matches!(control.commit(), Err(Error::Interrupted)));

        let control = Control::default();
        assert!(control.commit().is_ok() && control.commit().is_ok());
        assert!(!control.cancel());
        assert!(control.check().is_ok());
    }
}
