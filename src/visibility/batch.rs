//! Rays of a picture, side by side.

use pulp::{Simd, WithSimd};

use crate::num::{Bits, Float, Lanes, dispatch};
use crate::rays::{Frame, Pixels};
use crate::shape::{LARGEST_T, Objects};

/// Rays that go side by side in f32, and in f64: as many bytes as the widest registers have.
const LANES_F32: usize = 16;
const LANES_F64: usize = 8;

/// Some rays, each by twice its offset from the picture's centre, and what they see.
#[derive(Default)]
pub struct RayBatch {
    across: Vec<f32>,
    up: Vec<f32>,
    /// What they see, as many as there are rays, after [`RayBatch::find_f32`] or [`RayBatch::find_f64`].
    pub ids: Vec<u32>,
}

/// Twice the offsets of rays that go together, to the right and to the top, and what they see.
pub type TilePacks<'a, const N: usize> = (&'a [[f32; N]], &'a [[f32; N]], &'a mut [[u32; N]]);

impl RayBatch {
    /// Forgets all rays.
    pub fn clear(&mut self) {
        self.across.clear();
        self.up.clear();
    }

    /// Adds one, at most 2²⁴ from the middle.
    #[inline(always)]
    pub fn push(&mut self, (across, up): (i64, i64)) {
        self.across.push(across as f32);
        self.up.push(up as f32);
    }

    /// Takes the samples of the pixels with these indices instead, `n` × `n` of each.
    pub fn take_samples(&mut self, pixels: &Pixels, n: u32, indices: &[u32]) {
        let samples = pixels.samples(n);
        self.clear();
        for &index in indices {
            let (x, y) = pixels.xy(index as usize);
            for y in y * n..(y + 1) * n {
                for x in x * n..(x + 1) * n {
                    self.push(samples.offset2(x, y));
                }
            }
        }
    }

    /// Adds some, as far from the middle.
    #[inline(always)]
    pub fn extend(&mut self, across: &[f32], up: &[f32]) {
        self.across.extend_from_slice(across);
        self.up.extend_from_slice(up);
    }

    /// Twice their offsets from the picture's centre, to the right and to the top, and what they see, `N` of them together. The
    /// last ones stand for lanes that don't count.
    #[inline(always)]
    pub fn packs<const N: usize>(&mut self) -> TilePacks<'_, N> {
        let RayBatch { across, up, ids } = self;
        let padded = across.len().next_multiple_of(N);
        for numbers in [&mut *across, &mut *up] {
            let last = numbers.last().copied().unwrap_or(0.0);
            numbers.resize(padded, last);
        }
        ids.resize(padded, 0);
        (across.as_chunks().0, up.as_chunks().0, ids.as_chunks_mut().0)
    }

    /// Finds what they see in f32: ids, or [`crate::num::UNDECIDED`].
    pub fn find_f32(&mut self, camera: &Frame<f32>, objects: &Objects<f32>) {
        let largest_t = LARGEST_T as f32;
        dispatch(FindInBatch::<f32, LANES_F32> { camera, objects, largest_t, tile: self });
    }

    /// Finds the ids of the objects that the rays see in f64, or [`crate::num::UNDECIDED`]. Hits beyond `largest_t` are left open.
    pub fn find_f64(&mut self, camera: &Frame<f64>, objects: &Objects<f64>, largest_t: f64) {
        dispatch(FindInBatch::<f64, LANES_F64> { camera, objects, largest_t, tile: self });
    }
}

/// A tile, compiled for each instruction set that the processor may have.
struct FindInBatch<'a, F: Float, const N: usize> {
    camera: &'a Frame<F>,
    objects: &'a Objects<F>,
    largest_t: F,
    tile: &'a mut RayBatch,
}

impl<F: Float, const N: usize> WithSimd for FindInBatch<'_, F, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let FindInBatch { camera, objects, largest_t, tile } = self;
        let largest_t = Lanes([largest_t; N]);
        let len = tile.across.len();
        let (across, up, ids) = tile.packs::<N>();
        for ((across, up), ids) in across.iter().zip(up).zip(ids) {
            let (mut i, mut j) = ([F::default(); N], [F::default(); N]);
            for lane in 0..N {
                i[lane] = F::near(f64::from(across[lane]));
                j[lane] = F::near(f64::from(up[lane]));
            }
            let nearest = objects.nearest(&camera.ray(Lanes(i), Lanes(j)));
            let (found, _) = nearest.decide_up_to(largest_t);
            for (id, found) in ids.iter_mut().zip(found.0) {
                *id = found.to_id();
            }
        }
        tile.ids.truncate(len);
    }
}
