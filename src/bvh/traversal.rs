//! Beams of rays on their way through the tree.
//!
//! # Slabs
//! Along an axis the rays of a beam are within `[low + t·slow, high + t·quick]`: two half spaces of `(t, x)`, each of which
//! bounds the `t` at which a box is met. Bounds of origins and sides of boxes are rounded outward, and cost nothing. With
//! `u = 2⁻²⁴`, a slab `(side − origin)·(1/d)` has an error of `u` for the inverse, which is found in f64, its widening, the
//! difference and the product: 4 of the 6 that [`WIDER`] has, and of the 5 of [`NARROWER`].
//!
//! # Underflow and overflow
//! A difference of f32 does not underflow, and neither does the inverse of a direction below `2³¹`. A product that underflows has an
//! error of at most `2⁻¹²⁶`, flushed to 0 or not. The beam is wider by [`LEAST`] on either side. If an origin is so large that
//! [`LEAST`] is lost in it, then outward rounding makes the beam wider by more. Either moves the product by at least
//! `2⁻⁹⁰·2⁻³¹ = 2⁻¹²¹`. The largest inverse is `1/`[`FLAT`]` = 2⁶⁰`. Sides and origins end at `2¹⁰⁰`, so that a product may overflow: then
//! it is infinite with the right sign, beyond every `t`.

use glam::DVec3;

use super::{Bvh, Node, WIDTH, bits};
use crate::num::{Float, Lanes, Real};

/// Lower and upper corner of some points or vectors.
pub type Corners = [DVec3; 2];

/// Lower bounds of the `t` at which boxes are met.
pub type Enter = Lanes<f32, WIDTH>;

/// What is asked of the tree.
pub trait Visitor {
    /// What lies beyond is not asked for; below 0 where nothing is.
    fn last(&self) -> f32;
    /// The place of a sphere that will soon be visited.
    #[inline(always)]
    fn expect(&self, _place: u32) {}
    /// Some spheres of a node, by the lanes of their boxes, and where these are met.
    #[inline(always)]
    fn visit(&mut self, node: &Node, mut leaves: u32, enter: &Enter) {
        while leaves != 0 {
            let lane = leaves.trailing_zeros();
            leaves &= leaves - 1;
            if enter.0[lane as usize % WIDTH] <= self.last() {
                self.see(node.place(lane));
            }
        }
    }
    /// The sphere at a place, of those that are visited one after the other; not asked for where `visit` takes them together.
    fn see(&mut self, _place: u32) {}
}

/// Rays between bounds: one ray, a pack of pixels, a square of them, or the ways to a light.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beam {
    slabs: [Slab; 3],
    /// No box is asked for beyond.
    end: f32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Slab {
    /// Bounds of origins.
    low: f32,
    high: f32,
    /// `1/slow` and `1/quick`, of the bounds of directions.
    low_inverse: f32,
    high_inverse: f32,
    way: Descent,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Descent {
    #[default]
    Up,
    Down,
    Both,
}

/// Directions below this count as 0, which only widens a beam. No test sees it halved: so does a half of it.
const FLAT: f64 = 1.0 / (1u64 << 60) as f64;

/// Least width of a beam to each side. Halving it is not covered by a test: it moves a product by `2⁵` times an underflow.
const LEAST: f32 = 1.0 / (1u128 << 90) as f32;

/// Relative room of a slab. No test sees that of the far side halved: in f32 it rounds to the 4 that are needed.
pub(super) const WIDER: f32 = 1.0 + 3.0 * f32::EPSILON;
pub(super) const NARROWER: f32 = 1.0 - 2.5 * f32::EPSILON;

/// Coordinates beyond this are taken for this, or for infinitely far away. No test sees it halved: boxes end at `2⁶²`.
const FARTHEST: f64 = (1u128 << 100) as f64;

/// A number not above, by up to three units or three of the smallest numbers.
#[inline(always)]
pub(super) fn below(x: f64) -> f32 {
    let nearer = x.min(FARTHEST);
    match x > -FARTHEST {
        true => (nearer - (nearer.abs() * f32::UNIT + SMALLEST)) as f32,
        false => f32::NEG_INFINITY,
    }
}

/// A number not below, by up to three units or three of the smallest numbers.
#[inline(always)]
pub fn above(x: f64) -> f32 {
    let nearer = x.max(-FARTHEST);
    match x < FARTHEST {
        true => (nearer + (nearer.abs() * f32::UNIT + SMALLEST)) as f32,
        false => f32::INFINITY,
    }
}

/// The smallest f32 above 0. A subnormal number is rounded by up to a half of it.
const SMALLEST: f64 = 1.0 / (1u128 << 126) as f64 / (1u64 << 23) as f64;

impl Beam {
    /// From bounds of origins, relative to the tree's reference point, and of directions. No box is asked for at a larger `t`
    /// than `end`.
    #[inline(always)]
    pub fn new(origin: Corners, direction: Corners, end: f64) -> Beam {
        let mut slabs = [Slab::default(); 3];
        for (k, slab) in slabs.iter_mut().enumerate() {
            let (slow, quick) = (direction[0][k], direction[1][k]);
            let (is_up, is_down) = (slow > FLAT, quick < -FLAT);
            let way = match (is_up, is_down) {
                (true, _) => Descent::Up,
                (_, true) => Descent::Down,
                _ => Descent::Both,
            };
            let slow = if is_up | is_down { slow } else { slow.min(-FLAT) };
            let quick = if is_up | is_down { quick } else { quick.max(FLAT) };
            // What bounds the end is wider.
            let of_low = if is_up { WIDER } else { NARROWER };
            let of_high = if is_down { WIDER } else { NARROWER };
            *slab = Slab {
                low: below(origin[0][k]) - LEAST,
                high: above(origin[1][k]) + LEAST,
                low_inverse: (1.0 / slow) as f32 * of_low,
                high_inverse: (1.0 / quick) as f32 * of_high,
                way,
            };
        }
        Beam { slabs, end: above(end) }
    }

    /// Lower bounds of the `t ≥ 0` at which boxes are met, and which of them may be up to `last`.
    #[inline(always)]
    fn meet(&self, node: &Node, last: f32) -> (Enter, u32) {
        let (mut enter, mut leave) = (Lanes::splat(0.0), Lanes::splat(Real::min(last, self.end)));
        for axis in 0..3 {
            let (slab, low, high) = (&self.slabs[axis], node.low[axis], node.high[axis]);
            let of_low = (low - Lanes::splat(slab.high)) * Lanes::splat(slab.high_inverse);
            let of_high = (high - Lanes::splat(slab.low)) * Lanes::splat(slab.low_inverse);
            match slab.way {
                Descent::Up => (enter, leave) = (enter.max(of_low), leave.min(of_high)),
                Descent::Down => (enter, leave) = (enter.max(of_high), leave.min(of_low)),
                Descent::Both => enter = enter.max(of_low).max(of_high),
            }
        }
        // What is not a number is met.
        (enter, !bits(leave.lt(enter)) & node.boxes)
    }

    /// The `t` where a beam that goes up the first axis meets a side, and where it leaves it, each with the origin that it takes.
    #[cfg(test)]
    pub(super) fn sides(&self, side: f32) -> [(f32, f32); 2] {
        let slab = &self.slabs[0];
        [
            ((side - slab.high) * slab.high_inverse, slab.high),
            ((side - slab.low) * slab.low_inverse, slab.low),
        ]
    }

    /// Which of some boxes of a node may be met up to `last`.
    #[inline(always)]
    pub fn among(&self, node: &Node, leaves: u32, last: f32) -> u32 {
        self.meet(node, last).1 & leaves
    }
}

/// Most boxes of a cut.
const CUT: usize = 32;

/// What a beam sees of a tree: boxes from any level, near ones first. Walks of narrower beams begin there.
#[derive(Default)]
pub struct Frontier {
    nodes: Vec<Node>,
    /// Boxes, by their nodes and lanes, and where the beam meets them.
    open: Vec<(f32, u32, u32)>,
}

impl Frontier {
    /// The boxes of the cut, by their nodes.
    #[inline(always)]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Takes what a beam sees.
    #[inline(always)]
    pub fn make(&mut self, bvh: &Bvh, beam: &Beam) {
        let Frontier { nodes, open } = self;
        open.clear();
        nodes.clear();
        let (mut at, mut next) = (0, (!bvh.nodes.is_empty()).then_some(0));
        while let Some(number) = next {
            let node = &bvh.nodes[number as usize];
            let (enter, mut hits) = beam.meet(node, beam.end);
            while hits != 0 {
                let lane = hits.trailing_zeros();
                hits &= hits - 1;
                open.push((enter.0[lane as usize], number, lane));
            }
            next = None;
            // The nodes are opened in their order, as long as there is room.
            while open.len() + WIDTH <= CUT + 1 && at < open.len() && next.is_none() {
                let (_, number, lane) = open[at];
                let node = &bvh.nodes[number as usize];
                if lane < node.n_children {
                    open.swap_remove(at);
                    next = Some(node.place(lane));
                } else {
                    at += 1;
                }
            }
        }
        open.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for boxes in open.chunks(WIDTH) {
            let mut node = Node::EMPTY;
            for is_node in [true, false] {
                for &(_, number, lane) in boxes {
                    let from = &bvh.nodes[number as usize];
                    if (lane < from.n_children) == is_node {
                        node.push(from.sides(lane as usize), from.place(lane), is_node);
                    }
                }
            }
            nodes.push(node);
        }
    }
}

/// A beam on its way.
#[derive(Default)]
pub struct Traversal {
    beam: Beam,
    /// Nodes to be looked at, and lower bounds of their `t`: as one number, which is larger where that is later.
    stack: Vec<u64>,
    /// A node whose spheres the memory was asked for, these, and where their boxes are met.
    awaited: (u32, u32),
    enter: Enter,
}

impl Traversal {
    #[inline(always)]
    fn begin(&mut self, beam: Beam) {
        (self.beam, self.awaited) = (beam, (0, 0));
        self.stack.clear();
    }

    /// Begins at the root. Then [`Traversal::step`] goes on.
    #[inline(always)]
    pub fn begin_at_root(&mut self, bvh: &Bvh, beam: Beam) {
        self.begin(beam);
        self.stack.extend(bvh.root().iter().map(|_| 0));
    }

    /// Shows `visitor` the spheres below some nodes that a ray of the beam may meet at `0 ≤ t ≤ last`, near boxes
    /// first.
    #[inline(always)]
    pub fn all<V: Visitor>(&mut self, bvh: &Bvh, from: &[Node], beam: Beam, visitor: &mut V) {
        self.begin(beam);
        let mut from = from.iter();
        loop {
            let (node, (enter, leaves)) = if let Some(node) = from.next() {
                (node, self.look(node, 0, visitor))
            } else if let Some(at) = self.next(visitor) {
                let node = &bvh.nodes[at as usize];
                (node, self.look_ahead(bvh, node, visitor))
            } else {
                break;
            };
            if leaves != 0 {
                visitor.visit(node, leaves, &enter);
            }
        }
    }

    /// Shows what the memory was asked for, and looks at one more node. False where none is left.
    #[inline(always)]
    pub fn step<V: Visitor>(&mut self, bvh: &Bvh, visitor: &mut V) -> bool {
        let (at, leaves) = self.awaited;
        if leaves != 0 {
            visitor.visit(&bvh.nodes[at as usize], leaves, &self.enter);
            self.awaited = (0, 0);
        }
        let next = self.next(visitor);
        if let Some(at) = next {
            let (enter, leaves) = self.look_ahead(bvh, &bvh.nodes[at as usize], visitor);
            self.awaited = (at, leaves);
            self.enter = enter;
        }
        next.is_some()
    }

    /// The number of the next node that is not beyond.
    #[inline(always)]
    fn next<V: Visitor>(&mut self, visitor: &V) -> Option<u32> {
        while let Some(next) = self.stack.pop() {
            if f32::from_bits((next >> 32) as u32) <= visitor.last() {
                return Some(next as u32);
            }
        }
        None
    }

    /// Looks at a node, and asks the memory for what comes next.
    #[inline(always)]
    fn look_ahead<V: Visitor>(&mut self, bvh: &Bvh, node: &Node, visitor: &V) -> (Enter, u32) {
        let (enter, leaves) = self.look(node, self.stack.len(), visitor);
        if let Some(&next) = self.stack.last() {
            prefetch(&bvh.nodes[next as u32 as usize]);
        }
        let mut coming = leaves;
        while coming != 0 {
            visitor.expect(node.place(coming.trailing_zeros()));
            coming &= coming - 1;
        }
        (enter, leaves)
    }

    /// Notes the nodes below that are met, in order among those from `first` on; the bits of spheres that are.
    #[inline(always)]
    fn look<V: Visitor>(&mut self, node: &Node, first: usize, visitor: &V) -> (Enter, u32) {
        let (enter, hits) = self.beam.meet(node, visitor.last());
        let (stack, mut children) = (&mut self.stack, hits & node.children());
        while children != 0 {
            let lane = children.trailing_zeros();
            children &= children - 1;
            // The nearest one last, without a branch for what lies how.
            let enter = enter.0[lane as usize % WIDTH].to_bits();
            let mut nearer = u64::from(enter) << 32 | u64::from(node.place(lane));
            for other in &mut stack[first..] {
                (*other, nearer) = ((*other).max(nearer), (*other).min(nearer));
            }
            stack.push(nearer);
        }
        (enter, hits & !node.children())
    }
}

/// Asks the memory for a value.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for byte in (0..size_of::<T>()).step_by(CACHE_LINE) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let at = std::ptr::from_ref(value).cast::<i8>().wrapping_add(byte);
        // SAFETY: a hint, for which any address will do; each x86-64 processor has it.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(at);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// Bytes that come from the memory at once.
#[cfg(target_arch = "x86_64")]
const CACHE_LINE: usize = 64;
