//! The lecture's formulas, corrected, on world coordinates.
//!
//! This is what everyone copies, kept for teaching and measuring: `b² − 4ac` cancels near the
//! silhouette, `−b ± √D` near the surface, and world coordinates lose what lies far from the
//! origin.

mod prepare;
mod twin;

use bytemuck::{Pod, Zeroable};

pub(super) use prepare::objects;
pub(super) use twin::with_twin;
pub use twin::{
    Quadratic, closer_plane, closer_sphere, closest, normal_at, plane_lecture, quadratic,
    quadratic_roots, sphere_lecture,
};

use super::about::{About, Float, Promise, Space, Wgsl, part};

/// The facts of the kernel.
pub(super) const ABOUT: About = About {
    name: "lecture",
    float: Float::F32,
    space: Space::World,
    promise: Promise::PARITY,
    record_bytes: [size_of::<SphereLecture>(), size_of::<PlaneLecture>()],
    wgsl: Wgsl {
        records: "Lecture",
        parts: &[part!("lecture.wgsl", "src/kernel/lecture/twin.rs")],
        constants: |_| Vec::new(),
    },
};

/// A sphere as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SphereLecture {
    /// Centre, world units.
    pub center: [f32; 3],
    /// Radius, world units.
    pub radius: f32,
}

/// A plane as the device sees it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneLecture {
    /// A point of the plane, world units.
    pub point: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad0: f32,
    /// Normal of any length.
    pub normal: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad1: f32,
}
