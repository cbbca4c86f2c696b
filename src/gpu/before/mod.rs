//! Twins of what a device runs for the kernel `certified`: each ray alone, through the boxes of the tree where spheres are
//! many.

mod alone;
pub mod slabs;

pub use alone::propose_alone;
