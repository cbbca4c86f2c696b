//! Twin of `shaders/certified.wgsl` and `shaders/tree.wgsl`: each ray alone, in f32.

use rayon::prelude::*;

use super::slabs::{SlabRoom, meets, slabs_of};
use crate::bvh::{IS_LEAF, Leaves};
use crate::engine::List;
use crate::error::{Error, Result};
use crate::num::V3;
use crate::prepare::{InSpace, Prepared};
use crate::rays::{Frame, Rays};
use crate::seen::{Nearest, Objects, Ray};
use crate::trace::Kernel;

/// The proposals of the kernel `certified` where each ray is looked at alone, by the formulas of a device: the
/// twin that a device's proposals are compared with. [`Tracer::propose`](crate::tracer::Tracer::propose) on the CPU may leave
/// other rays open, but never sees another object.
///
/// # Errors
/// [`Error::Usage`] for another kernel's scene, and for one that a device finds no way through.
pub fn propose_alone(prepared: &Prepared, rays: &Rays) -> Result<Vec<u32>> {
    prepared.check(rays)?;
    let hierarchy = prepared.hierarchy.as_ref();
    let in_space = prepared.in_space()?;
    if prepared.kernel != Kernel::Certified || in_space.is_none() && hierarchy.is_some() {
        return Err(Error::Usage("no device proposes anything for this scene".into()));
    }
    let eye = prepared.eye();
    let listed = match hierarchy {
        None => Objects::new(prepared.seen_objects(), &eye),
        Some(hierarchy) => Objects::new(prepared.beside(&hierarchy.rest), &eye),
    };
    let look = |ray: Ray<f32>| {
        let mut nearest = listed.nearest(&ray);
        if let (Some(in_space), Some(hierarchy)) = (&in_space, hierarchy) {
            look_in_tree(&ray, &mut nearest, in_space, &hierarchy.leaves);
        }
        nearest.decide().0
    };
    let all = (0..rays.len()).into_par_iter();
    Ok(match rays {
        Rays::Pixels(pixels) => {
            let camera = Frame::of_pixels(pixels);
            let ray = |index| {
                let (x, y) = pixels.xy(index);
                let (i, j) = pixels.offset2(x, y);
                camera.ray(i as f32, j as f32)
            };
            all.map(|index| look(ray(index))).collect()
        }
        Rays::List(rays) => {
            let list = List::new(rays, prepared.reference);
            all.map(|index| look(list.one(index))).collect()
        }
    })
}

fn look_in_tree(ray: &Ray<f32>, nearest: &mut Nearest<f32>, in_space: &InSpace, leaves: &Leaves) {
    let InSpace { boxes, beside } = in_space;
    let room = SlabRoom::f32();
    let slabs = slabs_of(ray.origin, ray.direction, room.least_slack + beside, &room);
    let mut at = 0;
    while let Some(node) = boxes.get(at) {
        let is_leaf = node.link & IS_LEAF != 0;
        let is_met = meets(&slabs, V3(node.low), V3(node.high), nearest.high());
        at = if is_met || is_leaf { at + 1 } else { node.link as usize };
        if is_met && is_leaf {
            leaves.add(node.link & !IS_LEAF, ray, nearest);
        }
    }
}
