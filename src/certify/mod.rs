//! What follows the certified kernel's f32 stage: f64 with the same filter, then exact arithmetic.
//! Undecided rays flow one way and never loop back.

mod decide;
mod in_balls;
mod nearness;
mod point;
mod surfaces;
mod walk;

use std::collections::HashMap;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use crate::control::Control;
use crate::error::Result;
use crate::exact::{ExactPixels, ExactRay};
use crate::guard::{self, InputError};
use crate::host;
use crate::kernel::RayOf;
use crate::kernel::certified::FEW_SPHERES;
use crate::kernel::certified::Widening;
use crate::num::{Float, OPEN};
use crate::prepare::{Hierarchy, Prepared, Scaled, exponent_of, power_of_two};
use crate::rays::{Bundle, CameraF64, Pixels};
use crate::scene::Scene;
use crate::trace::{Hits, Kernel, Level, Ray, Rays, StageCounts, Timing, Wants};
use crate::vec3::Vec3;
use decide::MOST_HELD;
pub(crate) use decide::bits;
use nearness::Foot;
pub(crate) use nearness::{K, PlaneF64};
use surfaces::{InF32, MISS};
pub(crate) use surfaces::{Pack, Surfaces, is_id};

/// Whether the `t` of a ray's hits surely stays in f32's range.
fn is_ordinary(ray: &Ray) -> bool {
    exponent_of(ray.direction).abs() <= guard::LARGEST_EXPONENT && ray.direction != DVec3::ZERO
}

/// Decides what `prepared`'s kernel left open and fills in `t` and normals, for the certified
/// kernel; for the others it only counts.
pub fn resolve(
    prepared: &Prepared,
    rays: &Rays,
    wants: Wants,
    control: &Control,
    hits: &mut Hits,
    mut timing: Timing,
) -> Result<Timing> {
    let n_rays = rays.len() as u64;
    hits.counts = StageCounts { f32: n_rays, ..StageCounts::default() };
    match prepared.kernel {
        Kernel::Lecture | Kernel::Stable => return Ok(timing),
        Kernel::Double => {
            hits.counts = StageCounts { f64: n_rays, ..StageCounts::default() };
            hits.level.fill(Level::F64 as u8);
            return Ok(timing);
        }
        Kernel::Certified => {}
    }
    let stage = Stage::new(prepared, rays);
    let start = Instant::now();
    let undecided = open_rays(prepared, rays, hits)?;
    timing.refine = start.elapsed();

    // The exact stage gives the surfaces with the ids; they are not looked for again.
    let mut exact = Vec::new();
    stage.decide(&undecided, wants, control, &mut timing, |ray, settled| {
        match wants.surface && settled.level == Level::Exact {
            true => exact.push((ray, settled)),
            false => store(settled, ray as usize, wants, hits),
        }
    })?;
    if wants.surface {
        let start = Instant::now();
        stage.fill_surfaces(control, hits)?;
        timing.refine += start.elapsed();
    }
    for (ray, settled) in exact {
        store(settled, ray as usize, wants, hits);
    }
    Ok(timing)
}

fn listed_open(hits: &Hits) -> Vec<u32> {
    hits.id.par_chunks(RAYS_PER_PART).enumerate().flat_map_iter(open_of_part).collect()
}

fn open_of_part((part, ids): (usize, &[u32])) -> impl Iterator<Item = u32> {
    // Hardly a part has one. All are looked at, which several at a time can be.
    let has_open = ids.iter().fold(false, |any, &id| any | (id == OPEN));
    let ids = if has_open { ids } else { &[] };
    let first = (part * RAYS_PER_PART) as u32;
    (first..).zip(ids).filter(|&(_, &id)| id == OPEN).map(|(ray, _)| ray)
}

/// The rays that f32 does not decide, which have no id from here on.
fn open_rays(prepared: &Prepared, rays: &Rays, hits: &mut Hits) -> Result<Vec<u32>> {
    let undecided = undecided(prepared, rays, || Ok(listed_open(hits)))?;
    for &ray in &undecided {
        hits.id[ray as usize] = OPEN;
    }
    Ok(undecided)
}

/// Leaves all rays of a scene that starts in f64 open, without asking f32.
///
/// # Errors
/// Those of [`Prepared::check`].
pub fn leave_open(
    prepared: &Prepared,
    rays: &Rays,
    wants: Wants,
    control: &Control,
    hits: &mut Hits,
) -> Result<()> {
    prepared.check(rays)?;
    hits.make_room(rays.len(), wants);
    hits.id.fill(OPEN);
    control.advance(rays.len() as u64);
    Ok(())
}

/// The rays that f64 or exact arithmetic must decide, ascending: those that the backend left open,
/// which `listed` gives, and those whose f32 proposal counts for nothing, as its bounds don't hold or
/// as `t` could leave f32's range because the direction is very short or long.
///
/// # Errors
/// Those of `listed`.
pub fn undecided(
    prepared: &Prepared,
    rays: &Rays,
    listed: impl FnOnce() -> Result<Vec<u32>>,
) -> Result<Vec<u32>> {
    if prepared.kernel != Kernel::Certified {
        return Ok(Vec::new());
    }
    if !prepared.in_range {
        return Ok((0..rays.len() as u32).collect());
    }
    let mut undecided = listed()?;
    if let Rays::List(rays) = rays
        && undecided.len() < rays.len()
    {
        undecided.extend((0..).zip(rays).filter(|(_, ray)| !is_ordinary(ray)).map(|(at, _)| at));
        undecided.sort_unstable();
        undecided.dedup();
    }
    Ok(undecided)
}

/// The object of a ray that f32 left undecided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decided {
    /// Index of the ray.
    pub ray: u32,
    /// Its object; 0 is the background.
    pub id: u32,
    /// The stage that decided it.
    pub level: Level,
}

/// Decides some of the rays that [`undecided`] gave, for those who look at some alone.
///
/// # Errors
/// [`crate::Error::Interrupted`] when `control` was cancelled.
pub fn decide(
    prepared: &Prepared,
    rays: &Rays,
    undecided: &[u32],
    control: &Control,
) -> Result<Vec<Decided>> {
    let mut all = Vec::with_capacity(undecided.len());
    let stage = Stage::new(prepared, rays);
    let wants = Wants::default();
    stage.decide(undecided, wants, control, &mut Timing::default(), |ray, settled| {
        all.push(Decided { ray, id: settled.id, level: settled.level });
    })?;
    Ok(all)
}

/// Rays that one thread completes at a time.
const RAYS_PER_PART: usize = 1 << 13;

fn store(settled: Settled, index: usize, wants: Wants, hits: &mut Hits) {
    hits.id[index] = settled.id;
    if wants.surface {
        hits.t[index] = settled.t;
        hits.normal[index] = settled.normal;
    }
    if wants.level {
        hits.level[index] = settled.level as u8;
    }
    hits.counts.f32 -= 1;
    match settled.level {
        Level::Exact => hits.counts.exact += 1,
        _ => hits.counts.f64 += 1,
    }
}

/// One ray's result.
pub(crate) struct Settled {
    id: u32,
    /// Like the normal, that of a miss unless exact arithmetic decided.
    t: f32,
    normal: [f32; 3],
    level: Level,
}

/// What the bounds of all hits of a picture share.
#[derive(Clone, Copy)]
struct Bounds {
    widening: Widening<f64>,
    input: InputError,
}

/// The rays, in f64 and exactly.
enum StageRays<'a> {
    Pixels { pixels: &'a Pixels, camera: CameraF64, exact: Box<ExactPixels> },
    List(&'a [Ray]),
}

/// The stages after f32 for one scene and its rays.
pub(crate) struct Stage<'a> {
    prepared: &'a Prepared,
    scene: &'a Scene,
    rays: StageRays<'a>,
    /// Finds the spheres that are not in `rest`.
    hierarchy: Option<&'a Hierarchy>,
    /// For pixels: `k` of each sphere for the camera's position; none with a hierarchy.
    ks: Vec<K>,
    /// The same of [`Hierarchy::rest`], where `k` may be hard to come by.
    rest_ks: HashMap<u32, K>,
    /// Whether the bounds hold for these rays.
    usable: bool,
    /// Whether all rays start at the camera's position.
    has_one_origin: bool,
    bounds: Bounds,
    /// Few spheres as all rays from the camera's position see them; `None` out of range.
    feet: Vec<Option<Foot>>,
    planes: Vec<PlaneF64>,
    /// [`decide::MOST_HELD`]
    most_held: usize,
}

/// A ray in f64: `reference + o + 2^−exponent·t·direction`.
pub(crate) struct RayF64 {
    /// The camera's position, or the origin of a list's ray.
    reference: DVec3,
    /// Its origin is the zero vector but for parallel rays.
    ray: RayOf<f64>,
    exponent: i32,
}

impl RayF64 {
    /// `p − reference − o`, in this order: the sum of the latter two would lose what they differ in.
    #[inline(always)]
    fn to_point(&self, point: DVec3) -> Vec3<f64> {
        Vec3::from(point - self.reference) - self.ray.origin
    }

    /// `ℓ` of [`guard`]: a bound of the distance of a point.
    #[inline(always)]
    fn distance(&self, point: DVec3) -> f64 {
        guard::length_bound(point - self.reference) + self.origin_length()
    }

    /// What a `t` along the scaled direction is multiplied with.
    #[inline(always)]
    fn scale(&self) -> f64 {
        power_of_two(-self.exponent)
    }

    #[inline(always)]
    fn origin_length(&self) -> f64 {
        guard::length_bound(DVec3::from_array(self.ray.origin.0))
    }
}

impl<'a> Stage<'a> {
    pub(crate) fn new(prepared: &'a Prepared, rays: &'a Rays) -> Stage<'a> {
        let scene = &*prepared.scene;
        let hierarchy = prepared.hierarchy.as_ref();
        let k = |sphere| K::new(prepared.reference, sphere);
        let (rays, ks, usable, input) = match rays {
            Rays::Pixels(pixels) => (
                StageRays::Pixels {
                    pixels,
                    camera: CameraF64::new(pixels),
                    exact: Box::new(ExactPixels::new(pixels)),
                },
                match hierarchy {
                    None => scene.spheres.iter().map(k).collect(),
                    Some(_) => Vec::new(),
                },
                pixels.is_in_range() && pixels.spread() <= f64::FARTHEST,
                guard::input_of(pixels.view.lens),
            ),
            Rays::List(rays) => (StageRays::List(rays), Vec::new(), true, guard::LIST_F64),
        };
        let rest = hierarchy.map_or(&[][..], |hierarchy| &hierarchy.rest);
        let rest_ks = match rays {
            StageRays::Pixels { .. } => {
                rest.iter().map(|&id| (id, k(&scene.spheres[id as usize - 1]))).collect()
            }
            StageRays::List(_) => HashMap::new(),
        };
        let has_one_origin = prepared.bundle() == Bundle::Point;
        let bounds = Bounds { widening: guard::widening_f64(), input };
        let plane = |(index, plane)| {
            let mut plane = PlaneF64::new(plane, input);
            plane.is_repeated = prepared.repeats_a_plane(index);
            plane
        };
        let planes = scene.planes.iter().enumerate().map(plane).collect();
        let mut stage = Stage {
            prepared,
            scene,
            rays,
            hierarchy,
            ks,
            rest_ks,
            usable,
            has_one_origin,
            bounds,
            feet: Vec::new(),
            planes,
            most_held: MOST_HELD,
        };
        if let Some(any) = stage.ray_of_all().filter(|_| scene.spheres.len() <= FEW_SPHERES) {
            let foot = |(id, sphere)| stage.sphere_foot(&any, id, sphere);
            stage.feet = (1..).zip(scene.spheres.iter()).map(foot).collect();
        }
        stage
    }

    /// A ray from where all rays start, if they do start at one point.
    fn ray_of_all(&self) -> Option<RayF64> {
        match &self.rays {
            StageRays::Pixels { pixels, .. } if self.has_one_origin => {
                let ray = RayOf::new(Vec3::ZERO, Vec3::ZERO, Vec3::from(DVec3::X));
                Some(RayF64 { reference: pixels.view.position, ray, exponent: 0 })
            }
            _ => None,
        }
    }

    #[inline(always)]
    fn ray_f64(&self, index: usize) -> RayF64 {
        match &self.rays {
            StageRays::Pixels { pixels, camera, .. } => {
                let (x, y) = pixels.xy(index);
                let (i, j) = pixels.offset2(x, y);
                let ray = camera.camera_ray(i as f64, j as f64);
                RayF64 { reference: pixels.view.position, ray, exponent: 0 }
            }
            StageRays::List(rays) => {
                let Ray { origin, direction } = rays[index];
                let scaled = Scaled::new(direction);
                let ray = RayOf::new(Vec3::ZERO, Vec3::ZERO, scaled.rounded().into());
                RayF64 { reference: origin, ray, exponent: scaled.exponent() }
            }
        }
    }

    /// Fills in `t` and normal of all rays but undecided ones.
    fn fill_surfaces(&self, control: &Control, hits: &mut Hits) -> Result<()> {
        let surfaces = Surfaces::to_be_rounded(self);
        hits.id
            .par_chunks(RAYS_PER_PART)
            .zip(hits.t.par_chunks_mut(RAYS_PER_PART))
            .zip(hits.normal.par_chunks_mut(RAYS_PER_PART))
            .enumerate()
            .try_for_each_init(
                || (host::check(), Vec::new()),
                |(checked, room), (part, ((id, t), normal))| {
                    std::mem::replace(checked, Ok(()))?;
                    control.check()?;
                    let first = part * RAYS_PER_PART;
                    match surfaces.are_known() {
                        true => surfaces.find(first, id, room, &mut InF32 { t, normal }),
                        false => t.fill(0.0),
                    }
                    if !t.contains(&0.0) {
                        return Ok(());
                    }
                    for (at, &id) in id.iter().enumerate() {
                        if t[at] == 0.0 && id != OPEN {
                            control.check()?;
                            (t[at], normal[at]) = self.surface(first + at, id).unwrap_or(MISS);
                        }
                    }
                    Ok(())
                },
            )
    }

    fn exact_ray(&self, index: usize) -> ExactRay {
        match &self.rays {
            StageRays::Pixels { pixels, exact, .. } => {
                let (x, y) = pixels.xy(index);
                exact.ray(x, y)
            }
            StageRays::List(rays) => ExactRay::new(&rays[index]),
        }
    }
}

#[cfg(test)]
mod tests;
