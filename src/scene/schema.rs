//! The keys of scene files, once: from these lists they are read, written, laid over a file, and described.

mod value;

use std::ops::Range;
use std::path::Path;

use glam::DVec3;

use super::table::{Checked, Field};
use super::{
    Camera, Color, ColorMap, DataFormat, Light, Plane, Projection, Samples, Scene, Sky, Source,
    Sphere,
};
use crate::error::{Result, wrong_usage};
use crate::plain::Shown;

pub use value::*;

/// A key with an example of its value, which is empty where tables stand under it, and what it says.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// As the file has it.
    pub name: &'static str,
    /// In TOML.
    pub example: &'static str,
    /// A sentence.
    pub meaning: &'static str,
}

/// A kind of table of a scene file.
#[derive(Debug)]
pub struct SectionInfo {
    /// What stands above its keys.
    pub header: &'static str,
    /// A sentence.
    pub meaning: &'static str,
    /// The keys that it may have.
    pub keys: &'static [Key],
    /// Two keys of which a table has but one, and which is for what.
    pub exclusive: &'static [(&'static str, &'static str, &'static str)],
}

/// A table of a scene file, of whose keys any may be missing.
pub trait Section: Default {
    /// What it is called, and its keys.
    const INFO: SectionInfo;

    /// Calls `write` with each key that is there and its value, in the order of the schema.
    fn each(&self, write: &mut dyn FnMut(&'static str, &dyn Value));

    /// Where the header stands, or all of an inline table, and then each value; at the beginning of the text what
    /// comes from elsewhere.
    fn spans(&mut self) -> &mut [Range<usize>];

    /// Where the value of a key stands.
    fn span(&self, key: &str) -> Range<usize>;

    #[doc(hidden)]
    fn set(&mut self, field: &Field) -> Checked<()>;
}

/// Defines a table: header, meaning, the keys that exclude each other, and each key with its type, its
/// reader, an example and its meaning.
macro_rules! section {
    (
        $(#[$doc:meta])*
        $name:ident $header:literal, $about:literal, [$($exclusive:expr),*] {
            $($key:ident: $kind:ty, $read:ident = $example:literal, $meaning:literal;)*
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct $name {
            $(#[doc = $meaning] pub $key: Option<$kind>,)*
            /// See [`Section::spans`].
            pub spans: [Range<usize>; 1 + [$(stringify!($key)),*].len()],
        }

        impl Section for $name {
            const INFO: SectionInfo = SectionInfo {
                header: $header,
                meaning: $about,
                keys: &[$(Key { name: stringify!($key), example: $example, meaning: $meaning }),*],
                exclusive: &[$($exclusive),*],
            };

            fn each(&self, write: &mut dyn FnMut(&'static str, &dyn Value)) {
                $(if let Some(value) = &self.$key {
                    write(stringify!($key), value);
                })*
            }

            fn spans(&mut self) -> &mut [Range<usize>] {
                &mut self.spans
            }

            fn span(&self, key: &str) -> Range<usize> {
                let place = $name::INFO.keys.iter().position(|known| known.name == key);
                self.spans[place.map_or(0, |place| 1 + place)].clone()
            }

            fn set(&mut self, field: &Field) -> Checked<()> {
                match field.key.name {
                    $(stringify!($key) => self.$key = Some($read(field)?),)*
                    _ => {}
                }
                Ok(())
            }
        }
    };
}

section! {
    /// All of a scene file.
    SceneKeys "the top of the file", "Before the first header.", [] {
        background: Color, color = "\"#20242c\"", "Where no object is seen; black without it.";
        ambient: Color, ambient = "0.1", "Light from nowhere, for all objects: a number or a colour.";
        camera: CameraKeys, table = "", "The eye.";
        image: ImageKeys, table = "", "The picture.";
        light: Vec<LightKeys>, tables = "", "Lamps and suns.";
        sky: SkyKeys, table = "", "Light from everywhere.";
        sphere: Vec<SphereKeys>, tables = "", "Spheres.";
        spheres: Vec<CloudKeys>, tables = "", "Files of spheres.";
        plane: Vec<PlaneKeys>, tables = "", "Planes.";
    }
}
section! {
    /// A camera.
    CameraKeys "[camera]", "The eye. Needed for pictures, not for trace.", [(
        "fov", "height", "`fov` is for a perspective camera, `height` for an orthographic one"
    )] {
        position: DVec3, point = "[0.0, 1.0, 6.0]", "The eye.";
        look_at: DVec3, point = "[0.0, 0.5, 0.0]", "A point in the middle of the picture.";
        up: DVec3, direction = "[0.0, 1.0, 0.0]", "What is up in the picture; this without it.";
        fov: f64, fov = "40.0", "The vertical field of view, degrees; 45 without it.";
        height: f64, height = "4.0", "In place of fov: parallel rays, and a picture so many units high.";
    }
}
section! {
    /// The size of a picture.
    ImageKeys "[image]", "Optional; the command line wins over it.", [] {
        width: u32, pixels = "1280", "Pixels across.";
        height: u32, pixels = "720", "Pixels down.";
        samples: Samples, samples = "4", "4 × 4 rays a pixel, at most 16 × 16; 1 without it.";
    }
}
section! {
    /// A sphere.
    SphereKeys "[[sphere]]", "As many as there are spheres.", [] {
        name: String, text = "\"red giant\"", "Optional.";
        center: DVec3, point = "[0.0, 1.0, -4.0]", "The centre.";
        radius: f64, radius = "2.0", "More than 0.";
        color: Color, color = "\"#d62728\"", "A colour.";
    }
}
section! {
    /// A plane.
    PlaneKeys "[[plane]]", "As many as there are planes.", [] {
        name: String, text = "\"floor\"", "Optional.";
        point: DVec3, point = "[0.0, 0.0, 0.0]", "Any point of the plane.";
        normal: DVec3, direction = "[0.0, 1.0, 0.0]", "Across the plane, of any length but 0.";
        color: Color, color = "\"#8c8c8c\"", "A colour.";
    }
}
section! {
    /// A file of spheres.
    CloudKeys "[[spheres]]", "Many spheres from a file.", [(
        "color_by", "color",
        "`color` is one colour for all spheres, `color_by` the column that gives each its own"
    )] {
        file: String, text = "\"cloud.npy\"", "Path from the folder of the scene: .npy, .csv, .xyz or a LAMMPS dump.";
        format: DataFormat, data_format = "\"csv\"", "Format, if the content is not recognized: npy, csv, xyz or lammps.";
        radius: f64, radius = "0.01", "Radius of all spheres, if the file has none.";
        color: Color, color = "\"#1f77b4\"", "Colour of all spheres, if the file has none.";
        color_space: ColorSpace, color_space = "\"linear\"", "Colour space of colours in the file: srgb (default) or linear.";
        columns: ColumnKeys, table = "{ radius = \"R\" }", "Names of columns, if they are not known ones.";
        header: u32, header = "3", "Line that names the columns of a table, from 1; the first one by default.";
        missing: MissingRows, missing = "\"skip\"", "Leaves out rows without a coordinate or a radius.";
        color_by: String, column = "\"speed\"", "Column that a colour map is applied to.";
        colormap: ColorMap, colormap = "\"viridis\"", "Colour map; viridis by default.";
        range: [f64; 2], range = "[0.0, 2.5]",
            "Numbers at the ends of the colour map; by default, the column's minimum and maximum.";
        missing_color: Color, color = "\"#ff00ff\"", "Colour of rows without a number in that column.";
        frame: i32, frame = "0", "Frame of a file of several, from 0; -1 is the last one.";
    }
}
section! {
    /// The columns of a file.
    ColumnKeys "`columns` of [[spheres]]", "Names of a file's columns; false: there is none.", [] {
        x: ColumnChoice, column_choice = "\"px\"", "Coordinate of the centre, or a number such as 0.0 for all.";
        y: ColumnChoice, column_choice = "\"py\"", "Coordinate of the centre, or a number such as 0.0 for all.";
        z: ColumnChoice, column_choice = "\"pz\"", "Coordinate of the centre, or a number such as 0.0 for all.";
        radius: ColumnChoice, column_choice = "\"grain_radius\"", "Radius.";
        diameter: ColumnChoice, column_choice = "\"grain_size\"", "Twice the radius.";
        red: ColumnChoice, column_choice = "\"R\"", "Component of the colour.";
        green: ColumnChoice, column_choice = "\"G\"", "Component of the colour.";
        blue: ColumnChoice, column_choice = "\"B\"", "Component of the colour.";
        color: ColumnChoice, column_choice = "\"paint\"", "Whole colours: \"#rrggbb\", CSS names, packed numbers.";
        element: ColumnChoice, column_choice = "\"atom\"", "Chemical element.";
    }
}
section! {
    /// A light.
    LightKeys "[[light]]",
    "A lamp or a sun. Without any light, sky or ambient, colours are shown as they are.", [(
        "position", "direction",
        "`position` is for a light at a point, `direction` for a sun: the way its light travels"
    )] {
        position: Source, lamp = "[4.0, 6.0, 3.0]", "A lamp there; \"eye\" is one at the camera.";
        direction: DVec3, direction = "[-1.0, -2.0, -1.0]", "Or a sun: the way that its light travels.";
        color: Color, color = "\"#ffffff\"", "White without it.";
        intensity: f64, intensity = "0.9", "Not negative; 1 without it. Nothing falls off with distance.";
        shadows: bool, flag = "true", "With false, nothing is in its way.";
    }
}
section! {
    /// A sky.
    SkyKeys "[sky]", "Soft white light from everywhere.", [] {
        intensity: f64, intensity = "0.5", "What an open plane gets.";
        directions: u32, directions = "64", "Suns that it is made of; 64 without it, at most 65536.";
    }
}

/// All tables of a scene file, in the order of the manual.
pub const SECTIONS: [&SectionInfo; 9] = [
    &SceneKeys::INFO,
    &CameraKeys::INFO,
    &ImageKeys::INFO,
    &SphereKeys::INFO,
    &PlaneKeys::INFO,
    &CloudKeys::INFO,
    &LightKeys::INFO,
    &SkyKeys::INFO,
    &ColumnKeys::INFO,
];

impl SceneKeys {
    /// What a scene is, with so many of its spheres and a file that has the others.
    pub(super) fn of(scene: &Scene, n_single: usize, cloud: Option<CloudKeys>) -> SceneKeys {
        let sphere = |(index, sphere): (usize, &Sphere)| SphereKeys {
            name: scene.spheres.name(index).map(Into::into),
            center: Some(sphere.center),
            radius: Some(sphere.radius),
            color: scene.spheres.color(index),
            ..SphereKeys::default()
        };
        SceneKeys {
            background: Some(scene.background),
            ambient: scene.ambient,
            camera: scene.camera.as_ref().map(Into::into),
            image: Some(ImageKeys::new(scene.image, scene.samples))
                .filter(|image| *image != ImageKeys::default()),
            light: Some(scene.lights.iter().map(Into::into).collect()),
            sky: scene.sky.as_ref().map(Into::into),
            sphere: Some(scene.spheres[..n_single].iter().enumerate().map(sphere).collect()),
            spheres: Some(Vec::from_iter(cloud)),
            plane: Some(scene.planes.iter().map(Into::into).collect()),
            ..SceneKeys::default()
        }
    }

    /// The text of a scene file that says this.
    pub fn document(&self) -> String {
        let (mut keys, mut parts) = (Vec::new(), Vec::new());
        self.each(&mut |key, value| match value.tables() {
            None => keys.push((key, value.toml())),
            Some(tables) => parts.extend(tables),
        });
        if !keys.is_empty() {
            parts.insert(0, lines(&keys));
        }
        parts.join("\n")
    }
}

/// The keys of a table with their values in TOML.
fn keys_of(section: &impl Section) -> Vec<(&'static str, String)> {
    let mut keys = Vec::new();
    section.each(&mut |key, value| keys.push((key, value.toml())));
    keys
}

/// The keys of a table, a line each.
fn lines(keys: &[(&'static str, String)]) -> String {
    let width = keys.iter().map(|(key, _)| key.len()).max().unwrap_or(0);
    keys.iter().map(|(key, value)| format!("{key:<width$} = {value}\n")).collect()
}

impl CloudKeys {
    /// The keys of a file at this path, as a scene can name it.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::Error::Usage) for a path that is not UTF-8.
    pub(crate) fn of_file(path: &Path) -> Result<CloudKeys> {
        let Some(file) = path.to_str().map(Into::into) else {
            let message = format!("{}: a scene can name only a file in UTF-8", path.shown());
            return wrong_usage(message);
        };
        Ok(CloudKeys { file: Some(file), ..CloudKeys::default() })
    }
}

impl ImageKeys {
    pub(super) fn new(size: Option<[u32; 2]>, samples: Option<Samples>) -> ImageKeys {
        let [width, height] = [0, 1].map(|side| size.map(|size| size[side]));
        ImageKeys { width, height, samples, ..ImageKeys::default() }
    }
}

impl From<&Camera> for CameraKeys {
    fn from(camera: &Camera) -> CameraKeys {
        let (fov, height) = match camera.projection {
            Projection::Perspective { fov_degrees } => (Some(fov_degrees), None),
            Projection::Orthographic { height } => (None, Some(height)),
        };
        CameraKeys {
            position: Some(camera.position),
            look_at: Some(camera.look_at),
            up: Some(camera.up),
            fov,
            height,
            ..CameraKeys::default()
        }
    }
}

impl From<&Light> for LightKeys {
    fn from(light: &Light) -> LightKeys {
        let (position, direction) = match light.source {
            Source::Sun(direction) => (None, Some(direction)),
            place => (Some(place), None),
        };
        LightKeys {
            position,
            direction,
            color: Some(light.color).filter(|color| *color != Color([1.0; 3])),
            intensity: Some(light.intensity),
            shadows: (!light.shadows).then_some(false),
            ..LightKeys::default()
        }
    }
}

impl From<&Sky> for SkyKeys {
    fn from(sky: &Sky) -> SkyKeys {
        let (intensity, directions) = (Some(sky.intensity), Some(sky.directions));
        SkyKeys { intensity, directions, ..SkyKeys::default() }
    }
}

impl From<&Plane> for PlaneKeys {
    fn from(plane: &Plane) -> PlaneKeys {
        PlaneKeys {
            name: plane.name.as_deref().map(Into::into),
            point: Some(plane.point),
            normal: Some(plane.normal),
            color: Some(plane.color),
            ..PlaneKeys::default()
        }
    }
}
