//! Runs every benchmark on every scene: errors once, times in rounds.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use kugelblitz::control::Control;
use kugelblitz::device::{Device, Made};
use kugelblitz::memory;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::render::hits_bytes;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Rays, Timing, Wants};
use kugelblitz::{Error, Result};
use kugelblitz_judge::compare::{RayDifferences, RayError};
use kugelblitz_judge::verify::{SAMPLE_BYTES, Truth, ray_errors, sample};

use super::{Class, Count, Metric, Missing, Of, ReportScene, Row, Settings, Spread};

/// A picture's need.
pub const IDS: Wants = Wants { surface: false, level: false };

/// The need of depth and shading.
pub const SURFACE: Wants = Wants { surface: true, level: false };

/// The CPU as a device's name.
const CPU: &str = "CPU";

/// Makes the tracer that is measured.
pub type Make = Box<dyn Fn(&Arc<Prepared>, Wants) -> Result<Made>>;

/// A kernel on a device, or anything else that traces, to be measured.
pub struct Benchmark {
    /// The kernel's name in the report.
    pub name: String,
    /// The adapter's name, or `CPU`.
    pub device: String,
    /// The kernel that scenes are prepared for.
    pub kernel: Kernel,
    /// Makes its tracer.
    pub make: Make,
}

impl Benchmark {
    /// A kernel on a device.
    pub fn new(kernel: Kernel, device: &Device) -> Benchmark {
        let device = device.clone();
        Benchmark {
            name: kernel.name().into(),
            device: device.facts().map_or(CPU, |facts| &facts.name).into(),
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

/// What is to be measured.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    pub cases: &'a [ReportScene],
    pub benchmarks: &'a [Benchmark],
    pub settings: &'a Settings,
    pub control: &'a Control,
}

impl<'a> Work<'a> {
    /// The benchmarks of the device that stands first.
    pub fn of_first_device(&self) -> impl Iterator<Item = &'a Benchmark> + use<'a> {
        let all = self.benchmarks;
        all.iter().take_while(|benchmark| benchmark.device == all[0].device)
    }

    /// The scenes whose rays are measured.
    pub fn timed(&self) -> impl Iterator<Item = &'a ReportScene> + use<'a> {
        self.cases.iter().filter(|case| case.class != Class::Lit)
    }

    /// Pictures of a benchmark in all rounds, those included that come first in each.
    pub fn n_pictures(&self) -> u64 {
        (self.settings.rounds * (1 + self.settings.runs)) as u64
    }

    /// Rays that [`Work::scene_rows`] traces or compares, as [`Control::rays_done`] counts them.
    pub fn n_scene_rays(&self) -> u64 {
        let n_pixels = n_pixels(self.settings.size);
        let n_pictures = self.benchmarks.len() as u64 * 2 * self.n_pictures();
        let n_compared = n_pixels.min(self.settings.samples as u64);
        self.timed().count() as u64 * (n_pixels * n_pictures + n_compared)
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

    /// Each benchmark's errors and costs in each scene, then those of each class of scenes.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`].
    pub fn scene_rows(&self) -> Result<Vec<Row>> {
        self.refuse_what_cannot_fit()?;
        let Settings { size, samples, seed, rounds, .. } = *self.settings;
        let n_measured = self.timed().count() * self.benchmarks.len();
        let mut measured = vec![Measured::default(); n_measured];
        for round in 0..rounds {
            let mut measured = measured.iter_mut();
            for case in self.timed() {
                let pixels = picture(case, size)?;
                let index = || sample(pixels.len(), samples, seed);
                let truth = || Truth::of_pixels(&case.scene, &pixels, index(), self.control);
                let truth = (round == 0).then(truth).transpose()?;
                let rays = Rays::Pixels(pixels);
                for (benchmark, measured) in self.benchmarks.iter().zip(&mut measured) {
                    let mut hits = Hits::default();
                    let mut timed = |wants| {
                        let mut made = benchmark.tracer(&case.scene, &rays, wants)?;
                        if wants == IDS {
                            made.tracer.use_device_clock();
                        }
                        self.run(made, &rays, &mut hits)
                    };
                    measured.add(&timed(IDS)?, &timed(SURFACE)?);
                    if let Some(truth) = &truth {
                        measured.errors.add_errors(&hits, truth);
                    }
                }
            }
        }
        let mut own = measured.iter();
        let mut rows = Vec::new();
        for case in self.timed() {
            let of = Of::Scene { scene: case.name.clone(), class: case.class };
            for (benchmark, measured) in self.benchmarks.iter().zip(&mut own) {
                rows.push(Row::new(of.clone(), benchmark, &[&measured.errors, &measured.costs]));
            }
        }
        let classes = self.class_rows(&rows, &measured);
        Ok([rows, classes].concat())
    }

    /// A row for each of some benchmarks, and what did not fit.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`].
    pub fn rows<'b>(
        &self,
        of: &Of,
        benchmarks: impl IntoIterator<Item = &'b Benchmark>,
        subject: &Subject,
    ) -> Result<(Vec<Row>, Vec<Missing>)> {
        let (mut rows, mut missing) = (Vec::new(), Vec::new());
        for benchmark in benchmarks {
            match self.measured(benchmark, subject) {
                Ok(samples) => rows.push(Row::new(of.clone(), benchmark, &[&samples])),
                Err(Error::TooLarge(why)) => {
                    missing.push(Missing {
                        what: format!("{} on {}", of.name(), benchmark.device),
                        why,
                    });
                }
                Err(error) => return Err(error),
            }
        }
        Ok((rows, missing))
    }

    fn measured(
        &self,
        benchmark: &Benchmark,
        Subject { scene, rays, truth, n_rounds }: &Subject,
    ) -> Result<ResultSamples> {
        let (mut samples, mut hits) = (ResultSamples::default(), Hits::default());
        if let Some(truth) = truth {
            benchmark.tracer(scene, rays, SURFACE)?.tracer.trace(rays, self.control, &mut hits)?;
            samples.add_errors(&hits, truth);
        }
        for _ in 0..*n_rounds {
            let prepared = Arc::new(Prepared::new(Arc::clone(scene), benchmark.kernel, rays)?);
            samples.add(Metric::BuildMs, [ms(prepared.build_time())]);
            let made = (benchmark.make)(&prepared, IDS)?;
            let runs = self.run(made, rays, &mut hits)?;
            samples.add(Metric::TraceNsPerRay, runs.ns_per_ray());
            let of_pictures = runs.timed.iter().map(|time| ms(time.deciding() + time.readback));
            samples.add(Metric::PictureMs, of_pictures);
        }
        Ok(samples)
    }

    /// The errors of each class put together, and the means of its times.
    fn class_rows(&self, rows: &[Row], measured: &[Measured]) -> Vec<Row> {
        let mut classes = Vec::new();
        for class in [Class::Lecture, Class::Hard, Class::Given] {
            for (number, benchmark) in self.benchmarks.iter().enumerate() {
                // Of each scene there is a row for each benchmark, in their order.
                let cases = self.timed().enumerate().filter(|(_, case)| case.class == class);
                let own: Vec<usize> =
                    cases.map(|(at, _)| at * self.benchmarks.len() + number).collect();
                if own.is_empty() {
                    continue;
                }
                let mut errors = ResultSamples::default();
                own.iter().for_each(|&at| errors.append(&measured[at].errors));
                errors.count(Count::Scenes, own.len() as u64);
                let mut row = Row::new(Of::Class { class }, benchmark, &[&errors]);
                for metric in [Metric::TraceNsPerRay, Metric::SurfaceNsPerRay] {
                    let times: Vec<_> =
                        own.iter().filter_map(|&at| rows[at].number(metric)).collect();
                    row.numbers.extend(geometric_mean(&times).map(|mean| (metric, mean)));
                }
                classes.push(row);
            }
        }
        classes
    }

    /// Traces once, and then as often as is timed; `hits` are those of the last run.
    fn run(&self, made: Made, rays: &Rays, hits: &mut Hits) -> Result<Runs> {
        let Made { mut tracer, compile, .. } = made;
        let mut trace = || tracer.trace(rays, self.control, hits);
        let first = trace()?;
        let timed = (0..self.settings.runs).map(|_| trace()).collect::<Result<_>>()?;
        Ok(Runs { n_rays: rays.len(), compile, first, timed, bytes_device: tracer.bytes_device() })
    }
}

/// Rays through a scene, what is true of them where their errors are measured, and how often they are timed.
pub struct Subject {
    pub scene: Arc<Scene>,
    pub rays: Rays,
    pub truth: Option<Truth>,
    pub n_rounds: usize,
}

/// What was measured of a benchmark in a scene.
#[derive(Clone, Default)]
struct Measured {
    errors: ResultSamples,
    costs: ResultSamples,
}

impl Measured {
    /// Adds a round: its runs of ids, and those with `t` and normals.
    fn add(&mut self, ids: &Runs, surface: &Runs) {
        let costs = &mut self.costs;
        costs.add(Metric::TraceNsPerRay, ids.ns_per_ray());
        costs.add(Metric::SurfaceNsPerRay, surface.ns_per_ray());
        let on_device = ids.timed.iter().filter_map(|timing| timing.on_device);
        costs.add(Metric::DeviceNsPerRay, on_device.map(|time| ids.ns(time)));
        costs.add(Metric::ReadbackMs, ids.timed.iter().map(|timing| ms(timing.readback)));
        costs.add(Metric::CompileMs, [ms(ids.compile)]);
        costs.add(Metric::FirstPictureMs, [ms(ids.first.deciding() + ids.first.readback)]);
        costs.set(Count::BytesDevice, ids.bytes_device);
    }
}

/// All pixels that `case`'s camera sees at a size.
pub fn picture(case: &ReportScene, [width, height]: [u32; 2]) -> Result<Pixels> {
    let camera = case.scene.require_camera(case.name.as_ref())?;
    Ok(Pixels::whole(View::new(camera), width, height))
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

/// The work of one tracer: a first run, and those that are timed.
struct Runs {
    n_rays: usize,
    compile: Duration,
    first: Timing,
    timed: Vec<Timing>,
    bytes_device: u64,
}

impl Runs {
    /// The times of all stages but the read-back.
    fn ns_per_ray(&self) -> impl Iterator<Item = f64> {
        self.timed.iter().map(|timing| self.ns(timing.deciding()))
    }

    fn ns(&self, time: Duration) -> f64 {
        1e9 * time.as_secs_f64() / self.n_rays as f64
    }
}

/// A time in milliseconds.
fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

/// Values and counts of one or more results.
#[derive(Clone, Debug, Default)]
pub struct ResultSamples {
    pub counts: BTreeMap<Count, u64>,
    values: BTreeMap<Metric, Vec<f64>>,
}

impl ResultSamples {
    /// Adds `n` to a count.
    pub fn count(&mut self, count: Count, n: u64) {
        *self.counts.entry(count).or_default() += n;
    }

    /// Sets a count.
    pub fn set(&mut self, count: Count, n: u64) {
        self.counts.insert(count, n);
    }

    /// Adds values of a quantity.
    pub fn add(&mut self, metric: Metric, values: impl IntoIterator<Item = f64>) {
        self.values.entry(metric).or_default().extend(values);
    }

    /// Adds the errors of a result against the truth about some of its rays.
    pub fn add_errors(&mut self, hits: &Hits, truth: &Truth) {
        let mut found = RayDifferences::default();
        for (ray, error) in ray_errors(hits, truth).enumerate() {
            found.see(ray, &error);
            if let RayError::Right { id: 1.., t, normal } = error {
                self.add(Metric::TUlp, t.map(|t| t.ulp));
                self.add(Metric::TRelative, t.map(|t| t.relative));
                self.add(Metric::NormalDegrees, normal.map(|normal| normal.degrees));
            }
        }
        for (count, n) in [
            (Count::Rays, found.rays),
            (Count::FalseHits, found.false_hits),
            (Count::FalseMisses, found.false_misses),
            (Count::WrongObject, found.wrong_object),
            (Count::F32, hits.counts.f32),
            (Count::F64, hits.counts.f64),
            (Count::Exact, hits.counts.exact),
        ] {
            self.count(count, n);
        }
    }

    /// Adds what another one collected.
    pub fn append(&mut self, other: &ResultSamples) {
        other.counts.iter().for_each(|(&count, &n)| self.count(count, n));
        other.values.iter().for_each(|(&metric, values)| self.add(metric, values.iter().copied()));
    }

    /// How the values of each quantity lie.
    pub fn spreads(&self) -> impl Iterator<Item = (Metric, Spread)> {
        let values = self.values.iter();
        values.filter_map(|(&metric, values)| Some((metric, Spread::of(values.clone())?)))
    }
}
