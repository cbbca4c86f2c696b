//! Watching the scene file.
//!
//! It is looked at four times a second: a look costs microseconds, and works on network file
//! systems and with editors that write a new file in the old one's place, where the system's
//! notifications need special care.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// Time between two looks.
const INTERVAL: Duration = Duration::from_millis(250);

/// Time in which a change must have come to rest: some editors write in two steps.
const REST: Duration = Duration::from_millis(40);

/// A thread that looks at a file.
pub struct Watch {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// The mark that tells one state of a file from the next; `None` while it isn't there.
type Stamp = Option<(SystemTime, u64, u64)>;

fn stamp(path: &Path) -> Stamp {
    use std::os::unix::fs::MetadataExt;
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len(), metadata.ino()))
}

/// The state of a file that has stopped changing, or whose watch is stopped.
fn at_rest(path: &Path, mut known: Stamp, stopped: &Receiver<()>) -> Stamp {
    loop {
        if stopped.recv_timeout(REST) != Err(RecvTimeoutError::Timeout) {
            return known;
        }
        let now = stamp(path);
        if now == known {
            return now;
        }
        known = now;
    }
}

impl Watch {
    /// Calls `look` at each interval with whether the file has changed since the last change.
    ///
    /// # Errors
    /// The system's, when it has no thread to give.
    pub fn start(
        path: PathBuf,
        mut look: impl FnMut(bool) + Send + 'static,
    ) -> std::io::Result<Watch> {
        let (stop, stopped) = channel::<()>();
        let mut known = stamp(&path);
        let thread = std::thread::Builder::new().name("watch".into()).spawn(move || {
            while stopped.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                let mut now = stamp(&path);
                let changed = now != known;
                if changed {
                    now = at_rest(&path, now, &stopped);
                }
                known = now;
                look(changed);
            }
        })?;
        Ok(Watch { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so itself.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_seen_also_when_the_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, "a").unwrap();
        let (send, changes) = channel();
        let watch = Watch::start(path.clone(), move |changed| {
            if changed {
                let _ = send.send(());
            }
        })
        .unwrap();
        let wait = || changes.recv_timeout(Duration::from_secs(60)).expect("a change");
        std::fs::write(&path, "ab").unwrap();
        wait();
        let other = folder.path().join("other");
        std::fs::write(&other, "cd").unwrap();
        std::fs::rename(&other, &path).unwrap();
        wait();
        std::fs::remove_file(&path).unwrap();
        wait();
        std::fs::write(&path, "ef").unwrap();
        wait();
        drop(watch);
        assert!(changes.try_recv().is_err(), "no change without a change");
    }
}
