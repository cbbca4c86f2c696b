//! One tree over the spheres of a scene, and one walk through it, whatever is asked: built once, seen from anywhere.
//!
//! Boxes hold their spheres, and a [`Beam`] holds its rays. So a box that no ray of a beam meets holds nothing that one of
//! them could hit. The spheres stand in the order of the leaves: that is their place.

mod build;
mod leaves;
mod members;
mod sides;
mod walk;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use rayon::prelude::*;

use crate::control::Control;
use crate::error::Result;
use crate::guard::{round_down, round_up};
use crate::num::{Lanes, Real};
use crate::scene::Sphere;

pub use leaves::Leaves;
pub use members::MOST_SPHERES;
use sides::Sides;
pub use walk::{Beam, Corners, Cut, Enter, Visitor, Walk, above, prefetch};

/// Most boxes of a node.
pub const WIDTH: usize = 16;

/// Set in the link of a leaf's [`FlatBox`], on the device too.
pub const IS_LEAF: u32 = 1 << 31;

/// Boxes that a ray of a device looks at before it is left open. Of 10⁶ spheres in a cube, rays from outside looked at 2300 at
/// most and half of them at 16; without an end those into many nested spheres would hold the device until its driver takes it for
/// dead.
pub const MOST_BOXES: u32 = 1 << 13;

/// Boxes side by side: first those of nodes, then those of spheres, then empty ones.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node {
    low: [Lanes<f32, WIDTH>; 3],
    high: [Lanes<f32, WIDTH>; 3],
    /// Numbers of nodes, then places of spheres.
    links: [u32; WIDTH],
    n_children: u32,
    /// A bit a box.
    boxes: u32,
}

impl Node {
    const EMPTY: Node = Node {
        low: [Lanes([f32::INFINITY; WIDTH]); 3],
        high: [Lanes([f32::NEG_INFINITY; WIDTH]); 3],
        links: [0; WIDTH],
        n_children: 0,
        boxes: 0,
    };

    /// The place of the sphere in a box.
    #[inline(always)]
    pub fn place(&self, lane: u32) -> u32 {
        self.links[lane as usize % WIDTH]
    }

    /// The boxes that hold nodes, a bit each.
    #[inline(always)]
    fn children(&self) -> u32 {
        (1 << self.n_children) - 1
    }

    fn sides(&self, lane: usize) -> Sides {
        [&self.low, &self.high].map(|sides| [0, 1, 2].map(|axis| sides[axis].0[lane]))
    }

    /// Adds a box; those of nodes come first.
    fn push(&mut self, [low, high]: Sides, link: u32, is_node: bool) {
        let lane = self.boxes.count_ones() as usize;
        for axis in 0..3 {
            self.low[axis].0[lane] = low[axis];
            self.high[axis].0[lane] = high[axis];
        }
        self.links[lane] = link;
        self.boxes |= 1 << lane;
        self.n_children += u32::from(is_node);
    }
}

/// The tree over those spheres of a scene that can be seen and have a box in f32.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// What the boxes are relative to, world units.
    pub reference: DVec3,
    /// Node 0 is the root; there is none over no spheres.
    nodes: Vec<Node>,
    around: Sides,
    /// The sphere at each place.
    pub spheres: Vec<Sphere>,
    /// The id of the sphere at each place.
    pub ids: Vec<u32>,
    /// Ids of the spheres that f32 has no box for, ascending.
    pub outside: Vec<u32>,
}

/// A box of the tree for walks without a stack, as devices take it: two texels.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct FlatBox {
    /// Lower corner.
    pub low: [f32; 3],
    /// A leaf: [`IS_LEAF`] and the place of its sphere. Else the box that follows the subtree.
    pub link: u32,
    /// Upper corner.
    pub high: [f32; 3],
    /// The id of a leaf's sphere.
    pub id: u32,
}

/// Largest coordinate of a [`FlatBox`], and distance of an origin, with which `gpu::slabs` stay in f32's
/// range. No test sees it halved: the range may be smaller.
pub const REACH: f64 = (1u64 << 40) as f64;

impl Bvh {
    /// Builds the tree over the spheres of a scene.
    ///
    /// # Errors
    /// [`Error::TooLarge`](crate::Error::TooLarge) for more than [`MOST_SPHERES`] or than there is
    /// memory to build over; [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn new(spheres: &[Sphere], control: &Control) -> Result<Bvh> {
        members::check_size(spheres.len())?;
        let reference = members::reference(spheres);
        let (inside, outside) = members::members(spheres, reference);
        control.check()?;
        let (nodes, around, order) = build::build(spheres, reference, &inside, control)?;
        drop(inside);
        let spheres = order.par_iter().map(|&index| spheres[index as usize]).collect();
        let id = |index: u32| index + 1;
        Ok(Bvh {
            reference,
            nodes,
            around,
            spheres,
            ids: order.into_par_iter().map(id).collect(),
            outside: outside.into_iter().map(id).collect(),
        })
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.nodes.len()
    }

    /// The root, for walks that begin there; nothing over no spheres.
    #[inline(always)]
    pub fn root(&self) -> &[Node] {
        &self.nodes[..self.nodes.len().min(1)]
    }

    /// Bytes of the nodes, the spheres and their ids.
    pub fn bytes(&self) -> u64 {
        let Bvh { nodes, spheres, ids, .. } = self;
        (size_of_val(&nodes[..]) + size_of_val(&spheres[..]) + size_of_val(&ids[..])) as u64
    }

    /// The largest coordinate of a box.
    pub fn size(&self) -> f64 {
        self.around.as_flattened().iter().fold(0.0, |most: f64, side| most.max(side.abs().into()))
    }

    /// No ray with `|d| ≥ 1` that starts between two points, relative to the reference point, meets a box at a larger `t`.
    pub fn end(&self, [low, high]: [DVec3; 2]) -> f64 {
        let [first, last] = self.around.map(|corner| DVec3::from_array(corner.map(f64::from)));
        // No test sees the 1.01, which is for the roundings.
        1.01 * (last - low).abs().max((high - first).abs()).element_sum()
    }

    /// The boxes in depth-first order, relative to a point; `None` where they reach too far from there.
    /// Each step is rounded outward.
    pub fn boxes_from(&self, reference: DVec3) -> Option<Vec<FlatBox>> {
        let shift = (self.reference - reference).to_array();
        let low = |k: usize, x: f32| (f64::from(x) + shift[k].next_down()).next_down();
        let high = |k: usize, x: f32| (f64::from(x) + shift[k].next_up()).next_up();
        let [first, last] = self.around;
        let is_near = |k: usize| low(k, first[k]) >= -REACH && high(k, last[k]) <= REACH;
        if !self.nodes.is_empty() && !(0..3).all(is_near) {
            return None;
        }
        let flat = |[first, last]: Sides, link, id| FlatBox {
            low: std::array::from_fn(|k| round_down(low(k, first[k]))),
            link,
            high: std::array::from_fn(|k| round_up(high(k, last[k]))),
            id,
        };
        let mut boxes = Vec::with_capacity(self.nodes.len() + self.spheres.len());
        // Boxes that are still to be looked at, the next one last, and those whose subtree ends before them.
        let mut ahead: Vec<(u32, u32)> = Vec::new();
        let mut above: Vec<(usize, usize)> = Vec::new();
        let lanes = |number: u32| (0..self.nodes[number as usize].boxes.count_ones()).rev();
        if !self.nodes.is_empty() {
            ahead.extend(lanes(0).map(|lane| (0, lane)));
        }
        while let Some((number, lane)) = ahead.pop() {
            let (node, at) = (&self.nodes[number as usize], boxes.len());
            let link = node.place(lane);
            if lane >= node.n_children {
                boxes.push(flat(
                    node.sides(lane as usize),
                    link | IS_LEAF,
                    self.ids[link as usize],
                ));
            } else {
                above.push((at, ahead.len()));
                boxes.push(flat(node.sides(lane as usize), 0, 0));
                ahead.extend(lanes(link).map(|lane| (link, lane)));
            }
            while let Some(&(at, _)) = above.last().filter(|&&(_, left)| left == ahead.len()) {
                boxes[at].link = boxes.len() as u32;
                above.pop();
            }
        }
        Some(boxes)
    }
}

/// The bits of a mask, those of the first lane lowest. The mask goes through memory: joined into one number in registers,
/// all that it comes from would fall apart with it.
#[inline(always)]
fn bits(mask: <Lanes<f32, WIDTH> as Real>::Mask) -> u32 {
    let mask = std::hint::black_box(mask);
    let mut bits = 0;
    for (lane, mask) in mask.0.iter().enumerate() {
        bits |= mask & 1 << lane;
    }
    bits
}

#[cfg(test)]
mod tests;
