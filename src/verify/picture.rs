//! A picture's kernels on both devices, held against each other and against exact arithmetic.

use std::fmt::Write;
use std::sync::Arc;

use serde::Serialize;

use super::{
    AgainstExact, COLOR_BYTES, ColorDifferences, ColorTruth, SAMPLE_BYTES, Shown, Truth,
    broken_color_promises, broken_promises, color_promise, compare_colors, compare_colors_to_exact,
    compare_to_exact, promise, sample,
};
use crate::compare::{Comparison, compare};
use crate::control::Control;
use crate::device::Device;
use crate::error::{Error, Result};
use crate::memory;
use crate::prepare::Prepared;
use crate::rays::{Pixels, Rays};
use crate::render::{bands, hits_bytes, sampled_band_rows};
use crate::scene::{Samples, Scene};
use crate::shade::{Encoding, Lighting};
use crate::trace::{Hits, Kernel, Wants};
use crate::tracer::Tracer;

/// Pixels that are compared with exact arithmetic where nobody says how many: as many as take some seconds.
fn default_samples(scene: &Scene, colors: Option<&InColor>) -> usize {
    let n_work = scene.n_objects().max(1);
    match colors {
        None => ((1 << 31) / n_work).clamp(1 << 10, 1 << 16),
        Some(colors) => {
            let n_ways = colors.ways_of_pixel();
            ((1 << 31) / (n_work * n_ways)).min((1 << 20) / n_ways).clamp(1 << 6, 1 << 16)
        }
    }
}

/// What the colours of a lit or sampled picture are made from.
#[derive(Clone, Copy)]
struct InColor {
    /// Samples across and down a pixel.
    n_samples: Samples,
    n_lamps: usize,
}

impl InColor {
    /// `None` where each pixel has the colour of its object.
    fn new(scene: &Scene, pixels: &Pixels) -> Option<InColor> {
        let n_samples = scene.samples.unwrap_or_default();
        let lighting = Lighting::new(scene, &pixels.view);
        let n_lamps = lighting.as_ref().map_or(0, |lighting| lighting.lamps.len());
        (n_samples > Samples::ONE || lighting.is_some()).then_some(InColor { n_samples, n_lamps })
    }

    /// Rays and ways to lamps.
    fn ways_of_pixel(&self) -> usize {
        self.n_samples.of_pixel() as usize * (1 + self.n_lamps)
    }

    /// Rays that are traced for the colours of a pixel, once for each encoding.
    fn rays_of_pixel(&self) -> usize {
        match self.n_samples {
            Samples::ONE => 0,
            n => 3 * n.of_pixel() as usize,
        }
    }
}

const WANTS: Wants = Wants { surface: true, level: false };

/// The results of one kernel.
#[derive(Clone, Debug, Serialize)]
pub struct OfKernel {
    /// Its name.
    pub kernel: &'static str,
    /// What it promises, in words.
    pub promise: String,
    /// `null` where only the CPU traced.
    pub gpu_against_cpu: Option<Comparison>,
    /// Of the sampled pixels.
    pub against_exact: OnBoth<AgainstExact>,
    /// Of lit or sampled pictures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colors: Option<ColorsOfKernel>,
    /// Promises that are broken, one sentence each.
    pub broken: Vec<String>,
}

/// The colours of one kernel.
#[derive(Clone, Debug, Serialize)]
pub struct ColorsOfKernel {
    /// `null` where only the CPU traced.
    pub gpu_against_cpu: Option<ColorDifferences>,
    /// Of the sampled pixels.
    pub against_exact: OnBoth<ColorDifferences>,
}

/// Results of both devices; `null` where only the CPU traced.
#[derive(Clone, Debug, Serialize)]
pub struct OnBoth<T> {
    /// Of the GPU.
    pub gpu: Option<T>,
    /// Of the CPU.
    pub cpu: T,
}

/// What is true of a band's part of the samples.
struct TruthOfBand {
    band: Pixels,
    rays: Truth,
    colors: Option<ColorTruth>,
}

/// The verification of a picture: which of its pixels are held against exact arithmetic, and what is true of
/// them.
pub struct Verification {
    scene: Arc<Scene>,
    pixels: Pixels,
    colors: Option<InColor>,
    samples: Vec<usize>,
}

impl Verification {
    /// Of so many pixels, drawn by `seed`; without a number, as many as take some seconds.
    ///
    /// # Errors
    /// [`Error::TooLarge`] where that does not fit the memory.
    pub fn new(
        scene: &Arc<Scene>,
        pixels: &Pixels,
        n_samples: Option<usize>,
        seed: u64,
    ) -> Result<Verification> {
        let (scene, pixels) = (Arc::clone(scene), *pixels);
        let colors = InColor::new(&scene, &pixels);
        let n_samples = n_samples.unwrap_or_else(|| default_samples(&scene, colors.as_ref()));
        refuse_what_cannot_fit(&pixels, n_samples, colors)?;
        let samples = sample(pixels.len(), n_samples.min(pixels.len()), seed);
        Ok(Verification { scene, pixels, colors, samples })
    }

    /// Pixels that are held against exact arithmetic.
    pub fn n_samples(&self) -> usize {
        self.samples.len()
    }

    /// Steps of so many kernels, with a GPU or without, that [`Control`] counts.
    pub fn n_steps(&self, n_kernels: usize, has_gpu: bool) -> u64 {
        let n_devices = if has_gpu { 2 } else { 1 };
        let rays_of_pixel = 1 + self.colors.map_or(0, |colors| colors.rays_of_pixel());
        let n_truths = self.samples.len() * if self.colors.is_some() { 2 } else { 1 };
        (self.pixels.len() * rays_of_pixel * n_devices * n_kernels + n_truths) as u64
    }

    /// What became of each kernel, on the device that `device_of` gives for it and on the CPU.
    ///
    /// # Errors
    /// Those of the tracers; [`Error::Interrupted`].
    pub fn run<'d>(
        &self,
        kernels: &[Kernel],
        device_of: impl Fn(Kernel) -> &'d Device,
        control: &Control,
    ) -> Result<Vec<OfKernel>> {
        let Verification { scene, pixels, colors, samples } = self;
        let truths = truths(scene, pixels, *colors, samples, control)?;
        let work = Work { scene, pixels, colors: *colors, truths: &truths };
        kernels.iter().map(|&kernel| of_kernel(&work, kernel, device_of(kernel), control)).collect()
    }
}

/// Promises that are broken, one sentence each.
pub fn broken_of(results: &[OfKernel]) -> Vec<String> {
    results.iter().flat_map(|result| result.broken.clone()).collect()
}

/// The truth about each band's part of the samples.
fn truths(
    scene: &Scene,
    pixels: &Pixels,
    colors: Option<InColor>,
    samples: &[usize],
    control: &Control,
) -> Result<Vec<TruthOfBand>> {
    let mut rest = samples;
    let mut first_ray = 0;
    bands(pixels, n_band_rows(pixels, colors))
        .map(|band| {
            let end = rest.partition_point(|&index| index < first_ray + band.len());
            let index: Vec<usize> = rest[..end].iter().map(|index| index - first_ray).collect();
            rest = &rest[end..];
            first_ray += band.len();
            let of_colors = |InColor { n_samples, .. }| {
                ColorTruth::of_pixels(scene, &band, n_samples.across(), index.clone(), control)
            };
            let colors = colors.map(of_colors).transpose()?;
            Ok(TruthOfBand { band, rays: Truth::of_pixels(scene, &band, index, control)?, colors })
        })
        .collect()
}

fn n_band_rows(pixels: &Pixels, colors: Option<InColor>) -> u32 {
    sampled_band_rows(pixels, colors.map_or(Samples::ONE, |colors| colors.n_samples), WANTS)
}

/// What is verified, and what is true of it.
struct Work<'a> {
    scene: &'a Arc<Scene>,
    pixels: &'a Pixels,
    colors: Option<InColor>,
    truths: &'a [TruthOfBand],
}

/// The tracers of a device: of the pixels, and of their samples where there are several.
struct Tracers {
    pixels: Tracer,
    samples: Option<Tracer>,
}

impl Tracers {
    fn new(device: &Device, prepared: &Arc<Prepared>, of_samples: &Arc<Prepared>) -> Result<Self> {
        let samples = (!Arc::ptr_eq(prepared, of_samples))
            .then(|| Ok::<_, Error>(device.tracer(of_samples, Wants::default())?.tracer))
            .transpose()?;
        Ok(Tracers { pixels: device.tracer(prepared, WANTS)?.tracer, samples })
    }
}

fn of_kernel(work: &Work, kernel: Kernel, device: &Device, control: &Control) -> Result<OfKernel> {
    let Work { scene, pixels, colors, truths } = *work;
    let (scene, rays) = (Arc::clone(scene), Rays::Pixels(*pixels));
    let prepared = Arc::new(Prepared::new_with(scene.clone(), kernel, &rays, control)?);
    let of_samples = match colors.map_or(1, |colors| colors.n_samples.across()) {
        1 => Arc::clone(&prepared),
        n => {
            let rays = Rays::Pixels(pixels.samples(n));
            Arc::new(Prepared::renewed(Some(&prepared), scene, kernel, &rays, control)?)
        }
    };
    let mut cpu = Tracers::new(&Device::Cpu, &prepared, &of_samples)?;
    let is_on_gpu = device.facts().is_some();
    let mut gpu = is_on_gpu.then(|| Tracers::new(device, &prepared, &of_samples)).transpose()?;
    let bit_equal = is_on_gpu && device.is_ieee(kernel)?;
    let mut parity = is_on_gpu.then(Comparison::default);
    let mut exact = OnBoth::<AgainstExact>::new(is_on_gpu);
    let mut shown = colors.map(|_| ColorsOfKernel {
        gpu_against_cpu: is_on_gpu.then(ColorDifferences::default),
        against_exact: OnBoth::new(is_on_gpu),
    });
    let (mut on_cpu, mut on_gpu) = (Hits::default(), Hits::default());
    let mut first_ray = 0;
    for TruthOfBand { band, rays: truth, colors: true_colors } in truths {
        let rays = Rays::Pixels(*band);
        cpu.pixels.trace(&rays, control, &mut on_cpu)?;
        exact.cpu.add(&compare_to_exact(&on_cpu, truth), first_ray);
        if let Some(gpu) = &mut gpu {
            gpu.pixels.trace(&rays, control, &mut on_gpu)?;
            let against = compare_to_exact(&on_gpu, truth);
            exact.gpu.get_or_insert_default().add(&against, first_ray);
            parity.get_or_insert_default().add(&compare(&on_gpu, &on_cpu), first_ray);
        }
        if let (Some(shown), Some(truth), Some(colors)) = (&mut shown, true_colors, colors) {
            let painted = |hits: &Hits, tracers: &mut Tracers| {
                let Tracers { pixels, samples } = tracers;
                let (n, samples) = (colors.n_samples, samples.as_mut());
                Shown::painted(band, n, hits, pixels, samples, control)
            };
            let of_cpu = painted(&on_cpu, &mut cpu)?;
            let against = compare_colors_to_exact(&of_cpu, truth);
            shown.against_exact.cpu.add(&against, first_ray);
            if let Some(gpu) = &mut gpu {
                let of_gpu = painted(&on_gpu, gpu)?;
                let against = compare_colors_to_exact(&of_gpu, truth);
                shown.against_exact.gpu.get_or_insert_default().add(&against, first_ray);
                let parity = shown.gpu_against_cpu.get_or_insert_default();
                parity.add(&compare_colors(&of_gpu, &of_cpu), first_ray);
            }
        }
        first_ray += band.len();
    }
    let mut broken = broken_promises(kernel, bit_equal, parity.as_ref(), &exact.rows());
    if let Some(ColorsOfKernel { gpu_against_cpu, against_exact }) = &shown {
        let parity = gpu_against_cpu.as_ref();
        broken.extend(broken_color_promises(kernel, bit_equal, parity, &against_exact.rows()));
    }
    Ok(OfKernel {
        kernel: kernel.name(),
        promise: match is_on_gpu || kernel == Kernel::Certified {
            true => {
                let of_colors = shown.as_ref().and_then(|_| color_promise(kernel));
                promise(kernel, bit_equal).to_owned() + of_colors.unwrap_or_default()
            }
            false => "nothing that the CPU alone can show".into(),
        },
        broken,
        gpu_against_cpu: parity,
        against_exact: exact,
        colors: shown,
    })
}

impl<T: Default> OnBoth<T> {
    fn new(is_on_gpu: bool) -> OnBoth<T> {
        OnBoth { gpu: is_on_gpu.then(T::default), cpu: T::default() }
    }

    fn rows(&self) -> Vec<(&'static str, &T)> {
        let gpu = self.gpu.as_ref().map(|against| ("GPU", against));
        gpu.into_iter().chain([("CPU", &self.cpu)]).collect()
    }
}

/// The results in lines for people.
pub fn table(results: &[OfKernel]) -> String {
    let mut text = String::new();
    let parities: Vec<_> = results
        .iter()
        .filter_map(|result| Some((result.kernel, result.gpu_against_cpu.as_ref()?)))
        .collect();
    if !parities.is_empty() {
        text += "\nGPU against CPU   rays  hit or miss  other object  t differs  ulp max  \
                 normal differs  distance max\n";
    }
    for (kernel, c) in parities {
        let _ = writeln!(
            text,
            "{kernel:<10} {:>11} {:>12} {:>13} {:>10} {:>8} {:>15} {:>13.2e}",
            c.rays,
            c.hit_or_miss,
            c.other_object,
            c.t_differs,
            c.t_ulp_max,
            c.normal_differs,
            c.normal_distance_max
        );
    }
    text += "\nagainst exact     rays   false hits  false misses  wrong object  t error, ulp  \
             normal error\n";
    for result in results {
        for (device, c) in result.against_exact.rows() {
            let _ = writeln!(
                text,
                "{:<10} {device} {:>7} {:>12} {:>13} {:>13} {:>13.2} {:>13.2e}",
                result.kernel,
                c.rays,
                c.false_hits,
                c.false_misses,
                c.wrong_object,
                c.t_ulp_max,
                c.normal_distance_max
            );
        }
    }
    text += &color_table(results);
    text.push('\n');
    for result in results {
        let kept = if result.broken.is_empty() { "kept" } else { "BROKEN" };
        let _ = writeln!(text, "{} promises: {}: {kept}", result.kernel, result.promise);
    }
    text
}

/// Pixels whose colours differ; empty where there are no colours to compare.
fn color_table(results: &[OfKernel]) -> String {
    let with_colors: Vec<_> = results
        .iter()
        .filter_map(|result| Some((result.kernel, result.colors.as_ref()?)))
        .collect();
    let line = |name: &str, cells: [String; 4]| {
        let [pixels, srgb8, srgb16, linear] = cells;
        format!("{name:<24} {pixels:>7} {srgb8:>16} {srgb16:>12} {linear:>13}\n")
    };
    let head = |name, differ: &str| {
        let columns = ["in 8 bits", "in 16", "floats"].map(|what| format!("{differ} {what}"));
        let [srgb8, srgb16, linear] = columns;
        format!("\n{}", line(name, ["pixels".into(), srgb8, srgb16, linear]))
    };
    let row = |name: &str, found: &ColorDifferences| {
        let ColorDifferences { pixels, srgb8, srgb16, linear, .. } = found;
        line(name, [pixels, srgb8, srgb16, linear].map(u64::to_string))
    };
    let mut text = String::new();
    let parity = |(kernel, colors): &(&str, &ColorsOfKernel)| {
        Some(row(kernel, colors.gpu_against_cpu.as_ref()?))
    };
    let parities: String = with_colors.iter().filter_map(parity).collect();
    if !parities.is_empty() {
        text += &head("colours, GPU against CPU", "other");
        text += &parities;
    }
    if !with_colors.is_empty() {
        text += &head("colours against exact", "wrong");
    }
    for (kernel, colors) in with_colors {
        for (device, found) in colors.against_exact.rows() {
            text += &row(&format!("{kernel:<10} {device}"), found);
        }
    }
    text
}

/// Two results of a band, one a device, and the samples.
fn refuse_what_cannot_fit(
    pixels: &Pixels,
    n_samples: usize,
    colors: Option<InColor>,
) -> Result<()> {
    let n_rays = u64::from(pixels.width) * u64::from(n_band_rows(pixels, colors));
    let mut sample_bytes = SAMPLE_BYTES;
    let mut bytes = 2 * hits_bytes(n_rays, WANTS);
    if let Some(colors) = colors {
        sample_bytes += COLOR_BYTES;
        let encodings = [Encoding::Srgb8, Encoding::Srgb16, Encoding::Linear];
        let color_bytes: usize = encodings.map(Encoding::pixel_bytes).iter().sum();
        bytes = bytes.saturating_add(n_rays.saturating_mul(2 * color_bytes as u64));
        let n_rays = n_rays.saturating_mul(colors.rays_of_pixel() as u64 / 3);
        bytes = bytes.saturating_add(hits_bytes(n_rays, Wants::default()));
    }
    let samples = n_samples.min(pixels.len()) as u64 * sample_bytes;
    let what = format!("comparing {n_rays} pixels at once");
    memory::require(
        what,
        bytes.saturating_add(samples),
        "verify a smaller --size, or fewer --samples",
    )
}
