//! `kugelblitz report`

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use kugelblitz::device::Device;
use kugelblitz::gpu::{AdapterFacts, Gpu};
use kugelblitz::output::{self, OutputFile};
use kugelblitz::plain::Shown;
use kugelblitz::query::Kernel;
use kugelblitz::scene::read_scene_text;
use kugelblitz::support::memory;
use kugelblitz::{Error, Result};
use kugelblitz_report::{
    AdapterArithmetic, Benchmark, Environment, Report, ReportScene, SceneClass, Settings,
    Unmeasured, Work, default_cases, html, markdown, plots, text,
};

use crate::args::ReportArgs;
use crate::head::{Done, summary};
use crate::progress::Progress;
use crate::quiet::{self, quietly};
use crate::{Run, arguments, device, version, wrong_usage};

/// Measures, prints tables and writes files.
pub fn run(args: &ReportArgs, run: &Run) -> Result<Done<Report>> {
    let settings = settings(args);
    let cases = cases(args, settings.size, run)?;
    let clouds = cases.iter().flat_map(|case| &case.scene.clouds).map(|cloud| &cloud.path);
    output::refuse_overwriting(&args.output, args.scenes.iter().chain(clouds))?;
    // Early, so that a missing folder is an error before the work and not after it.
    let begin = |path: &PathBuf| Ok((OutputFile::create(path, false)?, form(path)?));
    let outputs = args.output.iter().map(begin).collect::<Result<Vec<_>>>()?;
    let mut missing = Vec::new();
    let devices = devices(args, &mut missing, run)?;
    let mut adapters = Vec::new();
    for device in &devices {
        if let Device::Gpu(gpu) = device {
            adapters.push(AdapterArithmetic::of(gpu)?);
        }
    }
    let environment = Environment::collect(command_line(), version::COMMIT, adapters);
    let kernels = if args.kernel.is_empty() { &Kernel::ALL } else { &*args.kernel };
    let mut benchmarks = Vec::new();
    for device in &devices {
        for &kernel in kernels {
            match why_not(kernel, device)? {
                None => benchmarks.push(Benchmark { kernel, device: device.clone() }),
                Some(why) => missing.push(Unmeasured {
                    what: format!("{} on {}", kernel.name(), device.label()),
                    why,
                }),
            }
        }
    }

    let (settings, control) = (&settings, &run.control);
    let work = Work { cases: &cases, benchmarks: &benchmarks, settings, control };
    let measure = || work.measure(environment);
    let mut report = Progress::start(run, work.n_rays()).during(measure)?;
    report.missing.extend(missing);

    let write = |(file, form): (OutputFile, Form)| file.filled(&form(&report)?);
    let files = outputs.into_iter().map(write).collect::<Result<_>>()?;
    let words = text::terminal(&report);
    Ok(Done { files, ..Done::in_words(report, words) })
}

/// Renderer of a report.
type Form = fn(&Report) -> Result<Vec<u8>>;

/// Returns the renderer for a file's extension.
fn form(path: &Path) -> Result<Form> {
    Ok(match path.extension().and_then(|ending| ending.to_str()) {
        Some("html") => |report| Ok(html::html(report).into_bytes()),
        Some("json") => |report| summary(Some("report"), Some(report), None),
        Some("md") => |report| Ok(markdown::markdown(report).into_bytes()),
        Some("svg") => |report| Ok(plots::svg(report).into_bytes()),
        _ => {
            return wrong_usage(format!(
                "{}: expected a file name that ends in .html (a page), .json (all figures), .md \
                 (tables) or .svg (plots)",
                path.shown()
            ));
        }
    })
}

fn command_line() -> String {
    let with =
        |line: String, argument: &std::ffi::OsString| line + " " + &*argument.to_string_lossy();
    arguments().iter().fold("kugelblitz".to_owned(), with)
}

/// The scenes, by their files' names, or by their paths where two files have the same name.
fn cases(args: &ReportArgs, size: [u32; 2], run: &Run) -> Result<Vec<ReportScene>> {
    if args.scenes.is_empty() {
        args.picture.refuse_without_scene()?;
        return default_cases();
    }
    let case = |path: &PathBuf| {
        let scene = args.picture.scene(path, Some(size), run)?;
        // A pipe can be read only once, and data have no comments.
        let text =
            if path.is_file() { read_scene_text(path).unwrap_or_default() } else { String::new() };
        let mut case = ReportScene::new(scene, &text, path, SceneClass::Given)?;
        if args.scenes.iter().filter(|other| other.file_stem() == path.file_stem()).count() > 1 {
            case.name = path.to_string_lossy().into_owned();
        }
        Ok(case)
    };
    args.scenes.iter().map(case).collect()
}

fn settings(args: &ReportArgs) -> Settings {
    let default = Settings::default();
    let is_built_in = args.scenes.is_empty();
    Settings {
        size: args.size.unwrap_or(default.size),
        samples: args.samples.map_or(default.samples, NonZeroUsize::get),
        seed: args.seed,
        rounds: args.rounds.map_or(default.rounds, NonZeroUsize::get),
        distances: if is_built_in { default.distances } else { Vec::new() },
        spheres: if is_built_in { default.spheres } else { Vec::new() },
        ..default
    }
}

/// The devices that --device names; without it every adapter, the best first, and the CPU.
fn devices(args: &ReportArgs, missing: &mut Vec<Unmeasured>, run: &Run) -> Result<Vec<Device>> {
    if let Some(choice) = &args.device {
        return Ok(vec![device::open(choice, None, run)?]);
    }
    if let Err(Error::TooLarge(why)) = memory::require_device() {
        missing.push(Unmeasured { what: "Vulkan devices".into(), why: why.text });
        return Ok(vec![Device::Cpu]);
    }
    let (opened, noise) = quietly(Gpu::open_all);
    quiet::show(&noise, run.talk.verbose);
    let mut devices = Vec::new();
    if opened.is_empty() {
        missing.push(Unmeasured {
            what: "Vulkan devices".into(),
            why: "there is none; Debian's package mesa-vulkan-drivers brings one in software"
                .into(),
        });
    }
    for (AdapterFacts { name, .. }, opened) in opened {
        match opened {
            Ok(gpu) => devices.push(Device::Gpu(Arc::new(gpu))),
            Err(error) => missing.push(Unmeasured { what: name, why: error.to_string() }),
        }
    }
    devices.push(Device::Cpu);
    Ok(devices)
}

/// Why a kernel would not run on the device itself.
fn why_not(kernel: Kernel, device: &Device) -> Result<Option<String>> {
    let Device::Gpu(gpu) = device else { return Ok(None) };
    if let Err(reason) = gpu.facts.check_kernel(kernel) {
        return Ok(Some(reason.to_string()));
    }
    let arithmetic = gpu.arithmetic()?;
    let works_on_cpu = kernel == Kernel::Certified && !arithmetic.suits_filter();
    Ok(works_on_cpu.then(|| arithmetic.filter_in_words().into()))
}
