//! The tree for rays from anywhere: nodes of up to eight boxes, which a ray meets side by side.

use glam::DVec3;
use rayon::prelude::*;

use super::{IS_LEAF, Tree};

/// Most boxes of a node.
const WIDTH: usize = 8;

/// Eight numbers side by side.
type Lanes<T> = [T; WIDTH];

/// Boxes, and what is in each.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct WideNode {
    low: [Lanes<f32>; 3],
    high: [Lanes<f32>; 3],
    /// The place of a sphere, with [`IS_LEAF`], or the number of a node.
    pub links: Lanes<u32>,
    pub n_boxes: usize,
}

impl WideNode {
    const EMPTY: WideNode =
        WideNode { low: [[0.0; WIDTH]; 3], high: [[0.0; WIDTH]; 3], links: [0; WIDTH], n_boxes: 0 };
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
        let mut wide = WideNode { n_boxes, ..WideNode::EMPTY };
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

/// A ray in the tree's frame.
#[derive(Clone, Copy, Debug)]
pub struct TreeRay {
    /// Offset of the origin from the reference point.
    pub origin: DVec3,
    /// Direction.
    pub direction: DVec3,
}

impl Tree {
    /// Shows `visit` every sphere, by its place in [`Tree::order`], that the ray may hit at
    /// `0 < t ≤ t_max`, nearer boxes first. `visit` returns the `t_max` from then on.
    ///
    /// Slabs are computed in f64. The box's margin covers what rounds in its own size, and `2⁻⁴⁵` of the
    /// origin's distance what rounds in that.
    #[inline(always)]
    pub fn visit(&self, ray: &TreeRay, visit: impl FnMut(usize) -> f64) {
        let slabs = Slab::new(ray.origin, ray.direction, 0.0);
        let walk = Walk { wide: self.wide(), slabs, visit };
        pulp::Arch::new().dispatch(walk);
    }
}

/// A ray along one axis.
#[derive(Clone, Copy)]
pub(super) struct Slab {
    origin: f64,
    slack: f64,
    direction: f64,
    /// `1/direction`
    inverse: f64,
}

impl Slab {
    /// Of a ray that may lie up to `slack` beside the true one.
    pub fn new(origin: DVec3, direction: DVec3, slack: f64) -> [Slab; 3] {
        // 2⁸ times the rounding of the offset to the origin.
        const SLACK: f64 = 1.0 / (1u64 << 45) as f64;
        let slack = slack + origin.abs().max_element() * SLACK;
        let inverse = direction.recip();
        std::array::from_fn(|axis| Slab {
            origin: origin[axis],
            slack,
            direction: direction[axis],
            inverse: inverse[axis],
        })
    }
}

/// A ray on its way, compiled for each instruction set that the processor may have.
struct Walk<'a, V> {
    wide: &'a Wide,
    slabs: [Slab; 3],
    visit: V,
}

impl<V: FnMut(usize) -> f64> pulp::WithSimd for Walk<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Walk { wide, slabs, mut visit } = self;
        let mut t_max = f64::INFINITY;
        let mut open = Vec::with_capacity(64);
        if !wide.nodes.is_empty() {
            open.push((0.0, wide.root as u32));
        }
        while let Some((t, link)) = open.pop() {
            if t > t_max {
                continue;
            }
            if link & IS_LEAF != 0 {
                t_max = visit((link & !IS_LEAF) as usize);
                continue;
            }
            let node = &wide.nodes[link as usize];
            let (enter, is_hit) = enter(node, &slabs, t_max);
            let base = open.len();
            for lane in 0..node.n_boxes {
                if is_hit[lane] {
                    // The nearest one last.
                    let farther = open[base..].iter().take_while(|(t, _)| *t > enter[lane]).count();
                    open.insert(base + farther, (enter[lane], node.links[lane]));
                }
            }
        }
    }
}

/// Lower bounds of the `t ≥ 0` at which the ray enters boxes, and which of these it may hit up to
/// `t_max`.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]
pub(super) fn enter(node: &WideNode, slabs: &[Slab; 3], t_max: f64) -> (Lanes<f64>, Lanes<bool>) {
    // Three roundings, of the difference, of the inverse and of the product.
    const WIDER: f64 = 1.0 + 4.0 * f64::EPSILON;
    const NARROWER: f64 = 1.0 - 4.0 * f64::EPSILON;
    let (mut enter, mut leave) = ([0.0; WIDTH], [t_max; WIDTH]);
    for (axis, &Slab { origin, slack, direction, inverse }) in slabs.iter().enumerate() {
        let (mut low, mut high) = ([0.0; WIDTH], [0.0; WIDTH]);
        for k in 0..WIDTH {
            low[k] = f64::from(node.low[axis][k]) - slack - origin;
            high[k] = f64::from(node.high[axis][k]) + slack - origin;
        }
        if inverse.is_finite() {
            for k in 0..WIDTH {
                let (a, b) = (low[k] * inverse, high[k] * inverse);
                let (near, far) = if a < b { (a, b) } else { (b, a) };
                let (near, far) = (near * NARROWER, far * WIDER);
                enter[k] = if near > enter[k] { near } else { enter[k] };
                leave[k] = if far < leave[k] { far } else { leave[k] };
            }
        } else if direction == 0.0 {
            // Along a direction this flat the slab is left only where it is not entered at all.
            for k in 0..WIDTH {
                leave[k] = if low[k] > 0.0 || high[k] < 0.0 { -1.0 } else { leave[k] };
            }
        }
    }
    (enter, std::array::from_fn(|k| enter[k] <= leave[k]))
}
