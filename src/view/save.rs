//! Saving a picture as `render` would draw it.

use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

use crate::error::{Error, Result};
use crate::session::Session;

/// A picture on its way into a file, on a thread of its own.
pub struct Save {
    /// The file.
    pub path: PathBuf,
    /// Columns and rows.
    pub size: [u32; 2],
    thread: JoinHandle<Result<()>>,
}

impl Save {
    /// Starts to draw what the session's camera sees as a PNG file; `done` is called with its path
    /// at the end.
    ///
    /// # Errors
    /// [`Error::Io`] when the system has no thread to give.
    pub fn start(
        mut session: Session,
        path: PathBuf,
        size: [u32; 2],
        done: impl FnOnce(PathBuf) + Send + 'static,
    ) -> Result<Save> {
        let target = path.clone();
        let work = move || {
            let [width, height] = size;
            let saved = session.render_to_file(&target, width, height);
            done(target);
            saved.map(drop)
        };
        let thread = std::thread::Builder::new().name("saving".into()).spawn(work);
        Ok(Save { path, size, thread: thread.map_err(Error::io("the saving thread"))? })
    }

    /// Waits for the end.
    ///
    /// # Errors
    /// Those of [`Session::render_to_file`].
    pub fn end(self) -> Result<()> {
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// The first of `NAME-1.png`, `NAME-2.png`, … in `folder` that isn't there and that none of `saves`
/// will be.
pub fn free_name(folder: &Path, scene: &Path, saves: &[Save]) -> PathBuf {
    let stem = scene.file_stem().map_or_else(|| "view".into(), |stem| stem.to_string_lossy());
    let mut n = 1;
    loop {
        let path = folder.join(format!("{stem}-{n}.png"));
        if !path.exists() && saves.iter().all(|save| save.path != path) {
            return path;
        }
        n += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_picture_is_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let scene = Path::new("scenes/ball.toml");
        let next = |saves: &[Save]| free_name(folder.path(), scene, saves);
        let [one, two, three] = [1, 2, 3].map(|n| folder.path().join(format!("ball-{n}.png")));
        assert_eq!(next(&[]), one);
        std::fs::write(&one, "").unwrap();
        assert_eq!(next(&[]), two);
        let thread = std::thread::spawn(|| Ok(()));
        assert_eq!(next(&[Save { path: two, size: [1, 1], thread }]), three);
    }
}
