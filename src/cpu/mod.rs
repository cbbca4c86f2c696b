//! What the CPU finds of a kernel's stage: rows in parallel.

mod plain;
mod squares;

use std::time::Instant;

use rayon::prelude::*;

use crate::control::Control;
use crate::engine::{LARGEST, List, ListSearch, Room, Search};
use crate::error::Result;
use crate::host;
use crate::kernel::Kernel;
use crate::prepare::Prepared;
use crate::rays::{Pixels, Ray, Rays};
use crate::trace::{Hits, Timing, Wants};
pub use squares::Squares;

/// Rays that one thread takes at a time from a list.
const RAYS_PER_CHUNK: usize = 4096;

/// What a kernel itself sees: [`Tracer::propose`](crate::tracer::Tracer::propose).
///
/// # Errors
/// Those of [`Prepared::check`]; [`crate::Error::Interrupted`].
pub fn propose(
    prepared: &Prepared,
    wants: Wants,
    rays: &Rays,
    control: &Control,
    hits: &mut Hits,
) -> Result<Timing> {
    let start = Instant::now();
    prepared.check(rays)?;
    hits.make_room(rays.len(), wants);
    match (prepared.kernel, rays) {
        _ if rays.is_empty() => {}
        (Kernel::Certified, Rays::Pixels(pixels)) => search(prepared, pixels, control, hits)?,
        (Kernel::Certified, Rays::List(rays)) => search_list(prepared, rays, control, hits)?,
        _ => plain::trace(prepared, rays, control, hits)?,
    }
    Ok(Timing { trace: start.elapsed(), ..Timing::default() })
}

/// The certified kernel's f32 stage for pixels.
fn search(prepared: &Prepared, pixels: &Pixels, control: &Control, hits: &mut Hits) -> Result<()> {
    let search = Search::new(prepared, pixels, 1);
    let strips = hits.id.par_chunks_mut(LARGEST as usize * pixels.width as usize).enumerate();
    strips.try_for_each_init(Room::default, |room, (strip, ids)| {
        control.check()?;
        host::check()?;
        search.look(strip as u32 * LARGEST, ids, room);
        control.advance(ids.len() as u64);
        Ok(())
    })
}

/// The certified kernel's f32 stage for a list of rays.
fn search_list(
    prepared: &Prepared,
    rays: &[Ray],
    control: &Control,
    hits: &mut Hits,
) -> Result<()> {
    let search = ListSearch::new(prepared);
    let chunks = rays.par_chunks(RAYS_PER_CHUNK).zip(hits.id.par_chunks_mut(RAYS_PER_CHUNK));
    chunks.try_for_each(|(rays, ids)| {
        control.check()?;
        host::check()?;
        search.look(List::new(rays, prepared.reference), ids);
        control.advance(ids.len() as u64);
        Ok(())
    })
}
