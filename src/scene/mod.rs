//! Scenes as the user wrote them, in f64, checked. A [`Scene`] knows nothing of devices or kernels.

mod clouds;
mod color;
mod colormap;
mod compose;
mod decode;
mod document;
mod edges;
mod framing;
mod legend;
mod light;
mod neighbours;
mod open;
mod overrides;
mod places;
mod raw;
mod read;
mod samples;
mod save;
pub mod schema;
mod shipped;
mod sniff;
mod spheres;
mod table;

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::{Message, Result, SceneError};

pub use color::{Color, hex, linear_from_srgb, linear_of_bytes, srgb_from_linear};
pub use colormap::ColorMap;
pub use compose::{Composed, compose_scene, place_camera, recompose_scene};
pub(crate) use document::seen_from;
pub(crate) use edges::Linear;
pub use edges::QuantizationTable;
pub use framing::Framing;
pub(crate) use framing::turned;
pub use legend::Coloring;
pub use light::{Light, Sky, Source};
pub(crate) use open::open_input;
pub use overrides::{InputFormat, SceneOverrides, Viewpoint};
pub use read::{parse_scene, read_scene, read_scene_text};
pub use samples::Samples;
pub(crate) use save::write_rows;
pub use shipped::SHIPPED_SCENES;
pub use sniff::DataFormat;
pub use spheres::{Sphere, Spheres};

/// The most objects that a scene may have: ids are `u32`, 0 is the background, and one more is
/// left free.
pub const MAX_OBJECTS: usize = u32::MAX as usize - 2;

/// How a camera maps the scene to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays start at the eye.
    Perspective {
        /// Vertical field of view, degrees, strictly between 0 and 180.
        fov_degrees: f64,
    },
    /// All rays run along the view axis; they start in the plane across it through `position`.
    Orthographic {
        /// Height of the picture, world units, positive.
        height: f64,
    },
}

/// A camera as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Eye point, or the middle of the picture's plane; world units.
    pub position: DVec3,
    /// A point on the view axis, different from `position`.
    pub look_at: DVec3,
    /// The direction that appears upward; not parallel to the view axis.
    pub up: DVec3,
    /// Field of view, or height of the picture.
    pub projection: Projection,
}

impl Camera {
    /// A camera with the defaults of scene files: y is up, and the field of view has 45°.
    pub fn new(position: DVec3, look_at: DVec3) -> Camera {
        let projection = Projection::Perspective { fov_degrees: 45.0 };
        Camera { position, look_at, up: DVec3::Y, projection }
    }

    /// The camera as a scene file has it, with all digits: read again, it is the same one.
    pub fn to_toml(&self) -> String {
        let camera = Some(self.into());
        schema::SceneKeys { camera, ..Default::default() }.document()
    }
}

/// The largest width and height of a picture, pixels: what picture viewers and GPU textures commonly take, and small enough
/// that products of two pixel coordinates fit in 32 bits.
pub const MAX_SIDE: u32 = 32768;

/// The set of points `p` with `(p − point)·normal = 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Name given in the scene file.
    pub name: Option<Box<str>>,
    /// Any point of the plane, world units.
    pub point: DVec3,
    /// Normal of any length but zero.
    pub normal: DVec3,
    /// Surface colour.
    pub color: Color,
}

/// A file of spheres that a scene names, and which spheres it gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// The file.
    pub path: PathBuf,
    /// Number of spheres.
    pub n_spheres: usize,
    /// Id of the first sphere; the others follow in the order of the file.
    pub first_id: u32,
    /// Colour map and column that gave the spheres their colours, if one did.
    pub coloring: Option<Coloring>,
    /// Names of the columns that were not used, in the order of the file.
    pub unused_columns: Vec<String>,
}

/// A checked scene. Object ids count from 1: single spheres in file order, then cloud spheres, then
/// planes; 0 is background.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Colour of pixels that see no object.
    pub background: Color,
    /// The camera, where the file has one; lists of rays need none.
    pub camera: Option<Camera>,
    /// The columns and rows of the picture that the file asks for.
    pub image: Option<[u32; 2]>,
    /// The samples across and down a pixel that the file asks for.
    pub samples: Option<Samples>,
    /// Lights, in file order.
    pub lights: Vec<Light>,
    /// Light from everywhere.
    pub sky: Option<Sky>,
    /// Light that every surface gets, wherever it lies.
    pub ambient: Option<Color>,
    /// Single spheres in file order, then the spheres of each cloud.
    pub spheres: Spheres,
    /// Planes, in file order.
    pub planes: Vec<Plane>,
    /// The files that the clouds came from, in file order.
    pub clouds: Vec<Cloud>,
    /// Notes of the reader that a user may want to know, each about a file.
    pub notes: Vec<Message>,
}

impl Scene {
    /// Number of objects, which is also the highest id.
    pub fn n_objects(&self) -> usize {
        self.spheres.len() + self.planes.len()
    }

    /// Bytes of memory that the objects take, without names.
    pub fn bytes(&self) -> u64 {
        self.spheres.bytes() + size_of_val(&self.planes[..]) as u64
    }

    /// The camera, or the error that a command that draws a picture gives without one. `path` is
    /// for the message.
    pub fn require_camera(&self, path: &Path) -> Result<&Camera> {
        self.camera.as_ref().ok_or_else(|| {
            SceneError::whole_file(
                path,
                "the scene has no [camera], and no spheres that a camera could frame",
                "add a camera, for example:\n\n[camera]\nposition = [0.0, 1.0, 6.0]\n\
                 look_at  = [0.0, 0.5, 0.0]\nfov      = 40.0",
            )
            .into()
        })
    }

    /// True where something lights the objects; else they have their colours as they are.
    pub fn is_lit(&self) -> bool {
        !self.lights.is_empty() || self.sky.is_some() || self.ambient.is_some()
    }

    /// The object that an id names, or `None` for the background and ids out of range.
    pub fn object(&self, id: u32) -> Option<Object<'_>> {
        let index = (id as usize).checked_sub(1)?;
        match self.spheres.get(index) {
            Some(sphere) => Some(Object::Sphere(sphere)),
            None => self.planes.get(index - self.spheres.len()).map(Object::Plane),
        }
    }

    /// The colour of what an id names: the background's for 0 and for ids out of range.
    pub fn color(&self, id: u32) -> Color {
        let Some(index) = (id as usize).checked_sub(1) else { return self.background };
        let of_plane = || Some(self.planes.get(index.checked_sub(self.spheres.len())?)?.color);
        self.spheres.color(index).or_else(of_plane).unwrap_or(self.background)
    }

    /// Name given in the scene file to the object with this id.
    pub fn name(&self, id: u32) -> Option<&str> {
        match self.object(id)? {
            Object::Sphere(_) => self.spheres.name(id as usize - 1),
            Object::Plane(plane) => plane.name.as_deref(),
        }
    }

    /// The objects with their ids, in the order of the ids.
    pub fn objects(&self) -> impl Iterator<Item = (u32, Object<'_>)> {
        let spheres = self.spheres.iter().map(Object::Sphere);
        (1..).zip(spheres.chain(self.planes.iter().map(Object::Plane)))
    }

    /// Linear colours by id: the first is the background's.
    pub fn colors(&self) -> impl Iterator<Item = Color> {
        (0..=self.n_objects() as u32).map(|id| self.color(id))
    }
}

/// One object of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Object<'a> {
    /// A sphere.
    Sphere(&'a Sphere),
    /// A plane.
    Plane(&'a Plane),
}

impl Object<'_> {
    /// The word for its shape, in English.
    pub fn shape(self) -> &'static str {
        match self {
            Object::Sphere(_) => "sphere",
            Object::Plane(_) => "plane",
        }
    }

    /// A point and how far from it the object goes; of one without an end any of its points.
    pub fn extent(self) -> (DVec3, f64) {
        match self {
            Object::Sphere(sphere) => (sphere.center, sphere.radius.abs()),
            Object::Plane(plane) => (plane.point, 0.0),
        }
    }
}
