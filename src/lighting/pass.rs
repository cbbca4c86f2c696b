//! The light on pixels, in lanes: bounds of their colours in numbers of `F`, and what these say of what is written.
//!
//! Lanes are neighbouring pixels, and a pack of them has one sample of each; where spheres are many, samples that see one of them
//! are put side by side. A light goes through stages, each a small loop over packs in memory: how steep it falls, balls of the
//! points of each object that it may shine on, what is in the way of these balls, and what of that is in the way of the points.
//!
//! # Bounds
//! A colour is `c·(A + Σ wᵢgᵢ)` with the light `A` from nowhere, the lamps' weights and what is given of them between two
//! bounds. All of it is positive: relative to its sum, of `n` lamps, the numbers `c`, `A` and `w` are rounded once, products
//! and sums take `n + 2`, the sum of `s` samples `s`, the quotient by their number 2.5 on a device, and the bounds' factors 2:
//! `n + s +` [`OF_COLOR`] roundings, see [`of_roundings`]. What underflows in all that lamps give a point, a weight, a product and a sum
//! each, is below [`Float::TINY`]. A colour that is not normal in f32 makes less than `2⁻⁶⁰`, far below the smallest edge
//! between bytes.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

mod order;
mod shadows;

use pulp::{Simd, WithSimd};

use super::Background;

use super::lit::Job;
use super::occluders::{LightSource, Occluders};
use super::quantized::QuantizedPixels;
use crate::bounds::{LONGEST_IN_F32, length_bound};
use crate::bvh::Traversal;
use crate::error::Result;
use crate::num::{Float, LaneBits, Lanes, Mask, Real, V3, dispatch, one_by_one};
use crate::prepare::{CertifiedLamp, CertifiedLighting, PreparedLight};
use crate::scene::Linear;
use crate::shape::shadow::{Aim, Origin};
use crate::shape::{Bounds, LightBounds, Occlusion, ShadowRay};
use crate::support::control::Control;
use crate::surface::{Pack, Surfaces, is_id};
use order::SampleOrder;
use shadows::{PointGroup, ShadowWay};

/// Roundings of a colour beside one for each lamp and each sample. No test sees it cut: each cosine is granted as much, and
/// without lamps two roundings are left.
const OF_COLOR: f64 = 10.0;

/// How far the true sum of positive terms may be from one that took `n` roundings by `unit`, relative to that one; `None` where
/// it may be any. The computed sum is the true one times `1 + θ` with `|θ| ≤ γ = nu/(1 − nu)` (Higham 2002, Accuracy and
/// Stability of Numerical Algorithms, lemma 3.1). So the true one is off by at most `γ/(1 − γ) = nu/(1 − 2nu)` of it.
fn of_roundings(n: f64, unit: f64) -> Option<f64> {
    let first_order = n * unit;
    // No test sees the 2 halved: `nu/(1 − nu)` is above `(1 − u)⁻ⁿ − 1`, the worst there is.
    (first_order < 0.25).then(|| first_order / (1.0 - 2.0 * first_order))
}

/// A pixel whose colour the bounds leave open.
pub struct Open {
    /// Index of the pixel.
    pub pixel: usize,
    /// Bounds of its colour.
    pub bounds: [Bounds<f64>; 3],
    /// What is surely known of the lamps' light: of the pixel's samples in turn, for each lamp in turn.
    pub visibility: Vec<Visibility>,
}

/// What is surely known of a lamp's light on a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visibility {
    /// Nothing.
    Unknown,
    /// It gives nothing: something is in its way, or it comes from behind.
    Hidden,
    /// Nothing is in its way.
    ShapeRecord,
}

/// Light in numbers of `F`.
pub struct LightPass<'a, F: Float> {
    job: Job<'a>,
    occluders: &'a Occluders<'a>,
    pub surfaces: Surfaces<'a, F>,
    lighting: CertifiedLighting<F>,
}

/// Bounds of what a light gives to some samples.
#[derive(Clone, Copy, Default)]
pub(super) struct LightInterval<F: Float, const N: usize> {
    bounds: Bounds<Lanes<F, N>>,
    /// 1 where it is known that nothing is in its way, else 0.
    clear: Lanes<F, N>,
    /// Whether something may be in the way of what it gives to any.
    is_lit: bool,
}

impl<F: Float, const N: usize> LightInterval<F, N> {
    /// Takes away what something is surely, or perhaps, in the way of.
    #[inline(always)]
    fn take(&mut self, Occlusion { blocked, clear }: Occlusion<Lanes<F, N>>) {
        self.bounds = self.bounds.behind(&Occlusion { blocked, clear: clear.max(self.clear) });
    }

    fn visibility(&self, lane: usize) -> Visibility {
        let zero = F::default();
        if !zero.lt(self.bounds.high.0[lane]) {
            Visibility::Hidden
        } else if zero.lt(self.bounds.low.0[lane]) {
            Visibility::ShapeRecord
        } else {
            Visibility::Unknown
        }
    }
}

/// Bounds of the colours of some samples.
#[derive(Clone, Copy, Default)]
struct Shade<F: Float, const N: usize> {
    light: LightBounds<Lanes<F, N>>,
    /// Shadow rays that are looked along.
    n_rays: Lanes<F, N>,
    /// 1 where an object is seen, else 0.
    n_hits: Lanes<F, N>,
}

impl<F: Float, const N: usize> Shade<F, N> {
    /// Adds another one's numbers.
    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.light = self.light.plus(other.light);
        (self.n_rays, self.n_hits) = (self.n_rays + other.n_rays, self.n_hits + other.n_hits);
    }

    /// Takes a lane of another one into one of its own.
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, other: &Self, from: usize) {
        for channel in 0..3 {
            self.light.low.0[channel].0[lane] = other.light.low.0[channel].0[from];
            self.light.high.0[channel].0[lane] = other.light.high.0[channel].0[from];
        }
        self.n_rays.0[lane] = other.n_rays.0[from];
        self.n_hits.0[lane] = other.n_hits.0[from];
    }
}

/// What the pixels of a part go through, from part to part.
#[derive(Default)]
pub struct LightScratch<F: Float, const N: usize> {
    pixels: Vec<usize>,
    /// Index of the light that is looked at.
    light: usize,
    packs: Vec<Pack<F, N>>,
    order: SampleOrder<F, N>,
    /// What each light gives to all packs, by the light's index.
    given: Vec<Vec<LightInterval<F, N>>>,
    shades: Vec<Shade<F, N>>,
    groups: Vec<PointGroup>,
    /// Lanes that are in no group yet.
    left: Vec<LaneBits<F, N>>,
    /// Places of listed objects that may be in the way.
    places: Vec<usize>,
    ways: Vec<ShadowWay<F, N>>,
    walk: Traversal,
}

/// The pixels of a call, and where what is found of them goes.
pub struct PixelBlock<'a, C> {
    /// Indices of pixels,
    pub pixels: &'a [usize],
    /// and what is known of them already; nothing, or of each.
    pub known: &'a [Open],
    /// Takes the colours of pixels from this index on.
    pub first: usize,
    pub out: &'a mut [[C; 3]],
    /// Gets those that are left open.
    pub open: &'a mut Vec<Open>,
}

impl<'a> LightPass<'a, f32> {
    /// In f32; `None` where weights, colours or the rays' origins are out of its range.
    pub fn in_f32(job: Job<'a>, occluders: &'a Occluders<'a>) -> Option<LightPass<'a, f32>> {
        let Job { lit, samples, .. } = job;
        let are_in_range =
            samples.longest_direction() <= LONGEST_IN_F32 && samples.spread() <= f32::FARTHEST;
        if !are_in_range || !lit.suits_f32() {
            return None;
        }
        let surfaces = Surfaces::in_f32(&occluders.stage, samples.view.lens);
        let pass = LightPass::new(job, occluders, surfaces);
        (pass.lighting.width.low > 0.5 && pass.surfaces.are_known).then_some(pass)
    }

    /// The numbers of the pass, for a device; `None` where a light is so far away that squares leave the range.
    pub fn lighting(&self) -> Option<&CertifiedLighting> {
        let is_far = |light: &LightSource| match light.origin {
            Origin::Point(at) => length_bound(at) >= f32::LARGEST_ROOT,
            Origin::Sun(_) => false,
        };
        (!self.occluders.lights.iter().any(is_far)).then_some(&self.lighting)
    }
}

impl<'a> LightPass<'a, f64> {
    /// In f64.
    pub fn in_f64(job: Job<'a>, occluders: &'a Occluders<'a>) -> LightPass<'a, f64> {
        LightPass::new(job, occluders, Surfaces::in_f64(&occluders.stage))
    }
}

impl<'a, F: Linear> LightPass<'a, F> {
    fn new(
        job: Job<'a>,
        occluders: &'a Occluders<'a>,
        surfaces: Surfaces<'a, F>,
    ) -> LightPass<'a, F> {
        let lighting = &job.lit.lighting;
        let n_samples = job.n_samples() as u32;
        let n_terms = lighting.lamps.len() as f64 + f64::from(n_samples).powi(2);
        let width = of_roundings(n_terms + OF_COLOR, F::UNIT).unwrap_or(f64::INFINITY);
        let lamp = |(lamp, light): (&PreparedLight, &LightSource)| CertifiedLamp {
            aim: Aim::new(light.origin),
            weight: V3(lamp.weight.map(F::near)),
            casts_shadows: lamp.casts_shadows(),
            contacts: light.contacts.clone(),
        };
        let ambient = |sign: f64| {
            V3(lighting
                .ambient
                .map(|part| F::near((F::near(part).to_f64() + sign * F::TINY).max(0.0))))
        };
        let casts_shadows = lighting.lamps.iter().any(PreparedLight::casts_shadows);
        let lighting = CertifiedLighting {
            n_samples,
            background: V3(job.color(0).map(F::near)),
            occluders: if casts_shadows {
                Occluders::listed_in(occluders.prepared, &occluders.lights)
            } else {
                Vec::new()
            },
            lamps: lighting.lamps.iter().zip(&occluders.lights).map(lamp).collect(),
            ambient: LightBounds { low: ambient(-1.0), high: ambient(1.0) },
            width: Bounds { low: F::near(1.0 - width), high: F::near(1.0 + width) },
            lengths: surfaces.lengths,
        };
        LightPass { job, occluders, surfaces, lighting }
    }

    /// Finds the colours of some pixels, `N` of them together, and gives the number of shadow rays of those that are not left
    /// open.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn find<C: QuantizedPixels, const N: usize>(
        &self,
        mut part: PixelBlock<C>,
        control: &Control,
        scratch: &mut LightScratch<F, N>,
    ) -> Result<u64> {
        if part.pixels.is_empty() {
            return Ok(0);
        }
        scratch.pixels.clear();
        scratch.pixels.extend(part.pixels);
        dispatch(Load(self, scratch));
        if self.occluders.tree.is_some() {
            dispatch(Sort(self, scratch));
        }
        dispatch(See(self, scratch));
        dispatch(Gather(self, scratch));
        for (index, lamp) in self.lighting.lamps.iter().enumerate() {
            control.check()?;
            scratch.light = index;
            dispatch(Face(self, scratch));
            self.remember(part.known, scratch);
            if lamp.casts_shadows && scratch.given[index].iter().any(|given| given.is_lit) {
                dispatch(Occlude(self, scratch));
                if self.occluders.tree.is_some() {
                    dispatch(OccludeByTree(self, scratch));
                }
            }
        }
        dispatch(Tint(self, scratch));
        scratch.order.restore(&mut scratch.shades);
        Ok(dispatch(Write(self, scratch, &mut part)))
    }

    /// Puts samples of pixels into packs, and makes room for their light.
    #[inline(always)]
    fn load<const N: usize>(&self, scratch: &mut LightScratch<F, N>) {
        let LightScratch { pixels, packs, shades, given, .. } = scratch;
        let (n, row, ids) = (self.job.n_samples(), self.job.row(), self.job.ids);
        let n_packs = pixels.len().div_ceil(N) * n * n;
        shades.resize(n_packs, Shade::default());
        // The colours are written as a whole later.
        for shade in &mut *shades {
            shade.n_rays = Lanes::lit(0.0);
        }
        given.resize_with(self.lighting.lamps.len(), Vec::new);
        for given in given {
            given.resize(n_packs, LightInterval::default());
        }
        packs.resize_with(packs.len().max(n_packs), Pack::default);
        packs.truncate(n_packs);
        for (some, packs) in pixels.chunks(N).zip(packs.chunks_mut(n * n)) {
            // Of each pixel's first sample its index and twice its offset from the picture's centre.
            let (mut at, mut across, mut up) = ([0; N], [0.0; N], [0.0; N]);
            let is_stretch = is_stretch::<N>(some) && self.job.is_in_row(some[0], N);
            for lane in 0..N {
                if is_stretch && lane > 0 {
                    at[lane] = at[0] + lane * n;
                    (across[lane], up[lane]) = (across[0] + 2.0 * (lane * n) as f64, up[0]);
                    continue;
                }
                at[lane] = self.job.first_sample(some[lane.min(some.len() - 1)]);
                let (x, y) = self.job.samples.xy(at[lane]);
                let (i, j) = self.job.samples.offset2(x, y);
                (across[lane], up[lane]) = (i as f64, j as f64);
            }
            for (sample, pack) in packs.iter_mut().enumerate() {
                let (right, down) = (sample % n, sample / n);
                let ids = &ids[down * row + right..];
                if is_stretch && n == 1 {
                    pack.see(&ids[at[0]..][..N]);
                } else {
                    let mut seen = [0; N];
                    for lane in 0..N {
                        seen[lane] = ids[at[lane]];
                    }
                    pack.see(&seen);
                }
                let (right, down) = (2.0 * right as f64, 2.0 * down as f64);
                for lane in 0..N {
                    pack.offset[0].0[lane] = F::near(across[lane] + right);
                    pack.offset[1].0[lane] = F::near(up[lane] - down);
                }
            }
        }
    }

    /// Puts samples side by side that see one object.
    #[inline(always)]
    fn sort<const N: usize>(&self, scratch: &mut LightScratch<F, N>) {
        scratch.order.sort(&mut scratch.packs);
    }

    /// Finds the surfaces that samples see.
    #[inline(always)]
    fn see<const N: usize>(&self, scratch: &mut LightScratch<F, N>) {
        self.surfaces.solve(&mut scratch.packs);
    }

    /// What a light gives if nothing is in its way.
    #[inline(always)]
    fn face<const N: usize>(&self, scratch: &mut LightScratch<F, N>) {
        let LightScratch { light: index, packs, shades, given, .. } = scratch;
        let lamp = &self.lighting.lamps[*index];
        let aim = lamp.aim.map(Lanes::splat);
        let (zero, one) = (Lanes::lit(0.0), Lanes::lit(1.0));
        let (clear, of_rays) = if lamp.casts_shadows { (zero, one) } else { (one, zero) };
        for ((pack, shade), given) in one_by_one(&*packs).zip(shades).zip(&mut given[*index]) {
            let surface = &pack.surface;
            let rays = ShadowRay::new(&aim, surface.point, surface.point_error);
            let (low, high) = rays.cosine(surface.normal, surface.normal_error);
            let low = Lanes::select(surface.is_known(), low, zero);
            let high = Lanes::select(is_id(&pack.ids, 0), zero, high);
            shade.n_rays = shade.n_rays + Lanes::select(zero.lt(high), of_rays, zero);
            let is_lit = zero.lt(high).any();
            *given = LightInterval { bounds: Bounds { low, high }, clear, is_lit };
        }
    }

    /// Takes over what is known of a light already.
    fn remember<const N: usize>(&self, known: &[Open], scratch: &mut LightScratch<F, N>) {
        if known.is_empty() {
            return;
        }
        let (n_lamps, n_samples) = (self.lighting.lamps.len(), self.job.n_samples().pow(2));
        let LightScratch { light: index, given, order, .. } = scratch;
        let given = &mut given[*index];
        given.iter_mut().for_each(|given| given.is_lit = false);
        for at in 0..N * given.len() {
            let (pack, lane) = order.place(at);
            let (number, sample) = (at / N, at / N % n_samples);
            let given = &mut given[pack];
            let known = known.get(number / n_samples * N + at % N).map(|known| &known.visibility);
            // The last pixel is in all lanes behind it.
            match known.map_or(Visibility::Hidden, |all| all[sample * n_lamps + *index]) {
                Visibility::Unknown => given.is_lit = true,
                Visibility::Hidden => {
                    let Bounds { low, high } = &mut given.bounds;
                    (low.0[lane], high.0[lane]) = Default::default();
                }
                Visibility::ShapeRecord => given.clear.0[lane] = F::near(1.0),
            }
        }
    }

    /// Adds what all lights give, and takes it times the objects' own colours, which are looked up first.
    #[inline(always)]
    fn tint<const N: usize>(&self, scratch: &mut LightScratch<F, N>) {
        let LightScratch { packs, given, shades, .. } = scratch;
        let (zero, one) = (Lanes::<F, N>::lit(0.0), V3([Lanes::lit(1.0); 3]));
        for (pack, shade) in one_by_one(&*packs).zip(&mut *shades) {
            let [mut red, mut green, mut blue] = self.job.color(pack.ids[0]);
            let mut color = V3([Lanes::lit(red), Lanes::lit(green), Lanes::lit(blue)]);
            if pack.one().is_none() {
                for lane in 1..N {
                    if pack.ids[lane] != pack.ids[lane - 1] {
                        [red, green, blue] = self.job.color(pack.ids[lane]);
                    }
                    color.0[0].0[lane] = F::near(red);
                    color.0[1].0[lane] = F::near(green);
                    color.0[2].0[lane] = F::near(blue);
                }
            }
            // Its place until the light is there.
            shade.light.low = color;
        }
        for (number, (pack, shade)) in one_by_one(&*packs).zip(shades).enumerate() {
            let mut sum = self.lighting.ambient.map(Lanes::splat);
            for (lamp, given) in self.lighting.lamps.iter().zip(&*given) {
                sum = sum.with(V3::splat(lamp.weight), given[number].bounds);
            }
            let nothing = is_id(&pack.ids, 0);
            shade.n_hits = Lanes::select(nothing, zero, Lanes::lit(1.0));
            let LightBounds { low, high } = sum;
            let sum = LightBounds {
                low: V3::select(nothing, one, low),
                high: V3::select(nothing, one, high),
            };
            shade.light = sum.on(shade.light.low);
        }
    }

    /// Writes means of samples.
    #[inline(always)]
    fn write<C: QuantizedPixels, const N: usize>(
        &self,
        part: &mut PixelBlock<C>,
        scratch: &LightScratch<F, N>,
    ) -> u64 {
        let PixelBlock { pixels, first, out, open, .. } = part;
        let mut n_rays = 0;
        let n = self.job.n_samples();
        let background = self.job.color(0).map(C::of);
        let (zero, one) = (Lanes::<F, N>::lit(0.0), Lanes::lit(1.0));
        let width = self.lighting.width.map(Lanes::splat);
        let all = pixels.chunks(N).zip(scratch.shades.chunks(n * n));
        for (number, (pixels, shades)) in one_by_one(all).enumerate() {
            let mut sum = shades[0];
            for shade in &shades[1..] {
                sum.add(shade);
            }
            let n_counted = match self.job.lit.style.background {
                Background::LeftOut => sum.n_hits.max(one),
                Background::Shown | Background::Black => Lanes::lit((n * n) as f64),
            };
            let LightBounds { low, high } = sum.light.mean(n_counted, width);
            let (mut found, mut is_known) = ([[C::default(); 3]; N], [true; N]);
            for channel in 0..3 {
                let (numbers, are_known) = C::of_lanes(low.0[channel], high.0[channel]);
                for lane in 0..N {
                    found[lane][channel] = numbers[lane];
                    is_known[lane] &= are_known[lane];
                }
            }
            let (mut are_all_known, mut all_rays) = (true, 0.0);
            for lane in 0..N {
                let is_background = sum.n_hits.0[lane].le(zero.0[lane]);
                found[lane] = if is_background { background } else { found[lane] };
                is_known[lane] |= is_background;
                are_all_known &= is_known[lane];
                all_rays += sum.n_rays.0[lane].to_f64();
            }
            if are_all_known && is_stretch::<N>(pixels) {
                out[pixels[0] - *first..][..N].copy_from_slice(&found);
                n_rays += all_rays as u64;
                continue;
            }
            for (lane, &pixel) in pixels.iter().enumerate() {
                if is_known[lane] {
                    out[pixel - *first] = found[lane];
                    n_rays += sum.n_rays.0[lane].to_f64() as u64;
                } else {
                    let bounds = std::array::from_fn(|channel| Bounds {
                        low: low.0[channel].0[lane].to_f64(),
                        high: high.0[channel].0[lane].to_f64(),
                    });
                    let samples = number * n * n..(number + 1) * n * n;
                    let visibility = samples.flat_map(|pack| {
                        let (pack, lane) = scratch.order.place(pack * N + lane);
                        scratch.given.iter().map(move |given| given[pack].visibility(lane))
                    });
                    open.push(Open { pixel, bounds, visibility: visibility.collect() });
                }
            }
        }
        n_rays
    }
}

/// Whether these are `N` pixels side by side.
#[inline(always)]
fn is_stretch<const N: usize>(pixels: &[usize]) -> bool {
    let mut is_stretch = pixels.len() == N;
    for (lane, &pixel) in pixels.iter().enumerate() {
        is_stretch &= pixel == pixels[0] + lane;
    }
    is_stretch
}

/// Stages, compiled for each instruction set that the processor may have. In one function for all of them numbers no longer
/// stay in registers, and closures become calls.
macro_rules! stages {
    ($($stage:ident: $function:ident),+) => {$(
        struct $stage<'a, 'b, F: Float, const N: usize>(&'a LightPass<'b, F>, &'a mut LightScratch<F, N>);

        impl<F: Linear, const N: usize> WithSimd for $stage<'_, '_, F, N> {
            type Output = ();

            #[inline(always)]
            fn with_simd<S: Simd>(self, _: S) {
                self.0.$function(self.1);
            }
        }
    )+};
}

stages!(
    Load: load, Sort: sort, See: see, Gather: gather, Face: face, Occlude: occlude, OccludeByTree: occlude_by_tree, Tint: tint
);

/// The last stage, of the numbers that a picture has.
struct Write<'a, 'b, 'c, C, F: Float, const N: usize>(
    &'a LightPass<'b, F>,
    &'a LightScratch<F, N>,
    &'a mut PixelBlock<'c, C>,
);

impl<C: QuantizedPixels, F: Linear, const N: usize> WithSimd for Write<'_, '_, '_, C, F, N> {
    type Output = u64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> u64 {
        self.0.write(self.2, self.1)
    }
}

#[cfg(test)]
mod tests;
