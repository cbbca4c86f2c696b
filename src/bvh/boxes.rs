//! A hierarchy over the boxes of spheres, for rays from anywhere. The boxes are wide enough that
//! whatever rounds around them, no sphere is lost.
//!
//! Coordinates are relative to the reference point. A sphere at `L` with radius `r` gets the box
//! `[L_k − r − δ_k, L_k + r + δ_k]`, rounded outward to f32, with `δ_k` from
//! `2⁻²⁰(|L_k| + r) + 2⁻⁴⁰(‖L‖ + r)` to twice that; a node gets the union, which is exact.
//!
//! # What is needed of the margin
//! A ray's direction is that of the scene, times a power of two. So each slab is that of the exact ray
//! but for these roundings of `½·2⁻⁵²`: of `L_k`, of `L_k − r` and of the margin's subtraction, of the
//! widening by the slack (each of up to `|L_k| + r`), and of the origin, of its own size. Together
//! `2⁻⁵¹(|L_k| + r)`, `NEED`, and `2⁻⁵³` of the origin. What follows, the difference, the inverse
//! and the product, is relative and in `enter`'s `WIDER`.
//!
//! The margin is `2³¹` times that, because the builder needs boxes that f32 tells apart (see
//! [`super`]), and a wider margin costs nothing: half of it is seen by no test of a ray. A test looks at
//! the need itself.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use rayon::prelude::*;

use super::{build, spread};
use crate::control::Control;
use crate::error::Result;
use crate::guard::{round_down, round_up};

/// The hierarchy.
#[derive(Clone, Debug)]
pub struct Boxes {
    nodes: Vec<Bvh2Node>,
    /// Which sphere is at each place of the leaves: its index among those that the hierarchy was
    /// built over.
    pub order: Vec<u32>,
}

impl Boxes {
    /// Builds the hierarchy over spheres with these offsets from the reference point and these
    /// radii. There are at most [`super::MOST_SPHERES`], none farther than f32 reaches.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted)
    pub fn new(spheres: &[(DVec3, f64)], control: &Control) -> Result<Boxes> {
        if spheres.is_empty() {
            return Ok(Boxes { nodes: Vec::new(), order: Vec::new() });
        }
        let sphere_box = |(index, &(l, r)): (usize, &(DVec3, f64))| sphere_box(l, r, index);
        let boxes: Vec<Aabb> = spheres.par_iter().enumerate().map(sphere_box).collect();
        let binary = build(&boxes, control)?;
        Ok(Boxes { nodes: binary.nodes, order: binary.primitive_indices })
    }

    /// Bytes of the nodes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
    }
}

/// What rounds around a box, of `|L_k| + r`.
#[cfg(test)]
const NEED: f64 = 1.0 / (1u64 << 51) as f64;

/// The box of a sphere with the margin, up to twice as wide.
fn sphere_box(l: DVec3, r: f64, index: usize) -> Aabb {
    // Eight of f32's units, so that equal spheres get different boxes.
    const NEAR: f64 = 1.0 / (1u64 << 20) as f64;
    // The same where a component is 0 and the radius small.
    const FAR: f64 = 1.0 / (1u64 << 40) as f64;
    let margin = (l.abs() + r) * NEAR + FAR * (l.length() + r);
    let margin = margin * (1.0 + DVec3::from_array(spread(index)));
    let (low, high) = (l - r - margin, l + r + margin);
    Aabb::new(
        Vec3A::from_array(low.to_array().map(round_down)),
        Vec3A::from_array(high.to_array().map(round_up)),
    )
}

/// A ray in the hierarchy's frame, in f64.
#[derive(Clone, Copy, Debug)]
pub struct BoxesRay {
    /// Offset of the origin from the reference point.
    pub origin: DVec3,
    /// Direction.
    pub direction: DVec3,
}

impl Boxes {
    /// Shows `visit` every sphere, by its place in [`Boxes::order`], that the ray may hit at
    /// `0 < t ≤ t_max`, nearer boxes first. `visit` returns the `t_max` from then on.
    ///
    /// Slabs are computed in f64. The box's margin covers what rounds in its own size, and `2⁻⁴⁵` of the
    /// origin's distance what rounds in that.
    pub fn visit(&self, ray: &BoxesRay, mut visit: impl FnMut(usize) -> f64) {
        // 2⁸ times the rounding of the offset to the origin.
        const SLACK: f64 = 1.0 / (1u64 << 45) as f64;
        let slack = ray.origin.abs().max_element() * SLACK;
        let inverse = ray.direction.recip();
        let enter = |index: usize| enter(self.nodes[index].aabb(), ray, inverse, slack);
        let mut t_max = f64::INFINITY;
        let mut stack = Vec::new();
        if !self.nodes.is_empty() {
            stack.extend(enter(0).map(|t| (t, 0)));
        }
        while let Some((t, index)) = stack.pop() {
            if t > t_max {
                continue;
            }
            let node = &self.nodes[index];
            let first = node.first_index as usize;
            if node.is_leaf() {
                for place in first..first + node.prim_count as usize {
                    t_max = visit(place);
                }
                continue;
            }
            let base = stack.len();
            stack.extend([first, first + 1].into_iter().filter_map(|k| Some((enter(k)?, k))));
            stack[base..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        }
    }
}

/// A lower bound of the `t ≥ 0` at which the ray enters a box; `None` where it misses it.
fn enter(aabb: &Aabb, ray: &BoxesRay, inverse: DVec3, slack: f64) -> Option<f64> {
    // Three roundings, of the difference, of the inverse and of the product.
    const WIDER: f64 = 1.0 + 4.0 * f64::EPSILON;
    let (mut enter, mut leave) = (0.0, f64::INFINITY);
    for axis in 0..3 {
        let low = f64::from(aabb.min[axis]) - slack - ray.origin[axis];
        let high = f64::from(aabb.max[axis]) + slack - ray.origin[axis];
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;

    fn boxes(spheres: &[(DVec3, f64)]) -> Boxes {
        Boxes::new(spheres, &Control::default()).unwrap()
    }

    fn spheres(n: usize) -> Vec<(DVec3, f64)> {
        let mut random = SplitMix::new(610);
        let mut decades = |low: f64, high: f64| 10f64.powf(low + (high - low) * random.unit());
        (0..n)
            .map(|_| {
                let scale = decades(-3.0, 6.0);
                let l = DVec3::from_array(std::array::from_fn(|_| decades(-2.0, 1.0) - 1.0));
                (scale * l, scale * decades(-6.0, -1.0))
            })
            .collect()
    }

    #[test]
    fn equal_spheres_make_no_deep_tree() {
        let boxes = boxes(&[(DVec3::new(1e5, -3.0, 0.0), 2.0); 5000]);
        let mut deepest = 0;
        let mut open = vec![(0, 1)];
        while let Some((index, depth)) = open.pop() {
            let node = &boxes.nodes[index];
            deepest = deepest.max(depth);
            if !node.is_leaf() {
                let first = node.first_index as usize;
                open.extend([(first, depth + 1), (first + 1, depth + 1)]);
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

    /// The lower side of a slab without any margin, in the steps of `sphere_box` and `enter`: how far
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
        let spheres = spheres(2000);
        let boxes = boxes(&spheres);
        let mut seen = vec![0; spheres.len()];
        let mut open = vec![(0, boxes.nodes[0].aabb().min, boxes.nodes[0].aabb().max)];
        while let Some((index, low, high)) = open.pop() {
            let node = &boxes.nodes[index];
            let Aabb { min, max, .. } = *node.aabb();
            assert!(low.cmple(min).all() && max.cmple(high).all(), "node {index}");
            let first = node.first_index as usize;
            if !node.is_leaf() {
                open.extend([(first, min, max), (first + 1, min, max)]);
                continue;
            }
            for &sphere in &boxes.order[first..first + node.prim_count as usize] {
                let (l, r) = spheres[sphere as usize];
                seen[sphere as usize] += 1;
                for axis in 0..3 {
                    let margin = (l[axis].abs() + r) * 2f64.powi(-21);
                    assert!(f64::from(min[axis]) <= l[axis] - r - margin, "{sphere} {axis}");
                    assert!(f64::from(max[axis]) >= l[axis] + r + margin, "{sphere} {axis}");
                }
            }
        }
        assert!(seen.iter().all(|&times| times == 1));
    }
}
