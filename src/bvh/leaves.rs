//! The spheres of a tree as an eye sees them in f32.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use bytemuck::Zeroable;
use pulp::{Simd, WithSimd};

use super::{Bvh, prefetch};
use crate::bounds::length_bounds;
use crate::num::fields::words;
use crate::num::{Lanes, Real, V3, dispatch};
use crate::scene::Sphere;
use crate::shape::{Nearest, Ray, RayOrigin, SphereLeaf, is_near_surface};
use crate::support::parallel;

/// Spheres that are looked at side by side.
const BLOCK: usize = 8;

/// Spheres that a thread takes at once.
const PER_PART: usize = 512 * BLOCK;

/// A sphere of the tree as an eye sees it; no border of the memory's lines cuts it.
#[derive(Clone, Copy, Zeroable)]
#[repr(C, align(32))]
struct Leaf {
    seen: SphereLeaf<f32>,
    id: u32,
}

/// The spheres of a tree as an eye sees them in f32, by place.
pub struct Leaves {
    blocks: Vec<[Leaf; BLOCK]>,
    /// Ids of the spheres that each ray tests in addition to the leaves, ascending: those outside of the tree, and those that the
    /// eye is so close to that a leaf says too little. The leaves of these are nowhere.
    pub rest: Vec<u32>,
}

impl Leaves {
    /// Bytes a sphere.
    pub const BYTES: usize = size_of::<Leaf>();

    /// Makes the leaves of a tree for an eye.
    pub fn new(bvh: &Bvh, eye: &RayOrigin) -> Leaves {
        let mut blocks = bytemuck::zeroed_vec(bvh.spheres.len().div_ceil(BLOCK));
        let spheres = bvh.spheres.chunks(PER_PART).zip(bvh.ids.chunks(PER_PART));
        let parts = blocks.chunks_mut(PER_PART / BLOCK).zip(spheres);
        let close = parallel::map(parts, |(blocks, (spheres, ids))| {
            dispatch(See { spheres, ids, eye, blocks })
        });
        let mut rest = [bvh.outside.clone(), close.concat()].concat();
        rest.sort_unstable();
        Leaves { blocks, rest }
    }

    /// Bytes of all.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.blocks[..]) as u64
    }

    /// The leaves as devices take them.
    pub fn words(&self) -> Vec<[f32; 8]> {
        let leaves = self.blocks.as_flattened();
        parallel::table(leaves.len(), |place| words(&leaves[place].seen))
    }

    /// Asks the memory for one.
    #[inline(always)]
    pub fn expect(&self, place: u32) {
        prefetch(self.leaf(place));
    }

    #[inline(always)]
    fn leaf(&self, place: u32) -> &Leaf {
        &self.blocks[place as usize / BLOCK][place as usize % BLOCK]
    }

    /// Takes one more sphere into account. False where no lane's ray meets it.
    #[inline(always)]
    pub fn add<R: Real<One = f32>>(&self, place: u32, ray: &Ray<R>, best: &mut Nearest<R>) -> bool {
        let Leaf { seen, id } = self.leaf(place);
        let next = seen.map(R::splat).bounds(ray);
        if let Some(next) = next {
            *best = best.with(next, R::splat_id(*id));
        }
        next.is_some()
    }
}

impl std::fmt::Debug for Leaves {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Leaves").field("rest", &self.rest).finish_non_exhaustive()
    }
}

/// Some spheres, compiled for each instruction set that the processor may have.
struct See<'a> {
    spheres: &'a [Sphere],
    ids: &'a [u32],
    eye: &'a RayOrigin,
    /// Their leaves.
    blocks: &'a mut [[Leaf; BLOCK]],
}

impl WithSimd for See<'_> {
    /// Ids of those that the eye is close to.
    type Output = Vec<u32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<u32> {
        let See { spheres, ids, eye, blocks } = self;
        // From elsewhere the size of a sphere hides no more than its own part of the distance.
        let is_one_point = eye.spread == 0.0 && eye.reach.apart == 0.0;
        let mut close = Vec::new();
        let parts = spheres.chunks(BLOCK).zip(ids.chunks(BLOCK));
        for (leaves, (spheres, ids)) in blocks.iter_mut().zip(parts) {
            let last = spheres.len() - 1;
            let (mut center, mut r) = (V3([Lanes::<f64, BLOCK>::lit(0.0); 3]), Lanes::lit(0.0));
            for lane in 0..BLOCK {
                let sphere = &spheres[lane.min(last)];
                for axis in 0..3 {
                    center.0[axis].0[lane] = sphere.center[axis] - eye.reference[axis];
                }
                r.0[lane] = sphere.radius.abs();
            }
            let seen = SphereLeaf::at::<f32>(center, r, eye).round_lanes();
            let distance = length_bounds(center);
            let near = is_near_surface(distance, r, distance);
            *leaves = [Leaf { seen: SphereLeaf::nowhere(), id: 0 }; BLOCK];
            for lane in 0..spheres.len() {
                leaves[lane].id = ids[lane];
                match is_one_point && near.0[lane] != 0 {
                    true => close.push(ids[lane]),
                    false => leaves[lane].seen = seen.map(|x| x.0[lane]),
                }
            }
        }
        close
    }
}
