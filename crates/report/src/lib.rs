//! Speed against error: the time of each kernel on each device, and its error against exact arithmetic.
//!
//! [`Work::measure`] makes a [`Report`]. [`text`], [`markdown`], [`plots`] and [`html`] render it.

use serde::Serialize;

mod chart;
mod environment;
mod generated;
pub mod html;
pub mod markdown;
mod measure;
pub mod plots;
mod scenes;
mod shadows;
mod stats;
mod table;
pub mod text;
mod theme;

pub use environment::{AdapterArithmetic, Environment};
pub use measure::{Benchmark, Work};
pub use scenes::{ReportScene, SceneClass, default_cases};
pub use stats::{ErrorQuantiles, RayErrors, TimeSpread};

use kugelblitz::query::StageCounts;

/// Version of the fields of a report in `docs/json.md`.
pub const SCHEMA: u32 = 3;

/// Results of one run of `kugelblitz report`.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Machine and program.
    pub environment: Environment,
    /// Amount of work.
    pub settings: Settings,
    /// Measured scenes.
    pub scenes: Vec<ReportScene>,
    /// Scenes of a class taken together: sums of counts, and the largest of the scenes' quantiles.
    pub classes: Vec<ClassRow>,
    /// Time and error of each scene.
    pub rays: Vec<SceneRow>,
    /// Error against the distance of a sphere; empty if scenes are given.
    pub distance: Vec<DistanceRow>,
    /// Time against the number of spheres in a cube; empty if scenes are given.
    pub spheres: Vec<SpheresRow>,
    /// Shadows of each scene with lights.
    pub shadows: Vec<ShadowRow>,
    /// Everything that could not be measured.
    pub missing: Vec<Unmeasured>,
}

/// Amount of work of a report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Width and height of each picture, pixels.
    pub size: [u32; 2],
    /// Maximum number of pixels of a picture to compare with exact arithmetic, drawn at random.
    pub samples: usize,
    /// Seed of this draw, and of the generated scenes and rays.
    pub seed: u64,
    /// Number of rounds. Each builds all tracers again, so that drifts of the machine show between rounds.
    pub rounds: usize,
    /// Timed runs in each round, after one that is not timed.
    pub runs: usize,
    /// Distances of a sphere of radius 1 from the camera. Unstable in JSON.
    pub distances: Vec<f64>,
    /// Numbers of spheres to time. Unstable in JSON.
    pub spheres: Vec<u64>,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            size: [1280, 720],
            samples: 1 << 16,
            seed: 0,
            rounds: 3,
            runs: 3,
            distances: (1..=12).map(|k| 10f64.powf(f64::from(k) / 2.0)).collect(),
            spheres: vec![1, 4, 16, 64, 256, 10_000, 100_000, 1_000_000],
        }
    }
}

/// A kernel on a device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KernelOnDevice {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Name of the adapter, or `CPU`.
    pub device: String,
}

/// Time and error of a kernel on a device, over all scenes of a class.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClassRow {
    /// Class of the scenes.
    pub class: SceneClass,
    /// Kernel and device.
    #[serde(flatten)]
    pub of: KernelOnDevice,
    /// Number of scenes.
    pub scenes: usize,
    /// Sums of counts, and the largest of the scenes' quantiles.
    #[serde(flatten)]
    pub errors: RayErrors,
    /// Time to find the visible object of each pixel, nanoseconds per ray: geometric means of the scenes' medians, minima and
    /// maxima.
    pub ns_per_ray: TimeSpread,
}

/// Time and error of a kernel on a device in one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneRow {
    /// Name of the scene.
    pub scene: String,
    /// Class of the scene.
    pub class: SceneClass,
    /// Kernel and device.
    #[serde(flatten)]
    pub of: KernelOnDevice,
    /// Errors of the compared rays.
    #[serde(flatten)]
    pub errors: RayErrors,
    /// Rays of the whole picture, by the stage that decided them.
    pub decided: StageCounts,
    /// Time to find the visible object of each pixel in all stages, without the read-back, nanoseconds per ray.
    pub ns_per_ray: TimeSpread,
}

/// Error of a kernel on a device for a sphere at a distance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DistanceRow {
    /// Distance of the centre from the camera, radii.
    pub distance: f64,
    /// Kernel and device.
    #[serde(flatten)]
    pub of: KernelOnDevice,
    /// Errors of the rays.
    #[serde(flatten)]
    pub errors: RayErrors,
}

/// Time of a kernel on a device for a number of spheres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpheresRow {
    /// Number of spheres.
    pub spheres: u64,
    /// Kernel and device.
    #[serde(flatten)]
    pub of: KernelOnDevice,
    /// Time to find the visible object of each pixel in all stages, without the read-back, nanoseconds per ray.
    pub ns_per_ray: TimeSpread,
    /// Time to build the hierarchy over the spheres, milliseconds; 0 without one.
    pub build_ms: TimeSpread,
}

/// Wrong shadows of a kernel with an epsilon in one scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ShadowRow {
    /// Name of the scene.
    pub scene: String,
    /// Name of the kernel. The CPU computes the shadows of all kernels.
    pub kernel: &'static str,
    /// Distance from the surface at which shadow rays start, world units; `null` for a kernel without an epsilon.
    pub epsilon: Option<f64>,
    /// Number of compared pixels.
    pub pixels: u64,
    /// Compared pixels times lights.
    pub shadow_rays: u64,
    /// Lights that reach the pixel and are left out (shadow acne).
    pub false_shadows: u64,
    /// Lights that do not reach the pixel and are counted (light leaks).
    pub leaks: u64,
    /// Pixels with a wrong byte.
    pub wrong_pixels: u64,
}

/// Something that could not be measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unmeasured {
    /// Device, kernel on a device, or number of spheres.
    pub what: String,
    /// Reason.
    pub why: String,
}
