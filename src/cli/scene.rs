//! Reading the scene, which takes a while where it has large clouds.

use std::path::Path;
use std::sync::Arc;

use kugelblitz::Result;
use kugelblitz::scene::{Scene, read_scene_with};

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
