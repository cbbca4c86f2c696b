//! The light on pixels, in lanes: bounds of their colours in numbers of `F`, and what these say of what is written.
//!
//! Lanes are neighbouring pixels, and a pack of them has one sample of each. A light goes through stages, each a small loop
//! over packs in memory: how steep it falls, balls of the points of each object that it may shine on, what is in the way of
//! these balls, and what of that is in the way of the points.
//!
//! # Bounds
//! A colour is `c·(A + Σ wᵢgᵢ)` with the light `A` from nowhere, the lamps' weights and what is given of them between two
//! bounds. All of it is positive: relative to its sum, of `n` lamps, the numbers `c`, `A` and `w` are rounded once, products
//! and sums take `n + 2`, the sum of `s` samples `s`, the quotient by their number 1, and the bounds' factors 2: `n + s +`
//! [`OF_COLOR`] roundings, see [`of_roundings`]. What underflows in all that lamps give a point, a weight, a product and a sum
//! each, is below [`Float::TINY`]. A colour that is not normal in f32 makes less than `2⁻⁶⁰`, far below the smallest edge
//! between bytes.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use glam::DVec3;
use pulp::{Simd, WithSimd};

use super::Background;
use super::lit::Job;
use super::occluders::Occluders;
use super::written::{Interval, Written};
use crate::bvh::{Bvh, Corners, Enter, Node, Visitor, Walk};
use crate::certify::{Pack, Surfaces, is_id};
use crate::guard::LONGEST_IN_F32;
use crate::guard::host::Bounded;
use crate::num::{Float, LaneBits, Lanes, Mask, Real, V3, one_by_one};
use crate::rays::Pixels;
use crate::scene::Linear;
use crate::seen::shadow::{Aim, Origin};
use crate::seen::{Bounds, Met, ShadowRay, SphereMet, Surface, Verdict};
use crate::seen::{Occluder, Record};

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
    /// Its index.
    pub pixel: usize,
    /// Bounds of its colour.
    pub bounds: [Interval; 3],
    /// Of its samples in turn, for each lamp in turn.
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
    Seen,
}

/// A lamp's light.
struct Light<F> {
    origin: Origin,
    weight: V3<F>,
    casts_shadows: bool,
}

/// Light in numbers of `F`.
pub struct Pass<'a, F: Float> {
    job: Job<'a>,
    occluders: &'a Occluders<'a>,
    samples: &'a Pixels,
    pub surfaces: Surfaces<'a, F>,
    /// [`Occluders::listed_in`]
    listed: Vec<Met<F>>,
    lights: Vec<Light<F>>,
    /// Bounds of the light from nowhere.
    ambient: Bounds<V3<F>>,
    /// What a colour is off by, relative.
    width: f64,
}

/// Bounds of what a light gives to some samples.
#[derive(Clone, Copy)]
struct Given<F: Float, const N: usize> {
    low: Lanes<F, N>,
    high: Lanes<F, N>,
    /// 1 where a shadow ray is to be looked along, −1 where it is known that nothing is in its way, else 0.
    asked: Lanes<F, N>,
    /// Whether something may be in the way of what it gives to any.
    is_lit: bool,
}

impl<F: Float, const N: usize> Given<F, N> {
    fn none() -> Self {
        let zero = Lanes::lit(0.0);
        Given { low: zero, high: zero, asked: zero, is_lit: false }
    }

    /// Takes away what something is surely, or perhaps, in the way of.
    #[inline(always)]
    fn take(&mut self, verdict: &Verdict<Lanes<F, N>>) {
        let zero = Lanes::lit(0.0);
        self.low = Lanes::select(zero.lt(verdict.clear.max(-self.asked)), self.low, zero);
        self.high = Lanes::select(zero.lt(verdict.blocked), zero, self.high);
    }

    fn visibility(&self, lane: usize) -> Visibility {
        let zero = F::default();
        match zero.lt(self.high.0[lane]) {
            false => Visibility::Hidden,
            true if zero.lt(self.low.0[lane]) => Visibility::Seen,
            true => Visibility::Unknown,
        }
    }
}

/// The ways from some samples to a light.
struct Way<F: Float, const N: usize> {
    rays: ShadowRay<Lanes<F, N>>,
    verdict: Verdict<Lanes<F, N>>,
    /// Positive where it is not known to be dark.
    asked: Lanes<F, N>,
}

impl<F: Float, const N: usize> Way<F, N> {
    /// Whether one of these lanes is not known to be dark.
    #[inline(always)]
    fn is_open(&self, lanes: Lanes<F, N>) -> bool {
        Lanes::lit(0.0).lt(lanes.min(self.asked)).any()
    }
}

/// Bounds of the colours of some samples.
#[derive(Clone, Copy)]
struct Shade<F: Float, const N: usize> {
    /// The objects' own.
    color: V3<Lanes<F, N>>,
    low: V3<Lanes<F, N>>,
    high: V3<Lanes<F, N>>,
    /// Shadow rays that are looked along.
    n_rays: Lanes<F, N>,
    /// 1 where an object is seen, else 0.
    n_hits: Lanes<F, N>,
}

impl<F: Float, const N: usize> Shade<F, N> {
    fn none() -> Self {
        let (zero, none) = (Lanes::lit(0.0), V3([Lanes::lit(0.0); 3]));
        Shade { color: none, low: none, high: none, n_rays: zero, n_hits: zero }
    }

    /// Adds another one's numbers, but for the object's colour.
    #[inline(always)]
    fn add(&mut self, other: &Self) {
        (self.low, self.high) = (self.low + other.low, self.high + other.high);
        (self.n_rays, self.n_hits) = (self.n_rays + other.n_rays, self.n_hits + other.n_hits);
    }
}

/// Packs at least whose points of an object share a walk through the tree, which lie below each other: with more the beams
/// get wide, with fewer there are more of them.
const TOGETHER: usize = 4;

/// Points of one object, lane by lane.
#[derive(Clone, Copy)]
struct Extent<F: Float, const N: usize> {
    id: u32,
    low: V3<Lanes<F, N>>,
    high: V3<Lanes<F, N>>,
    error: Lanes<F, N>,
    /// 1 where some are seen from inside.
    back: Lanes<F, N>,
}

/// A ball around points of one object.
struct Ball {
    id: u32,
    /// Whether some are seen from inside.
    has_back: bool,
    middle: V3<f64>,
    reach: f64,
}

impl<F: Float, const N: usize> Extent<F, N> {
    #[inline(always)]
    fn none(id: u32) -> Self {
        let (beyond, zero) = (V3([Lanes::lit(F::BEYOND); 3]), Lanes::lit(0.0));
        Extent { id, low: beyond, high: -beyond, error: zero, back: zero }
    }

    #[inline(always)]
    fn add(&mut self, is_in: LaneBits<F, N>, surface: &Surface<Lanes<F, N>>) {
        self.low = V3::select(is_in, self.low.min(surface.point), self.low);
        self.high = V3::select(is_in, self.high.max(surface.point), self.high);
        self.error = Lanes::select(is_in, self.error.max(surface.point_error), self.error);
        let back = Lanes::select(surface.front, Lanes::lit(0.0), Lanes::lit(1.0));
        self.back = Lanes::select(is_in, self.back.max(back), self.back);
    }

    /// Corners of a box around all true points.
    #[inline(always)]
    fn corners(&self) -> Corners {
        let (mut corners, error) = ([DVec3::ZERO; 2], most(self.error));
        for axis in 0..3 {
            let (low, high) = (-most(-self.low.0[axis]), most(self.high.0[axis]));
            // No test sees the roundings of these sums, which the beam has room for.
            (corners[0][axis], corners[1][axis]) = (low - error, high + error);
        }
        corners
    }

    /// From the middle of all lanes the true points are as far as half a diagonal of their box, the middle's own rounding, and
    /// the largest error.
    #[inline(always)]
    fn ball(&self) -> Ball {
        let (mut middle, mut half) = (V3([0.0; 3]), V3([0.0; 3]));
        for axis in 0..3 {
            let (low, high) = (-most(-self.low.0[axis]), most(self.high.0[axis]));
            half.0[axis] = (high - low) * 0.5;
            middle.0[axis] = low + half.0[axis];
        }
        // No test sees it halved: the unit is two roundings.
        let rounding = f64::UNIT * middle.dot(middle).sqrt();
        let reach = 1.01 * half.dot(half).sqrt() + rounding + most(self.error);
        Ball { id: self.id, has_back: most(self.back) > 0.0, middle, reach }
    }
}

impl Ball {
    /// The ways from its points to a light.
    #[inline(always)]
    fn shadow_ray(&self, origin: Origin) -> ShadowRay<f64> {
        ShadowRay::new(&Aim::new(origin), self.middle, self.reach)
    }
}

/// The largest of all lanes.
#[inline(always)]
fn most<F: Float, const N: usize>(lanes: Lanes<F, N>) -> f64 {
    let mut most = lanes.0[0];
    for lane in 1..N {
        most = most.max(lanes.0[lane]);
    }
    most.to_f64()
}

/// What the pixels of a part go through, from part to part.
#[derive(Default)]
pub struct Scratch<F: Float, const N: usize> {
    packs: Vec<Pack<F, N>>,
    /// Of each light in turn for all packs.
    given: Vec<Given<F, N>>,
    shades: Vec<Shade<F, N>>,
    boxes: Vec<Extent<F, N>>,
    balls: Vec<Ball>,
    /// Places of listed objects that may be in the way.
    places: Vec<usize>,
    /// 1 where a point of a pack is still to be looked at through the tree, else 0.
    left: Vec<Lanes<F, N>>,
    ways: Vec<Way<F, N>>,
    walk: Walk,
    /// Whether the light shines on anything.
    is_lit: bool,
}

/// The pixels of a call, and where what is found of them goes.
pub struct Part<'a, T> {
    /// Indices of pixels,
    pub pixels: &'a [usize],
    /// and what is known of them already; nothing, or of each.
    pub known: &'a [Open],
    /// Takes the colours of pixels from this index on.
    pub first: usize,
    pub out: &'a mut [T],
    /// Gets those that are left open.
    pub open: &'a mut Vec<Open>,
    /// Counts shadow rays of pixels that are not.
    pub n_rays: &'a mut u64,
}

impl<'a> Pass<'a, f32> {
    /// In f32; `None` where weights, colours or the rays' origins are out of its range.
    pub fn in_f32(
        job: Job<'a>,
        occluders: &'a Occluders<'a>,
        samples: &'a Pixels,
    ) -> Option<Pass<'a, f32>> {
        let are_in_range =
            samples.longest_direction() <= LONGEST_IN_F32 && samples.spread() <= f32::FARTHEST;
        if !are_in_range || !job.lit.suits_f32() {
            return None;
        }
        let surfaces = Surfaces::in_f32(&occluders.stage, samples.view.lens);
        let pass = Pass::new(job, occluders, samples, surfaces);
        (pass.width < 0.5 && pass.surfaces.are_known()).then_some(pass)
    }
}

impl<'a> Pass<'a, f64> {
    /// In f64.
    pub fn in_f64(
        job: Job<'a>,
        occluders: &'a Occluders<'a>,
        samples: &'a Pixels,
    ) -> Pass<'a, f64> {
        let surfaces = Surfaces::in_f64(&occluders.stage);
        Pass::new(job, occluders, samples, surfaces)
    }
}

impl<'a, F: Bounded + Linear> Pass<'a, F> {
    fn new(
        job: Job<'a>,
        occluders: &'a Occluders<'a>,
        samples: &'a Pixels,
        surfaces: Surfaces<'a, F>,
    ) -> Pass<'a, F> {
        let lighting = &job.lit.lighting;
        let n_terms = lighting.lamps.len() as f64 + f64::from(job.n_samples() as u32).powi(2);
        let lights = lighting.lamps.iter().zip(&occluders.origins).map(|(lamp, &origin)| Light {
            origin,
            weight: V3(lamp.weight.map(F::near)),
            casts_shadows: lamp.casts_shadows(),
        });
        let ambient = |sign: f64| {
            V3(lighting
                .ambient
                .map(|part| F::near((F::near(part).to_f64() + sign * F::TINY).max(0.0))))
        };
        Pass {
            lights: lights.collect(),
            listed: occluders.listed_in(),
            ambient: Bounds { low: ambient(-1.0), high: ambient(1.0) },
            width: of_roundings(n_terms + OF_COLOR, F::ROUNDING).unwrap_or(f64::INFINITY),
            job,
            occluders,
            samples,
            surfaces,
        }
    }

    /// Finds the colours of some pixels, `N` of them together.
    pub fn find<T: Written, const N: usize>(&self, mut part: Part<T>, scratch: &mut Scratch<F, N>) {
        if part.pixels.is_empty() {
            return;
        }
        let pixels = part.pixels;
        self.run::<N, { stage::LOAD }>(pixels, scratch, 0);
        self.run::<N, { stage::SEE }>(pixels, scratch, 0);
        self.run::<N, { stage::GATHER }>(pixels, scratch, 0);
        for (index, light) in self.lights.iter().enumerate() {
            self.run::<N, { stage::AIM }>(pixels, scratch, index);
            self.remember(index, part.known, scratch);
            if light.casts_shadows && scratch.is_lit {
                self.run::<N, { stage::DARKEN }>(pixels, scratch, index);
                if self.occluders.tree().is_some() {
                    self.run::<N, { stage::DARKEN_BY_TREE }>(pixels, scratch, index);
                }
            }
        }
        self.run::<N, { stage::TINT }>(pixels, scratch, 0);
        pulp::Arch::new().dispatch(Write { pass: self, part: &mut part, scratch });
    }

    fn run<const N: usize, const STAGE: usize>(
        &self,
        pixels: &[usize],
        scratch: &mut Scratch<F, N>,
        index: usize,
    ) {
        let run: Run<F, N, STAGE> = Run { pass: self, pixels, scratch, index };
        pulp::Arch::new().dispatch(run);
    }

    /// Puts samples of pixels into packs, and makes room for their light.
    #[inline(always)]
    fn load<const N: usize>(&self, pixels: &[usize], scratch: &mut Scratch<F, N>) {
        let Scratch { packs, shades, given, .. } = scratch;
        let (n, row, ids) = (self.job.n_samples(), self.job.row, self.job.ids);
        let n_packs = pixels.len().div_ceil(N) * n * n;
        shades.resize(n_packs, Shade::none());
        given.resize(n_packs * self.lights.len(), Given::none());
        packs.resize_with(packs.len().max(n_packs), Pack::default);
        packs.truncate(n_packs);
        let n_spheres = self.occluders.scene.spheres.len() as u32;
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
                let (x, y) = self.samples.xy(at[lane]);
                let (i, j) = self.samples.offset2(x, y);
                (across[lane], up[lane]) = (i as f64, j as f64);
            }
            for (sample, pack) in packs.iter_mut().enumerate() {
                let (right, down) = (sample % n, sample / n);
                let ids = &ids[down * row + right..];
                if is_stretch && n == 1 {
                    pack.see(&ids[at[0]..][..N], n_spheres);
                } else {
                    let mut seen = [0; N];
                    for lane in 0..N {
                        seen[lane] = ids[at[lane]];
                    }
                    pack.see(&seen, n_spheres);
                }
                let (right, down) = (2.0 * right as f64, 2.0 * down as f64);
                for lane in 0..N {
                    pack.offset[0].0[lane] = F::near(across[lane] + right);
                    pack.offset[1].0[lane] = F::near(up[lane] - down);
                }
            }
        }
    }

    /// Finds the surfaces that samples see.
    #[inline(always)]
    fn see<const N: usize>(&self, scratch: &mut Scratch<F, N>) {
        if self.surfaces.are_known() {
            return self.surfaces.solve(&mut scratch.packs);
        }
        for pack in &mut scratch.packs {
            pack.surface = Surface::default();
        }
    }

    #[inline(always)]
    fn shadow_rays<const N: usize>(
        &self,
        aim: &Aim<Lanes<F, N>>,
        pack: &Pack<F, N>,
    ) -> ShadowRay<Lanes<F, N>> {
        ShadowRay::new(aim, pack.surface.point, pack.surface.point_error)
    }

    /// What a light gives if nothing is in its way.
    #[inline(always)]
    fn aim<const N: usize>(&self, index: usize, scratch: &mut Scratch<F, N>) {
        let Scratch { packs, given, .. } = scratch;
        let light = &self.lights[index];
        let aim = Aim::new(light.origin);
        let (zero, is_asked) = (Lanes::lit(0.0), if light.casts_shadows { 1.0 } else { 0.0 });
        let all = &mut given[index * packs.len()..][..packs.len()];
        scratch.is_lit = false;
        for (pack, given) in one_by_one(&*packs).zip(all) {
            let (low, high) =
                self.shadow_rays(&aim, pack).cosine(pack.surface.normal, pack.surface.normal_error);
            let low = Lanes::select(pack.surface.is_known(), low, zero);
            let high = Lanes::select(is_id(&pack.ids, 0), zero, high);
            let asked = Lanes::select(zero.lt(high), Lanes::lit(is_asked), zero);
            let is_lit = zero.lt(high).any();
            *given = Given { low, high, asked, is_lit };
            scratch.is_lit |= is_lit;
        }
    }

    /// Takes over what is known of a light already.
    fn remember<const N: usize>(&self, index: usize, known: &[Open], scratch: &mut Scratch<F, N>) {
        if known.is_empty() {
            return;
        }
        let (n_lights, n_samples) = (self.lights.len(), self.job.n_samples().pow(2));
        let Scratch { given, packs, is_lit, .. } = scratch;
        let given = &mut given[index * packs.len()..][..packs.len()];
        for (given, known) in given.chunks_mut(n_samples).zip(known.chunks(N)) {
            for (sample, given) in given.iter_mut().enumerate() {
                given.is_lit = false;
                for lane in 0..N {
                    let known = known.get(lane).map(|known| &known.visibility);
                    // The last pixel is in all lanes behind it.
                    match known.map_or(Visibility::Hidden, |all| all[sample * n_lights + index]) {
                        Visibility::Unknown => given.is_lit = true,
                        Visibility::Hidden => {
                            (given.low.0[lane], given.high.0[lane]) = Default::default();
                        }
                        Visibility::Seen => given.asked.0[lane] = -given.asked.0[lane],
                    }
                }
            }
        }
        *is_lit = given.iter().any(|given| given.is_lit);
    }

    /// The points that samples see, by objects.
    #[inline(always)]
    fn gather<const N: usize>(&self, scratch: &mut Scratch<F, N>) {
        let Scratch { packs, boxes, balls, .. } = scratch;
        boxes.clear();
        for pack in packs {
            let mut left = pack.surface.is_known().and(is_id(&pack.ids, 0).not());
            while left.any() {
                let id = match pack.is_uniform() {
                    true => pack.ids[0],
                    false => first_of(left, &pack.ids),
                };
                let here = if pack.is_uniform() { left } else { left.and(is_id(&pack.ids, id)) };
                let known = boxes.iter().rposition(|some| some.id == id);
                let at = known.unwrap_or_else(|| {
                    boxes.push(Extent::none(id));
                    boxes.len() - 1
                });
                boxes[at].add(here, &pack.surface);
                if pack.is_uniform() {
                    break;
                }
                left = left.and(here.not());
            }
        }
        balls.clear();
        for some in boxes {
            balls.push(some.ball());
        }
    }

    /// Takes away what listed objects are in the way of.
    #[inline(always)]
    fn darken<const N: usize>(&self, index: usize, scratch: &mut Scratch<F, N>) {
        let Scratch { packs, given, balls, places, .. } = scratch;
        let given = &mut given[index * packs.len()..][..packs.len()];
        let (light, lamp) = (&self.lights[index], &self.job.lit.lighting.lamps[index]);
        let (zero, one) = (Lanes::<F, N>::lit(0.0), Lanes::lit(1.0));
        let aim = Aim::new(light.origin);
        for ball in balls {
            let id = ball.id;
            let mut both = packs.iter().zip(&*given);
            if !both.any(|(pack, given)| given.is_lit && pack.sees(id)) {
                continue;
            }
            let has_back = ball.has_back && self.occluders.own_is_in_the_way(lamp, id);
            let is_dark = self.occluders.look_around(&ball.shadow_ray(light.origin), id, places);
            if !is_dark && !has_back && places.is_empty() {
                continue;
            }
            for (pack, given) in packs.iter().zip(&mut *given) {
                if !given.is_lit || !pack.sees(id) {
                    continue;
                }
                let mut verdict = Verdict::none();
                if is_dark {
                    verdict = Verdict { blocked: one, clear: -one };
                } else {
                    let rays = self.shadow_rays(&aim, pack);
                    for &place in &*places {
                        verdict = verdict.with(self.listed[place].occlude(&rays));
                    }
                    if has_back {
                        let front = pack.surface.front;
                        verdict.blocked = Lanes::select(front, verdict.blocked, one);
                        verdict.clear = Lanes::select(front, verdict.clear, -one);
                    }
                }
                // Of those of which nothing is known the lower bound is 0 already.
                let here = pack.surface.is_known();
                let here = if pack.is_uniform() { here } else { here.and(is_id(&pack.ids, id)) };
                verdict.blocked = Lanes::select(here, verdict.blocked, zero);
                verdict.clear = Lanes::select(here, verdict.clear, one);
                given.take(&verdict);
            }
        }
    }

    /// Takes away what spheres of the tree are in the way of. The samples of some pixels that see one object lie close
    /// together, and share a walk.
    #[inline(always)]
    fn darken_by_tree<const N: usize>(&self, index: usize, scratch: &mut Scratch<F, N>) {
        let Some(bvh) = self.occluders.tree() else { return };
        let light = &self.lights[index];
        let aim = Aim::new(light.origin);
        let Scratch { packs, given, walk, left, ways, .. } = scratch;
        let given = &mut given[index * packs.len()..][..packs.len()];
        let (zero, one) = (Lanes::<F, N>::lit(0.0), Lanes::lit(1.0));
        let together = self.job.n_samples().pow(2).max(TOGETHER);
        for (packs, given) in packs.chunks(together).zip(given.chunks_mut(together)) {
            ways.clear();
            left.clear();
            for (pack, given) in packs.iter().zip(&*given) {
                let rays = self.shadow_rays(&aim, pack);
                let is_asked = pack.surface.is_known().and(zero.lt(given.high.min(given.asked)));
                let asked = Lanes::select(is_asked, given.high, zero);
                ways.push(Way { rays, verdict: Verdict::none(), asked });
                left.push(Lanes::select(is_asked, one, zero));
            }
            for first in 0..packs.len() {
                while let Some(lane) = (0..N).find(|&lane| zero.0[lane].lt(left[first].0[lane])) {
                    let own = packs[first].ids[lane];
                    let mut around = Extent::none(own);
                    for (pack, left) in packs.iter().zip(&mut *left).skip(first) {
                        let here = is_id(&pack.ids, own).and(zero.lt(*left));
                        around.add(here, &pack.surface);
                        *left = Lanes::select(here, zero, *left);
                    }
                    let beam = self.occluders.beam(bvh, light.origin, around.corners());
                    let (packs, ways) = (&packs[first..], &mut ways[first..]);
                    let mut darken = Darken { pass: self, bvh, own, packs, ways, is_dark: false };
                    walk.all(bvh, bvh.root(), beam, &mut darken);
                }
            }
            for ((pack, given), way) in packs.iter().zip(given).zip(&*ways) {
                let Verdict { mut blocked, mut clear } = way.verdict;
                let known = pack.surface.is_known();
                (blocked, clear) =
                    (Lanes::select(known, blocked, zero), Lanes::select(known, clear, one));
                given.take(&Verdict { blocked, clear });
            }
        }
    }

    /// Adds what all lights give, and takes it times the objects' own colours.
    #[inline(always)]
    fn tint<const N: usize>(&self, scratch: &mut Scratch<F, N>) {
        let Scratch { packs, given, shades, .. } = scratch;
        let (zero, one) = (Lanes::<F, N>::lit(0.0), V3([Lanes::lit(1.0); 3]));
        let n_packs = packs.len();
        for (pack, shade) in one_by_one(&*packs).zip(&mut *shades) {
            let [mut red, mut green, mut blue] = self.job.color(pack.ids[0]);
            shade.color = V3([Lanes::lit(red), Lanes::lit(green), Lanes::lit(blue)]);
            if pack.is_uniform() {
                continue;
            }
            for lane in 1..N {
                if pack.ids[lane] != pack.ids[lane - 1] {
                    [red, green, blue] = self.job.color(pack.ids[lane]);
                }
                shade.color.0[0].0[lane] = F::near(red);
                shade.color.0[1].0[lane] = F::near(green);
                shade.color.0[2].0[lane] = F::near(blue);
            }
        }
        for (number, (pack, shade)) in one_by_one(&*packs).zip(shades).enumerate() {
            let (mut low, mut high) = (V3::splat(self.ambient.low), V3::splat(self.ambient.high));
            let mut n_rays = zero;
            let here = given.iter().skip(number).step_by(n_packs);
            for (light, given) in self.lights.iter().zip(here) {
                let weight = V3::<Lanes<F, N>>::splat(light.weight);
                low = low + weight * given.low;
                high = high + weight * given.high;
                n_rays = n_rays + given.asked.abs();
            }
            let nothing = is_id(&pack.ids, 0);
            (shade.n_rays, shade.n_hits) = (n_rays, Lanes::select(nothing, zero, Lanes::lit(1.0)));
            shade.low = shade.color.times(V3::select(nothing, one, low));
            shade.high = shade.color.times(V3::select(nothing, one, high));
        }
    }

    /// Writes means of samples.
    #[inline(always)]
    fn write<T: Written, const N: usize>(&self, part: &mut Part<T>, scratch: &Scratch<F, N>) {
        let Part { pixels, first, out, open, n_rays, .. } = part;
        let n = self.job.n_samples();
        let background = T::of_bounds(&self.job.color(0).map(Interval::of)).unwrap_or_default();
        let (zero, one) = (Lanes::<F, N>::lit(0.0), Lanes::lit(1.0));
        let [narrower, wider] = [-self.width, self.width].map(|x| Lanes::lit(1.0 + x));
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
            let (low, high) = (sum.low * narrower / n_counted, sum.high * wider / n_counted);
            let mut found = [T::default(); N];
            let is_known = T::of_lanes(&low, &high, &mut found);
            let (mut are_all_known, mut all_rays) = (true, 0.0);
            for lane in 0..N {
                are_all_known &= is_known[lane] & zero.0[lane].lt(sum.n_hits.0[lane]);
                all_rays += sum.n_rays.0[lane].to_f64();
            }
            if are_all_known && is_stretch::<N>(pixels) {
                out[pixels[0] - *first..][..N].copy_from_slice(&found);
                **n_rays += all_rays as u64;
                continue;
            }
            for (lane, &pixel) in pixels.iter().enumerate() {
                if !zero.0[lane].lt(sum.n_hits.0[lane]) {
                    out[pixel - *first] = background;
                } else if is_known[lane] {
                    out[pixel - *first] = found[lane];
                    **n_rays += sum.n_rays.0[lane].to_f64() as u64;
                } else {
                    let bounds = std::array::from_fn(|channel| Interval {
                        low: low.0[channel].0[lane].to_f64(),
                        high: high.0[channel].0[lane].to_f64(),
                    });
                    let samples = number * n * n..(number + 1) * n * n;
                    let of_lights =
                        |pack| scratch.given.iter().skip(pack).step_by(scratch.packs.len());
                    let visibility =
                        samples.flat_map(of_lights).map(|given| given.visibility(lane));
                    open.push(Open { pixel, bounds, visibility: visibility.collect() });
                }
            }
        }
    }
}

/// Looks for what is in the way of light to points of one object.
struct Darken<'a, 'b, F: Float, const N: usize> {
    pass: &'a Pass<'b, F>,
    bvh: &'a Bvh,
    /// Their object, which is not in their way.
    own: u32,
    packs: &'a [Pack<F, N>],
    ways: &'a mut [Way<F, N>],
    is_dark: bool,
}

impl<F: Bounded + Linear, const N: usize> Visitor for Darken<'_, '_, F, N> {
    #[inline(always)]
    fn last(&self) -> f32 {
        if self.is_dark { -1.0 } else { f32::INFINITY }
    }

    #[inline(always)]
    fn visit(&mut self, node: &Node, mut leaves: u32, _: &Enter) {
        let (zero, one) = (Lanes::<F, N>::lit(0.0), Lanes::lit(1.0));
        while leaves != 0 {
            let place = node.place(leaves.trailing_zeros()) as usize;
            leaves &= leaves - 1;
            if self.bvh.ids[place] == self.own {
                continue;
            }
            let met = self.pass.occluders.met::<F>(&self.bvh.spheres[place]);
            let met = <SphereMet<f64> as Record>::splat(&met);
            let mut is_any_open = false;
            for (pack, way) in self.packs.iter().zip(&mut *self.ways) {
                if !pack.sees(self.own) {
                    continue;
                }
                let here = Lanes::select(is_id(&pack.ids, self.own), one, zero);
                if !way.is_open(here) {
                    continue;
                }
                let mut found = SphereMet::occlude(&met, &way.rays);
                found.blocked = Lanes::select(zero.lt(here), found.blocked, -one);
                found.clear = Lanes::select(zero.lt(here), found.clear, one);
                way.verdict = way.verdict.with(found);
                way.asked = Lanes::select(zero.lt(found.blocked), zero, way.asked);
                is_any_open |= way.is_open(here);
            }
            if !is_any_open {
                self.is_dark = true;
                return;
            }
        }
    }
}

/// Whether these are `N` pixels side by side.
#[inline(always)]
fn is_stretch<const N: usize>(pixels: &[usize]) -> bool {
    pixels.len() == N && pixels[N - 1] - pixels[0] == N - 1
}

/// The id of the first lane where a mask holds.
#[inline(always)]
fn first_of<F: Float, const N: usize>(mask: LaneBits<F, N>, ids: &[u32; N]) -> u32 {
    let mut id = 0;
    for lane in (0..N).rev() {
        id = if mask.0[lane] != F::Bits::default() { ids[lane] } else { id };
    }
    id
}

/// The stages of a pass before it writes.
mod stage {
    pub const LOAD: usize = 0;
    pub const SEE: usize = 1;
    pub const GATHER: usize = 2;
    pub const AIM: usize = 3;
    pub const DARKEN: usize = 4;
    pub const DARKEN_BY_TREE: usize = 5;
    pub const TINT: usize = 6;
}

/// A stage, compiled for each instruction set that the processor may have. In one function for all of them numbers no longer
/// stay in registers, and closures become calls.
struct Run<'a, 'b, F: Float, const N: usize, const STAGE: usize> {
    pass: &'a Pass<'b, F>,
    pixels: &'a [usize],
    scratch: &'a mut Scratch<F, N>,
    /// Index of the light.
    index: usize,
}

impl<F: Bounded + Linear, const N: usize, const STAGE: usize> WithSimd
    for Run<'_, '_, F, N, STAGE>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Run { pass, pixels, scratch, index } = self;
        match STAGE {
            stage::LOAD => pass.load(pixels, scratch),
            stage::SEE => pass.see(scratch),
            stage::GATHER => pass.gather(scratch),
            stage::AIM => pass.aim(index, scratch),
            stage::DARKEN => pass.darken(index, scratch),
            stage::DARKEN_BY_TREE => pass.darken_by_tree(index, scratch),
            _ => pass.tint(scratch),
        }
    }
}

/// The last stage, of the numbers that a picture has.
struct Write<'a, 'b, 'c, T, F: Float, const N: usize> {
    pass: &'a Pass<'b, F>,
    part: &'a mut Part<'c, T>,
    scratch: &'a Scratch<F, N>,
}

impl<T: Written, F: Bounded + Linear, const N: usize> WithSimd for Write<'_, '_, '_, T, F, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.pass.write(self.part, self.scratch);
    }
}

#[cfg(test)]
mod tests;
