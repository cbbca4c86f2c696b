//! The tree for rays from anywhere: nodes of up to sixteen boxes, which a ray meets side by side.

use std::ops::Range;

use bytemuck::{Zeroable, zeroed_vec};
use glam::DVec3;
use rayon::prelude::*;

use super::{IS_LEAF, Tree};
use crate::num::{LaneBits, Lanes, Real};

/// Most boxes of a node.
pub(super) const WIDTH: usize = 16;

/// Boxes, and what is in each. Where there are fewer, the others are empty: no ray meets them.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    low: [[f32; WIDTH]; 3],
    high: [[f32; WIDTH]; 3],
    /// The place of a sphere, with [`IS_LEAF`], or the number of a node.
    pub links: [u32; WIDTH],
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

/// Nodes of a subtree that one thread widens at a time.
const PART: usize = 1 << 14;

/// How many nodes there will be, found before there is room for them.
pub(super) struct WidePlan<'a> {
    tree: &'a Tree,
    parts: Vec<Range<usize>>,
    /// Where the nodes of each part begin, and where those above all parts do.
    firsts: Vec<usize>,
    n_nodes: usize,
}

impl<'a> WidePlan<'a> {
    /// Of boxes from several levels of a tree taken together, the largest first.
    pub fn new(tree: &'a Tree) -> WidePlan<'a> {
        let (parts, above) = tree.cut(PART);
        let count = |part: &Range<usize>| {
            let mut n_nodes = 0;
            widen(tree, part.start, &|_| None, |_, _| n_nodes += 1);
            n_nodes
        };
        let counts: Vec<usize> = parts.par_iter().map(count).collect();
        let mut n_nodes = 0;
        let mut firsts = Vec::with_capacity(parts.len() + 1);
        for count in counts {
            firsts.push(n_nodes);
            n_nodes += count;
        }
        firsts.push(n_nodes);
        let mut plan = WidePlan { tree, parts, firsts, n_nodes };
        if !above.is_empty() {
            let mut n_above = 0;
            widen(tree, 0, &|at| plan.part_at(at), |_, _| n_above += 1);
            plan.n_nodes += n_above;
        }
        plan
    }

    /// The number of the node that there is already for the subtree below a node of the tree.
    fn part_at(&self, at: usize) -> Option<usize> {
        let part = self.parts.binary_search_by_key(&at, |part| part.start).ok();
        part.map(|part| self.firsts[part])
    }

    /// Bytes of the nodes.
    pub fn bytes(&self) -> u64 {
        (self.n_nodes * size_of::<WideNode>()) as u64
    }

    /// The nodes.
    pub fn make(&self) -> Wide {
        let tree = self.tree;
        let mut nodes: Vec<WideNode> = zeroed_vec(self.n_nodes);
        let (below, above) = nodes.split_at_mut(self.firsts[self.parts.len()]);
        let mut left = below;
        let mut of_parts = Vec::with_capacity(self.parts.len());
        for (part, ends) in self.parts.iter().zip(self.firsts.windows(2)) {
            let (nodes, others) = left.split_at_mut(ends[1] - ends[0]);
            of_parts.push((part.start, ends[0], nodes));
            left = others;
        }
        of_parts.into_par_iter().for_each(|(root, first, nodes)| {
            widen(tree, root, &|_| None, |at, node| nodes[at] = node.numbered_from(first));
        });
        let first = self.firsts[self.parts.len()];
        let has_above = !above.is_empty();
        if has_above {
            // Below them are nodes of parts, whose numbers are what they are.
            let done = |at| self.part_at(at);
            widen(tree, 0, &done, |at, node| above[at] = node.numbered_from(first));
        }
        Wide { nodes, root: if has_above { first } else { 0 } }
    }
}

impl Wide {
    /// Bytes of the nodes.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.nodes[..]) as u64
    }
}

/// A node before all are numbered.
struct Below<'a> {
    tree: &'a Tree,
    /// The subtrees that it has the boxes of, and what these hold.
    below: &'a [(usize, Number)],
}

#[derive(Clone, Copy)]
enum Number {
    /// A sphere at this place.
    Sphere(u32),
    /// The node with this number, counted from the first one of all that are made together.
    Here(usize),
    /// One that there was before.
    Done(usize),
}

impl Below<'_> {
    fn numbered_from(&self, first: usize) -> WideNode {
        let mut wide = WideNode::EMPTY;
        for (lane, &(at, number)) in self.below.iter().enumerate() {
            let node = &self.tree.nodes[at];
            for axis in 0..3 {
                wide.low[axis][lane] = node.low[axis];
                wide.high[axis][lane] = node.high[axis];
            }
            wide.links[lane] = match number {
                Number::Sphere(place) => place | IS_LEAF,
                Number::Here(number) => (first + number) as u32,
                Number::Done(number) => number as u32,
            };
        }
        wide
    }
}

/// Hands over the nodes of a subtree with their numbers, its root first; `done` gives the number of a node that there is already
/// for what is below `at`. A subtree whose spheres fit into one node gets one, as long as others can be opened: nodes are fuller
/// so, and fewer.
fn widen(
    tree: &Tree,
    root: usize,
    done: &impl Fn(usize) -> Option<usize>,
    mut take: impl FnMut(usize, &Below),
) {
    let is_small = |at: usize| tree.after(at) - at < 2 * WIDTH;
    // The surface of an inner node's box; below 0 for what stays as it is.
    let area = |at: usize, opens_small: bool| {
        let stays = tree.place(at).is_some() || done(at).is_some();
        if stays || is_small(at) && !opens_small {
            return -1.0;
        }
        let node = &tree.nodes[at];
        let [x, y, z] = std::array::from_fn(|k| node.high[k] - node.low[k]);
        x * y + y * z + z * x
    };
    let (mut open, mut n_nodes) = (vec![(root, 0)], 1);
    while let Some((at, number)) = open.pop() {
        let opens_small = is_small(at);
        let area = |at| area(at, opens_small);
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
        let mut numbered = Vec::with_capacity(WIDTH);
        for &at in &below[..n_boxes] {
            numbered.push(match (tree.place(at), done(at)) {
                (Some(place), _) => (at, Number::Sphere(place as u32)),
                (None, Some(number)) => (at, Number::Done(number)),
                (None, None) => {
                    open.push((at, n_nodes));
                    n_nodes += 1;
                    (at, Number::Here(n_nodes - 1))
                }
            });
        }
        take(number, &Below { tree, below: &numbered });
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
#[derive(Clone, Copy, Debug, Default)]
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

/// Relative room of a slab. No test sees that of the far side halved: in f32 it rounds to the 4 that are needed.
const WIDER: f32 = 1.0 + 3.0 * f32::EPSILON;
const NARROWER: f32 = 1.0 - 2.5 * f32::EPSILON;

/// Room of the origin, relative to its largest component.
const SLACK: f32 = f32::EPSILON;

/// Components of a direction below this leave a slab only where it is not entered at all. No test sees it
/// halved: its inverse is far from the largest number.
const FLAT: f64 = 1.0 / (1u128 << 100) as f64;

impl Slab {
    /// Of a ray that may lie up to this much beside the true one. The largest component of its direction
    /// is below 2.
    pub fn of(origin: DVec3, direction: DVec3, beside: f64) -> [Slab; 3] {
        // No test sees it halved: it is `2⁴⁹` times what underflows.
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
pub(super) fn enter(node: &WideNode, slabs: &[Slab; 3], t_max: f32) -> ([f32; WIDTH], u32) {
    let all = Lanes::<f32, WIDTH>::splat;
    let (mut enter, mut leave) = (all(0.0), all(t_max));
    for (axis, slab) in slabs.iter().enumerate() {
        let (low, high) = (Lanes(node.low[axis]), Lanes(node.high[axis]));
        if slab.near_inverse != 0.0 {
            let (near, far) = if slab.goes_down { (high, low) } else { (low, high) };
            // What is not a number changes neither.
            enter = enter.max((near - all(slab.near_origin)) * all(slab.near_inverse));
            leave = leave.min((far - all(slab.far_origin)) * all(slab.far_inverse));
        } else if slab.is_flat {
            leave = Lanes::select(all(slab.near_origin).lt(low), all(-1.0), leave);
            leave = Lanes::select(high.lt(all(slab.far_origin)), all(-1.0), leave);
        }
    }
    (enter.0, bits(enter.le(leave)))
}

/// The bits of a mask, those of the first lane lowest. The mask goes through memory: joined into one number in registers,
/// all that it comes from would fall apart with it.
#[inline(always)]
fn bits(mask: LaneBits<f32, WIDTH>) -> u32 {
    let LaneBits(lanes) = std::hint::black_box(mask);
    let mut bits = 0;
    for (lane, mask) in lanes.iter().enumerate() {
        bits |= mask & 1 << lane;
    }
    bits
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
