//! The best plain-f32 kernel: the formulas of [`super::relative`] in f32.
//!
//! Offsets from the ray's origin are formed in f64 on the host, or from high and low parts for
//! lists of rays. Still plain f32: nothing is promised near a silhouette.

mod prepare;
mod twin;

use bytemuck::{Pod, Zeroable};

pub(super) use prepare::objects;

use super::about::{About, Float, Promise, Space, Wgsl, part};
use super::relative::RELATIVE;

/// The facts of the kernel.
pub(super) const ABOUT: About = About {
    name: "stable",
    float: Float::F32,
    space: Space::Reference,
    promise: Promise::PARITY,
    record_bytes: [size_of::<SphereStable>(), size_of::<PlaneStable>()],
    wgsl: Wgsl {
        records: "Stable",
        parts: &[RELATIVE, part!("stable.wgsl", "src/kernel/stable/twin.rs")],
        constants: |_| Vec::new(),
    },
};

/// A sphere as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereStable {
    /// Centre relative to the reference point, high part.
    pub center: [f32; 3],
    /// Radius.
    pub radius: f32,
    /// Centre relative to the reference point, low part.
    pub center_low: [f32; 3],
    /// `l·l − r²` for the reference point, rounded from f64.
    pub k: f32,
}

/// A plane as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneStable {
    /// Point of the plane relative to the reference point, high part.
    pub offset: [f32; 3],
    /// `(a − o)·n` for the reference point, rounded from f64.
    pub n_offset: f32,
    /// Point of the plane relative to the reference point, low part.
    pub offset_low: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad0: f32,
    /// Normal, scaled by a power of two to a largest component in `1..2`.
    pub normal: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad1: f32,
}
