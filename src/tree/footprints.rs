//! The tree as the pixels of one picture see it.
//!
//! All rays start at the eye, or in one plane, so that nearer and farther are the same for all of
//! them: the nodes stand in one order, near ones first, each with a link to what follows its subtree
//! (Smits, "Efficiency issues for ray tracing", JGT 1998). A walk needs no stack and keeps one number.

use std::ops::Range;

use bytemuck::{Pod, Zeroable, zeroed_vec};
use glam::DVec3;
use rayon::prelude::*;

pub use super::IS_LEAF;
use super::Tree;
use super::footprint::{Footprint, NO_CELL};

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

impl Cells {
    /// None, which no node covers: they begin past the last column.
    pub const NONE: Cells = Cells { first: NO_CELL as u32, last: 0 };
}

#[inline(always)]
const fn pack(column: u32, row: u32) -> u32 {
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

    /// Whether it has fewer columns or rows of cells than `side`.
    #[inline(always)]
    pub fn is_narrower(&self, side: u32) -> bool {
        let Footprint { columns, rows, .. } = self.footprint();
        [columns, rows].iter().any(|[first, last]| u32::from(last - first) + 1 < side)
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

/// Most nodes of a subtree that one thread fits at a time: they stay in its caches, and 16 bits count them.
const PART: usize = 1 << 14;

/// Subtrees that are fitted side by side, which have all leaves. They are the same for each picture.
#[derive(Clone, Debug)]
pub struct Parts {
    parts: Vec<Part>,
    /// The nodes above them, ascending.
    above: Vec<usize>,
}

/// A subtree. Its nodes have numbers here: first the leaves, in the order of their places, then the inner
/// nodes, depth-first.
#[derive(Clone, Debug)]
struct Part {
    nodes: Range<usize>,
    places: Range<usize>,
    /// What is below each inner node.
    joints: Vec<Joint>,
}

/// The children of an inner node.
#[derive(Clone, Copy, Debug)]
struct Joint {
    children: [u16; 2],
    /// How many nodes each child's subtree has.
    n_nodes: [u16; 2],
}

impl Part {
    fn new(tree: &Tree, nodes: Range<usize>, first_place: usize) -> Part {
        let n_leaves = nodes.len().div_ceil(2);
        let (mut numbers, mut n_before) = (Vec::with_capacity(nodes.len()), [0, n_leaves as u16]);
        for at in nodes.clone() {
            let next = &mut n_before[usize::from(tree.place(at).is_none())];
            numbers.push(*next);
            *next += 1;
        }
        let joint = |at: usize| {
            let [first, second] = tree.children(at);
            Joint {
                children: [first, second].map(|child| numbers[child - nodes.start]),
                n_nodes: [(second - first) as u16, (tree.after(second) - second) as u16],
            }
        };
        let joints = nodes.clone().filter(|&at| tree.place(at).is_none()).map(joint).collect();
        Part { places: first_place..first_place + n_leaves, joints, nodes }
    }

    /// The root's number.
    fn root(&self) -> usize {
        if self.joints.is_empty() { 0 } else { self.places.len() }
    }

    /// The hulls of all that is below each inner node; those of the leaves are there.
    fn fit(&self, hulls: &mut [Footprint]) {
        for (number, joint) in (self.places.len()..hulls.len()).zip(&self.joints).rev() {
            let [a, b] = joint.children.map(|child| &hulls[usize::from(child)]);
            hulls[number] = a.union(b);
        }
    }

    /// The nodes in the order of the walk, of which the root is number `start`. `order` is of as many
    /// numbers, to be written over.
    fn put(&self, start: usize, hulls: &[Footprint], order: &mut [u16], nodes: &mut [Node]) {
        order[self.root()] = 0;
        for (number, joint) in (self.places.len()..).zip(&self.joints) {
            let [a, b] = joint.children.map(usize::from);
            let is_second = usize::from(hulls[b].t < hulls[a].t);
            let here = order[number];
            let [near, far] = if is_second == 1 { [b, a] } else { [a, b] };
            order[near] = here + 1;
            order[far] = here + 1 + joint.n_nodes[is_second];
            let after = start + usize::from(here + 1 + joint.n_nodes[0] + joint.n_nodes[1]);
            nodes[usize::from(here)] = Node::new(&hulls[number], after as u32);
        }
        for ((place, hull), &here) in self.places.clone().zip(hulls).zip(&*order) {
            nodes[usize::from(here)] = Node::new(hull, place as u32 | IS_LEAF);
        }
    }
}

impl Parts {
    /// Those of a tree.
    pub fn new(tree: &Tree) -> Parts {
        let (nodes, above) = tree.cut(PART);
        let first_place = |first: &mut usize, nodes: Range<usize>| {
            let place = *first;
            *first += nodes.len().div_ceil(2);
            Some((nodes, place))
        };
        let with_places: Vec<_> = nodes.into_iter().scan(0, first_place).collect();
        let part = |(nodes, place)| Part::new(tree, nodes, place);
        Parts { parts: with_places.into_par_iter().map(part).collect(), above }
    }

    /// The places of their spheres, which ascend and are all places.
    pub fn places(&self) -> impl Iterator<Item = Range<usize>> {
        self.parts.iter().map(|part| part.places.clone())
    }

    /// The least `along·(p − from)` of the points `p` in the box of each, roughly.
    pub fn nearest(&self, tree: &Tree, from: DVec3, along: DVec3) -> Vec<f32> {
        let nearest = |part: &Part| tree.nearest(part.nodes.start, from, along) as f32;
        self.parts.iter().map(nearest).collect()
    }

    /// A number for each node above the parts, from those of the parts and what two of them make.
    fn fold<T: Copy>(&self, tree: &Tree, parts: &[T], join: impl Fn(T, T) -> T) -> Vec<T> {
        // What is below stands behind.
        let mut above: Vec<T> = Vec::with_capacity(self.above.len());
        for &at in self.above.iter().rev() {
            let [a, b] = tree.children(at).map(|child| match self.find(child) {
                Found::Part(part) => parts[part],
                Found::Above(number) => above[self.above.len() - 1 - number],
            });
            above.push(join(a, b));
        }
        above.reverse();
        above
    }

    /// A node that is the root of a part, or above the parts.
    fn find(&self, at: usize) -> Found {
        match self.parts.binary_search_by_key(&at, |part| part.nodes.start) {
            Ok(part) => Found::Part(part),
            Err(_) => Found::Above(self.above.partition_point(|&above| above < at)),
        }
    }

    /// The numbers in the walk of the nodes above the parts, and of the roots of the parts with their
    /// indices, ascending: of two children the one with the lesser `t` first.
    fn arrange(&self, tree: &Tree, nearest: &[f32]) -> (Vec<usize>, Vec<(usize, usize)>) {
        let nearest_above = self.fold(tree, nearest, f32::min);
        let (mut starts_above, mut starts) = (vec![0; self.above.len()], Vec::new());
        let mut open = if self.parts.is_empty() { Vec::new() } else { vec![0] };
        let mut next = 0;
        while let Some(at) = open.pop() {
            match self.find(at) {
                Found::Part(part) => {
                    starts.push((next, part));
                    next += self.parts[part].nodes.len();
                }
                Found::Above(number) => {
                    starts_above[number] = next;
                    next += 1;
                    let children = tree.children(at);
                    let [a, b] = children.map(|child| match self.find(child) {
                        Found::Part(part) => nearest[part],
                        Found::Above(number) => nearest_above[number],
                    });
                    let [first, second] = children;
                    open.extend(if b < a { [first, second] } else { [second, first] });
                }
            }
        }
        (starts_above, starts)
    }
}

/// What a picture gives for the parts of a tree.
pub struct Given<D> {
    /// For each part.
    pub of_parts: Vec<D>,
    /// A number for each part, of which those with less are looked at first: about the least `t`.
    pub nearest: Vec<f32>,
    /// Nodes to be written over, in place of new ones where they are as many.
    pub nodes: Vec<Node>,
}

/// A node of the tree.
enum Found {
    Part(usize),
    Above(usize),
}

impl Footprints {
    /// Fits bounds on the screen to a tree, whose sphere at each place has one of these footprints:
    /// [`Footprint::NONE`] where no pixel sees it.
    pub fn new(tree: &Tree, footprints: &[Footprint], cell_shift: u32) -> Footprints {
        let parts = Parts::new(tree);
        let given: Vec<_> = parts.places().map(|places| &footprints[places]).collect();
        let least = |given: &&[Footprint]| given.iter().fold(f32::MAX, |t, one| t.min(one.t));
        let nearest: Vec<f32> = given.iter().map(least).collect();
        let copy = |given: &[Footprint], here: &mut [Footprint]| {
            here.copy_from_slice(given);
        };
        let given = Given { of_parts: given, nearest, nodes: Vec::new() };
        Footprints::of_parts(tree, &parts, cell_shift, given, copy).0
    }

    /// Fits bounds on the screen to the parts of a tree. `see` writes the footprints of the spheres at a
    /// part's places, from what is given for it; with what it returns of each part.
    pub fn of_parts<D: Send, T: Send>(
        tree: &Tree,
        parts: &Parts,
        cell_shift: u32,
        given: Given<D>,
        see: impl Fn(D, &mut [Footprint]) -> T + Sync,
    ) -> (Footprints, Vec<T>) {
        let Given { of_parts, nearest, mut nodes } = given;
        if nodes.len() != tree.n_nodes() {
            nodes = zeroed_vec(tree.n_nodes());
        }
        let (starts_above, starts) = parts.arrange(tree, &nearest);
        let runs = starts.iter().map(|&(start, part)| start..start + parts.parts[part].nodes.len());
        let mut runs: Vec<_> = split(&mut nodes, runs).into_iter().zip(starts.iter()).collect();
        runs.sort_unstable_by_key(|&(_, (_, part))| part);
        let work = runs.into_par_iter().zip(&parts.parts).zip(of_parts);
        let (hulls, told): (Vec<Footprint>, Vec<T>) = work
            .map_init(
                <(Vec<_>, Vec<_>)>::default,
                |(hulls, order), (((nodes, at), part), given)| {
                    hulls.resize(nodes.len(), Footprint::NONE);
                    order.resize(nodes.len(), 0);
                    let told = see(given, &mut hulls[..part.places.len()]);
                    part.fit(hulls);
                    part.put(at.0, hulls, order, nodes);
                    (hulls[part.root()], told)
                },
            )
            .unzip();
        let hulls_above = parts.fold(tree, &hulls, |a, b| a.union(&b));
        for ((&at, &start), hull) in parts.above.iter().zip(&starts_above).zip(&hulls_above) {
            nodes[start] = Node::new(hull, (start + tree.after(at) - at) as u32);
        }
        (Footprints { nodes, cell_shift }, told)
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
        while let Some((node, place)) = self.next(&mut at, cells, t_max) {
            t_max = visit(node, place);
        }
    }
}

/// Leaves that are walked through.
pub trait Leaves {
    /// The next leaf that may be seen in one of the cells at `t ≤ t_max`, and the place of its sphere: from
    /// number `at`, which begins with 0, on. Nearer ones come first.
    fn next(&self, at: &mut usize, cells: Cells, t_max: f32) -> Option<(&Node, usize)>;
}

/// Of two children the nearer one comes first.
impl Leaves for Footprints {
    #[inline(always)]
    fn next(&self, at: &mut usize, cells: Cells, t_max: f32) -> Option<(&Node, usize)> {
        loop {
            let node = self.nodes.get(*at)?;
            if !node.covers(cells) || node.t > t_max {
                *at = node.after(*at);
                continue;
            }
            *at += 1;
            if let Some(place) = node.place() {
                return Some((node, place as usize));
            }
        }
    }
}

/// All leaves that may be seen in some cells, the nearest one first: a list is soon looked through, by many
/// parts of the cells.
#[derive(Clone, Debug, Default)]
pub struct Nearby {
    leaves: Vec<Node>,
}

impl Nearby {
    /// Gathers the leaves of these cells. False where they are more than `most`, and not all are here.
    #[inline(always)]
    pub fn gather(&mut self, footprints: &Footprints, cells: Cells, most: usize) -> bool {
        self.leaves.clear();
        let mut at = 0;
        while let Some((leaf, _)) = footprints.next(&mut at, cells, f32::MAX) {
            if self.leaves.len() == most {
                return false;
            }
            self.leaves.push(*leaf);
        }
        self.leaves.sort_unstable_by(|a, b| a.t.total_cmp(&b.t));
        true
    }

    /// Those leaves.
    pub fn leaves(&self) -> &[Node] {
        &self.leaves
    }
}

impl Leaves for Nearby {
    #[inline(always)]
    fn next(&self, at: &mut usize, cells: Cells, t_max: f32) -> Option<(&Node, usize)> {
        loop {
            let leaf = self.leaves.get(*at).filter(|leaf| leaf.t <= t_max)?;
            *at += 1;
            if leaf.covers(cells) {
                return Some((leaf, (leaf.link & !IS_LEAF) as usize));
            }
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
