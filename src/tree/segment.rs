//! Which spheres a stretch of a ray may meet, in no order: for those who ask whether anything is in its
//! way.

use glam::DVec3;

use super::wide::{Slab, enter};
use super::{IS_LEAF, Tree};
use crate::guard::round_up;

/// `origin + s·way` for `0 ≤ s ≤ 1`, or for all `s ≥ 0`, in the tree's frame.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Offset of its start from the reference point.
    pub origin: DVec3,
    /// To its end.
    pub way: DVec3,
    /// Whether it goes on behind.
    pub is_endless: bool,
    /// How far the true one may lie beside it.
    pub slack: f64,
}

/// The way of a segment through a tree; made once for many.
#[derive(Debug, Default)]
pub(crate) struct Walk {
    slabs: [Slab; 3],
    end: f32,
    /// Links that it still has to look at.
    ahead: Vec<u32>,
}

impl Walk {
    /// Begins with a segment. [`Tree::prepare_visits`] makes what this needs.
    #[inline(always)]
    pub fn start(&mut self, tree: &Tree, segment: &Segment) {
        let Walk { slabs, end, ahead } = self;
        let wide = tree.wide();
        // With a largest component in 1..2, as slabs ask for, the end is at this power of two.
        let power = power_of_two_below(segment.way.abs().max_element());
        *slabs = Slab::of(segment.origin, segment.way / power, segment.slack);
        *end = if segment.is_endless { f32::INFINITY } else { round_up(power) };
        ahead.clear();
        if !(segment.origin.is_finite() && segment.slack.is_finite()) {
            // f64 can't say where it is.
            ahead.extend((0..tree.order.len() as u32).map(|place| place | IS_LEAF));
        } else if !wide.nodes.is_empty() {
            ahead.push(wide.root as u32);
        }
    }

    /// The place in [`Tree::order`] of the next sphere that the segment may meet.
    #[inline(always)]
    pub fn next(&mut self, tree: &Tree) -> Option<usize> {
        while let Some(link) = self.ahead.pop() {
            if link & IS_LEAF != 0 {
                return Some((link & !IS_LEAF) as usize);
            }
            let node = &tree.wide().nodes[link as usize];
            let (_, mut hit) = enter(node, &self.slabs, self.end);
            while hit != 0 {
                self.ahead.push(node.links[hit.trailing_zeros() as usize]);
                hit &= hit - 1;
            }
        }
        None
    }
}

impl Tree {
    /// Shows `visit` every sphere, by its place in [`Tree::order`], that the segment may meet, until
    /// it returns false. [`Tree::prepare_visits`] makes what this needs.
    pub fn visit_segment(&self, segment: &Segment, visit: impl FnMut(usize) -> bool) {
        pulp::Arch::new().dispatch(Visit { tree: self, segment, visit });
    }
}

/// All of a walk, compiled for each instruction set that the processor may have.
struct Visit<'a, V> {
    tree: &'a Tree,
    segment: &'a Segment,
    visit: V,
}

impl<V: FnMut(usize) -> bool> pulp::WithSimd for Visit<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        let mut walk = Walk::default();
        walk.start(self.tree, self.segment);
        while let Some(place) = walk.next(self.tree) {
            if !(self.visit)(place) {
                return;
            }
        }
    }
}

/// The power of two just not above a number, or the least normal one.
fn power_of_two_below(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE)
}
