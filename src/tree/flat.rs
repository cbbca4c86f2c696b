//! The boxes of the tree one after the other, for walks without a stack: rays of a list on a device.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;

use super::{IS_LEAF, Tree};
use crate::guard::{round_down, round_up};

/// A box, and what is in it; two texels.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct BoxNode {
    /// Lower corner.
    pub low: [f32; 3],
    /// A leaf: [`IS_LEAF`] and the place of its sphere. Else the node that follows the subtree.
    pub link: u32,
    /// Upper corner.
    pub high: [f32; 3],
    /// The id of a leaf's sphere.
    pub id: u32,
}

/// Largest coordinate of a box, and distance of an origin, with which `gpu::before::slabs` stay in f32's
/// range. No test sees it halved: the range may be smaller.
pub const REACH: f64 = (1u64 << 40) as f64;

impl Tree {
    /// The nodes in depth-first order, relative to a point; `None` where they reach too far from there.
    /// Each step is rounded outward.
    pub fn boxes_from(&self, reference: DVec3) -> Option<Vec<BoxNode>> {
        let shift = (self.reference - reference).to_array();
        let low = |k: usize, x: f32| (f64::from(x) + shift[k].next_down()).next_down();
        let high = |k: usize, x: f32| (f64::from(x) + shift[k].next_up()).next_up();
        if let Some(root) = self.nodes.first() {
            let is_near = |k| low(k, root.low[k]) >= -REACH && high(k, root.high[k]) <= REACH;
            if !(0..3).all(is_near) {
                return None;
            }
        }
        let nodes = self.nodes.par_iter().map(|node| BoxNode {
            low: std::array::from_fn(|k| round_down(low(k, node.low[k]))),
            link: node.link,
            high: std::array::from_fn(|k| round_up(high(k, node.high[k]))),
            id: match node.link & IS_LEAF {
                0 => 0,
                _ => self.order[(node.link & !IS_LEAF) as usize] + 1,
            },
        });
        Some(nodes.collect())
    }
}
