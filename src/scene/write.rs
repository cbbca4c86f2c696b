//! Scenes as text.

use super::{Camera, Projection};

/// A scene file with one cloud; `about` is its first line, a comment.
pub(crate) fn cloud_scene_text(about: &str, file: &str, camera: &Camera) -> String {
    let camera = camera_text(camera);
    // A name may hold quotes and backslashes.
    let file = toml::Value::from(file);
    format!("# {about}\nbackground = \"#20242c\"\n\n{camera}\n[[spheres]]\nfile = {file}\n")
}

/// The camera as a scene file has it, with all digits: read again, it is the same one.
pub(crate) fn camera_text(camera: &Camera) -> String {
    let Camera { position, look_at, up, projection } = camera;
    let [position, look_at, up] = [position, look_at, up].map(|v| v.to_array());
    let (key, number) = match projection {
        Projection::Perspective { fov_degrees } => ("fov", fov_degrees),
        Projection::Orthographic { height } => ("height", height),
    };
    format!(
        "[camera]\nposition = {position:?}\nlook_at  = {look_at:?}\nup       = {up:?}\n\
         {key:<8} = {number:?}\n"
    )
}
