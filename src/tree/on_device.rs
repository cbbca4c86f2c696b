//! The boxes of the tree as a device sees them, which looks there for what is in the way of light.

use bytemuck::{Pod, Zeroable};

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

/// Constants in f64 of the walk in `shaders/lit.wgsl`, by their names there: no origin lies farther away than
/// spheres do, and the third digit of `BESIDE` is for the roundings of the slack.
pub const SEGMENT_CONSTANTS: [(&str, f64); 2] = [("REACH", LARGEST_F32), ("BESIDE", 1.001)];

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
