//! A tree over spheres on the device.

use super::layout::{Layout, Traversal};
use super::open::Gpu;
use super::pipeline::{Named, Resource};
use super::slabs::LEAST_SLACK;
use super::texture::{TEXEL_BYTES, TEXELS_PER_ROW, texture};
use crate::bvh::FlatBox;
use crate::error::{Error, Hint, Message, Result, Setting};
use crate::kernel::FloatType;
use crate::prepare::{DeviceBvh, Prepared};

/// The buffer and the textures that `shaders/tree.wgsl` reads.
pub type DeviceHierarchy = [Named; 3];

/// Hands the tree of a prepared scene to the device; `None` where there is none, or none that a
/// device can walk through.
///
/// # Errors
/// [`Error::TooLarge`] for more spheres than the device's textures hold, or than it has memory
/// for.
pub fn upload_hierarchy(gpu: &Gpu, prepared: &Prepared) -> Result<Option<DeviceHierarchy>> {
    let Some(hierarchy) = &prepared.hierarchy else { return Ok(None) };
    let mut rest = hierarchy.leaves.rest.clone();
    rest.resize(hierarchy.n_places_of_rest(), 0);
    check_limits(gpu, hierarchy.bvh.spheres.len(), rest.len())?;
    let Some(DeviceBvh { boxes, beside }) = prepared.in_space()? else { return Ok(None) };
    let n_boxes = boxes.len() as u32;
    let beside = f64::from(LEAST_SLACK + beside);
    // Behind the boxes the ids of the spheres beside the tree, a texel each.
    let mut texels: Vec<[u32; 4]> = bytemuck::cast_vec(boxes);
    texels.extend(rest.into_iter().map(|id| [id, 0, 0, 0]));
    let leaves = hierarchy.leaves.words();
    let walk = Traversal { n_boxes, beside }.bytes(FloatType::F32);
    let list = |name, bytes| texture(gpu, name, bytes).map(Resource::Texture);
    let bound = [
        ("walk", gpu.filled("walk", &walk).into()),
        ("boxes", list("boxes", bytemuck::cast_slice(&texels))?),
        ("leaves", list("leaves", bytemuck::cast_slice(&leaves))?),
    ];
    gpu.check()?;
    Ok(Some(bound))
}

/// Most texels that boxes, or leaves, take for each sphere: where nodes have ten boxes these have four above them, and with
/// the levels above there are less than half as many boxes more as there are spheres.
const TEXELS_PER_SPHERE: usize = 3 * size_of::<FlatBox>() / 2 / TEXEL_BYTES;

/// Refuses more spheres than a texture holds, or boxes with `n_more` texels behind them.
fn check_limits(gpu: &Gpu, n_spheres: usize, n_more: usize) -> Result<()> {
    let texels = TEXELS_PER_ROW as usize * gpu.facts.max_texture_side as usize;
    let most = texels.saturating_sub(n_more) / TEXELS_PER_SPHERE;
    if n_spheres > most {
        let text = format!(
            "the hierarchy has {n_spheres} spheres; `{}` takes at most {most}, in a texture of {} MiB",
            gpu.facts.name,
            (texels * TEXEL_BYTES) >> 20
        );
        let hint = Hint::new("use fewer spheres, or {}", [Setting::text("device", "cpu")]);
        return Err(Error::TooLarge(Message::new(text, hint)));
    }
    Ok(())
}
