//! Speed against error: what each kernel costs on each device, and how wrong it is.
//!
//! [`Report::measure`] makes one; [`text`], [`page`] and [`plot`] show it. All errors are against
//! exact arithmetic; all times are of the run that made the report.

use serde::{Deserialize, Serialize};

mod answer;
mod baseline;
mod clouds;
mod errors;
mod evidence;
mod figures;
mod light;
mod measure;
mod noise;
pub mod page;
mod pictures;
pub mod plot;
mod print;
mod scenes;
mod summary;
mod sweep;
mod tables;
pub mod text;

pub use baseline::{Baseline, Change, Earlier, Verdict, WrongIds};
pub use clouds::CLOUD_SIZE;
pub use errors::{Distribution, Errors};
pub use light::{LIGHT_SIZE, LightErrors, LightFault, LightPicture, LightResult, LightRow};
pub use measure::{Make, Subject};
pub use noise::Noise;
pub use scenes::{Case, default_cases};

use crate::control::Control;
use crate::error::Result;

/// The version of `docs/json.md`, which every summary begins with.
pub const SCHEMA: u32 = 1;

/// Everything that one run of `kugelblitz report` found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The machine and the program.
    pub evidence: Evidence,
    /// How much was measured.
    pub effort: Effort,
    /// Each scene with each kernel on each device.
    pub scenes: Vec<SceneResult>,
    /// The scenes of a class taken together: one row a kernel and device.
    pub classes: Vec<ClassResult>,
    /// Error and time against one quantity.
    pub sweeps: Vec<Sweep>,
    /// Many spheres: each number of them on each device.
    pub clouds: Vec<CloudResult>,
    /// Light and shadow in each scene with lights.
    pub light: Vec<LightResult>,
    /// All that could not be measured, and why.
    pub missing: Vec<Missing>,
    /// How much the times spread.
    pub noise: Noise,
    /// What changed since an earlier report, where one is given.
    pub baseline: Option<Baseline>,
    /// Pictures of chosen scenes with their errors.
    #[serde(skip)]
    pub pictures: Vec<ErrorPicture>,
    /// Pictures of chosen lit scenes with their errors.
    #[serde(skip)]
    pub light_pictures: Vec<LightPicture>,
}

impl Report {
    /// Measures `subjects` on `cases`. Subjects of one device stand together, the best device
    /// first. `control` counts [`Report::n_rays`] rays.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn measure(
        evidence: Evidence,
        cases: &[Case],
        subjects: &[Subject],
        effort: Effort,
        control: &Control,
    ) -> Result<Report> {
        let (scenes, classes) = measure::measure_scenes(cases, subjects, &effort, control)?;
        let pictures = pictures::take_pictures(cases, &scenes, subjects, &effort, control)?;
        let sweeps = match effort.sweeps {
            true => sweep::measure_sweeps(subjects, &effort, control)?,
            false => Vec::new(),
        };
        let (clouds, missing) = clouds::measure_clouds(subjects, &effort, control)?;
        let light = light::measure_light(cases, subjects, &effort, control)?;
        let light_pictures = light::take_light_pictures(cases, &light, subjects, &effort, control)?;
        let noise = Noise::of(&scenes);
        Ok(Report {
            evidence,
            effort,
            scenes,
            classes,
            sweeps,
            clouds,
            light,
            missing,
            noise,
            baseline: None,
            pictures,
            light_pictures,
        })
    }

    /// Rays that [`Report::measure`] traces, lights or compares, but for those of the few pictures.
    pub fn n_rays(cases: &[Case], subjects: &[Subject], effort: &Effort) -> u64 {
        let sweeps = if effort.sweeps { sweep::n_rays(subjects, effort) } else { 0 };
        let clouds = clouds::n_rays(subjects, effort);
        let light = light::n_rays(cases, subjects, effort);
        measure::n_rays(cases, subjects, effort) + sweeps + clouds + light
    }
}

/// A kernel on a device.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Contestant {
    /// The kernel's name.
    pub kernel: String,
    /// The adapter's name, or `CPU`.
    pub device: String,
}

/// How much is measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effort {
    /// Size of the pictures that are timed and whose pixels are compared.
    pub size: [u32; 2],
    /// Most pixels of a picture that are compared with exact arithmetic; drawn at random where the
    /// picture has more.
    pub samples: usize,
    /// Seed of that draw and of the sweeps' scenes and rays.
    pub seed: u64,
    /// How often everything is measured anew, tracer and shader included. Drifts of the machine
    /// show between rounds.
    pub rounds: usize,
    /// Timed runs in each round, after a first picture that counts apart.
    pub runs: usize,
    /// Size of the error pictures.
    pub picture_size: [u32; 2],
    /// True where the sweeps are measured.
    pub sweeps: bool,
    /// Numbers of spheres of the clouds that are measured.
    pub clouds: Vec<u64>,
}

impl Default for Effort {
    fn default() -> Effort {
        Effort {
            size: [1280, 720],
            samples: 1 << 16,
            seed: 0,
            rounds: 3,
            runs: 3,
            picture_size: [320, 180],
            sweeps: true,
            clouds: vec![10_000, 100_000, 1_000_000],
        }
    }
}

/// The machine and the program.
#[derive(Clone, Debug, Serialize)]
pub struct Evidence {
    /// The program's version.
    pub version: String,
    /// The commit that it was built from, where the build was told.
    pub commit: Option<String>,
    /// Date and time of the start, UTC, as in `2026-11-21T07:00:00Z`.
    pub date: String,
    /// The command line.
    pub command: String,
    /// The host's operating system.
    pub system: String,
    /// The host's CPU.
    pub host_cpu: String,
    /// Its logical cores.
    pub n_cores: usize,
    /// The adapters, the best first.
    pub adapters: Vec<AdapterEvidence>,
}

/// An adapter and what its arithmetic really does.
#[derive(Clone, Debug, Serialize)]
pub struct AdapterEvidence {
    /// The adapter's own account of itself.
    #[serde(flatten)]
    pub facts: crate::gpu::AdapterFacts,
    /// The self-test's findings in f32.
    pub arithmetic_f32: crate::gpu::Arithmetic,
    /// Those in f64; `None` where the device has none.
    pub arithmetic_f64: Option<crate::gpu::Arithmetic>,
}

/// Sort of a scene, by which results are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The lecture's figures.
    Lecture,
    /// Where f32 has a hard time.
    Hard,
    /// Where shadows are hard to tell. Their light is measured, not their rays.
    Lit,
    /// Named on the command line.
    Given,
}

impl Class {
    /// In a table or a legend.
    pub fn name(self) -> &'static str {
        match self {
            Class::Lecture => "lecture's scenes",
            Class::Hard => "hard scenes",
            Class::Lit => "lit scenes",
            Class::Given => "given scenes",
        }
    }
}

/// One scene with each kernel on each device.
#[derive(Clone, Debug, Serialize)]
pub struct SceneResult {
    /// The file's name without folder and ending.
    pub name: String,
    /// Sort of the scene.
    pub class: Class,
    /// The file's first comment: what it shows.
    pub about: String,
    /// Spheres in it.
    pub n_spheres: usize,
    /// Planes in it.
    pub n_planes: usize,
    /// One row a kernel and device.
    pub rows: Vec<Row>,
}

/// One kernel on one device in one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Who was measured.
    #[serde(flatten)]
    pub contestant: Contestant,
    /// How wrong it is.
    pub errors: Errors,
    /// Its time and memory.
    pub cost: Cost,
}

/// All scenes of a class for one kernel on one device.
#[derive(Clone, Debug, Serialize)]
pub struct ClassResult {
    /// The class.
    pub class: Class,
    /// Scenes in it that this was measured on.
    pub n_scenes: usize,
    /// Who was measured.
    #[serde(flatten)]
    pub contestant: Contestant,
    /// The errors of all scenes' samples put together.
    pub errors: Errors,
    /// The geometric mean of the scenes' medians, and of their least and largest times.
    pub trace_ns_per_ray: Spread,
    /// The same with `t` and normals.
    pub surface_ns_per_ray: Spread,
}

/// Median and range of repeated measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Middle value.
    pub median: f64,
    /// Least value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Number of values.
    pub n: usize,
}

impl Spread {
    /// Of some values; `None` for none.
    pub fn of(mut values: Vec<f64>) -> Option<Spread> {
        values.sort_by(f64::total_cmp);
        let (&min, &max) = (values.first()?, values.last()?);
        let upper = values.len() / 2;
        let lower = (values.len() - 1) / 2;
        Some(Spread { median: (values[lower] + values[upper]) / 2.0, min, max, n: values.len() })
    }

    /// The range as a share of the median; `None` of less than two values.
    pub fn relative_range(&self) -> Option<f64> {
        let share = (self.max - self.min) / self.median;
        (self.n > 1).then_some(if self.max > self.min { share } else { 0.0 })
    }
}

/// Time and memory of one kernel on one device in one scene. "Ids" is a picture's need: which
/// object each pixel shows. "Surface" adds `t` and the normal of each hit.
#[derive(Clone, Debug, Serialize)]
pub struct Cost {
    /// Rays of one picture.
    pub n_rays: u64,
    /// All stages of tracing ids but the read-back, nanoseconds a ray.
    pub trace_ns_per_ray: Spread,
    /// The same with `t` and normals.
    pub surface_ns_per_ray: Spread,
    /// The compute passes alone by the device's own clock, ids, nanoseconds a ray; `None` where it
    /// has no clock, and on the CPU.
    pub device_ns_per_ray: Option<Spread>,
    /// From the device into memory, ids, milliseconds a picture.
    pub readback_ms: Spread,
    /// Putting the shader together and compiling it, milliseconds. Drivers keep compiled shaders
    /// on disk, so the largest is of the first time ever and the least of a cache.
    pub compile_ms: Spread,
    /// The first picture after that, all stages, milliseconds.
    pub first_picture_ms: Spread,
    /// Bytes on the device for scene and results.
    pub bytes_device: u64,
}

/// Error and time against one quantity.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    /// `distance`, `offset` or `objects`.
    pub name: &'static str,
    /// Its subject, in a sentence.
    pub title: &'static str,
    /// The quantity in words.
    pub x_label: &'static str,
    /// One series a kernel and device.
    pub series: Vec<Series>,
}

/// One kernel on one device along a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    /// Who was measured.
    #[serde(flatten)]
    pub contestant: Contestant,
    /// In ascending order of `x`.
    pub points: Vec<SweepPoint>,
}

/// One point of a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct SweepPoint {
    /// The quantity.
    pub x: f64,
    /// In sweeps of errors.
    pub errors: Option<Errors>,
    /// In sweeps of time: tracing ids.
    pub trace_ns_per_ray: Option<Spread>,
}

/// Many spheres with `certified` on one device.
#[derive(Clone, Debug, Serialize)]
pub struct CloudResult {
    /// Spheres in the cloud.
    pub n_spheres: u64,
    /// Who was measured.
    #[serde(flatten)]
    pub contestant: Contestant,
    /// How wrong it is.
    pub errors: Errors,
    /// Building the hierarchy over the spheres, milliseconds.
    pub build_ms: Spread,
    /// All stages of tracing a picture's ids and the read-back, milliseconds.
    pub picture_ms: Spread,
}

/// Something that could not be measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Missing {
    /// A device, a kernel on a device, a cloud.
    pub what: String,
    /// Why.
    pub why: String,
}

/// A kernel's picture of a scene, and the error of each pixel.
#[derive(Clone, Debug)]
pub struct ErrorPicture {
    /// The scene's name.
    pub scene: String,
    /// The kernel and device.
    pub contestant: Contestant,
    /// Width, px.
    pub width: u32,
    /// Height, px.
    pub height: u32,
    /// 8-bit sRGB, row by row from the top.
    pub srgb: Vec<[u8; 3]>,
    /// The error of each pixel.
    pub faults: Vec<Fault>,
}

/// The error of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Background, as it should be.
    Background,
    /// The right object; the error of `t` in f32 steps at the exact `t`.
    Right {
        /// Error of `t`, ulp.
        t_ulp: f64,
    },
    /// An object where there is none.
    FalseHit,
    /// No object where there is one.
    FalseMiss,
    /// Another object than the visible one.
    WrongObject,
}
