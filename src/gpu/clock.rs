//! The device's own clock around a compute pass.

use std::time::Duration;

use super::open::Gpu;
use crate::error::{Error, Result};

/// Begin and end of the pass, each a 64-bit tick.
const BYTES: u64 = 2 * size_of::<u64>() as u64;

/// The clock of one device.
pub struct Clock {
    queries: wgpu::QuerySet,
    ticks: wgpu::Buffer,
    staging: wgpu::Buffer,
    ns_per_tick: f64,
}

impl Clock {
    /// `None` where the device has no clock.
    pub fn new(gpu: &Gpu) -> Option<Clock> {
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        use wgpu::BufferUsages as Usage;
        let n_bytes = BYTES as usize;
        Some(Clock {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("clock"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            ticks: gpu.buffer("ticks", n_bytes, Usage::QUERY_RESOLVE | Usage::COPY_SRC),
            staging: gpu.buffer("ticks to read", n_bytes, Usage::MAP_READ | Usage::COPY_DST),
            ns_per_tick: f64::from(gpu.queue.get_timestamp_period()),
        })
    }

    /// The timestamps to begin a pass with, so that it is measured.
    pub fn around_pass(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Makes the measured pass's time readable; goes after the pass.
    pub fn stop(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.ticks, 0);
        encoder.copy_buffer_to_buffer(&self.ticks, 0, &self.staging, 0, Some(BYTES));
    }

    /// The time of the pass that was submitted last.
    ///
    /// # Errors
    /// [`Error::Device`] when the device does not finish in time.
    pub fn read(&self, gpu: &Gpu) -> Result<Duration> {
        let mapped = gpu.map(&self.staging, BYTES);
        gpu.check()?;
        let view = mapped.map_err(|reason| {
            Error::Device(format!("`{}` did not give its time: {reason}", gpu.facts.name).into())
        })?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&view[..]);
        drop(view);
        self.staging.unmap();
        let ns = ticks[1].saturating_sub(ticks[0]) as f64 * self.ns_per_tick;
        Ok(Duration::from_nanos(ns as u64))
    }
}
