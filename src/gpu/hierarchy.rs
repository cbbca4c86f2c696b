//! A hierarchy over spheres on the device.

use std::time::Duration;

use super::adapter::Gpu;
use super::layout::Walk;
use super::tracer::storage;
use crate::bvh::footprints::{Footprints, Node};
use crate::error::{Error, Result};
use crate::kernel::certified::SphereFar;
use crate::prepare::{Hierarchy, Search};

/// Texels of a row of the textures that hold lists, a power of two; each Vulkan device has as many.
pub const TEXELS_PER_ROW: u32 = 4096;

/// Bytes of a texel.
const TEXEL_BYTES: usize = 16;

/// Bytes that are on their way to the device at a time.
pub const UPLOAD_BYTES: usize = 64 << 20;

/// An upload of that much that takes longer is given up.
const UPLOAD_TIMEOUT: Duration = Duration::from_secs(60);

/// What `shaders/hierarchy.wgsl` reads.
pub struct DeviceHierarchy {
    walk: wgpu::Buffer,
    rest_ids: Option<wgpu::Buffer>,
    nodes: wgpu::TextureView,
    far: wgpu::TextureView,
    n_nodes: u32,
    cell_shift: u32,
}

impl DeviceHierarchy {
    /// Hands a hierarchy to the device; `None` for one that is not searched by pixel.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more spheres than the device's textures hold, or than it has memory
    /// for.
    pub fn new(gpu: &Gpu, hierarchy: &Hierarchy) -> Result<Option<DeviceHierarchy>> {
        let Search::Pixels { footprints, far } = &hierarchy.search else { return Ok(None) };
        check_limits(gpu, far.len())?;
        let walk = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("walk"),
            size: size_of::<Walk>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let rest_ids = (!hierarchy.rest.is_empty())
            .then(|| storage(gpu, "ids of the rest", bytemuck::cast_slice(&hierarchy.rest)));
        let Footprints { nodes, cell_shift, .. } = footprints;
        let device_hierarchy = DeviceHierarchy {
            walk,
            rest_ids,
            nodes: texture(gpu, "nodes", bytemuck::cast_slice(nodes))?,
            far: texture(gpu, "far spheres", bytemuck::cast_slice(far))?,
            n_nodes: nodes.len() as u32,
            cell_shift: *cell_shift,
        };
        gpu.check()?;
        Ok(Some(device_hierarchy))
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
        buffers.map(wgpu::Buffer::as_entire_binding).chain(textures)
    }

    /// Says which pixel of the picture the next tile starts at.
    pub fn start_at(&self, gpu: &Gpu, [first_x, first_y]: [u32; 2]) {
        let &DeviceHierarchy { n_nodes, cell_shift, .. } = self;
        let walk = Walk { n_nodes, first_x, first_y, cell_shift };
        gpu.queue.write_buffer(&self.walk, 0, bytemuck::bytes_of(&walk));
    }
}

fn check_limits(gpu: &Gpu, n_spheres: usize) -> Result<()> {
    // A tree with one sphere in each leaf has fewer than two nodes a sphere.
    const TEXELS_PER_SPHERE: usize = size_of::<SphereFar>() / TEXEL_BYTES;
    const _: () = assert!(TEXELS_PER_SPHERE >= 2 * size_of::<Node>() / TEXEL_BYTES);
    let texels = TEXELS_PER_ROW as usize * gpu.facts.max_texture_side as usize;
    let most = texels / TEXELS_PER_SPHERE;
    if n_spheres > most {
        return Err(Error::TooLarge(format!(
            "the picture shows {n_spheres} spheres; `{}` takes at most {most}, in a texture of \
             {} MiB: use fewer spheres, or `--device cpu`",
            gpu.facts.name,
            (texels * TEXEL_BYTES) >> 20
        )));
    }
    Ok(())
}

/// A texture that holds `bytes` row by row.
pub(super) fn texture(gpu: &Gpu, label: &str, bytes: &[u8]) -> Result<wgpu::TextureView> {
    let row_bytes = TEXELS_PER_ROW as usize * TEXEL_BYTES;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width: TEXELS_PER_ROW,
            height: bytes.len().div_ceil(row_bytes).max(1) as u32,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let write = |row: usize, bytes: &[u8], width: usize| {
        let rows = bytes.len() / (width * TEXEL_BYTES);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: row as u32, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some((width * TEXEL_BYTES) as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d { width: width as u32, height: rows as u32, depth_or_array_layers: 1 },
        );
        let descriptor = wgpu::CommandEncoderDescriptor::default();
        let done = gpu.submit(gpu.device.create_command_encoder(&descriptor).finish());
        gpu.wait(done, UPLOAD_TIMEOUT).map_err(|reason| {
            Error::Device(format!("`{}` did not take the spheres: {reason}", gpu.facts.name))
        })
    };
    let (whole, last) = bytes.split_at(bytes.len() / row_bytes * row_bytes);
    let rows_at_once = UPLOAD_BYTES / row_bytes;
    for (index, rows) in whole.chunks(rows_at_once * row_bytes).enumerate() {
        write(index * rows_at_once, rows, TEXELS_PER_ROW as usize)?;
    }
    if !last.is_empty() {
        write(whole.len() / row_bytes, last, last.len() / TEXEL_BYTES)?;
    }
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}
