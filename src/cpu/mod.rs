//! The CPU as a backend: rows in parallel.

mod plain;
mod squares;

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::control::Control;
use crate::engine::{LARGEST, List, ListSearch, Room, Search};
use crate::error::Result;
use crate::host;
use crate::kernel::Kernel;
use crate::prepare::{Hierarchy, Prepared};
use crate::rays::{Pixels, Ray, Rays};
use crate::trace::{Hits, SampleIds, Timing, Wants};
use crate::tracer::{Tracer, trace_all_samples};
use squares::Squares;

/// Rays that one thread takes at a time from a list.
const RAYS_PER_CHUNK: usize = 4096;

/// Traces on the CPU.
pub struct CpuTracer {
    prepared: Arc<Prepared>,
    wants: Wants,
}

impl CpuTracer {
    /// A tracer for a prepared scene.
    pub fn new(prepared: Arc<Prepared>, wants: Wants) -> CpuTracer {
        CpuTracer { prepared, wants }
    }
}

impl Tracer for CpuTracer {
    fn propose(&mut self, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<Timing> {
        let start = Instant::now();
        self.prepared.check(rays)?;
        hits.make_room(rays.len(), self.wants);
        if rays.is_empty() {
            return Ok(Timing::default());
        }
        let prepared = &*self.prepared;
        match (prepared.kernel, rays) {
            (Kernel::Certified, Rays::Pixels(pixels)) => search(prepared, pixels, control, hits)?,
            (Kernel::Certified, Rays::List(rays)) => search_list(prepared, rays, control, hits)?,
            _ => plain::trace(prepared, rays, control, hits)?,
        }
        Ok(Timing { trace: start.elapsed(), ..Timing::default() })
    }

    fn target(&self) -> Option<(&Prepared, Wants)> {
        Some((&self.prepared, self.wants))
    }

    fn retarget(&mut self, prepared: Arc<Prepared>) -> Result<()> {
        self.prepared = prepared;
        Ok(())
    }

    fn trace_samples(
        &mut self,
        pixels: &Pixels,
        n: u32,
        control: &Control,
        hits: &mut Hits,
        samples: &mut SampleIds,
    ) -> Result<Timing> {
        match Squares::new(&self.prepared, pixels, n) {
            Some(squares) => squares.trace(control, samples),
            None => trace_all_samples(self, pixels, n, control, hits, samples),
        }
    }

    fn bytes_device(&self) -> u64 {
        let (spheres, planes) = self.prepared.objects.bytes();
        let hierarchy = self.prepared.hierarchy.as_ref().map_or(0, Hierarchy::bytes);
        (spheres.len() + planes.len()) as u64 + hierarchy
    }
}

/// The certified kernel's f32 stage for pixels.
fn search(prepared: &Prepared, pixels: &Pixels, control: &Control, hits: &mut Hits) -> Result<()> {
    let search = Search::new(prepared, pixels, 1);
    let strips = hits.id.par_chunks_mut(LARGEST as usize * pixels.width as usize).enumerate();
    strips.try_for_each_init(Room::default, |room, (strip, ids)| {
        control.check()?;
        host::check()?;
        search.look(strip as u32 * LARGEST, ids, room);
        control.advance(ids.len() as u64);
        Ok(())
    })
}

/// The certified kernel's f32 stage for a list of rays.
fn search_list(
    prepared: &Prepared,
    rays: &[Ray],
    control: &Control,
    hits: &mut Hits,
) -> Result<()> {
    let search = ListSearch::new(prepared);
    let chunks = rays.par_chunks(RAYS_PER_CHUNK).zip(hits.id.par_chunks_mut(RAYS_PER_CHUNK));
    chunks.try_for_each(|(rays, ids)| {
        control.check()?;
        host::check()?;
        search.look(List::new(rays, prepared.reference), ids);
        control.advance(ids.len() as u64);
        Ok(())
    })
}
