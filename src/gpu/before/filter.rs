//! The filter in f64 as a device runs it on rays that f32 left undecided, or on all: the numbers of the
//! objects that are tested one after the other, and what its shader has.
//!
//! It serves what f32 has room for. The rest, and what it leaves open, the CPU decides.

use glam::DVec3;

use super::seen_from::SeenFrom;
use crate::certify::K;
use crate::exact::{ExactRay, plane_numbers};
use crate::guard::{self, Guard, InputError};
use crate::kernel::certified::{
    LISTED_SPHERES, PlaneCertified, SphereCertified, k_in_range, offset_in_range,
};
use crate::kernel::{Kernel, Lists};
use crate::prepare::{Prepared, RayRecordDouble, Scaled};
use crate::rays::{Bundle, Ray};
use crate::scene::{Plane, Sphere};
use crate::vec3::dot3;

/// The numbers of a prepared scene for the filter in f64 on a device.
pub struct InF64 {
    /// The objects that are tested one after the other.
    pub lists: Lists<SphereCertified<f64>, PlaneCertified<f64>>,
    pub(super) frame: Frame,
}

/// The rays, and the point that the numbers are relative to.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) bundle: Bundle,
    reference: DVec3,
    /// Largest distance of an origin from there.
    farthest_origin: f64,
    pub(super) input: InputError,
}

/// Whether the filter in f64 on a device has a way to all objects of a scene.
pub fn suits_device(prepared: &Prepared) -> bool {
    prepared.kernel == Kernel::Certified
        && prepared.in_range
        && !prepared.has_tree_in_space()
        && prepared.n_listed_spheres() <= LISTED_SPHERES
        && prepared.scene.planes.len() <= LISTED_SPHERES
}

/// A ray of a list, which must be ordinary: its direction scaled as in [`crate::prepare::RayRecord`].
pub fn ray_record(ray: &Ray) -> RayRecordDouble {
    let direction = Scaled::new(ray.direction).rounded();
    RayRecordDouble {
        origin: ray.origin.to_array(),
        pad0: 0.0,
        direction: direction.to_array(),
        pad1: 0.0,
    }
}

impl InF64 {
    /// Of a scene that [`suits_device`].
    pub fn new(prepared: &Prepared) -> InF64 {
        let bundle = prepared.bundle();
        let frame = Frame {
            bundle,
            reference: prepared.reference,
            farthest_origin: prepared.farthest_origin(),
            input: guard::input_of_picture(bundle).unwrap_or(guard::LIST_F64),
        };
        let scene = &prepared.scene;
        let mut spheres: Vec<_> = match &prepared.hierarchy {
            None => scene.spheres.iter().map(|sphere| frame.sphere(sphere)).collect(),
            Some(hierarchy) => {
                let sphere = |&id: &u32| frame.sphere(&scene.spheres[id as usize - 1]);
                hierarchy.rest.iter().map(sphere).collect()
            }
        };
        spheres.resize(prepared.n_listed_spheres(), SphereCertified::never(bundle));
        InF64 {
            lists: Lists {
                spheres,
                planes: scene.planes.iter().map(|plane| frame.plane(plane)).collect(),
            },
            frame,
        }
    }

    /// What the spheres of a hierarchy are seen from.
    pub fn seen_from(&self) -> SeenFrom {
        let Frame { bundle, reference, farthest_origin, input } = self.frame;
        SeenFrom::new(reference, farthest_origin, bundle, input)
    }
}

impl Frame {
    /// A point in the coordinates of the rays: a list's are the world's, so that a difference is rounded
    /// once.
    fn place(&self, point: DVec3) -> [f64; 3] {
        match self.bundle {
            Bundle::Point | Bundle::Parallel => (point - self.reference).to_array(),
            Bundle::Free => point.to_array(),
        }
    }

    fn sphere(&self, sphere: &Sphere) -> SphereCertified<f64> {
        let &Frame { bundle, reference, farthest_origin, input } = self;
        let r = sphere.radius.abs();
        // Somewhere, where the difference to an origin is finite.
        let here = self.place(reference);
        if r == 0.0 {
            return SphereCertified { center: here, ..SphereCertified::never(bundle) };
        }
        let open = SphereCertified { center: here, ..SphereCertified::open(bundle) };
        let distance = guard::length_bound(sphere.center - reference) + farthest_origin;
        if !guard::sphere_in_range_f32(r, distance) {
            return open;
        }
        let Guard { inner2, outer2, slack, k_error } =
            Guard::new(r, distance, guard::UNIT_F64, input);
        let (q_low, q_high_or_r2) = match bundle {
            Bundle::Point => {
                let K { value, error } = K::new(reference, sphere);
                if !(value.abs() > error && k_in_range(value, r + distance)) {
                    return open;
                }
                let q = guard::widening_f64().inverse(value.abs(), error);
                (q.low.copysign(value), q.high.copysign(value))
            }
            Bundle::Parallel => (0.0, 0.0),
            Bundle::Free => (0.0, r * r),
        };
        let center = self.place(sphere.center);
        let center_low = [0.0; 3];
        SphereCertified { center, inner2, center_low, outer2, slack, q_low, q_high_or_r2, k_error }
    }

    /// Whether a plane goes through the reference point, which no ray from there then hits.
    fn starts_in(&self, plane: &Plane) -> bool {
        let ray = ExactRay::new(&Ray { origin: self.reference, direction: DVec3::X });
        let numbers = plane_numbers(&ray, plane.point, plane.normal);
        numbers.is_some_and(|numbers| numbers.numerator.signum() == 0)
    }

    fn plane(&self, plane: &Plane) -> PlaneCertified<f64> {
        let &Frame { bundle, reference, farthest_origin, input } = self;
        let here = self.place(reference);
        if plane.normal == DVec3::ZERO {
            return PlaneCertified { offset: here, ..PlaneCertified::never() };
        }
        let open = PlaneCertified { offset: here, ..PlaneCertified::open() };
        let normal = Scaled::new(plane.normal).rounded();
        let n_length = guard::length_bound(normal);
        let l = plane.point - reference;
        let distance = guard::length_bound(l) + farthest_origin;
        if !guard::plane_in_range_f32(distance) {
            return open;
        }
        let (unit, tiny) = (guard::UNIT_F64, guard::TINY_F64);
        let error = guard::plane_offset_error(n_length, distance, unit, input, tiny);
        let (mut away, mut q_low, mut q_high) = (normal, 0.0, 0.0);
        if bundle == Bundle::Point {
            let n_offset = dot3::<f64>(l.into(), normal.into());
            if n_offset.abs() > error && offset_in_range(n_offset) {
                let q = guard::widening_f64().inverse(n_offset.abs(), error);
                (q_low, q_high) = (q.low, q.high);
            } else if !self.starts_in(plane) {
                return open;
            }
            away = if n_offset < 0.0 { -normal } else { normal };
        }
        PlaneCertified {
            offset: self.place(plane.point),
            q_low,
            offset_low: [0.0; 3],
            q_high,
            normal: away.to_array(),
            direction_error: guard::plane_direction_error(n_length, unit, input),
            n_offset_error: error,
            padding: [0.0; 3],
        }
    }
}
