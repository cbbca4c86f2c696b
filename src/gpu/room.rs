//! Room on a device for what a shader makes of rays, and its way to the host.

use std::time::Instant;

use super::open::Gpu;
use super::pipeline::{Named, Program, whole};
use crate::error::{Error, Result};

/// An array that a shader fills, with an element for each ray: its name, and bytes of an element.
pub type PerRay = (&'static str, usize);

/// Room for what a shader makes of so many rays, and its way to the host.
pub struct BufferRoom {
    /// For so many.
    pub n_rays: usize,
    /// The arrays, with bytes of an element.
    results: Vec<(usize, wgpu::Buffer)>,
    staging: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

impl BufferRoom {
    /// Makes room, and binds it with all else that the shader binds.
    ///
    /// # Errors
    /// [`Error::Shader`] where that is not what the shader binds, [`Error::TooLarge`] where the device has no memory for it.
    pub fn new(
        gpu: &Gpu,
        program: &Program,
        n_rays: usize,
        results: &[PerRay],
        mut bound: Vec<Named>,
    ) -> Result<BufferRoom> {
        use wgpu::BufferUsages as Usage;
        let buffer = |&(name, bytes): &PerRay| {
            let buffer = gpu.buffer(name, n_rays * bytes, Usage::STORAGE | Usage::COPY_SRC);
            bound.push((name, buffer.clone().into()));
            (bytes, buffer)
        };
        let results: Vec<_> = results.iter().map(buffer).collect();
        let n_bytes = n_rays * results.iter().map(|(bytes, _)| bytes).sum::<usize>();
        let staging = gpu.buffer("staging", n_bytes, Usage::MAP_READ | Usage::COPY_DST);
        let bind_group = program.bind(&gpu.device, bound.iter().map(whole))?;
        gpu.check()?;
        Ok(BufferRoom { n_rays, results, staging, bind_group })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let of_results = self.results.iter().map(|(_, buffer)| buffer.size());
        of_results.sum::<u64>() + self.staging.size()
    }

    /// Commands that run the shader.
    pub fn dispatch(&self, gpu: &Gpu, program: &Program, [x, y]: [u32; 2]) -> wgpu::CommandEncoder {
        let mut encoder = gpu.encoder();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: None,
            timestamp_writes: None,
        });
        pass.set_pipeline(&program.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.dispatch_workgroups(x, y, 1);
        drop(pass);
        encoder
    }

    /// Submits the commands, and hands on what they made of the first rays, array by array. Returns when they were
    /// made.
    ///
    /// # Errors
    /// What `unfinished` says of a reason when the device takes too long, [`Error::Device`] when it fails.
    pub fn read(
        &self,
        gpu: &Gpu,
        mut encoder: wgpu::CommandEncoder,
        n_rays: usize,
        unfinished: impl FnOnce(&str) -> Error,
        take: &mut dyn FnMut(&[&[u8]]),
    ) -> Result<Instant> {
        let (mut end, mut ranges) = (0, Vec::new());
        for (bytes, buffer) in &self.results {
            let size = n_rays * bytes;
            encoder.copy_buffer_to_buffer(buffer, 0, &self.staging, end as u64, Some(size as u64));
            ranges.push(end..end + size);
            end += size;
        }
        gpu.submit(encoder.finish());
        let mapped = gpu.map(&self.staging, end as u64);
        gpu.check()?;
        let view = mapped.map_err(|reason| unfinished(&reason))?;
        let made = Instant::now();
        let arrays: Vec<&[u8]> = ranges.into_iter().map(|range| &view[range]).collect();
        take(&arrays);
        drop(view);
        self.staging.unmap();
        Ok(made)
    }
}
