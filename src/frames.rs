//! The cameras of a film: a turntable, or a path from a file.

use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::{Error, Result, wrong_usage};
use crate::input;
use crate::memory;
use crate::plain::Shown;
use crate::scene::{Camera, Projection, Scene, turned};
use crate::words::did_you_mean;

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

/// The columns of a path: the camera's position, the point that it looks at, the direction upward, and its projection.
const COLUMNS: [&str; 11] =
    ["x", "y", "z", "look_at_x", "look_at_y", "look_at_z", "up_x", "up_y", "up_z", "fov", "height"];

/// The names of the first three in other files.
const POSITION: [&str; 3] = ["position_x", "position_y", "position_z"];

/// Sets the number of a column.
fn set(camera: &mut Camera, column: usize, number: f64) {
    let axis = column % 3;
    match column {
        0..3 => camera.position[axis] = number,
        3..6 => camera.look_at[axis] = number,
        6..9 => camera.up[axis] = number,
        9 => camera.projection = Projection::Perspective { fov_degrees: number },
        _ => camera.projection = Projection::Orthographic { height: number },
    }
}

/// Reads a camera path: a `.csv` file whose header names `x`, `y`, `z` (the camera's position) and any
/// of `look_at_x`, `look_at_y`, `look_at_z`, `up_x`, `up_y`, `up_z`, and `fov` or `height`. What it does
/// not name is as in `camera`. Each line is a frame.
///
/// # Errors
/// Those of [`input::read_text`]; [`Error::Input`] names the line where something is wrong.
pub fn read_path(path: &Path, camera: &Camera) -> Result<Vec<Camera>> {
    let wrong = |message: String| Error::Input { path: path.to_owned(), message };
    let text = input::read_text(path, "a camera's path", "make parts")?;
    input::check_lines(&text, path)?;
    let n_lines = text.lines().count();
    // Twice, as lists that grow are moved.
    let n_bytes = 2 * n_lines * size_of::<Camera>();
    let what = format!("{}: a film of {n_lines} frames", path.shown());
    memory::require(what, n_bytes as u64, "make parts")?;
    let text = text.trim_start_matches('\u{feff}');
    let is_told = |(_, line): &(usize, &str)| !line.trim().is_empty() && !line.starts_with('#');
    let mut lines = (1..).zip(text.lines()).filter(is_told);
    let header = cells(lines.next().unwrap_or_default().1);
    let columns = columns_of(&header).map_err(wrong)?;

    let mut cameras: Vec<Camera> = Vec::new();
    for (line, text) in lines {
        let cells = cells(text);
        let of_line = |message: String| wrong(format!("line {line}: {message}"));
        if cameras.len() == MAX_FRAMES as usize {
            return Err(of_line(format!("a film has at most {MAX_FRAMES} frames; make parts")));
        }
        let (n_cells, n_columns) = (cells.len(), columns.len());
        if n_cells != n_columns {
            return Err(of_line(format!(
                "{n_cells} values, but the header names {n_columns} columns"
            )));
        }
        let mut of_frame = camera.clone();
        for (text, &column) in cells.into_iter().zip(&columns) {
            match text.parse::<f64>() {
                Ok(number) if number.is_finite() => set(&mut of_frame, column, number),
                _ => return Err(of_line(format!("{text:?} is not a finite number"))),
            }
        }
        cameras.push(of_frame.check().map_err(|error| of_line(error.to_string()))?);
    }
    if cameras.is_empty() {
        Err(wrong("there is no line below the header; give one for each frame".into()))
    } else {
        Ok(cameras)
    }
}

/// What stands between commas, without white space and quotes around it.
fn cells(line: &str) -> Vec<&str> {
    line.split(',').map(|cell| cell.trim().trim_matches('"')).collect()
}

/// Refuses cameras that are so far from a scene's objects that f64 has no number for it.
///
/// # Errors
/// [`Error::Usage`] names the frame.
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

/// The places in [`COLUMNS`] of the columns of a path, in the order of the file.
fn columns_of(header: &[&str]) -> Result<Vec<usize>, String> {
    let mut places = Vec::new();
    for name in header {
        let name = name.to_lowercase();
        if name == "frame" {
            return Err("the column `frame` numbers keys, and nothing is interpolated between keys: leave it \
                        out, and give a line for each frame"
                .into());
        }
        let names = || COLUMNS.into_iter().chain(POSITION);
        let place = names().position(|known| known == name);
        let Some(place) = place.map(|place| place % COLUMNS.len()) else {
            let near = did_you_mean(names(), &name);
            let hint = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
            let known = COLUMNS.join(", ");
            return Err(format!("unknown column {name:?}; {hint}known columns: {known}"));
        };
        if places.contains(&place) {
            return Err(format!("the column {name:?} is named twice"));
        }
        places.push(place);
    }
    let count = |range: Range<usize>| places.iter().filter(|place| range.contains(place)).count();
    if count(9..11) == 2 {
        return Err("`fov` is for a perspective camera, `height` for an orthographic one; keep one of the columns"
            .into());
    }
    if count(0..3) == 0 {
        let found = header.join(", ");
        return Err(format!(
            "the header has no columns x, y, z for the camera's position, only {found:?}"
        ));
    }
    for (what, three) in [
        ("the camera's position", 0..3),
        ("the point that is looked at", 3..6),
        ("the direction upward", 6..9),
    ] {
        if ![0, 3].contains(&count(three.clone())) {
            return Err(format!("{what} has three columns: {}", COLUMNS[three].join(", ")));
        }
    }
    Ok(places)
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

    fn read(text: &str) -> Result<Vec<Camera>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        std::fs::write(&path, text).unwrap();
        read_path(&path, &camera())
    }

    #[test]
    fn each_line_is_a_frame() {
        let cameras = read("x,y,z,fov\n1,2,3,40\n# later\n4,5,6,50\n").unwrap();
        let expected = |position, fov_degrees| Camera {
            position,
            projection: Projection::Perspective { fov_degrees },
            ..camera()
        };
        let [one, two] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)];
        assert_eq!(cameras, [expected(one, 40.0), expected(two, 50.0)]);
        let all = "position_x,position_y,position_z,look_at_x,look_at_y,look_at_z,up_x,up_y,up_z,height\n\
                   0,0,9, 0,0,0, 0,1,0, 2\n8,0,9, 0,4,0, 0,1,0, 4\n";
        let cameras = read(all).unwrap();
        assert_eq!(cameras.len(), 2);
        assert_eq!(cameras[1].position, DVec3::new(8.0, 0.0, 9.0));
        assert_eq!(cameras[1].look_at, DVec3::new(0.0, 4.0, 0.0));
        assert_eq!(cameras[1].projection, Projection::Orthographic { height: 4.0 });
    }

    #[test]
    fn what_is_wrong_in_a_path_is_named() {
        for (text, says) in [
            ("", "x, y, z"),
            ("x,y\n1,2\n", "three columns"),
            ("x,y,z,lookat_x\n", "did you mean `look_at_x`?"),
            ("x,y,z,x\n", "twice"),
            ("x,y,z,fov,height\n", "keep one"),
            ("x,y,z\n", "no line below"),
            ("x,y,z\n1,2\n", "line 2"),
            ("x,y,z\n1,2,3\n1,2,abc\n", "line 3: \"abc\""),
            ("x,y,z\n1,2,inf\n", "finite"),
            ("x,y,z\n1,0,1\n", "line 2: the camera: `look_at` is the same point"),
            ("x,y,z,fov\n1,2,3,180\n", "line 2: the camera: `fov`"),
            ("x,y,z,up_x,up_y,up_z\n1,2,3,0,0,0\n", "line 2: the camera: `up` is the zero vector"),
            ("frame,x,y,z\n1,1,2,3\n9,2,2,3\n", "a line for each frame"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.to_string().contains(says), "{text:?}: {error}");
            assert_eq!(error.exit_code(), 1);
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
        let far = Camera { position: DVec3::X * 1.7e308, ..camera() };
        let plane = crate::scene::Plane {
            name: None,
            point: DVec3::X * -1.7e308,
            normal: DVec3::Y,
            color: crate::scene::Color::BLACK,
        };
        let scene = Scene { planes: vec![plane], ..Scene::default() };
        assert!(check_reach(&[camera()], &scene).is_ok());
        let refused = check_reach(&[camera(), far], &scene).unwrap_err();
        assert!(refused.to_string().starts_with("frame 2"), "{refused}");
    }
}
