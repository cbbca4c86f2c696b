//! What follows the certified kernel's f32 stage: f64 with the same filter, then exact arithmetic.
//! Undecided rays flow one way and never loop back.

mod decide;
mod pack;
mod point;
mod surfaces;

use glam::DVec3;

use crate::bounds;
use crate::error::Result;
use crate::exact::ExactRays;
use crate::prepare::{LengthUnit, Prepared, exponent_of};
use crate::query::{Rays, StageCounts, WorldRay, places_of};
use crate::support::control::Control;
use crate::support::parallel;
use crate::visibility::Find64;
pub(crate) use pack::{Pack, PackF64, is_id};
use surfaces::MISS;
pub(crate) use surfaces::Surfaces;

/// Whether the `t` of the hits of a ray in this unit surely stays in f32's range.
pub fn is_ordinary(ray: &WorldRay, unit: LengthUnit) -> bool {
    let exponent = exponent_of(ray.direction);
    exponent.abs() <= bounds::LARGEST_EXPONENT
        && unit.exponent() - exponent <= bounds::LARGEST_SHIFT
        && ray.direction != DVec3::ZERO
}

/// The objects of rays that f32 left undecided.
#[derive(Debug, Default)]
pub struct Decided {
    /// The objects' ids, one a ray; 0 is the background.
    pub ids: Vec<u32>,
    /// Places among them of those that exact arithmetic decided. The others were decided in f64.
    pub exactly: Vec<usize>,
}

impl Decided {
    /// How many of `n_rays` each stage decided, where f32 left none but these.
    pub fn counts(&self, n_rays: usize) -> StageCounts {
        let [n_left, n_exact] = [self.ids.len(), self.exactly.len()];
        let [f32, f64, exact] = [n_rays - n_left, n_left - n_exact, n_exact].map(|n| n as u64);
        StageCounts { f32, f64, exact }
    }
}

/// The stages after f32 for one scene and its rays.
pub(crate) struct Resolver<'a> {
    prepared: &'a Prepared,
    rays: &'a Rays,
    exact: ExactRays<'a>,
    /// What f64 says of them.
    find: Find64<'a>,
}

impl<'a> Resolver<'a> {
    pub(crate) fn new(prepared: &'a Prepared, rays: &'a Rays) -> Resolver<'a> {
        Resolver { prepared, rays, exact: rays.into(), find: Find64::new(prepared, rays) }
    }

    /// Fills in `t` and normals of the rays from `first` on, which see these objects: in f64, with more digits, and exactly.
    ///
    /// `room` is what it works in, from call to call.
    pub fn complete(
        &self,
        surfaces: &Surfaces<f64>,
        (first, ids): (usize, &[u32]),
        (t, normal): (&mut [f32], &mut [[f32; 3]]),
        control: &Control,
        room: &mut Vec<PackF64>,
    ) -> Result<()> {
        surfaces.round(first, ids, room, t, normal);
        let open: Vec<usize> = places_of(0.0, t).collect();
        let surface = |&at: &usize| {
            control.check()?;
            Ok(self.surface(first + at, ids[at]).unwrap_or(MISS))
        };
        for (&at, found) in open.iter().zip(parallel::try_map(&open, surface)?) {
            (t[at], normal[at]) = found;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
