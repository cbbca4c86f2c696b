//! A bounding volume hierarchy over spheres. Its boxes are wide enough that whatever rounds to
//! f32 around them, no sphere is lost.
//!
//! # The margin of the boxes
//! Coordinates are relative to the reference point. A sphere at `L` with radius `r` gets the box
//! `[L_k − r − δ_k, L_k + r + δ_k]` with `δ_k = 2⁻²⁰(|L_k| + r) + 2⁻⁴⁰(‖L‖ + r)`, rounded outward;
//! a node gets the union, which is exact. So for each sphere below it, a node's face at coordinate `v_k`
//! lies beyond the sphere by at least `2⁻²¹|v_k|`, and by nearly `2⁻⁴⁰(‖L‖ + r)` of that sphere.
//!
//! A linear function `n·p` of a box takes its largest and smallest values at corners `v`. Computed
//! in f32 with an `n` rounded to f32, a corner's value is off by at most `4·2⁻²⁴·Σ|n_k v_k|` (one
//! rounding of `n_k`, one product, two sums). The margin moves it outward by `2⁻²¹·Σ|n_k v_k|`. So
//! the computed extreme bounds the true one on every sphere, and what lies beyond a plane by this test
//! does so exactly. The second part of `δ` is for an `n` or a direction that comes from f64 with an
//! error of `2⁻⁵⁰` of its length.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use rayon::prelude::*;

use crate::guard::{round_down, round_up};

/// Children of a node: one register of the widest common instruction set.
pub const WIDTH: usize = 8;

/// Most spheres of a leaf.
const LEAF_SPHERES: u32 = 4;

/// Most spheres of a hierarchy: a leaf's place and size share 31 bits.
pub const MOST_SPHERES: usize = 1 << 29;

/// A node: the boxes of its children side by side.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node {
    /// Lower corners: x, y and z of each child. +∞ where there is no child.
    pub low: [[f32; WIDTH]; 3],
    /// Upper corners; −∞ where there is no child.
    pub high: [[f32; WIDTH]; 3],
    children: [u32; WIDTH],
}

/// What a child is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// A node, as an index.
    Node(u32),
    /// The spheres at these places of [`Bvh::order`].
    Leaf {
        /// First place.
        first: u32,
        /// Number of spheres.
        n: u32,
    },
}

const IS_LEAF: u32 = 1 << 31;

impl Child {
    fn pack(self) -> u32 {
        match self {
            Child::Node(index) => index,
            Child::Leaf { first, n } => IS_LEAF | first << 2 | (n - 1),
        }
    }

    /// From the bits that [`Node::child_bits`] gives.
    #[inline(always)]
    pub fn unpack(bits: u32) -> Child {
        match bits & IS_LEAF {
            0 => Child::Node(bits),
            _ => Child::Leaf { first: (bits & !IS_LEAF) >> 2, n: (bits & 3) + 1 },
        }
    }
}

impl Node {
    const EMPTY: Node = Node {
        low: [[f32::INFINITY; WIDTH]; 3],
        high: [[f32::NEG_INFINITY; WIDTH]; 3],
        children: [0; WIDTH],
    };

    /// A child in 32 bits, for stacks.
    #[inline(always)]
    pub fn child_bits(&self, k: usize) -> u32 {
        self.children[k]
    }

    fn put(&mut self, k: usize, aabb: &Aabb, child: Child) {
        for axis in 0..3 {
            self.low[axis][k] = aabb.min[axis];
            self.high[axis][k] = aabb.max[axis];
        }
        self.children[k] = child.pack();
    }
}

/// The hierarchy. Node 0 is the root.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// Which sphere is at each place of the leaves: its index among those that the hierarchy was
    /// built over.
    pub order: Vec<u32>,
}

impl Bvh {
    /// The root as a child in 32 bits, for stacks.
    pub const ROOT: u32 = 0;

    /// Builds the hierarchy over spheres with these offsets from the reference point and these
    /// radii. There are at most [`MOST_SPHERES`], none farther than f32 reaches.
    pub fn new(spheres: &[(DVec3, f64)]) -> Bvh {
        if spheres.is_empty() {
            return Bvh { nodes: vec![Node::EMPTY], order: Vec::new() };
        }
        let boxes: Vec<Aabb> = spheres.par_iter().map(|&(l, r)| sphere_box(l, r)).collect();
        // Bottom-up by locality (PLOC, Meister & Bittner 2018), then reinsertion of some nodes.
        let params = BvhBuildParams {
            max_prims_per_leaf: LEAF_SPHERES,
            ..BvhBuildParams::very_fast_build()
        };
        let mut build_time = std::time::Duration::ZERO;
        let binary = build_bvh2(&boxes, params, &mut build_time);
        drop(boxes);
        Bvh { nodes: widen(&binary), order: binary.primitive_indices }
    }
}

/// The box of a sphere with the margin.
fn sphere_box(l: DVec3, r: f64) -> Aabb {
    const NEAR: f64 = 1.0 / (1u64 << 20) as f64;
    const FAR: f64 = 1.0 / (1u64 << 40) as f64;
    let margin = (l.abs() + r) * NEAR + FAR * (l.length() + r);
    let (low, high) = (l - r - margin, l + r + margin);
    Aabb::new(
        Vec3A::from_array(low.to_array().map(round_down)),
        Vec3A::from_array(high.to_array().map(round_up)),
    )
}

/// Puts up to three levels of the binary tree into one node, the largest boxes first.
fn widen(binary: &Bvh2) -> Vec<Node> {
    let mut nodes = vec![Node::EMPTY];
    let mut open = vec![(0, 0)];
    while let Some((from, to)) = open.pop() {
        let (children, n) = wide_children(binary, from);
        for (k, &child) in children[..n].iter().enumerate() {
            let node = &binary.nodes[child];
            let kind = if node.is_leaf() {
                Child::Leaf { first: node.first_index, n: node.prim_count }
            } else {
                nodes.push(Node::EMPTY);
                open.push((child, nodes.len() - 1));
                Child::Node(nodes.len() as u32 - 1)
            };
            nodes[to].put(k, node.aabb(), kind);
        }
    }
    nodes
}

/// The descendants of a binary node that become the children of a wide one.
fn wide_children(binary: &Bvh2, from: usize) -> ([usize; WIDTH], usize) {
    let mut children = [from; WIDTH];
    let mut n = 1;
    while n < WIDTH {
        let inner = (0..n).filter(|&k| !binary.nodes[children[k]].is_leaf());
        let area = |&k: &usize| binary.nodes[children[k]].aabb().half_area();
        let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
        let first = binary.nodes[children[largest]].first_index as usize;
        children[largest] = first;
        children[n] = first + 1;
        n += 1;
    }
    (children, n)
}

/// A ray in the hierarchy's frame, in f64.
#[derive(Clone, Copy, Debug)]
pub struct BvhRay {
    /// Offset of the origin from the reference point.
    pub origin: DVec3,
    /// Direction.
    pub direction: DVec3,
}

impl Bvh {
    /// Shows `visit` every sphere, by its place in [`Bvh::order`], that the ray may hit at
    /// `0 < t ≤ t_max`, nearer boxes first. `visit` returns the `t_max` from then on.
    ///
    /// Slabs are computed in f64. The box's margin covers the rounding of the direction, and `2⁻⁴⁵` of
    /// the origin's distance that of the origin and of all steps.
    pub fn visit(&self, ray: &BvhRay, mut visit: impl FnMut(usize) -> f64) {
        const SLACK: f64 = 1.0 / (1u64 << 45) as f64;
        let slack = ray.origin.abs().max_element() * SLACK;
        let inverse = ray.direction.recip();
        let mut t_max = f64::INFINITY;
        let mut stack = vec![(0.0, Bvh::ROOT)];
        while let Some((t, child)) = stack.pop() {
            if t > t_max {
                continue;
            }
            match Child::unpack(child) {
                Child::Leaf { first, n } => {
                    for place in first..first + n {
                        t_max = visit(place as usize);
                    }
                }
                Child::Node(index) => {
                    let node = &self.nodes[index as usize];
                    let base = stack.len();
                    for k in 0..WIDTH {
                        if let Some(t) = enter(node, k, ray, inverse, slack)
                            && t <= t_max
                        {
                            stack.push((t, node.child_bits(k)));
                        }
                    }
                    stack[base..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
                }
            }
        }
    }
}

/// A lower bound of the `t ≥ 0` at which the ray enters a child's box; `None` where it misses it.
fn enter(node: &Node, k: usize, ray: &BvhRay, inverse: DVec3, slack: f64) -> Option<f64> {
    // Three roundings, of the difference, of the inverse and of the product.
    const WIDER: f64 = 1.0 + 4.0 * f64::EPSILON;
    let (mut enter, mut leave) = (0.0, f64::INFINITY);
    for axis in 0..3 {
        let low = f64::from(node.low[axis][k]) - slack - ray.origin[axis];
        let high = f64::from(node.high[axis][k]) + slack - ray.origin[axis];
        if low > high {
            return None;
        }
        // Along a direction this flat the slab is left only where it is not entered at all.
        if !inverse[axis].is_finite() {
            if ray.direction[axis] == 0.0 && (low > 0.0 || high < 0.0) {
                return None;
            }
            continue;
        }
        let (a, b) = (low * inverse[axis], high * inverse[axis]);
        enter = f64::max(enter, a.min(b) / WIDER);
        leave = f64::min(leave, a.max(b) * WIDER);
    }
    (enter <= leave).then_some(enter)
}
