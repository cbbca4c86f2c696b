//! What rays see by a kernel without a proof.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use pulp::{Simd, WithSimd};

use super::{Strip, parts};
use crate::error::Result;
use crate::kernel::baseline::{Baseline, BaselineRays, LANES};
use crate::kernel::{Lists, ObjectRecords};
use crate::num::{Bits, Float, dispatch};
use crate::prepare::Prepared;
use crate::query::Hits;
use crate::rays::Rays;
use crate::support::control::Control;
use crate::support::parallel;

/// Finds all objects, and `t` and normals where they are wanted.
pub fn trace(prepared: &Prepared, rays: &Rays, control: &Control, hits: &mut Hits) -> Result<()> {
    match &prepared.objects {
        ObjectRecords::Lecture(lists) => trace_with(lists, prepared, rays, control, hits),
        ObjectRecords::Stable(lists) => trace_with(lists, prepared, rays, control, hits),
        ObjectRecords::Double(lists) => trace_with(lists, prepared, rays, control, hits),
        ObjectRecords::Certified { .. } => Ok(()),
    }
}

fn trace_with<S: Baseline, P: Baseline<Float = S::Float>>(
    lists: &Lists<S, P>,
    prepared: &Prepared,
    rays: &Rays,
    control: &Control,
    hits: &mut Hits,
) -> Result<()> {
    // Rays of a row are in packs.
    let parts = parts(rays, 1, hits);
    let rays = &BaselineRays::new(prepared.coordinates(), rays);
    let trace = |part: Strip| {
        let n_rays = part.ids.len() as u64;
        dispatch(Trace { lists, rays, control, part })?;
        control.advance(n_rays);
        Ok(())
    };
    parallel::try_map(parts, trace).map(drop)
}

/// Consecutive rays, compiled for each instruction set that the processor may have.
struct Trace<'a, S: Baseline, P> {
    lists: &'a Lists<S, P>,
    rays: &'a BaselineRays<'a, S::Float>,
    control: &'a Control,
    part: Strip<'a>,
}

impl<S: Baseline, P: Baseline<Float = S::Float>> WithSimd for Trace<'_, S, P> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Result<()> {
        let Trace { lists, rays, control, part } = self;
        let Strip { first, ids, t, normal, .. } = part;
        // In f64 what f32 can't hold is a miss.
        let misses_infinity = S::Float::UNIT < f32::UNIT;
        for start in (0..ids.len()).step_by(LANES) {
            // A ray may have millions of spheres to look at.
            control.check()?;
            let ray = rays.pack::<LANES>(first + start);
            let hit = lists.closest(&ray);
            let (mut all, mut ts) = ([0; LANES], [f32::INFINITY; LANES]);
            let scales = rays.scales::<LANES>(first + start);
            for lane in 0..LANES {
                all[lane] = hit.id.0[lane].to_id();
                ts[lane] = (hit.t.0[lane].to_f64() * scales[lane]) as f32;
            }
            let here = start..ids.len().min(start + LANES);
            if misses_infinity {
                for lane in 0..LANES {
                    all[lane] = if ts[lane] < f32::INFINITY { all[lane] } else { 0 };
                }
            }
            ids[here.clone()].copy_from_slice(&all[..here.len()]);
            if t.is_empty() {
                continue;
            }
            t[here.clone()].copy_from_slice(&ts[..here.len()]);
            let (_, found) = lists.surfaces(&ray, &hit.id);
            let mut rounded = [[0.0; 3]; LANES];
            for lane in 0..LANES {
                for axis in 0..3 {
                    let is_hit = all[lane] != 0;
                    rounded[lane][axis] =
                        if is_hit { found.0[axis].0[lane].to_f64() as f32 } else { 0.0 };
                }
            }
            normal[here.clone()].copy_from_slice(&rounded[..here.len()]);
        }
        Ok(())
    }
}
