//! Twins of what a device runs for the kernel `certified`: each ray of a picture alone, and a ray of a list through the
//! boxes of the tree.

mod alone;
mod in_space;
pub mod slabs;

pub use alone::propose_alone;
pub use in_space::propose_in_space;
