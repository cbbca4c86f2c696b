//! The hierarchies over many spheres. [`footprints`] finds what the pixels of one picture may see,
//! [`boxes`] what any ray may hit. Both are built by the same library, bottom-up by locality (PLOC,
//! Meister & Bittner 2018) with reinsertion of some nodes.

pub mod boxes;
pub mod footprint;
pub mod footprints;

use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

/// Most spheres of a hierarchy: the places of leaves and the numbers of nodes have 31 bits.
pub const MOST_SPHERES: usize = 1 << 29;

/// The binary tree over these boxes, which are finite, with one in each leaf. Node 0 is the root.
fn build(boxes: &[Aabb]) -> Bvh2 {
    let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::very_fast_build() };
    let mut build_time = Duration::ZERO;
    build_bvh2(boxes, params, &mut build_time)
}
