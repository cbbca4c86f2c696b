//! A hierarchy over spheres on the device.

use super::device::OpenDevice;
use super::layout::Walk;
use super::texture::{TEXEL_BYTES, TEXELS_PER_ROW, texture};
use crate::error::{Error, Result};
use crate::kernel::certified::{SphereCertified, SphereFar};
use crate::prepare::{Hierarchy, InSpace, Prepared, Seen};
use crate::tree::flat::BoxNode;
use crate::tree::footprints::{Footprints, Node};

/// The buffers and textures that `shaders/hierarchy.wgsl` or `shaders/tree.wgsl` reads.
pub struct DeviceHierarchy {
    walk: wgpu::Buffer,
    rest_ids: Option<wgpu::Buffer>,
    nodes: wgpu::TextureView,
    spheres: (&'static str, wgpu::TextureView),
    n_nodes: u32,
    cell_shift: u32,
}

impl DeviceHierarchy {
    /// Hands the hierarchy of a prepared scene to the device; `None` where there is none, or none that a
    /// device can walk through.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more spheres than the device's textures hold, or than it has memory
    /// for.
    pub fn new(gpu: &OpenDevice, prepared: &Prepared) -> Result<Option<DeviceHierarchy>> {
        match &prepared.hierarchy {
            None => Ok(None),
            Some(hierarchy @ Hierarchy { seen: Some(seen), .. }) => {
                DeviceHierarchy::of_picture(gpu, hierarchy, seen).map(Some)
            }
            Some(hierarchy) => {
                let n_rest = hierarchy.n_places_of_rest();
                check_limits(gpu, hierarchy.tree.order.len(), SPHERE_TEXELS, n_rest)?;
                let Some(in_space) = prepared.in_space()? else { return Ok(None) };
                DeviceHierarchy::of_list(gpu, hierarchy, in_space).map(Some)
            }
        }
    }

    fn of_picture(gpu: &OpenDevice, hierarchy: &Hierarchy, seen: &Seen) -> Result<DeviceHierarchy> {
        let Seen { footprints, far } = seen;
        check_limits(gpu, far.len(), FAR_TEXELS, 0)?;
        let walk = uniform(gpu, "walk", &Walk::default());
        let mut rest = hierarchy.rest.clone();
        rest.resize(hierarchy.n_places_of_rest(), 0);
        let rest_ids =
            (!rest.is_empty()).then(|| gpu.storage("ids of the rest", bytemuck::cast_slice(&rest)));
        let Footprints { nodes, cell_shift } = footprints;
        let device_hierarchy = DeviceHierarchy {
            walk,
            rest_ids,
            nodes: texture(gpu, "nodes", bytemuck::cast_slice(nodes))?,
            spheres: ("far_spheres", texture(gpu, "far spheres", bytemuck::cast_slice(far))?),
            n_nodes: nodes.len() as u32,
            cell_shift: *cell_shift,
        };
        gpu.check()?;
        Ok(device_hierarchy)
    }

    /// The boxes, and behind them the ids of the rest, a texel each.
    fn of_list(
        gpu: &OpenDevice,
        hierarchy: &Hierarchy,
        in_space: InSpace,
    ) -> Result<DeviceHierarchy> {
        let InSpace { nodes, spheres } = in_space;
        let n_nodes = nodes.len() as u32;
        let mut texels: Vec<[u32; 4]> = bytemuck::cast_vec(nodes);
        let mut rest = hierarchy.rest.clone();
        rest.resize(hierarchy.n_places_of_rest(), 0);
        texels.extend(rest.into_iter().map(|id| [id, 0, 0, 0]));
        let spheres = texture(gpu, "spheres of the tree", bytemuck::cast_slice(&spheres))?;
        let device_hierarchy = DeviceHierarchy {
            walk: uniform(gpu, "walk", &Walk { n_nodes, ..Walk::default() }),
            rest_ids: None,
            nodes: texture(gpu, "boxes", bytemuck::cast_slice(&texels))?,
            spheres: ("tree_spheres", spheres),
            n_nodes,
            cell_shift: 0,
        };
        gpu.check()?;
        Ok(device_hierarchy)
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let texels = |view: &wgpu::TextureView| {
            u64::from(view.texture().width()) * u64::from(view.texture().height())
        };
        let rest = self.rest_ids.as_ref().map_or(0, wgpu::Buffer::size);
        let textures = (texels(&self.nodes) + texels(&self.spheres.1)) * TEXEL_BYTES as u64;
        textures + self.walk.size() + rest
    }

    /// What a shader that walks through it binds.
    pub fn resources(&self) -> impl Iterator<Item = (&'static str, wgpu::BindingResource<'_>)> {
        let walk = [("walk", self.walk.as_entire_binding())];
        let rest = self.rest_ids.iter().map(|ids| ("rest_ids", ids.as_entire_binding()));
        let (name, spheres) = &self.spheres;
        let textures = [("nodes", &self.nodes), (*name, spheres)]
            .map(|(name, view)| (name, wgpu::BindingResource::TextureView(view)));
        walk.into_iter().chain(rest).chain(textures)
    }

    /// Says which pixel of the picture the next tile starts at.
    pub fn start_at(&self, gpu: &OpenDevice, [first_x, first_y]: [u32; 2]) {
        let &DeviceHierarchy { n_nodes, cell_shift, .. } = self;
        let walk = Walk { n_nodes, first_x, first_y, cell_shift };
        gpu.queue.write_buffer(&self.walk, 0, bytemuck::bytes_of(&walk));
    }
}

/// A buffer that all invocations read.
pub(super) fn uniform(
    gpu: &OpenDevice,
    label: &str,
    value: &impl bytemuck::NoUninit,
) -> wgpu::Buffer {
    let bytes = bytemuck::bytes_of(value);
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let buffer = gpu.buffer(label, bytes.len(), usage);
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// Texels of a sphere of a picture's hierarchy, and of one of a list's.
const FAR_TEXELS: usize = size_of::<SphereFar>() / TEXEL_BYTES;
const SPHERE_TEXELS: usize = size_of::<SphereCertified>() / TEXEL_BYTES;

/// Refuses more spheres, of so many texels each, than a texture holds, or nodes with `n_more` texels
/// behind them.
fn check_limits(
    gpu: &OpenDevice,
    n_spheres: usize,
    sphere_texels: usize,
    n_more: usize,
) -> Result<()> {
    // A tree with one sphere in each leaf has fewer than two nodes a sphere.
    const NODE_TEXELS: [usize; 2] =
        [2 * size_of::<Node>() / TEXEL_BYTES, 2 * size_of::<BoxNode>() / TEXEL_BYTES];
    let texels_per_sphere =
        sphere_texels.max(NODE_TEXELS[usize::from(sphere_texels != FAR_TEXELS)]);
    let texels = TEXELS_PER_ROW as usize * gpu.facts.max_texture_side as usize;
    let most = texels.saturating_sub(n_more) / texels_per_sphere;
    if n_spheres > most {
        return Err(Error::TooLarge(format!(
            "the hierarchy has {n_spheres} spheres; `{}` takes at most {most}, in a texture of \
             {} MiB: use fewer spheres, or `--device cpu`",
            gpu.facts.name,
            (texels * TEXEL_BYTES) >> 20
        )));
    }
    Ok(())
}
