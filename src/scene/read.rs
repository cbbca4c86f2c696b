//! Scene files: what a valid scene is.

use std::io::{self, Read};
use std::path::Path;

use glam::DVec3;
use toml::de::DeTable;

use super::clouds::read_clouds;
use super::decode::Input;
use super::open::InputReader;
use super::raw::entries_of_toml;
use super::schema::{
    CameraKeys, CloudKeys, FOV, HEIGHT, ImageKeys, LightKeys, PlaneKeys, SceneKeys, Section,
    SkyKeys, SphereKeys,
};
use super::shipped::shipped_scene;
use super::sniff::{Content, DataFormat, recognize};
use super::table::{Checked, lacks, read_table, syntax_fault};
use super::{Camera, Color, Light, Plane, Projection, Scene, Sky, Source, Sphere, Spheres};
use crate::error::{Error, Message, Result, SceneError};
use crate::input::MAX_BYTES;
use crate::plain::Shown;
use crate::rays::View;
use crate::support::control::Control;
use crate::support::memory;

/// Reads and checks a scene file and the clouds that it names.
///
/// # Errors
/// [`Error::Scene`](crate::Error::Scene) for everything wrong in the file or a cloud,
/// [`Error::TooLarge`](crate::Error::TooLarge) for more spheres than have an id or fit the memory.
pub fn read_scene(path: &Path) -> Result<Scene> {
    parse_scene(&read_scene_text(path)?, path)
}

/// Bytes of memory for each byte of a scene file while it is parsed. Measured for TOML alone: 45 for spheres, 95 for lists of
/// short numbers; the tables made of them take as much again.
const PARSE_BYTES: u64 = 200;

/// The text of a scene file.
///
/// # Errors
/// [`Error::Scene`](crate::Error::Scene) where it can't be read, is not UTF-8, or has more than
/// [`MAX_BYTES`](crate::input::MAX_BYTES); [`Error::TooLarge`](crate::Error::TooLarge) where there is not the memory to
/// parse it.
pub fn read_scene_text(path: &Path) -> Result<String> {
    InputReader::new(&Control::default()).text(path)
}

/// The error of a scene file or data that cannot be read.
fn cannot_read(path: &Path, error: &io::Error) -> Error {
    let help = match error.kind() {
        io::ErrorKind::NotFound if DataFormat::of_name(path).is_some() => "check the path",
        io::ErrorKind::NotFound => {
            "check the path; built-in scenes such as `figure1` need no file, and `kugelblitz new scene.toml` writes one to start from"
        }
        io::ErrorKind::InvalidInput | io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData => {
            "the file may be damaged; copy or save it again"
        }
        _ => "give the path of a scene (TOML) or of data",
    };
    SceneError::whole_file(path, format!("cannot read it: {error}"), help).into()
}

/// Reads and checks the text of a scene file. `path` is for messages, and the files of clouds are
/// looked for from its folder.
///
/// # Errors
/// As [`read_scene`].
pub fn parse_scene(text: &str, path: &Path) -> Result<Scene> {
    Ok(InputReader::new(&Control::default()).parse(text, path)?.0)
}

impl<'c> InputReader<'_, 'c> {
    /// Opens a scene file or data. The name of a built-in scene gives its text if no file has this name.
    pub(super) fn open_scene(self, path: &Path) -> Result<Input<'c>> {
        let opened = self.input(path).or_else(|error| match shipped_scene(path) {
            Some(text) if error.kind() == io::ErrorKind::NotFound => {
                Input::new(Box::new(text.as_bytes()), Some(text.len() as u64))
            }
            _ => Err(error),
        });
        opened.map_err(|error| {
            self.control.check().err().unwrap_or_else(|| cannot_read(path, &error))
        })
    }

    /// Reads the text of a scene file, as [`read_scene_text`] does.
    pub(super) fn text(self, path: &Path) -> Result<String> {
        let input = self.open_scene(path)?;
        match recognize(input.head(), path) {
            Content::Scene => self.text_of(input, path),
            Content::Data(_) => {
                let help = "commands take data as they are; to make a scene of them, use `kugelblitz render DATA --print-scene=SCENE`";
                Err(SceneError::whole_file(path, "expected a scene, found data", help).into())
            }
            Content::Foreign(foreign) => {
                let message = format!("expected a scene or data, found {}", foreign.what);
                Err(SceneError::whole_file(path, message, foreign.hint(path)).into())
            }
        }
    }

    /// Reads the text of an open scene file.
    pub(super) fn text_of(self, input: Input, path: &Path) -> Result<String> {
        let mut bytes = Vec::new();
        let read = input.take(MAX_BYTES + 1).read_to_end(&mut bytes);
        read.map_err(|error| cannot_read(path, &error))?;
        const CLOUD: &str = "give many spheres as a cloud, in a file of their own: [[spheres]]";
        if bytes.len() as u64 > MAX_BYTES {
            let message =
                format!("the scene is larger than {} MiB, the most that is read", MAX_BYTES >> 20);
            return Err(SceneError::whole_file(path, message, CLOUD).into());
        }
        let what = format!("{}: parsing the scene", path.shown());
        memory::require(what, bytes.len() as u64 * PARSE_BYTES, CLOUD)?;
        String::from_utf8(bytes).map_err(|error| {
            let start = error.utf8_error().valid_up_to();
            let text = String::from_utf8_lossy(error.as_bytes());
            let message = format!(
                "byte 0x{:02x} is not UTF-8 text",
                error.as_bytes()[start..].first().copied().unwrap_or(0)
            );
            let help = "a scene file is TOML, saved as UTF-8";
            let span = start..start + char::REPLACEMENT_CHARACTER.len_utf8();
            SceneError::new(span, message, help).in_text(&text, path).into()
        })
    }

    /// The scene of such a text, and what was chosen of [`InputReader::usual`].
    pub(super) fn parse(self, text: &str, path: &Path) -> Result<(Scene, CloudKeys)> {
        let read = || {
            let (mut scene, clouds) = read_document(text)?;
            let folder = path.parent().unwrap_or(path);
            let chosen = read_clouds(&clouds, folder, self, &mut scene)?;
            Ok((scene, chosen))
        };
        read().map_err(|error| match error {
            Error::Scene(error) => error.in_text(text, path).into(),
            error => error,
        })
    }
}

/// The scene without its clouds, and what the file says about them.
fn read_document(text: &str) -> Checked<(Scene, Vec<CloudKeys>)> {
    let document = DeTable::parse(text).map_err(|error| syntax_fault(text, &error))?;
    read_table::<SceneKeys>(&entries_of_toml(document.get_ref()), 0..0)?.scene()
}

impl SceneKeys {
    fn scene(self) -> Checked<(Scene, Vec<CloudKeys>)> {
        let camera = self.camera.map(|camera| camera.camera()).transpose()?;
        let image = self.image.unwrap_or_default();
        let eye = camera.as_ref().map_or(DVec3::ZERO, |camera| camera.position);
        let lights = self.light.into_iter().flatten();
        let lights = lights.map(|light| light.light(eye)).collect::<Checked<_>>()?;
        let mut spheres = Spheres::default();
        for (index, keys) in (0..).zip(self.sphere.into_iter().flatten()) {
            let (sphere, color) = keys.sphere(eye)?;
            spheres.push(sphere, color);
            if let Some(name) = keys.name {
                spheres.set_name(index, name);
            }
        }
        let planes = self.plane.into_iter().flatten();
        let scene = Scene {
            background: self.background.unwrap_or_default(),
            image: image.size()?,
            samples: image.samples,
            lights,
            sky: self.sky.map(|sky| sky.sky()).transpose()?,
            ambient: self.ambient,
            planes: planes.map(|plane| plane.plane(eye)).collect::<Checked<_>>()?,
            camera,
            spheres,
            clouds: Vec::new(),
            notes: Vec::new(),
        };
        Ok((scene, self.spheres.unwrap_or_default()))
    }
}

/// The value of a key that its table must have.
macro_rules! need {
    ($keys:ident.$key:ident) => {
        $keys.$key.as_ref().ok_or_else(|| lacks($keys, &[stringify!($key)]))?
    };
}

/// The sine between `up` and the view axis above which `right` has a direction. Its f64 value is
/// wrong by less than 2⁻⁴⁹ (two normalised vectors with 2⁻⁵¹ each, 3·2⁻⁵³ for the cross product),
/// so at 2⁻⁴⁰ `right` is good to one part in 2⁹, and much below that it is rounding noise.
const MIN_UP_SINE: f64 = 1.0 / (1u64 << 40) as f64;

impl CameraKeys {
    /// Returns the camera.
    ///
    /// # Errors
    /// Names the key that is missing or wrong.
    pub fn camera(&self) -> Checked<Camera> {
        let (position, look_at) = (*need!(self.position), *need!(self.look_at));
        let axis = from_eye(self, "look_at", look_at, position)?;
        if axis == DVec3::ZERO {
            return Err(SceneError::new(
                self.span("look_at"),
                "`look_at` is the same point as `position`",
                "the camera looks from `position` towards `look_at`; move one of them",
            ));
        }
        let up = self.up.unwrap_or(DVec3::Y);
        let span_of_up = self.span(if self.up.is_some() { "up" } else { "look_at" });
        if up == DVec3::ZERO {
            let help = "choose a direction across the view, of any length but zero";
            return Err(SceneError::new(span_of_up, "`up` is the zero vector", help));
        }
        if !(direction(axis).cross(direction(up)).length() > MIN_UP_SINE) {
            let default = if self.up.is_none() { "default " } else { "" };
            let other =
                if direction(axis).abs().y > 0.5 { "[0.0, 0.0, 1.0]" } else { "[0.0, 1.0, 0.0]" };
            return Err(SceneError::new(
                span_of_up,
                format!(
                    "the {default}`up` {:?} is parallel to the view from `position` to `look_at`",
                    up.to_array()
                ),
                format!("choose a direction across the view, e.g. up = {other}"),
            ));
        }
        let mut camera = Camera { up, ..Camera::new(position, look_at) };
        let (key, number, projection, (expected, is_possible)) = match (self.fov, self.height) {
            (None, None) => return Ok(camera),
            (Some(fov), _) => ("fov", fov, Projection::Perspective { fov_degrees: fov }, FOV),
            (None, Some(height)) => ("height", height, Projection::Orthographic { height }, HEIGHT),
        };
        camera.projection = projection;
        // A number near the smallest f64 has no half or tangent but 0, and a picture no extent.
        if is_possible(number) && View::new(&camera).h > 0.0 {
            return Ok(camera);
        }
        let found = format!("`{key}` is {number:?}");
        Err(SceneError::new(self.span(key), found, format!("expected {expected}")))
    }
}

impl Camera {
    /// The camera, if a scene file may have it.
    ///
    /// # Errors
    /// [`Error::Usage`] in the words of the scene's reader.
    pub fn check(self) -> Result<Camera> {
        let checked = CameraKeys::from(&self).camera();
        checked.map_err(|error| {
            Error::Usage(Message::new(format!("the camera: {}", error.message), error.hint))
        })
    }
}

impl ImageKeys {
    /// The size, of which a file gives both sides or none.
    fn size(&self) -> Checked<Option<[u32; 2]>> {
        if self.width.is_none() && self.height.is_none() {
            return Ok(None);
        }
        Ok(Some([*need!(self.width), *need!(self.height)]))
    }
}

impl LightKeys {
    /// Returns the light, for a camera at `eye`.
    ///
    /// # Errors
    /// Names the key that is missing or reaches too far from `eye`.
    pub fn light(&self, eye: DVec3) -> Checked<Light> {
        let source = match (self.position, self.direction) {
            (Some(place), _) => {
                if let Source::Point(point) = place {
                    from_eye(self, "position", point, eye)?;
                }
                place
            }
            (None, Some(direction)) => Source::Sun(direction),
            (None, None) => return Err(lacks(self, &["position", "direction"])),
        };
        Ok(Light {
            source,
            color: self.color.unwrap_or(Color([1.0; 3])),
            intensity: self.intensity.unwrap_or(1.0),
            shadows: self.shadows.unwrap_or(true),
        })
    }
}

impl SkyKeys {
    /// Returns the sky.
    ///
    /// # Errors
    /// Names the key that is missing.
    pub fn sky(&self) -> Checked<Sky> {
        let directions = self.directions.unwrap_or(Sky::DIRECTIONS);
        Ok(Sky { intensity: *need!(self.intensity), directions })
    }
}

impl SphereKeys {
    fn sphere(&self, eye: DVec3) -> Checked<(Sphere, Color)> {
        let center = *need!(self.center);
        from_eye(self, "center", center, eye)?;
        let radius = *need!(self.radius);
        if !(center.abs() + DVec3::splat(radius)).is_finite() {
            return Err(too_far(self, "radius"));
        }
        Ok((Sphere { center, radius }, *need!(self.color)))
    }
}

impl PlaneKeys {
    /// Returns the plane, for a camera at `eye`.
    ///
    /// # Errors
    /// Names the key that is missing or reaches too far from `eye`.
    pub fn plane(&self, eye: DVec3) -> Checked<Plane> {
        let point = *need!(self.point);
        from_eye(self, "point", point, eye)?;
        Ok(Plane {
            point,
            normal: *need!(self.normal),
            color: *need!(self.color),
            name: self.name.as_deref().map(Into::into),
        })
    }
}

impl CloudKeys {
    /// The file, where the other keys go together.
    pub(super) fn file(&self) -> Checked<&str> {
        let file = need!(self.file);
        let of_map = [
            ("colormap", self.colormap.is_some()),
            ("range", self.range.is_some()),
            ("missing_color", self.missing_color.is_some()),
        ];
        match of_map.into_iter().find(|(_, is_given)| *is_given) {
            Some((key, _)) if self.color_by.is_none() => Err(SceneError::new(
                self.span(key),
                format!("`{key}` is given without `color_by`"),
                "it says how a column is coloured: name the column, e.g. `color_by = \"speed\"`",
            )),
            _ => Ok(file),
        }
    }
}

/// `point − eye`, which all later arithmetic starts from.
fn from_eye(section: &impl Section, key: &str, point: DVec3, eye: DVec3) -> Checked<DVec3> {
    let difference = point - eye;
    if difference.is_finite() { Ok(difference) } else { Err(too_far(section, key)) }
}

fn too_far(section: &impl Section, key: &str) -> Box<SceneError> {
    SceneError::new(
        section.span(key),
        format!("`{key}` reaches too far from the eye or the origin"),
        "sums and differences of coordinates must stay below 1.8e308, the largest 64-bit float",
    )
}

/// `v` with length 1, without overflow or underflow on the way.
fn direction(v: DVec3) -> DVec3 {
    (v / v.abs().max_element()).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bound on `up` is where its derivation puts it: three quarters of it is parallel, five
    /// quarters is not, at any length of `up`.
    #[test]
    fn up_is_parallel_at_its_bound() {
        let camera = |sine: f64, length: f64| {
            let across = sine * length;
            read_document(&format!(
                "[camera]\nposition=[0,0,0]\nlook_at=[0,0,-3]\nup=[{across:e},0,{length:e}]"
            ))
        };
        for length in [1e-200, 1.0, 1e200] {
            assert!(camera(0.75 * 2f64.powi(-40), length).is_err(), "{length}");
            assert!(camera(1.25 * 2f64.powi(-40), length).is_ok(), "{length}");
        }
    }
}
