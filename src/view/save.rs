//! Saving a picture as `render` would draw it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::tracing::Backend;
use crate::camera::Pixels;
use crate::control::Control;
use crate::error::Result;
use crate::memory::Available;
use crate::output::{self, OutputFile};
use crate::picture::{Format, PictureOptions};
use crate::render::plan;
use crate::scene::Scene;
use crate::session::Session;
use crate::trace::Kernel;

/// The first of `NAME-1.png`, `NAME-2.png`, … in `folder` that isn't there.
pub fn free_name(folder: &Path, scene: &Path) -> PathBuf {
    let stem = scene.file_stem().map_or_else(|| "view".into(), |stem| stem.to_string_lossy());
    let name = |n: u32| folder.join(format!("{stem}-{n}.png"));
    (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(0))
}

/// Traces `pixels` and writes them as a PNG file.
///
/// # Errors
/// Those of `render`.
pub fn save(
    backend: &Backend,
    scene: &Arc<Scene>,
    kernel: Kernel,
    pixels: Pixels,
    path: &Path,
    control: &Control,
) -> Result<()> {
    let (format, options) = (Format::Png, PictureOptions::default());
    let plan = plan(format, options, &pixels, scene.n_objects(), Available::now())?;
    let file = OutputFile::create(path, format.needs_seek())?;
    let mut session = Session::new(Arc::clone(scene), backend.device(), kernel);
    let (_, file) = session.draw(&pixels, &plan, file, control)?;
    output::commit([file], control)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_picture_is_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let scene = Path::new("scenes/ball.toml");
        let first = free_name(folder.path(), scene);
        assert_eq!(first, folder.path().join("ball-1.png"));
        std::fs::write(first, "").unwrap();
        assert_eq!(free_name(folder.path(), scene), folder.path().join("ball-2.png"));
    }
}
