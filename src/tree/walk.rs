//! Rays from anywhere on their way through the tree.

use glam::DVec3;
use pulp::Simd;

use super::wide::{Slab, WIDTH, Wide, enter};
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
    pub(crate) fn visit_all<C: Company>(&self, company: &mut C) {
        match self.wide().bytes() {
            ..CACHED_BYTES => self.visit_abreast::<1, C>(company),
            _ => self.visit_abreast::<ABREAST, C>(company),
        }
    }

    #[inline(always)]
    fn visit_abreast<const N: usize, C: Company>(&self, company: &mut C) {
        let wide = self.wide();
        let mut walkers: [Option<(C::Ray, Walker)>; N] = std::array::from_fn(|_| {
            let (ray, tree_ray) = company.next()?;
            Some((ray, Walker::new(wide, &tree_ray)))
        });
        let mut n_walking = walkers.iter().flatten().count();
        while n_walking > 0 {
            for slot in &mut walkers {
                let Some((ray, walker)) = slot else { continue };
                if let Some(place) = walker.awaited.take() {
                    walker.t_max = round_up(company.visit(ray, place));
                }
                match walker.step(wide) {
                    Step::Node => match walker.open.last().map(Open::link) {
                        Some(link) if link & IS_LEAF != 0 => {
                            prefetch(company.sphere((link & !IS_LEAF) as usize));
                        }
                        Some(link) => prefetch(&wide.nodes[link as usize]),
                        None => {}
                    },
                    Step::Sphere(place) => {
                        prefetch(company.sphere(place));
                        walker.awaited = Some(place);
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
    /// The sphere at a place, which will be visited soon.
    fn sphere(&self, place: usize) -> &Self::Sphere;
    /// Shows a ray the sphere at a place; returns its `t_max` from then on.
    fn visit(&mut self, ray: &mut Self::Ray, place: usize) -> f64;
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
    open: Vec<Open>,
    /// The place of a sphere that the memory was asked for.
    awaited: Option<usize>,
}

/// A node or a leaf, and a lower bound of the `t ≥ 0` at which a ray enters it: as one number, which is
/// larger where that is later.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Open(u64);

impl Open {
    #[inline(always)]
    fn new(t: f32, link: u32) -> Open {
        Open(u64::from(t.to_bits()) << 32 | u64::from(link))
    }

    #[inline(always)]
    fn t(&self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn link(&self) -> u32 {
        self.0 as u32
    }
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
            self.open.push(Open::new(0.0, wide.root as u32));
        }
    }

    #[inline(always)]
    fn step(&mut self, wide: &Wide) -> Step {
        let link = loop {
            match self.open.pop() {
                None => return Step::End,
                Some(open) if open.t() > self.t_max => {}
                Some(open) => break open.link(),
            }
        };
        if link & IS_LEAF != 0 {
            return Step::Sphere((link & !IS_LEAF) as usize);
        }
        let node = &wide.nodes[link as usize];
        let (enter, mut hit) = enter(node, &self.slabs, self.t_max);
        // The nearest one last, without a branch for what lies how.
        let (mut sorted, mut n_hit) = ([Open::default(); WIDTH], 0);
        while hit != 0 {
            let lane = hit.trailing_zeros() as usize;
            hit &= hit - 1;
            let mut nearer = Open::new(enter[lane], node.links[lane]);
            for other in &mut sorted[..n_hit] {
                (*other, nearer) = ((*other).max(nearer), (*other).min(nearer));
            }
            sorted[n_hit] = nearer;
            n_hit += 1;
        }
        self.open.extend_from_slice(&sorted[..n_hit]);
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
    fn with_simd<S: Simd>(self, _: S) {
        let Alone { tree, ray, mut visit } = self;
        let wide = tree.wide();
        let mut walker = Walker::new(wide, ray);
        loop {
            match walker.step(wide) {
                Step::Node => {}
                Step::Sphere(place) => walker.t_max = round_up(visit(place)),
                Step::End => return,
            }
        }
    }
}
