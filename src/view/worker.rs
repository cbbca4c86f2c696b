//! A thread that does the newest of the jobs that it is given, and skips what came between.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::control::Control;
use crate::error::{Error, Result};

/// The thread and its next job.
pub struct Worker<J> {
    desk: Arc<Desk<J>>,
    thread: Option<JoinHandle<()>>,
}

struct Desk<J> {
    state: Mutex<Jobs<J>>,
    changed: Condvar,
}

struct Jobs<J> {
    next: Option<J>,
    closed: bool,
    /// Of the job at work.
    control: Arc<Control>,
}

/// The link from a job at work to those that came after it.
pub struct Turn<'a, J> {
    desk: &'a Desk<J>,
    /// Cancelled when a newer job waits.
    pub control: Arc<Control>,
}

impl<J> Desk<J> {
    fn lock(&self) -> MutexGuard<'_, Jobs<J>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes what comes next, and asks the job at work to stop.
    fn replace(&self, change: impl FnOnce(&mut Jobs<J>)) {
        let mut jobs = self.lock();
        change(&mut jobs);
        jobs.control.cancel();
        self.changed.notify_all();
    }

    /// The next job, or `None` when there will be none.
    fn take(&self) -> Option<(J, Arc<Control>)> {
        let mut state = self.lock();
        loop {
            if state.closed {
                return None;
            }
            if let Some(job) = state.next.take() {
                state.control = Arc::default();
                return Some((job, Arc::clone(&state.control)));
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl<J> Turn<'_, J> {
    /// True when a newer job waits.
    pub fn is_over(&self) -> bool {
        self.control.check().is_err()
    }

    /// Waits; gives `false` at once when a newer job comes.
    pub fn rest(&self, time: Duration) -> bool {
        let end = Instant::now() + time;
        let mut state = self.desk.lock();
        while !self.is_over() {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return true;
            }
            let waited = self.desk.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        false
    }
}

impl<J: Send + 'static> Worker<J> {
    /// Starts a thread that calls `work` for each job, with a function that passes an answer to
    /// `say`. That hears of failures too, but not of interruptions.
    ///
    /// # Errors
    /// [`Error::Io`] when the system has no thread to give.
    pub fn start<A>(
        name: &str,
        say: impl Fn(Result<A>) + Send + 'static,
        mut work: impl FnMut(J, &Turn<J>, &dyn Fn(A)) -> Result<()> + Send + 'static,
    ) -> Result<Worker<J>> {
        let state = Jobs { next: None, closed: false, control: Arc::default() };
        let desk = Arc::new(Desk { state: Mutex::new(state), changed: Condvar::new() });
        let seen = Arc::clone(&desk);
        let run = move || {
            while let Some((job, control)) = seen.take() {
                let turn = Turn { desk: &seen, control };
                match work(job, &turn, &|answer| say(Ok(answer))) {
                    Ok(()) | Err(Error::Interrupted) => {}
                    Err(error) => say(Err(error)),
                }
            }
        };
        let thread = std::thread::Builder::new().name(name.into()).spawn(run);
        let thread = thread.map_err(Error::io(format!("the {name} thread")))?;
        Ok(Worker { desk, thread: Some(thread) })
    }

    /// Hands over a job in place of the one that waits; the one at work is asked to stop.
    pub fn ask(&self, job: J) {
        self.desk.replace(|jobs| jobs.next = Some(job));
    }

    /// Forgets the job that waits and asks the one at work to stop.
    pub fn stop(&self) {
        self.desk.replace(|jobs| jobs.next = None);
    }
}

impl<J> Drop for Worker<J> {
    fn drop(&mut self) {
        self.desk.replace(|jobs| jobs.closed = true);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so itself.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn jobs_in_between_are_skipped_and_the_one_at_work_is_told() {
        let (started, at_work) = channel();
        let (go, may_go) = channel::<()>();
        let (done, results) = channel();
        let say = move |result: Result<_>| done.send(result.unwrap()).unwrap();
        let worker = Worker::start("test", say, move |job: u32, turn, say| {
            started.send(job).unwrap();
            may_go.recv().unwrap();
            say((job, turn.is_over()));
            Ok(())
        })
        .unwrap();
        worker.ask(1);
        assert_eq!(at_work.recv().unwrap(), 1);
        worker.ask(2);
        worker.ask(3);
        go.send(()).unwrap();
        assert_eq!(results.recv().unwrap(), (1, true));
        assert_eq!(at_work.recv().unwrap(), 3);
        go.send(()).unwrap();
        assert_eq!(results.recv().unwrap(), (3, false));
    }

    #[test]
    fn a_rest_ends_early_for_a_newer_job_and_for_the_end() {
        let (started, at_work) = channel();
        let (done, results) = channel();
        let say = move |result: Result<_>| done.send(result.unwrap()).unwrap();
        let worker = Worker::start("test", say, move |time: Duration, turn, say| {
            started.send(()).unwrap();
            say(turn.rest(time));
            Ok(())
        })
        .unwrap();
        worker.ask(Duration::from_secs(600));
        at_work.recv().unwrap();
        worker.ask(Duration::ZERO);
        assert!(!results.recv().unwrap());
        assert!(results.recv().unwrap());
        at_work.recv().unwrap();
        worker.ask(Duration::from_secs(600));
        at_work.recv().unwrap();
        drop(worker);
        assert!(!results.recv().unwrap());
    }
}
