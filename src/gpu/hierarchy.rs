//! A hierarchy over spheres on the device.

use super::device::OpenDevice;
use super::layout::{SeenFrom, Walk};
use super::texture::{TEXEL_BYTES, TEXELS_PER_ROW, texture};
use crate::error::{Error, Result};
use crate::kernel::certified::SphereFar;
use crate::prepare::{Hierarchy, Prepared, Seen};
use crate::tree::footprints::{Footprints, Node};

/// The buffers and textures that `shaders/hierarchy.wgsl` reads. A clone shares them.
#[derive(Clone)]
pub struct DeviceHierarchy {
    walk: wgpu::Buffer,
    rest_ids: Option<wgpu::Buffer>,
    nodes: wgpu::TextureView,
    far: wgpu::TextureView,
    n_nodes: u32,
    cell_shift: u32,
    /// In f64: what spheres are seen from, and the spheres of the scene.
    in_f64: Option<[wgpu::Buffer; 2]>,
}

impl DeviceHierarchy {
    /// Hands a hierarchy to the device; `None` for one that is not searched by pixel.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more spheres than the device's textures hold, or than it has memory
    /// for.
    pub fn new(gpu: &OpenDevice, hierarchy: &Hierarchy) -> Result<Option<DeviceHierarchy>> {
        let Some(Seen { footprints, far }) = &hierarchy.seen else { return Ok(None) };
        check_limits(gpu, far.len())?;
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
            far: texture(gpu, "far spheres", bytemuck::cast_slice(far))?,
            n_nodes: nodes.len() as u32,
            cell_shift: *cell_shift,
            in_f64: None,
        };
        gpu.check()?;
        Ok(Some(device_hierarchy))
    }

    /// The same with what f64 needs, for a walk of its own.
    pub fn in_f64(&self, gpu: &OpenDevice, prepared: &Prepared) -> DeviceHierarchy {
        let walk = uniform(gpu, "walk", &Walk::default());
        DeviceHierarchy { walk, in_f64: Some(of_scene(gpu, prepared)), ..self.clone() }
    }

    /// The ids of the spheres that are not in the hierarchy.
    pub fn rest_ids(&self) -> Option<&wgpu::Buffer> {
        self.rest_ids.as_ref()
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let texels = |view: &wgpu::TextureView| {
            u64::from(view.texture().width()) * u64::from(view.texture().height())
        };
        let rest = self.rest_ids.as_ref().map_or(0, wgpu::Buffer::size);
        let textures = (texels(&self.nodes) + texels(&self.far)) * TEXEL_BYTES as u64;
        textures + self.walk.size() + rest
    }

    /// In the order of the shader's bindings.
    pub fn resources(&self) -> impl Iterator<Item = wgpu::BindingResource<'_>> {
        let buffers = [Some(&self.walk), self.rest_ids.as_ref()].into_iter().flatten();
        let textures = [&self.nodes, &self.far].map(wgpu::BindingResource::TextureView);
        let in_f64 = self.in_f64.iter().flatten().map(wgpu::Buffer::as_entire_binding);
        buffers.map(wgpu::Buffer::as_entire_binding).chain(textures).chain(in_f64)
    }

    /// Says which pixel of the picture the next tile starts at.
    pub fn start_at(&self, gpu: &OpenDevice, [first_x, first_y]: [u32; 2]) {
        let &DeviceHierarchy { n_nodes, cell_shift, .. } = self;
        let walk = Walk { n_nodes, first_x, first_y, cell_shift };
        gpu.queue.write_buffer(&self.walk, 0, bytemuck::bytes_of(&walk));
    }
}

/// The spheres of a scene as it has them, behind what they are seen from.
pub fn of_scene(gpu: &OpenDevice, prepared: &Prepared) -> [wgpu::Buffer; 2] {
    let seen_from =
        SeenFrom { reference: prepared.reference.to_array(), spread: prepared.farthest_origin() };
    let spheres = bytemuck::cast_slice(&prepared.scene.spheres[..]);
    [uniform(gpu, "seen from", &seen_from), gpu.storage("spheres of the scene", spheres)]
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

fn check_limits(gpu: &OpenDevice, n_spheres: usize) -> Result<()> {
    // A tree with one sphere in each leaf has fewer than two nodes a sphere.
    const TEXELS_PER_SPHERE: usize = size_of::<SphereFar>() / TEXEL_BYTES;
    const _: () = assert!(TEXELS_PER_SPHERE >= 2 * size_of::<Node>() / TEXEL_BYTES);
    let texels = TEXELS_PER_ROW as usize * gpu.facts.max_texture_side as usize;
    let most = texels / TEXELS_PER_SPHERE;
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
