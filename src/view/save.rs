//! Saving a picture as `render` would draw it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::tracing::Backend;
use crate::camera::Pixels;
use crate::control::Control;
use crate::cpu::CpuTracer;
use crate::error::Result;
use crate::gpu::GpuTracer;
use crate::memory::Available;
use crate::output::{self, OutputFile};
use crate::picture::{Format, Frame, PictureOptions, PictureWriter};
use crate::prepare::Prepared;
use crate::render::{plan, render};
use crate::scene::Scene;
use crate::trace::{Kernel, Rays, Tracer};

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
    let prepared = Arc::new(Prepared::new(Arc::clone(scene), kernel, &Rays::Pixels(pixels))?);
    let wants = format.wants(options.certificates);
    let mut tracer: Box<dyn Tracer> = match backend.on_cpu {
        true => Box::new(CpuTracer::new(prepared, wants)),
        false => Box::new(GpuTracer::new(Arc::clone(&backend.gpu), prepared, wants)?),
    };
    let palette = scene.palette();
    let frame = Frame::from(&pixels);
    let mut writer = PictureWriter::create(format, options, frame, &palette, file, path)?;
    render(&mut *tracer, &pixels, plan.n_band_rows, &mut writer, control)?;
    output::commit([writer.finish()?], control)
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
