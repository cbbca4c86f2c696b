//! A kernel on the CPU.

use super::arithmetic::Arithmetic;
use super::{Hit, PACKET, RayOf};
use crate::vec3::Vec3;

/// A kernel with its objects, for one bundle of rays.
pub trait Twin: Sync {
    /// Its arithmetic.
    type Float: Arithmetic;
    /// True where the kernel itself gives `t` and normals.
    const GIVES_SURFACE: bool = true;
    /// True where its ids rest on a proof.
    const IS_PROVEN: bool = false;
    /// The object of a ray.
    fn closest(&self, ray: &RayOf<Self::Float>) -> Hit<Self::Float>;
    /// The ids of a packet of pixels' rays, where the kernel has a quicker way for them.
    fn packet(&self, _: &[RayOf<Self::Float>; PACKET]) -> Option<[u32; PACKET]> {
        None
    }
    /// The normal at a hit.
    fn normal_at(&self, ray: &RayOf<Self::Float>, hit: Hit<Self::Float>) -> Vec3<Self::Float>;
}

/// Work for any kernel, compiled once for each.
pub trait WithTwin {
    /// Its result.
    type Output;
    /// Does it.
    fn with<T: Twin>(self, twin: &T) -> Self::Output;
}
