//! Twin of `shaders/hierarchy.wgsl` and of lists: each ray of a picture alone.

use rayon::prelude::*;

use crate::control::Control;
use crate::cpu::{Leaf, Listed, ParallelRays, PointRays, TileRays, TraceRays};
use crate::error::{Error, Result};
use crate::guard;
use crate::kernel::certified::{Nearest, Widening};
use crate::kernel::{Kernel, RayOf};
use crate::prepare::{Hierarchy, Prepared, Seen};
use crate::rays::{CameraF32, Lens, Pixels, Rays};
use crate::trace::{Hits, Wants};

/// The proposals of the kernel `certified` where each ray is looked at alone, by the formulas of a device: the
/// twin that a device's proposals are compared with. [`CpuTracer`](crate::cpu::CpuTracer) may leave other rays open, but never sees
/// another object.
///
/// # Errors
/// [`Error::Usage`] for another kernel's scene, and for a hierarchy that is not over pixels.
pub fn propose_alone(prepared: &Prepared, pixels: &Pixels) -> Result<Vec<u32>> {
    let rays = Rays::Pixels(*pixels);
    prepared.check(&rays)?;
    let hierarchy = prepared.hierarchy.as_ref();
    if hierarchy.is_none() && prepared.kernel == Kernel::Certified {
        let (mut hits, control) = (Hits::default(), Control::default());
        hits.reset(rays.len(), Wants::default());
        let trace = TraceRays { prepared, rays: &rays, control: &control, hits: &mut hits };
        prepared.objects.with_twin(prepared.bundle(), trace)?;
        return Ok(hits.id);
    }
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
    let (widening, others) = (guard::widening_f32(), Listed::new(prepared, hierarchy));
    let propose = |index: usize| {
        let (x, y) = pixels.xy(index);
        let (i, j) = pixels.offset2(x, y);
        let ray = camera.camera_ray(i as f32, j as f32);
        let listed = others.nearest::<T::Filter>(&ray, &widening);
        nearest_far::<T>(&ray, [x, y], listed, seen, &widening).decide()
    };
    (0..pixels.len()).into_par_iter().map(propose).collect()
}

/// The nearest of `listed` and the spheres of the hierarchy, for a ray of this pixel.
fn nearest_far<T: TileRays>(
    ray: &RayOf<f32>,
    pixel: [u32; 2],
    listed: Nearest<f32>,
    seen: &Seen,
    widening: &Widening<f32>,
) -> Nearest<f32> {
    let mut nearest = listed;
    let Seen { footprints, far } = seen;
    let t_max = guard::t_bound_f32(ray.a * nearest.low);
    footprints.visit(footprints.cells(pixel, pixel), t_max, |_, place| {
        let sphere = &far[place];
        nearest = nearest.nearer(T::leaf(ray, &Leaf::of_rays(sphere), widening), sphere.id);
        guard::t_bound_f32(ray.a * nearest.low)
    });
    nearest
}
