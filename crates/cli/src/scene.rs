//! Preparing the scene, which takes a while where it has large clouds, and what it is made from.

use std::path::{Path, PathBuf};

use kugelblitz::Result;
use kugelblitz::output;
use kugelblitz::scene::Scene;
use kugelblitz::trace::Kernel;
use kugelblitz::words::count;

use crate::Run;
use crate::progress::Progress;

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
