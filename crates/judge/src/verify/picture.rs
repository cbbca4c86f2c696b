//! A picture's kernels on both devices, held against each other and against exact arithmetic.

use std::num::NonZeroUsize;
use std::sync::Arc;

use kugelblitz::Control;
use kugelblitz::device::Device;
use kugelblitz::lighting::Lighting;
use kugelblitz::query::{Hits, Kernel};
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::render::{bands, n_steps, sampled_band_rows};
use kugelblitz::scene::{Samples, Scene};
use kugelblitz::{Result, Session};
use serde::Serialize;

use super::{
    ColorDifferences, Differences, RenderedColors, Truth, broken_promises,
    colors::{ENCODINGS, WANTS},
    promise, sample,
};
use crate::compare::RayDifferences;
use crate::cost::ObjectCounts;

/// Results of the verification of a picture.
#[derive(Clone, Debug, Serialize)]
pub struct Verified {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Objects of the scene.
    pub objects: ObjectCounts,
    /// Pixels traced.
    pub rays: usize,
    /// Pixels compared with exact arithmetic.
    pub samples: usize,
    /// Seed of the draw of the compared pixels.
    pub seed: u64,
    /// Results of each kernel.
    pub kernels: Vec<OfKernel>,
}

/// The results of one kernel.
#[derive(Clone, Debug, Serialize)]
pub struct OfKernel {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Promise of the kernel in words. Unstable in JSON.
    pub promise: String,
    /// Differences between the devices; `null` if only the CPU traced.
    pub gpu_against_cpu: Option<Parity>,
    /// Differences between the sampled pixels and the exact picture.
    pub against_exact: OnBoth<RayDifferences>,
    /// Colours of the kernel; absent unless the picture is lit or sampled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colors: Option<ColorsOfKernel>,
    /// Broken promises, one sentence each; empty if the verification succeeds.
    pub broken: Vec<String>,
}

/// The colours of one kernel.
#[derive(Clone, Debug, Serialize)]
pub struct ColorsOfKernel {
    /// Differences between the devices; `null` if only the CPU traced.
    pub gpu_against_cpu: Option<ColorDifferences>,
    /// Differences between the colours of the sampled pixels and the exact ones.
    pub against_exact: OnBoth<ColorDifferences>,
}

/// Results of both devices.
#[derive(Clone, Debug, Serialize)]
pub struct OnBoth<T> {
    /// Result of the GPU; `null` if only the CPU traced.
    pub gpu: Option<T>,
    /// Result of the CPU.
    pub cpu: T,
}

/// Differences between the hits of the GPU and the CPU.
#[derive(Clone, Debug, Serialize)]
pub struct Parity {
    /// Rays compared.
    pub rays: u64,
    /// Rays that one hits and the other misses.
    pub hit_or_miss: u64,
    /// Rays that hit different objects.
    pub other_object: u64,
    /// Rays on the same object with another `t`.
    pub t_differs: u64,
    /// Largest distance of two `t` on the same object, in f32 steps at the `t` of the CPU.
    pub t_ulp_max: u64,
    /// Rays on the same object with another normal.
    pub normal_differs: u64,
    /// Largest distance of two normals on the same object.
    pub normal_distance_max: f64,
    /// Index of the first ray that differs; `null` if none does.
    pub first: Option<usize>,
}

impl From<&RayDifferences> for Parity {
    fn from(of: &RayDifferences) -> Parity {
        Parity {
            rays: of.rays,
            hit_or_miss: of.false_hits + of.false_misses,
            other_object: of.wrong_object,
            t_differs: of.t_differs,
            t_ulp_max: of.t_ulp_max.ceil().min(f64::from(u32::MAX)) as u64,
            normal_differs: of.normal_differs,
            normal_distance_max: of.normal_distance_max,
            first: of.first,
        }
    }
}

/// What is true of a band's part of the samples.
struct TruthOfBand {
    band: Pixels,
    /// Index of the band's first ray.
    first_ray: usize,
    rays: Truth,
    colors: Option<RenderedColors>,
}

/// The verification of a picture: which of its pixels are held against exact arithmetic, and what is true of
/// them.
pub struct Verification {
    scene: Arc<Scene>,
    pixels: Pixels,
    /// Samples of a pixel's colour; `None` where each pixel has the colour of its object.
    colors: Option<Samples>,
    samples: Vec<usize>,
    seed: u64,
}

impl Verification {
    /// Draws so many pixels by `seed`, to be held against exact arithmetic; without a number, as many as take some seconds.
    pub fn new(
        scene: &Arc<Scene>,
        pixels: &Pixels,
        n_samples: Option<NonZeroUsize>,
        seed: u64,
    ) -> Verification {
        let lighting = Lighting::new(scene, &pixels.view);
        let of_pixel = scene.samples.unwrap_or_default();
        let is_colored = of_pixel > Samples::ONE || lighting.is_some();
        // Rays and ways to lamps of a pixel.
        let n_lamps = lighting.map_or(0, |lighting| lighting.lamps.len());
        let n_ways = of_pixel.of_pixel() as usize * (1 + n_lamps);
        let some_seconds = || {
            let n_work = scene.n_objects().max(1) * n_ways;
            let least = if is_colored { 1 << 6 } else { 1 << 10 };
            ((1 << 31) / n_work).min((1 << 20) / n_ways).clamp(least, 1 << 16)
        };
        let n_samples = n_samples.map_or_else(some_seconds, NonZeroUsize::get).min(pixels.len());
        Verification {
            scene: Arc::clone(scene),
            pixels: *pixels,
            colors: is_colored.then_some(of_pixel),
            samples: sample(pixels.len(), n_samples, seed),
            seed,
        }
    }

    fn n_band_rows(&self) -> u32 {
        sampled_band_rows(&self.pixels, self.colors.unwrap_or_default(), WANTS)
    }

    /// Returns the number of steps of these kernels, with a GPU or without, that [`Control`] counts.
    pub fn n_steps(&self, kernels: &[Kernel], has_gpu: bool) -> u64 {
        let n_devices = if has_gpu { 2 } else { 1 };
        let (n_traced, n_truths) = match self.colors {
            None => ((self.pixels.len() * kernels.len()) as u64, 1),
            Some(n_samples) => {
                let is_lit = self.scene.is_lit();
                let n = kernels.iter().map(|&kernel| n_renderings(kernel, is_lit)).sum::<usize>();
                (n as u64 * n_steps(&self.pixels, n_samples, is_lit), 2)
            }
        };
        n_traced * n_devices + n_truths * self.samples.len() as u64
    }

    /// What became of each kernel, on the device that `device_of` gives for it and on the CPU.
    ///
    /// # Errors
    /// Those of the tracers; [`Error::Interrupted`](kugelblitz::Error::Interrupted).
    pub fn run<'d>(
        &self,
        kernels: &[Kernel],
        device_of: impl Fn(Kernel) -> &'d Device,
        control: &Control,
    ) -> Result<Verified> {
        let truths = self.truths(control)?;
        let of_kernel =
            |&kernel: &Kernel| self.of_kernel(&truths, kernel, device_of(kernel), control);
        Ok(Verified {
            size: [self.pixels.width, self.pixels.height],
            objects: ObjectCounts::of(&self.scene),
            rays: self.pixels.len(),
            samples: self.samples.len(),
            seed: self.seed,
            kernels: kernels.iter().map(of_kernel).collect::<Result<_>>()?,
        })
    }

    /// The truth about each band's part of the samples.
    fn truths(&self, control: &Control) -> Result<Vec<TruthOfBand>> {
        let (mut rest, mut first_ray) = (self.samples.as_slice(), 0);
        let truth = |band: Pixels| {
            let end_ray = first_ray + band.len();
            let (own, others) = rest.split_at(rest.partition_point(|&index| index < end_ray));
            let index: Vec<usize> = own.iter().map(|index| index - first_ray).collect();
            let of_colors = |n_samples: Samples| {
                let n_samples = n_samples.across();
                RenderedColors::exact(&self.scene, &band, n_samples, &index, control)
            };
            let colors = self.colors.map(of_colors).transpose()?;
            let rays = Truth::of_rays(&self.scene, &Rays::Pixels(band), index, control)?;
            let truth = TruthOfBand { band, first_ray, rays, colors };
            (rest, first_ray) = (others, end_ray);
            Ok(truth)
        };
        bands(&self.pixels, self.n_band_rows()).map(truth).collect()
    }

    fn of_kernel(
        &self,
        truths: &[TruthOfBand],
        kernel: Kernel,
        device: &Device,
        control: &Control,
    ) -> Result<OfKernel> {
        let is_on_gpu = device.facts().is_some();
        let bit_equal = is_on_gpu && device.is_ieee(kernel)?;
        let on = |device: &Device| {
            let mut session = Session::new(Arc::clone(&self.scene), device.clone(), kernel);
            session.force_light_on_device();
            session
        };
        let (mut gpu, mut cpu) = (is_on_gpu.then(|| on(device)), on(&Device::Cpu));
        let mut parity = is_on_gpu.then(Differences::default);
        let mut exact = OnBoth { gpu: parity.clone(), cpu: Differences::default() };
        for truth in truths {
            // Without a GPU, only the colours of the samples are compared.
            let lit = if is_on_gpu { &(0..truth.band.len()).collect() } else { &truth.rays.index };
            let on_cpu = self.traced(&mut cpu, &truth.band, lit, control)?;
            exact.cpu.see(&on_cpu, truth);
            if let (Some(gpu), Some(exact), Some(parity)) = (&mut gpu, &mut exact.gpu, &mut parity)
            {
                let on_gpu = self.traced(gpu, &truth.band, lit, control)?;
                exact.see(&on_gpu, truth);
                parity.rays.see_all(&on_gpu.0, &on_cpu.0, truth.first_ray);
                if let (Some(a), Some(b)) = (&on_gpu.1, &on_cpu.1) {
                    parity.colors.get_or_insert_default().see_all(a, b, truth.first_ray);
                }
            }
        }
        let of_devices: Vec<_> = exact.rows().collect();
        let colors = |found: &Differences| found.colors.clone().unwrap_or_default();
        Ok(OfKernel {
            kernel: kernel.name(),
            promise: if is_on_gpu || kernel == Kernel::Certified {
                promise(kernel, bit_equal, self.colors.is_some(), is_on_gpu)
            } else {
                "nothing that the CPU alone can show".into()
            },
            broken: broken_promises(kernel, bit_equal, parity.as_ref(), &of_devices),
            gpu_against_cpu: parity.as_ref().map(|found| Parity::from(&found.rays)),
            against_exact: exact.map(|found| found.rays.clone()),
            colors: self.colors.map(|_| ColorsOfKernel {
                gpu_against_cpu: parity.as_ref().map(colors),
                against_exact: exact.map(colors),
            }),
        })
    }

    /// Returns the results of a band; kernels without a proof light only the pixels with the indices `lit`.
    fn traced(
        &self,
        session: &mut Session,
        band: &Pixels,
        lit: &[usize],
        control: &Control,
    ) -> Result<TracedBand> {
        if let Some(n_samples) = self.colors {
            let (hits, colors) = RenderedColors::kept(session, band, n_samples, lit, control)?;
            return Ok((hits, Some(colors)));
        }
        Ok((session.hits(band, WANTS, control)?, None))
    }
}

/// The results of a band on a device.
type TracedBand = (Hits, Option<RenderedColors>);

impl Differences {
    /// Counts those of a band's results from what is true.
    fn see(&mut self, (hits, colors): &TracedBand, truth: &TruthOfBand) {
        self.rays.see_exact(hits, &truth.rays, truth.first_ray);
        if let (Some(shown), Some(exact)) = (colors, &truth.colors) {
            let shown = (shown, truth.rays.index.iter().copied());
            self.colors.get_or_insert_default().see(shown, exact, truth.first_ray);
        }
    }
}

impl<T> OnBoth<T> {
    fn map<U>(&self, of: impl Fn(&T) -> U) -> OnBoth<U> {
        OnBoth { gpu: self.gpu.as_ref().map(&of), cpu: of(&self.cpu) }
    }

    /// Both with the names of the devices.
    pub(super) fn rows(&self) -> impl Iterator<Item = (&'static str, &T)> {
        let gpu = self.gpu.as_ref().map(|of| ("GPU", of));
        gpu.into_iter().chain([("CPU", &self.cpu)])
    }
}

impl Verified {
    /// Promises that are broken, one sentence each.
    pub fn broken(&self) -> Vec<String> {
        self.kernels.iter().flat_map(|result| result.broken.clone()).collect()
    }

    /// The results in lines for people.
    pub fn in_words(&self) -> String {
        let mut rows = <[String; 4]>::default();
        for OfKernel { kernel, gpu_against_cpu, against_exact, colors, .. } in &self.kernels {
            if let Some(found) = gpu_against_cpu {
                let Parity { rays, hit_or_miss, other_object, t_differs, t_ulp_max, .. } = found;
                let (normals, distance) = (found.normal_differs, found.normal_distance_max);
                rows[0] += &format!(
                    "{kernel:<10} {rays:>11} {hit_or_miss:>12} {other_object:>13} {t_differs:>10} \
                     {t_ulp_max:>8} {normals:>15} {distance:>13.2e}\n"
                );
            }
            for (on, found) in against_exact.rows() {
                let RayDifferences { rays, false_hits, false_misses, wrong_object, .. } = found;
                let (ulp, distance) = (found.t_ulp_max, found.normal_distance_max);
                rows[1] += &format!(
                    "{kernel:<10} {on} {rays:>7} {false_hits:>12} {false_misses:>13} \
                     {wrong_object:>13} {ulp:>13.2} {distance:>13.2e}\n"
                );
            }
            if let Some(ColorsOfKernel { gpu_against_cpu, against_exact }) = colors {
                rows[2].extend(gpu_against_cpu.iter().map(|found| found.row(kernel)));
                let row = |(on, found): (&str, &ColorDifferences)| {
                    found.row(&format!("{kernel:<10} {on}"))
                };
                rows[3].extend(against_exact.rows().map(row));
            }
        }
        let heads = [
            "GPU against CPU   rays  hit or miss  other object  t differs  ulp max  normal differs  distance max\n",
            "against exact     rays   false hits  false misses  wrong object  t error, ulp  normal error\n",
            "colours, GPU against CPU  pixels  other in 8 bits  other in 16  other floats\n",
            "colours against exact     pixels  wrong in 8 bits  wrong in 16  wrong floats\n",
        ];
        let parts = heads.iter().zip(&rows).filter(|(_, rows)| !rows.is_empty());
        let mut text: String = parts.map(|(head, rows)| format!("\n{head}{rows}")).collect();
        text.push('\n');
        for OfKernel { kernel, promise, broken, gpu_against_cpu, .. } in &self.kernels {
            let kept = if broken.is_empty() { "kept" } else { "BROKEN" };
            let note = if gpu_against_cpu.is_none() { "; no GPU was compared" } else { "" };
            text += &format!("{kernel} promises: {promise}: {kept}{note}\n");
        }
        text
    }
}

impl ColorDifferences {
    fn row(&self, name: &str) -> String {
        let ColorDifferences { pixels, srgb8, srgb16, linear, .. } = self;
        format!("{name:<24} {pixels:>7} {srgb8:>16} {srgb16:>12} {linear:>13}\n")
    }
}
/// Number of times that [`RenderedColors::kept`] renders the pixels: `certified` has its own computation for each encoding, and
/// the light of the other kernels is the same for all of them.
fn n_renderings(kernel: Kernel, is_lit: bool) -> usize {
    if kernel == Kernel::Certified || !is_lit { ENCODINGS.len() } else { 1 }
}
