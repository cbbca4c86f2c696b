//! The intersection kernels, a folder each: `mod.rs` has the facts and the records of its objects,
//! `prepare.rs` makes these of a scene, `twin.rs` has the arithmetic, name by name that of a file in
//! `shaders/`. The registry lists them all.

mod about;
pub(crate) mod arithmetic;
pub mod certified;
pub mod coordinates;
pub mod double;
pub mod lecture;
mod registry;
pub mod relative;
pub mod stable;
pub(crate) mod twin;

use crate::scene::{Plane, Scene, Sphere};
use crate::vec3::{Real, Vec3, dot3};

pub(crate) use about::part;
pub use about::{About, Exactness, Float, Part, Promise, Space, Wgsl};
pub use registry::{Kernel, Objects, SHARED_PARTS};

/// A ray as a kernel sees it. Twin of `Ray` in `shaders/ray.wgsl`.
#[derive(Clone, Copy, Debug)]
pub struct RayOf<R> {
    /// Origin: world units for `lecture`, relative to the reference point otherwise.
    pub origin: Vec3<R>,
    /// The rest that the origin's rounding left.
    pub origin_low: Vec3<R>,
    /// Direction of any length.
    pub direction: Vec3<R>,
    /// `d·d`
    pub a: R,
    /// `1 / (d·d)`
    pub inv_a: R,
}

impl<R: Real> RayOf<R> {
    /// A ray with its derived numbers.
    #[inline(always)]
    pub fn new(origin: Vec3<R>, origin_low: Vec3<R>, direction: Vec3<R>) -> RayOf<R> {
        let a = dot3(direction, direction);
        RayOf { origin, origin_low, direction, a, inv_a: R::ONE / a }
    }
}

/// The closest hit so far. Twin of `Hit` in `shaders/ray.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<R> {
    /// Ray parameter, +∞ for none.
    pub t: R,
    /// Object id, 0 for none.
    pub id: u32,
}

impl<R: Real> Hit<R> {
    /// Nothing was hit.
    pub const MISS: Self = Hit { t: R::INFINITY, id: 0 };
}

impl<R: Real> Hit<R> {
    /// The nearer of the hit so far and a candidate, whose `t` is 0 where there is none. Equal
    /// `t`: the lower id, which comes first, stays.
    #[inline(always)]
    pub fn closer(self, t: R, id: u32) -> Self {
        if t > R::ZERO && t < self.t { Hit { t, id } } else { self }
    }
}

/// Spheres and planes, each in id order.
#[derive(Clone, Debug)]
pub struct Lists<S, P> {
    /// Spheres.
    pub spheres: Vec<S>,
    /// Planes.
    pub planes: Vec<P>,
}

impl<S: bytemuck::NoUninit, P: bytemuck::NoUninit> Lists<S, P> {
    fn new(
        scene: &Scene,
        sphere: impl Fn(&Sphere) -> S,
        plane: impl Fn(&Plane) -> P,
    ) -> Lists<S, P> {
        Lists {
            spheres: scene.spheres.iter().map(sphere).collect(),
            planes: scene.planes.iter().map(plane).collect(),
        }
    }

    /// The bytes of the spheres and those of the planes.
    pub fn bytes(&self) -> (&[u8], &[u8]) {
        (bytemuck::cast_slice(&self.spheres), bytemuck::cast_slice(&self.planes))
    }
}
