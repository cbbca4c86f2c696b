//! Reading and preparing the scene, which take a while where it has large clouds.

use std::path::Path;
use std::sync::Arc;

use kugelblitz::Result;
use kugelblitz::output;
use kugelblitz::prepare::Prepared;
use kugelblitz::scene::{Scene, read_scene_with};
use kugelblitz::trace::{Kernel, Rays};

use super::output::count;
use super::progress::Progress;
use super::{Run, TalkArgs};

/// Reads a scene and shows how far it is.
///
/// # Errors
/// Those of [`read_scene_with`].
pub fn read(path: &Path, talk: &TalkArgs, run: &Run) -> Result<Arc<Scene>> {
    let _progress = Progress::of_bytes(talk, &run.control);
    read_scene_with(path, &run.control).map(Arc::new)
}

/// Prepares a scene, and shows that it takes a while.
///
/// # Errors
/// Those of [`Prepared::new_with`].
pub fn prepare(
    scene: &Arc<Scene>,
    kernel: Kernel,
    rays: &Rays,
    talk: &TalkArgs,
    run: &Run,
) -> Result<Arc<Prepared>> {
    let what = match kernel {
        Kernel::Certified => "building the hierarchy over",
        Kernel::Lecture | Kernel::Stable | Kernel::Double => "preparing",
    };
    let _progress = Progress::of_step(
        talk,
        format!("{what} {}, {}", count(scene.spheres.len(), "sphere"), kernel.name()),
    );
    Prepared::new_with(Arc::clone(scene), kernel, rays, &run.control).map(Arc::new)
}

/// Refuses outputs that would replace what they are made from, or each other.
///
/// # Errors
/// [`kugelblitz::Error::Usage`]
pub fn refuse_overwriting(outputs: &[&Path], inputs: &[&Path], scene: &Scene) -> Result<()> {
    let clouds = scene.clouds.iter().map(|cloud| &*cloud.path);
    let inputs: Vec<&Path> = inputs.iter().copied().chain(clouds).collect();
    output::refuse_overwriting(outputs, &inputs)
}
