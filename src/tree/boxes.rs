//! The boxes of the tree, for rays from anywhere. They are wide enough that whatever rounds around
//! them, no sphere is lost.
//!
//! Coordinates are relative to the tree's reference point. A sphere at `L` with radius `r` gets the box
//! `[L_k − r − δ_k, L_k + r + δ_k]` with `δ_k = 2⁻⁴⁵(|L_k| + r)`, rounded outward to f32; a node gets
//! the union, which is exact.
//!
//! # What is needed of the margin
//! A ray's direction is that of the scene, times a power of two. So each slab is that of the exact ray
//! but for these roundings of `½·2⁻⁵²`: of `L_k`, of `L_k − r` and of the margin's subtraction, and one
//! in reserve (each of up to `|L_k| + r`). Together `2⁻⁵¹(|L_k| + r)`, `NEED`. What rounds in the ray
//! itself and in the slabs is in [`super::wide`]'s slack and in its `WIDER`.
//!
//! The margin is `2⁶` times that: hidden in f32's own outward rounding, it costs nothing, and half of it
//! is seen by no test of a ray. A test looks at the need itself.

use glam::DVec3;

use super::{IS_LEAF, Node};
use crate::guard::{round_down, round_up};

/// What rounds around a box, of `|L_k| + r`.
#[cfg(test)]
const NEED: f64 = 1.0 / (1u64 << 51) as f64;

/// The margin of a box, of `|L_k| + r`: `2⁶` times the need, so that no test sees it halved.
const MARGIN: f64 = 1.0 / (1u64 << 45) as f64;

impl Node {
    /// A leaf for the sphere at `l` from the reference point.
    pub(super) fn leaf(l: DVec3, radius: f64, place: usize) -> Node {
        let r = radius.abs();
        let margin = (l.abs() + r) * MARGIN;
        Node {
            low: (l - r - margin).to_array().map(round_down),
            high: (l + r + margin).to_array().map(round_up),
            link: place as u32 | IS_LEAF,
        }
    }

    /// An inner node; `after` is the node that follows its subtree.
    pub(super) fn around(first: &Node, second: &Node, after: usize) -> Node {
        Node {
            low: std::array::from_fn(|k| first.low[k].min(second.low[k])),
            high: std::array::from_fn(|k| first.high[k].max(second.high[k])),
            link: after as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;
    use crate::random::SplitMix;
    use crate::scene::Sphere;
    use crate::tree::Tree;

    fn tree(spheres: &[Sphere]) -> Tree {
        Tree::new(spheres, &Control::default()).unwrap()
    }

    fn spheres(n: usize) -> Vec<Sphere> {
        let mut random = SplitMix::new(610);
        let mut decades = |low: f64, high: f64| 10f64.powf(low + (high - low) * random.unit());
        (0..n)
            .map(|_| {
                let scale = decades(-3.0, 6.0);
                let l = DVec3::from_array(std::array::from_fn(|_| decades(-2.0, 1.0) - 1.0));
                Sphere { center: scale * l, radius: scale * decades(-6.0, -1.0) }
            })
            .collect()
    }

    #[test]
    fn equal_spheres_make_no_deep_tree() {
        let sphere = |i: u32| Sphere {
            // Different, but not in f32.
            center: DVec3::new(1e5, -3.0 + 1e-12 * f64::from(i), 0.0),
            radius: 2.0,
        };
        let tree = tree(&(0..5000).map(sphere).collect::<Vec<_>>());
        let mut deepest = 0;
        let mut open = vec![(0, 1)];
        while let Some((at, depth)) = open.pop() {
            deepest = deepest.max(depth);
            if tree.place(at).is_none() {
                open.extend(tree.children(at).map(|child| (child, depth + 1)));
            }
        }
        assert!(deepest < 500, "{deepest} levels");
    }

    /// What a two-sum gives: a difference and what it lost, exactly (Knuth).
    fn difference(a: f64, b: f64) -> (f64, f64) {
        let s = a - b;
        let part = s - a;
        (s, (a - (s - part)) - (b + part))
    }

    /// The lower side of a slab without any margin, in the steps of `Node::leaf`, and one more: how far
    /// it is above the exact one, as part of what is needed.
    #[test]
    fn the_need_of_a_margin() {
        let mut random = SplitMix::new(1103);
        let mut number = || {
            let mantissa = match random.unit() {
                u if u < 0.5 => 1.0 + (16.0 * random.unit()).floor() * f64::EPSILON,
                _ => 1.0 + random.unit(),
            };
            let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            sign * mantissa * 2f64.powf((6.0 * random.unit() - 3.0).round())
        };
        let mut worst = 0.0;
        for _ in 0..2_000_000 {
            let (center, reference, r) = (number(), number(), number().abs());
            let ((l, lost_l), tiny) = (difference(center, reference), number() * f64::EPSILON);
            let (low, lost_low) = difference(l, r);
            let (low, lost_margin) = difference(low, tiny);
            let (_, lost_slack) = difference(low, tiny);
            let lost = lost_l + lost_low + lost_margin + lost_slack;
            worst = f64::max(worst, lost.abs() / (NEED * (l.abs() + r)));
        }
        println!("{worst:.4} of what is said to be needed");
        assert!(worst <= 1.0 && worst > 0.5, "{worst}");
    }

    /// Each sphere is in one leaf, within the boxes of all nodes above, by the margin.
    #[test]
    fn boxes_hold_what_is_below_them() {
        for n in [1, 2, 3, 2047, 5000] {
            let spheres = spheres(n);
            let tree = tree(&spheres);
            assert_eq!((tree.n_nodes(), &tree.outside[..]), (2 * n - 1, &[][..]));
            let mut seen = vec![0; n];
            let mut open = vec![(0, [f32::MIN; 3], [f32::MAX; 3])];
            while let Some((at, low, high)) = open.pop() {
                let node = &tree.nodes[at];
                for axis in 0..3 {
                    assert!(low[axis] <= node.low[axis] && node.high[axis] <= high[axis], "{at}");
                }
                let Some(place) = tree.place(at) else {
                    open.extend(tree.children(at).map(|child| (child, node.low, node.high)));
                    continue;
                };
                let sphere = tree.order[place] as usize;
                seen[sphere] += 1;
                let (l, r) = (spheres[sphere].center - tree.reference, spheres[sphere].radius);
                for axis in 0..3 {
                    let margin = (l[axis].abs() + r) * 2f64.powi(-46);
                    assert!(f64::from(node.low[axis]) <= l[axis] - r - margin, "{sphere} {axis}");
                    assert!(f64::from(node.high[axis]) >= l[axis] + r + margin, "{sphere} {axis}");
                }
            }
            assert!(seen.iter().all(|&times| times == 1));
        }
    }

    /// Cut into subtrees, the tree still has each node once.
    #[test]
    fn parts_and_the_nodes_above_them_are_all_nodes() {
        let tree = tree(&spheres(3000));
        for most in [1, 7, 1000, 1 << 20] {
            let (parts, above) = tree.cut(most);
            assert!(
                parts.iter().all(|part| part.len() <= most && tree.after(part.start) == part.end)
            );
            let mut all: Vec<usize> = parts.into_iter().flatten().chain(above).collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..tree.n_nodes()));
        }
    }
}
