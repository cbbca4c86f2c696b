//! f32 with a proven error bound: it proposes an object only where it is proven, and says
//! "undecided" elsewhere. f64 and exact arithmetic follow. The formulas are those of [`crate::seen`], the bounds are derived
//! in [`crate::guard`].

mod records;

use super::about::{About, Exactness, Float, Promise, Space, Wgsl, part};
use crate::num::{Float as _, OPEN};
use crate::rays::Bundle;

pub use records::{PlaneCertified, SphereCertified};

/// The facts of the kernel.
pub(super) const ABOUT: About = About {
    name: "certified",
    float: Float::F32,
    space: Space::Reference,
    promise: PROMISE,
    record_bytes: [size_of::<SphereCertified>(), size_of::<PlaneCertified>()],
    wgsl: Wgsl {
        records: "Certified",
        parts: &[part!("certified.wgsl"), part!("slabs.wgsl")],
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

fn constants(_: Bundle) -> Vec<(&'static str, String)> {
    let literal = |x: f64| Float::F32.literal(x);
    vec![
        ("UNDECIDED", format!("{OPEN}u")),
        ("BEYOND", literal(f32::BEYOND)),
        ("TINY", literal(f32::TINY)),
        ("QUOTIENT", literal(crate::seen::quotient_width::<f32>())),
    ]
}

/// A picture of more spheres than this has a hierarchy. It pays from about here on.
pub const FEW_SPHERES: usize = 16;

/// A list of rays into more spheres than this has a hierarchy. Up to here a device tests them one
/// after the other, unrolled, and its compiler takes longer with the square of their number.
pub const LISTED_SPHERES: usize = 128;
