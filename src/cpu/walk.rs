//! Twin of `shaders/hierarchy.wgsl`: a ray that walks through a hierarchy alone.

use super::tile::{Leaf, TileRays};
use crate::guard;
use crate::kernel::RayOf;
use crate::kernel::certified::{Nearest, Widening};
use crate::prepare::Seen;

/// The nearest of `listed` and the spheres of the hierarchy, for a ray of this pixel.
pub(super) fn nearest_far<T: TileRays>(
    ray: &RayOf<f32>,
    pixel: [u32; 2],
    listed: Nearest<f32>,
    seen: &Seen,
    widening: &Widening<f32>,
) -> Nearest<f32> {
    let mut nearest = listed;
    let Seen { footprints, far } = seen;
    let t_max = guard::t_bound_f32(ray.a * nearest.low);
    footprints.visit(footprints.cells(pixel, pixel), t_max, |_, place| {
        let sphere = &far[place];
        nearest = nearest.nearer(T::leaf(ray, &Leaf::of_rays(sphere), widening), sphere.id);
        guard::t_bound_f32(ray.a * nearest.low)
    });
    nearest
}
