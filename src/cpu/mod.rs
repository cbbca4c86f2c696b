//! The CPU reference: the kernels' Rust twins, rows in parallel.

mod tile;

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::camera::{CameraF32, Pixels};
use crate::certify;
use crate::error::Result;
use crate::guard;
use crate::kernel::certified::{
    self, Nearest, PACKET, UNDECIDED, Widening, plane_record_nearness, record_nearness,
};
use crate::kernel::{Hit, RayOf, lecture, stable};
use crate::prepare::{Hierarchy, Lists, Objects, Prepared};
use crate::trace::{Control, Hits, Ray, Rays, Timing, Tracer, Wants};
use crate::vec3::Vec3;
use tile::{TILE, TileFrame, TileTracer};

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

/// One kernel with its objects.
trait Kernel: Sync {
    /// Whether the kernel itself gives `t` and normals.
    const GIVES_SURFACE: bool = true;
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32>;
    /// The ids of a packet of pixels' rays, where the kernel has a quicker way for them.
    fn packet(&self, _: &[RayOf<f32>; PACKET]) -> Option<[u32; PACKET]> {
        None
    }
    fn normal_at(&self, ray: &RayOf<f32>, hit: Hit<f32>) -> Vec3<f32>;
}

struct Lecture<'a>(&'a Lists<lecture::SphereLecture, lecture::PlaneLecture>);

impl Kernel for Lecture<'_> {
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        lecture::closest(ray, &self.0.spheres, &self.0.planes)
    }
    #[inline(always)]
    fn normal_at(&self, ray: &RayOf<f32>, hit: Hit<f32>) -> Vec3<f32> {
        lecture::normal_at(ray, hit, &self.0.spheres, &self.0.planes)
    }
}

struct Stable<'a, const PIXELS: bool>(&'a Lists<stable::SphereStable, stable::PlaneStable>);

impl<const PIXELS: bool> Kernel for Stable<'_, PIXELS> {
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        stable::closest::<PIXELS>(ray, &self.0.spheres, &self.0.planes)
    }
    #[inline(always)]
    fn normal_at(&self, ray: &RayOf<f32>, hit: Hit<f32>) -> Vec3<f32> {
        stable::normal_at::<PIXELS>(ray, hit, &self.0.spheres, &self.0.planes)
    }
}

/// The f32 stage alone: it gives ids, or "undecided".
struct Certified<'a, const PIXELS: bool, const NEAR: bool> {
    objects: &'a Lists<certified::SphereCertified, certified::PlaneCertified>,
    widening: Widening<f32>,
}

impl<'a, const PIXELS: bool, const NEAR: bool> Certified<'a, PIXELS, NEAR> {
    fn new(objects: &'a Lists<certified::SphereCertified, certified::PlaneCertified>) -> Self {
        Certified { objects, widening: guard::widening_f32() }
    }
}

impl<const PIXELS: bool, const NEAR: bool> Kernel for Certified<'_, PIXELS, NEAR> {
    const GIVES_SURFACE: bool = false;
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        let Lists { spheres, planes } = self.objects;
        let id = certified::propose::<PIXELS, NEAR>(ray, spheres, planes, &self.widening);
        Hit { id, ..Hit::MISS }
    }
    #[inline(always)]
    fn packet(&self, rays: &[RayOf<f32>; PACKET]) -> Option<[u32; PACKET]> {
        let Lists { spheres, planes } = self.objects;
        (PIXELS && !NEAR).then(|| certified::propose_packet(rays, spheres, planes, &self.widening))
    }
    #[inline(always)]
    fn normal_at(&self, _: &RayOf<f32>, _: Hit<f32>) -> Vec3<f32> {
        Vec3::ZERO
    }
}

/// A run of consecutive entries of [`Hits`].
struct HitsSlice<'a> {
    id: &'a mut [u32],
    surface: Option<(&'a mut [f32], &'a mut [[f32; 3]])>,
}

impl HitsSlice<'_> {
    #[inline(always)]
    fn put<K: Kernel>(
        &mut self,
        index: usize,
        kernel: &K,
        ray: &RayOf<f32>,
        hit: Hit<f32>,
        t_scale: f64,
    ) {
        self.id[index] = hit.id;
        if let Some((t, normal)) = &mut self.surface {
            t[index] = (f64::from(hit.t) * t_scale) as f32;
            if hit.id != 0 {
                normal[index] = kernel.normal_at(ray, hit).0;
            }
        }
    }
}

impl Tracer for CpuTracer {
    fn trace(&mut self, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<Timing> {
        let start = Instant::now();
        self.prepared.check(rays)?;
        hits.reset(rays.len(), self.wants);
        if rays.is_empty() {
            return Ok(Timing::default());
        }
        if let Some(hierarchy) = &self.prepared.hierarchy {
            trace_hierarchy(&self.prepared, hierarchy, rays, control, hits)?;
            let traced = Timing { trace: start.elapsed(), ..Timing::default() };
            return certify::finish(&self.prepared, rays, self.wants, control, hits, traced);
        }
        let world = self.prepared.reference.into();
        let mut run = |kernel: &dyn TraceRays, origin| {
            kernel.trace_rays(&self.prepared, origin, rays, control, hits)
        };
        match (&self.prepared.objects, rays) {
            (Objects::Lecture(lists), _) => run(&Lecture(lists), world),
            (Objects::Stable(lists), Rays::Pixels(_)) => run(&Stable::<true>(lists), Vec3::ZERO),
            (Objects::Stable(lists), Rays::List(_)) => run(&Stable::<false>(lists), Vec3::ZERO),
            (Objects::Certified(lists), Rays::Pixels(_)) => match self.prepared.near {
                true => run(&Certified::<true, true>::new(lists), Vec3::ZERO),
                false => run(&Certified::<true, false>::new(lists), Vec3::ZERO),
            },
            (Objects::Certified(lists), Rays::List(_)) => {
                run(&Certified::<false, true>::new(lists), Vec3::ZERO)
            }
        }?;
        let traced = Timing { trace: start.elapsed(), ..Timing::default() };
        certify::finish(&self.prepared, rays, self.wants, control, hits, traced)
    }

    fn bytes_device(&self) -> u64 {
        let (spheres, planes) = self.prepared.objects.bytes();
        (spheres.len() + planes.len()) as u64
    }
}

/// The certified kernel's f32 stage through a hierarchy. A list of rays is left to f64.
fn trace_hierarchy(
    prepared: &Prepared,
    hierarchy: &Hierarchy,
    rays: &Rays,
    control: &Control,
    hits: &mut Hits,
) -> Result<()> {
    let (Rays::Pixels(pixels), true) = (rays, prepared.in_range) else {
        hits.id.fill(UNDECIDED);
        return Ok(());
    };
    let frame = TileFrame::new(pixels);
    let rows = Rows { prepared, hierarchy, frame: &frame, pixels };
    let width = pixels.width as usize;
    hits.id.par_chunks_mut(TILE * width).enumerate().try_for_each(|(band, ids)| {
        control.check()?;
        let arch = pulp::Arch::new();
        arch.dispatch(RowOfTiles { rows: &rows, first_row: band * TILE, ids });
        control.advance(ids.len() as u64);
        Ok(())
    })
}

/// A picture that is traced in rows of tiles.
struct Rows<'a> {
    prepared: &'a Prepared,
    hierarchy: &'a Hierarchy,
    frame: &'a TileFrame,
    pixels: &'a Pixels,
}

/// The ids of one row of tiles, compiled for each instruction set that the processor may have.
struct RowOfTiles<'a> {
    rows: &'a Rows<'a>,
    first_row: usize,
    ids: &'a mut [u32],
}

impl pulp::WithSimd for RowOfTiles<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let RowOfTiles { rows: Rows { prepared, hierarchy, frame, pixels }, first_row, ids } = self;
        let widening = guard::widening_f32();
        let width = pixels.width as usize;
        let n_rows = ids.len() / width;
        let (left, top) = pixels.offset2(pixels.x, pixels.y + first_row as u32);
        let mut tracer = TileTracer::new(hierarchy, frame, widening);
        for first_column in (0..width).step_by(TILE) {
            let i = left + 2 * first_column as i64;
            tracer.trace(i, top);
            for y in 0..n_rows.min(TILE) {
                for x in 0..TILE.min(width - first_column) {
                    let mut nearest = tracer.nearest(x, y);
                    if !hierarchy.rest.is_empty() || !prepared.scene.planes.is_empty() {
                        let (i, j) = (i + 2 * x as i64, top - 2 * y as i64);
                        nearest = others(prepared, hierarchy, frame.ray(i, j), nearest, &widening);
                    }
                    ids[y * width + first_column + x] = nearest.decide();
                }
            }
        }
    }
}

/// The objects outside the hierarchy.
fn others(
    prepared: &Prepared,
    hierarchy: &Hierarchy,
    ray: RayOf<f32>,
    mut nearest: Nearest<f32>,
    widening: &Widening<f32>,
) -> Nearest<f32> {
    for (id, sphere) in &hierarchy.rest {
        nearest = nearest.nearer(record_nearness::<true, true>(&ray, sphere, widening), *id);
    }
    let Objects::Certified(Lists { planes, .. }) = &prepared.objects else { return nearest };
    let first_id = prepared.scene.spheres.len() as u32 + 1;
    for (plane, id) in planes.iter().zip(first_id..) {
        nearest = nearest.nearer(plane_record_nearness::<true>(&ray, plane, widening), id);
    }
    nearest
}

/// The loop over all rays, compiled once a kernel.
trait TraceRays {
    fn trace_rays(
        &self,
        prepared: &Prepared,
        camera_origin: Vec3<f32>,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<()>;
}

impl<K: Kernel> TraceRays for K {
    fn trace_rays(
        &self,
        prepared: &Prepared,
        camera_origin: Vec3<f32>,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<()> {
        match rays {
            Rays::Pixels(pixels) => {
                let camera = CameraF32::new(pixels);
                for_each_chunk::<Self>(hits, pixels.width as usize, control, |row, slice| {
                    trace_row(self, &camera, camera_origin, pixels, row as u32, slice);
                })
            }
            Rays::List(rays) => {
                for_each_chunk::<Self>(hits, RAYS_PER_CHUNK, control, |chunk, slice| {
                    let first = chunk * RAYS_PER_CHUNK;
                    let end = (first + RAYS_PER_CHUNK).min(rays.len());
                    trace_list(self, prepared, &rays[first..end], slice);
                })
            }
        }
    }
}

fn trace_row<K: Kernel>(
    kernel: &K,
    camera: &CameraF32,
    origin: Vec3<f32>,
    pixels: &Pixels,
    row: u32,
    slice: &mut HitsSlice,
) {
    let (offset_i, j) = pixels.offset2(pixels.x, pixels.y + row);
    let ray_at = |column: usize| {
        let i = offset_i + 2 * column as i64;
        let direction = camera.camera_direction(i as f32, j as f32);
        RayOf::new(origin, Vec3::ZERO, direction)
    };
    let width = pixels.width as usize;
    let mut column = 0;
    while column + PACKET <= width {
        let Some(ids) = kernel.packet(&std::array::from_fn(|lane| ray_at(column + lane))) else {
            break;
        };
        slice.id[column..column + PACKET].copy_from_slice(&ids);
        column += PACKET;
    }
    for column in column..width {
        let ray = ray_at(column);
        slice.put(column, kernel, &ray, kernel.closest(&ray), 1.0);
    }
}

fn trace_list<K: Kernel>(kernel: &K, prepared: &Prepared, rays: &[Ray], slice: &mut HitsSlice) {
    for (index, ray) in rays.iter().enumerate() {
        let (record, exponent) = prepared.ray_record(ray);
        let ray = RayOf::new(Vec3(record.origin), Vec3(record.origin_low), Vec3(record.direction));
        slice.put(index, kernel, &ray, kernel.closest(&ray), 2f64.powi(-exponent));
    }
}

/// Runs `work(chunk index, entries)` over all chunks of `n` rays in parallel, until cancelled.
fn for_each_chunk<K: Kernel>(
    hits: &mut Hits,
    n: usize,
    control: &Control,
    work: impl Fn(usize, &mut HitsSlice) + Sync,
) -> Result<()> {
    let run = |chunk: usize, mut slice: HitsSlice| {
        control.check()?;
        work(chunk, &mut slice);
        control.advance(slice.id.len() as u64);
        Ok(())
    };
    let ids = hits.id.par_chunks_mut(n).enumerate();
    if hits.t.is_empty() || !K::GIVES_SURFACE {
        ids.try_for_each(|(chunk, id)| run(chunk, HitsSlice { id, surface: None }))
    } else {
        let surfaces = hits.t.par_chunks_mut(n).zip(hits.normal.par_chunks_mut(n));
        ids.zip(surfaces).try_for_each(|((chunk, id), surface)| {
            run(chunk, HitsSlice { id, surface: Some(surface) })
        })
    }
}
