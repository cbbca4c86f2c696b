//! The CPU reference: the kernels' Rust twins, rows in parallel.

mod squares;

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::control::Control;
use crate::engine::{LARGEST, List, ListSearch, Room, Search};
use crate::error::Result;
use crate::host;
use crate::kernel::arithmetic::Arithmetic;
use crate::kernel::coordinates::Coordinates;
use crate::kernel::twin::{PACKET, Packet, Twin, WithTwin};
use crate::kernel::{Kernel, RayOf};
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

/// A run of consecutive entries of [`Hits`].
struct HitsSlice<'a> {
    id: &'a mut [u32],
    surface: Option<(&'a mut [f32], &'a mut [[f32; 3]])>,
}

impl HitsSlice<'_> {
    /// Finds what rays hit, of which `ray` gives each with what its `t` is multiplied with.
    #[inline(always)]
    fn find<T: Twin>(
        &mut self,
        twin: &T,
        control: &Control,
        ray: impl Fn(usize) -> (RayOf<T::Float>, f64),
    ) -> Result<()> {
        let len = self.id.len();
        for first in (0..len).step_by(PACKET) {
            // A ray may have millions of spheres to look at.
            control.check()?;
            // The last one stands for lanes that don't count.
            let index = |lane: usize| (first + lane).min(len - 1);
            let mut packet = Packet::new(|lane| ray(index(lane)).0);
            twin.closest_of(&mut packet);
            for lane in 0..PACKET.min(len - first) {
                let (at, hit) = (first + lane, packet.hit(lane));
                let seen = T::Float::seen(hit, ray(at).1);
                self.id[at] = seen.id;
                if let Some((t, normal)) = &mut self.surface {
                    t[at] = seen.t;
                    if seen.id != 0 {
                        normal[at] = T::Float::normal(twin.normal_at(&packet.ray(lane), hit));
                    }
                }
            }
        }
        Ok(())
    }
}

/// The rays of a slice, compiled for each instruction set that the processor may have.
struct Find<'a, 'b, T, R> {
    slice: &'a mut HitsSlice<'b>,
    twin: &'a T,
    control: &'a Control,
    ray: R,
}

impl<T: Twin, R: Fn(usize) -> (RayOf<T::Float>, f64)> pulp::WithSimd for Find<'_, '_, T, R> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Result<()> {
        self.slice.find(self.twin, self.control, self.ray)
    }
}

impl Tracer for CpuTracer {
    fn propose(&mut self, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<Timing> {
        let start = Instant::now();
        self.prepared.check(rays)?;
        match self.prepared.kernel {
            Kernel::Certified => hits.make_room(rays.len(), self.wants),
            _ => hits.reset(rays.len(), self.wants),
        }
        if rays.is_empty() {
            return Ok(Timing::default());
        }
        let prepared = &*self.prepared;
        match (prepared.kernel, rays) {
            (Kernel::Certified, Rays::Pixels(pixels)) => search(prepared, pixels, control, hits)?,
            (Kernel::Certified, Rays::List(rays)) => search_list(prepared, rays, control, hits)?,
            _ => {
                let trace = TraceRays { prepared, rays, control, hits };
                prepared.objects.with_twin(prepared.bundle(), trace).transpose()?;
            }
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

/// The loop over all rays.
pub(crate) struct TraceRays<'a> {
    pub prepared: &'a Prepared,
    pub rays: &'a Rays,
    pub control: &'a Control,
    pub hits: &'a mut Hits,
}

impl WithTwin for TraceRays<'_> {
    type Output = Result<()>;

    fn with<T: Twin>(self, twin: &T) -> Result<()> {
        let TraceRays { prepared, rays, control, hits } = self;
        let coordinates = &prepared.coordinates();
        match rays {
            Rays::Pixels(pixels) => {
                let camera = T::Float::camera(coordinates, pixels);
                for_each_chunk::<T>(hits, pixels.width as usize, control, |row, slice| {
                    trace_row(twin, &camera, pixels, row as u32, control, slice)
                })
            }
            Rays::List(rays) => {
                for_each_chunk::<T>(hits, RAYS_PER_CHUNK, control, |chunk, slice| {
                    let first = chunk * RAYS_PER_CHUNK;
                    let end = (first + RAYS_PER_CHUNK).min(rays.len());
                    trace_list(twin, coordinates, &rays[first..end], control, slice)
                })
            }
        }
    }
}

fn trace_row<T: Twin>(
    twin: &T,
    camera: &<T::Float as Arithmetic>::Camera,
    pixels: &Pixels,
    row: u32,
    control: &Control,
    slice: &mut HitsSlice,
) -> Result<()> {
    let (offset_i, j) = pixels.offset2(pixels.x, pixels.y + row);
    let ray = |column: usize| (T::Float::pixel_ray(camera, offset_i + 2 * column as i64, j), 1.0);
    pulp::Arch::new().dispatch(Find { slice, twin, control, ray })
}

fn trace_list<T: Twin>(
    twin: &T,
    coordinates: &Coordinates,
    rays: &[Ray],
    control: &Control,
    slice: &mut HitsSlice,
) -> Result<()> {
    let ray = |index: usize| T::Float::list_ray(coordinates, &rays[index]);
    pulp::Arch::new().dispatch(Find { slice, twin, control, ray })
}

/// Runs `work(chunk index, entries)` over all chunks of `n` rays in parallel, until cancelled.
fn for_each_chunk<T: Twin>(
    hits: &mut Hits,
    n: usize,
    control: &Control,
    work: impl Fn(usize, &mut HitsSlice) -> Result<()> + Sync,
) -> Result<()> {
    let run = |chunk: usize, mut slice: HitsSlice| {
        control.check()?;
        work(chunk, &mut slice)?;
        control.advance(slice.id.len() as u64);
        Ok(())
    };
    let ids = hits.id.par_chunks_mut(n).enumerate();
    if hits.t.is_empty() {
        ids.try_for_each(|(chunk, id)| run(chunk, HitsSlice { id, surface: None }))
    } else {
        let surfaces = hits.t.par_chunks_mut(n).zip(hits.normal.par_chunks_mut(n));
        ids.zip(surfaces).try_for_each(|((chunk, id), surface)| {
            run(chunk, HitsSlice { id, surface: Some(surface) })
        })
    }
}
