//! The formulas of [`super::relative`] in f64 from end to end: all that one would do without this
//! crate's design.
//!
//! More digits make wrong objects rare, but nothing says which rays they are.

mod prepare;
mod twin;

use bytemuck::{Pod, Zeroable};

pub(super) use prepare::objects;
pub use twin::narrow;

use super::about::{About, Float, Promise, Space, Wgsl, part};
use super::relative::RELATIVE;

/// The facts of the kernel.
pub(super) const ABOUT: About = About {
    name: "double",
    float: Float::F64,
    space: Space::Reference,
    promise: Promise::PARITY,
    record_bytes: [size_of::<SphereDouble>(), size_of::<PlaneDouble>()],
    wgsl: Wgsl {
        records: "Double",
        parts: &[RELATIVE, part!("double.wgsl", "src/kernel/double/twin.rs")],
        constants: |_| Vec::new(),
    },
};

/// A sphere as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereDouble {
    /// Centre relative to the reference point.
    pub center: [f64; 3],
    /// Radius.
    pub radius: f64,
    /// `l·l − r²` for the reference point.
    pub k: f64,
    /// Fills WGSL's 32-byte alignment of the struct.
    pub padding: [f64; 3],
}

/// A plane as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneDouble {
    /// Point of the plane relative to the reference point.
    pub offset: [f64; 3],
    /// `(a − o)·n` for the reference point.
    pub n_offset: f64,
    /// Normal, scaled by a power of two to a largest component in `1..2`.
    pub normal: [f64; 3],
    /// Fills WGSL's 32-byte alignment of the struct.
    pub padding: f64,
}
