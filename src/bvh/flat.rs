//! The tree for walks without a stack, as devices take it: boxes in depth-first order, each with the way to what follows all
//! that it holds.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::sides::{self, NOTHING, Sides};
use super::{Bvh, Node};
use crate::bounds;
use crate::num::{round_down, round_up};
use crate::support::parallel;

/// Set in the link of a leaf's [`FlatBox`], on the device too.
pub const IS_LEAF: u32 = 1 << 31;

/// Boxes that a ray of a device looks at before it is left open. Of 10⁶ spheres in a cube, rays from outside looked at less
/// than 500, at 22 on average; without an end those into many nested spheres would hold the device until its driver takes it for
/// dead.
pub const MOST_BOXES: u32 = 1 << 13;

/// [`MOST_BOXES`] where the device lights what it sees, of rays and of shadow rays. No bound: the CPU takes what is left.
pub const MOST_BOXES_TO_LIGHT: u32 = 1 << 10;

/// Largest coordinate of a [`FlatBox`], and distance of an origin, with which `gpu::slabs` stay in f32's
/// range. No test sees it halved: the range may be smaller.
pub const REACH: f64 = (1u64 << 40) as f64;

/// Boxes of a node that have one around them: a ray that meets a node looks at few more than it meets.
const GROUP: usize = 4;

/// A box of the tree, two texels of a device.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct FlatBox {
    /// Lower corner.
    pub low: [f32; 3],
    /// A leaf: [`IS_LEAF`] and the place of its sphere. Else the boxes from this one to that behind its subtree.
    pub link: u32,
    /// Upper corner.
    pub high: [f32; 3],
    /// The id of a leaf's sphere.
    pub id: u32,
}

impl Bvh {
    /// The boxes in depth-first order, relative to a point; `None` where they reach too far from there. Each step is rounded
    /// outward.
    ///
    /// Each box is wider on every side by `turn` of the distance of its farthest corner from the point. That contains rays from the
    /// point whose direction has this relative error, and shadow rays to far lights ([`crate::shape::shadow`]).
    ///
    /// Of neighbours those come first whose middle, relative to the point as well, has the least of a number: for rays that meet
    /// them in this order, the first hit hides most of what follows.
    pub fn boxes_from(
        &self,
        reference: DVec3,
        turn: f64,
        order: impl Fn(DVec3) -> f64 + Sync,
    ) -> Option<Vec<FlatBox>> {
        let flat = Flat { bvh: self, shift: self.reference - reference, turn, order };
        let Some(root) = self.root().first() else { return Some(Vec::new()) };
        if !flat.moved(self.around).as_flattened().iter().all(|side| side.abs() <= REACH) {
            return None;
        }
        let part = |lane| {
            let mut boxes = Vec::new();
            flat.add(&mut boxes, root, lane);
            boxes
        };
        let parts = parallel::map(0..root.n_boxes(), part);
        let mut boxes = Vec::with_capacity(3 * self.spheres.len() / 2);
        flat.add_below(&mut boxes, root, |boxes, lane| boxes.extend_from_slice(&parts[lane]));
        Some(boxes)
    }
}

/// What boxes are put one behind the other for.
struct Flat<'a, F> {
    bvh: &'a Bvh,
    shift: DVec3,
    turn: f64,
    order: F,
}

impl<F: Fn(DVec3) -> f64> Flat<'_, F> {
    /// Returns a box relative to the new point, wider by the roundings and by the error of a ray's direction.
    ///
    /// Let a true ray be in the box at `t`. Its point there is at most as far from the origin as the farthest corner, at a distance
    /// `r`. The computed ray's direction has a relative error of `turn`, so its point at `t` is within `turn·r` of that point, and
    /// in the wider box.
    /// Each box gets a slack for its distance only: one far sphere must not widen all boxes.
    fn moved(&self, [low, high]: Sides) -> [[f64; 3]; 2] {
        let shift = self.shift.to_array();
        let low = std::array::from_fn(|k| (f64::from(low[k]) + shift[k].next_down()).next_down());
        let high = std::array::from_fn(|k| (f64::from(high[k]) + shift[k].next_up()).next_up());
        if self.turn == 0.0 {
            return [low, high];
        }
        let farthest = DVec3::from(low).abs().max(DVec3::from(high).abs());
        let slack = self.turn * bounds::length_bound(farthest);
        [low.map(|side| (side - slack).next_down()), high.map(|side| (side + slack).next_up())]
    }

    fn flat(&self, sides: Sides, link: u32, id: u32) -> FlatBox {
        let [low, high] = self.moved(sides);
        FlatBox { low: low.map(round_down), link, high: high.map(round_up), id }
    }

    /// Adds a box of a node and what is in it.
    fn add(&self, boxes: &mut Vec<FlatBox>, node: &Node, lane: usize) {
        let (sides, link) = (node.sides(lane), node.place(lane as u32));
        if lane < node.n_children as usize {
            let below = &self.bvh.nodes[link as usize];
            self.add_around(boxes, sides, |boxes| {
                self.add_below(boxes, below, |boxes, lane| self.add(boxes, below, lane));
            });
        } else {
            boxes.push(self.flat(sides, link | IS_LEAF, self.bvh.ids[link as usize]));
        }
    }

    /// Adds a box around what is added.
    fn add_around(
        &self,
        boxes: &mut Vec<FlatBox>,
        sides: Sides,
        add: impl FnOnce(&mut Vec<FlatBox>),
    ) {
        let at = boxes.len();
        boxes.push(self.flat(sides, 0, 0));
        add(boxes);
        boxes[at].link = (boxes.len() - at) as u32;
    }

    /// Adds all boxes of a node, in groups.
    fn add_below(
        &self,
        boxes: &mut Vec<FlatBox>,
        node: &Node,
        add: impl Fn(&mut Vec<FlatBox>, usize),
    ) {
        let n = node.n_boxes();
        let groups = (0..n).step_by(GROUP).map(|first| {
            let lanes = first..n.min(first + GROUP);
            (lanes.clone().map(|lane| node.sides(lane)).fold(NOTHING, sides::union), lanes)
        });
        for (sides, lanes) in self.in_order(groups) {
            let is_alone = lanes.len() == 1 || lanes.len() == n;
            let in_order = self.in_order(lanes.map(|lane| (node.sides(lane), lane)));
            let add_all = |boxes: &mut _| in_order.for_each(|(_, lane)| add(boxes, lane));
            match is_alone {
                true => add_all(boxes),
                false => self.add_around(boxes, sides, add_all),
            }
        }
    }

    /// Sorts boxes, with what belongs to each, by the order of their middles, least first; those of equal order stay as they are.
    fn in_order<T>(
        &self,
        all: impl Iterator<Item = (Sides, T)>,
    ) -> impl Iterator<Item = (Sides, T)> {
        let corner = |sides: [f32; 3]| DVec3::from_array(sides.map(f64::from));
        let middle = |[low, high]: Sides| (corner(low) + corner(high)) * 0.5 + self.shift;
        let mut all: Vec<_> =
            all.map(|(sides, what)| ((self.order)(middle(sides)), (sides, what))).collect();
        all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        all.into_iter().map(|(_, all)| all)
    }
}
