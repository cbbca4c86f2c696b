//! The filter with a list of objects: it gives ids, or "undecided".

use std::marker::PhantomData;

use super::filter::{Filter, FreeFilter, ParallelFilter, PointFilter, Widening, nearest_listed};
use super::records::{PlaneCertified, SphereCertified};
use crate::guard;
use crate::kernel::twin::{Twin, WithTwin};
use crate::kernel::{Hit, Lists, RayOf};
use crate::rays::Bundle;
use crate::vec3::Vec3;

struct Certified<'a, F> {
    objects: &'a Lists<SphereCertified, PlaneCertified>,
    widening: Widening<f32>,
    filter: PhantomData<F>,
}

impl<F: Filter> Certified<'_, F> {
    #[inline(always)]
    fn closest_by<G: Filter>(&self, ray: &RayOf<f32>) -> Hit<f32> {
        let Lists { spheres, planes } = self.objects;
        let n_spheres = spheres.len() as u32;
        let sphere_id = |index: u32| index + 1;
        let nearest =
            nearest_listed::<f32, G>(ray, spheres, planes, n_spheres, sphere_id, &self.widening);
        Hit { id: nearest.decide(), ..Hit::MISS }
    }
}

impl<F: Filter> Twin for Certified<'_, F> {
    type Float = f32;
    const GIVES_SURFACE: bool = false;
    const IS_PROVEN: bool = true;
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        self.closest_by::<F>(ray)
    }

    fn closest_from_anywhere(&self, ray: &RayOf<f32>) -> Hit<f32> {
        self.closest_by::<FreeFilter>(ray)
    }

    #[inline(always)]
    fn normal_at(&self, _: &RayOf<f32>, _: Hit<f32>) -> Vec3<f32> {
        Vec3::ZERO
    }
}

/// Does `work` with these objects.
pub fn with_twin<W: WithTwin>(
    lists: &Lists<SphereCertified, PlaneCertified>,
    bundle: Bundle,
    work: W,
) -> W::Output {
    match bundle {
        Bundle::Point => with::<PointFilter, W>(lists, work),
        Bundle::Parallel => with::<ParallelFilter, W>(lists, work),
        Bundle::Free => with::<FreeFilter, W>(lists, work),
    }
}

fn with<F: Filter, W: WithTwin>(
    objects: &Lists<SphereCertified, PlaneCertified>,
    work: W,
) -> W::Output {
    let widening = guard::widening_f32();
    work.with(&Certified::<F> { objects, widening, filter: PhantomData })
}
