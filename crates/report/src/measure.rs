//! Measures times in rounds, and errors once.

use std::sync::Arc;

use kugelblitz::Control;
use kugelblitz::device::{Device, Made};
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, StageCounts};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Scene};
use kugelblitz::{Error, Result};
use kugelblitz_judge::verify::{Truth, sample};

use super::generated::{DISTANCE_RAYS, MOST_TESTED, sphere_at_distance, spheres_in_cube};
use super::{
    ClassRow, DistanceRow, Environment, KernelOnDevice, RayErrors, Report, ReportScene, SceneClass,
    SceneRow, Settings, SpheresRow, TimeSpread, Unmeasured,
};

/// The visible object of each pixel.
pub const IDS: Outputs = Outputs { surface: false, level: false };

/// The visible object with `t` and the normal.
const SURFACE: Outputs = Outputs { surface: true, level: false };

/// A kernel on a device, to be measured.
pub struct Benchmark {
    /// Kernel.
    pub kernel: Kernel,
    /// Device.
    pub device: Device,
}

impl Benchmark {
    /// Returns the names of kernel and device.
    pub fn names(&self) -> KernelOnDevice {
        let device = self.device.facts().map_or("CPU", |facts| &facts.name);
        KernelOnDevice { kernel: self.kernel.name(), device: device.into() }
    }

    /// Builds a new tracer, with a shader that is compiled again.
    fn tracer(&self, scene: &Arc<Scene>, rays: &Rays, wants: Outputs) -> Result<Made> {
        let prepared = Arc::new(Prepared::new(Arc::clone(scene), self.kernel, rays)?);
        if let Device::Gpu(gpu) = &self.device {
            gpu.forget_programs();
        }
        self.device.tracer(&prepared, wants)
    }
}

/// Work of a report.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    /// Scenes.
    pub cases: &'a [ReportScene],
    /// Kernels on devices.
    pub benchmarks: &'a [Benchmark],
    /// Amount of work.
    pub settings: &'a Settings,
    /// Counts rays, and interrupts.
    pub control: &'a Control,
}

/// Workload of a measurement.
#[derive(Clone, Copy)]
enum Workload<'a> {
    /// Picture of a scene.
    Scene(&'a ReportScene),
    /// Sphere at a distance.
    Distance(f64),
    /// Picture of so many spheres.
    Spheres(u64),
}

/// Measurements of a kernel on a device.
struct Measured<'a> {
    workload: Workload<'a>,
    benchmark: &'a Benchmark,
    errors: RayErrors,
    decided: StageCounts,
    ns_per_ray: Vec<f64>,
    build_ms: Vec<f64>,
}

impl<'a> Work<'a> {
    /// Measures everything. The control counts [`Work::n_rays`] rays.
    ///
    /// # Errors
    /// Returns the errors of tracing, and [`Error::Interrupted`].
    pub fn measure(self, environment: Environment) -> Result<Report> {
        let mut report = Report {
            environment,
            settings: self.settings.clone(),
            scenes: self.cases.to_vec(),
            classes: Vec::new(),
            rays: Vec::new(),
            distance: Vec::new(),
            spheres: Vec::new(),
            shadows: Vec::new(),
            missing: Vec::new(),
        };
        for measured in self.measured(&mut report.missing)? {
            let Measured { workload, benchmark, errors, decided, ns_per_ray, build_ms } = measured;
            let (of, ns_per_ray) = (benchmark.names(), TimeSpread::new(ns_per_ray));
            match workload {
                Workload::Scene(case) => {
                    let (scene, class) = (case.name.clone(), case.class);
                    report.rays.push(SceneRow { scene, class, of, errors, decided, ns_per_ray });
                }
                Workload::Distance(distance) => {
                    report.distance.push(DistanceRow { distance, of, errors });
                }
                Workload::Spheres(spheres) => {
                    let build_ms = TimeSpread::new(build_ms);
                    report.spheres.push(SpheresRow { spheres, of, ns_per_ray, build_ms });
                }
            }
        }
        report.classes = self.classes(&report.rays);
        report.shadows = self.shadows()?;
        Ok(report)
    }

    /// Returns the number of rays that [`Work::measure`] traces or compares, including shadow rays.
    pub fn n_rays(self) -> u64 {
        let of_workload = |workload: Workload| {
            let n_pictures = self.n_compared(workload).min(1) as usize
                + usize::from(workload.is_timed())
                    * self.settings.rounds
                    * (1 + self.settings.runs);
            let n_benchmarks = self.benchmarks_of(workload).count();
            let n_traced = self.n_rays_of(workload) * (n_pictures * n_benchmarks) as u64;
            if n_benchmarks > 0 { n_traced + self.n_compared(workload) } else { 0 }
        };
        self.workloads().map(of_workload).sum::<u64>() + self.n_shadow_rays()
    }

    fn workloads(self) -> impl Iterator<Item = Workload<'a>> {
        let Settings { distances, spheres, .. } = self.settings;
        let traced = self.cases.iter().filter(|case| case.class != SceneClass::Lit);
        let distances = distances.iter().map(|&distance| Workload::Distance(distance));
        let spheres = spheres.iter().map(|&n| Workload::Spheres(n));
        traced.map(Workload::Scene).chain(distances).chain(spheres)
    }

    /// Returns the benchmarks that take part. Only `certified` has a hierarchy, which many spheres need.
    fn benchmarks_of(self, workload: Workload) -> impl Iterator<Item = &'a Benchmark> {
        let is_many = matches!(workload, Workload::Spheres(n) if n > MOST_TESTED);
        self.benchmarks.iter().filter(move |of| !is_many || of.kernel == Kernel::Certified)
    }

    fn n_rays_of(&self, workload: Workload) -> u64 {
        match workload {
            Workload::Distance(_) => DISTANCE_RAYS as u64,
            _ => n_pixels(self.settings.size),
        }
    }

    /// Returns the number of rays to compare with exact arithmetic.
    fn n_compared(&self, workload: Workload) -> u64 {
        match workload {
            Workload::Scene(_) => n_pixels(self.settings.size).min(self.settings.samples as u64),
            Workload::Distance(_) => DISTANCE_RAYS as u64,
            Workload::Spheres(_) => 0,
        }
    }

    /// Generates the scene and the rays. They exist only while they are measured, to save memory.
    fn scene_and_rays(&self, workload: Workload) -> Result<(Arc<Scene>, Rays)> {
        let Settings { size, seed, .. } = *self.settings;
        Ok(match workload {
            Workload::Scene(case) => {
                (Arc::clone(&case.scene), Rays::Pixels(pixels_of(case.camera()?, size)))
            }
            Workload::Distance(distance) => sphere_at_distance(distance, seed),
            Workload::Spheres(n) => spheres_in_cube(n, seed, size, self.control)?,
        })
    }

    /// Measures each benchmark of each workload: errors in the first round, times in all.
    fn measured(self, missing: &mut Vec<Unmeasured>) -> Result<Vec<Measured<'a>>> {
        let unmeasured = |workload| {
            let of_benchmark = |benchmark| Measured {
                workload,
                benchmark,
                errors: RayErrors::default(),
                decided: StageCounts::default(),
                ns_per_ray: Vec::new(),
                build_ms: Vec::new(),
            };
            (workload, self.benchmarks_of(workload).map(of_benchmark).collect())
        };
        let mut all: Vec<(Workload, Vec<Measured>)> = self.workloads().map(unmeasured).collect();
        for round in 0..self.settings.rounds {
            for (workload, measured) in &mut all {
                if measured.is_empty() || round > 0 && !workload.is_timed() {
                    continue;
                }
                let (scene, rays) = self.scene_and_rays(*workload)?;
                let n_compared = if round == 0 { self.n_compared(*workload) } else { 0 };
                let truth = (n_compared > 0).then(|| {
                    let index = sample(rays.len(), n_compared as usize, self.settings.seed);
                    Truth::of_rays(&scene, &rays, index, self.control)
                });
                let truth = truth.transpose()?;
                for mut own in std::mem::take(measured) {
                    match (self.add_round(&mut own, &scene, &rays, truth.as_ref()), *workload) {
                        (Err(Error::TooLarge(why)), Workload::Spheres(n)) => {
                            let KernelOnDevice { kernel, device } = own.benchmark.names();
                            let what = format!("{n} spheres, {kernel} on {device}");
                            missing.push(Unmeasured { what, why: why.text });
                        }
                        (added, _) => {
                            added?;
                            measured.push(own);
                        }
                    }
                }
            }
        }
        Ok(all.into_iter().flat_map(|(_, measured)| measured).collect())
    }

    /// Adds a round of a benchmark: errors if the truth is known, and times.
    fn add_round(
        &self,
        measured: &mut Measured,
        scene: &Arc<Scene>,
        rays: &Rays,
        truth: Option<&Truth>,
    ) -> Result<()> {
        let mut hits = Hits::default();
        if let Some(truth) = truth {
            let mut tracer = measured.benchmark.tracer(scene, rays, SURFACE)?.tracer;
            tracer.trace(rays, self.control, &mut hits)?;
            measured.errors = RayErrors::new(&hits, truth);
            measured.decided = hits.counts;
        }
        if measured.workload.is_timed() {
            let mut tracer = measured.benchmark.tracer(scene, rays, IDS)?.tracer;
            measured.build_ms.push(1e3 * tracer.prepared().build_time().as_secs_f64());
            tracer.trace(rays, self.control, &mut hits)?;
            for _ in 0..self.settings.runs {
                let time = tracer.trace(rays, self.control, &mut hits)?.deciding();
                measured.ns_per_ray.push(1e9 * time.as_secs_f64() / rays.len() as f64);
            }
        }
        Ok(())
    }

    /// Returns the scenes of each class taken together.
    fn classes(&self, rows: &[SceneRow]) -> Vec<ClassRow> {
        let mut classes = Vec::new();
        for class in SceneClass::TRACED {
            for of in self.benchmarks.iter().map(Benchmark::names) {
                let own: Vec<_> =
                    rows.iter().filter(|row| row.class == class && row.of == of).collect();
                if own.is_empty() {
                    continue;
                }
                let mut errors = RayErrors::default();
                own.iter().for_each(|row| errors.add(&row.errors));
                let times: Vec<_> = own.iter().map(|row| row.ns_per_ray).collect();
                let ns_per_ray = TimeSpread::geometric_mean(&times);
                classes.push(ClassRow { class, of, scenes: own.len(), errors, ns_per_ray });
            }
        }
        classes
    }
}

impl Workload<'_> {
    fn is_timed(self) -> bool {
        !matches!(self, Workload::Distance(_))
    }
}

impl ReportScene {
    pub(crate) fn camera(&self) -> Result<&Camera> {
        self.scene.require_camera(self.name.as_ref())
    }
}

/// Returns all pixels of a picture.
pub fn pixels_of(camera: &Camera, [width, height]: [u32; 2]) -> Pixels {
    Pixels::whole(View::new(camera), width, height)
}

/// Returns the number of pixels of a picture.
pub fn n_pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}
