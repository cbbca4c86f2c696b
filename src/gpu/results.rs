//! Room on the device for the rays and the results of a dispatch, and the way of these to the host.

use std::ops::Range;
use std::time::Duration;

use super::device::OpenDevice;
use super::pipeline::Named;
use super::tiles::Tile;
use crate::kernel::Float;
use crate::kernel::coordinates::{RayRecord, RayRecordDouble};
use crate::prepare::ShaderKey;
use crate::rays::Bundle;
use crate::trace::Hits;

/// Bytes of the id, of `t`, and of the normal of one ray.
const RESULT_BYTES: [usize; 3] = [4, 4, 12];

/// Buffers for `n_rays` rays.
pub struct Results {
    pub n_rays: usize,
    /// The ids, and `t` and normals where there are such.
    pub device: Vec<Named>,
    staging: wgpu::Buffer,
    /// Rays that the host gives, one by one.
    pub rays: Option<Named>,
}

impl Results {
    /// For a shader of this key.
    pub fn new(gpu: &OpenDevice, n_rays: usize, key: &ShaderKey) -> Results {
        let buffer =
            |label, bytes_per_ray: usize, usage| gpu.buffer(label, n_rays * bytes_per_ray, usage);
        let results = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let n_results = if key.surface { RESULT_BYTES.len() } else { 1 };
        let device: Vec<_> = ["ids", "ts", "normals"]
            .into_iter()
            .zip(RESULT_BYTES)
            .take(n_results)
            .map(|(name, bytes_per_ray)| (name, buffer(name, bytes_per_ray, results)))
            .collect();
        let bytes_per_ray = RESULT_BYTES.iter().take(n_results).sum();
        let staging_usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = buffer("staging", bytes_per_ray, staging_usage);
        let rays = (key.bundle == Bundle::Free).then(|| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            let bytes_per_ray = match key.kernel.about().float {
                Float::F64 => size_of::<RayRecordDouble>(),
                Float::F32 => size_of::<RayRecord>(),
            };
            ("rays", buffer("rays", bytes_per_ray, usage))
        });
        Results { n_rays, device, staging, rays }
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let buffers = self.device.iter().chain(&self.rays);
        buffers.map(|(_, buffer)| buffer.size()).sum::<u64>() + self.staging.size()
    }

    /// Copies the ids of a tile to where they stay on the device.
    #[cfg(feature = "view")]
    pub fn keep(&self, encoder: &mut wgpu::CommandEncoder, tile: &Tile, ids: &wgpu::Buffer) {
        let [offset, bytes] = [tile.first, tile.n_rays].map(|n| (n * RESULT_BYTES[0]) as u64);
        encoder.copy_buffer_to_buffer(&self.device[0].1, 0, ids, offset, Some(bytes));
    }

    /// Copies the results of a tile to where the host reads them.
    pub fn stage(&self, encoder: &mut wgpu::CommandEncoder, tile: &Tile) {
        for ((_, buffer), range) in self.device.iter().zip(ranges(tile.n_rays)) {
            let bytes = range.len() as u64;
            encoder.copy_buffer_to_buffer(
                buffer,
                0,
                &self.staging,
                range.start as u64,
                Some(bytes),
            );
        }
    }

    /// Waits for what was staged of a tile.
    pub fn map(
        &self,
        gpu: &OpenDevice,
        tile: &Tile,
        timeout: Duration,
    ) -> Result<wgpu::BufferView, String> {
        let end = ranges(tile.n_rays)[self.device.len() - 1].end;
        gpu.map(&self.staging, end as u64, timeout)
    }

    /// Puts what was mapped of a tile into its place. A `t` is divided by two to the power of the ray's
    /// exponent, where there are such.
    pub fn store(&self, view: wgpu::BufferView, tile: &Tile, exponents: &[i32], hits: &mut Hits) {
        let [ids, ts, normals] = ranges(tile.n_rays);
        let place = tile.first..tile.first + tile.n_rays;
        hits.id[place.clone()].copy_from_slice(bytemuck::cast_slice(&view[ids]));
        if self.device.len() > 1 {
            hits.t[place.clone()].copy_from_slice(bytemuck::cast_slice(&view[ts]));
            hits.normal[place.clone()].copy_from_slice(bytemuck::cast_slice(&view[normals]));
            for (t, exponent) in hits.t[place].iter_mut().zip(exponents) {
                *t = (f64::from(*t) * 2f64.powi(-exponent)) as f32;
            }
        }
        drop(view);
        self.staging.unmap();
    }
}

/// Where each kind of results of `n_rays` rays lies where the host reads them.
fn ranges(n_rays: usize) -> [Range<usize>; 3] {
    let mut offset = 0;
    RESULT_BYTES.map(|bytes_per_ray| {
        let start = offset;
        offset += n_rays * bytes_per_ray;
        start..offset
    })
}
