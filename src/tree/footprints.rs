//! The tree as the pixels of one picture see it.
//!
//! All rays start at the eye, or in one plane, so that nearer and farther are the same for all of
//! them: the nodes stand in one order, near ones first, each with a link to what follows its subtree
//! (Smits, "Efficiency issues for ray tracing", JGT 1998). A walk needs no stack and keeps one number.

use std::borrow::Borrow;
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

/// Most nodes of a subtree that one thread fits at a time: they stay in its caches.
const PART: usize = 1 << 14;

/// Subtrees that are fitted side by side.
pub struct Parts<'a> {
    tree: &'a Tree,
    nodes: Vec<Range<usize>>,
    /// The nodes above them, ascending.
    above: Vec<usize>,
}

impl<'a> Parts<'a> {
    /// Those of a tree.
    pub fn new(tree: &'a Tree) -> Parts<'a> {
        let (nodes, above) = tree.cut(PART);
        Parts { tree, nodes, above }
    }

    /// The places of their spheres, which ascend and are all places.
    pub fn places(&self) -> impl Iterator<Item = Range<usize>> {
        self.nodes.iter().scan(0, |first, nodes| {
            let places = *first..*first + nodes.len().div_ceil(2);
            *first = places.end;
            Some(places)
        })
    }
}

impl Footprints {
    /// Fits bounds on the screen to a tree, whose sphere at each place has one of these footprints:
    /// [`Footprint::NONE`] where no pixel sees it.
    pub fn new(tree: &Tree, footprints: &[Footprint], cell_shift: u32) -> Footprints {
        let parts = Parts::new(tree);
        let given = parts.places().map(|places| &footprints[places]).collect();
        let copy = |given: &[Footprint], here: &mut [Footprint]| {
            here.copy_from_slice(given);
        };
        Footprints::of_parts(&parts, cell_shift, given, copy).0
    }

    /// Fits bounds on the screen to the parts of a tree. `see` writes the footprints of the spheres at a
    /// part's places, from what is `given` for it; with what it returns of each part.
    pub fn of_parts<D: Send, T: Send>(
        parts: &Parts,
        cell_shift: u32,
        given: Vec<D>,
        see: impl Fn(D, &mut [Footprint]) -> T + Sync,
    ) -> (Footprints, Vec<T>) {
        let tree = parts.tree;
        let mut nodes: Vec<Node> = zeroed_vec(tree.n_nodes());
        let slices = split(&mut nodes, parts.nodes.iter().cloned());
        let work = slices.into_par_iter().zip(&parts.nodes).zip(given);
        let (hulls, told): (Vec<Footprint>, Vec<T>) = work
            .map_init(<(Vec<_>, Vec<_>)>::default, |(leaves, hulls), ((nodes, part), given)| {
                leaves.resize(part.len().div_ceil(2), Footprint::NONE);
                hulls.resize(part.len(), Footprint::NONE);
                let told = see(given, leaves);
                fit(tree, part, leaves, hulls);
                order(tree, part, hulls, nodes);
                (hulls[0], told)
            })
            .unzip();
        (Footprints { nodes: put_together(parts, &hulls, nodes), cell_shift }, told)
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

/// The hulls of all that is below each node of a part, from the footprints of its leaves.
fn fit(tree: &Tree, part: &Range<usize>, leaves: &[Footprint], hulls: &mut [Footprint]) {
    let mut n_left = leaves.len();
    for at in part.clone().rev() {
        hulls[at - part.start] = match tree.place(at) {
            Some(_) => {
                n_left -= 1;
                leaves[n_left]
            }
            None => {
                let [a, b] = tree.children(at).map(|child| &hulls[child - part.start]);
                a.union(b)
            }
        };
    }
}

/// The nodes of a part in the order of the walk, as if the part were all.
fn order(tree: &Tree, part: &Range<usize>, hulls: &[Footprint], nodes: &mut [Node]) {
    let mut open = vec![part.start];
    let mut next = 0;
    while let Some(mut at) = open.pop() {
        // Down to the nearest leaf.
        loop {
            nodes[next] = node(tree, &hulls[at - part.start], at, next);
            next += 1;
            if tree.place(at).is_some() {
                break;
            }
            let children = tree.children(at);
            let [a, b] = children.map(|child| hulls[child - part.start].t);
            let is_second = usize::from(b < a);
            open.push(children[1 - is_second]);
            at = children[is_second];
        }
    }
}

/// All nodes in the order of the walk, from those of the parts, whose roots have these hulls.
fn put_together(parts: &Parts, hulls: &[Footprint], ordered: Vec<Node>) -> Vec<Node> {
    let Parts { tree, nodes: parts, above } = parts;
    if above.is_empty() {
        return ordered;
    }
    let part_at = |at: usize| parts.binary_search_by_key(&at, |part| part.start);
    let mut hulls_above = vec![Footprint::NONE; above.len()];
    let hull_in = |hulls_above: &[Footprint], at: usize| match part_at(at) {
        Ok(part) => hulls[part],
        Err(_) => above.binary_search(&at).map_or(Footprint::NONE, |above| hulls_above[above]),
    };
    for (number, &at) in above.iter().enumerate().rev() {
        let [a, b] = tree.children(at).map(|child| hull_in(&hulls_above, child));
        hulls_above[number] = a.union(&b);
    }
    let hull = |at: usize| hull_in(&hulls_above, at);
    let mut nodes: Vec<Node> = zeroed_vec(ordered.len());
    // Where each part begins in the walk.
    let (mut starts, mut next) = (Vec::with_capacity(parts.len()), 0);
    walk(tree, hull, 0, |at| {
        if let Ok(part) = part_at(at) {
            starts.push((next, part));
            next += parts[part].len();
            return false;
        }
        nodes[next] = node(tree, &hull(at), at, next);
        next += 1;
        true
    });
    let runs = starts.iter().map(|&(next, part)| next..next + parts[part].len());
    let slices = split(&mut nodes, runs);
    slices.into_par_iter().zip(&starts).for_each(|(nodes, &(start, part))| {
        for (to, from) in nodes.iter_mut().zip(&ordered[parts[part].clone()]) {
            let moved = if from.link & IS_LEAF == 0 { start as u32 } else { 0 };
            *to = Node { link: from.link + moved, ..*from };
        }
    });
    nodes
}

/// Shows `visit` the nodes of a subtree, those below the nearer child of a node first; it returns
/// whether to go on below a node.
fn walk<H: Borrow<Footprint>>(
    tree: &Tree,
    hull: impl Fn(usize) -> H,
    root: usize,
    mut visit: impl FnMut(usize) -> bool,
) {
    let mut open = vec![root];
    while let Some(at) = open.pop() {
        if visit(at) && tree.place(at).is_none() {
            let [a, b] = tree.children(at);
            let is_nearer = hull(a).borrow().t <= hull(b).borrow().t;
            open.extend(if is_nearer { [b, a] } else { [a, b] });
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
