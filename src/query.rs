//! [`Rays`] in, [`Hits`] out: the same for every backend.

use std::time::Duration;

use bytemuck::Zeroable;

use crate::error::Result;
use crate::kernel::FloatType;
pub use crate::kernel::Kernel;
use crate::num::UNDECIDED;
pub use crate::rays::{Rays, WorldRay};
use crate::support::memory;
use crate::support::parallel;

/// The outputs that the caller will look at beyond the ids. The others are not computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Outputs {
    /// `t` and the normal of each hit.
    pub surface: bool,
    /// The stage that decided each ray.
    pub level: bool,
}

/// The stage that decided a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Stage {
    /// f32, on the device.
    F32 = 0,
    /// f64.
    F64 = 1,
    /// Exact arithmetic.
    Exact = 2,
}

impl Stage {
    /// The stage that decides all rays of a kernel without a proof.
    pub fn of(kernel: Kernel) -> Stage {
        match kernel.about().float {
            FloatType::F32 => Stage::F32,
            FloatType::F64 => Stage::F64,
        }
    }
}

/// Number of rays that each stage decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct StageCounts {
    /// Rays decided in f32.
    pub f32: u64,
    /// Rays decided in f64.
    pub f64: u64,
    /// Rays decided in exact arithmetic.
    pub exact: u64,
}

impl StageCounts {
    /// So many rays that one stage decided.
    pub fn of(n_rays: u64, level: Stage) -> StageCounts {
        let mut counts = StageCounts::default();
        match level {
            Stage::F32 => counts.f32 = n_rays,
            Stage::F64 => counts.f64 = n_rays,
            Stage::Exact => counts.exact = n_rays,
        }
        counts
    }

    /// All rays counted.
    pub fn total(&self) -> u64 {
        self.f32 + self.f64 + self.exact
    }

    /// Adds another part of the same picture.
    pub fn add(&mut self, other: StageCounts) {
        self.f32 += other.f32;
        self.f64 += other.f64;
        self.exact += other.exact;
    }
}

/// The hits of rays, one entry a ray in the order of the rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hits {
    /// Object id; 0 is the background.
    pub id: Vec<u32>,
    /// Ray parameter, +∞ on the background; empty unless [`Outputs::surface`].
    pub t: Vec<f32>,
    /// Unit normal that faces the ray, zero on the background; empty unless [`Outputs::surface`].
    pub normal: Vec<[f32; 3]>,
    /// [`Stage`] as a number; empty unless [`Outputs::level`]. Unlike all else here, it may differ
    /// between devices and between crops of a picture: a device whose f32 rounds otherwise leaves
    /// other rays open, and so does a CPU whose tiles of pixels begin elsewhere.
    pub level: Vec<u8>,
    /// How many rays each stage decided.
    pub counts: StageCounts,
}

impl Hits {
    /// Returns the memory for the hits of `n_rays` rays, in bytes.
    pub fn bytes(n_rays: u64, wants: Outputs) -> u64 {
        let surface = size_of::<f32>() + size_of::<[f32; 3]>();
        let ray_bytes = size_of::<u32>()
            + if wants.surface { surface } else { 0 }
            + usize::from(wants.level) * size_of::<u8>();
        n_rays.saturating_mul(ray_bytes as u64)
    }

    /// Makes room for `n` rays, whose levels are f32. Everything else is yet to be written.
    ///
    /// # Errors
    /// Returns [`crate::Error::TooLarge`] if they do not fit the memory.
    pub(crate) fn make_room(&mut self, n: usize, wants: Outputs) -> Result<()> {
        if n > self.id.capacity() {
            memory::require(
                format!("a buffer for the hits of {n} rays"),
                Hits::bytes(n as u64, wants),
                "render a smaller picture, or trace in parts",
            )?;
        }
        let n_surface = if wants.surface { n } else { 0 };
        resize(&mut self.id, n);
        resize(&mut self.t, n_surface);
        resize(&mut self.normal, n_surface);
        self.level.clear();
        self.level.resize(if wants.level { n } else { 0 }, Stage::F32 as u8);
        self.counts = StageCounts::default();
        Ok(())
    }

    /// Adds the hits of further rays, with the same outputs.
    pub(crate) fn append(&mut self, more: &Hits) {
        self.id.extend_from_slice(&more.id);
        self.t.extend_from_slice(&more.t);
        self.normal.extend_from_slice(&more.normal);
        self.level.extend_from_slice(&more.level);
        self.counts.add(more.counts);
    }

    /// Number of rays that hit an object.
    pub fn n_hits(&self) -> u64 {
        self.id.iter().filter(|&&id| id != 0).count() as u64
    }
}

/// What the samples of pixels see, `n` × `n` of each.
#[derive(Clone, Debug, Default)]
pub struct SampleIds {
    /// For each pixel the object that all its samples see, or [`UNDECIDED`].
    pub whole: Vec<u32>,
    /// Indices of the pixels that show several, ascending.
    pub mixed: Vec<u32>,
    /// The ids of their samples: row by row of a pixel, one pixel after the other.
    pub ids: Vec<u32>,
    /// Samples of a pixel.
    pub n_each: usize,
    /// How many samples each stage decided, those of whole pixels among them.
    pub counts: StageCounts,
}

/// The pixels of some rows that show several objects, and their samples.
pub(crate) type Mixed = (Vec<u32>, Vec<u32>);

impl SampleIds {
    /// Takes in what all samples see, as rows of a picture that is `n` times as large as one of so many
    /// columns.
    pub fn gather(&mut self, hits: &Hits, n_columns: usize, n: usize) {
        let (n_columns, row) = (n_columns.max(1), n_columns.max(1) * n);
        let ids_of_row = hits.id.chunks_exact(row * n);
        resize(&mut self.whole, hits.id.len() / (n * n));
        let rows = self.whole.chunks_mut(n_columns).zip(ids_of_row).enumerate();
        let mixed = parallel::map(rows, |(y, (whole, ids))| {
            let (mut mixed, mut samples) = Mixed::default();
            for (x, whole) in whole.iter_mut().enumerate() {
                let mut rows = ids.chunks_exact(row).map(|ids| &ids[x * n..][..n]);
                *whole = ids[x * n];
                if !rows.clone().flatten().all(|id| id == whole) {
                    *whole = UNDECIDED;
                    mixed.push((y * n_columns + x) as u32);
                    rows.by_ref().for_each(|ids| samples.extend(ids));
                }
            }
            (mixed, samples)
        });
        self.set_mixed(mixed, n);
        self.counts = hits.counts;
    }

    /// Replaces the pixels that show several objects, from top to bottom.
    pub(crate) fn set_mixed(&mut self, mixed: Vec<Mixed>, n: usize) {
        self.n_each = n * n;
        self.mixed.clear();
        self.ids.clear();
        for (mixed, ids) in mixed {
            self.mixed.extend(mixed);
            self.ids.extend(ids);
        }
    }

    /// How many samples of each pixel hit an object.
    pub fn coverage(&self) -> Coverage {
        let n_each = self.n_each as u16;
        let whole = |pixel: usize| if self.whole[pixel] == 0 { 0 } else { n_each };
        let mut n_hits = parallel::table(self.whole.len(), whole);
        for (&pixel, ids) in self.mixed.iter().zip(self.ids.chunks_exact(self.n_each)) {
            n_hits[pixel as usize] = ids.iter().filter(|&&id| id != 0).count() as u16;
        }
        Coverage { n_hits, n_samples: n_each }
    }
}

/// How many samples of each of consecutive pixels hit an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Samples that hit an object, by pixel: at most `n_samples` each.
    pub n_hits: Vec<u16>,
    /// Samples of a pixel, at least 1.
    pub n_samples: u16,
}

impl Coverage {
    /// That of pixels with `n` × `n` samples each, which saw the objects with these ids: rows of so many columns of samples.
    pub fn of_ids(ids: &[u32], n_columns: usize, n: usize) -> Coverage {
        let mut n_hits = vec![0; ids.len() / (n * n)];
        let rows = n_hits.chunks_mut((n_columns / n).max(1));
        parallel::map(rows.zip(ids.chunks((n_columns * n).max(1))), |(n_hits, ids)| {
            for (at, &id) in ids.iter().enumerate() {
                n_hits[at % n_columns / n] += u16::from(id != 0);
            }
        });
        Coverage { n_hits, n_samples: (n * n) as u16 }
    }

    /// Adds further pixels, with as many samples each.
    pub(crate) fn append(&mut self, more: &Coverage) {
        self.n_hits.extend_from_slice(&more.n_hits);
        self.n_samples = more.n_samples;
    }

    /// The share of a pixel's samples that hit: the nearest f32.
    pub fn alpha(&self, pixel: usize) -> f32 {
        // Both numbers are f32, so that the quotient is rounded once.
        f32::from(self.n_hits[pixel]) / f32::from(self.n_samples)
    }

    /// The share of a pixel's samples that hit, times `largest`: the nearest whole number, of two the
    /// larger.
    pub fn whole_alpha(&self, pixel: usize, largest: u16) -> u16 {
        let n_samples = u64::from(self.n_samples);
        let scaled = u64::from(self.n_hits[pixel]) * u64::from(largest);
        ((2 * scaled + n_samples) / (2 * n_samples)) as u16
    }
}

/// Makes `n` values of any kind. New memory comes zeroed and is first touched by who writes to it.
pub(crate) fn resize<T: Zeroable + Copy>(values: &mut Vec<T>, n: usize) {
    match n > values.capacity() {
        true => *values = bytemuck::zeroed_vec(n),
        false => values.resize(n, T::zeroed()),
    }
}

/// Indices of a value that is rare: most parts of 256 are passed after one comparison of all that is in them.
pub(crate) fn places_of<T: PartialEq + Copy>(rare: T, all: &[T]) -> impl Iterator<Item = usize> {
    const AT_ONCE: usize = 256;
    let parts = (0..).step_by(AT_ONCE).zip(all.chunks(AT_ONCE));
    parts.filter(move |(_, part)| part.contains(&rare)).flat_map(move |(first, part)| {
        (first..).zip(part).filter(move |&(_, &value)| value == rare).map(|(at, _)| at)
    })
}

/// Time spent in the stages of one [`Tracer::trace`](crate::tracer::Tracer::trace).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Dispatch until the device is done; on the CPU the tracing itself.
    pub trace: Duration,
    /// f64 stage.
    pub refine: Duration,
    /// Exact stage.
    pub decide: Duration,
    /// From the device into [`Hits`].
    pub readback: Duration,
}

impl Timing {
    /// All stages but the read-back.
    pub fn deciding(&self) -> Duration {
        self.trace + self.refine + self.decide
    }

    /// The time that went by while threads worked side by side, shared among the stages as the threads' times were. A thread that
    /// waits for others may take up another part, whose time then counts twice, so that shares are estimates.
    pub(crate) fn within(self, wall: Duration) -> Timing {
        if self.deciding().is_zero() {
            return self;
        }
        let share = wall.as_secs_f64() / self.deciding().as_secs_f64();
        let [trace, refine, decide] =
            [self.trace, self.refine, self.decide].map(|time| time.mul_f64(share));
        Timing { trace, refine, decide, ..self }
    }

    /// Adds another part of the same picture.
    pub fn add(&mut self, other: Timing) {
        self.trace += other.trace;
        self.refine += other.refine;
        self.decide += other.decide;
        self.readback += other.readback;
    }
}
