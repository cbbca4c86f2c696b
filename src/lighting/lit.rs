//! Hits → colours where a scene has light: every number that of exact arithmetic. Bounds in f32 and then in f64 decide
//! nearly all pixels, each by the interval of its mean; the rest are decided exactly.

use std::mem::take;
use std::sync::{Arc, OnceLock};

use super::decide::Known;
use super::occluders::Occluders;
use super::pass::{LightInterval, LightPass, LightScratch, Open, PixelBlock, Visibility};
use super::quantized::QuantizedPixels;
use super::unlit::color;
use super::{Background, ColorCounts, Encoding, PIXELS_AT_ONCE, Style, baseline};
use crate::error::Result;
use crate::kernel::Kernel;
use crate::num::UNDECIDED;
use crate::prepare::{CertifiedLighting, Lighting, MOST_IN_F32, Prepared};
use crate::query::{Rays, StageCounts};
use crate::rays::Pixels;
use crate::scene::{Samples, Scene};
use crate::support::control::Control;
use crate::support::fpu_check;
use crate::support::memory;
use crate::support::parallel;
use crate::tracer::Tracer;

/// Shades the pictures of one scene and one camera.
#[derive(Debug)]
pub struct Lit {
    scene: Arc<Scene>,
    pub(super) lighting: Lighting,
    pub(super) style: Style,
    suits_f32: OnceLock<bool>,
}

impl Lit {
    /// A shader for a scene with this light.
    pub fn new(scene: Arc<Scene>, lighting: Lighting, style: Style) -> Lit {
        Lit { scene, lighting, style, suits_f32: OnceLock::new() }
    }

    /// Whether all colours and weights are in f32's range.
    pub fn suits_f32(&self) -> bool {
        let is_small = |parts: &[f64; 3]| parts.iter().all(|x| (0.0..MOST_IN_F32).contains(x));
        let look = || {
            let mut ids = 0..=self.scene.n_objects() as u32;
            let lamps = &self.lighting.lamps;
            is_small(&self.lighting.ambient)
                && lamps.iter().all(|lamp| is_small(&lamp.weight))
                && ids.all(|id| is_small(&self.scene.color(id).0))
        };
        *self.suits_f32.get_or_init(look)
    }

    /// Replaces `colors` by those of pixels. `ids` are what their samples see, which are pixels of a picture that is [`Lit`]'s
    /// number of samples times as large, and `tracer` traces that picture; its device may light what they see. Returns where
    /// the colours are from, and how many ways to lamps each stage decided.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled; those of [`Tracer::trace`].
    pub fn shade<C: LitChannel>(
        &self,
        (pixels, ids): (&Pixels, &[u32]),
        tracer: &mut Tracer,
        control: &Control,
        colors: &mut Vec<[C; 3]>,
    ) -> Result<(ColorCounts, StageCounts)> {
        let samples = &pixels.samples(self.style.n_samples.across());
        let job = Job { lit: self, samples, ids };
        colors.clear();
        colors.resize(pixels.len(), Default::default());
        let prepared = &*Arc::clone(tracer.prepared());
        if prepared.kernel != Kernel::Certified {
            let encode = |mean: [f64; 3]| mean.map(C::of);
            return baseline::light_pixels(&job, prepared, tracer, control, colors, encode);
        }
        let rays = Rays::Pixels(*samples);
        let occluders = Occluders::new(prepared, &rays, &self.lighting);
        let mut certified = Certified::new(job, &occluders, C::FIND_IN_F32.is_some());
        certified.require_memory()?;
        certified.propose(tracer, pixels, control)?;
        let counts = certified.run(control, colors)?;
        let codes = certified.codes.unwrap_or_default();
        let device = codes.iter().filter(|&&code| code != UNDECIDED).count() as u64;
        Ok((ColorCounts { device, device_f32: device, cpu: pixels.len() as u64 - device }, counts))
    }

    /// Returns the colors that [`Lit::shade`] encodes, linear, for a kernel without a proof. Only the pixels with the indices
    /// `lit` are lit. The others have the background's color.
    ///
    /// # Errors
    /// Returns the errors of [`Lit::shade`].
    pub fn means(
        &self,
        (pixels, ids): (&Pixels, &[u32]),
        lit: &[usize],
        tracer: &mut Tracer,
        control: &Control,
    ) -> Result<Vec<[f64; 3]>> {
        let samples = &pixels.samples(self.style.n_samples.across());
        let all = Job { lit: self, samples, ids };
        let mut lit_ids = vec![0; ids.len()];
        for sample in lit.iter().flat_map(|&pixel| all.samples_of(pixel)) {
            lit_ids[sample] = ids[sample];
        }
        let (job, mut means) = (Job { ids: &lit_ids, ..all }, vec![[0.0; 3]; pixels.len()]);
        let prepared = Arc::clone(tracer.prepared());
        baseline::light_pixels(&job, &prepared, tracer, control, &mut means, |mean| mean)?;
        Ok(means)
    }
}

/// What a device needs for the light on these pixels; `None` where a scene has no light, or f32 no say.
#[doc(hidden)]
pub fn certified_lighting(
    prepared: &Prepared,
    pixels: &Pixels,
    n_samples: Samples,
) -> Option<CertifiedLighting> {
    let lighting = Lighting::new(&prepared.scene, &pixels.view)?;
    let style = Style { n_samples, ..Style::new(Encoding::Srgb8) };
    let lit = &Lit::new(Arc::clone(&prepared.scene), lighting, style);
    let samples = pixels.samples(n_samples.across());
    let rays = Rays::Pixels(samples);
    let occluders = Occluders::new(prepared, &rays, &lit.lighting);
    let job = Job { lit, samples: &samples, ids: &[] };
    LightPass::in_f32(job, &occluders)?.lighting().cloned()
}

/// Rows whose pixels are painted together: what one point sees of the lamps, those beside and below it mostly see as well.
const STRIP_ROWS: usize = 8;

/// Pixels of a row that stay together.
const CELL: usize = LANES_F32;

/// Most samples that go from stage to stage together, so that what is known of them stays in the cache.
const MOST_SAMPLES: usize = 512;

/// Bytes of a cosine in exact numbers with its weights: resident memory grew by 540 each, for two shells an ulp apart under skies
/// of 2048 and 4096 directions.
const EXACT_COSINE_BYTES: u64 = 1 << 10;

/// The pixels of one call.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub lit: &'a Lit,
    /// The samples of all pixels, as pixels of a larger picture.
    pub samples: &'a Pixels,
    /// What they see.
    pub ids: &'a [u32],
}

impl Job<'_> {
    /// Samples across a pixel.
    pub fn n_samples(&self) -> usize {
        self.lit.style.n_samples.across() as usize
    }

    /// Samples of a row.
    pub fn row(&self) -> usize {
        self.samples.width as usize
    }

    /// Pixels of a row.
    pub fn n_columns(&self) -> usize {
        self.row() / self.n_samples()
    }

    /// What the samples of consecutive pixels of a row see, row by row.
    fn rows_of_samples(&self, first: usize, n_pixels: usize) -> impl Iterator<Item = &[u32]> {
        let (n, start) = (self.n_samples(), self.first_sample(first));
        (0..n).map(move |row| &self.ids[start + row * self.row()..][..n_pixels * n])
    }

    /// Whether no sample of consecutive pixels of a row sees an object.
    fn is_background(&self, first: usize, n_pixels: usize) -> bool {
        let mut rows = self.rows_of_samples(first, n_pixels);
        rows.all(|ids| ids.iter().fold(0, |any, &id| any | id) == 0)
    }

    /// The number that the sum of a pixel's samples is divided by.
    pub fn n_counted(&self, pixel: usize) -> u64 {
        self.lit.style.background.n_counted(self.samples_of(pixel).map(|at| self.ids[at]))
    }

    /// Counts the light of pixels that are about to get it.
    pub fn advance(&self, control: &Control, n_pixels: usize) {
        control.advance(n_pixels as u64 * u64::from(self.lit.style.n_samples.across()).pow(2));
    }

    /// Pixels that take a moment, between which Ctrl-C is looked at: cells in a row, and rows.
    pub fn block(&self) -> [usize; 2] {
        let n_samples = self.n_samples().pow(2);
        let n_questions = n_samples * (self.lit.lighting.lamps.len() + 1);
        let n_pixels = (PIXELS_AT_ONCE / n_questions).min(MOST_SAMPLES / n_samples);
        let n_cells = (n_pixels / CELL).max(1);
        let rows = n_cells.min(STRIP_ROWS);
        [n_cells / rows, rows]
    }

    /// Whether so many pixels from this one on are in one row.
    pub fn is_in_row(&self, pixel: usize, n_pixels: usize) -> bool {
        pixel % self.n_columns() + n_pixels <= self.n_columns()
    }

    /// Index of a pixel's first sample.
    pub fn first_sample(&self, pixel: usize) -> usize {
        let (n, n_columns) = (self.n_samples(), self.n_columns());
        pixel / n_columns * n * self.row() + pixel % n_columns * n
    }

    /// Indices of a pixel's samples.
    pub fn samples_of(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let (n, row, first) = (self.n_samples(), self.row(), self.first_sample(pixel));
        (0..n * n).map(move |sample| first + sample / n * row + sample % n)
    }

    pub fn color(&self, id: u32) -> [f64; 3] {
        color(&self.lit.scene, self.lit.style.background, id)
    }
}

/// Pixels side by side in f32, and in f64: as many bytes as the widest registers have.
const LANES_F32: usize = 16;
const LANES_F64: usize = 8;

/// How f32 finds pixels: [`LightPass::find`].
type FindInF32<C> =
    fn(&LightPass<f32>, PixelBlock<C>, &Control, &mut LightScratch<f32, LANES_F32>) -> Result<u64>;

/// A channel of a lit pixel.
pub trait LitChannel: QuantizedPixels {
    /// What finds pixels in f32, where that is good enough for such numbers. It is compiled for bytes alone.
    const FIND_IN_F32: Option<FindInF32<Self>> = None;
}

impl LitChannel for u8 {
    const FIND_IN_F32: Option<FindInF32<u8>> =
        Some(|pass, part, control, scratch| pass.find(part, control, scratch));
}

impl LitChannel for u16 {}

impl LitChannel for f32 {}

/// The pixels of the kernel `certified`.
pub(super) struct Certified<'a> {
    pub job: Job<'a>,
    in_f32: Option<LightPass<'a, f32>>,
    /// A device's bytes of the pixels, in place of those of f32 here: [`crate::tracer::Backend::light`].
    codes: Option<&'a [u32]>,
    pub in_f64: LightPass<'a, f64>,
    pub occluders: &'a Occluders<'a>,
}

/// What a thread needs.
#[derive(Default)]
pub(super) struct LightWork<C> {
    in_f32: LightScratch<f32, LANES_F32>,
    in_f64: LightScratch<f64, LANES_F64>,
    /// What is to be found.
    pub pixels: Vec<usize>,
    /// What f32 leaves open, and f64.
    open: [Vec<Open>; 2],
    pub colors: Known<C>,
    pub counts: StageCounts,
}

impl<'a> Certified<'a> {
    /// With f32 first, if it is good enough for such colours.
    pub fn new(job: Job<'a>, occluders: &'a Occluders<'a>, is_f32_enough: bool) -> Certified<'a> {
        let in_f32 = is_f32_enough.then(|| LightPass::in_f32(job, occluders)).flatten();
        let in_f64 = LightPass::in_f64(job, occluders);
        Certified { job, in_f32, codes: None, in_f64, occluders }
    }

    /// Refuses more samples and lamps than there is memory for: of a block of pixels each thread keeps what each lamp gives each
    /// sample, and whether it is seen, and of one pixel the exact cosines.
    fn require_memory(&self) -> Result<()> {
        let n_samples = self.job.n_samples().pow(2) as u64;
        let n_cells = self.job.block().iter().product::<usize>() as u64;
        let n_packs = CELL / LANES_F64;
        let of_cell = size_of::<LightInterval<f32, LANES_F32>>()
            + n_packs * size_of::<LightInterval<f64, LANES_F64>>()
            + 2 * CELL * size_of::<Visibility>();
        let of_lamp = n_samples * (n_cells * of_cell as u64 + EXACT_COSINE_BYTES);
        let n_lamps = self.job.lit.lighting.lamps.len() as u64;
        memory::require(
            format!("the light of {n_lamps} lamps on {n_samples} samples a pixel"),
            rayon::current_num_threads() as u64 * n_lamps * of_lamp,
            "take fewer samples, or a sky of fewer directions",
        )
    }

    /// Has a device find bytes in f32, where it does.
    fn propose(
        &mut self,
        tracer: &'a mut Tracer,
        pixels: &Pixels,
        control: &Control,
    ) -> Result<()> {
        let counts_all = self.job.lit.style.background != Background::LeftOut;
        if counts_all
            && let Some(backend) = tracer.backend()
            && let Some(lighting) = self.in_f32.as_ref().and_then(LightPass::lighting)
        {
            self.codes = backend.light(lighting, pixels, control)?;
            if self.codes.is_some() {
                self.in_f32 = None;
            }
        }
        Ok(())
    }

    /// Takes a device's bytes, `codes`, for the pixels of a row from this one on, and puts those that are open into `work`. The
    /// device has looked at all lamps.
    fn take<C: QuantizedPixels>(
        &self,
        codes: &[u32],
        first: usize,
        out: &mut [[C; 3]],
        work: &mut LightWork<C>,
    ) {
        let n_lamps =
            self.job.lit.lighting.lamps.iter().filter(|lamp| lamp.casts_shadows()).count();
        let all = self.job.rows_of_samples(first, out.len()).flatten();
        let mut n_hits = all.filter(|&&id| id != 0).count();
        for (pixel, out) in (first..).zip(out) {
            match codes[pixel] {
                UNDECIDED => {
                    n_hits -=
                        self.job.samples_of(pixel).filter(|&at| self.job.ids[at] != 0).count();
                    work.pixels.push(pixel);
                }
                code => {
                    let [red, green, blue, _] = code.to_le_bytes();
                    *out = [red, green, blue].map(C::of_byte);
                }
            }
        }
        work.counts.f32 += (n_hits * n_lamps) as u64;
    }

    /// Finds the colours of the pixels in `work` in f32, f64, and exactly, and puts them into `out`, which begins at the pixel
    /// `first`.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn find<C: LitChannel>(
        &self,
        (first, out): (usize, &mut [[C; 3]]),
        control: &Control,
        work: &mut LightWork<C>,
    ) -> Result<()> {
        let LightWork { in_f32, in_f64, pixels: some, open: [after_f32, open], colors, counts } =
            work;
        after_f32.clear();
        open.clear();
        if let (Some(pass), Some(find)) = (&self.in_f32, C::FIND_IN_F32) {
            let part = PixelBlock { pixels: some, known: &[], first, out, open: after_f32 };
            counts.f32 += find(pass, part, control, in_f32)?;
            some.clear();
            some.extend(after_f32.iter().map(|open| open.pixel));
        }
        let part = PixelBlock { pixels: some, known: after_f32, first, out, open };
        counts.f64 += self.in_f64.find(part, control, in_f64)?;
        for open in open {
            out[open.pixel - first] = self.decide(open, control, colors, counts)?;
        }
        some.clear();
        Ok(())
    }

    /// Fills `out` with the colours of all pixels.
    fn run<C: LitChannel>(&self, control: &Control, out: &mut [[C; 3]]) -> Result<StageCounts> {
        let job = &self.job;
        let ([cells, rows], width) = (job.block(), job.n_columns().max(1));
        let background = job.color(0).map(C::of);
        let paint = |work: &mut LightWork<C>, (strip, out): (usize, &mut [[C; 3]])| {
            let first = strip * STRIP_ROWS * width;
            for top in (0..out.len()).step_by(rows * width) {
                for left in (0..width).step_by(cells * CELL) {
                    control.check()?;
                    fpu_check::check()?;
                    // Cells that lie below each other follow each other.
                    for column in (left..width.min(left + cells * CELL)).step_by(CELL) {
                        for start in (top..out.len().min(top + rows * width)).step_by(width) {
                            let cell = start + column..start + width.min(column + CELL);
                            job.advance(control, cell.len());
                            if work.pixels.len() + cell.len() > cells * rows * CELL {
                                self.find((first, out), control, work)?;
                            }
                            let at = first + cell.start;
                            match (job.is_background(at, cell.len()), self.codes) {
                                (true, _) => out[cell].fill(background),
                                (_, Some(codes)) => self.take(codes, at, &mut out[cell], work),
                                _ => work.pixels.extend(at..at + cell.len()),
                            }
                        }
                    }
                    // What a device leaves of several blocks goes together.
                    if self.codes.is_none() {
                        self.find((first, out), control, work)?;
                    }
                }
            }
            self.find((first, out), control, work)?;
            Ok(take(&mut work.counts))
        };
        let mut counts = StageCounts::default();
        let strips = out.chunks_mut(width * STRIP_ROWS).enumerate();
        for of_strip in parallel::try_map_in(strips, paint)? {
            counts.add(of_strip);
        }
        Ok(counts)
    }
}
