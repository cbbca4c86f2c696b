//! What every JSON summary begins with, and the parts that several have.

use kugelblitz::device::Device;
use kugelblitz::gpu::AdapterFacts;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{StageCounts, Timing};
use serde::Serialize;

use super::output::ms;

/// The head of every summary.
#[derive(Serialize)]
pub struct Head {
    schema: u32,
    version: &'static str,
    command: &'static str,
}

impl Head {
    /// The head of `command`.
    pub fn new(command: &'static str) -> Head {
        Head { schema: 1, version: env!("CARGO_PKG_VERSION"), command }
    }
}

/// What traced.
#[derive(Serialize)]
pub struct On {
    adapter: Option<Adapter>,
    device: &'static str,
}

#[derive(Serialize)]
struct Adapter {
    name: String,
    #[serde(rename = "type")]
    kind: &'static str,
    driver: String,
}

impl From<&Device> for On {
    fn from(device: &Device) -> On {
        let adapter = |facts: &AdapterFacts| Adapter {
            name: facts.name.clone(),
            kind: facts.kind,
            driver: facts.driver.clone(),
        };
        On { adapter: device.facts().map(adapter), device: device.kind() }
    }
}

/// Objects of the scene.
#[derive(Serialize)]
pub struct Objects {
    spheres: usize,
    planes: usize,
}

impl From<&Scene> for Objects {
    fn from(scene: &Scene) -> Objects {
        Objects { spheres: scene.spheres.len(), planes: scene.planes.len() }
    }
}

/// Rays, and how many each stage decided.
#[derive(Serialize)]
pub struct RayCounts {
    total: u64,
    #[serde(flatten)]
    stages: StageCounts,
}

impl From<StageCounts> for RayCounts {
    fn from(stages: StageCounts) -> RayCounts {
        RayCounts { total: stages.total(), stages }
    }
}

/// Milliseconds of all stages.
#[derive(Default, Serialize)]
pub struct Ms {
    pub read: f64,
    pub prepare: f64,
    /// The hierarchy over many spheres.
    pub build: f64,
    pub upload: f64,
    pub compile: f64,
    #[serde(flatten)]
    pub stages: MsStages,
    /// Colours.
    pub shade: f64,
    pub write: f64,
    /// From the program's start, so with opening the device as well.
    pub total: f64,
}

/// Milliseconds of the tracing stages.
#[derive(Default, Serialize)]
pub struct MsStages {
    trace: f64,
    refine: f64,
    decide: f64,
    readback: f64,
}

impl From<Timing> for MsStages {
    fn from(timing: Timing) -> MsStages {
        MsStages {
            trace: ms(timing.trace),
            refine: ms(timing.refine),
            decide: ms(timing.decide),
            readback: ms(timing.readback),
        }
    }
}
