//! The intersection kernels: `lecture`, `relative` (the kernels `stable` and `double`) and `certified` have the facts, the records
//! of the objects and, but for the last one, the formulas, each with a file in `shaders/`. Those of `certified` are
//! [`crate::shape`]'s. [`Kernel`] lists them all; [`baseline`] goes through the objects of those without a proof.

pub mod baseline;
pub mod certified;
pub mod coordinates;
mod info;
pub mod lecture;
pub mod relative;

use glam::DVec3;

use crate::scene::{Plane, Scene, Sphere};
use certified::{PlaneWords, SphereWords};
use lecture::{PlaneLecture, SphereLecture};
use relative::{PlaneDouble, PlaneStable, SphereDouble, SphereStable};

pub use baseline::Lists;
pub(crate) use info::part;
pub use info::{Exactness, FloatType, KernelInfo, Promise, ShaderPart, Space};

/// The intersection kernels (contract §2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kernel {
    /// The lecture's formulas, corrected, in f32 on world coordinates.
    Lecture,
    /// The best plain-f32 kernel: camera-relative, free of cancellation.
    Stable,
    /// The formulas of [`Kernel::Stable`] in f64: what one would do without a proof.
    Double,
    /// f32 with a proven error bound, then f64, then exact arithmetic.
    Certified,
}

/// The parts of all kernels' shaders: vectors, and the camera.
pub const SHARED_PARTS: [ShaderPart; 3] =
    [part!("vec.wgsl"), part!("printed/camera.wgsl"), part!("camera.wgsl")];

/// The objects in the form of one kernel, in id order.
#[derive(Clone, Debug)]
pub enum ObjectRecords {
    /// For [`Kernel::Lecture`].
    Lecture(Lists<SphereLecture, PlaneLecture>),
    /// For [`Kernel::Stable`].
    Stable(Lists<SphereStable, PlaneStable>),
    /// For [`Kernel::Double`].
    Double(Lists<SphereDouble, PlaneDouble>),
    /// For [`Kernel::Certified`].
    Certified {
        /// The records.
        lists: Lists<SphereWords, PlaneWords>,
        /// Whether one [is close](crate::shape::ShapeRecord::is_close).
        any_close: bool,
    },
}

impl Kernel {
    /// All of them, in the order in which they are told: from the least exact to the exact one.
    pub const ALL: [Kernel; 4] =
        [Kernel::Lecture, Kernel::Stable, Kernel::Double, Kernel::Certified];

    /// The kernel's facts.
    pub fn about(self) -> &'static KernelInfo {
        match self {
            Kernel::Lecture => &lecture::INFO,
            Kernel::Stable => &relative::STABLE,
            Kernel::Double => &relative::DOUBLE,
            Kernel::Certified => &certified::INFO,
        }
    }

    /// The name on the command line and in reports.
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// All objects of a scene, relative to `reference` where the kernel's coordinates are; none yet for the one with a proof.
    pub fn objects(self, scene: &Scene, reference: DVec3) -> ObjectRecords {
        match self {
            Kernel::Lecture => {
                ObjectRecords::Lecture(lists(scene, SphereLecture::new, PlaneLecture::new))
            }
            Kernel::Stable => ObjectRecords::Stable(lists(
                scene,
                |sphere| SphereStable::new(sphere, reference),
                |plane| PlaneStable::new(plane, reference),
            )),
            Kernel::Double => ObjectRecords::Double(lists(
                scene,
                |sphere| SphereDouble::new(sphere, reference),
                |plane| PlaneDouble::new(plane, reference),
            )),
            Kernel::Certified => {
                let lists = Lists { spheres: Vec::new(), planes: Vec::new() };
                ObjectRecords::Certified { lists, any_close: false }
            }
        }
    }
}

impl ObjectRecords {
    /// The device's bytes of the spheres and of the planes.
    pub fn bytes(&self) -> (&[u8], &[u8]) {
        match self {
            ObjectRecords::Lecture(lists) => lists.bytes(),
            ObjectRecords::Stable(lists) => lists.bytes(),
            ObjectRecords::Double(lists) => lists.bytes(),
            ObjectRecords::Certified { lists, .. } => lists.bytes(),
        }
    }
}

fn lists<S, P>(
    scene: &Scene,
    sphere: impl Fn(&Sphere) -> S,
    plane: impl Fn(&Plane) -> P,
) -> Lists<S, P> {
    Lists {
        spheres: scene.spheres.iter().map(sphere).collect(),
        planes: scene.planes.iter().map(plane).collect(),
    }
}
