//! The boxes of the tree as a device sees them, which looks there for what is in the way of light.

use bytemuck::{Pod, Zeroable};

use super::wide::{BESIDE, LEAST_SLACK, NARROWER, SLACK, WIDER};
use super::{IS_LEAF, Node, Tree};
use crate::guard::LARGEST_F32;

/// A box, in the order of the tree's nodes. Twin of `Box` in `shaders/lit.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct BoxOnDevice {
    /// Lower corner, relative to the tree's reference point.
    pub low: [f32; 3],
    /// Upper corner.
    pub high: [f32; 3],
    /// A leaf: [`IS_LEAF`] and the index of its sphere. Else the node that follows the subtree.
    pub link: u32,
}

/// Constants in f64 of the walk in `shaders/lit.wgsl`, by their names there.
///
/// No origin lies farther away than spheres do, and so every box is nearer than four times that, in the
/// largest component: `BEHIND_ALL` is behind them all. Where the direction's component is below `FLAT`, a
/// slab is not looked at, so that a product of a difference below `2⁶³` and an inverse stays finite.
pub const SEGMENT_CONSTANTS: [(&str, f64); 4] = [
    ("REACH", LARGEST_F32),
    ("BEHIND_ALL", 16.0 * LARGEST_F32),
    ("FLAT", 1.0 / LARGEST_F32),
    ("BESIDE", BESIDE),
];

/// The same in f32: those of [`super::wide`]. A device rounds to f32 to nearest, which is measured, and each
/// sum, difference and product to either side, by `2u` at most. So an origin is off by `3u` of the `4u` that the slack
/// has, and a slab by `7u` (difference, inverse, its widening, product) of the `8u` that it is widened by.
/// What is flushed to 0 is far below the least slack.
pub const SLAB_CONSTANTS: [(&str, f32); 4] = [
    ("SLACK", SLACK),
    ("LEAST_SLACK", LEAST_SLACK),
    ("SLAB_NARROWER", NARROWER),
    ("SLAB_WIDER", WIDER),
];

impl Tree {
    /// The boxes.
    pub(crate) fn boxes_on_device(&self) -> Vec<BoxOnDevice> {
        let of_node = |&Node { low, high, link }: &Node| BoxOnDevice {
            low,
            high,
            link: match link & IS_LEAF {
                0 => link,
                _ => IS_LEAF | self.order[(link & !IS_LEAF) as usize],
            },
        };
        self.nodes.iter().map(of_node).collect()
    }
}
