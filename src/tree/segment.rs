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

/// What a segment still has to look at.
pub(crate) type Ahead = Vec<u32>;

impl Tree {
    /// Shows `visit` every sphere, by its place in [`Tree::order`], that the segment may meet, until
    /// it returns false. [`Tree::prepare_visits`] makes what this needs.
    pub fn visit_segment(&self, segment: &Segment, visit: impl FnMut(usize) -> bool) {
        pulp::Arch::new().dispatch(Walk { tree: self, segment, visit });
    }

    /// [`Tree::visit_segment`] for one segment of many; `ahead` is room that they share.
    #[inline(always)]
    pub(crate) fn walk_segment<S: pulp::Simd>(
        &self,
        simd: S,
        segment: &Segment,
        ahead: &mut Ahead,
        mut visit: impl FnMut(usize) -> bool,
    ) {
        let wide = self.wide();
        // With a largest component in 1..2, as slabs ask for, the end is at this power of two.
        let power = power_of_two_below(segment.way.abs().max_element());
        let slabs = Slab::of(segment.origin, segment.way / power, segment.slack);
        let end = if segment.is_endless { f32::INFINITY } else { round_up(power) };
        ahead.clear();
        if !(segment.origin.is_finite() && segment.slack.is_finite()) {
            // f64 can't say where it is.
            ahead.extend((0..self.order.len() as u32).map(|place| place | IS_LEAF));
        } else if !wide.nodes.is_empty() {
            ahead.push(wide.root as u32);
        }
        while let Some(link) = ahead.pop() {
            if link & IS_LEAF != 0 {
                if !visit((link & !IS_LEAF) as usize) {
                    return;
                }
                continue;
            }
            let node = &wide.nodes[link as usize];
            let (_, mut hit) = enter(simd, node, &slabs, end);
            while hit != 0 {
                ahead.push(node.links[hit.trailing_zeros() as usize]);
                hit &= hit - 1;
            }
        }
    }
}

/// A segment on its way, compiled for each instruction set that the processor may have.
struct Walk<'a, V> {
    tree: &'a Tree,
    segment: &'a Segment,
    visit: V,
}

impl<V: FnMut(usize) -> bool> pulp::WithSimd for Walk<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        self.tree.walk_segment(simd, self.segment, &mut Vec::with_capacity(64), self.visit);
    }
}

/// The power of two just not above a number, or the least normal one.
fn power_of_two_below(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE)
}
