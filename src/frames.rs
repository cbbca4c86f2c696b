//! Cameras and file names of a turntable film.

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::{Result, wrong_usage};
use crate::scene::{Camera, Scene, turned};

/// Most frames of a film: seven digits in their names.
pub const MAX_FRAMES: u32 = 9_999_999;

/// A camera that goes once around the point it looks at, about `up`, in `n_frames` equal steps. The
/// first frame is the camera itself, and the one after the last would be again: the film is a loop.
pub fn turntable(camera: &Camera, n_frames: u32) -> Vec<Camera> {
    let arm = camera.position - camera.look_at;
    let of_frame = |frame| {
        let position = camera.look_at + turned(arm, camera.up, frame, n_frames);
        Camera { position: if frame == 0 { camera.position } else { position }, ..camera.clone() }
    };
    (0..n_frames).map(of_frame).collect()
}

/// Refuses cameras that are so far from a scene's objects that f64 has no number for it.
///
/// # Errors
/// [`Error::Usage`](crate::Error::Usage) names the frame.
pub fn check_reach(cameras: &[Camera], scene: &Scene) -> Result<()> {
    let largest = |place: DVec3| place.abs().max_element();
    let extents = scene.objects().map(|(_, object)| object.extent());
    let reach = extents.map(|(at, radius)| largest(at) + radius).fold(0.0, f64::max);
    let is_far = |camera: &Camera| !(largest(camera.position) + reach).is_finite();
    match cameras.iter().position(is_far) {
        None => Ok(()),
        Some(frame) => wrong_usage(format!(
            "frame {}: the camera is too far from the objects: sums of coordinates must stay below \
             1.8e308",
            frame + 1
        )),
    }
}

/// The file of a frame: `film/out-0007.png` for `film/out.png`. `n_frames` says how many digits the
/// numbers have, at least four.
pub fn file_of_frame(output: &Path, frame: u32, n_frames: u32) -> PathBuf {
    let digits = n_digits(n_frames);
    numbered(output, &format!("{frame:0digits$}"))
}

/// The files of all frames as C's `printf` and ffmpeg name them: `film/out-%04d.png`.
pub fn pattern_of_files(output: &Path, n_frames: u32) -> PathBuf {
    let percent = |path: &Path| PathBuf::from(path.to_string_lossy().replace('%', "%%"));
    numbered(&percent(output), &format!("%0{}d", n_digits(n_frames)))
}

fn n_digits(n_frames: u32) -> usize {
    n_frames.to_string().len().max(4)
}

fn numbered(output: &Path, number: &str) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push("-");
    name.push(number);
    if let Some(ending) = output.extension() {
        name.push(".");
        name.push(ending);
    }
    output.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::new(DVec3::new(3.0, 2.0, 1.0), DVec3::new(1.0, 0.0, 1.0))
    }

    #[test]
    fn a_turntable_goes_around_once() {
        for up in [DVec3::Y, DVec3::Z, DVec3::new(0.1, 3.0, 0.2)] {
            let camera = Camera { up, ..camera() };
            let cameras = turntable(&camera, 8);
            assert_eq!((cameras.len(), &cameras[0]), (8, &camera));
            for (one, next) in cameras.iter().zip(cameras.iter().cycle().skip(1)) {
                let [a, b] = [one, next].map(|camera| camera.position - camera.look_at);
                assert!((a.length() - 8f64.sqrt()).abs() < 1e-14, "{a}");
                // The height above the turntable stays, and each step is an eighth of a turn.
                let axis = up.normalize();
                assert!((a.dot(axis) - b.dot(axis)).abs() < 1e-14);
                let [a, b] = [a, b].map(|v| v - axis * v.dot(axis));
                assert!(
                    (a.cross(b).dot(axis) / (a.length() * b.length()) - 0.5f64.sqrt()).abs()
                        < 1e-14
                );
            }
        }
    }

    #[test]
    fn files_are_numbered() {
        let at = |path: &str, frame, n| file_of_frame(path.as_ref(), frame, n);
        assert_eq!(at("a/out.png", 7, 36), Path::new("a/out-0007.png"));
        assert_eq!(at("out.tar.exr", 12, 12345), Path::new("out.tar-00012.exr"));
        let pattern = pattern_of_files("50%/out.png".as_ref(), 36);
        assert_eq!(pattern, Path::new("50%%/out-%04d.png"));
    }

    #[test]
    fn a_camera_out_of_reach_is_refused() {
        let around = DVec3::X * 0.8e308;
        let cameras = turntable(&Camera { position: DVec3::ZERO, look_at: around, ..camera() }, 2);
        let plane = crate::scene::Plane {
            name: None,
            point: DVec3::X * -1.7e308,
            normal: DVec3::Y,
            color: crate::scene::Color::BLACK,
        };
        let scene = Scene { planes: vec![plane], ..Scene::default() };
        assert!(check_reach(&cameras[..1], &scene).is_ok());
        let refused = check_reach(&cameras, &scene).unwrap_err();
        assert!(refused.to_string().starts_with("frame 2"), "{refused}");
    }
}
