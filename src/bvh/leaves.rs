//! The spheres of a tree as an eye sees them in f32.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::{Bvh, prefetch};
use crate::guard::length_bounds;
use crate::num::fields::words;
use crate::num::{Lanes, Real, V3, dispatch};
use crate::scene::Sphere;
use crate::seen::{Eye, Nearest, Ray, SphereLeaf, is_near_surface};

/// Spheres that are looked at side by side.
const BLOCK: usize = 8;

/// A sphere of the tree as an eye sees it; no border of the memory's lines cuts it.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Leaf {
    seen: SphereLeaf<f32>,
    id: u32,
}

/// The spheres of a tree as an eye sees them in f32, by place.
pub struct Leaves {
    blocks: Vec<[Leaf; BLOCK]>,
    /// Ids of the spheres that each ray looks at beside the leaves, ascending: those that f32 has no box for, and those that the
    /// eye is so close to that a leaf says too little. The leaves of these are nowhere.
    pub rest: Vec<u32>,
}

impl Leaves {
    /// Bytes a sphere.
    pub const BYTES: usize = size_of::<Leaf>();

    /// Makes the leaves of a tree for an eye.
    pub fn new(bvh: &Bvh, eye: &Eye) -> Leaves {
        let (mut blocks, mut close) = (Vec::new(), Vec::new());
        let spheres = bvh.spheres.par_chunks(BLOCK).zip(bvh.ids.par_chunks(BLOCK));
        let see = |(spheres, ids)| dispatch(See { spheres, ids, eye });
        spheres.map(see).unzip_into_vecs(&mut blocks, &mut close);
        let mut rest = bvh.outside.clone();
        for (ids, close) in bvh.ids.chunks(BLOCK).zip(close) {
            if close.contains(&true) {
                let ids = ids.iter().zip(close).filter(|&(_, is_close)| is_close);
                rest.extend(ids.map(|(&id, _)| id));
            }
        }
        rest.sort_unstable();
        Leaves { blocks, rest }
    }

    /// Bytes of all.
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.blocks[..]) as u64
    }

    /// The leaves as devices take them.
    pub fn words(&self) -> Vec<[f32; 8]> {
        self.blocks.as_flattened().par_iter().map(|leaf| words(&leaf.seen)).collect()
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
    eye: &'a Eye,
}

impl WithSimd for See<'_> {
    /// Their leaves, and which of them the eye is close to.
    type Output = ([Leaf; BLOCK], [bool; BLOCK]);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let See { spheres, ids, eye } = self;
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
        let mut is_close = [false; BLOCK];
        // From elsewhere the size of a sphere hides no more than its own part of the distance.
        if eye.spread == 0.0 && eye.reach.apart == 0.0 {
            let distance = length_bounds(center);
            let near = is_near_surface(distance, r, distance);
            for lane in 0..spheres.len() {
                is_close[lane] = near.0[lane] != 0;
            }
        }
        let mut leaves = [Leaf { seen: SphereLeaf::nowhere(), id: 0 }; BLOCK];
        for lane in 0..spheres.len() {
            leaves[lane].id = ids[lane];
            if !is_close[lane] {
                leaves[lane].seen = seen.map(|x| x.0[lane]);
            }
        }
        (leaves, is_close)
    }
}
