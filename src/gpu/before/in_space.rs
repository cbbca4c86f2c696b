//! Twin of `shaders/tree.wgsl`: a ray of a list that walks through the boxes of the tree alone, in f32.

use rayon::prelude::*;

use super::slabs::{SlabRoom, meets, slabs_of};
use crate::cpu::Listed;
use crate::error::{Error, Result};
use crate::guard;
use crate::kernel::RayOf;
use crate::kernel::arithmetic::Arithmetic;
use crate::kernel::certified::{Filter, FreeFilter, Nearest};
use crate::prepare::{InSpace, Prepared};
use crate::rays::Rays;
use crate::tree::IS_LEAF;
use crate::vec3::Vec3;

/// The proposals of the kernel `certified` in f32 for a list of rays into many spheres, as a device makes
/// them: the twin that they are compared with.
///
/// # Errors
/// [`Error::Usage`] for anything else.
pub fn propose_in_space(prepared: &Prepared, rays: &Rays) -> Result<Vec<u32>> {
    prepared.check(rays)?;
    let in_space = prepared.in_space()?;
    let (Rays::List(rays), Some(in_space), Some(hierarchy)) =
        (rays, &in_space, &prepared.hierarchy)
    else {
        return Err(Error::Usage("the scene has no tree in space for a device".into()));
    };
    let coordinates = prepared.coordinates();
    let (widening, others) = (guard::widening_f32(), Listed::new(prepared, hierarchy));
    let propose = |ray| {
        let (ray, _) = f32::list_ray(&coordinates, ray);
        let listed = others.nearest::<FreeFilter>(&ray, &widening);
        nearest_in_tree(&ray, listed, in_space).decide()
    };
    Ok(rays.par_iter().map(propose).collect())
}

fn nearest_in_tree(ray: &RayOf<f32>, listed: Nearest<f32>, in_space: &InSpace) -> Nearest<f32> {
    let InSpace { nodes, spheres } = in_space;
    let widening = guard::widening_f32();
    let room = SlabRoom::f32();
    let slabs = slabs_of(ray.origin, ray.direction, room.least_slack, &room);
    let mut nearest = listed;
    let mut t_max = guard::t_bound_f32(ray.a * nearest.low);
    let mut at = 0;
    while let Some(node) = nodes.get(at) {
        let is_leaf = node.link & IS_LEAF != 0;
        let is_met = meets(&slabs, Vec3(node.low), Vec3(node.high), t_max);
        at = if is_met || is_leaf { at + 1 } else { node.link as usize };
        if is_met && is_leaf {
            let sphere = &spheres[(node.link & !IS_LEAF) as usize];
            nearest = nearest.nearer(FreeFilter::sphere_nearness(ray, sphere, &widening), node.id);
            t_max = guard::t_bound_f32(ray.a * nearest.low);
        }
    }
    nearest
}
