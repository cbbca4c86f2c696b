//! Watching the scene file.
//!
//! It is looked at four times a second: a look costs microseconds, and works on network file
//! systems and with editors that write a new file in the old one's place, where the system's
//! notifications need special care.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use kugelblitz::Result;

use super::worker::{Turn, Worker};

/// Time between two looks.
const INTERVAL: Duration = Duration::from_millis(250);

/// Time in which a change must have come to rest: some editors write in two steps.
const REST: Duration = Duration::from_millis(40);

/// The mark that tells one state of a file from the next; `None` while it isn't there.
type Stamp = Option<(SystemTime, u64)>;

fn stamp(path: &Path) -> Stamp {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

/// Starts a thread that calls `look` at each interval, with true where the file has changed since the last time and come
/// to rest. Dropped, it stops.
///
/// # Errors
/// [`kugelblitz::Error::Io`] when the system has no thread to give.
pub fn watch(path: PathBuf, mut look: impl FnMut(bool) + Send + 'static) -> Result<Worker<()>> {
    let mut known = stamp(&path);
    let work = move |(), turn: &mut Turn<()>, _: &dyn Fn(())| {
        let mut changes = false;
        while turn.rest(if changes { REST } else { INTERVAL }) {
            let now = stamp(&path);
            let is_at_rest = now == known;
            known = now;
            look(changes && is_at_rest);
            changes = !is_at_rest;
        }
        Ok(())
    };
    let mut watch = Worker::start("watching", |_: Result<()>| {}, work)?;
    watch.ask(());
    Ok(watch)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn changes_are_seen_also_when_the_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, "a").unwrap();
        let (send, changes) = channel();
        let watch = watch(path.clone(), move |changed| {
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

    /// A file that never rests keeps nobody from being heard.
    #[test]
    fn looks_go_on_while_the_file_changes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let (send, looks) = channel();
        let _watch = watch(path.clone(), move |changed| {
            let _ = send.send(changed);
        })
        .unwrap();
        let mut write = (0..100_000).map(|n| std::fs::write(&path, n.to_string()).unwrap());
        for _ in 0..10 {
            assert!(write.any(|()| looks.recv_timeout(Duration::from_millis(1)).is_ok()));
        }
        assert!(looks.iter().any(|changed| changed));
    }
}
