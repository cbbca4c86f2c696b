//! What `shaders/certified.wgsl` and `shaders/tree.wgsl` do: each ray alone, in f32.

use kugelblitz::bvh::{IS_LEAF, Leaves, MOST_BOXES};
use kugelblitz::gpu::slabs::{LEAST_SLACK, Slabs};
use kugelblitz::num::{OPEN, V3};
use kugelblitz::prepare::{InSpace, Prepared};
use kugelblitz::rays::{Frame, List, Rays};
use kugelblitz::seen::{Nearest, Objects, Ray};
use rayon::prelude::*;

/// The proposals of the kernel `certified` where each ray is looked at alone, by the formulas of a device: the
/// twin that a device's proposals are compared with. The CPU may leave other rays open, but never sees another object. `None`
/// where a device finds no way through a scene.
pub fn propose_alone(prepared: &Prepared, rays: &Rays) -> Option<Vec<u32>> {
    let hierarchy = prepared.hierarchy.as_ref();
    let in_space = prepared.in_space().expect("memory for the boxes of a tree");
    if in_space.is_none() && hierarchy.is_some() {
        return None;
    }
    let eye = prepared.eye();
    let listed = match hierarchy {
        None => Objects::new(prepared.seen_objects(), &eye),
        Some(hierarchy) => Objects::new(prepared.beside(&hierarchy.rest), &eye),
    };
    let look = |ray: Ray<f32>| {
        let mut nearest = listed.nearest(&ray);
        match (&in_space, hierarchy) {
            (Some(in_space), Some(hierarchy))
                if !look_in_tree(&ray, &mut nearest, in_space, &hierarchy.leaves) =>
            {
                OPEN
            }
            _ => nearest.decide().0,
        }
    };
    let all = (0..rays.len()).into_par_iter();
    Some(match rays {
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

/// Whether that comes to its end.
fn look_in_tree(
    ray: &Ray<f32>,
    nearest: &mut Nearest<f32>,
    in_space: &InSpace,
    leaves: &Leaves,
) -> bool {
    let InSpace { boxes, beside } = in_space;
    let slabs = Slabs::new(ray, LEAST_SLACK + beside);
    let mut at = 0;
    for _ in 0..MOST_BOXES {
        let Some(node) = boxes.get(at) else { break };
        let is_leaf = node.link & IS_LEAF != 0;
        let is_met = slabs.between(V3(node.low), V3(node.high)).is_within(nearest.high());
        at = if is_met || is_leaf { at + 1 } else { node.link as usize };
        if is_met && is_leaf {
            leaves.add(node.link & !IS_LEAF, ray, nearest);
        }
    }
    at == boxes.len()
}
