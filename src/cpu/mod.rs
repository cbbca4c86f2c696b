//! The CPU reference: the kernels' Rust twins, rows in parallel.

mod tile;
mod walk;

use std::marker::PhantomData;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::arithmetic::Arithmetic;
use crate::camera::{Bundle, CameraF32, Lens, Pixels};
use crate::certify;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::guard;
use crate::host;
use crate::kernel::certified::{
    self, FarFilter, Filter, FreeFilter, Nearest, PACKET, ParallelFilter, PointFilter, UNDECIDED,
    Widening,
};
use crate::kernel::relative::{RelativePlane, RelativeSphere};
use crate::kernel::{Hit, RayOf, lecture, relative};
use crate::prepare::{Hierarchy, Lists, Objects, Prepared, Seen};
use crate::trace::{Hits, Ray, Rays, Timing, Wants};
use crate::tracer::Tracer;
use crate::vec3::Vec3;
use tile::{ParallelRays, PointRays, TILE, TileRays, TileTracer};

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
    type Float: Arithmetic;
    /// Whether the kernel itself gives `t` and normals.
    const GIVES_SURFACE: bool = true;
    /// Whether its ids rest on a proof.
    const IS_PROVEN: bool = false;
    fn closest(&self, ray: &RayOf<Self::Float>) -> Hit<Self::Float>;
    /// The ids of a packet of pixels' rays, where the kernel has a quicker way for them.
    fn packet(&self, _: &[RayOf<Self::Float>; PACKET]) -> Option<[u32; PACKET]> {
        None
    }
    fn normal_at(&self, ray: &RayOf<Self::Float>, hit: Hit<Self::Float>) -> Vec3<Self::Float>;
}

struct Lecture<'a>(&'a Lists<lecture::SphereLecture, lecture::PlaneLecture>);

impl Kernel for Lecture<'_> {
    type Float = f32;
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        lecture::closest(ray, &self.0.spheres, &self.0.planes)
    }
    #[inline(always)]
    fn normal_at(&self, ray: &RayOf<f32>, hit: Hit<f32>) -> Vec3<f32> {
        lecture::normal_at(ray, hit, &self.0.spheres, &self.0.planes)
    }
}

/// `stable` in f32, `double` in f64.
struct Relative<'a, S, P, const IS_POINT: bool>(&'a Lists<S, P>);

impl<S, P, const IS_POINT: bool> Kernel for Relative<'_, S, P, IS_POINT>
where
    S: RelativeSphere<Float: Arithmetic> + Sync,
    P: RelativePlane<Float = S::Float> + Sync,
{
    type Float = S::Float;
    #[inline(always)]
    fn closest(&self, ray: &RayOf<S::Float>) -> Hit<S::Float> {
        relative::closest::<IS_POINT, S, P>(ray, &self.0.spheres, &self.0.planes)
    }
    #[inline(always)]
    fn normal_at(&self, ray: &RayOf<S::Float>, hit: Hit<S::Float>) -> Vec3<S::Float> {
        relative::normal_at::<IS_POINT, S, P>(ray, hit, &self.0.spheres, &self.0.planes)
    }
}

/// The f32 stage alone: it gives ids, or "undecided".
struct Certified<'a, F> {
    objects: &'a Lists<certified::SphereCertified, certified::PlaneCertified>,
    widening: Widening<f32>,
    filter: PhantomData<F>,
}

impl<'a, F: Filter> Certified<'a, F> {
    fn new(objects: &'a Lists<certified::SphereCertified, certified::PlaneCertified>) -> Self {
        Certified { objects, widening: guard::widening_f32(), filter: PhantomData }
    }
}

impl<F: Filter> Kernel for Certified<'_, F> {
    type Float = f32;
    const GIVES_SURFACE: bool = false;
    const IS_PROVEN: bool = true;
    #[inline(always)]
    fn closest(&self, ray: &RayOf<f32>) -> Hit<f32> {
        let Lists { spheres, planes } = self.objects;
        let id = certified::propose::<F>(ray, spheres, planes, &self.widening);
        Hit { id, ..Hit::MISS }
    }
    #[inline(always)]
    fn packet(&self, rays: &[RayOf<f32>; PACKET]) -> Option<[u32; PACKET]> {
        let Lists { spheres, planes } = self.objects;
        F::IS_STRAIGHT
            .then(|| certified::propose_packet::<F>(rays, spheres, planes, &self.widening))
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
    fn put<K: Kernel>(&mut self, index: usize, kernel: &K, ray: &RayOf<K::Float>, t_scale: f64) {
        let hit = kernel.closest(ray);
        let seen = K::Float::seen(hit, t_scale);
        self.id[index] = seen.id;
        if let Some((t, normal)) = &mut self.surface {
            t[index] = seen.t;
            if seen.id != 0 {
                normal[index] = K::Float::normal(kernel.normal_at(ray, hit));
            }
        }
    }
}

impl Tracer for CpuTracer {
    fn propose(&mut self, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<Timing> {
        let start = Instant::now();
        self.prepared.check(rays)?;
        hits.reset(rays.len(), self.wants);
        if rays.is_empty() {
            return Ok(Timing::default());
        }
        if let Some(hierarchy) = &self.prepared.hierarchy {
            trace_hierarchy(&self.prepared, hierarchy, rays, control, hits)?;
            return Ok(Timing { trace: start.elapsed(), ..Timing::default() });
        }
        let prepared = &*self.prepared;
        let mut run = |kernel: &dyn TraceRays| kernel.trace_rays(prepared, rays, control, hits);
        match (&prepared.objects, prepared.bundle()) {
            (Objects::Lecture(lists), _) => run(&Lecture(lists)),
            (Objects::Stable(lists), Bundle::Point) => run(&Relative::<_, _, true>(lists)),
            (Objects::Stable(lists), _) => run(&Relative::<_, _, false>(lists)),
            (Objects::Double(lists), Bundle::Point) => run(&Relative::<_, _, true>(lists)),
            (Objects::Double(lists), _) => run(&Relative::<_, _, false>(lists)),
            (Objects::Certified(lists), Bundle::Point) => match prepared.near {
                true => run(&Certified::<PointFilter>::new(lists)),
                false => run(&Certified::<FarFilter>::new(lists)),
            },
            (Objects::Certified(lists), Bundle::Parallel) => {
                run(&Certified::<ParallelFilter>::new(lists))
            }
            (Objects::Certified(lists), Bundle::Free) => run(&Certified::<FreeFilter>::new(lists)),
        }?;
        Ok(Timing { trace: start.elapsed(), ..Timing::default() })
    }

    fn certify(
        &self,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
        timing: Timing,
    ) -> Result<Timing> {
        certify::finish(&self.prepared, rays, self.wants, control, hits, timing)
    }

    fn retarget(&mut self, prepared: Arc<Prepared>) -> Result<()> {
        self.prepared = prepared;
        Ok(())
    }

    fn bytes_device(&self) -> u64 {
        let (spheres, planes) = self.prepared.objects.bytes();
        let hierarchy = self.prepared.hierarchy.as_ref().map_or(0, Hierarchy::bytes);
        (spheres.len() + planes.len()) as u64 + hierarchy
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
    let (Rays::Pixels(pixels), Some(Seen { footprints, far })) = (rays, &hierarchy.seen) else {
        hits.id.fill(UNDECIDED);
        return Ok(());
    };
    let width = pixels.width as usize;
    hits.id.par_chunks_mut(TILE * width).enumerate().try_for_each(|(band, ids)| {
        control.check()?;
        host::check()?;
        let first_row = (band * TILE) as u32;
        let n_rays = ids.len() as u64;
        let row = RowOfTiles { prepared, hierarchy, pixels, first_row, control, ids };
        let arch = pulp::Arch::new();
        match pixels.view.lens {
            Lens::Perspective => {
                let tracer = TileTracer::<PointRays>::new(footprints, far, pixels);
                arch.dispatch(WithTracer { row, tracer })
            }
            Lens::Orthographic => {
                let tracer = TileTracer::<ParallelRays>::new(footprints, far, pixels);
                arch.dispatch(WithTracer { row, tracer })
            }
        }?;
        control.advance(n_rays);
        Ok(())
    })
}

/// The ids of one row of tiles, compiled for each instruction set that the processor may have.
struct RowOfTiles<'a> {
    prepared: &'a Prepared,
    hierarchy: &'a Hierarchy,
    pixels: &'a Pixels,
    first_row: u32,
    control: &'a Control,
    ids: &'a mut [u32],
}

/// The row with the rays of one bundle.
struct WithTracer<'a, T> {
    row: RowOfTiles<'a>,
    tracer: TileTracer<'a, T>,
}

impl<T: TileRays> pulp::WithSimd for WithTracer<'_, T> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Result<()> {
        let WithTracer { row, mut tracer } = self;
        let RowOfTiles { prepared, hierarchy, pixels, first_row, control, ids } = row;
        let widening = guard::widening_f32();
        let width = pixels.width as usize;
        let n_rows = ids.len() / width;
        for first_column in (0..width).step_by(TILE) {
            control.check()?;
            let (x, y) = (pixels.x + first_column as u32, pixels.y + first_row);
            tracer.trace(x, y, |ray| others::<T::Filter>(prepared, hierarchy, ray, &widening));
            for row in 0..n_rows {
                for column in 0..TILE.min(width - first_column) {
                    let id = tracer.nearest(column, row).decide();
                    ids[row * width + first_column + column] = id;
                }
            }
        }
        Ok(())
    }
}

/// What the kernel `certified` proposes where each ray goes through the hierarchy alone, as on a
/// device, into `ids`: the twin that a device's proposals are compared with. A tile of
/// [`CpuTracer`] also shows a ray the spheres of its neighbours, and so may leave more rays open,
/// but never sees another object.
///
/// # Errors
/// [`crate::Error::Usage`] for anything else than a picture of many spheres.
pub fn propose_alone(prepared: &Prepared, pixels: &Pixels) -> Result<Vec<u32>> {
    prepared.check(&Rays::Pixels(*pixels))?;
    let hierarchy = prepared.hierarchy.as_ref();
    let Some((hierarchy, seen)) = hierarchy.and_then(|h| Some((h, h.seen.as_ref()?))) else {
        return Err(Error::Usage("the scene has no hierarchy over pixels".into()));
    };
    Ok(match pixels.view.lens {
        Lens::Perspective => rays_alone::<PointRays>(prepared, hierarchy, seen, pixels),
        Lens::Orthographic => rays_alone::<ParallelRays>(prepared, hierarchy, seen, pixels),
    })
}

fn rays_alone<T: TileRays>(
    prepared: &Prepared,
    hierarchy: &Hierarchy,
    seen: &Seen,
    pixels: &Pixels,
) -> Vec<u32> {
    let camera = CameraF32::new(pixels);
    let widening = guard::widening_f32();
    let propose = |index: usize| {
        let (x, y) = pixels.xy(index);
        let (i, j) = pixels.offset2(x, y);
        let ray = camera.camera_ray(i as f32, j as f32);
        let listed = others::<T::Filter>(prepared, hierarchy, &ray, &widening);
        walk::nearest_far::<T>(&ray, [x, y], listed, seen, &widening).decide()
    };
    (0..pixels.len()).into_par_iter().map(propose).collect()
}

/// The objects outside the hierarchy.
#[inline(always)]
fn others<F: Filter>(
    prepared: &Prepared,
    hierarchy: &Hierarchy,
    ray: &RayOf<f32>,
    widening: &Widening<f32>,
) -> Nearest<f32> {
    let mut nearest = Nearest::NONE;
    let Objects::Certified(Lists { spheres, planes }) = &prepared.objects else { return nearest };
    for (sphere, id) in spheres.iter().zip(&hierarchy.rest) {
        nearest = nearest.nearer(F::sphere(ray, sphere, widening), *id);
    }
    let first_id = prepared.scene.spheres.len() as u32 + 1;
    for (plane, id) in planes.iter().zip(first_id..) {
        nearest = nearest.nearer(F::plane(ray, plane, widening), id);
    }
    nearest
}

/// The loop over all rays, compiled once a kernel.
trait TraceRays {
    fn trace_rays(
        &self,
        prepared: &Prepared,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<()>;
}

impl<K: Kernel> TraceRays for K {
    fn trace_rays(
        &self,
        prepared: &Prepared,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<()> {
        match rays {
            Rays::Pixels(pixels) => {
                let camera = K::Float::camera(prepared, pixels);
                for_each_chunk::<Self>(hits, pixels.width as usize, control, |row, slice| {
                    trace_row(self, &camera, pixels, row as u32, control, slice)
                })
            }
            Rays::List(rays) => {
                for_each_chunk::<Self>(hits, RAYS_PER_CHUNK, control, |chunk, slice| {
                    let first = chunk * RAYS_PER_CHUNK;
                    let end = (first + RAYS_PER_CHUNK).min(rays.len());
                    trace_list(self, prepared, &rays[first..end], control, slice)
                })
            }
        }
    }
}

fn trace_row<K: Kernel>(
    kernel: &K,
    camera: &<K::Float as Arithmetic>::Camera,
    pixels: &Pixels,
    row: u32,
    control: &Control,
    slice: &mut HitsSlice,
) -> Result<()> {
    let (offset_i, j) = pixels.offset2(pixels.x, pixels.y + row);
    let ray_at = |column: usize| K::Float::pixel_ray(camera, offset_i + 2 * column as i64, j);
    let width = pixels.width as usize;
    let mut column = 0;
    // A ray may have millions of spheres to look at.
    while column + PACKET <= width {
        control.check()?;
        let rays = K::Float::pixel_rays(camera, offset_i + 2 * column as i64, j);
        let Some(ids) = kernel.packet(&rays) else { break };
        slice.id[column..column + PACKET].copy_from_slice(&ids);
        column += PACKET;
    }
    for column in column..width {
        control.check()?;
        slice.put(column, kernel, &ray_at(column), 1.0);
    }
    Ok(())
}

fn trace_list<K: Kernel>(
    kernel: &K,
    prepared: &Prepared,
    rays: &[Ray],
    control: &Control,
    slice: &mut HitsSlice,
) -> Result<()> {
    for (index, ray) in rays.iter().enumerate() {
        control.check()?;
        let (ray, t_scale) = K::Float::list_ray(prepared, ray);
        slice.put(index, kernel, &ray, t_scale);
    }
    Ok(())
}

/// Runs `work(chunk index, entries)` over all chunks of `n` rays in parallel, until cancelled.
fn for_each_chunk<K: Kernel>(
    hits: &mut Hits,
    n: usize,
    control: &Control,
    work: impl Fn(usize, &mut HitsSlice) -> Result<()> + Sync,
) -> Result<()> {
    let run = |chunk: usize, mut slice: HitsSlice| {
        control.check()?;
        if K::IS_PROVEN {
            host::check()?;
        }
        work(chunk, &mut slice)?;
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
