//! The light of a picture for a device that shades as a kernel without a proof does.

/// The light of a picture in the coordinates of a kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainLighting {
    /// Light from nowhere.
    pub ambient: [f64; 3],
    /// How far from a surface shadow rays start, world units.
    pub epsilon: f64,
    /// Lights and suns of the sky.
    pub lamps: Vec<PlainLamp>,
}

/// A light, or a sun of the sky.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainLamp {
    /// The place of a point, or the way to a sun.
    pub at: [f64; 3],
    /// One of [`lamp_kind`](super::lamp_kind).
    pub kind: u32,
    /// [`Lamp::weight`](crate::shade::Lamp::weight)
    pub weight: [f64; 3],
    /// Whether objects are in its way.
    pub shadows: bool,
}

impl PlainLighting {
    /// Up to so many objects, and so many lamps, a device in software lights pictures sooner than the CPU.
    pub const FEW_OBJECTS: usize = 24;
    /// See [`PlainLighting::FEW_OBJECTS`].
    pub const FEW_LAMPS: usize = 32;
}

/// What a lamp is.
pub mod lamp_kind {
    /// The point that all rays start from.
    pub const EYE: u32 = 0;
    /// A point.
    pub const POINT: u32 = 1;
    /// A sun.
    pub const SUN: u32 = 2;
}
