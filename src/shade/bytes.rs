//! The bytes of neighbours in a row, where there are few objects: in f32 with bounds, side by side. What these leave
//! open goes to f64.
//!
//! Points, normals and what lamps give them come by the same steps as in f64, with the units of
//! [`crate::guard::host`]. A colour is `c·(A + Σ wᵢgᵢ)` with the light `A` from nowhere, the lamps' weights and what is given
//! of them, and all of it is positive: relative to its sum, of `n` lamps, the numbers `c`, `A` and `w` are rounded once,
//! `g` is the middle of two bounds, products and sums take `n + 2`. So do the sum of `s` samples with `s`, the quotient by
//! their number with 2, and the bounds of the result with one: `n + s + ` [`OF_COLOR`] roundings, see [`of_roundings`]. What the
//! `g` are off by adds `c·Σ max(wᵢ)·(gᵢ's half width)`.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use pulp::Simd;

use super::Background;
use super::beam::{Beam, in_the_way};
use super::finder::{Finder, LampF64, ListedShape, Room, middle_of};
use super::lamp::MOST_IN_F32;
use super::lit::Job;
use super::written::{Interval, Written};
use crate::engine::{Camera, eye_of};
use crate::guard::host::{Bounded, input_in_f32};
use crate::guard::{LONGEST_IN_F32, ROOM, Reach, round_up};
use crate::num::{Float, Lanes};
use crate::rays::Pixels;
use crate::scene::Edges;
use crate::seen::{Eye, In, Lengths, PlaneSeen, Seen as SeenObject, SphereSeen};
use crate::trace::StageCounts;
use crate::vec3::{Vec3, dot3};
use crate::wide::{Holds, SideBySide, WideF32};

/// Numbers side by side.
const LANES: usize = 16;

/// Roundings of a colour beside one for each lamp and each sample.
const OF_COLOR: f64 = 10.0;

/// How much larger than some points a ball around them is that later ones may lie in, too.
const LARGER: f64 = 1.6;

type Row = [f32; LANES];

#[inline(always)]
fn registers<S: Simd>() -> impl Iterator<Item = usize> {
    (0..LANES).step_by(WideF32::<S>::LANES)
}

/// What is found of neighbours.
#[derive(Clone)]
struct Pack {
    at: [Row; 3],
    /// Infinite where nothing is known.
    error: Row,
    normal: [Row; 3],
    normal_error: Row,
    direction: [Row; 3],
    /// Bounds of what a lamp gives.
    given: [Row; 2],
    light: [Row; 3],
    /// What that is off by.
    doubt: Row,
    /// Ways to lamps that are looked along.
    n_ways: Row,
}

impl Pack {
    const NONE: Pack = Pack {
        at: [[0.0; LANES]; 3],
        error: [f32::INFINITY; LANES],
        normal: [[0.0; LANES]; 3],
        normal_error: [f32::INFINITY; LANES],
        direction: [[1.0; LANES]; 3],
        given: [[0.0; LANES]; 2],
        light: [[0.0; LANES]; 3],
        doubt: [0.0; LANES],
        n_ways: [0.0; LANES],
    };
}

#[inline(always)]
fn load<S: Simd>(simd: S, row: &Row, first: usize) -> WideF32<S> {
    WideF32::load(simd, &row[first..])
}

#[inline(always)]
fn load3<S: Simd>(simd: S, rows: &[Row; 3], first: usize) -> Vec3<WideF32<S>> {
    let [x, y, z] = rows;
    Vec3([load(simd, x, first), load(simd, y, first), load(simd, z, first)])
}

/// Colours side by side.
#[derive(Clone, Default)]
struct Colors {
    /// Of each channel.
    parts: [Row; 3],
    /// What they are off by but for rounding; infinite where nothing is known.
    doubts: [Row; 3],
    n_ways: Row,
}

/// Where points lay whose ways to a lamp all met something, or all nothing.
#[derive(Clone, Copy)]
struct Seen {
    id: u32,
    from: Vec3<f64>,
    reach: f64,
    is_dark: bool,
}

/// Finds the bytes of one picture.
pub struct ByteFinder<'a> {
    finder: &'a Finder<'a>,
    job: &'a Job<'a>,
    samples: &'a Pixels,
    camera: Camera<f32>,
    lengths: Lengths<f32>,
    /// By ids.
    objects: Vec<SeenInF32>,
    colors: Vec<[f32; 3]>,
    background: [u8; 3],
    /// What sums are off by, relative.
    rounding: f32,
}

/// A point that is off by as much is not known.
const UNKNOWN: f32 = <f32 as Float>::BEYOND as f32 / 4.0;

/// A normal that is off by more is of no use for a byte.
const OF_USE: f32 = 1.0 / (1u32 << 10) as f32;

/// Neighbours in a row that see one object.
struct Run {
    id: u32,
    /// Where in the row they begin.
    at: usize,
    n: usize,
    /// [`Pixels::offset2`] of the first one.
    offset: (i64, i64),
}

/// How many ids at the beginning are the same.
fn run_length(ids: &[u32]) -> usize {
    // So many are compared at a time.
    const BLOCK: usize = 16;
    let Some(&id) = ids.first() else { return 0 };
    let is_one = |ids: &&[u32]| ids.iter().fold(0, |other, &next| other | (next ^ id)) == 0;
    let n = BLOCK * ids.chunks_exact(BLOCK).take_while(is_one).count();
    n + ids[n..].iter().take_while(|&&next| next == id).count()
}

/// An object as all samples see it.
pub(super) enum SeenInF32 {
    Nothing,
    /// And whether it [`is_close`](SeenObject::is_close).
    Sphere(SphereSeen<f32>, bool),
    Plane(PlaneSeen<f32>),
}

/// Room for the bytes of a part of a row.
#[derive(Default)]
pub struct ByteRoom {
    packs: Vec<Pack>,
    room: Room,
    /// By lamps.
    seen: Vec<Option<Seen>>,
    /// Of a row of samples, and of pixels.
    samples: Vec<Colors>,
    pixels: Vec<Colors>,
    /// Places in the last part that were left open.
    pub open: Vec<usize>,
}

impl<'a> ByteFinder<'a> {
    /// For the pixels with these samples; `None` for many spheres, where weights or colours are out of f32's range, and
    /// where there are so many terms that f32 knows nothing of their sum.
    pub fn new(
        finder: &'a Finder<'a>,
        job: &'a Job<'a>,
        samples: &'a Pixels,
    ) -> Option<ByteFinder<'a>> {
        if finder.has_tree() {
            return None;
        }
        let n_objects = finder.n_objects();
        let lighting = &job.lit.lighting;
        let weights = lighting.lamps.iter().map(|lamp| lamp.weight);
        let mut numbers =
            weights.chain((0..=n_objects).map(|id| job.color(id))).chain([lighting.ambient]);
        if !numbers.all(|parts| parts.iter().all(|part| (0.0..MOST_IN_F32).contains(part))) {
            return None;
        }
        let n_terms =
            finder.lamps.len() as f64 + f64::from(job.lit.style.n_samples.across()).powi(2);
        let rounding = of_roundings(n_terms + OF_COLOR)?;
        let longest = samples.longest_direction();
        if longest > LONGEST_IN_F32 || !finder.surfaces.are_known() {
            return None;
        }
        let eye = eye_of(samples, Reach::default(), <f32 as Bounded>::UNIT);
        let eye = Eye { input: input_in_f32(samples.view.lens), ..eye };
        Some(ByteFinder {
            finder,
            job,
            samples,
            camera: Camera::new(samples),
            lengths: Lengths::new(&eye, longest),
            objects: (0..=n_objects).map(|id| finder.seen_in_f32(id, &eye)).collect(),
            colors: (0..=n_objects).map(|id| job.color(id).map(|part| part as f32)).collect(),
            background: Written::of_bounds(&job.color(0).map(Interval::of)).unwrap_or_default(),
            rounding,
        })
    }

    /// Writes the bytes of consecutive pixels of a row, the first of which has this index.
    pub fn find(
        &self,
        first: usize,
        out: &mut [[u8; 3]],
        room: &mut ByteRoom,
        counts: &mut StageCounts,
    ) {
        pulp::Arch::new().dispatch(FindBytes { bytes: self, first, out, room, counts });
    }
}

/// How far the true sum of positive terms may be from one that took `n` roundings, relative to that one; `None` where it
/// may be any. The computed sum is the true one times `1 + θ` with `|θ| ≤ γ = nu/(1 − nu)` (Higham 2002, Accuracy and
/// Stability of Numerical Algorithms, lemma 3.1). So the true one is off by at most `γ/(1 − γ) = nu/(1 − 2nu)` of it.
fn of_roundings(n: f64) -> Option<f32> {
    let first_order = n * <f32 as Bounded>::UNIT;
    (first_order < 0.25).then(|| round_up(first_order / (1.0 - 2.0 * first_order)))
}

/// The points of neighbours, by themselves: in one large function numbers no longer stay in registers.
struct FindPoints<'a, T: SeenObject> {
    bytes: &'a ByteFinder<'a>,
    run: &'a Run,
    packs: &'a mut [Pack],
    seen: &'a In<T, f32>,
    is_close: bool,
}

impl<T: SeenObject> pulp::WithSimd for FindPoints<'_, T> {
    type Output = (Vec3<f64>, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> (Vec3<f64>, f64) {
        let FindPoints { bytes, run, packs, seen, is_close } = self;
        let ambient = bytes.job.lit.lighting.ambient.map(|part| [part as f32; LANES]);
        let (seen, lengths) = (T::splat(seen), bytes.lengths.splat());
        let (start, end) = (run.at % LANES, run.at % LANES + run.n);
        let (first, j) = (run.offset.0 - 2 * start as i64, [run.offset.1 as f32; LANES]);
        for (number, pack) in packs.iter_mut().enumerate() {
            let mut i = [0.0; LANES];
            for lane in 0..LANES {
                i[lane] = first as f32 + 2.0 * (number * LANES + lane) as f32;
            }
            let ray = bytes.camera.ray(i, j);
            let found = match is_close {
                false => T::surface::<Lanes<f32, LANES>>(&seen, &ray, &lengths),
                true => T::surface_close(&seen, &ray, &lengths),
            };
            for axis in 0..3 {
                pack.at[axis] = found.point.0[axis].0;
                pack.normal[axis] = found.normal.0[axis].0;
                pack.direction[axis] = ray.direction.0[axis].0;
            }
            pack.normal_error = found.normal_error.0;
            for lane in 0..LANES {
                let column = number * LANES + lane;
                let is_in_run = (start <= column) & (column < end);
                // From inside it is left to f64.
                let error = found.point_error.0[lane];
                let is_known = (error < UNKNOWN) & (found.front.0[lane] != 0);
                let is_known = is_known & (found.normal_error.0[lane] < OF_USE);
                pack.error[lane] = if is_in_run & is_known { error } else { f32::INFINITY };
            }
            (pack.light, pack.doubt, pack.n_ways) = (ambient, [0.0; LANES], [0.0; LANES]);
        }
        let (mut low, mut high) = ([[f32::INFINITY; LANES]; 3], [[f32::NEG_INFINITY; LANES]; 3]);
        let mut most = [0.0; LANES];
        for pack in packs {
            for lane in 0..LANES {
                let is_known = pack.error[lane] < f32::INFINITY;
                for axis in 0..3 {
                    let at = pack.at[axis][lane];
                    let (low, high) = (&mut low[axis][lane], &mut high[axis][lane]);
                    *low = if is_known & (at < *low) { at } else { *low };
                    *high = if is_known & (*high < at) { at } else { *high };
                }
                let is_more = is_known & (most[lane] < pack.error[lane]);
                most[lane] = if is_more { pack.error[lane] } else { most[lane] };
            }
        }
        let (mut ends, mut error) = ([Vec3::ZERO; 2], most[0]);
        for axis in 0..3 {
            let (mut least, mut largest) = (low[axis][0], high[axis][0]);
            for lane in 1..LANES {
                least = if low[axis][lane] < least { low[axis][lane] } else { least };
                largest = if largest < high[axis][lane] { high[axis][lane] } else { largest };
            }
            (ends[0].0[axis], ends[1].0[axis]) = (least.into(), largest.into());
        }
        for lane in 1..LANES {
            error = if error < most[lane] { most[lane] } else { error };
        }
        middle_of(ends[0], ends[1], error.into())
    }
}

struct FindBytes<'a> {
    bytes: &'a ByteFinder<'a>,
    first: usize,
    out: &'a mut [[u8; 3]],
    room: &'a mut ByteRoom,
    counts: &'a mut StageCounts,
}

impl pulp::WithSimd for FindBytes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let FindBytes { bytes, first, out, room, counts } = self;
        room.open.clear();
        let (job, n) = (bytes.job, bytes.job.lit.style.n_samples.across() as usize);
        let n_packs = (out.len() * n).div_ceil(LANES);
        room.seen.resize(bytes.finder.lamps.len(), None);
        room.samples.resize(n_packs, Colors::default());
        let start = job.first_sample(first);
        if n == 1 {
            bytes.find_row(simd, start, out.len(), room);
            bytes.write(simd, first, &room.samples, out, &mut room.open, counts);
            return;
        }
        room.pixels.clear();
        room.pixels.resize(out.len().div_ceil(LANES), Colors::default());
        for row in 0..n {
            bytes.find_row(simd, start + row * job.row, out.len() * n, room);
            add_samples(&room.samples, n, out.len(), &mut room.pixels);
        }
        bytes.divide(first, out.len(), &mut room.pixels);
        bytes.write(simd, first, &room.pixels, out, &mut room.open, counts);
    }
}

/// Adds those of `n` neighbours each to those of `n_pixels` pixels.
fn add_samples(samples: &[Colors], n: usize, n_pixels: usize, pixels: &mut [Colors]) {
    for pixel in 0..n_pixels {
        let (mut parts, mut doubts, mut n_ways) = ([0.0; 3], [0.0; 3], 0.0);
        for sample in pixel * n..(pixel + 1) * n {
            let (from, lane) = (&samples[sample / LANES], sample % LANES);
            for channel in 0..3 {
                parts[channel] += from.parts[channel][lane];
                doubts[channel] += from.doubts[channel][lane];
            }
            n_ways += from.n_ways[lane];
        }
        let (to, lane) = (&mut pixels[pixel / LANES], pixel % LANES);
        for channel in 0..3 {
            to.parts[channel][lane] += parts[channel];
            to.doubts[channel][lane] += doubts[channel];
        }
        to.n_ways[lane] += n_ways;
    }
}

impl ByteFinder<'_> {
    /// The colours of `n` neighbours in a row of samples, the first of which has this index.
    #[inline(always)]
    fn find_row<S: Simd>(&self, simd: S, first: usize, n: usize, room: &mut ByteRoom) {
        let ids = &self.job.ids[first..first + n];
        let (x, y) = self.samples.xy(first);
        let offset = self.samples.offset2(x, y);
        let mut at = 0;
        while at < n {
            let (id, n) = (ids[at], run_length(&ids[at..]));
            let run = Run { id, at, n, offset: (offset.0 + 2 * at as i64, offset.1) };
            match id {
                0 => fill(&mut room.samples, at..at + n, self.colors[0], 0.0),
                _ => self.find_run(simd, &run, room),
            }
            at += n;
        }
    }

    /// Those of neighbours that see one object.
    #[inline(always)]
    fn find_run<S: Simd>(&self, simd: S, run: &Run, room: &mut ByteRoom) {
        let ByteRoom { packs, room, seen, samples, .. } = room;
        // Their places are those of the colours.
        let numbers = run.at / LANES..(run.at + run.n).div_ceil(LANES);
        packs.resize(packs.len().max(numbers.len()), Pack::NONE);
        let packs = &mut packs[..numbers.len()];
        let around = self.find_points(run, packs);
        self.find_light(simd, run.id, around, packs, seen, room);
        let like = |number: f32| WideF32::splat(simd, number);
        let color = self.colors[run.id as usize];
        let (start, end) = (like((run.at % LANES) as f32), run.at % LANES + run.n);
        let columns = columns();
        for (number, (pack, colors)) in packs.iter().zip(&mut samples[numbers]).enumerate() {
            for first in registers::<S>() {
                let column = load(simd, &columns, first) + like((number * LANES) as f32);
                let is_in_run = start.le(column).and(column.lt(like(end as f32)));
                let put = |to: &mut Row, numbers: WideF32<S>| {
                    is_in_run.select(numbers, load(simd, to, first)).store(&mut to[first..]);
                };
                let infinite = like(f32::INFINITY);
                let is_known = load(simd, &pack.error, first).lt(infinite);
                let doubt = load(simd, &pack.doubt, first);
                for channel in 0..3 {
                    let light = load(simd, &pack.light[channel], first);
                    put(&mut colors.parts[channel], light * like(color[channel]));
                    let doubt = doubt * like(ROOM as f32 * color[channel]);
                    put(&mut colors.doubts[channel], is_known.select(doubt, infinite));
                }
                put(&mut colors.n_ways, load(simd, &pack.n_ways, first));
            }
        }
    }

    /// The points that they see; the middle of them, and how far each is from it.
    fn find_points(&self, run: &Run, packs: &mut [Pack]) -> (Vec3<f64>, f64) {
        let bytes = self;
        match &self.objects[run.id as usize] {
            SeenInF32::Nothing => (Vec3::ZERO, f64::INFINITY),
            SeenInF32::Sphere(seen, is_close) => {
                let is_close = *is_close;
                let find = FindPoints::<SphereSeen<f64>> { bytes, run, packs, seen, is_close };
                pulp::Arch::new().dispatch(find)
            }
            SeenInF32::Plane(seen) => {
                let is_close = false;
                let find = FindPoints::<PlaneSeen<f64>> { bytes, run, packs, seen, is_close };
                pulp::Arch::new().dispatch(find)
            }
        }
    }

    /// What lamps give to points of an object that lie within some distance from a middle.
    #[inline(always)]
    fn find_light<S: Simd>(
        &self,
        simd: S,
        id: u32,
        around: (Vec3<f64>, f64),
        packs: &mut [Pack],
        seen: &mut [Option<Seen>],
        room: &mut Room,
    ) {
        let finder = self.finder;
        let like = |number: f32| WideF32::splat(simd, number);
        let (zero, one) = (like(0.0), like(1.0));
        let lamps = self.job.lit.lighting.lamps.iter().zip(&finder.lamps);
        for ((lamp, &place), seen) in lamps.zip(seen) {
            let has_shadows = lamp.casts_shadows();
            let way = if has_shadows { one } else { zero };
            let mut is_any = zero.lt(zero);
            for pack in &mut *packs {
                for first in registers::<S>() {
                    let beams = self.beams(simd, place, pack, first);
                    let normal = load3(simd, &pack.normal, first);
                    let normal_error = load(simd, &pack.normal_error, first);
                    let (low, high) = beams.cosine(normal, normal_error);
                    let is_known = load(simd, &pack.error, first).lt(like(f32::INFINITY));
                    let is_lit = is_known.and(zero.lt(high));
                    is_any = is_any.or(is_lit);
                    let n_ways = load(simd, &pack.n_ways, first);
                    is_lit.select(n_ways + way, n_ways).store(&mut pack.n_ways[first..]);
                    is_lit.select(low, zero).store(&mut pack.given[0][first..]);
                    is_lit.select(high, zero).store(&mut pack.given[1][first..]);
                }
            }
            if !is_any.any() {
                continue;
            }
            if has_shadows {
                if self.is_dark(simd, place, id, around, seen, room) {
                    continue;
                }
                if !room.listed.is_empty() {
                    for pack in &mut *packs {
                        for first in registers::<S>() {
                            let beams = self.beams(simd, place, pack, first);
                            self.darken(simd, &beams, pack, first, &room.listed);
                        }
                    }
                }
            }
            let [r, g, b] = lamp.weight;
            let weight = [r as f32, g as f32, b as f32];
            let largest = round_up(r.max(g).max(b));
            for pack in &mut *packs {
                for first in registers::<S>() {
                    let low = load(simd, &pack.given[0], first);
                    let high = load(simd, &pack.given[1], first);
                    let middle = (low + high) * like(0.5);
                    for channel in 0..3 {
                        let light = &mut pack.light[channel];
                        let sum = load(simd, light, first) + middle * like(weight[channel]);
                        sum.store(&mut light[first..]);
                    }
                    let doubt = load(simd, &pack.doubt, first);
                    let half = (high - low) * like(0.5 * ROOM as f32);
                    (doubt + half * like(largest)).store(&mut pack.doubt[first..]);
                }
            }
        }
    }

    /// Whether something is in all ways to a lamp from points around a middle; if not, what may be in some is
    /// listed.
    #[inline(always)]
    fn is_dark<S: Simd>(
        &self,
        simd: S,
        lamp: LampF64,
        id: u32,
        (from, reach): (Vec3<f64>, f64),
        seen: &mut Option<Seen>,
        room: &mut Room,
    ) -> bool {
        if let Some(seen) = seen
            && seen.id == id
        {
            let apart = from - seen.from;
            let left = seen.reach - ROOM * reach;
            if left > 0.0 && ROOM * dot3(apart, apart) < left * left {
                room.listed.clear();
                return seen.is_dark;
            }
        }
        for factor in [LARGER, 1.0] {
            let reach = factor * reach;
            let around = self.finder.beam(lamp, from, reach, Vec3::ZERO);
            let is_dark = self.finder.look_around(simd, &around, Some(id), room);
            if is_dark || room.listed.is_empty() {
                *seen = Some(Seen { id, from, reach, is_dark });
                return is_dark;
            }
        }
        false
    }

    #[inline(always)]
    fn beams<S: Simd>(
        &self,
        simd: S,
        lamp: LampF64,
        pack: &Pack,
        first: usize,
    ) -> Beam<WideF32<S>> {
        let (at, direction) = (load3(simd, &pack.at, first), load3(simd, &pack.direction, first));
        self.finder.beam(lamp, at, load(simd, &pack.error, first), direction)
    }

    /// Takes what is certainly or perhaps in the way from what a lamp gives.
    #[inline(always)]
    fn darken<S: Simd>(
        &self,
        simd: S,
        beams: &Beam<WideF32<S>>,
        pack: &mut Pack,
        first: usize,
        listed: &[usize],
    ) {
        let like = |number: f64| WideF32::splat(simd, number as f32);
        let mut state = like(in_the_way::NO);
        for &at in listed {
            let object = &self.finder.listed[at];
            let met = match object.shape {
                ListedShape::Sphere(r) => {
                    let Vec3([x, y, z]) = object.at;
                    beams.meets_sphere(Vec3([like(x), like(y), like(z)]), like(r))
                }
                ListedShape::Plane(normal) => beams.meets_plane(object.at, normal),
            };
            state = state.max(met);
        }
        let zero = like(0.0);
        let low = load(simd, &pack.given[0], first);
        let high = load(simd, &pack.given[1], first);
        let low = like(in_the_way::NO).lt(state).select(zero, low);
        let high = state.lt(like(in_the_way::YES)).select(high, zero);
        low.store(&mut pack.given[0][first..]);
        high.store(&mut pack.given[1][first..]);
    }

    /// Makes means of sums.
    fn divide(&self, first: usize, n_pixels: usize, pixels: &mut [Colors]) {
        let n_samples = self.job.lit.style.n_samples.across().pow(2) as f32;
        let leaves_out = self.job.lit.style.background == Background::LeftOut;
        for pixel in 0..n_pixels {
            let n = match leaves_out {
                true => self.job.n_counted(first + pixel) as f32,
                false => n_samples,
            };
            let (colors, lane) = (&mut pixels[pixel / LANES], pixel % LANES);
            for channel in 0..3 {
                colors.parts[channel][lane] /= n;
                colors.doubts[channel][lane] /= n;
            }
        }
    }

    /// Writes the bytes of means, and those that they leave open into `open`.
    #[inline(always)]
    fn write<S: Simd>(
        &self,
        simd: S,
        first_pixel: usize,
        colors: &[Colors],
        out: &mut [[u8; 3]],
        open: &mut Vec<usize>,
        counts: &mut StageCounts,
    ) {
        let like = |number: f32| WideF32::splat(simd, number);
        let (rounding, most) = (like(self.rounding), like(f32::MAX));
        let (mut n_ways, columns) = (like(0.0), columns());
        for (number, (colors, out)) in colors.iter().zip(out.chunks_mut(LANES)).enumerate() {
            let mut words = [0.0; LANES];
            let mut known = 0;
            for first in registers::<S>() {
                let doubt = load(simd, &colors.doubts[0], first);
                // Other places have what an earlier part left there.
                let is_here = load(simd, &columns, first).lt(like(out.len() as f32));
                let mut is_known = doubt.lt(most).and(is_here);
                let mut word = like(0.0);
                for (channel, place) in [1.0, 256.0, 65536.0].into_iter().enumerate() {
                    let part = load(simd, &colors.parts[channel], first);
                    let error = load(simd, &colors.doubts[channel], first) + part * rounding;
                    let (low, high) = (part - error, part + error);
                    let (byte, is_one) = Edges::close_bytes(simd, is_known, low, high);
                    is_known = is_known.and(is_one);
                    word = word + byte * like(place);
                }
                word.store(&mut words[first..]);
                let ways = load(simd, &colors.n_ways, first);
                n_ways = n_ways + is_known.select(ways, like(0.0));
                known |= is_known.bits() << first;
            }
            // Each word's last byte is written over by the next word: shorter pieces take longer.
            let mut bytes = [0; 3 * LANES + 1];
            for lane in 0..LANES {
                let word = (words[lane] as u32).to_le_bytes();
                bytes[3 * lane..3 * lane + 4].copy_from_slice(&word);
            }
            let (bytes, _) = bytes.as_chunks();
            out.copy_from_slice(&bytes[..out.len()]);
            let mut left = !known & ((1u64 << out.len()) - 1) as u32;
            while left != 0 {
                open.push(number * LANES + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
        let mut ways = [0.0; LANES];
        n_ways.store(&mut ways);
        counts.f32 += ways.iter().map(|&n| n as u64).sum::<u64>();
        self.write_background(first_pixel, out, open);
    }

    /// Where no sample of a pixel sees an object, its colour is known as it is.
    fn write_background(&self, first: usize, out: &mut [[u8; 3]], open: &mut Vec<usize>) {
        let (job, n) = (self.job, self.job.lit.style.n_samples.across() as usize);
        let start = job.first_sample(first);
        if !job.ids[start..start + out.len() * n].contains(&0) {
            return;
        }
        for (at, out) in out.iter_mut().enumerate() {
            if job.is_background(start + at * n) {
                *out = self.background;
            }
        }
        open.retain(|&at| !job.is_background(start + at * n));
    }
}

/// Colours of some places that are known up to `doubt` and their rounding.
fn fill(colors: &mut [Colors], places: std::ops::Range<usize>, color: [f32; 3], doubt: f32) {
    for at in places {
        let (colors, lane) = (&mut colors[at / LANES], at % LANES);
        for channel in 0..3 {
            colors.parts[channel][lane] = color[channel];
            colors.doubts[channel][lane] = doubt;
        }
        colors.n_ways[lane] = 0.0;
    }
}

fn columns() -> Row {
    std::array::from_fn(|lane| lane as f32)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::lit::{Certified, Lit, Work};
    use super::super::{Encoding, Lighting, Style};
    use super::*;
    use crate::control::Control;
    use crate::cpu::CpuTracer;
    use crate::kernel::Kernel;
    use crate::prepare::Prepared;
    use crate::rays::{Rays, View};
    use crate::scene::{
        Camera, Color, Light, Plane, Projection, Samples, Scene, Source, Sphere, parse_scene,
    };
    use crate::trace::{Hits, Wants};
    use crate::tracer::Tracer;

    /// Spheres over a floor in the light of a lamp, a sun and one at the eye, from far and from near, large and
    /// small.
    fn scene(rng: &mut ChaCha8Rng) -> Arc<Scene> {
        let size = 2f64.powi(rng.random_range(-8..16));
        let mut number = |least: f64, most: f64| rng.random_range(least..most);
        let mut vector = |reach: f64| {
            DVec3::new(number(-reach, reach), number(-reach, reach), number(-reach, reach))
        };
        let target = vector(1.0) * size;
        let away = vector(1.0).normalize();
        let color = Color([0.9, 0.5, 0.1]);
        let spheres = (0..4).map(|k| {
            let center = target + vector(2.0) * size;
            (Sphere { center, radius: size * 0.3 * f64::from(1 + k) }, color)
        });
        let spheres = spheres.collect();
        let normal = away + vector(0.5);
        let point = target - away * (1.5 * size);
        let plane = Plane { name: None, point, normal, color: Color([0.5; 3]) };
        let light = |source, shadows| Light {
            source,
            color: Color([1.0, 0.9, 0.7]),
            intensity: 0.6,
            shadows,
        };
        let lights = vec![
            light(Source::Point(target + away * (6.0 * size) + vector(4.0) * size), true),
            light(Source::Sun(vector(1.0) - away), true),
            light(Source::Eye, false),
        ];
        let distance = size * [4.0, 30.0][usize::from(vector(1.0).x > 0.0)];
        let projection = match vector(1.0).x > 0.0 {
            true => Projection::Perspective { fov_degrees: 180.0 * size / distance },
            false => Projection::Orthographic { height: 4.0 * size },
        };
        let camera = Camera { projection, ..Camera::new(target + away * distance, target) };
        let ambient = Some(Color([0.02; 3]));
        let planes = vec![plane];
        Arc::new(Scene {
            camera: Some(camera),
            spheres,
            planes,
            lights,
            ambient,
            ..Scene::default()
        })
    }

    /// Does something with the bytes' finder of a scene.
    fn with_finder(
        scene: &Arc<Scene>,
        n_samples: u32,
        run: &mut dyn FnMut(&Certified, &ByteFinder, &Pixels),
    ) {
        let view = View::new(scene.camera.as_ref().unwrap());
        let pixels = Pixels::whole(view, 37, 11).samples(n_samples);
        let rays = Rays::Pixels(pixels);
        let prepared = Prepared::new(Arc::clone(scene), Kernel::Certified, &rays).unwrap();
        let prepared = Arc::new(prepared);
        let mut hits = Hits::default();
        let mut tracer = CpuTracer::new(Arc::clone(&prepared), Wants::default());
        tracer.trace(&rays, &Control::default(), &mut hits).unwrap();
        let lighting = Lighting::new(scene, &pixels.view).unwrap();
        let style = Style { n_samples: Samples::nearest(n_samples), ..Style::new(Encoding::Srgb8) };
        let lit = Lit::new(Arc::clone(scene), lighting, style);
        let finder = Finder::new(&prepared, &rays, &lit.lighting);
        let job = Job { lit: &lit, ids: &hits.id, row: pixels.width as usize };
        let bytes = ByteFinder::new(&finder, &job, &pixels).unwrap();
        run(&Certified { job, finder: &finder }, &bytes, &pixels);
    }

    /// A floor whose every byte is on an edge, in a sun's light: each kind of pixel is decided exactly once.
    #[test]
    fn equal_questions_are_asked_once() {
        let text = std::fs::read_to_string(
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/lit/hard/byte_edge.toml"),
        );
        let scene = Arc::new(parse_scene(&text.unwrap(), "byte_edge.toml".as_ref()).unwrap());
        for n_samples in [1, 3] {
            with_finder(&scene, n_samples, &mut |certified, _, _| {
                let mut work: Work<[u8; 3]> = Work::new(certified);
                for pixel in 0..37 * 11 {
                    work.find(pixel, 1, 0);
                    assert_eq!(work.color(pixel, 0), [5; 3]);
                }
                assert_eq!(work.n_known(), 1, "{n_samples} samples");
            });
        }
    }

    struct FindRow<'a, 'b> {
        bytes: &'a ByteFinder<'b>,
        first: usize,
        n: usize,
        room: &'a mut ByteRoom,
    }

    impl pulp::WithSimd for FindRow<'_, '_> {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let FindRow { bytes, first, n, room } = self;
            room.seen.resize(bytes.finder.lamps.len(), None);
            room.samples.resize(n.div_ceil(LANES), Colors::default());
            bytes.find_row(simd, first, n, room);
        }
    }

    /// Of colours in f32: how many are known, and those that are farther from the ones in f64 than this share of
    /// their bounds.
    fn look(share: f64) -> (usize, Vec<String>) {
        let mut rng = ChaCha8Rng::seed_from_u64(1431);
        let (mut n_known, mut wrong) = (0, Vec::new());
        for number in 0..300 {
            let scene = scene(&mut rng);
            with_finder(&scene, 1, &mut |certified, bytes, pixels| {
                let (mut room, n) = (ByteRoom::default(), pixels.width as usize);
                let mut work: Work<[u8; 3]> = Work::new(certified);
                for row in 0..pixels.height as usize {
                    let first = row * n;
                    let find = FindRow { bytes, first, n, room: &mut room };
                    match number % 2 {
                        0 => pulp::Arch::new().dispatch(find),
                        _ => pulp::WithSimd::with_simd(find, pulp::Scalar),
                    }
                    work.find(first, n, 0);
                    for at in 0..n {
                        let (colors, lane) = (&room.samples[at / LANES], at % LANES);
                        for channel in 0..3 {
                            let part = f64::from(colors.parts[channel][lane]);
                            let doubt = f64::from(colors.doubts[channel][lane]);
                            if !doubt.is_finite() {
                                continue;
                            }
                            n_known += 1;
                            let [low, high] = work.bounds(at, channel);
                            let error = share * (doubt + part * f64::from(bytes.rounding));
                            if part + error < low || high < part - error {
                                wrong
                                    .push(format!("{scene:?} {first} + {at}: {part} {low} {high}"));
                            }
                        }
                    }
                }
            });
        }
        (n_known, wrong)
    }

    #[test]
    fn colours_are_within_their_bounds() {
        let (n_known, wrong) = look(1.0);
        assert!(wrong.is_empty(), "{} of {n_known}: {}", wrong.len(), wrong[0]);
        assert!(n_known > 200_000, "{n_known}");
    }

    /// The largest errors of all steps don't meet in one colour.
    #[test]
    fn sabotage_smaller_bounds_of_colours_are_noticed() {
        assert!(!look(1.0 / 12.0).1.is_empty());
    }

    /// f32 decides nearly all bytes, and those that it does are the ones of f64 or exact arithmetic.
    #[test]
    fn bytes_are_those_that_f64_finds() {
        let mut rng = ChaCha8Rng::seed_from_u64(1432);
        let (mut n_known, mut n_all) = (0, 0);
        for number in 0..60 {
            let scene = scene(&mut rng);
            let n_samples = 1 + number % 3;
            with_finder(&scene, n_samples, &mut |certified, bytes, pixels| {
                let mut work: Work<[u8; 3]> = Work::new(certified);
                let n = (pixels.width / n_samples) as usize;
                let (mut room, mut out) = (ByteRoom::default(), vec![[0; 3]; n]);
                for row in 0..(pixels.height / n_samples) as usize {
                    let counts = &mut StageCounts::default();
                    bytes.find(row * n, &mut out, &mut room, counts);
                    work.find(row * n, n, 0);
                    for (at, &found) in out.iter().enumerate() {
                        n_all += 1;
                        if !room.open.contains(&at)
                            && !certified
                                .job
                                .is_background(certified.job.first_sample(row * n + at))
                        {
                            n_known += 1;
                            assert_eq!(found, work.color(row * n + at, at), "{scene:?}");
                        }
                    }
                }
            });
        }
        assert!(n_known > n_all / 2 && n_all > 10_000, "{n_known} of {n_all}");
    }

    /// What an earlier part of a row left in the room counts for nothing.
    #[test]
    fn ways_are_counted_where_they_are() {
        let mut rng = ChaCha8Rng::seed_from_u64(1433);
        let mut n_ways = 0;
        for _ in 0..20 {
            let scene = scene(&mut rng);
            with_finder(&scene, 1, &mut |_, bytes, pixels| {
                let mut out = vec![[0; 3]; pixels.width as usize];
                let (mut used, mut fresh) = (ByteRoom::default(), ByteRoom::default());
                let [mut of_used, mut of_fresh] = [StageCounts::default(); 2];
                bytes.find(0, &mut out, &mut used, &mut StageCounts::default());
                bytes.find(0, &mut out[..5], &mut used, &mut of_used);
                bytes.find(0, &mut out[..5], &mut fresh, &mut of_fresh);
                assert_eq!(of_used, of_fresh);
                n_ways += of_fresh.f32;
            });
        }
        assert!(n_ways > 50, "{n_ways}");
    }

    /// By the worst sum, whose every rounding goes down by a whole unit.
    #[test]
    fn as_many_roundings_as_a_colour_takes_are_granted() {
        for n in [1.0, 2.0, 10.0, 300.0, 4096.0, 1e5, 1e6, 4e6] {
            let granted = f64::from(of_roundings(n).unwrap());
            let worst = (-n * (-<f32 as Bounded>::UNIT).ln_1p()).exp_m1();
            assert!(granted >= worst && granted <= 2.0 * worst, "{n}: {granted} {worst}");
            assert!(n * <f32 as Bounded>::UNIT < worst, "{n}: the first order alone would do");
        }
        assert_eq!(of_roundings(0.25 / <f32 as Bounded>::UNIT), None);
    }
}
