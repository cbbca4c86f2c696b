//! Building the tree: spheres are halved along the widest axis until few are left, which a library
//! joins bottom-up by locality (PLOC, Meister & Bittner 2018). The runs are built side by side, and in
//! the caches; a run's own coordinates keep digits that those of the scene have not.

use std::time::Duration;

use bytemuck::zeroed_vec;
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ploc::PlocSearchDistance;

use rayon::prelude::*;

use super::{IS_LEAF, Node};
use crate::control::Control;
use crate::error::Result;
use crate::random::SplitMix;
use crate::scene::Sphere;

/// Spheres that are joined bottom-up. Fewer are joined in no less time a sphere, more in more.
const RUN: usize = 2048;

/// The nodes in depth-first order, and the index of the sphere at each place, of the `members` among
/// the spheres.
///
/// # Errors
/// [`crate::Error::Interrupted`]
pub(super) fn build(
    spheres: &[Sphere],
    reference: DVec3,
    members: Vec<u32>,
    control: &Control,
) -> Result<(Vec<Node>, Vec<u32>)> {
    let mut items: Vec<Item> = members
        .into_par_iter()
        .map(|index| {
            let at = (spheres[index as usize].center - reference).as_vec3().to_array();
            Item { at, index }
        })
        .collect();
    let mut order = vec![0; items.len()];
    let mut nodes = zeroed_vec((2 * items.len()).saturating_sub(1));
    let builder = Builder { spheres, reference, control };
    if !items.is_empty() {
        let part = Part { first_node: 0, first_place: 0, nodes: &mut nodes, order: &mut order };
        builder.halve(&mut items, part)?;
    }
    Ok((nodes, order))
}

/// A sphere's centre, roughly, and its index.
#[derive(Clone, Copy)]
struct Item {
    at: [f32; 3],
    index: u32,
}

/// The nodes and places of a subtree.
struct Part<'a> {
    first_node: usize,
    first_place: usize,
    nodes: &'a mut [Node],
    order: &'a mut [u32],
}

struct Builder<'a> {
    spheres: &'a [Sphere],
    reference: DVec3,
    control: &'a Control,
}

impl Builder<'_> {
    fn halve(&self, items: &mut [Item], part: Part) -> Result<()> {
        if items.len() <= RUN {
            self.control.check()?;
            self.join(items, part);
            return Ok(());
        }
        let (axis, middle) = (widest_axis(items), items.len() / 2);
        items.select_nth_unstable_by(middle, |a, b| a.at[axis].total_cmp(&b.at[axis]));
        let (low, high) = items.split_at_mut(middle);
        let Part { first_node, first_place, nodes, order } = part;
        let n_nodes = nodes.len();
        let (root, below) = nodes.split_at_mut(1);
        let (nodes_low, nodes_high) = below.split_at_mut(2 * middle - 1);
        let (order_low, order_high) = order.split_at_mut(middle);
        let second = first_node + 1 + nodes_low.len();
        let low_part =
            Part { first_node: first_node + 1, first_place, nodes: nodes_low, order: order_low };
        let high_part = Part {
            first_node: second,
            first_place: first_place + middle,
            nodes: nodes_high,
            order: order_high,
        };
        let (a, b) = rayon::join(|| self.halve(low, low_part), || self.halve(high, high_part));
        a.and(b)?;
        let (first, second) = (below[0], below[2 * middle - 1]);
        root[0] = Node::around(&first, &second, first_node + n_nodes);
        Ok(())
    }

    /// The subtree over few spheres.
    fn join(&self, items: &[Item], part: Part) {
        // The spheres themselves lie anywhere.
        let spheres: Vec<Sphere> =
            items.iter().map(|item| self.spheres[item.index as usize]).collect();
        let binary = join(&boxes(&spheres));
        let Part { first_node, first_place, nodes, order } = part;
        let (mut at, mut place) = (0, 0);
        let mut open = vec![0];
        while let Some(index) = open.pop() {
            let node = &binary.nodes[index];
            let first = node.first_index as usize;
            if node.is_leaf() {
                let which = binary.primitive_indices[first] as usize;
                let Sphere { center, radius } = spheres[which];
                nodes[at] = Node::leaf(center - self.reference, radius, first_place + place);
                order[place] = items[which].index;
                place += 1;
            } else {
                open.extend([first + 1, first]);
            }
            at += 1;
        }
        // A node that has no box yet is an inner one, and its children follow it.
        for at in (0..nodes.len()).rev() {
            if nodes[at].link & IS_LEAF != 0 {
                continue;
            }
            let first = nodes[at + 1];
            let second = after(&first, at + 1, first_node);
            let after = after(&nodes[second], second, first_node);
            nodes[at] = Node::around(&first, &nodes[second], first_node + after);
        }
    }
}

/// Boxes of the spheres in coordinates of their own, from −1 to 1. Boxes that f32 can't tell apart
/// would be joined one by one, in a time that grows with the square of their number, and to a deep
/// tree. So each is wider than its sphere by a little of its own.
fn boxes(spheres: &[Sphere]) -> Vec<Aabb> {
    // Eight of f32's units.
    const NEAR: f64 = 1.0 / (1u64 << 20) as f64;
    // The same where a component is 0 and the radius small.
    const FAR: f64 = 1.0 / (1u64 << 40) as f64;
    let (mut low, mut high, mut largest) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0);
    for &Sphere { center, radius } in spheres {
        (low, high) = (low.min(center), high.max(center));
        largest = f64::max(largest, radius.abs());
    }
    let middle = low / 2.0 + high / 2.0;
    let extent = (high / 2.0 - low / 2.0).max_element() + largest;
    let inverse = if extent.recip().is_finite() { extent.recip() } else { 1.0 };
    let sphere_box = |(which, &Sphere { center, radius }): (usize, &Sphere)| {
        let (l, r) = ((center - middle) * inverse, radius.abs() * inverse);
        let margin = (l.abs() + r) * NEAR + FAR * (l.length() + r);
        let reach = r + margin * (1.0 + spread(which));
        let corner = |v: DVec3| Vec3A::from_array(v.as_vec3().to_array());
        Aabb::new(corner(l - reach), corner(l + reach))
    };
    spheres.iter().enumerate().map(sphere_box).collect()
}

/// The binary tree over these boxes, with one in each leaf. Node 0 is the root.
fn join(boxes: &[Aabb]) -> Bvh2 {
    let parameters = BvhBuildParams {
        ploc_search_distance: PlocSearchDistance::VeryLow,
        // The nodes are counted on it.
        max_prims_per_leaf: 1,
        ..BvhBuildParams::fastest_build()
    };
    let mut build_time = Duration::ZERO;
    build_bvh2(boxes, parameters, &mut build_time)
}

/// A number in `0..1` for each axis, another one for each sphere.
fn spread(which: usize) -> DVec3 {
    let mut random = SplitMix::new(which as u64);
    DVec3::from_array(std::array::from_fn(|_| random.unit()))
}

/// What follows the subtree at `at` in a part, which is linked already.
fn after(node: &Node, at: usize, first_node: usize) -> usize {
    if node.link & IS_LEAF != 0 { at + 1 } else { node.link as usize - first_node }
}

fn widest_axis(items: &[Item]) -> usize {
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for item in items {
        for axis in 0..3 {
            low[axis] = low[axis].min(item.at[axis]);
            high[axis] = high[axis].max(item.at[axis]);
        }
    }
    let width = |&axis: &usize| high[axis] / 2.0 - low[axis] / 2.0;
    (0..3).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0)
}
