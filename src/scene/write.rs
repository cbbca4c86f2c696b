//! Scenes as text.

use super::Camera;

/// A scene file with one cloud; `about` is its first line, a comment.
pub(crate) fn cloud_scene_text(about: &str, file: &str, camera: &Camera) -> String {
    let Camera { position, look_at, up, fov_degrees } = camera;
    let [position, look_at, up] = [position, look_at, up].map(|v| v.to_array());
    // A name may hold quotes and backslashes.
    let file = toml::Value::from(file);
    format!(
        "# {about}\nbackground = \"#20242c\"\n\n[camera]\nposition = {position:?}\n\
         look_at = {look_at:?}\nup = {up:?}\nfov = {fov_degrees:?}\n\n[[spheres]]\nfile = {file}\n"
    )
}
