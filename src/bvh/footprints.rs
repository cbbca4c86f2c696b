//! A hierarchy over the footprints of spheres, for the pixels of one picture.
//!
//! All rays start at the eye, or in one plane, so that nearer and farther are the same for all of
//! them: the nodes
//! stand in one fixed order, near ones first, each with a link to what follows its subtree (Smits,
//! "Efficiency issues for ray tracing", JGT 1998). A walk needs no stack and keeps one number.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use rayon::prelude::*;

use super::footprint::{Footprint, Projection};
use super::{build, spread};
use crate::control::Control;
use crate::error::Result;

/// A node of 16 bytes, as the device sees it. [`Node::covers`] and the walk have their twins in
/// `shaders/hierarchy.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Node {
    /// First column, and first row `· 2¹⁶`.
    low: u32,
    /// Last column, and last row `· 2¹⁶`, with [`BORROW`].
    high: u32,
    /// No sphere below is seen nearer.
    t: f32,
    /// A leaf: [`IS_LEAF`] and the place of its sphere. Else the node that follows the subtree.
    link: u32,
}

/// Set in a leaf's link.
pub const IS_LEAF: u32 = 1 << 31;

/// Above the 15 bits of a column and of a row: taken by a difference that is negative.
pub const BORROW: u32 = 1 << 31 | 1 << 15;

/// A rectangle of cells, packed as in [`Node`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Cells {
    first: u32,
    last: u32,
}

#[inline(always)]
fn pack(column: u32, row: u32) -> u32 {
    column | row << 16
}

impl Node {
    fn new(footprint: &Footprint, link: u32) -> Node {
        let Footprint { columns, rows, t } = footprint;
        let corner = |end: usize| pack(columns[end].into(), rows[end].into());
        Node { low: corner(0), high: corner(1) | BORROW, t: *t, link }
    }

    /// What is seen of all spheres below.
    pub fn footprint(&self) -> Footprint {
        let [low, high] = [self.low, self.high & !BORROW];
        Footprint {
            columns: [low as u16, high as u16],
            rows: [(low >> 16) as u16, (high >> 16) as u16],
            t: self.t,
        }
    }

    /// Whether it shares a cell with these: no difference of columns or rows is negative.
    #[inline(always)]
    pub fn covers(&self, cells: Cells) -> bool {
        let past_low = (cells.last | BORROW).wrapping_sub(self.low);
        let before_high = self.high.wrapping_sub(cells.first);
        past_low & before_high & BORROW == BORROW
    }

    /// No sphere below is seen nearer than this.
    #[inline(always)]
    pub fn t(&self) -> f32 {
        self.t
    }

    /// The place of a leaf's sphere.
    #[inline(always)]
    pub fn place(&self) -> Option<u32> {
        (self.link & IS_LEAF != 0).then_some(self.link & !IS_LEAF)
    }

    /// The node that follows what is below node `at`, which this is.
    #[inline(always)]
    fn after(&self, at: usize) -> usize {
        if self.link & IS_LEAF == 0 { self.link as usize } else { at + 1 }
    }
}

/// The hierarchy. Node 0 is the root.
#[derive(Clone, Debug, Default)]
pub struct Footprints {
    /// All nodes, in the order of the walk.
    pub nodes: Vec<Node>,
    /// Which sphere is at each place of the leaves: its index among those that the hierarchy was
    /// built over.
    pub order: Vec<u32>,
    /// [`Projection::cell_shift`]
    pub cell_shift: u32,
}

impl Footprints {
    /// Builds the hierarchy over at most [`super::MOST_SPHERES`] footprints of a projection.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted)
    pub fn new(
        projection: &Projection,
        footprints: &[Footprint],
        control: &Control,
    ) -> Result<Footprints> {
        let cell_shift = projection.cell_shift();
        if footprints.is_empty() {
            return Ok(Footprints { cell_shift, ..Footprints::default() });
        }
        let boxes: Vec<Aabb> = footprints
            .par_iter()
            .enumerate()
            .map(|(index, footprint)| footprint_box(projection, footprint, index))
            .collect();
        let binary = build(&boxes, control)?;
        drop(boxes);
        let mut part = flatten_in_parallel(&binary, footprints);
        let mut place = 0;
        for (at, node) in part.nodes.iter_mut().enumerate() {
            if node.link == IS_LEAF {
                node.link |= place;
                place += 1;
            } else {
                node.link += at as u32;
            }
        }
        Ok(Footprints { nodes: part.nodes, order: part.order, cell_shift })
    }

    /// The cells of the pixels from the `first` to the `last` column and row of the picture.
    #[inline(always)]
    pub fn cells(&self, first: [u32; 2], last: [u32; 2]) -> Cells {
        let [first, last] = [first, last].map(|pixel| pixel.map(|side| side >> self.cell_shift));
        Cells { first: pack(first[0], first[1]), last: pack(last[0], last[1]) }
    }

    /// Shows `visit` the leaves, and the places of their spheres, that may be seen in one of the
    /// cells at `t ≤ t_max`, nearer nodes first. `visit` returns the `t_max` from then on.
    #[inline(always)]
    pub fn visit(&self, cells: Cells, mut t_max: f32, mut visit: impl FnMut(&Node, usize) -> f32) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !node.covers(cells) || node.t > t_max {
                at = node.after(at);
                continue;
            }
            if let Some(place) = node.place() {
                t_max = visit(node, place as usize);
            }
            at += 1;
        }
    }
}

fn footprint_box(projection: &Projection, footprint: &Footprint, index: usize) -> Aabb {
    let Footprint { columns, rows, t } = footprint;
    let depth = projection.depth_in_cells(*t);
    // Any finite box will do: it says only what is grouped.
    let depth = depth.clamp(-1e9, 1e9);
    // A cell, or what f32 can tell apart.
    let room = f64::max(1.0, depth.abs() / f64::from(1 << 16));
    let depth = (depth + room * spread(index)[0]) as f32;
    let corner = |end: usize, half: f32| {
        Vec3A::new(f32::from(columns[end]) + half, f32::from(rows[end]) + half, depth)
    };
    Aabb::new(corner(0, -0.5), corner(1, 0.5))
}

/// A subtree in the order of the walk, not yet linked: an inner node's link is the number of nodes of
/// its subtree, a leaf's is [`IS_LEAF`] alone.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Part {
    /// Puts the node `at` around all that follow it.
    fn close(&mut self, at: usize) {
        let mut hull = self.nodes[at + 1].footprint();
        let mut child = at + 1;
        while child < self.nodes.len() {
            let node = &self.nodes[child];
            hull = hull.union(&node.footprint());
            child += if node.link == IS_LEAF { 1 } else { node.link as usize };
        }
        self.nodes[at] = Node::new(&hull, (self.nodes.len() - at) as u32);
    }
}

/// A leaf, or the children of an inner node.
fn halves(binary: &Bvh2, index: usize) -> Vec<usize> {
    match binary.nodes[index].is_leaf() {
        true => vec![index],
        false => children(binary, index).to_vec(),
    }
}

/// The children of an inner node, the nearer one first.
fn children(binary: &Bvh2, index: usize) -> [usize; 2] {
    let first = binary.nodes[index].first_index as usize;
    let depth = |index: usize| binary.nodes[index].aabb().min.z;
    if depth(first) <= depth(first + 1) { [first, first + 1] } else { [first + 1, first] }
}

/// Subtrees that are flattened side by side.
const PARTS: usize = 64;

fn flatten_in_parallel(binary: &Bvh2, footprints: &[Footprint]) -> Part {
    let mut roots = vec![0];
    while roots.len() < PARTS && roots.iter().any(|&root| !binary.nodes[root].is_leaf()) {
        roots = roots.into_iter().flat_map(|root| halves(binary, root)).collect();
    }
    let flat = |&root: &usize| (root, flatten(binary, footprints, root, HashMap::new()));
    let parts = roots.par_iter().map(flat).collect();
    flatten(binary, footprints, 0, parts)
}

/// The subtree below a node, with the `parts` of it that are flat already.
fn flatten(
    binary: &Bvh2,
    footprints: &[Footprint],
    root: usize,
    mut parts: HashMap<usize, Part>,
) -> Part {
    enum Step {
        Enter(usize),
        Close(usize),
    }
    let mut flat = Part::default();
    flat.nodes.reserve(parts.values().map(|part| part.nodes.len()).sum());
    flat.order.reserve(parts.values().map(|part| part.order.len()).sum());
    let mut open = vec![Step::Enter(root)];
    while let Some(step) = open.pop() {
        match step {
            Step::Close(at) => flat.close(at),
            Step::Enter(index) => {
                let node = &binary.nodes[index];
                if let Some(part) = parts.remove(&index) {
                    flat.nodes.extend(part.nodes);
                    flat.order.extend(part.order);
                } else if node.is_leaf() {
                    let first = node.first_index as usize;
                    for place in first..first + node.prim_count as usize {
                        let sphere = binary.primitive_indices[place];
                        flat.nodes.push(Node::new(&footprints[sphere as usize], IS_LEAF));
                        flat.order.push(sphere);
                    }
                } else {
                    let [near, far] = children(binary, index);
                    let at = flat.nodes.len();
                    flat.nodes.push(Node::zeroed());
                    open.extend([Step::Close(at), Step::Enter(far), Step::Enter(near)]);
                }
            }
        }
    }
    flat
}
