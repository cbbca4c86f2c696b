//! Runs every contestant on every scene: errors once, times in rounds.

use std::sync::Arc;
use std::time::Duration;

use super::errors::Collector;
use super::peers::{self, Peer, PeerRun, Program};
use super::scenes::Case;
use super::{
    Class, ClassResult, Contestant, Cost, Effort, Missing, PeerResult, Row, SceneResult, Spread,
};
use crate::camera::{Pixels, View};
use crate::control::Control;
use crate::device::{Device, Made};
use crate::error::Result;
use crate::prepare::Prepared;
use crate::scene::Scene;
use crate::trace::{Hits, Kernel, Rays, Tracer, Wants};
use crate::verify::{Truth, sample};

/// A picture's need.
const IDS: Wants = Wants { surface: false, level: false };

/// The need of depth and shading.
const SURFACE: Wants = Wants { surface: true, level: false };

/// The CPU as a device's name.
const CPU: &str = "CPU";

/// Makes the tracer that is measured.
pub type Make = Box<dyn Fn(&Arc<Prepared>, Wants) -> Result<Made>>;

/// What is measured: a kernel on a device, or anything else that traces.
pub struct Subject {
    /// What it is called.
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
    cases.len() as u64 * (width * height * pictures as u64 + samples)
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
    let mut costs: Vec<Vec<CostRuns>> =
        cases.iter().map(|_| subjects.iter().map(|_| CostRuns::default()).collect()).collect();
    let mut errors: Vec<Vec<Collector>> = Vec::new();
    for round in 0..effort.rounds {
        for (case, costs) in cases.iter().zip(&mut costs) {
            let pixels = picture(case, effort.size)?;
            let truth = match round {
                0 => {
                    let index = sample(pixels.len(), effort.samples, effort.seed);
                    Some(Truth::of_pixels(&case.scene, &pixels, index, control)?)
                }
                _ => None,
            };
            let mut of_case = Vec::new();
            for (subject, cost) in subjects.iter().zip(costs) {
                cost.time_ids(subject, case, &pixels, effort, control)?;
                let hits = cost.time_surface(subject, case, &pixels, effort, control)?;
                let mut collector = Collector::default();
                if let Some(truth) = &truth {
                    collector.add(&hits, truth);
                }
                of_case.push(collector);
            }
            if round == 0 {
                errors.push(of_case);
            }
        }
    }
    let n_rays = u64::from(effort.size[0]) * u64::from(effort.size[1]);
    let costs: Vec<Vec<Cost>> = costs
        .into_iter()
        .map(|costs| costs.into_iter().map(|cost| cost.finish(n_rays)).collect())
        .collect();
    Ok(put_together(cases, subjects, &costs, errors))
}

/// The installed ones among the peers on each scene, and why the others are missing.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted), or when this machine fails.
pub(super) fn measure_peers(
    cases: &[Case],
    effort: &Effort,
    control: &Control,
) -> Result<(Vec<PeerResult>, Vec<Missing>)> {
    let runs = peers::Effort { n_runs: effort.runs, ..peers::Effort::default() };
    let (mut results, mut missing) = (Vec::new(), Vec::new());
    for peer in Peer::ALL {
        let program = match Program::open(peer, &runs, control) {
            Ok(program) => program,
            Err(peers::Missing::Because(why)) => {
                missing.push(Missing { what: peer.name().into(), why });
                continue;
            }
            Err(peers::Missing::Stopped(error)) => return Err(error),
        };
        for case in cases {
            match program.run(
                &case.scene,
                &picture(case, effort.size)?.view,
                effort.size,
                &runs,
                control,
            ) {
                Ok(run) => results.push(peer_result(case, run, effort, control)?),
                Err(peers::Missing::Because(why)) => {
                    missing
                        .push(Missing { what: format!("{} on {}", peer.name(), case.name), why });
                }
                Err(peers::Missing::Stopped(error)) => return Err(error),
            }
        }
    }
    Ok((results, missing))
}

fn peer_result(
    case: &Case,
    run: PeerRun,
    effort: &Effort,
    control: &Control,
) -> Result<PeerResult> {
    let pixels = picture(case, effort.size)?;
    let index = sample(pixels.len(), effort.samples, effort.seed);
    let truth = Truth::of_pixels(&case.scene, &pixels, index, control)?;
    let mut errors = Collector::default();
    errors.add(&Hits { id: run.ids, ..Hits::default() }, &truth);
    let ns_per_ray = 1e6 / pixels.len() as f64;
    let version = run.version.map(|version| format!(" {version}")).unwrap_or_default();
    Ok(PeerResult {
        peer: format!("{}{version}", run.peer),
        n_threads: run.n_threads,
        scene: case.name.clone(),
        class: case.class,
        errors: errors.finish(),
        trace_ns_per_ray: run.trace_ms.map(|ms| ms.scaled(ns_per_ray)),
        process_ms: run.wall_ms,
    })
}

/// A subject's errors in all scenes of a class, and its times in each.
type Pool = (Collector, Vec<Spread>);

fn put_together(
    cases: &[Case],
    subjects: &[Subject],
    costs: &[Vec<Cost>],
    errors: Vec<Vec<Collector>>,
) -> (Vec<SceneResult>, Vec<ClassResult>) {
    let mut scenes = Vec::new();
    let mut pools: Vec<(Class, Vec<Pool>)> = Vec::new();
    for ((case, costs), errors) in cases.iter().zip(costs).zip(errors) {
        let place = pools.iter().position(|(class, _)| *class == case.class);
        let place = place.unwrap_or_else(|| {
            let empty = subjects.iter().map(|_| Pool::default()).collect();
            pools.push((case.class, empty));
            pools.len() - 1
        });
        let mut rows = Vec::new();
        for (((subject, cost), errors), pool) in
            subjects.iter().zip(costs).zip(errors).zip(&mut pools[place].1)
        {
            rows.push(Row {
                contestant: subject.contestant.clone(),
                errors: errors.clone().finish(),
                cost: cost.clone(),
            });
            pool.0.append(errors);
            pool.1.push(cost.trace_ns_per_ray);
        }
        scenes.push(SceneResult {
            name: case.name.clone(),
            class: case.class,
            about: case.about.clone(),
            n_spheres: case.scene.spheres.len(),
            n_planes: case.scene.planes.len(),
            rows,
        });
    }
    let classes = pools.into_iter().flat_map(|(class, pool)| {
        subjects.iter().zip(pool).map(move |(subject, (errors, times))| ClassResult {
            class,
            n_scenes: times.len(),
            contestant: subject.contestant.clone(),
            errors: errors.finish(),
            trace_ns_per_ray: geometric_mean(&times),
        })
    });
    (scenes, classes.collect())
}

/// Of medians, least and largest values, each for itself.
pub(super) fn geometric_mean(spreads: &[Spread]) -> Spread {
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

/// The single measurements behind a [`Cost`], in seconds.
#[derive(Default)]
struct CostRuns {
    trace: Vec<f64>,
    surface: Vec<f64>,
    on_device: Vec<f64>,
    readback: Vec<f64>,
    compile: Vec<f64>,
    first_picture: Vec<f64>,
    bytes_device: u64,
}

impl CostRuns {
    fn time_ids(
        &mut self,
        subject: &Subject,
        case: &Case,
        pixels: &Pixels,
        effort: &Effort,
        control: &Control,
    ) -> Result<()> {
        let rays = Rays::Pixels(*pixels);
        let Made { mut tracer, compile, .. } = subject.tracer(&case.scene, &rays, IDS)?;
        tracer.use_device_clock();
        let mut hits = Hits::default();
        let first = tracer.trace(&rays, control, &mut hits)?;
        self.compile.push(compile.as_secs_f64());
        self.first_picture.push((first.deciding() + first.readback).as_secs_f64());
        for _ in 0..effort.runs {
            let timing = tracer.trace(&rays, control, &mut hits)?;
            self.trace.push(timing.deciding().as_secs_f64());
            self.readback.push(timing.readback.as_secs_f64());
            self.on_device.extend(timing.on_device.as_ref().map(Duration::as_secs_f64));
        }
        self.bytes_device = tracer.bytes_device();
        Ok(())
    }

    /// Gives the hits of the last run.
    fn time_surface(
        &mut self,
        subject: &Subject,
        case: &Case,
        pixels: &Pixels,
        effort: &Effort,
        control: &Control,
    ) -> Result<Hits> {
        let rays = Rays::Pixels(*pixels);
        let mut tracer = subject.tracer(&case.scene, &rays, SURFACE)?.tracer;
        let mut hits = Hits::default();
        tracer.trace(&rays, control, &mut hits)?;
        self.surface.extend(time_runs(&mut *tracer, &rays, effort.runs, control, &mut hits)?);
        Ok(hits)
    }

    fn finish(self, n_rays: u64) -> Cost {
        let spread = |seconds: &[f64], factor: f64| {
            Spread::of(seconds.iter().map(|value| value * factor).collect()).unwrap_or_default()
        };
        let ns_per_ray = 1e9 / n_rays.max(1) as f64;
        Cost {
            n_rays,
            trace_ns_per_ray: spread(&self.trace, ns_per_ray),
            surface_ns_per_ray: spread(&self.surface, ns_per_ray),
            device_ns_per_ray: (!self.on_device.is_empty())
                .then(|| spread(&self.on_device, ns_per_ray)),
            readback_ms: spread(&self.readback, 1e3),
            compile_ms: spread(&self.compile, 1e3),
            first_picture_ms: spread(&self.first_picture, 1e3),
            bytes_device: self.bytes_device,
        }
    }
}

/// Seconds of `n_runs` runs, without the read-back.
pub(super) fn time_runs(
    tracer: &mut dyn Tracer,
    rays: &Rays,
    n_runs: usize,
    control: &Control,
    hits: &mut Hits,
) -> Result<Vec<f64>> {
    (0..n_runs).map(|_| Ok(tracer.trace(rays, control, hits)?.deciding().as_secs_f64())).collect()
}
