//! Runs benchmarks on subjects: errors once, times in rounds.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use kugelblitz::control::Control;
use kugelblitz::device::{Device, Made};
use kugelblitz::memory;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::render::hits_bytes;
use kugelblitz::scene::{Camera, Scene};
use kugelblitz::trace::{Hits, Kernel, Rays, Timing, Wants};
use kugelblitz::{Error, Result};
use kugelblitz_judge::compare::{RayDifferences, RayError};
use kugelblitz_judge::verify::{SAMPLE_BYTES, Truth, ray_errors, sample};

use super::Metric::*;
use super::{
    Class, Count, Environment, Metric, Missing, Noise, Of, Report, ReportScene, Row, RowKey,
    Settings, Spread,
};

/// A picture's need.
pub const IDS: Wants = Wants { surface: false, level: false };

/// The need of depth and shading.
pub const SURFACE: Wants = Wants { surface: true, level: false };

/// A kernel on a device, to be measured.
pub struct Benchmark {
    /// The kernel.
    pub kernel: Kernel,
    /// The device.
    pub device: Device,
}

impl Benchmark {
    /// The adapter's name, or `CPU`.
    pub fn device_name(&self) -> &str {
        self.device.facts().map_or("CPU", |facts| &facts.name)
    }

    /// What a row of it is of, where there is no epsilon.
    pub fn key(&self, of: Of) -> RowKey {
        let (kernel, device) = (self.kernel.name().into(), self.device_name().into());
        RowKey { of, kernel, device, epsilon: None }
    }

    /// A new tracer for `scene` and `rays`, its shader compiled anew.
    pub(super) fn tracer(&self, scene: &Arc<Scene>, rays: &Rays, wants: Wants) -> Result<Made> {
        let prepared = Arc::new(Prepared::new(Arc::clone(scene), self.kernel, rays)?);
        if let Device::Gpu(gpu) = &self.device {
            gpu.forget_programs();
        }
        self.device.tracer(&prepared, wants)
    }
}

/// What a report is to measure.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    /// The scenes.
    pub cases: &'a [ReportScene],
    /// What is run on them. Benchmarks of one device stand together, the best device first.
    pub benchmarks: &'a [Benchmark],
    /// How much is measured.
    pub settings: &'a Settings,
    /// Counts the rays, and interrupts.
    pub control: &'a Control,
}

/// Makes a scene and rays through it, which take memory.
pub type Make<'a> = Box<dyn Fn() -> Result<(Arc<Scene>, Rays)> + 'a>;

/// What is timed, and which times of it are measured.
pub type Times = &'static [(Wants, &'static [Metric])];

/// Rays through a scene, and what is measured of them.
pub struct Subject<'a> {
    pub of: Of,
    pub make: Make<'a>,
    pub n_rays: u64,
    /// Most rays that are compared with exact arithmetic.
    pub n_compared: usize,
    pub times: Times,
    pub benchmarks: Vec<&'a Benchmark>,
}

impl Subject<'_> {
    /// Rays that [`Work::measured`] traces or compares, as [`Control::rays_done`] counts them.
    pub fn n_traced(&self, settings: &Settings) -> u64 {
        let n_timed = self.times.len() * settings.rounds * (1 + settings.runs);
        let n_pictures = n_timed + usize::from(self.n_compared > 0);
        let n_traced = self.n_rays * (n_pictures * self.benchmarks.len()) as u64;
        if n_traced > 0 { n_traced + self.n_rays.min(self.n_compared as u64) } else { 0 }
    }
}

/// What was measured of a benchmark in a subject.
struct Measured<'a> {
    of: Of,
    benchmark: &'a Benchmark,
    counts: BTreeMap<Count, u64>,
    values: BTreeMap<Metric, Vec<f64>>,
}

/// The times of a scene's picture.
const SCENE_TIMES: Times = &[
    (IDS, &[TraceNsPerRay, DeviceNsPerRay, ReadbackMs, CompileMs, FirstPictureMs]),
    (SURFACE, &[SurfaceNsPerRay]),
];

impl<'a> Work<'a> {
    /// Measures it all. The control counts [`Work::n_rays`] rays.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`].
    pub fn measure(self, environment: Environment) -> Result<Report> {
        let (mut rows, missing) = self.ray_rows()?;
        rows.extend(self.light_rows()?);
        Ok(Report {
            environment,
            settings: self.settings.clone(),
            scenes: self.cases.to_vec(),
            missing,
            noise: Noise::of(&rows),
            baseline: None,
            pictures: [self.pictures(&rows)?, self.light_pictures(&rows)?].concat(),
            rows,
        })
    }

    /// Rays that [`Work::measure`] traces, lights or compares, but for those of the few pictures.
    pub fn n_rays(self) -> u64 {
        let subjects = self.scenes().into_iter().chain(self.made());
        let n_traced = subjects.map(|subject| subject.n_traced(self.settings));
        n_traced.sum::<u64>() + self.n_light_rays()
    }

    /// The benchmarks of the device that stands first.
    pub(super) fn of_first_device(&self) -> &'a [Benchmark] {
        let mut devices = self.benchmarks.chunk_by(|a, b| a.device_name() == b.device_name());
        devices.next().unwrap_or_default()
    }

    /// The scenes whose rays are measured.
    pub(super) fn timed(&self) -> impl Iterator<Item = &'a ReportScene> + use<'a> {
        self.cases.iter().filter(|case| case.class != Class::Lit)
    }

    /// The rays of each scene's picture.
    fn scenes(self) -> Vec<Subject<'a>> {
        let Settings { size, samples, .. } = *self.settings;
        let subject = |case: &'a ReportScene| Subject {
            of: Of::Scene { scene: case.name.clone(), class: case.class },
            make: Box::new(move || {
                Ok((Arc::clone(&case.scene), Rays::Pixels(picture(case, size)?)))
            }),
            n_rays: n_pixels(size),
            n_compared: samples,
            times: SCENE_TIMES,
            benchmarks: self.benchmarks.iter().collect(),
        };
        self.timed().map(subject).collect()
    }

    fn refuse_what_cannot_fit(&self) -> Result<()> {
        let [width, height] = self.settings.size;
        let n_rays = n_pixels([width, height]);
        // Any ray may be among the undecided.
        let hits = hits_bytes(n_rays, SURFACE) + n_rays * size_of::<u32>() as u64;
        let samples = n_rays.min(self.settings.samples as u64) * SAMPLE_BYTES;
        let what = format!("measuring pictures of {width}x{height} pixels");
        memory::require(what, hits + samples, "measure a smaller --size, or fewer --samples")
    }

    /// All rows of rays: the scenes, their classes, and what is made for the report; and what did not fit.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`].
    fn ray_rows(self) -> Result<(Vec<Row>, Vec<Missing>)> {
        self.refuse_what_cannot_fit()?;
        let mut missing = Vec::new();
        let scenes = self.measured(&self.scenes(), &mut missing)?;
        let classes = self.class_rows(&scenes);
        let mut rows: Vec<Row> = scenes.into_iter().map(Measured::row).chain(classes).collect();
        // One after the other: the errors of each are many numbers.
        for subject in self.made() {
            rows.extend(self.measured(&[subject], &mut missing)?.into_iter().map(Measured::row));
        }
        Ok((rows, missing))
    }

    /// Each benchmark of each subject that fits: the errors in the first round, the times in all.
    fn measured(
        &self,
        subjects: &[Subject<'a>],
        missing: &mut Vec<Missing>,
    ) -> Result<Vec<Measured<'a>>> {
        let unmeasured = |subject: &Subject<'a>| -> Vec<Measured> {
            let nothing = |&benchmark| Measured {
                of: subject.of.clone(),
                benchmark,
                counts: BTreeMap::new(),
                values: BTreeMap::new(),
            };
            subject.benchmarks.iter().map(nothing).collect()
        };
        let mut all: Vec<_> = subjects.iter().map(unmeasured).collect();
        for round in 0..self.settings.rounds {
            for (subject, measured) in subjects.iter().zip(&mut all) {
                let is_over = round > 0 && subject.times.is_empty();
                if is_over || measured.is_empty() {
                    continue;
                }
                let (scene, rays) = (subject.make)()?;
                let truth = (round == 0 && subject.n_compared > 0).then(|| {
                    let index = sample(rays.len(), subject.n_compared, self.settings.seed);
                    Truth::of_rays(&scene, &rays, index, self.control)
                });
                let truth = truth.transpose()?;
                for mut own in std::mem::take(measured) {
                    match self.add_round(&mut own, (&scene, &rays), subject.times, truth.as_ref()) {
                        Err(Error::TooLarge(why)) if !matches!(own.of, Of::Scene { .. }) => {
                            let device = own.benchmark.device_name();
                            let what = format!("{} on {device}", own.of.name());
                            missing.push(Missing { what, why: why.text });
                        }
                        added => {
                            added?;
                            measured.push(own);
                        }
                    }
                }
            }
        }
        Ok(all.into_iter().flatten().collect())
    }

    /// Adds a round of a benchmark: the errors where the truth is there, and these times.
    fn add_round(
        &self,
        measured: &mut Measured,
        (scene, rays): (&Arc<Scene>, &Rays),
        times: Times,
        truth: Option<&Truth>,
    ) -> Result<()> {
        let benchmark = measured.benchmark;
        let mut hits = Hits::default();
        if let Some(truth) = truth {
            let mut tracer = benchmark.tracer(scene, rays, SURFACE)?.tracer;
            tracer.trace(rays, self.control, &mut hits)?;
            measured.add_errors(&hits, truth);
        }
        for (wants, metrics) in times {
            let mut made = benchmark.tracer(scene, rays, *wants)?;
            if metrics.contains(&DeviceNsPerRay)
                && let Some(backend) = made.tracer.backend()
            {
                backend.use_clock();
            }
            let trace = |_| made.tracer.trace(rays, self.control, &mut hits);
            let timings = (0..=self.settings.runs).map(trace).collect::<Result<Vec<_>>>()?;
            let (first, runs) = timings.split_at(1);
            let ns = |time: Duration| 1e9 * time.as_secs_f64() / rays.len() as f64;
            for &metric in *metrics {
                let value = |timing: &Timing| {
                    Some(match metric {
                        BuildMs => ms(made.tracer.prepared().build_time()),
                        CompileMs => ms(made.compile),
                        FirstPictureMs | PictureMs => ms(timing.deciding() + timing.readback),
                        ReadbackMs => ms(timing.readback),
                        DeviceNsPerRay => ns(timing.on_device?),
                        _ => ns(timing.deciding()),
                    })
                };
                let is_once = matches!(metric, BuildMs | CompileMs | FirstPictureMs);
                let timings = if is_once { first } else { runs };
                let values = timings.iter().filter_map(value);
                measured.values.entry(metric).or_default().extend(values);
            }
            // Of other subjects they don't repeat: tiles of many objects are as large as time allows.
            if *wants == IDS && matches!(measured.of, Of::Scene { .. }) {
                measured.counts.insert(Count::BytesDevice, made.tracer.bytes_device());
            }
        }
        Ok(())
    }

    /// The errors of each class put together, and the means of its times.
    fn class_rows(&self, scenes: &[Measured]) -> Vec<Row> {
        let mut rows = Vec::new();
        for class in Class::ALL {
            for benchmark in self.benchmarks {
                let is_own = |scene: &&Measured| {
                    matches!(scene.of, Of::Scene { class: own, .. } if own == class)
                        && std::ptr::eq(scene.benchmark, benchmark)
                };
                let own: Vec<_> = scenes.iter().filter(is_own).collect();
                if own.is_empty() {
                    continue;
                }
                let mut counts = BTreeMap::from([(Count::Scenes, own.len() as u64)]);
                own.iter().for_each(|scene| add(&mut counts, scene.counts.clone()));
                counts.remove(&Count::BytesDevice);
                let values = |metric| own.iter().filter_map(move |scene| scene.values.get(&metric));
                let error = |metric| {
                    Some((metric, Spread::of(values(metric).flatten().copied().collect())?))
                };
                let time = |metric| {
                    let times = values(metric).filter_map(|times| Spread::of(times.clone()));
                    Some((metric, geometric_mean(&times.collect::<Vec<_>>())?))
                };
                let errors = [TUlp, TRelative, NormalDegrees].into_iter().filter_map(error);
                let times = [TraceNsPerRay, SurfaceNsPerRay].into_iter().filter_map(time);
                let numbers = errors.chain(times).collect();
                rows.push(Row { key: benchmark.key(Of::Class { class }), numbers, counts });
            }
        }
        rows
    }
}

impl Measured<'_> {
    /// Adds the errors of a result against the truth about some of its rays.
    fn add_errors(&mut self, hits: &Hits, truth: &Truth) {
        let mut found = RayDifferences::default();
        for (ray, error) in ray_errors(hits, truth).enumerate() {
            found.see(ray, &error);
            if let RayError::Right { id: 1.., t, normal } = error {
                let errors = [
                    (TUlp, t.map(|t| t.ulp)),
                    (TRelative, t.map(|t| t.relative)),
                    (NormalDegrees, normal.map(|normal| normal.degrees)),
                ];
                for (metric, error) in errors {
                    self.values.entry(metric).or_default().extend(error);
                }
            }
        }
        let counts = [
            (Count::Rays, found.rays),
            (Count::FalseHits, found.false_hits),
            (Count::FalseMisses, found.false_misses),
            (Count::WrongObject, found.wrong_object),
            (Count::F32, hits.counts.f32),
            (Count::F64, hits.counts.f64),
            (Count::Exact, hits.counts.exact),
        ];
        add(&mut self.counts, counts);
    }

    fn row(self) -> Row {
        let spread = |(metric, values)| Some((metric, Spread::of(values)?));
        let numbers = self.values.into_iter().filter_map(spread).collect();
        Row { key: self.benchmark.key(self.of), numbers, counts: self.counts }
    }
}

/// Adds counts to those that are there.
pub fn add(counts: &mut BTreeMap<Count, u64>, more: impl IntoIterator<Item = (Count, u64)>) {
    more.into_iter().for_each(|(count, n)| *counts.entry(count).or_default() += n);
}

/// All pixels of a case's picture of a size.
pub fn picture(case: &ReportScene, size: [u32; 2]) -> Result<Pixels> {
    Ok(pixels_of(case.scene.require_camera(case.name.as_ref())?, size))
}

/// All pixels of a picture that a camera takes.
pub fn pixels_of(camera: &Camera, [width, height]: [u32; 2]) -> Pixels {
    Pixels::whole(View::new(camera), width, height)
}

/// Pixels of a picture.
pub fn n_pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Geometric means of medians, 99.9th percentiles, least and largest values, each for itself; `None` of nothing.
fn geometric_mean(spreads: &[Spread]) -> Option<Spread> {
    let mean = |part: fn(&Spread) -> f64| {
        let logarithms: f64 = spreads.iter().map(|spread| part(spread).ln()).sum();
        (logarithms / spreads.len() as f64).exp()
    };
    (!spreads.is_empty()).then(|| Spread {
        median: mean(|spread| spread.median),
        p999: mean(|spread| spread.p999),
        min: mean(|spread| spread.min),
        max: mean(|spread| spread.max),
        n: spreads.iter().map(|spread| spread.n).sum(),
    })
}

/// A time in milliseconds.
fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}
