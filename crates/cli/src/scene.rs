//! Reading and preparing the scene, which take a while where it has large clouds.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use kugelblitz::Result;
use kugelblitz::output;
use kugelblitz::scene::{Scene, read_scene_with};
use kugelblitz::trace::Kernel;
use kugelblitz::words::count;

use crate::Run;
use crate::progress::Progress;

/// Reads a scene, shows how far it is, and says what its reader noted.
///
/// # Errors
/// Those of [`read_scene_with`].
pub fn read(path: &Path, run: &Run) -> Result<Arc<Scene>> {
    let scene = Progress::of_bytes(run).during(|| read_scene_with(path, &run.control))?;
    say_notes(&scene, run);
    Ok(Arc::new(scene))
}

/// Says what the reader of a scene noted.
pub fn say_notes(scene: &Scene, run: &Run) {
    scene.notes.iter().for_each(|note| run.say(note));
}

/// Shows, while it lives, that preparing a scene takes a while.
pub fn preparing(scene: &Scene, kernel: Kernel, run: &Run) -> Progress {
    let has_hierarchy = kernel == Kernel::Certified;
    let what = if has_hierarchy { "building the hierarchy over" } else { "preparing" };
    let n_spheres = count(scene.spheres.len(), "sphere");
    Progress::of_step(run, format!("{what} {n_spheres}, {}", kernel.name()))
}

/// Refuses outputs that would replace what they are made from, or each other.
///
/// # Errors
/// [`kugelblitz::Error::Usage`]
pub fn refuse_overwriting<'p>(
    outputs: impl IntoIterator<Item: AsRef<Path>>,
    inputs: impl IntoIterator<Item = &'p PathBuf>,
    scene: &'p Scene,
) -> Result<()> {
    let clouds = scene.clouds.iter().map(|cloud| &cloud.path);
    output::refuse_overwriting(outputs, inputs.into_iter().chain(clouds))
}
