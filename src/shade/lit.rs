//! Hits → colours where a scene has light: every number that of exact arithmetic. f64 with bounds decides
//! nearly all pixels, each by the interval of its mean, where f32 has not decided them before ([`super::bytes`]); the rest
//! are decided exactly.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::bytes::{ByteFinder, ByteRoom};
use super::finder::{Finder, Given, PACKS, Room, Row, SamplePoint};
use super::in_f64::n_terms;
use super::lamp::{Lighting, Origin};
use super::mean::ExactMean;
use super::written::{Interval, Written};
use super::{Background, ColorCounts, PIXELS_AT_ONCE, Style, plain};
use crate::certify::{LANES, Pack, Points, registers};
use crate::control::Control;
use crate::error::Result;
use crate::exact::{exact, integer};
use crate::guard::UNIT_F64;
use crate::host;
use crate::kernel::Kernel;
use crate::prepare::Prepared;
use crate::rays::Pixels;
use crate::scene::{Color, Scene};
use crate::trace::{Coverage, Rays, StageCounts};
use crate::tracer::Tracer;
use crate::wide::{SideBySide, WideF64};

/// Shades the pictures of one scene and one camera.
#[derive(Debug)]
pub struct Lit {
    scene: Arc<Scene>,
    pub(super) lighting: Lighting,
    pub(super) style: Style,
}

impl Lit {
    /// A shader for a scene with this light.
    pub fn new(scene: Arc<Scene>, lighting: Lighting, style: Style) -> Lit {
        Lit { scene, lighting, style }
    }

    /// How pixels get their colours.
    pub fn style(&self) -> &Style {
        &self.style
    }

    /// How many samples of each pixel hit an object; `samples` and `ids` are those of [`Lit::shade`].
    pub fn coverage(&self, samples: &Pixels, ids: &[u32]) -> Coverage {
        let job = Job { lit: self, ids, row: samples.width as usize };
        let n_hits = |pixel| job.samples(pixel).filter(|&at| ids[at] != 0).count() as u16;
        let n_samples = self.style.n_samples.across().pow(2);
        let n_pixels = ids.len() / n_samples as usize;
        let n_hits = (0..n_pixels).into_par_iter().map(n_hits).collect();
        Coverage { n_hits, n_samples: n_samples as u16 }
    }

    /// Replaces `colors` by those of pixels. `samples` are the rays of their samples, a rectangle of
    /// whole pixels of a picture that is [`Lit`]'s number of samples times as large, `ids` what they
    /// see, and `prepared` is of that picture.
    ///
    /// `device` traces them; it may light what a kernel without a proof sees. Returns where the colours are from,
    /// and how many ways to lamps each stage decided.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled; those of [`Tracer::trace`].
    pub fn shade<T: Written>(
        &self,
        (prepared, samples, ids): (&Prepared, &Pixels, &[u32]),
        device: Option<&mut (dyn Tracer + '_)>,
        control: &Control,
        colors: &mut Vec<T>,
    ) -> Result<(ColorCounts, StageCounts)> {
        let n_pixels = ids.len() / self.style.n_samples.across().pow(2) as usize;
        let job = Job { lit: self, ids, row: samples.width as usize };
        colors.clear();
        colors.resize(n_pixels, T::default());
        if prepared.kernel != Kernel::Certified {
            let is_lit_there = plain::shade(&job, (prepared, samples), device, control, colors)?;
            let colors = match is_lit_there {
                true => ColorCounts { device: n_pixels as u64, ..ColorCounts::default() },
                false => ColorCounts { cpu: n_pixels as u64, ..ColorCounts::default() },
            };
            return Ok((colors, plain::counts(&job, n_pixels, prepared.kernel == Kernel::Double)));
        }
        let rays = Rays::Pixels(*samples);
        prepared.prepare_shadows(control)?;
        let finder = Finder::new(prepared, &rays, &self.lighting);
        let counts = Certified { job, finder: &finder }.run(samples, control, colors)?;
        Ok((ColorCounts { cpu: n_pixels as u64, ..ColorCounts::default() }, counts))
    }
}

/// Rows whose parts follow each other: what is in the way of one row is in the cache for the next one.
const STRIP_ROWS: usize = 8;

/// More than what underflows in all that lamps give a point: `2⁻¹⁰⁷⁴` of a weight, a product and a sum each, of fewer than
/// `2⁷⁰` lamps. Where there is so much other light that it does not count, it is below a rounding of that.
const UNDERFLOW: f64 =
    1.0 / ((1u128 << 100) as f64 * (1u128 << 100) as f64 * (1u128 << 100) as f64);

/// Most colours that one thread keeps of pixels that were decided exactly.
const MOST_KNOWN: usize = 1 << 12;

/// Most pixels of a row that are painted before the next row.
const MOST_COLUMNS: usize = 128;

/// The pixels of one call.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub lit: &'a Lit,
    pub ids: &'a [u32],
    /// Samples of a row.
    pub row: usize,
}

impl Job<'_> {
    pub fn run<T: Send>(
        &self,
        control: &Control,
        out: &mut [T],
        pixel: impl Fn(usize) -> T + Sync,
    ) -> Result<()> {
        let part = self.part();
        out.par_chunks_mut(part).enumerate().try_for_each(|(number, out)| {
            control.check()?;
            host::check()?;
            self.advance(control, out.len());
            for (at, out) in (number * part..).zip(out) {
                *out = pixel(at);
            }
            Ok(())
        })
    }

    /// True where no sample of a pixel sees an object; its first one is `first`.
    pub fn is_background(&self, first: usize) -> bool {
        let n = self.lit.style.n_samples.across() as usize;
        let mut rows = (0..n).map(|row| &self.ids[first + row * self.row..][..n]);
        rows.all(|row| row.iter().all(|&id| id == 0))
    }

    /// True where none of so many neighbours from `first` on sees an object.
    fn is_background_to(&self, first: usize, n: usize) -> bool {
        self.ids[first..first + n].iter().fold(0, |any, &id| any | id) == 0
    }

    /// The number that the sum of a pixel's samples is divided by.
    pub fn n_counted(&self, pixel: usize) -> u64 {
        match self.lit.style.background {
            Background::Shown | Background::Black => {
                self.lit.style.n_samples.across().pow(2).into()
            }
            Background::LeftOut => {
                let n_hits = self.samples(pixel).filter(|&at| self.ids[at] != 0).count();
                n_hits.max(1) as u64
            }
        }
    }

    /// Counts the light of pixels that are about to get it.
    pub fn advance(&self, control: &Control, n_pixels: usize) {
        control.advance(n_pixels as u64 * u64::from(self.lit.style.n_samples.across()).pow(2));
    }

    /// Pixels of a row that take a moment, between which Ctrl-C is looked at.
    pub fn part(&self) -> usize {
        let n_questions =
            self.lit.style.n_samples.across().pow(2) as usize * (self.lit.lighting.lamps.len() + 1);
        (PIXELS_AT_ONCE / n_questions).clamp(16, MOST_COLUMNS)
    }

    /// Index of a pixel's first sample.
    pub fn first_sample(&self, pixel: usize) -> usize {
        let (n, n_columns) = (
            self.lit.style.n_samples.across() as usize,
            self.row / self.lit.style.n_samples.across() as usize,
        );
        pixel / n_columns * n * self.row + pixel % n_columns * n
    }

    /// Indices of a pixel's samples.
    pub fn samples(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let (n, row) = (self.lit.style.n_samples.across() as usize, self.row);
        let first = self.first_sample(pixel);
        (0..n * n).map(move |sample| first + sample / n * row + sample % n)
    }

    pub fn color(&self, id: u32) -> [f64; 3] {
        match id == 0 && self.lit.style.background != Background::Shown {
            true => Color::BLACK.0,
            false => self.lit.scene.color(id).0,
        }
    }
}

/// The pixels of the kernel `certified`.
#[derive(Clone, Copy)]
pub(super) struct Certified<'a> {
    pub job: Job<'a>,
    pub finder: &'a Finder<'a>,
}

impl Certified<'_> {
    /// Fills `out` with the colours of all pixels.
    fn run<T: Written>(
        &self,
        samples: &Pixels,
        control: &Control,
        out: &mut [T],
    ) -> Result<StageCounts> {
        let Certified { ref job, finder } = *self;
        let n_samples = job.lit.style.n_samples.across() as usize;
        let (row, part) = (job.row / n_samples, job.part());
        let background = T::of_bounds(&job.color(0).map(Interval::of)).unwrap_or_default();
        let are_bytes = T::as_bytes(&mut []).is_some();
        let bytes = are_bytes.then(|| ByteFinder::new(finder, job, samples)).flatten();
        let paint =
            |work: &mut Work<T>, first: usize, number: usize, out: &mut [T]| -> Result<()> {
                control.check()?;
                host::check()?;
                job.advance(control, out.len());
                let first_sample = job.first_sample(first);
                if n_samples == 1 && job.is_background_to(first_sample, out.len()) {
                    out.fill(background);
                    return Ok(());
                }
                if let Some(bytes) = &bytes
                    && let Some(out) = T::as_bytes(out)
                {
                    bytes.find(first, out, &mut work.bytes, &mut work.counts);
                }
                if bytes.is_some() {
                    work.write_open(first, out);
                    return Ok(());
                }
                work.find(first, out.len(), number);
                if n_samples == 1 {
                    work.write(first, background, out);
                    return Ok(());
                }
                for (at, out) in out.iter_mut().enumerate() {
                    *out = match job.is_background(first_sample + at * n_samples) {
                        true => background,
                        false => work.color(first + at, at),
                    };
                }
                Ok(())
            };
        out.par_chunks_mut(row.max(1) * STRIP_ROWS)
            .enumerate()
            .try_fold(
                || Work::new(self),
                |mut work, (strip, out)| {
                    for column in (0..row).step_by(part) {
                        for (y, out) in out.chunks_mut(row).enumerate() {
                            let first = (strip * STRIP_ROWS + y) * row + column;
                            let out = &mut out[column..(column + part).min(row)];
                            paint(&mut work, first, column / part, out)?;
                        }
                    }
                    Ok(work)
                },
            )
            .map(|work: Result<Work<T>>| work.map(|work| work.counts))
            .try_reduce(StageCounts::default, |mut sum, other| {
                sum.add(other);
                Ok(sum)
            })
    }

    /// Decides a pixel exactly. `known` has the colours of pixels that were decided before, by what their samples see, where that
    /// says all.
    fn exact<T: Written>(
        &self,
        pixel: usize,
        bounds: &[Interval; 3],
        known: &mut HashMap<Vec<u32>, T>,
        counts: &mut StageCounts,
    ) -> T {
        let sample = |at: usize| SamplePoint::new(self.finder, at, self.job.ids[at]);
        let samples: Vec<SamplePoint> = self.job.samples(pixel).map(sample).collect();
        let Some(seen) = self.seen_evenly(&samples, counts) else {
            return self.exact_mean(pixel, &samples, bounds, counts);
        };
        if let Some(color) = known.get(&seen) {
            return *color;
        }
        // Its ways are counted already.
        let color = self.exact_mean(pixel, &samples, bounds, &mut StageCounts::default());
        if known.len() < MOST_KNOWN {
            known.insert(seen, color);
        }
        color
    }

    /// What says all of the colour of samples that see planes in the light of suns, or nothing: how many of them see which plane
    /// in which suns' light. On one side of a plane each sun's is the same everywhere. `None` for others.
    fn seen_evenly(&self, samples: &[SamplePoint], counts: &mut StageCounts) -> Option<Vec<u32>> {
        let (lamps, finder) = (&self.job.lit.lighting.lamps, self.finder);
        let is_even = |sample: &SamplePoint| {
            sample.id == 0 || sample.in_f64.is_some() && finder.is_plane(sample.id)
        };
        let are_suns = lamps.iter().all(|lamp| matches!(lamp.origin, Origin::Sun(_)));
        if !(are_suns && samples.iter().all(is_even)) {
            return None;
        }
        // For each kind of sample its object, its side with its suns, and how often it is there.
        let n_words = 3 + lamps.len() / 32;
        let (mut seen, mut one): (Vec<u32>, Vec<u32>) = Default::default();
        for sample in samples {
            one.clear();
            one.resize(n_words, 0);
            one[0] = sample.id;
            if sample.id != 0 {
                let (point, _) = sample.in_f64.as_ref()?;
                let faces_front = finder.faces_front(sample.id, point);
                one[1] = u32::from(faces_front);
                for (index, lamp) in lamps.iter().enumerate() {
                    let gives = finder.lights_plane(index, sample.id, faces_front)
                        && finder.is_seen((index, lamp), sample, counts);
                    let bit = index + 1;
                    one[1 + bit / 32] |= u32::from(gives) << (bit % 32);
                }
            }
            let is_alike = |kind: &&mut [u32]| kind[..n_words - 1] == one[..n_words - 1];
            match seen.chunks_mut(n_words).find(is_alike) {
                Some(kind) => kind[n_words - 1] += 1,
                None => {
                    one[n_words - 1] = 1;
                    seen.extend_from_slice(&one);
                }
            }
        }
        Some(seen)
    }

    fn exact_mean<T: Written>(
        &self,
        pixel: usize,
        samples: &[SamplePoint],
        bounds: &[Interval; 3],
        counts: &mut StageCounts,
    ) -> T {
        let lighting = &self.job.lit.lighting;
        let mut mean = ExactMean::new(self.job.n_counted(pixel) * u64::from(lighting.n_shares));
        let shares = integer(lighting.n_shares.into());
        for sample in samples {
            let color = self.job.color(sample.id).map(exact);
            let Some((point, shape)) = sample.exactly(self.finder) else {
                for channel in 0..3 {
                    mean.add(channel, &(&color[channel] * &shares));
                }
                continue;
            };
            for channel in 0..3 {
                let ambient = exact(lighting.ambient[channel]) * &shares;
                mean.add(channel, &(ambient * &color[channel]));
            }
            for (index, lamp) in lighting.lamps.iter().enumerate() {
                if let Some(beam) = self.finder.exact_beam(lamp, point)
                    && let Some(cosine) = beam.cosine(shape)
                    && self.finder.is_seen((index, lamp), sample, counts)
                {
                    let weight = &lamp.exact_weight;
                    let weights = std::array::from_fn(|k| &weight[k] * &color[k]);
                    mean.add_light(cosine, weights);
                }
            }
        }
        T::of_exact(&mean, bounds)
    }
}

/// Samples side by side on their way to bounds.
pub(super) struct Work<'a, T> {
    certified: &'a Certified<'a>,
    points: Points,
    /// Bounds of the colours of the samples in the rows of a part, [`LANES`] together.
    colors: Vec<[[Row; 2]; 3]>,
    /// Pixels of a part whose colour is not found side by side.
    open: Vec<usize>,
    bytes: ByteRoom,
    room: Room,
    /// See [`Certified::exact`].
    known: HashMap<Vec<u32>, T>,
    /// What the sum of a pixel's bounds may be off by, relative.
    error: f64,
    pub counts: StageCounts,
}

impl<'a, T: Written> Work<'a, T> {
    pub fn new(certified: &'a Certified<'a>) -> Work<'a, T> {
        let Certified { job, .. } = certified;
        let n_lamps = job.lit.lighting.lamps.len();
        let part = job.part() * job.lit.style.n_samples.across() as usize;
        // Of `n` terms, products of three numbers: `n + 4` roundings at most.
        let n_terms = n_terms(job.lit.style.n_samples.across(), &job.lit.lighting);
        Work {
            certified,
            points: Points::default(),
            colors: Vec::new(),
            open: Vec::new(),
            bytes: ByteRoom::default(),
            known: HashMap::new(),
            room: Room::new(n_lamps, job.row.div_ceil(part) * part.div_ceil(LANES)),
            error: n_terms as f64 * UNIT_F64,
            counts: StageCounts::default(),
        }
    }

    /// Finds the colours of the samples of `n` pixels from `first` on, which are the part of a row with this
    /// number.
    pub fn find(&mut self, first: usize, n: usize, number: usize) {
        self.find_some(first, n, number, |_| true);
    }

    /// The same of those that are asked for; the others have the light of none.
    fn find_some(
        &mut self,
        first: usize,
        n: usize,
        number: usize,
        is_asked: impl Fn(usize) -> bool,
    ) {
        let Certified { job, finder } = self.certified;
        self.colors.clear();
        let n_samples = job.lit.style.n_samples.across() as usize;
        for row in 0..n_samples {
            let start = job.first_sample(first) + row * job.row;
            let ids = &job.ids[start..start + n * n_samples];
            self.points.find(&finder.surfaces, start, ids);
            for at in (0..n * n_samples).filter(|at| !is_asked(at / n_samples)) {
                self.points.packs[at / LANES].is_object[at % LANES] = 0.0;
            }
            let (colors, packs) = (&mut self.colors, &self.points.packs[..]);
            let (room, counts) = (&mut self.room, &mut self.counts);
            let column = number * (job.part() * n_samples).div_ceil(LANES);
            let find = FindColors { finder, job, packs, column, colors, room, counts };
            pulp::Arch::new().dispatch(find);
        }
    }

    /// Writes those bytes that f32 left open, of pixels from `first` on.
    fn write_open(&mut self, first: usize, out: &mut [T]) {
        let open = std::mem::take(&mut self.bytes.open);
        for some in open.chunk_by(|a, b| a / LANES == b / LANES) {
            // With their neighbours, as these mostly see the same object.
            let start = some[0] / LANES * LANES;
            let n = LANES.min(out.len() - start);
            self.find_some(first + start, n, 0, |at| some.contains(&(start + at)));
            for &at in some {
                out[at] = self.color(first + at, at - start);
            }
        }
        self.bytes.open = open;
    }

    /// Writes the colours of pixels with one sample each, from `first` on.
    fn write(&mut self, first: usize, background: T, out: &mut [T]) {
        let (packs, colors, error) = (&self.points.packs[..], &self.colors[..], self.error);
        let open = &mut self.open;
        let write = WriteColors { packs, colors, error, background, out: &mut *out, open };
        pulp::Arch::new().dispatch(write);
        for at in std::mem::take(&mut self.open) {
            out[at] = self.color(first + at, at);
        }
    }

    /// Kinds of pixels that were decided exactly.
    #[cfg(test)]
    pub fn n_known(&self) -> usize {
        self.known.len()
    }

    /// Bounds of a channel of the sample at a place of the row.
    #[cfg(test)]
    pub fn bounds(&self, at: usize, channel: usize) -> [f64; 2] {
        self.colors[at / LANES][channel].map(|bound| bound[at % LANES])
    }

    /// The colour of `pixel`, the one `at` in a part.
    pub fn color(&mut self, pixel: usize, at: usize) -> T {
        let Certified { job, .. } = self.certified;
        let n_samples = job.lit.style.n_samples.across() as usize;
        let packs_of_row = self.colors.len() / n_samples;
        let mut bounds = [Interval::default(); 3];
        for row in 0..n_samples {
            let colors = &self.colors[row * packs_of_row..];
            for column in at * n_samples..(at + 1) * n_samples {
                let (pack, lane) = (&colors[column / LANES], column % LANES);
                for channel in 0..3 {
                    bounds[channel].low += pack[channel][0][lane];
                    bounds[channel].high += pack[channel][1][lane];
                }
            }
        }
        let (narrower, wider) = (1.0 - self.error, 1.0 + self.error);
        for Interval { low, high } in &mut bounds {
            (*low, *high) = (*low * narrower, *high * wider);
        }
        if n_samples > 1 {
            let n_counted = job.n_counted(pixel) as f64;
            for Interval { low, high } in &mut bounds {
                (*low, *high) = (*low / n_counted, *high / n_counted);
            }
        }
        let Work { known, counts, .. } = self;
        T::of_bounds(&bounds).unwrap_or_else(|| self.certified.exact(pixel, &bounds, known, counts))
    }
}

/// The colours of some points, compiled for each instruction set that the processor may have.
struct FindColors<'a> {
    finder: &'a Finder<'a>,
    job: &'a Job<'a>,
    packs: &'a [Pack],
    /// That of the first pack.
    column: usize,
    colors: &'a mut Vec<[[Row; 2]; 3]>,
    room: &'a mut Room,
    counts: &'a mut StageCounts,
}

impl pulp::WithSimd for FindColors<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let FindColors { finder, job, packs, column, colors, room, counts } = self;
        let lighting = &job.lit.lighting;
        for (number, packs) in packs.chunks(PACKS).enumerate() {
            let column = column + number * PACKS;
            let first = colors.len();
            let ambient = |part: f64| [(part - UNDERFLOW).max(0.0), part + UNDERFLOW];
            let ambient = lighting.ambient.map(|part| ambient(part).map(|bound| [bound; LANES]));
            colors.resize(first + packs.len(), ambient);
            let light = &mut colors[first..];
            let has_objects = packs.iter().any(|pack| pack.id != [0; LANES]);
            let lamps = if has_objects { &lighting.lamps[..] } else { &[] };
            for lamp in lamps.iter().enumerate() {
                let given = finder.light(simd, lamp, (column, packs), room, counts);
                for (light, given) in light.iter_mut().zip(&given) {
                    add_light(simd, lamp.1.weight, given, light);
                }
            }
            for (pack, light) in packs.iter().zip(light) {
                take_color(simd, job, pack, light);
            }
        }
    }
}

/// The colours of the numbers of some points, compiled for each instruction set that the processor may have.
struct WriteColors<'a, T> {
    packs: &'a [Pack],
    colors: &'a [[[Row; 2]; 3]],
    /// [`Work::error`]
    error: f64,
    background: T,
    out: &'a mut [T],
    /// Gets the places in `out` of those that their bounds leave open.
    open: &'a mut Vec<usize>,
}

impl<T: Written> pulp::WithSimd for WriteColors<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let WriteColors { packs, colors, error, background, out, open } = self;
        let (narrower, wider) = (1.0 - error, 1.0 + error);
        for (number, out) in out.chunks_mut(LANES).enumerate() {
            let (ids, mut bounds) = (&packs[number].id, colors[number]);
            for channel in 0..3 {
                for (side, factor) in [narrower, wider].into_iter().enumerate() {
                    for first in registers::<S>() {
                        let bound = &mut bounds[channel][side][first..];
                        (WideF64::load(simd, bound) * WideF64::splat(simd, factor)).store(bound);
                    }
                }
            }
            let mut found = [T::default(); LANES];
            let is_known = T::of_rows(&bounds, &mut found);
            out.copy_from_slice(&found[..out.len()]);
            if ids.contains(&0) {
                for (out, _) in out.iter_mut().zip(ids).filter(|(_, id)| **id == 0) {
                    *out = background;
                }
            }
            if is_known != [true; LANES] {
                let is_open = |lane: &usize| ids[*lane] != 0 && !is_known[*lane];
                open.extend((0..out.len()).filter(is_open).map(|lane| number * LANES + lane));
            }
        }
    }
}

/// Adds a lamp's light.
#[inline(always)]
fn add_light<S: pulp::Simd>(simd: S, weight: [f64; 3], given: &Given, light: &mut [[Row; 2]; 3]) {
    for first in registers::<S>() {
        let low = WideF64::load(simd, &given.low[first..]);
        let high = WideF64::load(simd, &given.high[first..]);
        for channel in 0..3 {
            let weight = low.like(weight[channel]);
            let [lows, highs] = &mut light[channel];
            (WideF64::load(simd, &lows[first..]) + weight * low).store(&mut lows[first..]);
            (WideF64::load(simd, &highs[first..]) + weight * high).store(&mut highs[first..]);
        }
    }
}

/// Makes colours of the light of some points. The background has its colour as it is.
#[inline(always)]
fn take_color<S: pulp::Simd>(simd: S, job: &Job, pack: &Pack, light: &mut [[Row; 2]; 3]) {
    let mut color = job.color(pack.id[0]);
    let mut colors = color.map(|part| [part; LANES]);
    if pack.id != [pack.id[0]; LANES] {
        for lane in 1..LANES {
            if pack.id[lane] != pack.id[lane - 1] {
                color = job.color(pack.id[lane]);
            }
            for channel in 0..3 {
                colors[channel][lane] = color[channel];
            }
        }
    }
    for first in registers::<S>() {
        let zero = WideF64::splat(simd, 0.0);
        let is_object = zero.lt(WideF64::load(simd, &pack.is_object[first..]));
        for channel in 0..3 {
            let color = WideF64::load(simd, &colors[channel][first..]);
            for side in 0..2 {
                let bound = &mut light[channel][side][first..];
                let here = is_object.select(WideF64::load(simd, bound), zero.like(1.0));
                (color * here).store(bound);
            }
        }
    }
}
