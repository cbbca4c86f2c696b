//! The tree as the pixels of one picture see it.
//!
//! All rays start at the eye, or in one plane, so that nearer and farther are the same for all of
//! them: the nodes stand in one order, near ones first, each with a link to what follows its subtree
//! (Smits, "Efficiency issues for ray tracing", JGT 1998). A walk needs no stack and keeps one number.

use std::ops::Range;

use bytemuck::{Pod, Zeroable, zeroed_vec};
use rayon::prelude::*;

pub use super::IS_LEAF;
use super::Tree;
use super::footprint::Footprint;

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

/// The nodes. Node 0 is the root.
#[derive(Clone, Debug, Default)]
pub struct Footprints {
    /// All nodes, in the order of the walk.
    pub nodes: Vec<Node>,
    /// [`super::footprint::Projection::cell_shift`]
    pub cell_shift: u32,
}

/// Nodes of a subtree that one thread fits at a time.
const PART: usize = 1 << 14;

impl Footprints {
    /// Fits bounds on the screen to a tree, whose sphere at each place has one of these footprints:
    /// [`Footprint::NONE`] where no pixel sees it.
    pub fn new(tree: &Tree, footprints: &[Footprint], cell_shift: u32) -> Footprints {
        let (parts, above) = tree.cut(PART);
        let mut hulls: Vec<Footprint> = zeroed_vec(tree.n_nodes());
        let hull = |hulls: &[Footprint], first: usize, at: usize| match tree.place(at) {
            Some(place) => footprints[place],
            None => {
                let [a, b] = tree.children(at).map(|child| &hulls[child - first]);
                a.union(b)
            }
        };
        let slices = split(&mut hulls, parts.iter().cloned());
        slices.into_par_iter().zip(&parts).for_each(|(hulls, part)| {
            for at in part.clone().rev() {
                hulls[at - part.start] = hull(hulls, part.start, at);
            }
        });
        for &at in above.iter().rev() {
            hulls[at] = hull(&hulls, 0, at);
        }
        Footprints { nodes: near_first(tree, &hulls, &parts), cell_shift }
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

/// These runs of a slice, which ascend and don't overlap.
fn split<T>(mut all: &mut [T], runs: impl Iterator<Item = Range<usize>>) -> Vec<&mut [T]> {
    let mut first = 0;
    let mut slices = Vec::new();
    for run in runs {
        let (before, after) = all.split_at_mut(run.end - first);
        slices.push(&mut before[run.start - first..]);
        (all, first) = (after, run.end);
    }
    slices
}

/// The nodes in the order of the walk.
fn near_first(tree: &Tree, hulls: &[Footprint], parts: &[Range<usize>]) -> Vec<Node> {
    let mut nodes: Vec<Node> = zeroed_vec(hulls.len());
    // Where each part begins in the walk.
    let (mut starts, mut next) = (Vec::with_capacity(parts.len()), 0);
    if !hulls.is_empty() {
        walk(tree, hulls, 0, |at| {
            if let Ok(part) = parts.binary_search_by_key(&at, |part| part.start) {
                starts.push((next, at));
                next += parts[part].len();
                return false;
            }
            nodes[next] = node(tree, &hulls[at], at, next);
            next += 1;
            true
        });
    }
    let runs = starts.iter().map(|&(next, at)| next..next + tree.after(at) - at);
    let slices = split(&mut nodes, runs);
    slices.into_par_iter().zip(&starts).for_each(|(nodes, &(start, root))| {
        let mut put = nodes.iter_mut().zip(start..);
        walk(tree, hulls, root, |at| {
            if let Some((place, next)) = put.next() {
                *place = node(tree, &hulls[at], at, next);
            }
            true
        });
    });
    nodes
}

/// Shows `visit` the nodes of a subtree, those below the nearer child of a node first; it returns
/// whether to go on below a node.
fn walk(tree: &Tree, hulls: &[Footprint], root: usize, mut visit: impl FnMut(usize) -> bool) {
    let mut open = vec![root];
    while let Some(at) = open.pop() {
        if visit(at) && tree.place(at).is_none() {
            let [a, b] = tree.children(at);
            open.extend(if hulls[a].t <= hulls[b].t { [b, a] } else { [a, b] });
        }
    }
}

/// The node of the tree that is number `next` of the walk.
fn node(tree: &Tree, hull: &Footprint, at: usize, next: usize) -> Node {
    let link = match tree.place(at) {
        Some(place) => place as u32 | IS_LEAF,
        None => (next + tree.after(at) - at) as u32,
    };
    Node::new(hull, link)
}
