//! Hits → colours where a scene has light or a pixel several samples: every number that of exact
//! arithmetic. f64 with bounds decides nearly all pixels, each by the interval of its mean; the rest are
//! decided exactly.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::sync::Arc;

use rayon::prelude::*;

use super::finder::{Finder, Row};
use super::in_f64::n_terms;
use super::lamp::Lighting;
use super::mean::ExactMean;
use super::{Background, Colors, PIXELS_AT_ONCE, Style, plain};
use crate::certify::{Completer, LANES, Pack, Points};
use crate::control::Control;
use crate::error::Result;
use crate::exact::{ExactPoint, Shape, exact, integer};
use crate::guard::UNIT_F64;
use crate::host;
use crate::kernel::Kernel;
use crate::prepare::Prepared;
use crate::rays::Pixels;
use crate::scene::{Color, Edges, Scene};
use crate::trace::{Coverage, Rays, StageCounts};

/// Shades the pictures of one scene and one camera.
#[derive(Debug)]
pub struct Lit {
    scene: Arc<Scene>,
    pub(super) lighting: Option<Lighting>,
    pub(super) style: Style,
}

/// Bounds of a number.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Interval {
    low: f64,
    high: f64,
}

impl Lit {
    /// A shader for a scene with light, or for pixels of several samples.
    pub fn new(scene: Arc<Scene>, lighting: Option<Lighting>, style: Style) -> Lit {
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
        let n_samples = self.style.n_samples.pow(2);
        let n_pixels = ids.len() / n_samples as usize;
        let n_hits = (0..n_pixels).into_par_iter().map(n_hits).collect();
        Coverage { n_hits, n_samples: n_samples as u16 }
    }

    /// Replaces `colors` by those of pixels. `samples` are the rays of their samples, a rectangle of
    /// whole pixels of a picture that is [`Lit`]'s number of samples times as large, `ids` what they
    /// see, and `prepared` is of that picture.
    ///
    /// Returns how many ways to lamps each stage decided.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn shade(
        &self,
        prepared: &Prepared,
        samples: &Pixels,
        ids: &[u32],
        control: &Control,
        colors: &mut Colors,
    ) -> Result<StageCounts> {
        let n_pixels = ids.len() / self.style.n_samples.pow(2) as usize;
        let job = Job { lit: self, ids, row: samples.width as usize };
        if prepared.kernel != Kernel::Certified {
            return plain::with_means(&job, prepared, samples, self.style.epsilon, |mean| {
                let code = |edges: &Edges, at| mean(at).map(|x| edges.number(x));
                let (srgb8, srgb16) = (Edges::srgb8(), Edges::srgb16());
                match colors {
                    Colors::Srgb8(out) => job.run(n_pixels, control, out, |at, _| {
                        code(srgb8, at).map(|code| code as u8)
                    }),
                    Colors::Srgb16(out) => {
                        job.run(n_pixels, control, out, |at, _| code(srgb16, at))
                    }
                    Colors::Linear(out) => {
                        job.run(n_pixels, control, out, |at, _| mean(at).map(|x| x as f32))
                    }
                }?;
                Ok(plain::counts(&job, n_pixels, prepared.kernel == Kernel::Double))
            });
        }
        let rays = Rays::Pixels(*samples);
        let finder = Finder::new(prepared, &rays, self.lighting.as_ref());
        let job = Certified { job, finder: &finder };
        match colors {
            Colors::Srgb8(out) => {
                let edges = Edges::srgb8();
                job.run(n_pixels, control, out, |bounds, at, counts| {
                    job.code(bounds, at, edges, 255, counts).map(|code| code as u8)
                })
            }
            Colors::Srgb16(out) => {
                let edges = Edges::srgb16();
                job.run(n_pixels, control, out, |bounds, at, counts| {
                    job.code(bounds, at, edges, u16::MAX, counts)
                })
            }
            Colors::Linear(out) => {
                job.run(n_pixels, control, out, |bounds, at, n| job.linear(bounds, at, n))
            }
        }
    }
}

/// The pixels of one call.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub lit: &'a Lit,
    pub ids: &'a [u32],
    /// Samples of a row.
    pub row: usize,
}

impl Job<'_> {
    fn run<T: Send + Default + Copy>(
        &self,
        n_pixels: usize,
        control: &Control,
        out: &mut Vec<[T; 3]>,
        pixel: impl Fn(usize, &mut StageCounts) -> [T; 3] + Sync,
    ) -> Result<StageCounts> {
        out.clear();
        out.resize(n_pixels, [T::default(); 3]);
        let part = self.part();
        out.par_chunks_mut(part)
            .enumerate()
            .map(|(number, out)| {
                control.check()?;
                host::check()?;
                self.advance(control, out.len());
                let mut counts = StageCounts::default();
                for (at, out) in (number * part..).zip(out) {
                    *out = pixel(at, &mut counts);
                }
                Ok(counts)
            })
            .try_reduce(StageCounts::default, |mut sum, other| {
                sum.add(other);
                Ok(sum)
            })
    }

    /// The object that all samples of a pixel see, the first one of which is `first`, if it is one.
    fn only_id(&self, first: usize) -> Option<u32> {
        let (n, id) = (self.lit.style.n_samples as usize, self.ids[first]);
        let mut rows = (0..n).map(|row| &self.ids[first + row * self.row..][..n]);
        rows.all(|row| row.iter().all(|&other| other == id)).then_some(id)
    }

    /// The number that the sum of a pixel's samples is divided by.
    pub fn n_counted(&self, pixel: usize) -> u64 {
        match self.lit.style.background {
            Background::Shown | Background::Black => self.lit.style.n_samples.pow(2).into(),
            Background::LeftOut => {
                let n_hits = self.samples(pixel).filter(|&at| self.ids[at] != 0).count();
                n_hits.max(1) as u64
            }
        }
    }

    /// Counts the light of pixels that are about to get it.
    pub fn advance(&self, control: &Control, n_pixels: usize) {
        if self.lit.lighting.is_some() {
            control.advance(n_pixels as u64 * u64::from(self.lit.style.n_samples).pow(2));
        }
    }

    /// Pixels that take a moment, between which Ctrl-C is looked at.
    pub fn part(&self) -> usize {
        let n_lamps = self.lit.lighting.as_ref().map_or(0, |lighting| lighting.lamps.len());
        let n_questions = self.lit.style.n_samples.pow(2) as usize * (n_lamps + 1);
        (PIXELS_AT_ONCE / n_questions).clamp(16, PIXELS_AT_ONCE / 8)
    }

    /// Index of a pixel's first sample.
    pub fn first_sample(&self, pixel: usize) -> usize {
        let (n, n_columns) =
            (self.lit.style.n_samples as usize, self.row / self.lit.style.n_samples as usize);
        pixel / n_columns * n * self.row + pixel % n_columns * n
    }

    /// Indices of a pixel's samples.
    pub fn samples(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let (n, row) = (self.lit.style.n_samples as usize, self.row);
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
    /// Fills `out` with what `pixel` makes of the bounds of each pixel's mean.
    fn run<T: Send + Default + Copy>(
        &self,
        n_pixels: usize,
        control: &Control,
        out: &mut Vec<[T; 3]>,
        pixel: impl Fn([Interval; 3], usize, &mut StageCounts) -> [T; 3] + Sync,
    ) -> Result<StageCounts> {
        out.clear();
        out.resize(n_pixels, [T::default(); 3]);
        let row = self.job.row / self.job.lit.style.n_samples as usize;
        let part = self.job.part();
        let rows = out.par_chunks_mut(row).enumerate();
        rows.map(|(y, out)| {
            let mut work = Work::new(self);
            for (number, out) in out.chunks_mut(part).enumerate() {
                control.check()?;
                host::check()?;
                let first = y * row + number * part;
                work.find(first, out.len());
                self.job.advance(control, out.len());
                let (first_sample, n) = (self.job.first_sample(first), out.len());
                for (at, out) in out.iter_mut().enumerate() {
                    let bounds = work.bounds(first + at, first_sample, at, n);
                    *out = pixel(bounds, first + at, &mut work.counts);
                }
            }
            Ok(work.counts)
        })
        .try_reduce(StageCounts::default, |mut sum, other| {
            sum.add(other);
            Ok(sum)
        })
    }

    pub fn code(
        &self,
        bounds: [Interval; 3],
        pixel: usize,
        edges: &Edges,
        most: u16,
        counts: &mut StageCounts,
    ) -> [u16; 3] {
        let low = bounds.map(|b| edges.number(b.low));
        if low == bounds.map(|b| edges.number(b.high)) {
            return low;
        }
        self.exact(pixel, counts, |mean, channel| {
            mean.code(channel, low[channel], most, |code| edges.range(code).0)
        })
    }

    pub fn linear(
        &self,
        bounds: [Interval; 3],
        pixel: usize,
        counts: &mut StageCounts,
    ) -> [f32; 3] {
        let low = bounds.map(|b| b.low as f32);
        if low == bounds.map(|b| b.high as f32) {
            return low;
        }
        self.exact(pixel, counts, |mean, channel| mean.nearest_f32(channel, low[channel]))
    }

    /// Decides a pixel's channels exactly.
    fn exact<T>(
        &self,
        pixel: usize,
        counts: &mut StageCounts,
        decide: impl Fn(&ExactMean, usize) -> T,
    ) -> [T; 3] {
        let lighting = self.job.lit.lighting.as_ref();
        let n_shares = lighting.map_or(1, |lighting| lighting.n_shares);
        let sample = |at: usize| {
            let id = self.job.ids[at];
            let point: Option<(ExactPoint, Shape)> =
                lighting.and_then(|_| self.finder.stage.exact_point(at, id));
            (at, id, point)
        };
        let samples: Vec<_> = self.job.samples(pixel).map(sample).collect();
        let mut mean = ExactMean::new(self.job.n_counted(pixel) * u64::from(n_shares));
        let shares = integer(n_shares.into());
        for (at, id, point) in &samples {
            let color = self.job.color(*id).map(exact);
            match (lighting, point) {
                (Some(lighting), Some((point, shape))) => {
                    for channel in 0..3 {
                        let ambient = exact(lighting.ambient[channel]) * &shares;
                        mean.add(channel, &(ambient * &color[channel]));
                    }
                    for (index, lamp) in lighting.lamps.iter().enumerate() {
                        if let Some(beam) = self.finder.exact_beam(lamp, point)
                            && let Some(cosine) = beam.cosine(shape)
                            && self.finder.is_seen(index, lamp, &beam, *at, *id, counts)
                        {
                            let weight = &lamp.exact_weight;
                            let weights = std::array::from_fn(|k| &weight[k] * &color[k]);
                            mean.add_light(cosine, weights);
                        }
                    }
                }
                _ => {
                    for channel in 0..3 {
                        mean.add(channel, &(&color[channel] * &shares));
                    }
                }
            }
        }
        std::array::from_fn(|channel| decide(&mean, channel))
    }
}

/// Samples side by side on their way to bounds.
pub(super) struct Work<'a> {
    certified: &'a Certified<'a>,
    completer: Option<Box<Completer<'a>>>,
    points: Points,
    /// The light that each sample gets, row by row of the part.
    light: Vec<[[Row; 2]; 3]>,
    /// See [`Finder::light`], for each lamp.
    last: Vec<Option<usize>>,
    pub counts: StageCounts,
}

impl<'a> Work<'a> {
    pub fn new(certified: &'a Certified<'a>) -> Work<'a> {
        let lighting = certified.job.lit.lighting.as_ref();
        Work {
            certified,
            completer: lighting.map(|_| Completer::new(&certified.finder.stage)),
            points: Points::default(),
            light: Vec::new(),
            last: vec![None; lighting.map_or(0, |lighting| lighting.lamps.len())],
            counts: StageCounts::default(),
        }
    }

    /// Finds the light of the samples of `n` pixels in a row, from `first` on.
    pub fn find(&mut self, first: usize, n: usize) {
        let Certified { job, finder } = self.certified;
        let (Some(lighting), Some(completer)) = (&job.lit.lighting, &mut self.completer) else {
            return;
        };
        self.light.clear();
        let n_samples = job.lit.style.n_samples as usize;
        for row in 0..n_samples {
            let start = job.first_sample(first) + row * job.row;
            let ids = &job.ids[start..start + n * n_samples];
            self.points.find(completer, start, ids);
            let (light, packs) = (&mut self.light, &self.points.packs[..]);
            let (last, counts) = (&mut self.last[..], &mut self.counts);
            pulp::Arch::new().dispatch(FindLight { finder, lighting, packs, light, last, counts });
        }
    }

    /// Bounds of the mean of `pixel`, the one `at` in a part of `n` pixels whose first sample is given. Each sum of
    /// `n` terms, products of three numbers, is off by `n + 4` roundings at most.
    pub fn bounds(&self, pixel: usize, first_sample: usize, at: usize, n: usize) -> [Interval; 3] {
        let Certified { job, .. } = self.certified;
        let n_samples = job.lit.style.n_samples as usize;
        if job.lit.lighting.is_none()
            && let Some(id) = job.only_id(first_sample + at * n_samples)
        {
            return job.color(id).map(|part| Interval { low: part, high: part });
        }
        let packs_of_row = (n * n_samples).div_ceil(LANES);
        let mut sums = [Interval::default(); 3];
        for row in 0..n_samples {
            let start = row * job.row;
            let light = &self.light[row * packs_of_row.min(self.light.len())..];
            for column in at * n_samples..(at + 1) * n_samples {
                let id = job.ids[first_sample + start + column];
                let color = job.color(id);
                for channel in 0..3 {
                    let [low, high] = match (id, &job.lit.lighting) {
                        (0, _) | (_, None) => [1.0; 2],
                        _ => light[column / LANES][channel].map(|row| row[column % LANES]),
                    };
                    sums[channel].low += color[channel] * low;
                    sums[channel].high += color[channel] * high;
                }
            }
        }
        let n_samples = n_samples * n_samples;
        let n_terms = match &job.lit.lighting {
            Some(lighting) => n_terms(n_samples, lighting),
            None => n_samples + 8,
        };
        let (n_counted, error) = (job.n_counted(pixel) as f64, n_terms as f64 * UNIT_F64);
        sums.map(|Interval { low, high }| Interval {
            low: low / n_counted * (1.0 - error),
            high: high / n_counted * (1.0 + error),
        })
    }
}

/// The light of some points, compiled for each instruction set that the processor may have.
struct FindLight<'a> {
    finder: &'a Finder<'a>,
    lighting: &'a Lighting,
    packs: &'a [Pack],
    light: &'a mut Vec<[[Row; 2]; 3]>,
    last: &'a mut [Option<usize>],
    counts: &'a mut StageCounts,
}

impl pulp::WithSimd for FindLight<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let FindLight { finder, lighting, packs, light, last, counts } = self;
        for pack in packs {
            let mut sums = lighting.ambient.map(|part| [[part; LANES]; 2]);
            for (index, lamp) in lighting.lamps.iter().enumerate() {
                let given = finder.light(index, lamp, pack, &mut last[index], counts);
                for (sum, weight) in sums.iter_mut().zip(lamp.weight) {
                    for lane in 0..LANES {
                        sum[0][lane] += weight * given.low[lane];
                        sum[1][lane] += weight * given.high[lane];
                    }
                }
            }
            light.push(sums);
        }
    }
}
