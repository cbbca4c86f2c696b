//! The tree over the spheres of a scene: built once, seen from anywhere. Its boxes find what any ray
//! may hit. For the pixels of a picture [`footprints`] fits bounds on the screen to the same tree, anew
//! for each view.
//!
//! The nodes stand in depth-first order: the first child of a node follows it, the second one follows
//! the first one's subtree. So a subtree is a run of nodes, and its spheres are a run of places.

mod boxes;
mod build;
pub mod flat;
pub mod footprint;
pub mod footprints;
mod members;
mod segment;
mod walk;
mod wide;

use std::ops::Range;
use std::sync::OnceLock;

use glam::DVec3;

use crate::control::Control;
use crate::error::Result;
use crate::memory;
use crate::scene::Sphere;

pub use members::MOST_SPHERES;
pub use segment::Segment;
pub(crate) use segment::Walk;
pub(crate) use walk::Company;
pub use walk::TreeRay;
use wide::{Wide, WidePlan};

/// Set in a leaf's link, on the device too.
pub const IS_LEAF: u32 = 1 << 31;

/// A node of the tree.
#[derive(Clone, Copy, Debug, bytemuck::Zeroable)]
#[repr(C)]
struct Node {
    /// Lower corner of the box around all spheres below, relative to the tree's reference point.
    low: [f32; 3],
    /// Upper corner.
    high: [f32; 3],
    /// A leaf: [`IS_LEAF`] and the place of its sphere. Else the node that follows the subtree.
    link: u32,
}

/// The tree over those spheres of a scene that can be seen and have a box in f32, one in each leaf.
#[derive(Clone, Debug)]
pub struct Tree {
    /// What the boxes are relative to, world units.
    pub reference: DVec3,
    nodes: Vec<Node>,
    /// The index of the sphere at each place of the leaves.
    pub order: Vec<u32>,
    /// Indices of the spheres that f32 has no box for, ascending.
    pub outside: Vec<u32>,
    wide: OnceLock<Wide>,
}

impl Tree {
    /// Builds the tree over the spheres of a scene.
    ///
    /// # Errors
    /// [`Error::TooLarge`](crate::Error::TooLarge) for more than [`MOST_SPHERES`] or than there is
    /// memory to build over; [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn new(spheres: &[Sphere], control: &Control) -> Result<Tree> {
        members::check_size(spheres.len())?;
        let reference = members::reference(spheres);
        let (inside, outside) = members::members(spheres, reference);
        control.check()?;
        let (nodes, order) = build::build(spheres, reference, inside, control)?;
        Ok(Tree { reference, nodes, order, outside, wide: OnceLock::new() })
    }

    /// The largest coordinate of the boxes.
    pub(crate) fn largest_coordinate(&self) -> f64 {
        let sides = self.nodes.first().map_or([[0.0; 3]; 2], |root| [root.low, root.high]);
        sides.as_flattened().iter().fold(0.0, |largest: f64, side| largest.max(side.abs().into()))
    }

    /// Number of nodes. Node 0 is the root.
    pub fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Bytes of the nodes, of the order, and of the nodes for rays from anywhere where these are made.
    pub fn bytes(&self) -> u64 {
        let wide = self.wide.get().map_or(0, Wide::bytes);
        (size_of_val(&self.nodes[..]) + size_of_val(&self.order[..])) as u64 + wide
    }

    /// The nodes for rays from anywhere, made when they are first needed.
    #[inline]
    fn wide(&self) -> &Wide {
        // Made before anybody waits for them: a thread of the pool that makes them may come here again meanwhile.
        self.wide.get().unwrap_or_else(|| {
            let made = WidePlan::new(self).make();
            self.wide.get_or_init(|| made)
        })
    }

    /// Bytes of what [`Tree::prepare_visits`] makes.
    pub fn visit_bytes(&self) -> u64 {
        self.wide.get().map_or_else(|| WidePlan::new(self).bytes(), Wide::bytes)
    }

    /// Makes what [`Tree::visit`] needs, which takes longer than a ray.
    ///
    /// # Errors
    /// [`Error::TooLarge`](crate::Error::TooLarge) where there is no memory for it,
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn prepare_visits(&self, control: &Control) -> Result<()> {
        control.check()?;
        if self.wide.get().is_none() {
            let plan = WidePlan::new(self);
            let what = format!("boxes of {} spheres for any rays", self.order.len());
            memory::require(what, plan.bytes(), "free some, or split the scene")?;
            let made = plan.make();
            self.wide.get_or_init(|| made);
        }
        control.check()
    }

    /// The place of a leaf's sphere.
    #[inline(always)]
    pub fn place(&self, at: usize) -> Option<usize> {
        let link = self.nodes[at].link;
        (link & IS_LEAF != 0).then_some((link & !IS_LEAF) as usize)
    }

    /// The node that follows the subtree below node `at`.
    #[inline(always)]
    pub fn after(&self, at: usize) -> usize {
        match self.nodes[at].link {
            link if link & IS_LEAF == 0 => link as usize,
            _ => at + 1,
        }
    }

    /// The children of an inner node.
    #[inline(always)]
    pub fn children(&self, at: usize) -> [usize; 2] {
        [at + 1, self.after(at + 1)]
    }

    /// The least `along·(p − from)` of the points `p` in a node's box, roughly.
    fn nearest(&self, at: usize, from: DVec3, along: DVec3) -> f64 {
        let (Node { low, high, .. }, shift) = (&self.nodes[at], self.reference - from);
        let corner = |k: usize| if along[k] < 0.0 { high[k] } else { low[k] };
        (0..3).map(|k| along[k] * (f64::from(corner(k)) + shift[k])).sum()
    }

    /// Subtrees of at most `most` nodes that have all leaves, and the nodes above them; both ascending.
    pub fn cut(&self, most: usize) -> (Vec<Range<usize>>, Vec<usize>) {
        let (mut parts, mut above) = (Vec::new(), Vec::new());
        let mut at = 0;
        while at < self.nodes.len() {
            let after = self.after(at);
            if after - at <= most {
                parts.push(at..after);
                at = after;
            } else {
                above.push(at);
                at += 1;
            }
        }
        (parts, above)
    }
}
