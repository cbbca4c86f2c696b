//! f32 with a proven error bound: the filter proposes an object only where it is proven, and says
//! "undecided" elsewhere. f64 and exact arithmetic follow. The bounds are derived in
//! [`crate::guard`].

mod filter;
mod prepare;
mod records;
mod twin;

use super::about::{About, Exactness, Float, Promise, Space, Wgsl, part};
use crate::guard;
use crate::num::OPEN;
use crate::rays::Bundle;
use crate::vec3::Real;

#[cfg(feature = "gpu")]
pub(crate) use filter::FreeFilter;
pub(crate) use filter::{Filter, ParallelFilter, PointFilter, nearest_listed};
pub use filter::{
    GuardOf, Nearest, Nearness, Widening, closest_approach, far_nearness, far_nearness_at,
    inside_nearness, normalized, outside_nearness, parallel_nearness, parallel_nearness_at,
    plane_nearness, plane_nearness_at, sphere_nearness,
};
pub(super) use prepare::objects;
pub(crate) use prepare::{Frame, Leaf, farthest_origin};
pub use records::{PlaneCertified, SphereCertified, SphereFar};
pub(super) use twin::with_twin;

/// The facts of the kernel.
pub(super) const ABOUT: About = About {
    name: "certified",
    float: Float::F32,
    space: Space::Reference,
    promise: PROMISE,
    record_bytes: [size_of::<SphereCertified>(), size_of::<PlaneCertified>()],
    wgsl: Wgsl {
        records: "Certified",
        parts: &[
            part!("certified.wgsl", "src/kernel/certified/filter.rs"),
            part!("slabs.wgsl", "src/gpu/before/slabs.rs"),
        ],
        constants,
    },
};

const WORDS: &str = "ids exact, t the exact one rounded, each component of a normal the exact one rounded, GPU and CPU equal bit by bit";

const PROMISE: Promise = Promise {
    words: WORDS,
    words_elsewhere: WORDS,
    exact: Some(Exactness {
        // The nearest f32.
        t_ulp: 0.5,
        normal_distance: 1.7321 / (1u64 << 25) as f64,
    }),
};

fn constants(bundle: Bundle) -> Vec<(&'static str, String)> {
    let Widening { narrower, wider, far_narrower } = guard::widening_f32();
    let mut constants = vec![
        ("NARROWER", narrower),
        ("WIDER", wider),
        ("FAR_NARROWER", far_narrower),
        ("LARGEST", f32::MAX),
    ];
    if bundle == Bundle::Parallel {
        constants.push(("SMALL", f32::SMALL));
    }
    let literal = |(name, value): (_, f32)| (name, Float::F32.literal(value.into()));
    let undecided = ("UNDECIDED", format!("{OPEN}u"));
    std::iter::once(undecided).chain(constants.into_iter().map(literal)).collect()
}

/// A picture of more spheres than this has a hierarchy. It pays from about here on.
pub const FEW_SPHERES: usize = 16;

/// A list of rays into more spheres than this has a hierarchy. Up to here a device tests them one
/// after the other, unrolled, and its compiler takes longer with the square of their number.
pub const LISTED_SPHERES: usize = 128;
