//! The rays that f32 left undecided: in f64, and what is left exactly.

use std::collections::HashSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::surfaces::MISS;
use super::walk::Walks;
use super::{RayF64, Settled, Stage, StageRays};
use crate::control::Control;
use crate::engine::{Find64, Tile};
use crate::error::Result;
use crate::exact::{Shape, nearest};
use crate::guard;
use crate::host;
use crate::kernel::certified::Nearness;
use crate::num::OPEN;
use crate::prepare::{Hierarchy, Seen};
use crate::scene::Object;
use crate::trace::{Level, Timing, Wants};
use crate::tree::TreeRay;
use crate::vec3::Vec3;

/// Undecided rays that are looked at before they are settled.
const RAYS_AT_ONCE: usize = 1 << 16;

/// Candidates that are held for them together: every object may be a candidate of every ray.
pub const MOST_HELD: usize = 1 << 22;

fn each_ray<T: Send>(
    rays: &[u32],
    control: &Control,
    work: impl Fn(usize, &mut Candidates) -> T + Sync,
) -> Result<Vec<T>> {
    let begin = || (host::check(), Candidates::default());
    let one = |(checked, candidates): &mut (Result<()>, Candidates), &ray: &u32| {
        std::mem::replace(checked, Ok(()))?;
        control.check().map(|()| work(ray as usize, candidates))
    };
    rays.par_iter().map_init(begin, one).collect()
}

fn each_pair<A: Send, T: Send>(
    rays: &[u32],
    others: Vec<A>,
    control: &Control,
    work: impl Fn(usize, A) -> T + Sync,
) -> Result<Vec<T>> {
    let one = |checked: &mut Result<()>, (&ray, other): (&u32, A)| {
        std::mem::replace(checked, Ok(()))?;
        control.check().map(|()| work(ray as usize, other))
    };
    rays.par_iter().zip(others).map_init(host::check, one).collect()
}

/// What the f64 filter says of a ray.
pub enum Decision {
    /// The object, 0 for the background.
    Decided(u32),
    /// Any of these, or none.
    Open(Vec<u32>),
}

impl Decision {
    /// Itself, where `room` has places for its candidates: it takes them. What is not held is
    /// looked for again.
    pub fn hold(self, room: &AtomicUsize) -> Option<Decision> {
        let Decision::Open(candidates) = &self else { return Some(self) };
        let take = |left: usize| left.checked_sub(candidates.len());
        let fits = room.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take).is_ok();
        fits.then_some(self)
    }
}

/// Rays that one thread decides in a quicker way at a time.
const RAYS_PER_PART: usize = 1 << 10;

/// A quicker way to the ids of many rays, of which it leaves some open.
pub enum Quick<'a> {
    Few(Find64<'a>),
    Walks(&'a Hierarchy),
}

/// More objects than this are found through a hierarchy where there is one.
const MOST_LISTED: usize = 64;

impl<'a> Quick<'a> {
    pub fn new(stage: &'a Stage<'a>) -> Option<Quick<'a>> {
        let is_listed = stage.hierarchy.is_none() || stage.scene.n_objects() <= MOST_LISTED;
        match (stage.hierarchy, &stage.rays) {
            (Some(hierarchy), StageRays::List(_)) => Some(Quick::Walks(hierarchy)),
            (_, StageRays::Pixels { pixels, .. }) if stage.usable && is_listed => {
                Some(Quick::Few(Find64::new(stage.prepared, pixels)))
            }
            _ => None,
        }
    }

    /// The ids of `rays`, [`OPEN`] where they are left open.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn decide(
        &self,
        stage: &Stage,
        rays: &[u32],
        control: &Control,
        ids: &mut [u32],
    ) -> Result<()> {
        let parts = rays.par_chunks(RAYS_PER_PART).zip(ids.par_chunks_mut(RAYS_PER_PART));
        parts.try_for_each_init(Tile::default, |tile, (rays, ids)| {
            control.check()?;
            host::check()?;
            match *self {
                Quick::Few(ref few) => {
                    few.decide(rays, tile, ids);
                    Ok(())
                }
                Quick::Walks(hierarchy) => {
                    pulp::Arch::new().dispatch(Walks { stage, hierarchy, rays, control, ids })
                }
            }
        })
    }
}

impl Settled {
    /// A ray's object that f64 decided; its hit is not complete yet.
    pub fn in_f64(id: u32) -> Settled {
        Settled { id, t: 0.0, normal: [0.0; 3], level: Level::F64 }
    }
}

impl Stage<'_> {
    /// Decides `undecided` rays: in f64, and what is left exactly.
    pub fn decide(
        &self,
        undecided: &[u32],
        wants: Wants,
        control: &Control,
        timing: &mut Timing,
        mut store: impl FnMut(u32, Settled),
    ) -> Result<()> {
        let start = Instant::now();
        let quick = Quick::new(self);
        let (mut ids, mut open) = (Vec::new(), Vec::new());
        timing.refine += start.elapsed();
        for rays in undecided.chunks(RAYS_AT_ONCE) {
            let start = Instant::now();
            let mut open_rays = rays;
            if let Some(quick) = &quick {
                ids.resize(rays.len(), OPEN);
                quick.decide(self, rays, control, &mut ids)?;
                open.clear();
                for (&ray, &id) in rays.iter().zip(&ids) {
                    match id {
                        OPEN => open.push(ray),
                        id => store(ray, Settled::in_f64(id)),
                    }
                }
                open_rays = &open;
            }
            timing.refine += start.elapsed();
            self.decide_one_by_one(open_rays, wants, control, timing, &mut store)?;
        }
        Ok(())
    }

    /// The same, one ray after the other.
    fn decide_one_by_one(
        &self,
        rays: &[u32],
        wants: Wants,
        control: &Control,
        timing: &mut Timing,
        mut store: impl FnMut(u32, Settled),
    ) -> Result<()> {
        let start = Instant::now();
        let room = AtomicUsize::new(self.most_held);
        let decisions = each_ray(rays, control, |ray, candidates| {
            self.decide_f64(ray, candidates).hold(&room)
        })?;
        timing.refine += start.elapsed();

        let start = Instant::now();
        let settled = each_pair(rays, decisions, control, |ray, decision| {
            match decision.unwrap_or_else(|| self.decide_f64(ray, &mut Candidates::default())) {
                Decision::Decided(id) => Settled::in_f64(id),
                Decision::Open(candidates) => self.settle(ray, &candidates, wants),
            }
        })?;
        for (&ray, settled) in rays.iter().zip(settled) {
            store(ray, settled);
        }
        timing.decide += start.elapsed();
        Ok(())
    }

    /// The filter again, in f64: keeps the candidates that could be nearest.
    pub fn decide_f64(&self, index: usize, candidates: &mut Candidates) -> Decision {
        let ray = self.ray_f64(index);
        if ray.ray.direction == Vec3::ZERO {
            return Decision::Decided(0);
        }
        candidates.clear();
        let mut consider = |id: u32| {
            if let Some(object) = self.scene.object(id) {
                candidates.add(id, self.nearness(&ray, id, object));
            }
            candidates.nearest_low
        };
        match self.hierarchy {
            Some(hierarchy) if self.usable => {
                let planes = self.scene.spheres.len()..self.scene.n_objects();
                for id in planes.map(|index| index as u32 + 1) {
                    consider(id);
                }
                for &id in &hierarchy.rest {
                    consider(id);
                }
                self.search(hierarchy, index, &ray, consider);
            }
            _ => {
                for id in 1..=self.scene.n_objects() as u32 {
                    consider(id);
                }
            }
        }
        match self.without_repeats(candidates.finish()) {
            [] => Decision::Decided(0),
            [(id, root)] if self.to_f32(&ray, *root).is_some() => Decision::Decided(*id),
            open => Decision::Open(open.iter().map(|(id, _)| *id).collect()),
        }
    }

    /// Without candidates that equal an earlier one: of equals, the lowest id wins.
    fn without_repeats<'c>(
        &self,
        candidates: &'c mut Vec<(u32, Nearness<f64>)>,
    ) -> &'c [(u32, Nearness<f64>)] {
        if candidates.len() > 1 {
            let mut seen = HashSet::with_capacity(candidates.len());
            candidates
                .retain(|(id, _)| self.scene.object(*id).is_some_and(|o| seen.insert(bits(o))));
        }
        candidates
    }

    /// Shows `consider` the ids of the spheres that the ray may hit, nearer ones first; it returns a lower
    /// bound of the nearness that is still of interest.
    fn search(
        &self,
        hierarchy: &Hierarchy,
        index: usize,
        ray: &RayF64,
        mut consider: impl FnMut(u32) -> f64,
    ) {
        if let (Some(seen), StageRays::Pixels { pixels, .. }) = (&hierarchy.seen, &self.rays) {
            let Seen { footprints, far } = seen;
            let (x, y) = pixels.xy(index);
            footprints.visit(footprints.cells([x, y], [x, y]), f32::INFINITY, |_, place| {
                guard::round_up(t_bound(ray, consider(far[place].id)))
            });
            return;
        }
        let tree = &*hierarchy.tree;
        let origin = ray.reference - tree.reference;
        if !origin.is_finite() {
            // So far away that f64 can't say where.
            tree.order.iter().for_each(|&index| {
                consider(index + 1);
            });
            return;
        }
        let direction = DVec3::from_array(ray.ray.direction.0);
        tree.visit(&TreeRay { origin, direction }, |place| {
            t_bound(ray, consider(tree.order[place] + 1))
        });
    }

    /// The nearest of the candidates.
    pub(super) fn settle(&self, index: usize, candidates: &[u32], wants: Wants) -> Settled {
        let (t, normal) = MISS;
        let level = Level::Exact;
        let miss = Settled { id: 0, t, normal, level };
        let ray = self.exact_ray(index);
        let shapes =
            candidates.iter().filter_map(|&id| Some((id, Shape::from(self.scene.object(id)?))));
        match nearest(&ray, shapes) {
            None => miss,
            Some(hit) if !wants.surface => Settled { id: hit.id, ..miss },
            // As for the rays that f64 decides, so that a hit's numbers don't tell its stage.
            Some(hit) => {
                let (t, normal) = self.surface(index, hit.id).unwrap_or(MISS);
                Settled { id: hit.id, t, normal, level }
            }
        }
    }
}

/// Objects that could be the nearest.
#[derive(Default)]
pub struct Candidates {
    nearest_low: f64,
    roots: Vec<(u32, Nearness<f64>)>,
}

impl Candidates {
    fn add(&mut self, id: u32, root: Nearness<f64>) {
        if root.high > 0.0 && root.high >= self.nearest_low {
            self.nearest_low = f64::max(self.nearest_low, root.low);
            self.roots.push((id, root));
        }
    }

    /// Those that still could, in the order of their ids, as ties are decided.
    fn finish(&mut self) -> &mut Vec<(u32, Nearness<f64>)> {
        self.roots.retain(|(_, root)| root.high >= self.nearest_low);
        self.roots.sort_unstable_by_key(|(id, _)| *id);
        &mut self.roots
    }

    /// None, for another ray.
    fn clear(&mut self) {
        self.nearest_low = 0.0;
        self.roots.clear();
    }
}

/// An upper bound of `t = 1/(a·w)` for a nearness `w` of at least `low`.
fn t_bound(ray: &RayF64, low: f64) -> f64 {
    guard::widening_f64().wider / (ray.ray.a * low)
}

/// The numbers of an object, the same for equal ones; a plane's radius is one that no sphere has.
pub fn bits(object: Object) -> [u64; 7] {
    let (at, normal, radius) = match object {
        Object::Sphere(sphere) => (sphere.center, DVec3::ZERO, sphere.radius),
        Object::Plane(plane) => (plane.point, plane.normal, f64::NAN),
    };
    let [x, y, z] = at.to_array().map(f64::to_bits);
    let [nx, ny, nz] = normal.to_array().map(f64::to_bits);
    [x, y, z, nx, ny, nz, radius.to_bits()]
}
