//! Twins of what a device runs for the kernel `certified`: each ray alone, through the boxes of the tree where spheres are
//! many, and the light on what it sees where they are few. A device's proposals are compared with theirs.

mod ids;
mod light;

pub use ids::{Twin, propose_alone};
pub use light::light_alone;
