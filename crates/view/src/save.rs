//! Saving what is shown, as `render` would draw it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::output::{OutputFile, commit};
use kugelblitz::picture::rgb8_file;
use kugelblitz::query::Kernel;
use kugelblitz::{Error, Result};
use kugelblitz_judge::show::{self, Show};

/// What is to be saved.
pub struct Saving {
    /// Scene, light, samples, camera and kernel, where it is one.
    pub session: Session,
    /// Columns and rows.
    pub size: [u32; 2],
    /// The mode of showing.
    pub show: Show,
    /// The kernels that are shown: one, or two side by side.
    pub kernels: Vec<Kernel>,
    /// Where the divider between them stands, 0 to 1.
    pub divider: f32,
    /// Stops it.
    pub control: Arc<Control>,
}

impl Saving {
    fn work(self, path: &Path) -> Result<()> {
        let Saving { mut session, size: [width, height], show, kernels, divider, control } = self;
        let (kernels, divider) = match kernels[..] {
            [left, right] => ([left, right], divider),
            _ if show == Show::Color => {
                return session.render_to_file(path, width, height).map(drop);
            }
            _ => ([session.kernel(); 2], 0.0),
        };
        let pixels = session.pixels(width, height)?;
        let file = OutputFile::create(path, false)?;
        let parts = (kernels, (f64::from(divider) * f64::from(width)).round() as u32);
        let n_samples = session.scene().samples.unwrap_or_default();
        let colors = show::side_by_side(&mut session, show, &pixels, parts, n_samples, &control)?;
        let png = rgb8_file([width, height], &colors).map_err(Error::io(path))?;
        let file = file.filled(&png)?;
        // A control of its own: the program's is for all that the window does.
        control.check()?;
        commit([file], &Control::default())
    }
}

/// A picture on its way into a file, on a thread of its own.
pub struct Save {
    /// The file.
    pub path: PathBuf,
    /// Columns and rows.
    pub size: [u32; 2],
    thread: JoinHandle<Result<()>>,
}

impl Save {
    /// Starts to save a PNG file; `done` is called with its path at the end.
    ///
    /// # Errors
    /// [`Error::Io`] when the system has no thread to give.
    pub fn start(
        saving: Saving,
        path: PathBuf,
        done: impl FnOnce(PathBuf) + Send + 'static,
    ) -> Result<Save> {
        let (target, size) = (path.clone(), saving.size);
        let work = move || {
            let saved = saving.work(&target);
            done(target);
            saved
        };
        let thread = std::thread::Builder::new().name("saving".into()).spawn(work);
        Ok(Save { path, size, thread: thread.map_err(Error::io("the saving thread"))? })
    }

    /// Waits for the end.
    ///
    /// # Errors
    /// Those of [`Session::render_to_file`] and [`show::side_by_side`].
    pub fn end(self) -> Result<()> {
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// The first of `SCENE-1.png`, `SCENE-2.png`, … in `folder` that isn't there and that none of `saves` will
/// be. Other modes than colours, and two kernels, are in the name too: `SCENE-depth-lecture-certified-1.png`.
pub fn free_name(
    folder: &Path,
    scene: &Path,
    show: Show,
    kernels: &[Kernel],
    saves: &[Save],
) -> PathBuf {
    let mut stem =
        scene.file_stem().map_or_else(|| "view".into(), |stem| stem.to_string_lossy().into_owned());
    let mode = (show != Show::Color).then(|| show.name());
    let kernels = kernels.iter().map(|kernel| kernel.name()).filter(|_| kernels.len() > 1);
    for word in mode.into_iter().chain(kernels) {
        stem = format!("{stem}-{word}");
    }
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
        let next = |saves: &[Save]| free_name(folder.path(), scene, Show::Color, &[], saves);
        let [one, two, three] = [1, 2, 3].map(|n| folder.path().join(format!("ball-{n}.png")));
        assert_eq!(next(&[]), one);
        std::fs::write(&one, "").unwrap();
        assert_eq!(next(&[]), two);
        let thread = std::thread::spawn(|| Ok(()));
        assert_eq!(next(&[Save { path: two, size: [1, 1], thread }]), three);
    }

    #[test]
    fn names_say_what_is_shown() {
        let name =
            |show, kernels| free_name(Path::new("."), Path::new("a/b.toml"), show, kernels, &[]);
        assert_eq!(name(Show::Depth, &[Kernel::Certified]), Path::new("./b-depth-1.png"));
        let both = name(Show::Color, &[Kernel::Lecture, Kernel::Certified]);
        assert_eq!(both, Path::new("./b-lecture-certified-1.png"));
    }
}
