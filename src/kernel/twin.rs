//! A kernel on the CPU.

use super::arithmetic::Arithmetic;
use super::{Hit, RayOf};
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
    /// The same of a ray that starts anywhere, as shadow rays do.
    fn closest_from_anywhere(&self, ray: &RayOf<Self::Float>) -> Hit<Self::Float>;
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
