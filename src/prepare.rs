//! Scene → [`Prepared`]: the plain numbers that every backend traces, the same for all of them.

use std::sync::Arc;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::kernel::lecture::{PlaneLecture, SphereLecture};
use crate::kernel::stable::{PlaneStable, SphereStable};
use crate::scene::Scene;
use crate::trace::{Kernel, Ray, Rays};

/// Where the rays come from; each source has its own shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// Pixels of a camera: all rays start at the reference point.
    Pixels,
    /// A list of rays with any origins.
    List,
}

/// What a scene asks of a backend. What is not needed is in no shader and in no binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Needs {
    /// The kernel.
    pub kernel: Kernel,
    /// Where the rays come from.
    pub source: Source,
    /// Number of spheres.
    pub n_spheres: usize,
    /// Number of planes.
    pub n_planes: usize,
    /// Whether `t` and normals are wanted.
    pub surface: bool,
}

/// The objects in the form of one kernel, in id order.
#[derive(Clone, Debug)]
pub enum Objects {
    /// For [`Kernel::Lecture`].
    Lecture {
        /// Spheres.
        spheres: Vec<SphereLecture>,
        /// Planes.
        planes: Vec<PlaneLecture>,
    },
    /// For [`Kernel::Stable`].
    Stable {
        /// Spheres.
        spheres: Vec<SphereStable>,
        /// Planes.
        planes: Vec<PlaneStable>,
    },
}

impl Objects {
    /// The device's bytes of the spheres and of the planes.
    pub fn bytes(&self) -> (&[u8], &[u8]) {
        match self {
            Objects::Lecture { spheres, planes } => {
                (bytemuck::cast_slice(spheres), bytemuck::cast_slice(planes))
            }
            Objects::Stable { spheres, planes } => {
                (bytemuck::cast_slice(spheres), bytemuck::cast_slice(planes))
            }
        }
    }
}

/// A scene ready to be traced by one kernel from one source of rays.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The scene that this was made from.
    pub scene: Arc<Scene>,
    /// The kernel.
    pub kernel: Kernel,
    /// Where the rays come from.
    pub source: Source,
    /// What coordinates are relative to, world units: the eye, or the middle of the origins.
    pub reference: DVec3,
    /// The objects.
    pub objects: Objects,
}

impl Prepared {
    /// Prepares `scene` for `rays`. All later rays must come from the same camera position or,
    /// for lists, from within the box of these origins.
    ///
    /// # Errors
    /// [`Error::Usage`] for an empty list of rays.
    pub fn new(scene: Arc<Scene>, kernel: Kernel, rays: &Rays) -> Result<Prepared> {
        let (source, reference) = match rays {
            Rays::Pixels(pixels) => (Source::Pixels, pixels.view.position),
            Rays::List(rays) => (Source::List, middle_of_origins(rays)?),
        };
        let objects = match kernel {
            Kernel::Lecture => lecture_objects(&scene),
            Kernel::Stable | Kernel::Certified => stable_objects(&scene, reference),
        };
        Ok(Prepared { scene, kernel, source, reference, objects })
    }

    /// What a backend must be able to do for this scene.
    pub fn needs(&self, surface: bool) -> Needs {
        Needs {
            kernel: self.kernel,
            source: self.source,
            n_spheres: self.scene.spheres.len(),
            n_planes: self.scene.planes.len(),
            surface,
        }
    }
}

fn middle_of_origins(rays: &[Ray]) -> Result<DVec3> {
    let first = rays.first().ok_or_else(|| Error::Usage("there are no rays to trace".into()))?;
    let (low, high) = rays.iter().fold((first.origin, first.origin), |(low, high), ray| {
        (low.min(ray.origin), high.max(ray.origin))
    });
    Ok(low / 2.0 + high / 2.0)
}

/// `v` as f32 high part and f32 low part: together 48 bits.
pub fn split(v: DVec3) -> ([f32; 3], [f32; 3]) {
    let high = v.as_vec3();
    let low = (v - high.as_dvec3()).as_vec3();
    (high.to_array(), low.to_array())
}

/// The binary exponent of the largest component of `v`; 0 for the zero vector.
pub fn exponent_of(v: DVec3) -> i32 {
    let largest = v.abs().max_element();
    if largest == 0.0 || !largest.is_finite() {
        return 0;
    }
    let biased = ((largest.to_bits() >> 52) & 0x7ff) as i32;
    if biased == 0 { -1023 } else { biased - 1023 }
}

/// `v · 2^exponent`, exact unless the result leaves f64's normal range.
pub fn scale_by_power_of_two(v: DVec3, exponent: i32) -> DVec3 {
    let half = exponent / 2;
    v * 2f64.powi(half) * 2f64.powi(exponent - half)
}

fn lecture_objects(scene: &Scene) -> Objects {
    Objects::Lecture {
        spheres: scene
            .spheres
            .iter()
            .map(|s| SphereLecture {
                center: s.center.as_vec3().to_array(),
                radius: s.radius as f32,
            })
            .collect(),
        planes: scene
            .planes
            .iter()
            .map(|p| PlaneLecture {
                point: p.point.as_vec3().to_array(),
                pad0: 0.0,
                normal: p.normal.as_vec3().to_array(),
                pad1: 0.0,
            })
            .collect(),
    }
}

fn stable_objects(scene: &Scene, reference: DVec3) -> Objects {
    Objects::Stable {
        spheres: scene
            .spheres
            .iter()
            .map(|s| {
                let l = s.center - reference;
                let (center, center_low) = split(l);
                let k = l.length_squared() - s.radius * s.radius;
                SphereStable { center, radius: s.radius as f32, center_low, k: k as f32 }
            })
            .collect(),
        planes: scene
            .planes
            .iter()
            .map(|p| {
                let l = p.point - reference;
                let normal = scale_by_power_of_two(p.normal, -exponent_of(p.normal));
                let (offset, offset_low) = split(l);
                PlaneStable {
                    offset,
                    n_offset: l.dot(normal) as f32,
                    offset_low,
                    pad0: 0.0,
                    normal: normal.as_vec3().to_array(),
                    pad1: 0.0,
                }
            })
            .collect(),
    }
}

/// A ray of a list as the device sees it.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct RayRecord {
    /// Origin: world units for `lecture`, else the high part relative to the reference point.
    pub origin: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad0: f32,
    /// Low part of the origin.
    pub origin_low: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad1: f32,
    /// Direction; scaled by a power of two to a largest component in `1..2`, but not for `lecture`.
    pub direction: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad2: f32,
}

impl Prepared {
    /// A ray of a list in this scene's frame, and the exponent `e` with
    /// `direction = 2^e · record.direction`, so that `t = 2^−e · t_record`.
    pub fn ray_record(&self, ray: &Ray) -> (RayRecord, i32) {
        let (origin, low, direction, exponent) = match self.kernel {
            Kernel::Lecture => (ray.origin.as_vec3().to_array(), [0.0; 3], ray.direction, 0),
            Kernel::Stable | Kernel::Certified => {
                let (high, low) = split(ray.origin - self.reference);
                let exponent = exponent_of(ray.direction);
                (high, low, scale_by_power_of_two(ray.direction, -exponent), exponent)
            }
        };
        let record = RayRecord {
            origin,
            pad0: 0.0,
            origin_low: low,
            pad1: 0.0,
            direction: direction.as_vec3().to_array(),
            pad2: 0.0,
        };
        (record, exponent)
    }
}
