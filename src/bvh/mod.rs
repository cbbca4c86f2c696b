//! One tree over the spheres of a scene, and one walk through it, whatever is asked: built once, seen from anywhere.
//!
//! Boxes hold their spheres, and a [`Beam`] holds its rays. So a box that no ray of a beam meets holds nothing that one of
//! them could hit. The spheres stand in the order of the leaves: that is their place.

mod build;
mod flat;
mod leaves;
mod members;
mod sides;
mod traversal;

use glam::DVec3;

use crate::error::Result;
use crate::num::{Lanes, Real};
use crate::scene::Sphere;
use crate::support::control::Control;
use crate::support::parallel;

pub use flat::{FlatBox, IS_LEAF, MOST_BOXES, MOST_BOXES_TO_LIGHT, REACH};
pub use leaves::Leaves;
pub use members::MOST_SPHERES;
use sides::Sides;
pub use traversal::{Beam, Corners, Enter, Frontier, Traversal, Visitor, above, prefetch};

/// Most boxes of a node.
pub const WIDTH: usize = 16;

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

    fn n_boxes(&self) -> usize {
        self.boxes.count_ones() as usize
    }

    fn sides(&self, lane: usize) -> Sides {
        [&self.low, &self.high].map(|sides| [0, 1, 2].map(|axis| sides[axis].0[lane]))
    }

    /// Adds a box; those of nodes come first.
    fn push(&mut self, [low, high]: Sides, link: u32, is_node: bool) {
        let lane = self.n_boxes();
        for axis in 0..3 {
            self.low[axis].0[lane] = low[axis];
            self.high[axis].0[lane] = high[axis];
        }
        self.links[lane] = link;
        self.boxes |= 1 << lane;
        self.n_children += u32::from(is_node);
    }
}

/// The tree over the spheres of a scene that can be seen and are not outliers.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// The point of the scene that the boxes are relative to.
    pub reference: DVec3,
    /// Node 0 is the root; there is none over no spheres.
    nodes: Vec<Node>,
    around: Sides,
    /// The sphere at each place.
    pub spheres: Vec<Sphere>,
    /// The id of the sphere at each place.
    pub ids: Vec<u32>,
    /// Ids of the spheres that are not in the tree, ascending: f32 has no box for them, or they are much larger or farther away
    /// than most.
    pub outside: Vec<u32>,
}

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
        let id = |index: u32| index + 1;
        Ok(Bvh {
            reference,
            nodes,
            around,
            spheres: parallel::table(order.len(), |place| spheres[order[place] as usize]),
            ids: parallel::table(order.len(), |place| id(order[place])),
            outside: outside.into_iter().map(id).collect(),
        })
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
        if self.nodes.is_empty() {
            return 0.0;
        }
        let [first, last] = self.around.map(|corner| DVec3::from_array(corner.map(f64::from)));
        // No test sees the 1.01, which is for the roundings.
        1.01 * (last - low).abs().max((high - first).abs()).element_sum()
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
