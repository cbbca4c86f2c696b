//! Runs every benchmark on every scene: errors once, times in rounds.

use std::sync::Arc;
use std::time::Duration;

use kugelblitz::Result;
use kugelblitz::control::Control;
use kugelblitz::device::{Device, Made};
use kugelblitz::memory;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::render::hits_bytes;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Rays, Timing, Wants};
use kugelblitz_judge::verify::{SAMPLE_BYTES, Truth, sample};

use super::samples::Samples;
use super::{Case, Class, Count, Metric, Of, Row, Settings, Spread};

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
    pub cases: &'a [Case],
    pub benchmarks: &'a [Benchmark],
    pub settings: &'a Settings,
}

impl<'a> Work<'a> {
    /// The benchmarks of the device that stands first.
    pub fn of_first_device(&self) -> impl Iterator<Item = &'a Benchmark> + use<'a> {
        let all = self.benchmarks;
        all.iter().take_while(|benchmark| benchmark.device == all[0].device)
    }

    /// The scenes whose rays are measured.
    pub fn timed(&self) -> impl Iterator<Item = &'a Case> + use<'a> {
        self.cases.iter().filter(|case| case.class != Class::Lit)
    }

    /// Rays that [`Work::scene_rows`] traces or compares, as [`Control::rays_done`] counts them.
    pub fn n_scene_rays(&self) -> u64 {
        let Settings { size, rounds, runs, samples, .. } = self.settings;
        let n_pixels = n_pixels(*size);
        let pictures = self.benchmarks.len() * 2 * rounds * (1 + runs);
        let of_scene = n_pixels * pictures as u64 + n_pixels.min(*samples as u64);
        self.timed().count() as u64 * of_scene
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
    /// Those of tracing; [`Error::Interrupted`](kugelblitz::Error::Interrupted).
    pub fn scene_rows(&self, control: &Control) -> Result<Vec<Row>> {
        self.refuse_what_cannot_fit()?;
        let Settings { size, samples, seed, rounds, runs, .. } = *self.settings;
        let n_measured = self.timed().count() * self.benchmarks.len();
        let mut measured = vec![Measured::default(); n_measured];
        for round in 0..rounds {
            let mut measured = measured.iter_mut();
            for case in self.timed() {
                let pixels = picture(case, size)?;
                let truth = match round {
                    0 => {
                        let index = sample(pixels.len(), samples, seed);
                        Some(Truth::of_pixels(&case.scene, &pixels, index, control)?)
                    }
                    _ => None,
                };
                let rays = Rays::Pixels(pixels);
                for (benchmark, measured) in self.benchmarks.iter().zip(&mut measured) {
                    let mut hits = Hits::default();
                    let mut timed = |wants| {
                        let mut made = benchmark.tracer(&case.scene, &rays, wants)?;
                        if wants == IDS {
                            made.tracer.use_device_clock();
                        }
                        run(made, &rays, runs, control, &mut hits)
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

    /// The errors of each class put together, and the means of its times.
    fn class_rows(&self, rows: &[Row], measured: &[Measured]) -> Vec<Row> {
        let mut classes = Vec::new();
        for class in [Class::Lecture, Class::Hard, Class::Given] {
            for (number, benchmark) in self.benchmarks.iter().enumerate() {
                // Of each scene there is a row for each benchmark, in their order.
                let of_benchmark =
                    || rows.iter().zip(measured).skip(number).step_by(self.benchmarks.len());
                let is_own = |(row, _): &(&Row, &Measured)| matches!(row.key.of, Of::Scene { class: own, .. } if own == class);
                let own = || of_benchmark().filter(is_own);
                let mut errors = Samples::default();
                own().for_each(|(_, measured)| errors.append(&measured.errors));
                errors.count(Count::Scenes, own().count() as u64);
                let mut row = Row::new(Of::Class { class }, benchmark, &[&errors]);
                for metric in [Metric::TraceNsPerRay, Metric::SurfaceNsPerRay] {
                    let times: Vec<_> = own().filter_map(|(row, _)| row.number(metric)).collect();
                    row.numbers.extend(geometric_mean(&times).map(|mean| (metric, mean)));
                }
                classes.extend((row.count(Count::Scenes) > 0).then_some(row));
            }
        }
        classes
    }
}

/// What was measured of a benchmark in a scene.
#[derive(Clone, Default)]
struct Measured {
    errors: Samples,
    costs: Samples,
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
pub fn picture(case: &Case, [width, height]: [u32; 2]) -> Result<Pixels> {
    let camera = case.scene.require_camera(case.name.as_ref())?;
    Ok(Pixels::whole(View::new(camera), width, height))
}

/// Pixels of a picture.
pub fn n_pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Of medians, least and largest values, each for itself; `None` of nothing.
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
pub struct Runs {
    n_rays: usize,
    compile: Duration,
    first: Timing,
    pub timed: Vec<Timing>,
    bytes_device: u64,
}

impl Runs {
    /// The times of all stages but the read-back.
    pub fn ns_per_ray(&self) -> impl Iterator<Item = f64> {
        self.timed.iter().map(|timing| self.ns(timing.deciding()))
    }

    fn ns(&self, time: Duration) -> f64 {
        1e9 * time.as_secs_f64() / self.n_rays as f64
    }
}

/// Traces once, and then as often as is timed; `hits` are those of the last run.
pub fn run(
    Made { mut tracer, compile, .. }: Made,
    rays: &Rays,
    n_timed: usize,
    control: &Control,
    hits: &mut Hits,
) -> Result<Runs> {
    let first = tracer.trace(rays, control, hits)?;
    let timed = (0..n_timed).map(|_| tracer.trace(rays, control, hits)).collect::<Result<_>>()?;
    Ok(Runs { n_rays: rays.len(), compile, first, timed, bytes_device: tracer.bytes_device() })
}

/// A time in milliseconds.
pub fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}
