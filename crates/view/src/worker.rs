//! A thread that does the newest of the jobs that it is given, and skips what came between.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use kugelblitz::Control;
use kugelblitz::{Error, Result};

/// A job, and what stops it.
type WorkerJob<J> = (J, Arc<Control>);

/// The thread and its newest job.
pub struct Worker<J> {
    jobs: Option<Sender<WorkerJob<J>>>,
    /// What stops the newest job.
    control: Arc<Control>,
    closing: Arc<Control>,
    thread: Option<JoinHandle<()>>,
}

/// The link from a job at work to those that came after it.
pub struct Turn<'a, J> {
    jobs: &'a Receiver<WorkerJob<J>>,
    next: Option<WorkerJob<J>>,
    /// Cancelled when a newer job waits, and at the end.
    pub control: Arc<Control>,
    /// Cancelled at the end alone.
    pub closing: &'a Control,
}

impl<J> Turn<'_, J> {
    /// Waits; gives `false` at once when a newer job comes.
    pub fn rest(&mut self, time: Duration) -> bool {
        let next = self.jobs.recv_timeout(time);
        let has_rested = matches!(next, Err(RecvTimeoutError::Timeout));
        self.next = next.ok();
        has_rested
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
        mut work: impl FnMut(J, &mut Turn<J>, &dyn Fn(A)) -> Result<()> + Send + 'static,
    ) -> Result<Worker<J>> {
        let (sender, jobs) = channel::<WorkerJob<J>>();
        let closing = Arc::<Control>::default();
        let is_closing = Arc::clone(&closing);
        let run = move || {
            let mut next = None;
            while let Some(job) = next.take().or_else(|| jobs.recv().ok()) {
                let (job, control) = jobs.try_iter().last().unwrap_or(job);
                let mut turn = Turn { jobs: &jobs, next: None, control, closing: &is_closing };
                match work(job, &mut turn, &|answer| say(Ok(answer))) {
                    Ok(()) | Err(Error::Interrupted) => {}
                    Err(error) => say(Err(error)),
                }
                next = turn.next;
            }
        };
        let thread = std::thread::Builder::new().name(name.into()).spawn(run);
        let thread = Some(thread.map_err(Error::io(format!("the {name} thread")))?);
        Ok(Worker { jobs: Some(sender), control: Arc::default(), closing, thread })
    }

    /// Hands over a job in place of the one that waits; the one at work is asked to stop.
    pub fn ask(&mut self, job: J) {
        self.control.cancel();
        self.control = Arc::default();
        if let Some(jobs) = &self.jobs {
            // Only a thread that panicked takes none, and it has said so itself.
            let _ = jobs.send((job, Arc::clone(&self.control)));
        }
    }
}

impl<J> Drop for Worker<J> {
    fn drop(&mut self) {
        self.control.cancel();
        self.closing.cancel();
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_in_between_are_skipped_and_the_one_at_work_is_told() {
        let (started, at_work) = channel();
        let (go, may_go) = channel::<()>();
        let (done, results) = channel();
        let say = move |result: Result<_>| done.send(result.unwrap()).unwrap();
        let mut worker = Worker::start("test", say, move |job: u32, turn, say| {
            started.send(job).unwrap();
            may_go.recv().unwrap();
            say((job, turn.control.is_cancelled()));
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
        let mut worker = Worker::start("test", say, move |time: Duration, turn, say| {
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
