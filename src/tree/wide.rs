//! The tree for rays from anywhere: nodes of up to sixteen boxes, which a ray meets side by side.

use glam::DVec3;
use pulp::Simd;
use rayon::prelude::*;

use super::{IS_LEAF, Tree};
use crate::wide::{Holds, SideBySide, WideF32};

/// Most boxes of a node.
pub(super) const WIDTH: usize = 16;

/// As many numbers side by side.
type Lanes<T> = [T; WIDTH];

/// Boxes, and what is in each. Where there are fewer, the others are empty: no ray meets them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    low: [Lanes<f32>; 3],
    high: [Lanes<f32>; 3],
    /// The place of a sphere, with [`IS_LEAF`], or the number of a node.
    pub links: Lanes<u32>,
}

impl WideNode {
    const EMPTY: WideNode = WideNode {
        low: [[f32::INFINITY; WIDTH]; 3],
        high: [[f32::NEG_INFINITY; WIDTH]; 3],
        links: [IS_LEAF; WIDTH],
    };
}

/// The nodes.
#[derive(Clone, Debug)]
pub(super) struct Wide {
    pub nodes: Vec<WideNode>,
    pub root: usize,
}

/// Most bytes a sphere while the nodes are made: each has two boxes or more, and parts are put together
/// once they are made.
pub(super) const WIDE_BYTES: u64 = 2 * size_of::<WideNode>() as u64;

/// Nodes of a subtree that one thread widens at a time.
const PART: usize = 1 << 14;

impl Wide {
    /// Takes boxes from several levels of a tree together, the largest first.
    pub fn new(tree: &Tree) -> Wide {
        let (parts, above) = tree.cut(PART);
        let widen_part = |part: &std::ops::Range<usize>| {
            let mut nodes = Vec::new();
            widen(tree, part.start, |_| None, &mut nodes);
            nodes
        };
        let widened: Vec<Vec<WideNode>> = parts.par_iter().map(widen_part).collect();
        let mut nodes = Vec::with_capacity(widened.iter().map(Vec::len).sum());
        let mut firsts = Vec::with_capacity(parts.len());
        for part in widened {
            let first = nodes.len() as u32;
            firsts.push(first);
            nodes.extend(part.into_iter().map(|mut node| {
                let inner = node.links.iter_mut().filter(|link| **link & IS_LEAF == 0);
                inner.for_each(|link| *link += first);
                node
            }));
        }
        let mut root = 0;
        if !above.is_empty() {
            root = nodes.len();
            let part = |at: usize| parts.binary_search_by_key(&at, |part| part.start).ok();
            widen(tree, 0, |at| part(at).map(|part| firsts[part]), &mut nodes);
        }
        Wide { nodes, root }
    }

    /// Bytes of the nodes.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.nodes[..]) as u64
    }
}

/// Adds the nodes of a subtree, its root first; `done` gives the number of a node that there is
/// already for what is below `at`.
fn widen(tree: &Tree, root: usize, done: impl Fn(usize) -> Option<u32>, nodes: &mut Vec<WideNode>) {
    // The surface of an inner node's box; below 0 for what stays as it is.
    let area = |at: usize| {
        if tree.place(at).is_some() || done(at).is_some() {
            return -1.0;
        }
        let node = &tree.nodes[at];
        let [x, y, z] = std::array::from_fn(|k| node.high[k] - node.low[k]);
        x * y + y * z + z * x
    };
    nodes.push(WideNode::EMPTY);
    let mut open = vec![(root, nodes.len() - 1)];
    while let Some((at, number)) = open.pop() {
        let (mut below, mut areas, mut n_boxes) = ([at; WIDTH], [area(at); WIDTH], 1);
        while n_boxes < WIDTH {
            let largest = (1..n_boxes).fold(0, |a, b| if areas[b] > areas[a] { b } else { a });
            if areas[largest] < 0.0 {
                break;
            }
            let [first, second] = tree.children(below[largest]);
            (below[largest], areas[largest]) = (first, area(first));
            (below[n_boxes], areas[n_boxes]) = (second, area(second));
            n_boxes += 1;
        }
        let below = &below[..n_boxes];
        let mut wide = WideNode::EMPTY;
        for (lane, &at) in below.iter().enumerate() {
            let node = &tree.nodes[at];
            for axis in 0..3 {
                wide.low[axis][lane] = node.low[axis];
                wide.high[axis][lane] = node.high[axis];
            }
            wide.links[lane] = match (tree.place(at), done(at)) {
                (Some(place), _) => place as u32 | IS_LEAF,
                (None, Some(number)) => number,
                (None, None) => {
                    nodes.push(WideNode::EMPTY);
                    open.push((at, nodes.len() - 1));
                    nodes.len() as u32 - 1
                }
            };
        }
        nodes[number] = wide;
    }
}

/// A ray along one axis, in f32. What it enters first is a box's low side, or its high side where it
/// goes down.
///
/// With `u = 2⁻²⁴`, a slab `(c − o)·(1/d)` has these errors. Of the origin `o ± slack`: its rounding
/// to f32 and that of the sum, half a step each. A step of the largest component is at most `2u` of it,
/// which is [`SLACK`]; where the sum has wider steps, it is twice the step of the origin. So boxes only
/// become wider. Relative ones, of `u` each: the difference, the inverse, its widening, and
/// the product. They are 4 of the 6 that [`WIDER`] has, and of the 5 of [`NARROWER`]. Underflow takes
/// `2⁻¹⁴⁹` from a product, and the slack is at least `2⁻¹⁰⁰`, which the largest component of the
/// direction, below 2, can at most halve. Overflow gives the ∞ of the right sign, or boxes that are met
/// although they are not.
#[derive(Clone, Copy)]
pub(super) struct Slab {
    goes_down: bool,
    /// The origin, moved by the slack to meet the near side sooner and the far side later.
    near_origin: f32,
    far_origin: f32,
    /// `1/direction`, 0 where that is 0 or nearly so.
    near_inverse: f32,
    far_inverse: f32,
    /// True where the direction is 0.
    is_flat: bool,
}

/// Relative room of a slab.
const WIDER: f32 = 1.0 + 3.0 * f32::EPSILON;
const NARROWER: f32 = 1.0 - 2.5 * f32::EPSILON;

/// Room of the origin, relative to its largest component.
const SLACK: f32 = f32::EPSILON;

/// Components of a direction below this leave a slab only where it is not entered at all.
const FLAT: f64 = 1.0 / (1u128 << 100) as f64;

impl Slab {
    /// Of a ray that may lie up to this much beside the true one. The largest component of its direction
    /// is below 2.
    pub fn of(origin: DVec3, direction: DVec3, beside: f64) -> [Slab; 3] {
        const LEAST: f32 = 1.0 / (1u128 << 100) as f32;
        // The third digit is for the roundings of this sum.
        let slack = origin.abs().max_element() as f32 * SLACK + (1.001 * beside) as f32 + LEAST;
        std::array::from_fn(|axis| {
            let (origin, direction) = (origin[axis] as f32, direction[axis]);
            let goes_down = direction < 0.0;
            let slack_here = if goes_down { -slack } else { slack };
            let inverse = match direction.abs() > FLAT {
                true => (1.0 / direction) as f32,
                false => 0.0,
            };
            Slab {
                goes_down,
                near_origin: origin + slack_here,
                far_origin: origin - slack_here,
                near_inverse: inverse * NARROWER,
                far_inverse: inverse * WIDER,
                is_flat: direction == 0.0,
            }
        })
    }
}

/// Lower bounds of the `t ≥ 0` at which the ray enters boxes, and which of these it may hit up to
/// `t_max`, bit by bit.
#[inline(always)]
pub(super) fn enter<S: Simd>(
    simd: S,
    node: &WideNode,
    slabs: &[Slab; 3],
    t_max: f32,
) -> (Lanes<f32>, u32) {
    let n_lanes = WideF32::<S>::LANES.min(WIDTH);
    let (mut enters, mut hits) = ([0.0; WIDTH], 0);
    for first in (0..WIDTH).step_by(n_lanes) {
        let load = |side: &Lanes<f32>| WideF32::load(simd, &side[first..]);
        let zero = WideF32::splat(simd, 0.0);
        let (mut enter, mut leave) = (zero, zero.like(t_max));
        for (axis, slab) in slabs.iter().enumerate() {
            let (low, high) = (&node.low[axis], &node.high[axis]);
            if slab.near_inverse != 0.0 {
                let (near, far) = if slab.goes_down { (high, low) } else { (low, high) };
                let near =
                    (load(near) - zero.like(slab.near_origin)) * zero.like(slab.near_inverse);
                let far = (load(far) - zero.like(slab.far_origin)) * zero.like(slab.far_inverse);
                enter = enter.max(near);
                leave = leave.min(far);
            } else if slab.is_flat {
                let is_beside = zero
                    .like(slab.near_origin)
                    .lt(load(low))
                    .or(load(high).lt(zero.like(slab.far_origin)));
                leave = is_beside.select(zero.like(-1.0), leave);
            }
        }
        enter.store(&mut enters[first..]);
        hits |= enter.le(leave).bits() << first;
    }
    (enters, hits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;

    /// The rounding to nearest of f32.
    const UNIT: f64 = 1.0 / (1 << 24) as f64;

    /// The largest of what is needed for many numbers, most of them above a power of two by a little,
    /// where roundings cost most.
    fn worst(needed: impl Fn([f64; 3]) -> f64) -> f64 {
        let mut random = SplitMix::new(1180);
        let mut number = || {
            let most = [1.0, 0.3, 0.1, 0.02][(4.0 * random.unit()) as usize];
            2f64.powf((6.0 * random.unit() - 3.0).round()) * (1.0 + most * random.unit())
        };
        (0..8_000_000).map(|_| needed([number(), number(), number()])).fold(0.0, f64::max)
    }

    /// Half of the constant would not do.
    fn assert_tight(name: &str, constant: f64, found: f64) {
        println!("{name}: {found:.3} of {constant}");
        assert!(found <= constant && found > constant / 2.0, "{name}: {found} of {constant}");
    }

    /// The box's side and the ray's origin are exact in f32, and the origin so small that its own room
    /// doesn't count.
    #[test]
    fn the_relative_room_of_slabs() {
        let sides = |[side, origin, direction]: [f64; 3]| {
            let (side, origin) = (side as f32, (origin * 2f64.powi(-12)) as f32);
            let slab = Slab::of(DVec3::X * f64::from(origin), DVec3::X * direction, 0.0)[0];
            let exact = (f64::from(side) - f64::from(origin)) / direction;
            let near = f64::from((side - slab.near_origin) * slab.near_inverse);
            let far = f64::from((side - slab.far_origin) * slab.far_inverse);
            (near / exact, far / exact)
        };
        let room = |bound: f32| (f64::from(bound) - 1.0).abs() / UNIT;
        let later = |numbers| (sides(numbers).0 / f64::from(NARROWER) - 1.0) / UNIT;
        assert_tight("NARROWER", room(NARROWER), worst(later));
        let sooner = |numbers| (1.0 - sides(numbers).1 / f64::from(WIDER)) / UNIT;
        assert_tight("WIDER", room(WIDER), worst(sooner));
    }

    #[test]
    fn the_room_of_origins() {
        let room = f64::from(SLACK) / UNIT;
        let needed = |[origin, ..]: [f64; 3]| {
            let slab = Slab::of(DVec3::X * origin, DVec3::X, 0.0)[0];
            let near = f64::from(slab.near_origin) - origin;
            let far = origin - f64::from(slab.far_origin);
            room - near.min(far) / (UNIT * origin)
        };
        assert_tight("SLACK", room, worst(needed));
    }
}
