//! The light of a picture in numbers of f64 and of f32, for a device that shades it. Coordinates are relative to
//! [`Prepared::reference`](crate::prepare::Prepared::reference).

use bytemuck::{Pod, Zeroable};

use crate::prepare::ColorWords;

/// The numbers for the colours of a picture's pixels.
#[derive(Clone, Debug)]
pub struct LightInF64 {
    /// How they are given.
    pub words: ColorWords,
    /// What is the same for all pixels.
    pub all: LightOfAll,
    /// Lights and suns of the sky.
    pub lamps: Vec<LampInF64>,
    /// All spheres in f32, by their indices.
    pub narrow: Vec<NarrowSphere>,
    /// The ids of spheres that are looked at one after the other; others are in the scene's tree.
    pub spheres: Vec<u32>,
    /// Planes.
    pub planes: Vec<PlaneInTheWay>,
    /// Linear colours by id, the first that of samples that hit nothing.
    pub palette: Vec<ColorInF64>,
    /// The values at which bytes or numbers of 16 bits end, ascending; none for floats.
    pub edges: Vec<f64>,
    /// What f32 looks at first, for bytes.
    pub in_f32: Option<LightInF32>,
}

/// The numbers for the colours of a picture's pixels in f32, beside those spheres and boxes that f64 has too.
#[derive(Clone, Debug)]
pub struct LightInF32 {
    /// What is the same for all pixels.
    pub all: LightOfAllInF32,
    /// Lights and suns of the sky.
    pub lamps: Vec<LampInF32>,
    /// Where all spheres are seen, by their indices.
    pub seen_spheres: Vec<SeenSphere>,
    /// Where all planes are.
    pub seen_planes: Vec<SeenPlane>,
    /// Planes that may be in a lamp's way.
    pub planes: Vec<NarrowPlaneInTheWay>,
    /// Linear colours by id, the first that of samples that hit nothing.
    pub palette: Vec<ColorInF32>,
    /// The smallest numbers of f32 that are not below those at which bytes end.
    pub edges: Vec<f32>,
}

/// See [`LightInF64::all`]. Twin of `LightOfAll` in `shaders/lit.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LightOfAll {
    /// Light from nowhere.
    pub ambient: [f64; 3],
    /// Relative error of a mean of colours, above that of the light.
    pub mean_error: f64,
    /// From the reference point to that of the tree.
    pub to_tree: [f64; 3],
    /// Number of lamps.
    pub n_lamps: u32,
    /// Samples across and down a pixel.
    pub n_samples: u32,
    /// Spheres that are looked at one after the other.
    pub n_listed_spheres: u32,
    /// Planes.
    pub n_listed_planes: u32,
    /// Nodes of the tree.
    pub n_boxes: u32,
    /// 1 where samples that hit nothing are left out of the mean, else 0.
    pub leaves_out: u32,
    /// [`least_slack_of_beams`](super::slabs::least_slack_of_beams) of the tree's boxes.
    pub least_slack: f32,
    /// Fills WGSL's 32-byte alignment of the struct.
    pub padding: [u32; 3],
}

/// See [`LightInF32::all`]. Twin of `LightOfAll` in `shaders/lit.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LightOfAllInF32 {
    /// [`LightOfAll::ambient`]
    pub ambient: [f32; 3],
    /// [`LightOfAll::mean_error`] of f32, with those of colours and weights.
    pub mean_error: f32,
    /// [`LightOfAll::to_tree`]
    pub to_tree: [f32; 3],
    /// [`LightOfAll::n_lamps`]
    pub n_lamps: u32,
    /// [`LightOfAll::n_samples`]
    pub n_samples: u32,
    /// [`LightOfAll::n_listed_spheres`]
    pub n_listed_spheres: u32,
    /// [`LightOfAll::n_listed_planes`]
    pub n_listed_planes: u32,
    /// [`LightOfAll::n_boxes`]
    pub n_boxes: u32,
    /// [`LightOfAll::leaves_out`]
    pub leaves_out: u32,
    /// [`LightOfAll::least_slack`]
    pub least_slack: f32,
    /// Fills WGSL's 16-byte alignment of the struct.
    pub padding: [u32; 2],
}

/// [`LampInF64`] in f32.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LampInF32 {
    /// The place of a point, or the direction of a sun's light; beyond f32's range where it has none.
    pub at: [f32; 3],
    /// One of [`lamp_kind`](crate::prepare::lamp_kind).
    pub kind: u32,
    /// 1 where objects are in its way, else 0.
    pub shadows: u32,
    /// Fills WGSL's 16-byte alignment of a vector.
    pub padding: [u32; 3],
    /// [`Lamp::weight`](crate::shade::Lamp::weight)
    pub weight: [f32; 3],
    /// Fills it again.
    pub padding_behind: u32,
}

/// A light, or a sun of the sky. Twin of `Lamp` in `shaders/lit.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LampInF64 {
    /// The place of a point, or the direction of a sun's light with a largest component from 1 to 2.
    pub at: [f64; 3],
    /// One of [`lamp_kind`](crate::prepare::lamp_kind).
    pub kind: u32,
    /// 1 where objects are in its way, else 0.
    pub shadows: u32,
    /// [`Lamp::weight`](crate::shade::Lamp::weight)
    pub weight: [f64; 3],
    /// Fills WGSL's 32-byte alignment of a vector.
    pub padding: f64,
}

/// A sphere that may be in a lamp's way, in f32. Twin of `NarrowSphere` in `shaders/narrow.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct NarrowSphere {
    /// Its centre, high parts.
    pub center: [f32; 3],
    /// Its radius; 0 where f32 can't have it.
    pub radius: f32,
    /// Its centre, low parts.
    pub center_low: [f32; 3],
    /// Fills WGSL's 16-byte alignment of the struct.
    pub padding: u32,
}

/// A plane that may be in a lamp's way, in f32. Twin of `NarrowPlane` in `shaders/narrow.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct NarrowPlane {
    /// A point of it, high parts.
    pub point: [f32; 3],
    /// At least the length of its normal; 0 where f32 can't have it.
    pub size: f32,
    /// The point, low parts.
    pub point_low: [f32; 3],
    /// Fills WGSL's 16-byte alignment of a vector.
    pub padding: u32,
    /// Its normal, with a largest component from 1 to 2.
    pub normal: [f32; 3],
    /// Fills it again.
    pub padding_again: u32,
}

/// A plane that may be in a lamp's way. Twin of `InTheWayPlane` in `shaders/lit.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneInTheWay {
    /// A point of it.
    pub point: [f64; 3],
    /// The object's id.
    pub id: u32,
    /// Fills WGSL's 32-byte alignment of a vector.
    pub padding: u32,
    /// Its normal, with a largest component from 1 to 2.
    pub normal: [f64; 3],
    /// Fills it again.
    pub padding_again: f64,
    /// The same in f32.
    pub narrow: NarrowPlane,
    /// Fills WGSL's 32-byte alignment of the struct.
    pub padding_behind: [u32; 4],
}

/// The same for f32 alone. Twin of `InTheWayPlane` there, in f32.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct NarrowPlaneInTheWay {
    /// Its numbers.
    pub narrow: NarrowPlane,
    /// The object's id.
    pub id: u32,
    /// Fills WGSL's 16-byte alignment of the struct.
    pub padding: [u32; 3],
}

/// Where a sphere is seen, in f32; see [`crate::gpu::before::point`]. Twin of `SeenSphere` in `shaders/point.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct SeenSphere {
    /// Its centre's place in the picture, in halves of a pixel from the middle to the right and up, high parts.
    pub place: [f32; 2],
    /// The low parts.
    pub place_low: [f32; 2],
    /// The centre's depth, 1 for parallel rays; 0 where its place is not used.
    pub depth: f32,
    /// What these are off by, world units.
    pub error: f32,
    /// Of its radius.
    pub inverse_radius: f32,
    /// 1 where its near side is seen, −1 from inside, 0 where neither is known.
    pub side: f32,
}

/// Where a plane is seen, in f32; see [`crate::gpu::before::point`]. Twin of `SeenPlane` in `shaders/point.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct SeenPlane {
    /// The unit normal times the view axis, and times the picture's steps to the right and up.
    pub slope: [f32; 3],
    /// The unit normal times the way to the plane; 0 where f32 has none.
    pub offset: f32,
    /// The unit normal.
    pub unit: [f32; 3],
    /// What the offset is off by before it is rounded.
    pub error: f32,
}

/// [`ColorInF64`] in f32.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct ColorInF32 {
    /// Red, green and blue.
    pub parts: [f32; 3],
    /// Fills WGSL's 16-byte alignment of a vector.
    pub padding: f32,
}

impl From<[f64; 3]> for ColorInF32 {
    fn from(parts: [f64; 3]) -> ColorInF32 {
        ColorInF32 { parts: parts.map(|part| part as f32), padding: 0.0 }
    }
}

/// A linear colour, with the alignment of a vector in WGSL.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct ColorInF64 {
    /// Red, green and blue.
    pub parts: [f64; 3],
    /// Fills WGSL's 32-byte alignment of a vector.
    pub padding: f64,
}

impl From<[f64; 3]> for ColorInF64 {
    fn from(parts: [f64; 3]) -> ColorInF64 {
        ColorInF64 { parts, padding: 0.0 }
    }
}
