//! Which spheres a stretch of a ray may meet, in no order: for those who ask whether anything is in its
//! way.

use glam::DVec3;

use super::wide::{Slab, enter};
use super::{IS_LEAF, Tree};

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

impl Tree {
    /// Shows `visit` every sphere, by its place in [`Tree::order`], that the segment may meet, until
    /// it returns false. [`Tree::prepare_visits`] makes what this needs.
    pub fn visit_segment(&self, segment: &Segment, visit: impl FnMut(usize) -> bool) {
        pulp::Arch::new().dispatch(Walk { tree: self, segment, visit });
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
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Walk { tree, segment, mut visit } = self;
        let wide = tree.wide();
        let slabs = Slab::new(segment.origin, segment.way, segment.slack);
        let end = if segment.is_endless { f64::INFINITY } else { 1.0 };
        let mut open = Vec::with_capacity(64);
        if !wide.nodes.is_empty() {
            open.push(wide.root as u32);
        }
        while let Some(link) = open.pop() {
            if link & IS_LEAF != 0 {
                if !visit((link & !IS_LEAF) as usize) {
                    return;
                }
                continue;
            }
            let node = &wide.nodes[link as usize];
            let (_, is_hit) = enter(node, &slabs, end);
            let links = node.links[..node.n_boxes].iter().zip(is_hit);
            open.extend(links.filter(|(_, is_hit)| *is_hit).map(|(link, _)| *link));
        }
    }
}
