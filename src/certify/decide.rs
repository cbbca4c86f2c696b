//! The rays that f32 left undecided: in f64, and what is left exactly.

use std::time::Instant;

use rayon::prelude::*;

use super::surfaces::MISS;
use super::{Settled, Stage};
use crate::control::Control;
use crate::engine::{Candidates, Said, Tile};
use crate::error::Result;
use crate::exact::{Shape, nearest};
use crate::host;
use crate::num::OPEN;
use crate::scene::Object;
use crate::trace::{Level, Timing, Wants};
use glam::DVec3;

/// Undecided rays that are looked at before they are settled.
const RAYS_AT_ONCE: usize = 1 << 16;

/// Rays that one thread decides at a time.
const RAYS_PER_PART: usize = 1 << 10;

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
        let (mut ids, mut open) = (Vec::new(), Vec::new());
        for rays in undecided.chunks(RAYS_AT_ONCE) {
            let start = Instant::now();
            ids.resize(rays.len(), OPEN);
            self.decide_f64(rays, control, &mut ids)?;
            open.clear();
            for (&ray, &id) in rays.iter().zip(&ids) {
                match id {
                    OPEN => open.push(ray),
                    id => store(ray, Settled::in_f64(id)),
                }
            }
            timing.refine += start.elapsed();

            let start = Instant::now();
            let begin = || (host::check(), Candidates::default());
            let one = |(checked, candidates): &mut (Result<()>, Candidates), &ray: &u32| {
                std::mem::replace(checked, Ok(()))?;
                control.check()?;
                Ok(self.settle(ray as usize, candidates, wants))
            };
            let settled = open.par_iter().map_init(begin, one).collect::<Result<Vec<Settled>>>()?;
            for (&ray, settled) in open.iter().zip(settled) {
                store(ray, settled);
            }
            timing.decide += start.elapsed();
        }
        Ok(())
    }

    /// The ids of some rays in f64, [`OPEN`] where they are left open.
    pub fn decide_f64(&self, rays: &[u32], control: &Control, ids: &mut [u32]) -> Result<()> {
        let parts = rays.par_chunks(RAYS_PER_PART).zip(ids.par_chunks_mut(RAYS_PER_PART));
        let begin = || (Tile::default(), Candidates::default());
        parts.try_for_each_init(begin, |(tile, candidates), (rays, ids)| {
            host::check()?;
            if self.find.is_listed() {
                control.check()?;
                self.find.decide(rays, tile, ids);
                return Ok(());
            }
            for (&ray, id) in rays.iter().zip(ids) {
                // A ray may have millions of spheres to look at.
                control.check()?;
                *id = match self.find.look(ray as usize, candidates) {
                    Said::Sees(id) => id,
                    Said::Open(_) => OPEN,
                };
            }
            Ok(())
        })
    }

    /// What a ray sees, exactly where f64 leaves it open.
    fn settle(&self, index: usize, candidates: &mut Candidates, wants: Wants) -> Settled {
        let found = match self.find.look(index, candidates) {
            Said::Sees(id) => return Settled::in_f64(id),
            Said::Open(found) => found,
        };
        let (t, normal) = MISS;
        let level = Level::Exact;
        let miss = Settled { id: 0, t, normal, level };
        let ray = self.exact_ray(index);
        let shape = |&(id, _): &(u32, f64)| Some((id, Shape::from(self.scene.object(id)?)));
        match nearest(&ray, found.iter().filter_map(shape)) {
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
