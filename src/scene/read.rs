//! Scene files: which tables and keys they have, and what a valid scene is.

use std::path::Path;

use glam::DVec3;
use toml::de::DeTable;

use super::clouds::{CloudTable, ColumnNames, Given, Part, is_cloud_file, read_clouds};
use super::open::Files;
use super::places::{Fault, Stop};
use super::sniff::look_of_bytes;
use super::table::{Checked, Field, Kind, Table, syntax_fault};
use super::{
    Camera, Color, ColorMap, Coloring, ImageSize, Light, Plane, Projection, Samples, Scene, Sky,
    Source, Sphere, Spheres,
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

/// As [`read_scene`]; `control` counts the bytes of the clouds and can stop the reading.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted) as well.
pub fn read_scene_with(path: &Path, control: &Control) -> Result<Scene> {
    read_scene_from(Files::All, path, control)
}

/// As [`read_scene_with`], for those who read a scene again while they watch its file: what is no
/// regular file, the scene's or a cloud's, is an error, for it could keep its reader for ever.
///
/// # Errors
/// As [`read_scene_with`].
pub fn reread_scene(path: &Path, control: &Control) -> Result<Scene> {
    read_scene_from(Files::Regular, path, control)
}

fn read_scene_from(files: Files, path: &Path, control: &Control) -> Result<Scene> {
    parse_scene_from(files, &text_of(files, path)?, path, control)
}

/// Bytes of memory for each byte of a scene file while it is parsed. Measured: 42 for spheres, 76
/// for lists of short numbers.
const PARSE_BYTES: u64 = 80;

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
         {name} --print-scene=scene.toml`, and `render`, `view` and `export` take them as they are"
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

/// As [`parse_scene`]; `control` counts the bytes of the clouds and can stop the reading.
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

const TOP: Kind = Kind {
    header: "the top of the file",
    keys: &[
        ("background", "\"#20242c\""),
        ("ambient", "0.1"),
        ("camera", ""),
        ("image", ""),
        ("light", ""),
        ("sky", ""),
        ("sphere", ""),
        ("spheres", ""),
        ("plane", ""),
    ],
};
const CAMERA: Kind = Kind {
    header: "[camera]",
    keys: &[
        ("position", "[0.0, 1.0, 6.0]"),
        ("look_at", "[0.0, 0.5, 0.0]"),
        ("up", "[0.0, 1.0, 0.0]"),
        ("fov", "40.0"),
        ("height", "4.0"),
    ],
};
const IMAGE: Kind =
    Kind { header: "[image]", keys: &[("width", "1280"), ("height", "720"), ("samples", "4")] };
const LIGHT: Kind = Kind {
    header: "[[light]]",
    keys: &[
        ("position", "[4.0, 6.0, 3.0]"),
        ("direction", "[-1.0, -2.0, -1.0]"),
        ("color", "\"#ffffff\""),
        ("intensity", "0.9"),
        ("shadows", "true"),
    ],
};
const SKY: Kind = Kind { header: "[sky]", keys: &[("intensity", "0.5"), ("directions", "64")] };
const SPHERE: Kind = Kind {
    header: "[[sphere]]",
    keys: &[
        ("name", "\"red giant\""),
        ("center", "[0.0, 1.0, -4.0]"),
        ("radius", "2.0"),
        ("color", "\"#d62728\""),
    ],
};
const PLANE: Kind = Kind {
    header: "[[plane]]",
    keys: &[
        ("name", "\"floor\""),
        ("point", "[0.0, 0.0, 0.0]"),
        ("normal", "[0.0, 1.0, 0.0]"),
        ("color", "\"#8c8c8c\""),
    ],
};
const SPHERES: Kind = Kind {
    header: "[[spheres]]",
    keys: &[
        ("file", "\"cloud.npy\""),
        ("radius", "0.01"),
        ("color", "\"#1f77b4\""),
        ("columns", ""),
        ("color_by", "\"speed\""),
        ("colormap", "\"viridis\""),
        ("range", "[0.0, 2.5]"),
        ("missing_color", "\"#ff00ff\""),
        ("frame", "0"),
    ],
};
const COLUMNS: Kind = Kind {
    header: "`columns` of [[spheres]]",
    keys: &[
        ("x", "\"px\""),
        ("y", "\"py\""),
        ("z", "\"pz\""),
        ("radius", "\"grain_radius\""),
        ("diameter", "\"grain_size\""),
        ("red", "\"R\""),
        ("green", "\"G\""),
        ("blue", "\"B\""),
        ("element", "\"atom\""),
    ],
};
/// All kinds, to tell where a key that is known elsewhere belongs.
pub(super) const KINDS: [&Kind; 9] =
    [&TOP, &CAMERA, &IMAGE, &SPHERE, &PLANE, &SPHERES, &LIGHT, &SKY, &COLUMNS];
/// Those of objects.
pub(super) const OBJECTS: [&Kind; 3] = [&SPHERE, &PLANE, &SPHERES];

/// The scene without its clouds, and what the file says about them.
fn read_document(text: &str) -> Checked<(Scene, Vec<CloudTable>)> {
    let document = DeTable::parse(text).map_err(|error| syntax_fault(text, &error))?;
    let top = Table::new(&TOP, document.get_ref(), 0..0)?;
    let background = match top.get("background") {
        Some(field) => field.color()?,
        None => Color::BLACK,
    };
    let camera = top.get("camera").map(|field| read_camera(&field.table(&CAMERA)?)).transpose()?;
    let (image, samples) = match top.get("image") {
        Some(field) => read_image(&field.table(&IMAGE)?)?,
        None => (None, None),
    };
    let ambient = top.get("ambient").map(|field| read_ambient(&field)).transpose()?;
    let eye = camera.as_ref().map_or(DVec3::ZERO, |camera| camera.position);
    let lights = top.each("light", &LIGHT, |table| read_light(table, eye))?;
    let sky = top.get("sky").map(|field| read_sky(&field.table(&SKY)?)).transpose()?;
    let mut spheres = Spheres::default();
    for (index, (sphere, color, name)) in
        (0..).zip(top.each("sphere", &SPHERE, |table| read_sphere(table, eye))?)
    {
        spheres.push(sphere, color);
        if let Some(name) = name {
            spheres.set_name(index, name);
        }
    }
    let planes = top.each("plane", &PLANE, |table| read_plane(table, eye))?;
    let clouds = top.each("spheres", &SPHERES, read_cloud_table)?;
    let scene = Scene {
        background,
        camera,
        image,
        samples,
        lights,
        sky,
        ambient,
        spheres,
        planes,
        clouds: Vec::new(),
        notes: Vec::new(),
    };
    Ok((scene, clouds))
}

/// The sine between `up` and the view axis above which `right` has a direction. Its f64 value is
/// wrong by less than 2⁻⁴⁹ (two normalised vectors with 2⁻⁵¹ each, 3·2⁻⁵³ for the cross product),
/// so at 2⁻⁴⁰ `right` is good to one part in 2⁹, and much below that it is rounding noise.
const MIN_UP_SINE: f64 = 1.0 / (1u64 << 40) as f64;

fn read_camera(table: &Table) -> Checked<Camera> {
    let position = table.require("position")?.vector()?;
    let look_at_field = table.require("look_at")?;
    let look_at = look_at_field.vector()?;
    let axis = finite_difference(&look_at_field, look_at, position)?;
    if axis == DVec3::ZERO {
        return Err(Fault::new(
            look_at_field.span(),
            "`look_at` is the same point as `position`",
            "the camera looks from `position` towards `look_at`; move one of them",
        ));
    }
    let up_field = table.get("up");
    let up = match &up_field {
        Some(field) => field.nonzero_vector()?,
        None => DVec3::Y,
    };
    let up_sine = direction(axis).cross(direction(up)).length();
    if up_sine <= MIN_UP_SINE {
        let default = if up_field.is_none() { "default " } else { "" };
        let other = match direction(axis).abs().y > 0.5 {
            true => "[0.0, 0.0, 1.0]",
            false => "[0.0, 1.0, 0.0]",
        };
        return Err(Fault::new(
            up_field.as_ref().unwrap_or(&look_at_field).span(),
            format!(
                "the {default}`up` {:?} is parallel to the view from `position` to `look_at`",
                up.to_array()
            ),
            format!("choose a direction across the view, e.g. up = {other}"),
        ));
    }
    let of = |projection| Camera { position, look_at, up, projection };
    // A number near the smallest f64 has no half or tangent but 0, and a picture no extent.
    let checked = |field: &Field, projection, is_in_range, help| {
        if is_in_range && View::new(&of(projection)).h > 0.0 {
            return Ok(of(projection));
        }
        let found = format!("`{}` is {:?}", field.key, field.number()?);
        Err(Fault::new(field.span(), found, help))
    };
    match (table.get("fov"), table.get("height")) {
        (None, None) => Ok(Camera { up, ..Camera::new(position, look_at) }),
        (Some(field), None) => {
            let fov_degrees = field.number()?;
            let is_in_range = fov_degrees > 0.0 && fov_degrees < 180.0;
            let help = "the vertical field of view is in degrees, greater than 0 and less than 180";
            checked(&field, Projection::Perspective { fov_degrees }, is_in_range, help)
        }
        (None, Some(field)) => {
            let height = field.number()?;
            let help = "the height of an orthographic camera's picture is in world units, greater \
                        than 0";
            checked(&field, Projection::Orthographic { height }, height > 0.0, help)
        }
        (Some(_), Some(field)) => Err(Fault::new(
            field.span(),
            "the camera has both `fov` and `height`",
            "`fov` is for a perspective camera, `height` for an orthographic one; remove one of them",
        )),
    }
}

/// The size, of which the file gives both sides or none, and the samples.
fn read_image(table: &Table) -> Checked<(Option<ImageSize>, Option<Samples>)> {
    let side = |key| table.require(key)?.whole_number("pixels", ImageSize::MAX_SIDE);
    let size = match (table.get("width"), table.get("height")) {
        (None, None) => None,
        _ => Some(ImageSize { width: side("width")?, height: side("height")? }),
    };
    let samples = |field: Field| field.whole_number("samples", Samples::MOST).map(Samples::nearest);
    Ok((size, table.get("samples").map(samples).transpose()?))
}

/// A number for all three channels, or a colour.
fn read_ambient(field: &Field) -> Checked<Color> {
    match field.is_number() {
        true => field.not_negative().map(|light| Color([light; 3])),
        false => field.color(),
    }
}

fn read_light(table: &Table, eye: DVec3) -> Checked<Light> {
    let source = match (table.get("position"), table.get("direction")) {
        (Some(field), None) if field.is_text() => {
            field.require_word("eye", "a point of three numbers, or \"eye\" for the camera")?;
            Source::Eye
        }
        (Some(field), None) => {
            let position = field.vector()?;
            finite_difference(&field, position, eye)?;
            Source::Point(position)
        }
        (None, Some(field)) => Source::Sun(field.nonzero_vector()?),
        (None, None) => return Err(table.lacks(["position", "direction"])),
        (Some(_), Some(field)) => {
            return Err(Fault::new(
                field.span(),
                "the light has both `position` and `direction`",
                "`position` is for a light at a point, `direction` for a sun: the way its light \
                 travels; remove one of them",
            ));
        }
    };
    Ok(Light {
        source,
        color: table.get("color").map_or(Ok(Color([1.0; 3])), |field| field.color())?,
        intensity: table.get("intensity").map_or(Ok(1.0), |field| field.not_negative())?,
        shadows: table.get("shadows").map_or(Ok(true), |field| field.flag())?,
    })
}

fn read_sky(table: &Table) -> Checked<Sky> {
    let directions = |field: Field| field.whole_number("directions", Sky::MAX_DIRECTIONS);
    Ok(Sky {
        intensity: table.require("intensity")?.not_negative()?,
        directions: table.get("directions").map_or(Ok(Sky::DIRECTIONS), directions)?,
    })
}

/// A sphere, its colour and its name.
fn read_sphere(table: &Table, eye: DVec3) -> Checked<(Sphere, Color, Option<String>)> {
    let name = table.get("name").map(|field| field.text()).transpose()?;
    let center_field = table.require("center")?;
    let center = center_field.vector()?;
    finite_difference(&center_field, center, eye)?;
    let radius_field = table.require("radius")?;
    let radius = read_radius(&radius_field)?;
    if !(center.abs() + DVec3::splat(radius)).is_finite() {
        return Err(too_far(&radius_field));
    }
    Ok((Sphere { center, radius }, table.require("color")?.color()?, name))
}

fn read_radius(field: &Field) -> Checked<f64> {
    match field.number()? {
        radius if radius > 0.0 => Ok(radius),
        radius => Err(Fault::new(
            field.span(),
            format!("`radius` is {radius:?}"),
            "a radius is greater than 0",
        )),
    }
}

fn read_cloud_table(table: &Table) -> Checked<CloudTable> {
    let file = table.require("file")?;
    let radius = table.get("radius").map(|field| Given::new(field.span(), read_radius(&field)));
    let color = table.get("color").map(|field| Given::new(field.span(), field.color()));
    let mut columns = ColumnNames::default();
    if let Some(field) = table.get("columns") {
        let names = field.table(&COLUMNS)?;
        for part in Part::ALL {
            let name = names.get(part.key());
            let name = name.map(|field| Given::new(field.span(), field.column())).transpose()?;
            columns.set(part, name);
        }
    }
    let color_by = table.get("color_by").map(|field| {
        let name = field.column().and_then(|name| name.map_or_else(|| field.text(), Ok));
        Given::new(field.span(), name)
    });
    let of_color_by = ["colormap", "range", "missing_color"];
    let alone = of_color_by.into_iter().filter(|_| color_by.is_none());
    if let Some(field) = alone.filter_map(|key| table.get(key)).next() {
        return Err(Fault::new(
            field.span(),
            format!("`{}` is given without `color_by`", field.key),
            "it says how a column is coloured: name the column, e.g. `color_by = \"speed\"`",
        ));
    }
    if let (Some(field), Some(_)) = (table.get("color"), &color_by) {
        return Err(Fault::new(
            field.span(),
            "both `color` and `color_by` are given",
            "`color` is one colour for all spheres, `color_by` the column that gives each its own; \
             remove one of them",
        ));
    }
    let whole = "a whole number: 0 is the first frame";
    let frame = table.get("frame").map(|field| Given::new(field.span(), field.index(whole)));
    Ok(CloudTable {
        file: Given::new(file.span(), file.text())?,
        radius: radius.transpose()?,
        color: color.transpose()?,
        columns,
        color_by: color_by.transpose()?,
        colormap: table
            .get("colormap")
            .map_or(Ok(ColorMap::default()), |field| field.colormap())?,
        range: table.get("range").map(|field| field.range()).transpose()?,
        missing_color: table
            .get("missing_color")
            .map_or(Ok(Coloring::MISSING_COLOR), |field| field.color())?,
        frame: frame.transpose()?,
    })
}

fn read_plane(table: &Table, eye: DVec3) -> Checked<Plane> {
    let name = table.get("name").map(|field| field.text()).transpose()?.map(Into::into);
    let point_field = table.require("point")?;
    let point = point_field.vector()?;
    finite_difference(&point_field, point, eye)?;
    Ok(Plane {
        name,
        point,
        normal: table.require("normal")?.nonzero_vector()?,
        color: table.require("color")?.color()?,
    })
}

/// `point − eye`, which all later arithmetic starts from.
fn finite_difference(field: &Field, point: DVec3, eye: DVec3) -> Checked<DVec3> {
    let difference = point - eye;
    match difference.is_finite() {
        true => Ok(difference),
        false => Err(too_far(field)),
    }
}

fn too_far(field: &Field) -> Fault {
    Fault::new(
        field.span(),
        format!("`{}` reaches too far from the eye or the origin", field.key),
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
