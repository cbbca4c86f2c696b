//! f32 with a proven error bound: it proposes an object only where it is proven, and says
//! "undecided" elsewhere. f64 and exact arithmetic follow. The formulas are those of [`crate::shape`], the bounds are derived
//! in [`crate::bounds`].

use super::info::{Exactness, FloatType, KernelInfo, Promise, Space, part};

/// A sphere as the device sees it: the words of a [`SphereRecord`](crate::shape::SphereRecord).
pub type SphereWords = [f32; 20];

/// A plane as the device sees it: the words of a [`PlaneRecord`](crate::shape::PlaneRecord).
pub type PlaneWords = [f32; 12];

/// The facts of the kernel.
pub(super) const INFO: KernelInfo = KernelInfo {
    name: "certified",
    float: FloatType::F32,
    space: Space::Reference,
    promise: PROMISE,
    record_bytes: [size_of::<SphereWords>(), size_of::<PlaneWords>()],
    record_names: "Record",
    shader_parts: &[part!("printed/shape.wgsl"), part!("certified.wgsl")],
};

const WORDS: &str =
    "ids exact, t the exact one rounded, each component of a normal the exact one rounded";

const PROMISE: Promise = Promise {
    words: WORDS,
    words_elsewhere: WORDS,
    exact: Some(Exactness {
        // The nearest f32.
        t_ulp: 0.5,
        normal_distance: 1.7321 / (1u64 << 25) as f64,
    }),
};

/// A picture of more spheres than this has a hierarchy. It pays from about here on.
pub const FEW_SPHERES: usize = 16;

/// A list of rays into more spheres than this has a hierarchy. Up to here a device tests them one
/// after the other.
pub const LISTED_SPHERES: usize = 128;
