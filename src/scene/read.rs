//! Scene files: what a valid scene is.

use std::ops::Range;
use std::path::Path;

use glam::DVec3;
use toml::de::DeTable;

use super::clouds::{CloudTable, ColumnNames, Part, is_cloud_file, read_clouds};
use super::open::Files;
use super::places::{Fault, Stop};
use super::schema::{
    CameraKeys, CloudKeys, ColumnKeys, FOV, HEIGHT, ImageKeys, LightKeys, PlaneKeys, SceneKeys,
    SkyKeys, Spanned, SphereKeys,
};
use super::sniff::look_of_bytes;
use super::table::{Checked, lacks, read_table, syntax_fault};
use super::{
    Camera, Color, Coloring, ImageSize, Light, Plane, Projection, Scene, Sky, Source, Sphere,
    Spheres,
};
use crate::control::Control;
use crate::error::{Error, Result, SceneError};
use crate::input::MAX_BYTES;
use crate::memory;
use crate::plain::Shown;
use crate::rays::View;

/// Reads and checks a scene file and the clouds that it names.
///
/// # Errors
/// [`Error::Scene`](crate::Error::Scene) for everything wrong in the file or a cloud,
/// [`Error::TooLarge`](crate::Error::TooLarge) for more spheres than have an id or fit the memory.
pub fn read_scene(path: &Path) -> Result<Scene> {
    read_scene_with(path, &Control::default())
}

/// Reads and checks a scene file as [`read_scene`] does; `control` counts the bytes of the clouds and can stop the reading.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted) as well.
pub fn read_scene_with(path: &Path, control: &Control) -> Result<Scene> {
    read_scene_from(Files::All, path, control)
}

/// Reads and checks a scene file as [`read_scene_with`] does, for those who read a scene again while they watch its file: what is
/// no regular file, the scene's or a cloud's, is an error, for it could keep its reader for ever.
///
/// # Errors
/// As [`read_scene_with`].
pub fn reread_scene(path: &Path, control: &Control) -> Result<Scene> {
    read_scene_from(Files::Regular, path, control)
}

fn read_scene_from(files: Files, path: &Path, control: &Control) -> Result<Scene> {
    parse_scene_from(files, &text_of(files, path)?, path, control)
}

/// Bytes of memory for each byte of a scene file while it is parsed. Measured for TOML alone: 45 for spheres, 95 for
/// lists of short numbers. What tables take beside that is asked for when they are read.
const PARSE_BYTES: u64 = 100;

/// The text of a scene file.
///
/// # Errors
/// [`Error::Scene`](crate::Error::Scene) where it can't be read, is not UTF-8, or has more than
/// [`MAX_BYTES`](crate::input::MAX_BYTES); [`Error::TooLarge`](crate::Error::TooLarge) where there is not the memory to
/// parse it.
pub fn read_scene_text(path: &Path) -> Result<String> {
    text_of(Files::All, path)
}

pub(super) fn text_of(files: Files, path: &Path) -> Result<String> {
    let bytes = files.read(path, MAX_BYTES + 1).map_err(|error| {
        let message = format!("cannot read the scene: {error}");
        SceneError::whole_file(path, message, "give the path of a scene file (TOML)")
    })?;
    const CLOUD: &str = "give many spheres as a cloud, in a file of their own: [[spheres]]";
    if is_cloud_file(path) {
        return Err(no_scene(path, "data of spheres, by its name"));
    }
    if bytes.len() as u64 > MAX_BYTES {
        let message =
            format!("the scene is larger than {} MiB, the most that is read", MAX_BYTES >> 20);
        return Err(SceneError::whole_file(path, message, CLOUD).into());
    }
    if let Some(found) = look_of_bytes(&bytes) {
        return Err(no_scene(path, found));
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
        Fault::new(span, message, help).in_text(&text, path).into()
    })
}

/// The error of a file that is something else.
fn no_scene(path: &Path, found: &str) -> Error {
    let name = path.shown();
    let help = format!(
        "a scene is a text in TOML; data that end in .npy, .csv or .xyz become one by `kugelblitz render \
         {name} --print-scene=scene.toml`, and all commands but `report` take them as they are"
    );
    SceneError::whole_file(path, format!("this is no scene, but {found}"), help).into()
}

/// Reads and checks the text of a scene file. `path` is for messages, and the files of clouds are
/// looked for from its folder.
///
/// # Errors
/// As [`read_scene`].
pub fn parse_scene(text: &str, path: &Path) -> Result<Scene> {
    parse_scene_with(text, path, &Control::default())
}

/// Reads and checks the text of a scene file as [`parse_scene`] does; `control` counts the bytes of the clouds and can stop the
/// reading.
///
/// # Errors
/// As [`read_scene_with`].
pub fn parse_scene_with(text: &str, path: &Path, control: &Control) -> Result<Scene> {
    parse_scene_from(Files::All, text, path, control)
}

pub(super) fn parse_scene_from(
    files: Files,
    text: &str,
    path: &Path,
    control: &Control,
) -> Result<Scene> {
    let read = || -> Result<Scene, Stop> {
        let (mut scene, clouds) = read_document(text)?;
        read_clouds(&clouds, path.parent().unwrap_or(path), files, &mut scene, control)?;
        Ok(scene)
    };
    read().map_err(|stop| stop.in_text(text, path))
}

/// The scene without its clouds, and what the file says about them.
fn read_document(text: &str) -> Checked<(Scene, Vec<CloudTable>)> {
    let document = DeTable::parse(text).map_err(|error| syntax_fault(text, &error))?;
    read_table::<SceneKeys>(document.get_ref(), 0..0)?.scene()
}

impl SceneKeys {
    fn scene(self) -> Checked<(Scene, Vec<CloudTable>)> {
        let camera = self.camera.map(|camera| camera.camera()).transpose()?;
        let image = self.image.unwrap_or_else(|| ImageKeys::default().into()).value;
        let eye = camera.as_ref().map_or(DVec3::ZERO, |camera| camera.position);
        let lights = each(self.light, |light| light.light(eye))?;
        let mut spheres = Spheres::default();
        for (index, keys) in (0..).zip(self.sphere.into_iter().flat_map(|all| all.value)) {
            let (sphere, color) = keys.sphere(eye)?;
            spheres.push(sphere, color);
            if let Some(name) = keys.name {
                spheres.set_name(index, name.value);
            }
        }
        let scene = Scene {
            background: self.background.map_or(Color::BLACK, |color| color.value),
            image: image.size()?,
            samples: image.samples.map(|samples| samples.value),
            lights,
            sky: self.sky.map(|sky| sky.sky()).transpose()?,
            ambient: self.ambient.map(|ambient| ambient.value),
            planes: each(self.plane, |plane| plane.plane(eye))?,
            camera,
            spheres,
            clouds: Vec::new(),
            notes: Vec::new(),
        };
        Ok((scene, each(self.spheres, CloudKeys::cloud)?))
    }
}

/// The value of a key that its table must have.
macro_rules! need {
    ($keys:ident.$key:ident) => {
        $keys.$key.as_ref().ok_or_else(|| lacks::<Self>(&$keys.span, &[stringify!($key)]))?
    };
}

/// What `of` makes of each table under a key.
fn each<S, T>(tables: Option<Spanned<Vec<S>>>, of: impl Fn(S) -> Checked<T>) -> Checked<Vec<T>> {
    tables.into_iter().flat_map(|tables| tables.value).map(of).collect()
}

/// The sine between `up` and the view axis above which `right` has a direction. Its f64 value is
/// wrong by less than 2⁻⁴⁹ (two normalised vectors with 2⁻⁵¹ each, 3·2⁻⁵³ for the cross product),
/// so at 2⁻⁴⁰ `right` is good to one part in 2⁹, and much below that it is rounding noise.
const MIN_UP_SINE: f64 = 1.0 / (1u64 << 40) as f64;

impl CameraKeys {
    /// The camera that this says.
    fn camera(&self) -> Checked<Camera> {
        let position = need!(self.position).value;
        let look_at = need!(self.look_at);
        let axis = from_eye("look_at", look_at.value, &look_at.span, position)?;
        if axis == DVec3::ZERO {
            return Err(Fault::new(
                look_at.span.clone(),
                "`look_at` is the same point as `position`",
                "the camera looks from `position` towards `look_at`; move one of them",
            ));
        }
        let up = self.up.as_ref().map_or(DVec3::Y, |up| up.value);
        if up == DVec3::ZERO {
            let span = self.up.as_ref().map_or(&look_at.span, |up| &up.span);
            let help = "choose a direction across the view, of any length but zero";
            return Err(Fault::new(span.clone(), "`up` is the zero vector", help));
        }
        if !(direction(axis).cross(direction(up)).length() > MIN_UP_SINE) {
            let default = if self.up.is_none() { "default " } else { "" };
            let other = match direction(axis).abs().y > 0.5 {
                true => "[0.0, 0.0, 1.0]",
                false => "[0.0, 1.0, 0.0]",
            };
            return Err(Fault::new(
                self.up.as_ref().map_or(&look_at.span, |up| &up.span).clone(),
                format!(
                    "the {default}`up` {:?} is parallel to the view from `position` to `look_at`",
                    up.to_array()
                ),
                format!("choose a direction across the view, e.g. up = {other}"),
            ));
        }
        let mut camera = Camera { up, ..Camera::new(position, look_at.value) };
        let (key, given, projection, (expected, is_possible)) = match (&self.fov, &self.height) {
            (None, None) => return Ok(camera),
            (Some(fov), _) => ("fov", fov, Projection::Perspective { fov_degrees: fov.value }, FOV),
            (None, Some(height)) => {
                ("height", height, Projection::Orthographic { height: height.value }, HEIGHT)
            }
        };
        camera.projection = projection;
        let number = given.value;
        // A number near the smallest f64 has no half or tangent but 0, and a picture no extent.
        if is_possible(number) && View::new(&camera).h > 0.0 {
            return Ok(camera);
        }
        let found = format!("`{key}` is {number:?}");
        Err(Fault::new(given.span.clone(), found, format!("expected {expected}")))
    }
}

impl Camera {
    /// The camera, if a scene file may have it.
    ///
    /// # Errors
    /// [`Error::Usage`] in the words of the scene's reader.
    pub fn check(self) -> Result<Camera> {
        let checked = CameraKeys::from(&self).camera();
        checked.map_err(|Fault { message, help, .. }| {
            Error::Usage(format!("the camera: {message}; {help}"))
        })
    }
}

impl ImageKeys {
    /// The size, of which a file gives both sides or none.
    fn size(&self) -> Checked<Option<ImageSize>> {
        if self.width.is_none() && self.height.is_none() {
            return Ok(None);
        }
        let width = need!(self.width).value;
        let height = need!(self.height).value;
        Ok(Some(ImageSize { width, height }))
    }
}

impl LightKeys {
    fn light(self, eye: DVec3) -> Checked<Light> {
        let source = match (&self.position, &self.direction) {
            (Some(place), _) => {
                if let Source::Point(point) = place.value {
                    from_eye("position", point, &place.span, eye)?;
                }
                place.value
            }
            (None, Some(direction)) => Source::Sun(direction.value),
            (None, None) => return Err(lacks::<Self>(&self.span, &["position", "direction"])),
        };
        Ok(Light {
            source,
            color: self.color.map_or(Color([1.0; 3]), |color| color.value),
            intensity: self.intensity.map_or(1.0, |intensity| intensity.value),
            shadows: self.shadows.is_none_or(|shadows| shadows.value),
        })
    }
}

impl SkyKeys {
    fn sky(&self) -> Checked<Sky> {
        let intensity = need!(self.intensity).value;
        let directions = self.directions.as_ref().map_or(Sky::DIRECTIONS, |number| number.value);
        Ok(Sky { intensity, directions })
    }
}

impl SphereKeys {
    fn sphere(&self, eye: DVec3) -> Checked<(Sphere, Color)> {
        let center = need!(self.center);
        from_eye("center", center.value, &center.span, eye)?;
        let radius = need!(self.radius);
        let sphere = Sphere { center: center.value, radius: radius.value };
        if !(sphere.center.abs() + DVec3::splat(sphere.radius)).is_finite() {
            return Err(too_far("radius", &radius.span));
        }
        Ok((sphere, need!(self.color).value))
    }
}

impl PlaneKeys {
    fn plane(self, eye: DVec3) -> Checked<Plane> {
        let point = need!(self.point);
        from_eye("point", point.value, &point.span, eye)?;
        Ok(Plane {
            point: point.value,
            normal: need!(self.normal).value,
            color: need!(self.color).value,
            name: self.name.map(|name| name.value.into()),
        })
    }
}

impl CloudKeys {
    fn cloud(self) -> Checked<CloudTable> {
        let file = need!(self.file).clone();
        if self.color_by.is_none() {
            let keys = [
                ("colormap", self.colormap.as_ref().map(|key| &key.span)),
                ("range", self.range.as_ref().map(|key| &key.span)),
                ("missing_color", self.missing_color.as_ref().map(|key| &key.span)),
            ];
            if let Some((key, span)) = keys.into_iter().find_map(|(key, span)| Some((key, span?))) {
                return Err(Fault::new(
                    span.clone(),
                    format!("`{key}` is given without `color_by`"),
                    "it says how a column is coloured: name the column, e.g. `color_by = \"speed\"`",
                ));
            }
        }
        let ColumnKeys { x, y, z, radius, diameter, red, green, blue, element, .. } =
            self.columns.map(|columns| columns.value).unwrap_or_default();
        let mut columns = ColumnNames::default();
        let names = [x, y, z, radius, diameter, red, green, blue, element];
        Part::ALL.into_iter().zip(names).for_each(|(part, name)| columns.set(part, name));
        Ok(CloudTable {
            file,
            radius: self.radius,
            color: self.color,
            columns,
            color_by: self.color_by,
            colormap: self.colormap.map(|map| map.value).unwrap_or_default(),
            range: self.range.map(|range| range.value),
            missing_color: self.missing_color.map_or(Coloring::MISSING_COLOR, |key| key.value),
            frame: self.frame,
        })
    }
}

/// `point − eye`, which all later arithmetic starts from.
fn from_eye(key: &str, point: DVec3, span: &Range<usize>, eye: DVec3) -> Checked<DVec3> {
    let difference = point - eye;
    match difference.is_finite() {
        true => Ok(difference),
        false => Err(too_far(key, span)),
    }
}

fn too_far(key: &str, span: &Range<usize>) -> Fault {
    Fault::new(
        span.clone(),
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
