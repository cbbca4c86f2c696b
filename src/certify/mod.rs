//! What follows the certified kernel's f32 stage: f64 with the same filter, then exact arithmetic.
//! Undecided rays flow one way and never loop back.

mod decide;
mod in_balls;
mod point;
mod surfaces;

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use crate::control::Control;
use crate::engine::Find64;
use crate::error::Result;
use crate::exact::{ExactPixels, ExactRay};
use crate::guard;
use crate::host;
use crate::num::{Float, OPEN};
use crate::prepare::{Hierarchy, Prepared, exponent_of};
use crate::rays::Pixels;
use crate::scene::Scene;
use crate::trace::{Hits, Kernel, Level, Ray, Rays, StageCounts, Timing, Wants};
pub(crate) use decide::bits;
use surfaces::{MISS, PlaneF64};
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
) -> Result<Timing> {
    prepared.check(rays)?;
    hits.make_room(rays.len(), wants);
    hits.id.fill(OPEN);
    control.advance(rays.len() as u64);
    Ok(Timing::default())
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

/// The rays, as they are and exactly.
enum StageRays<'a> {
    Pixels { pixels: &'a Pixels, exact: Box<ExactPixels> },
    List(&'a [Ray]),
}

/// The stages after f32 for one scene and its rays.
pub(crate) struct Stage<'a> {
    scene: &'a Scene,
    rays: StageRays<'a>,
    /// Has the spheres that are not listed.
    hierarchy: Option<&'a Hierarchy>,
    /// Whether the bounds hold for these rays.
    usable: bool,
    planes: Vec<PlaneF64>,
    /// What f64 says of them.
    find: Find64<'a>,
}

impl<'a> Stage<'a> {
    pub(crate) fn new(prepared: &'a Prepared, rays: &'a Rays) -> Stage<'a> {
        let scene = &*prepared.scene;
        let find = Find64::new(prepared, rays);
        let (rays, usable) = match rays {
            Rays::Pixels(pixels) => (
                StageRays::Pixels { pixels, exact: Box::new(ExactPixels::new(pixels)) },
                pixels.is_in_range() && pixels.spread() <= f64::FARTHEST,
            ),
            Rays::List(rays) => (StageRays::List(rays), true),
        };
        let plane = |(index, plane)| PlaneF64 {
            is_repeated: prepared.repeats_a_plane(index),
            ..PlaneF64::new(plane)
        };
        let planes = scene.planes.iter().enumerate().map(plane).collect();
        let hierarchy = prepared.hierarchy.as_ref();
        Stage { scene, rays, hierarchy, usable, planes, find }
    }

    /// The numbers of the plane with this id.
    pub fn plane(&self, id: u32) -> &PlaneF64 {
        &self.planes[id as usize - 1 - self.scene.spheres.len()]
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
                        true => surfaces.round(first, id, room, t, normal),
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
