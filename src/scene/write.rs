//! Scenes as text.

use std::path::{Path, PathBuf};

use super::{Camera, Projection, parse_scene};
use crate::error::{Error, Result, SceneError};

/// A scene file with one cloud; `about` is its first line, a comment.
pub(crate) fn cloud_scene_text(about: &str, file: &str, camera: &Camera) -> String {
    let camera = camera_text(camera);
    // A name may hold quotes and backslashes.
    let file = toml::Value::from(file);
    format!("# {about}\nbackground = \"#20242c\"\n\n{camera}\n[[spheres]]\nfile = {file}\n")
}

/// The camera in a line of a scene file, `camera = …`, with all digits.
pub(crate) fn camera_in_a_line(camera: &Camera) -> String {
    let Camera { position, look_at, up, .. } = camera;
    let [position, look_at, up] = [position, look_at, up].map(|v| v.to_array());
    let (key, number) = lens(camera);
    format!(
        "camera = {{ position = {position:?}, look_at = {look_at:?}, up = {up:?}, {key} = {number:?} }}"
    )
}

/// The key and the number that say how much the camera sees.
fn lens(camera: &Camera) -> (&'static str, f64) {
    match camera.projection {
        Projection::Perspective { fov_degrees } => ("fov", fov_degrees),
        Projection::Orthographic { height } => ("height", height),
    }
}

/// The camera as a scene file has it, with all digits: read again, it is the same one.
pub(crate) fn camera_text(camera: &Camera) -> String {
    let Camera { position, look_at, up, .. } = camera;
    let [position, look_at, up] = [position, look_at, up].map(|v| v.to_array());
    let (key, number) = lens(camera);
    format!(
        "[camera]\nposition = {position:?}\nlook_at  = {look_at:?}\nup       = {up:?}\n\
         {key:<8} = {number:?}\n"
    )
}

/// A camera that a scene file may have.
///
/// # Errors
/// [`Error::Usage`] in the words of the scene reader.
pub(crate) fn checked(camera: Camera) -> Result<Camera> {
    match parse_scene(&camera_text(&camera), Path::new("the camera")) {
        Ok(_) => Ok(camera),
        Err(Error::Scene(error)) => {
            let SceneError { message, help, .. } = *error;
            Err(Error::Usage(format!("the camera: {message}; {help}")))
        }
        Err(error) => Err(error),
    }
}

/// `cloud` as a scene file at `scene` names it: alone where they share a folder.
pub(crate) fn seen_from(scene: &Path, cloud: &Path) -> Result<PathBuf> {
    let name = cloud.file_name().map(PathBuf::from).unwrap_or_default();
    let folder_of_cloud = folder_of(cloud)?;
    Ok(if folder_of(scene)? == folder_of_cloud { name } else { folder_of_cloud.join(name) })
}

/// The folder of a file that may not be there yet, from the root on.
pub(super) fn folder_of(path: &Path) -> Result<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    folder.canonicalize().map_err(Error::io(folder))
}
