//! The list of all kernels, and the only one.

use glam::DVec3;

use super::about::{About, Part, part};
use super::certified::{self, PlaneCertified, SphereCertified};
use super::double::{self, PlaneDouble, SphereDouble};
use super::lecture::{self, PlaneLecture, SphereLecture};
use super::stable::{self, PlaneStable, SphereStable};
use super::twin::WithTwin;
use super::{Lists, relative};
use crate::rays::Bundle;
use crate::scene::Scene;

/// The intersection kernels (contract §2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kernel {
    /// The lecture's formulas, corrected, in f32 on world coordinates.
    Lecture,
    /// The best plain-f32 kernel: camera-relative, free of cancellation.
    Stable,
    /// The same formulas in f64: what one would do without a proof.
    Double,
    /// f32 with a proven error bound, then f64, then exact arithmetic.
    Certified,
}

/// The parts of all kernels' shaders: rays, vectors, and the camera where there is one.
pub const SHARED_PARTS: [Part; 3] = [
    part!("ray.wgsl", "src/kernel/mod.rs"),
    part!("vec.wgsl", "src/vec3.rs"),
    part!("camera.wgsl", "src/rays/camera.rs"),
];

/// The objects in the form of one kernel, in id order.
#[derive(Clone, Debug)]
pub enum Objects {
    /// For [`Kernel::Lecture`].
    Lecture(Lists<SphereLecture, PlaneLecture>),
    /// For [`Kernel::Stable`].
    Stable(Lists<SphereStable, PlaneStable>),
    /// For [`Kernel::Double`].
    Double(Lists<SphereDouble, PlaneDouble>),
    /// For [`Kernel::Certified`].
    Certified(Lists<SphereCertified, PlaneCertified>),
}

impl Kernel {
    /// All of them, in the order in which they are told: from the least exact to the exact one.
    pub const ALL: [Kernel; 4] =
        [Kernel::Lecture, Kernel::Stable, Kernel::Double, Kernel::Certified];

    /// Its facts.
    pub fn about(self) -> &'static About {
        match self {
            Kernel::Lecture => &lecture::ABOUT,
            Kernel::Stable => &stable::ABOUT,
            Kernel::Double => &double::ABOUT,
            Kernel::Certified => &certified::ABOUT,
        }
    }

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// All objects of a scene, relative to `reference` where the kernel's coordinates are; none yet for the one with a proof.
    pub fn objects(self, scene: &Scene, reference: DVec3) -> Objects {
        match self {
            Kernel::Lecture => Objects::Lecture(lecture::objects(scene)),
            Kernel::Stable => Objects::Stable(stable::objects(scene, reference)),
            Kernel::Double => Objects::Double(double::objects(scene, reference)),
            Kernel::Certified => {
                Objects::Certified(Lists { spheres: Vec::new(), planes: Vec::new() })
            }
        }
    }
}

impl Objects {
    /// The device's bytes of the spheres and of the planes.
    pub fn bytes(&self) -> (&[u8], &[u8]) {
        match self {
            Objects::Lecture(lists) => lists.bytes(),
            Objects::Stable(lists) => lists.bytes(),
            Objects::Double(lists) => lists.bytes(),
            Objects::Certified(lists) => lists.bytes(),
        }
    }

    /// Does `work` with the twin of a kernel without a proof; `None` for the one with it.
    pub(crate) fn with_twin<W: WithTwin>(&self, bundle: Bundle, work: W) -> Option<W::Output> {
        match self {
            Objects::Lecture(lists) => Some(lecture::with_twin(lists, work)),
            Objects::Stable(lists) => Some(relative::with_twin(lists, bundle, work)),
            Objects::Double(lists) => Some(relative::with_twin(lists, bundle, work)),
            Objects::Certified(_) => None,
        }
    }
}
