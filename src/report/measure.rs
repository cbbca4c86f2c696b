//! Runs every contestant on every scene: errors once, times in rounds.

use std::sync::Arc;
use std::time::Duration;

use super::errors::Collector;
use super::scenes::Case;
use super::{Class, ClassResult, Contestant, Cost, Effort, Row, SceneResult, Spread};
use crate::control::Control;
use crate::device::{Device, Made};
use crate::error::Result;
use crate::memory;
use crate::prepare::Prepared;
use crate::rays::{Pixels, View};
use crate::render::hits_bytes;
use crate::scene::Scene;
use crate::trace::{Hits, Kernel, Rays, Timing, Wants};
use crate::verify::{SAMPLE_BYTES, Truth, sample};

/// A picture's need.
pub(super) const IDS: Wants = Wants { surface: false, level: false };

/// The need of depth and shading.
pub(super) const SURFACE: Wants = Wants { surface: true, level: false };

/// The CPU as a device's name.
const CPU: &str = "CPU";

/// Makes the tracer that is measured.
pub type Make = Box<dyn Fn(&Arc<Prepared>, Wants) -> Result<Made>>;

/// A kernel on a device, or anything else that traces, to be measured.
pub struct Subject {
    /// Its names.
    pub contestant: Contestant,
    /// The kernel that scenes are prepared for.
    pub kernel: Kernel,
    /// Makes its tracer.
    pub make: Make,
}

impl Subject {
    /// A kernel on a device.
    pub fn new(kernel: Kernel, device: &Device) -> Subject {
        let name = device.facts().map_or(CPU, |facts| &facts.name);
        let device = device.clone();
        Subject {
            contestant: Contestant { kernel: kernel.name().into(), device: name.into() },
            kernel,
            make: Box::new(move |prepared, wants| {
                if let Device::Gpu(gpu) = &device {
                    gpu.forget_programs();
                }
                device.tracer(prepared, wants)
            }),
        }
    }

    /// A tracer for `scene` and `rays`.
    pub(super) fn tracer(&self, scene: &Arc<Scene>, rays: &Rays, wants: Wants) -> Result<Made> {
        let prepared = Arc::new(Prepared::new(Arc::clone(scene), self.kernel, rays)?);
        (self.make)(&prepared, wants)
    }
}

/// Those of the device that stands first.
pub(super) fn of_first_device(subjects: &[Subject]) -> Vec<&Subject> {
    let device = |subject: &Subject| subject.contestant.device.clone();
    let first = subjects.first().map(device);
    subjects.iter().filter(|subject| Some(device(subject)) == first).collect()
}

/// The scenes whose rays are measured.
pub(super) fn timed(cases: &[Case]) -> Vec<&Case> {
    cases.iter().filter(|case| case.class != Class::Lit).collect()
}

/// All pixels that `case`'s camera sees at a size.
pub(super) fn picture(case: &Case, [width, height]: [u32; 2]) -> Result<Pixels> {
    let camera = case.scene.require_camera(case.name.as_ref())?;
    Ok(Pixels::whole(View::new(camera), width, height))
}

/// Rays that [`measure_scenes`] traces or compares, as [`Control::rays_done`] counts them.
pub(super) fn n_rays(cases: &[Case], subjects: &[Subject], effort: &Effort) -> u64 {
    let [width, height] = effort.size.map(u64::from);
    let pictures = subjects.len() * 2 * effort.rounds * (1 + effort.runs);
    let samples = (width * height).min(effort.samples as u64);
    timed(cases).len() as u64 * (width * height * pictures as u64 + samples)
}

fn refuse_what_cannot_fit(effort: &Effort) -> Result<()> {
    let [width, height] = effort.size;
    let n_rays = u64::from(width) * u64::from(height);
    // Any ray may be among the undecided.
    let hits = hits_bytes(n_rays, SURFACE) + n_rays * size_of::<u32>() as u64;
    let samples = n_rays.min(effort.samples as u64) * SAMPLE_BYTES;
    let what = format!("measuring pictures of {width}x{height} pixels");
    memory::require(what, hits + samples, "measure a smaller --size, or fewer --samples")
}

/// Each subject's errors and costs in each scene, and those of each class of scenes.
///
/// # Errors
/// Those of tracing; [`Error::Interrupted`](crate::Error::Interrupted).
pub(super) fn measure_scenes(
    cases: &[Case],
    subjects: &[Subject],
    effort: &Effort,
    control: &Control,
) -> Result<(Vec<SceneResult>, Vec<ClassResult>)> {
    refuse_what_cannot_fit(effort)?;
    let cases = timed(cases);
    let none = || subjects.iter().map(|_| Measured::default()).collect();
    let mut measured: Vec<Vec<Measured>> = cases.iter().map(|_| none()).collect();
    for round in 0..effort.rounds {
        for (case, measured) in cases.iter().zip(&mut measured) {
            let pixels = picture(case, effort.size)?;
            let truth = match round {
                0 => {
                    let index = sample(pixels.len(), effort.samples, effort.seed);
                    Some(Truth::of_pixels(&case.scene, &pixels, index, control)?)
                }
                _ => None,
            };
            let rays = Rays::Pixels(pixels);
            for (subject, measured) in subjects.iter().zip(measured) {
                let mut hits = Hits::default();
                let mut timed = |wants| {
                    let mut made = subject.tracer(&case.scene, &rays, wants)?;
                    if wants == IDS {
                        made.tracer.use_device_clock();
                    }
                    run(made, &rays, effort.runs, control, &mut hits)
                };
                measured.ids.push(timed(IDS)?);
                measured.surface.push(timed(SURFACE)?);
                if let Some(truth) = &truth {
                    measured.errors.add(&hits, truth);
                }
            }
        }
    }
    let classes = class_results(&cases, subjects, &measured);
    let scenes = cases.iter().zip(measured).map(|(case, measured)| {
        let row = |(subject, measured): (&Subject, Measured)| Row {
            contestant: subject.contestant.clone(),
            cost: measured.cost(),
            errors: measured.errors.finish(),
        };
        SceneResult {
            name: case.name.clone(),
            class: case.class,
            about: case.about.clone(),
            n_spheres: case.scene.spheres.len(),
            n_planes: case.scene.planes.len(),
            rows: subjects.iter().zip(measured).map(row).collect(),
        }
    });
    Ok((scenes.collect(), classes))
}

fn class_results(
    cases: &[&Case],
    subjects: &[Subject],
    measured: &[Vec<Measured>],
) -> Vec<ClassResult> {
    let mut results = Vec::new();
    for class in [Class::Lecture, Class::Hard, Class::Given] {
        let of_class = cases.iter().zip(measured).filter(|(case, _)| case.class == class);
        let of_class: Vec<&Vec<Measured>> = of_class.map(|(_, measured)| measured).collect();
        if of_class.is_empty() {
            continue;
        }
        for (i, subject) in subjects.iter().enumerate() {
            let own = || of_class.iter().map(|measured| &measured[i]);
            let mut errors = Collector::default();
            own().for_each(|measured| errors.append(&measured.errors));
            let costs: Vec<Cost> = own().map(|measured| measured.cost()).collect();
            let mean = |time: fn(&Cost) -> Spread| {
                geometric_mean(&costs.iter().map(time).collect::<Vec<_>>())
            };
            results.push(ClassResult {
                class,
                n_scenes: of_class.len(),
                contestant: subject.contestant.clone(),
                errors: errors.finish(),
                trace_ns_per_ray: mean(|cost| cost.trace_ns_per_ray),
                surface_ns_per_ray: mean(|cost| cost.surface_ns_per_ray),
            });
        }
    }
    results
}

/// Of medians, least and largest values, each for itself.
fn geometric_mean(spreads: &[Spread]) -> Spread {
    let mean = |part: fn(&Spread) -> f64| {
        let logarithms: f64 = spreads.iter().map(|spread| part(spread).ln()).sum();
        (logarithms / spreads.len().max(1) as f64).exp()
    };
    Spread {
        median: mean(|spread| spread.median),
        min: mean(|spread| spread.min),
        max: mean(|spread| spread.max),
        n: spreads.iter().map(|spread| spread.n).sum(),
    }
}

/// All measurements of a subject in a scene, an entry a round.
#[derive(Default)]
struct Measured {
    errors: Collector,
    ids: Vec<Runs>,
    surface: Vec<Runs>,
}

impl Measured {
    fn cost(&self) -> Cost {
        let n_rays = self.ids.first().map_or(0, |runs| runs.n_rays);
        let ns_per_ray = 1e9 / n_rays.max(1) as f64;
        let times = |runs: &[Runs], of: fn(&Timing) -> Option<Duration>, per_second| {
            spread(runs.iter().flat_map(|runs| &runs.timed).filter_map(of), per_second)
        };
        let deciding = |runs| times(runs, |timing| Some(timing.deciding()), ns_per_ray);
        let first = self.ids.iter().map(|runs| runs.first.deciding() + runs.first.readback);
        let compile = self.ids.iter().map(|runs| runs.compile);
        let readback = times(&self.ids, |timing| Some(timing.readback), 1e3);
        Cost {
            n_rays,
            trace_ns_per_ray: deciding(&self.ids).unwrap_or_default(),
            surface_ns_per_ray: deciding(&self.surface).unwrap_or_default(),
            device_ns_per_ray: times(&self.ids, |timing| timing.on_device, ns_per_ray),
            readback_ms: readback.unwrap_or_default(),
            compile_ms: spread(compile, 1e3).unwrap_or_default(),
            first_picture_ms: spread(first, 1e3).unwrap_or_default(),
            bytes_device: self.ids.last().map_or(0, |runs| runs.bytes_device),
        }
    }
}

/// The work of one tracer: a first run, and those that are timed.
pub(super) struct Runs {
    pub n_rays: u64,
    pub compile: Duration,
    pub first: Timing,
    pub timed: Vec<Timing>,
    pub bytes_device: u64,
}

/// Traces once, and then as often as is timed; `hits` are those of the last run.
pub(super) fn run(
    Made { mut tracer, compile, .. }: Made,
    rays: &Rays,
    n_timed: usize,
    control: &Control,
    hits: &mut Hits,
) -> Result<Runs> {
    let first = tracer.trace(rays, control, hits)?;
    let timed = (0..n_timed).map(|_| tracer.trace(rays, control, hits)).collect::<Result<_>>()?;
    let (n_rays, bytes_device) = (rays.len() as u64, tracer.bytes_device());
    Ok(Runs { n_rays, compile, first, timed, bytes_device })
}

/// Median and range of times, each `per_second` for a second; `None` for none.
pub(super) fn spread(times: impl Iterator<Item = Duration>, per_second: f64) -> Option<Spread> {
    Spread::of(times.map(|time| per_second * time.as_secs_f64()).collect())
}
