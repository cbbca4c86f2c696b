//! Twin of the filter in f64 on a device, ray by ray.

use rayon::prelude::*;

use super::filter::{InF64, ray_record, suits_device};
use crate::error::{Error, Result};
use crate::guard;
use crate::kernel::RayOf;
use crate::kernel::certified::{
    Filter, FreeFilter, Nearest, ParallelFilter, PointFilter, nearest_listed,
};
use crate::prepare::{Prepared, Seen};
use crate::rays::{Bundle, CameraF64, Rays};
use crate::trace::Ray;
use crate::vec3::Vec3;

/// The proposals of the kernel `certified` in f64, as a device makes them, into ids: the twin that they
/// are compared with. Rays of a list must have directions that f32 has room for.
///
/// # Errors
/// [`Error::Usage`] for a scene that no device decides in f64, and for rays that the scene was not prepared
/// for.
pub fn propose_in_f64(prepared: &Prepared, rays: &Rays) -> Result<Vec<u32>> {
    prepared.check(rays)?;
    if !suits_device(prepared) {
        return Err(Error::Usage("no device decides these rays in f64".into()));
    }
    let numbers = InF64::new(prepared);
    Ok(match prepared.bundle() {
        Bundle::Point => propose::<PointFilter>(prepared, &numbers, rays),
        Bundle::Parallel => propose::<ParallelFilter>(prepared, &numbers, rays),
        Bundle::Free => propose::<FreeFilter>(prepared, &numbers, rays),
    })
}

fn propose<F: Filter<f64>>(prepared: &Prepared, numbers: &InF64, rays: &Rays) -> Vec<u32> {
    let list_ray = |ray: &Ray| {
        let record = ray_record(ray);
        let (origin, direction) = (Vec3(record.origin), Vec3(record.direction));
        nearest::<F>(prepared, numbers, &RayOf::new(origin, Vec3::ZERO, direction), None).decide()
    };
    match rays {
        Rays::List(rays) => rays.par_iter().map(list_ray).collect(),
        Rays::Pixels(pixels) => {
            let camera = CameraF64::new(pixels);
            let pixel = |index: usize| {
                let (x, y) = pixels.xy(index);
                let (i, j) = pixels.offset2(x, y);
                let ray = camera.camera_ray(i as f64, j as f64);
                nearest::<F>(prepared, numbers, &ray, Some([x, y])).decide()
            };
            (0..pixels.len()).into_par_iter().map(pixel).collect()
        }
    }
}

fn nearest<F: Filter<f64>>(
    prepared: &Prepared,
    numbers: &InF64,
    ray: &RayOf<f64>,
    pixel: Option<[u32; 2]>,
) -> Nearest<f64> {
    let widening = guard::widening_f64();
    let n_spheres = prepared.scene.spheres.len() as u32;
    let hierarchy = prepared.hierarchy.as_ref();
    let sphere_id = |index: u32| match hierarchy {
        None => index + 1,
        // What follows them is no sphere.
        Some(hierarchy) => hierarchy.rest.get(index as usize).copied().unwrap_or(0),
    };
    let (spheres, planes) = (&numbers.lists.spheres, &numbers.lists.planes);
    let mut nearest =
        nearest_listed::<f64, F>(ray, spheres, planes, n_spheres, sphere_id, &widening);
    if let (Some(hierarchy), Some(pixel)) = (hierarchy, pixel)
        && let Some(Seen { footprints, far }) = &hierarchy.seen
    {
        let seen_from = numbers.seen_from();
        let t_max = |nearest: &Nearest<f64>| guard::round_down(t_bound(ray.a * nearest.low));
        footprints.visit(footprints.cells(pixel, pixel), t_max(&nearest), |_, place| {
            let id = far[place].id;
            let sphere = seen_from.sphere_seen(&prepared.scene.spheres[id as usize - 1]);
            nearest = nearest.nearer(F::sphere_nearness(ray, &sphere, &widening), id);
            t_max(&nearest)
        });
    }
    nearest
}

/// [`guard::t_bound_f32`] in f64, with the same room.
fn t_bound(nearness: f64) -> f64 {
    f64::from(guard::T_ROOM) / nearness.max(f64::from(guard::LEAST_NEARNESS))
}
