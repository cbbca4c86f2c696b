//! `t` and the normal of a hit that is known to exist.

use rayon::prelude::*;

use super::{RayF64, Stage};
use crate::control::Control;
use crate::error::Result;
use crate::exact::{ExactHit, ExactRay, Shape, visible_root};
use crate::guard;
use crate::host;
use crate::kernel::RayOf;
use crate::kernel::certified::{UNDECIDED, half_chord_radius, normalized};
use crate::prepare::{exponent_of, scale_by_power_of_two};
use crate::scene::{Object, Sphere};
use crate::trace::Hits;
use crate::vec3::{Vec3, dot3};

/// Largest error of an f64 normal before it is rounded to f32: with the rounding itself, `√3·2⁻²⁵`,
/// it stays below `2⁻²³`, also if it were twice as large; not four times.
const NORMAL_TOLERANCE: f64 = 1.0 / (1u64 << 25) as f64;
const _: () = assert!(NORMAL_TOLERANCE + 1.7321 / (1u64 << 25) as f64 <= 1.0 / (1u64 << 23) as f64);

/// Rays that one thread takes at a time.
const RAYS_PER_CHUNK: usize = 1024;

/// `t` and the normal of a hit.
type Surface = (f32, [f32; 3]);

impl Stage<'_> {
    /// `t` and normal in f64, or `None` where their bounds are too wide.
    fn surface_f64(&self, ray: &RayF64, id: u32, object: Object) -> Option<Surface> {
        let root = self.nearness(ray, id, object);
        let t = self.to_f32(ray, root)?;
        let normal = match object {
            Object::Sphere(sphere) => self.sphere_normal(ray, id, sphere)?,
            Object::Plane(plane) => {
                let normal = scale_by_power_of_two(plane.normal, -exponent_of(plane.normal));
                crate::vec3::facing(normal.into(), ray.ray.direction)
            }
        };
        Some((t, normal.0.map(|component| component as f32)))
    }

    /// The normal from half the chord, where its error is small enough.
    fn sphere_normal(&self, ray: &RayF64, id: u32, sphere: &Sphere) -> Option<Vec3<f64>> {
        let foot = self.sphere_foot(ray, id, sphere)?;
        let RayOf { direction, a, inv_a, .. } = ray.ray;
        let p = foot.l - direction * (dot3(direction, foot.l) * inv_a);
        let m = dot3(p, p);
        let half_chord = |r2: f64| ((r2 - m).max(0.0) * inv_a).sqrt();
        let width = half_chord(foot.guard.outer2) - half_chord(foot.guard.inner2);
        let (r, l) = (foot.r, foot.distance);
        let error = guard::normal_error(r, l, width * a.sqrt(), guard::UNIT_F64, self.input);
        if error > NORMAL_TOLERANCE || foot.k.value.abs() <= foot.k.error {
            return None;
        }
        Some(normalized(half_chord_radius(&ray.ray, foot.l, r, foot.k.value > 0.0)))
    }

    /// Fills in `t` and normal of all rays whose object is known.
    pub fn fill_surfaces(&self, control: &Control, hits: &mut Hits) -> Result<()> {
        hits.id
            .par_chunks(RAYS_PER_CHUNK)
            .zip(hits.t.par_chunks_mut(RAYS_PER_CHUNK))
            .zip(hits.normal.par_chunks_mut(RAYS_PER_CHUNK))
            .enumerate()
            .try_for_each(|(chunk, ((ids, ts), normals))| {
                control.check()?;
                host::check()?;
                for (i, &id) in ids.iter().enumerate() {
                    if id != 0 && id != UNDECIDED {
                        let surface = self.surface(chunk * RAYS_PER_CHUNK + i, id);
                        (ts[i], normals[i]) = surface.unwrap_or((f32::INFINITY, [0.0; 3]));
                    }
                }
                Ok(())
            })
    }

    /// `t` and normal of a hit that is known to exist: in f64, else exactly.
    pub fn surface(&self, index: usize, id: u32) -> Option<Surface> {
        let object = self.scene.object(id)?;
        if let Some(surface) = self.surface_f64(&self.ray_f64(index), id, object) {
            return Some(surface);
        }
        let ray = self.exact_ray(index);
        let shape = Shape::from(object);
        let visible = visible_root(&ray, &shape);
        debug_assert!(visible.is_some(), "object {id} was decided for ray {index} but is not hit");
        let (root, side) = visible?;
        Some(exact_surface(&ray, &ExactHit { id, root, side }, &shape))
    }
}

pub fn exact_surface(ray: &ExactRay, hit: &ExactHit, shape: &Shape) -> Surface {
    (hit.t_f32(), hit.normal_f32(ray, shape))
}
