//! The CPU reference: the kernels' Rust twins, rows in parallel.

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::camera::{CameraF32, Pixels};
use crate::error::Result;
use crate::kernel::{Hit, RayOf, lecture, stable};
use crate::prepare::{Objects, Prepared};
use crate::trace::{Control, Hits, Ray, Rays, StageCounts, Timing, Tracer, Wants};
use crate::vec3::Vec3;

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
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32>;
    fn normal_at(&self, ray: &RayOf<f32>, hit: Hit<f32>) -> Vec3<f32>;
}

struct Lecture<'a> {
    spheres: &'a [lecture::SphereLecture],
    planes: &'a [lecture::PlaneLecture],
}

impl Kernel for Lecture<'_> {
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        lecture::closest(ray, self.spheres, self.planes)
    }
    #[inline(always)]
    fn normal_at(&self, ray: &RayOf<f32>, hit: Hit<f32>) -> Vec3<f32> {
        lecture::normal_at(ray, hit, self.spheres, self.planes)
    }
}

struct Stable<'a, const PIXELS: bool> {
    spheres: &'a [stable::SphereStable],
    planes: &'a [stable::PlaneStable],
}

impl<const PIXELS: bool> Kernel for Stable<'_, PIXELS> {
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        stable::closest::<PIXELS>(ray, self.spheres, self.planes)
    }
    #[inline(always)]
    fn normal_at(&self, ray: &RayOf<f32>, hit: Hit<f32>) -> Vec3<f32> {
        stable::normal_at::<PIXELS>(ray, hit, self.spheres, self.planes)
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
        hits.reset(rays.len(), self.wants);
        match &self.prepared.objects {
            Objects::Lecture { spheres, planes } => {
                let origin = self.prepared.reference.into();
                trace_rays(
                    &Lecture { spheres, planes },
                    &self.prepared,
                    origin,
                    rays,
                    control,
                    hits,
                )
            }
            Objects::Stable { spheres, planes } => match rays {
                Rays::Pixels(_) => {
                    let kernel = Stable::<true> { spheres, planes };
                    trace_rays(&kernel, &self.prepared, Vec3::ZERO, rays, control, hits)
                }
                Rays::List(_) => {
                    let kernel = Stable::<false> { spheres, planes };
                    trace_rays(&kernel, &self.prepared, Vec3::ZERO, rays, control, hits)
                }
            },
        }?;
        hits.counts = StageCounts { f32: rays.len() as u64, ..StageCounts::default() };
        Ok(Timing { trace: start.elapsed(), ..Timing::default() })
    }

    fn bytes_device(&self) -> u64 {
        let (spheres, planes) = self.prepared.objects.bytes();
        (spheres.len() + planes.len()) as u64
    }
}

fn trace_rays<K: Kernel>(
    kernel: &K,
    prepared: &Prepared,
    camera_origin: Vec3<f32>,
    rays: &Rays,
    control: &Control,
    hits: &mut Hits,
) -> Result<()> {
    match rays {
        Rays::Pixels(pixels) => {
            let camera = CameraF32::new(pixels);
            for_each_chunk(hits, pixels.width as usize, control, |row, slice| {
                trace_row(kernel, &camera, camera_origin, pixels, row as u32, slice);
            })
        }
        Rays::List(rays) => for_each_chunk(hits, RAYS_PER_CHUNK, control, |chunk, slice| {
            let first = chunk * RAYS_PER_CHUNK;
            let end = (first + RAYS_PER_CHUNK).min(rays.len());
            trace_list(kernel, prepared, &rays[first..end], slice);
        }),
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
    for column in 0..pixels.width {
        let i = offset_i + 2 * i64::from(column);
        let direction = camera.camera_direction(i as f32, j as f32);
        let ray = RayOf::new(origin, Vec3::ZERO, direction);
        slice.put(column as usize, kernel, &ray, kernel.closest(&ray), 1.0);
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
fn for_each_chunk(
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
    if hits.t.is_empty() {
        ids.try_for_each(|(chunk, id)| run(chunk, HitsSlice { id, surface: None }))
    } else {
        let surfaces = hits.t.par_chunks_mut(n).zip(hits.normal.par_chunks_mut(n));
        ids.zip(surfaces).try_for_each(|((chunk, id), surface)| {
            run(chunk, HitsSlice { id, surface: Some(surface) })
        })
    }
}
