//! `kugelblitz verify`

use std::fmt::Write;
use std::sync::Arc;

use kugelblitz::compare::{Comparison, compare};
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::memory;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::Pixels;
use kugelblitz::render::{band_rows, bands, hits_bytes};
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz::verify::{
    AgainstExact, SAMPLE_BYTES, Truth, broken_promises, compare_to_exact, promise, sample,
};
use kugelblitz::{Error, Result};
use serde::Serialize;

use super::device;
use super::head::{Objects, On, print_summary};
use super::output::{objects, print_text};
use super::progress::Progress;
use super::render::size;
use super::{Run, VerifyArgs, scene};

/// Pixels that are compared with exact arithmetic without --samples: as many as take some seconds.
fn default_samples(n_objects: usize) -> usize {
    ((1 << 31) / n_objects.max(1)).clamp(1 << 10, 1 << 16)
}

const WANTS: Wants = Wants { surface: true, level: false };

#[derive(Serialize)]
struct Summary {
    #[serde(flatten)]
    on: On,
    size: [u32; 2],
    objects: Objects,
    rays: u64,
    samples: usize,
    seed: u64,
    kernels: Vec<OfKernel>,
}

#[derive(Serialize)]
struct OfKernel {
    kernel: &'static str,
    promise: &'static str,
    /// `null` where only the CPU traced.
    gpu_against_cpu: Option<Comparison>,
    against_exact: AgainstExactOn,
    broken: Vec<String>,
}

#[derive(Serialize)]
struct AgainstExactOn {
    gpu: Option<AgainstExact>,
    cpu: AgainstExact,
}

/// Compares the devices with each other and with exact arithmetic.
pub fn run(args: &VerifyArgs, run: &Run) -> Result<()> {
    let scene = scene::read(&args.scene, &args.talk, run)?;
    let pixels = args.size.pixels(&scene, &args.scene)?;
    let n_samples = args.samples.unwrap_or_else(|| default_samples(scene.n_objects()));
    refuse_what_cannot_fit(&pixels, n_samples)?;
    let only = (!args.all_kernels).then_some(args.kernel.kernel);
    let device = device::open(&args.device.device, only, &args.talk)?;
    run.control.check()?;

    let kernels = only.map_or(Kernel::ALL.to_vec(), |kernel| vec![kernel]);
    let n_samples = n_samples.min(pixels.len());
    let n_devices = if device.facts().is_some() { 2 } else { 1 };
    let n_rays = (pixels.len() * n_devices * kernels.len() + n_samples) as u64;
    let progress = Progress::start(&args.talk, &run.control, n_rays);
    let samples = sample(pixels.len(), n_samples, args.seed);
    let truths = truths(&scene, &pixels, &samples, &run.control)?;
    let mut results = Vec::new();
    for kernel in kernels {
        let device = device::or_cpu(&device, kernel, &args.talk);
        results.push(of_kernel(&scene, &pixels, kernel, device, &truths, &run.control)?);
    }
    drop(progress);

    let broken: Vec<String> = results.iter().flat_map(|result| result.broken.clone()).collect();
    if args.talk.json {
        let summary = Summary {
            on: On::from(&device),
            size: [pixels.width, pixels.height],
            objects: Objects::from(&*scene),
            rays: pixels.len() as u64,
            samples: n_samples,
            seed: args.seed,
            kernels: results,
        };
        print_summary("verify", &summary)?;
    } else {
        let share = match n_samples == pixels.len() {
            true => "all pixels".to_string(),
            false => format!("{n_samples} of {} pixels (seed {})", pixels.len(), args.seed),
        };
        let head = format!(
            "{}: {}, {}, on {}; {share} against exact arithmetic\n",
            args.scene.display(),
            size(&pixels),
            objects(&scene),
            device.label()
        );
        print_text(&(head + &table(&results)))?;
    }
    match broken.is_empty() {
        true => Ok(()),
        false => Err(Error::Comparison(broken.join("; "))),
    }
}

/// The truth about each band's part of the samples.
fn truths(
    scene: &Scene,
    pixels: &Pixels,
    samples: &[usize],
    control: &Control,
) -> Result<Vec<Truth>> {
    let mut rest = samples;
    let mut first_ray = 0;
    bands(pixels, band_rows(pixels, WANTS))
        .map(|band| {
            let end = rest.partition_point(|&index| index < first_ray + band.len());
            let index = rest[..end].iter().map(|index| index - first_ray).collect();
            rest = &rest[end..];
            first_ray += band.len();
            Truth::of_pixels(scene, &band, index, control)
        })
        .collect()
}

fn of_kernel(
    scene: &Arc<Scene>,
    pixels: &Pixels,
    kernel: Kernel,
    device: &Device,
    truths: &[Truth],
    control: &Control,
) -> Result<OfKernel> {
    let rays = Rays::Pixels(*pixels);
    let prepared = Arc::new(Prepared::new_with(scene.clone(), kernel, &rays, control)?);
    let mut cpu = Device::Cpu.tracer(&prepared, WANTS)?.tracer;
    let is_on_gpu = device.facts().is_some();
    let mut gpu = is_on_gpu.then(|| device.tracer(&prepared, WANTS)).transpose()?;
    let mut parity = is_on_gpu.then(Comparison::default);
    let mut exact =
        AgainstExactOn { gpu: is_on_gpu.then(AgainstExact::default), cpu: AgainstExact::default() };
    let (mut on_cpu, mut on_gpu) = (Hits::default(), Hits::default());
    let mut first_ray = 0;
    for (band, truth) in bands(pixels, band_rows(pixels, WANTS)).zip(truths) {
        let rays = Rays::Pixels(band);
        cpu.trace(&rays, control, &mut on_cpu)?;
        exact.cpu.add(&compare_to_exact(&on_cpu, truth), first_ray);
        if let Some(gpu) = &mut gpu {
            gpu.tracer.trace(&rays, control, &mut on_gpu)?;
            let against = compare_to_exact(&on_gpu, truth);
            exact.gpu.get_or_insert_default().add(&against, first_ray);
            parity.get_or_insert_default().add(&compare(&on_gpu, &on_cpu), first_ray);
        }
        first_ray += band.len();
    }
    let bit_equal = is_on_gpu && device.is_ieee(kernel)?;
    Ok(OfKernel {
        kernel: kernel.name(),
        promise: match is_on_gpu || kernel == Kernel::Certified {
            true => promise(kernel, bit_equal),
            false => "nothing that the CPU alone can show",
        },
        broken: broken_promises(kernel, bit_equal, parity.as_ref(), &exact.rows()),
        gpu_against_cpu: parity,
        against_exact: exact,
    })
}

impl AgainstExactOn {
    fn rows(&self) -> Vec<(&'static str, &AgainstExact)> {
        let gpu = self.gpu.as_ref().map(|against| ("GPU", against));
        gpu.into_iter().chain([("CPU", &self.cpu)]).collect()
    }
}

fn table(results: &[OfKernel]) -> String {
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
    text.push('\n');
    for result in results {
        let kept = if result.broken.is_empty() { "kept" } else { "BROKEN" };
        let _ = writeln!(text, "{} promises: {}: {kept}", result.kernel, result.promise);
    }
    text
}

/// Two results of a band, one a device, and the samples.
fn refuse_what_cannot_fit(pixels: &Pixels, n_samples: usize) -> Result<()> {
    let n_rays = u64::from(pixels.width) * u64::from(band_rows(pixels, WANTS));
    let samples = n_samples.min(pixels.len()) as u64 * SAMPLE_BYTES;
    let needed = (2 * hits_bytes(n_rays, WANTS)).saturating_add(samples);
    let what = format!("comparing {n_rays} pixels at once");
    memory::require(what, needed, "verify a smaller --size, or fewer --samples")
}
