//! The objects outside a hierarchy, which every ray looks at.

use crate::kernel::certified::{
    Filter, Nearest, PlaneCertified, SphereCertified, Widening, nearest_listed,
};
use crate::kernel::{Lists, RayOf};
use crate::prepare::{Hierarchy, Objects, Prepared};

/// Planes, and the spheres of [`Hierarchy::rest`].
#[derive(Clone, Copy)]
pub(crate) struct Listed<'a> {
    spheres: &'a [SphereCertified],
    planes: &'a [PlaneCertified],
    /// The spheres' ids.
    ids: &'a [u32],
    /// Those in the scene.
    n_spheres: u32,
}

impl<'a> Listed<'a> {
    /// Those of a scene.
    pub fn new(prepared: &'a Prepared, hierarchy: &'a Hierarchy) -> Listed<'a> {
        let Objects::Certified(lists) = &prepared.objects else {
            return Listed { spheres: &[], planes: &[], ids: &[], n_spheres: 0 };
        };
        Listed::of(lists, prepared, hierarchy)
    }

    /// Those of a scene with other numbers.
    pub fn of(
        lists: &'a Lists<SphereCertified, PlaneCertified>,
        prepared: &Prepared,
        hierarchy: &'a Hierarchy,
    ) -> Listed<'a> {
        let ids = &hierarchy.rest[..];
        // What follows them is no sphere.
        let spheres = &lists.spheres[..ids.len()];
        let n_spheres = prepared.scene.spheres.len() as u32;
        Listed { spheres, planes: &lists.planes, ids, n_spheres }
    }

    /// True where there are none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty() && self.planes.is_empty()
    }

    /// The nearest of them.
    #[inline(always)]
    pub fn nearest<F: Filter>(&self, ray: &RayOf<f32>, widening: &Widening<f32>) -> Nearest<f32> {
        let &Listed { spheres, planes, ids, n_spheres } = self;
        let sphere_id = |index: u32| ids[index as usize];
        nearest_listed::<f32, F>(ray, spheres, planes, n_spheres, sphere_id, widening)
    }
}
