//! What the rays of a list see in f32: side by side where objects are few, else each alone through the tree.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use glam::DVec3;
use pulp::{Simd, WithSimd};

use crate::bvh::{Beam, Bvh, Leaves, Traversal, Visitor};
use crate::num::{Bits, V3, dispatch};
use crate::prepare::{Hierarchy, Prepared};
use crate::rays::{self, List};
use crate::shape::{Nearest, Objects, Ray};

/// Rays that go side by side.
const LANES: usize = 16;

/// The objects as the rays of a list see them in f32.
pub struct ListSearch<'a> {
    prepared: &'a Prepared,
    /// The objects beside the tree, or all where there is none.
    beside: Objects<f32>,
}

impl<'a> ListSearch<'a> {
    /// For the rays that a scene is prepared for.
    pub fn new(prepared: &'a Prepared) -> ListSearch<'a> {
        let beside = Objects::new(prepared.listed(prepared.rest()), &prepared.eye);
        ListSearch { prepared, beside }
    }

    /// Finds what rays see in f32: ids, or [`UNDECIDED`](crate::num::UNDECIDED).
    pub fn look(&self, rays: &[rays::WorldRay], ids: &mut [u32]) {
        let list = List::new(rays, self.prepared.origins());
        dispatch(FindList { search: self, list, ids });
    }
}

/// Some rays, compiled for each instruction set that the processor may have.
struct FindList<'a> {
    search: &'a ListSearch<'a>,
    list: List<'a>,
    ids: &'a mut [u32],
}

impl WithSimd for FindList<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let FindList { search: ListSearch { beside, prepared }, list, ids } = self;
        match &prepared.hierarchy {
            None => {
                for (first, ids) in (0..).step_by(LANES).zip(ids.chunks_mut(LANES)) {
                    let (found, _) = beside.nearest(&list.load::<LANES>(first)).decide();
                    for (id, found) in ids.iter_mut().zip(found.0) {
                        *id = found.to_id();
                    }
                }
            }
            Some(hierarchy) => {
                let tree = OfTree { hierarchy, beside, list };
                let is_cached = hierarchy.bvh.bytes() < CACHED_BYTES;
                tree.find(if is_cached { 1 } else { ABREAST }, ids);
            }
        }
    }
}

/// Rays that walk at a time: while the memory brings what one needs, the others go on. Among 10⁶ spheres
/// that is two and a half times as fast as one after the other; more don't gain.
const ABREAST: usize = 8;

/// Trees of fewer bytes are in a processor's caches, where rays are as fast one after the other, and faster
/// where each goes the way of the one before.
const CACHED_BYTES: u64 = 4 << 20;

#[derive(Clone, Copy)]
struct OfTree<'a> {
    hierarchy: &'a Hierarchy,
    beside: &'a Objects<f32>,
    list: List<'a>,
}

/// A ray on its way.
struct SingleRayVisitor<'a> {
    leaves: &'a Leaves,
    ray: Ray<f32>,
    best: Nearest<f32>,
}

impl Visitor for SingleRayVisitor<'_> {
    #[inline(always)]
    fn last(&self) -> f32 {
        self.best.high()
    }

    #[inline(always)]
    fn expect(&self, place: u32) {
        self.leaves.expect(place);
    }

    #[inline(always)]
    fn see(&mut self, place: u32) {
        self.leaves.add(place, &self.ray, &mut self.best);
    }
}

impl<'a> OfTree<'a> {
    #[inline(always)]
    fn begin(&self, index: usize, walk: &mut Traversal) -> SingleRayVisitor<'a> {
        let OfTree { hierarchy: Hierarchy { bvh, leaves, .. }, beside, list } = *self;
        let (from, way) = list.ray(index);
        let ray = Ray::new(V3::lit(from), V3::lit(way));
        walk.begin_at_root(bvh, beam_of(bvh, list.rays[index].origin, way));
        SingleRayVisitor { leaves, ray, best: beside.nearest(&ray) }
    }

    /// `abreast` of them at a time.
    #[inline(always)]
    fn find(&self, abreast: usize, ids: &mut [u32]) {
        let bvh = &*self.hierarchy.bvh;
        let mut walks: [Traversal; ABREAST] = std::array::from_fn(|_| Traversal::default());
        let mut slots: [Option<(usize, SingleRayVisitor)>; ABREAST] = std::array::from_fn(|_| None);
        let (mut next, mut n_done) = (0, 0);
        while n_done < ids.len() {
            for (slot, walk) in slots[..abreast].iter_mut().zip(&mut walks) {
                if let Some((at, alone)) = slot {
                    if walk.step(bvh, alone) {
                        continue;
                    }
                    (ids[*at], _) = alone.best.decide();
                    n_done += 1;
                    *slot = None;
                }
                if next < ids.len() {
                    *slot = Some((next, self.begin(next, walk)));
                    next += 1;
                }
            }
        }
    }
}

/// The beam of a ray of a list, whose direction has a largest component in `1..2`.
#[inline(always)]
pub fn beam_of(bvh: &Bvh, origin: DVec3, direction: DVec3) -> Beam {
    let from = origin - bvh.reference;
    // The difference is rounded once.
    let room = from.abs() * f64::EPSILON;
    let origin = [from - room, from + room];
    Beam::new(origin, [direction; 2], bvh.end(origin))
}
