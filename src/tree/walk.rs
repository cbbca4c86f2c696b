//! Rays from anywhere on their way through the tree.

use glam::DVec3;
use pulp::Simd;

use super::wide::{Slab, Wide, enter};
use super::{IS_LEAF, Tree};
use crate::guard::round_up;

/// A ray in the tree's frame.
#[derive(Clone, Copy, Debug)]
pub struct TreeRay {
    /// Offset of the origin from the reference point.
    pub origin: DVec3,
    /// Direction, with a largest component in `1..2`.
    pub direction: DVec3,
}

impl Tree {
    /// Shows `visit` every sphere, by its place in [`Tree::order`], that the ray may hit at
    /// `0 < t ≤ t_max`, nearer boxes first. `visit` returns the `t_max` from then on.
    pub fn visit(&self, ray: &TreeRay, visit: impl FnMut(usize) -> f64) {
        pulp::Arch::new().dispatch(Alone { tree: self, ray, visit });
    }

    /// The same for many rays.
    #[inline(always)]
    pub(crate) fn visit_all<S: Simd, C: Company>(&self, simd: S, company: &mut C) {
        match self.wide().bytes() {
            ..CACHED_BYTES => self.visit_abreast::<1, S, C>(simd, company),
            _ => self.visit_abreast::<ABREAST, S, C>(simd, company),
        }
    }

    #[inline(always)]
    fn visit_abreast<const N: usize, S: Simd, C: Company>(&self, simd: S, company: &mut C) {
        let wide = self.wide();
        let mut walkers: [Option<(C::Ray, Walker)>; N] = std::array::from_fn(|_| {
            let (ray, tree_ray) = company.next()?;
            Some((ray, Walker::new(wide, &tree_ray)))
        });
        let mut n_walking = walkers.iter().flatten().count();
        while n_walking > 0 {
            for slot in &mut walkers {
                let Some((ray, walker)) = slot else { continue };
                if let Some(index) = walker.awaited.take() {
                    walker.t_max = round_up(company.visit(ray, index));
                }
                match walker.step(simd, wide) {
                    Step::Node => match walker.open.last() {
                        Some(&(_, link)) if link & IS_LEAF != 0 => {
                            prefetch(&self.order[(link & !IS_LEAF) as usize]);
                        }
                        Some(&(_, link)) => prefetch(&wide.nodes[link as usize]),
                        None => {}
                    },
                    Step::Sphere(place) => {
                        let index = self.order[place];
                        prefetch(company.sphere(index));
                        walker.awaited = Some(index);
                    }
                    Step::End => {
                        company.finish(ray);
                        match company.next() {
                            Some((next, tree_ray)) => {
                                *ray = next;
                                walker.start(wide, &tree_ray);
                            }
                            None => {
                                *slot = None;
                                n_walking -= 1;
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Rays that walk at a time: while the memory brings what one needs, the others go on. Among 10⁶ spheres
/// that is two and a half times as fast as one after the other; more don't gain.
const ABREAST: usize = 8;

/// Nodes of fewer bytes are in a processor's caches, where rays are as fast one after the other, and faster
/// where each goes the way of the one before.
const CACHED_BYTES: u64 = 2 << 20;

/// Many rays, and what they look for.
pub(crate) trait Company {
    /// What is kept of a ray on its way.
    type Ray;
    /// What a sphere is looked at by.
    type Sphere;

    /// The next ray that sets out.
    fn next(&mut self) -> Option<(Self::Ray, TreeRay)>;
    /// The sphere with an index, which will be visited soon.
    fn sphere(&self, index: u32) -> &Self::Sphere;
    /// Shows a ray the sphere with an index; returns its `t_max` from then on.
    fn visit(&mut self, ray: &mut Self::Ray, index: u32) -> f64;
    /// A ray that has seen all that it may hit.
    fn finish(&mut self, ray: &mut Self::Ray);
}

/// Asks the memory for a value.
#[inline(always)]
fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for byte in (0..size_of::<T>()).step_by(CACHE_LINE) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let at = std::ptr::from_ref(value).cast::<i8>().wrapping_add(byte);
        // SAFETY: a hint, for which any address will do; each x86-64 processor has it.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(at);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// Bytes that come from the memory at once.
#[cfg(target_arch = "x86_64")]
const CACHE_LINE: usize = 64;

/// A ray on its way, and what it still has to look at: nodes and leaves, with lower bounds of the `t` at
/// which it enters them.
struct Walker {
    slabs: [Slab; 3],
    t_max: f32,
    open: Vec<(f32, u32)>,
    /// The index of a sphere that the memory was asked for.
    awaited: Option<u32>,
}

/// What a walker has come to.
enum Step {
    Node,
    /// A sphere that it may hit, by its place.
    Sphere(usize),
    End,
}

impl Walker {
    #[inline(always)]
    fn new(wide: &Wide, ray: &TreeRay) -> Walker {
        let slabs = Slab::of(ray.origin, ray.direction, 0.0);
        let open = Vec::with_capacity(64);
        let mut walker = Walker { slabs, t_max: f32::INFINITY, open, awaited: None };
        walker.start(wide, ray);
        walker
    }

    /// Sets out with another ray, at the root.
    #[inline(always)]
    fn start(&mut self, wide: &Wide, ray: &TreeRay) {
        self.slabs = Slab::of(ray.origin, ray.direction, 0.0);
        self.t_max = f32::INFINITY;
        self.open.clear();
        if !wide.nodes.is_empty() {
            self.open.push((0.0, wide.root as u32));
        }
    }

    #[inline(always)]
    fn step<S: Simd>(&mut self, simd: S, wide: &Wide) -> Step {
        let link = loop {
            match self.open.pop() {
                None => return Step::End,
                Some((t, _)) if t > self.t_max => {}
                Some((_, link)) => break link,
            }
        };
        if link & IS_LEAF != 0 {
            return Step::Sphere((link & !IS_LEAF) as usize);
        }
        let node = &wide.nodes[link as usize];
        let (enter, mut hit) = enter(simd, node, &self.slabs, self.t_max);
        let open = &mut self.open;
        let base = open.len();
        while hit != 0 {
            let lane = hit.trailing_zeros() as usize;
            hit &= hit - 1;
            // The nearest one last.
            let mut at = open.len();
            open.push((enter[lane], node.links[lane]));
            while at > base && open[at - 1].0 < open[at].0 {
                open.swap(at - 1, at);
                at -= 1;
            }
        }
        Step::Node
    }
}

/// One ray, compiled for each instruction set that the processor may have.
struct Alone<'a, V> {
    tree: &'a Tree,
    ray: &'a TreeRay,
    visit: V,
}

impl<V: FnMut(usize) -> f64> pulp::WithSimd for Alone<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Alone { tree, ray, mut visit } = self;
        let wide = tree.wide();
        let mut walker = Walker::new(wide, ray);
        loop {
            match walker.step(simd, wide) {
                Step::Node => {}
                Step::Sphere(place) => walker.t_max = round_up(visit(place)),
                Step::End => return,
            }
        }
    }
}
