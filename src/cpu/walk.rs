//! Twin of `shaders/hierarchy.wgsl`: a ray that walks through a hierarchy alone.

use crate::bvh::footprints::{Cells, Footprints};
use crate::guard;
use crate::kernel::RayOf;
use crate::kernel::certified::{Nearest, Nearness, SphereFar, Widening, far_nearness};
use crate::vec3::Vec3;

/// The nearest of `listed` and the spheres of the hierarchy.
pub fn nearest_far(
    ray: &RayOf<f32>,
    cell: Cells,
    listed: Nearest<f32>,
    footprints: &Footprints,
    far: &[SphereFar],
    widening: &Widening<f32>,
) -> Nearest<f32> {
    let mut nearest = listed;
    let t_max = guard::t_bound_f32(ray.a * nearest.low);
    footprints.visit(cell, t_max, |_, place| {
        let SphereFar { center, inner2, outer2, q, id, .. } = far[place];
        let root = far_nearness(ray, Vec3(center), inner2, outer2, q);
        let low = root.low * widening.far_narrower;
        nearest = nearest.nearer(Nearness { low, high: root.high }, id);
        guard::t_bound_f32(ray.a * nearest.low)
    });
    nearest
}
