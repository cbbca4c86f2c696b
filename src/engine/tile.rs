//! Rays of a picture, side by side.

use pulp::{Simd, WithSimd};

use crate::guard::{self, Reach};
use crate::num::{Bits, Float, Lanes, Real, V3};
use crate::rays::{Lens, Pixels};
use crate::seen::{Eye, Objects, Ray};

/// Rays that go side by side in f32, and in f64: as many bytes as the widest registers have.
const LANES_F32: usize = 16;
const LANES_F64: usize = 8;

/// The camera of a picture, in numbers of `F`, at the origin of coordinates. Its steps are half a pixel.
pub struct Camera<F> {
    forward: V3<F>,
    right_step: V3<F>,
    true_up_step: V3<F>,
    lens: Lens,
}

impl<F: Float> Camera<F> {
    /// That of `pixels`.
    pub fn new(pixels: &Pixels) -> Camera<F> {
        let view = &pixels.view;
        let step = view.h / f64::from(pixels.image_height);
        Camera {
            forward: V3::near(view.forward),
            right_step: V3::near(view.right * step),
            true_up_step: V3::near(view.true_up * step),
            lens: view.lens,
        }
    }

    /// Rays by twice their offsets from the picture's centre.
    #[inline(always)]
    pub fn ray<const N: usize>(&self, across: [F; N], up: [F; N]) -> Ray<Lanes<F, N>> {
        let right = V3::splat(self.right_step) * Lanes(across);
        let true_up = V3::splat(self.true_up_step) * Lanes(up);
        let (forward, zero) = (V3::splat(self.forward), V3([Lanes::lit(0.0); 3]));
        match self.lens {
            Lens::Perspective => Ray::new(zero, (forward + right) + true_up),
            Lens::Orthographic => Ray::new(right + true_up, forward),
        }
    }
}

/// The rays of a picture as objects' numbers in arithmetic with this unit ask for them. One of them stands for all within
/// `reach`.
pub fn eye_of(pixels: &Pixels, reach: Reach, unit: f64) -> Eye {
    Eye {
        reference: pixels.view.position,
        spread: pixels.spread(),
        input: guard::input_of(pixels.view.lens),
        reach,
        unit,
    }
}

/// Some rays, each by twice its offset from the picture's centre, and what they see.
#[derive(Default)]
pub struct Tile {
    across: Vec<f32>,
    up: Vec<f32>,
    /// As many as there are rays, after [`Tile::find_f32`] or [`Tile::find_f64`].
    pub ids: Vec<u32>,
}

impl Tile {
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

    /// Finds what they see in f32: ids, or [`crate::num::OPEN`].
    pub fn find_f32(&mut self, camera: &Camera<f32>, objects: &Objects<f32>) {
        pulp::Arch::new().dispatch(Find::<f32, LANES_F32> { camera, objects, tile: self });
    }

    /// The same in f64.
    pub fn find_f64(&mut self, camera: &Camera<f64>, objects: &Objects<f64>) {
        pulp::Arch::new().dispatch(Find::<f64, LANES_F64> { camera, objects, tile: self });
    }
}

/// A tile, compiled for each instruction set that the processor may have.
struct Find<'a, F: Float, const N: usize> {
    camera: &'a Camera<F>,
    objects: &'a Objects<F>,
    tile: &'a mut Tile,
}

impl<F: Float, const N: usize> WithSimd for Find<'_, F, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Find { camera, objects, tile: Tile { across, up, ids } } = self;
        let len = across.len();
        // The last ones stand for lanes that don't count.
        let padded = len.next_multiple_of(N);
        for numbers in [&mut *across, &mut *up] {
            let last = numbers.last().copied().unwrap_or(0.0);
            numbers.resize(padded, last);
        }
        ids.resize(padded, 0);
        let places = across.as_chunks::<N>().0.iter().zip(up.as_chunks::<N>().0);
        for ((across, up), ids) in places.zip(ids.as_chunks_mut::<N>().0) {
            let (mut i, mut j) = ([F::default(); N], [F::default(); N]);
            for lane in 0..N {
                i[lane] = F::near(f64::from(across[lane]));
                j[lane] = F::near(f64::from(up[lane]));
            }
            let (found, _) = objects.nearest(&camera.ray(i, j)).decide();
            for (id, found) in ids.iter_mut().zip(found.0) {
                *id = found.to_id();
            }
        }
        for numbers in [across, up] {
            numbers.truncate(len);
        }
        ids.truncate(len);
    }
}
