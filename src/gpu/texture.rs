//! Textures that hold lists, row by row.

use super::open::Gpu;
use crate::error::{Error, Result};

/// Texels of a row of the textures that hold lists, a power of two; each Vulkan device has as many.
pub const TEXELS_PER_ROW: u32 = 4096;

/// What a texel is.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// Bytes of a texel.
pub const TEXEL_BYTES: usize = 16;

/// Bytes that are on their way to the device at a time.
pub const UPLOAD_BYTES: usize = 64 << 20;

/// A texture that holds `bytes` row by row.
pub fn texture(gpu: &Gpu, label: &str, bytes: &[u8]) -> Result<wgpu::TextureView> {
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
        format: FORMAT,
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
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
        let done = gpu.submit(gpu.encoder().finish());
        gpu.wait(Some(done)).map_err(|reason| {
            Error::Device(format!("`{}` did not take the spheres: {reason}", gpu.facts.name).into())
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
