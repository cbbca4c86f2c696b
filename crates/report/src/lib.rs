//! Speed against error: what each kernel costs on each device, and how wrong it is.
//!
//! [`Work::measure`] makes a list of [`Row`]s; [`text`], [`page`] and [`plot`] are views of them. All
//! errors are against exact arithmetic; all times are of the run that made the report.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};

mod answer;
mod baseline;
mod environment;
mod figures;
mod light;
mod measure;
mod noise;
mod order;
pub mod page;
mod pictures;
pub mod plot;
mod print;
mod scenes;
mod sweep;
mod tables;
pub mod text;

pub use baseline::{Baseline, Change, Earlier, TimeVerdict, WrongIds};
pub use environment::{AdapterArithmetic, Environment};
pub use light::LIGHT_SIZE;
pub use measure::{Benchmark, Work};
pub use noise::Noise;
pub use pictures::ErrorPicture;
pub use scenes::{Class, ReportScene, default_cases};
pub use sweep::{CLOUD_SIZE, SWEEPS, Sweep};

/// The version of a report's fields in `docs/json.md`.
pub const SCHEMA: u32 = 2;

/// Everything that one run of `kugelblitz report` found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The machine and the program.
    pub environment: Environment,
    /// How much was measured.
    pub settings: Settings,
    /// The scenes that were measured.
    pub scenes: Vec<ReportScene>,
    /// All numbers.
    pub rows: Vec<Row>,
    /// All that could not be measured, and why.
    pub missing: Vec<Missing>,
    /// How much the times spread.
    pub noise: Noise,
    /// What changed since an earlier report, where one is given.
    pub baseline: Option<Baseline>,
    /// Pictures of chosen scenes with their errors.
    #[serde(skip)]
    pub pictures: Vec<ErrorPicture>,
}

/// How much is measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
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

impl Default for Settings {
    fn default() -> Settings {
        Settings {
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

/// One kernel on one device, measured in one thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What the row is of. No other row of a report has the same.
    #[serde(flatten)]
    pub key: RowKey,
    /// Quantities that were measured several times or of several rays.
    pub numbers: BTreeMap<Metric, Spread>,
    /// Quantities that were counted.
    pub counts: BTreeMap<Count, u64>,
}

/// What a row is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RowKey {
    /// The thing that was measured.
    #[serde(flatten)]
    pub of: Of,
    /// The kernel's name.
    pub kernel: String,
    /// The adapter's name, or `CPU`.
    pub device: String,
    /// How far from a surface shadow rays start, world units; `None` for a kernel that needs none, and
    /// where no light is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epsilon: Option<f64>,
}

/// The thing that a row measures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "of", rename_all = "lowercase")]
pub enum Of {
    /// Rays of a scene's picture.
    Scene {
        /// The scene's name.
        scene: String,
        /// The scene's sort.
        class: Class,
    },
    /// The scenes of a class taken together: all errors, and the geometric means of times.
    Class {
        /// The sort of scenes.
        class: Class,
    },
    /// A point of one of the [`SWEEPS`].
    Sweep {
        /// The sweep's name.
        sweep: String,
        /// The quantity that is swept.
        x: f64,
    },
    /// A picture of many spheres.
    Cloud {
        /// How many.
        spheres: u64,
    },
    /// Light and shadow of a scene.
    Light {
        /// The scene's name.
        scene: String,
    },
}

/// A quantity with a [`Spread`]. "Ids" is a picture's need: which object each pixel shows. "Surface" adds
/// `t` and the normal of each hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Error of `t` in f32 steps at the exact `t`, where the object is right.
    TUlp,
    /// Error of `t` relative to the exact one, where the object is right.
    TRelative,
    /// Angle to the exact normal in degrees, where the object is right.
    NormalDegrees,
    /// All stages of tracing ids but the read-back, nanoseconds a ray.
    TraceNsPerRay,
    /// All stages of tracing ids, `t` and normals but the read-back, nanoseconds a ray.
    SurfaceNsPerRay,
    /// The compute passes alone by the device's own clock, ids, nanoseconds a ray.
    DeviceNsPerRay,
    /// From the device into memory, ids, milliseconds a picture.
    ReadbackMs,
    /// Putting the shader together and compiling it, milliseconds. Drivers keep compiled shaders
    /// on disk, so the largest is of the first time ever and the least of a cache.
    CompileMs,
    /// The first picture after that, all stages, milliseconds.
    FirstPictureMs,
    /// Building the hierarchy over the spheres, milliseconds.
    BuildMs,
    /// All stages of tracing a picture's ids and the read-back, milliseconds.
    PictureMs,
}

/// A quantity that is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Count {
    /// Scenes of a class that were measured.
    Scenes,
    /// Rays compared.
    Rays,
    /// Rays that hit an object where there is none.
    FalseHits,
    /// Rays that miss an object that is there.
    FalseMisses,
    /// Rays that hit another object than the visible one.
    WrongObject,
    /// Rays of the whole picture that f32 decided.
    F32,
    /// Rays of the whole picture that f64 decided.
    F64,
    /// Rays of the whole picture that exact arithmetic decided.
    Exact,
    /// Bytes on the device for scene and results.
    BytesDevice,
    /// Pixels whose light was compared.
    Pixels,
    /// Pixels times lights: for each, a light counts or does not.
    Verdicts,
    /// Lights that count and are left out: acne.
    FalseShadows,
    /// Lights that don't count and are let in.
    Leaks,
    /// Pixels with a wrong byte.
    WrongBytes,
    /// Pixels with a byte that is off by more than 8 levels.
    FarBytes,
}

impl Row {
    /// A quantity's values; `None` where it was not measured.
    pub fn number(&self, metric: Metric) -> Option<Spread> {
        self.numbers.get(&metric).copied()
    }

    /// A count; 0 where nothing was counted.
    pub fn count(&self, count: Count) -> u64 {
        self.counts.get(&count).copied().unwrap_or(0)
    }

    /// The time of ids, if a logarithmic axis has a place for it.
    fn time(&self) -> Option<Spread> {
        let is_drawable = |time: &Spread| time.median > 0.0 && time.median.is_finite();
        self.number(Metric::TraceNsPerRay).filter(is_drawable)
    }

    /// Rays with a wrong id.
    pub fn wrong_ids(&self) -> u64 {
        let wrong = [Count::FalseHits, Count::FalseMisses, Count::WrongObject];
        wrong.iter().map(|&count| self.count(count)).sum()
    }

    /// Share of rays with a wrong id, 0 to 1.
    pub fn wrong_share(&self) -> f64 {
        self.wrong_ids() as f64 / self.count(Count::Rays).max(1) as f64
    }

    /// Lights that are wrongly in shadow or not.
    pub fn wrong_shadows(&self) -> u64 {
        self.count(Count::FalseShadows) + self.count(Count::Leaks)
    }
}

/// Middle, nearly worst and outermost of several values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Middle value.
    #[serde(deserialize_with = "number_or_infinity")]
    pub median: f64,
    /// 99.9 % of the values are not larger.
    #[serde(deserialize_with = "number_or_infinity")]
    pub p999: f64,
    /// Least value.
    #[serde(deserialize_with = "number_or_infinity")]
    pub min: f64,
    /// Largest value.
    #[serde(deserialize_with = "number_or_infinity")]
    pub max: f64,
    /// Number of values.
    pub n: usize,
}

/// JSON has no infinity; there it is `null`.
fn number_or_infinity<'de, D: Deserializer<'de>>(json: D) -> std::result::Result<f64, D::Error> {
    Ok(Option::deserialize(json)?.unwrap_or(f64::INFINITY))
}

impl Spread {
    /// The spread of some values, none of them NaN; `None` for none.
    pub fn of(mut values: Vec<f64>) -> Option<Spread> {
        values.sort_unstable_by(f64::total_cmp);
        let n = values.len();
        let (&min, &max) = (values.first()?, values.last()?);
        let median = (values[(n - 1) / 2] + values[n / 2]) / 2.0;
        // Nearest rank: the smallest value that at least this share does not exceed.
        let p999 = values[((0.999 * n as f64).ceil() as usize).clamp(1, n) - 1];
        Some(Spread { median, p999, min, max, n })
    }

    /// The range as a share of the median; `None` of less than two values.
    pub fn relative_range(&self) -> Option<f64> {
        let share = (self.max - self.min) / self.median;
        (self.n > 1).then_some(if self.max > self.min { share } else { 0.0 })
    }
}

/// Something that could not be measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Missing {
    /// A device, a kernel on a device, a cloud.
    pub what: String,
    /// Why.
    pub why: String,
}
