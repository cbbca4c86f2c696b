//! The tree over many spheres and their numbers for rays of a list, as a device takes them in f32.

use rayon::prelude::*;

use super::Prepared;
use crate::error::Result;
use crate::kernel::certified::{Frame, SphereCertified};
use crate::memory;
use crate::rays::Bundle;
use crate::tree::flat::{BoxNode, REACH};

/// Boxes and spheres relative to [`Prepared::reference`].
pub struct InSpace {
    /// In depth-first order.
    pub nodes: Vec<BoxNode>,
    /// At each place of [`crate::tree::Tree::order`].
    pub spheres: Vec<SphereCertified>,
}

/// Bytes a sphere: two nodes and its numbers.
const BYTES: u64 = (2 * size_of::<BoxNode>() + size_of::<SphereCertified>()) as u64;

impl Prepared {
    /// What a device needs to trace a list of rays into many spheres; `None` for all else, and where
    /// spheres or rays are so far away that f32 has no slabs for them.
    ///
    /// # Errors
    /// [`crate::Error::TooLarge`] where there is no memory for it.
    pub fn in_space(&self) -> Result<Option<InSpace>> {
        let Some(hierarchy) = self.hierarchy.as_ref().filter(|_| self.bundle() == Bundle::Free)
        else {
            return Ok(None);
        };
        let tree = &hierarchy.tree;
        let n_spheres = tree.order.len();
        memory::require(
            format!("{n_spheres} spheres for rays of a list on a device"),
            n_spheres as u64 * BYTES,
            "use fewer spheres, or `--device cpu`",
        )?;
        if self.farthest_origin() > REACH {
            return Ok(None);
        }
        let Some(nodes) = tree.boxes_from(self.reference) else { return Ok(None) };
        let frame = Frame::of_list(self.reference, self.farthest_origin());
        let sphere = |&index: &u32| frame.sphere(&self.scene.spheres[index as usize]);
        Ok(Some(InSpace { nodes, spheres: tree.order.par_iter().map(sphere).collect() }))
    }
}
