//! What the CPU finds: parts of a picture's rays, or of a list's, go through all stages, side by side.

mod baseline;
#[cfg(test)]
mod tests;

use std::time::Instant;

use crate::error::Result;
use crate::kernel::Kernel;
use crate::num::UNDECIDED;
use crate::prepare::Prepared;
use crate::query::{Hits, Outputs, SampleIds, Stage, StageCounts, Timing, places_of, resize};
use crate::rays::{Pixels, Rays};
use crate::support::control::Control;
use crate::support::fpu_check;
use crate::support::parallel;
use crate::surface::{PackF64, Resolver, Surfaces, is_ordinary};
use crate::visibility::{self, LARGEST, ListSearch, Search};

/// Rays that one thread takes at a time from a list.
const RAYS_PER_PART: usize = 4096;

/// Consecutive rays, and where what they see goes; nothing where it is not wanted.
struct Strip<'a> {
    /// Index of the first.
    first: usize,
    ids: &'a mut [u32],
    t: &'a mut [f32],
    normal: &'a mut [[f32; 3]],
    level: &'a mut [u8],
}

/// All rays, in parts of so many rows of a picture.
fn parts<'a>(rays: &Rays, n_rows: u32, hits: &'a mut Hits) -> Vec<Strip<'a>> {
    let n = match rays {
        Rays::Pixels(pixels) => n_rows as usize * pixels.width as usize,
        Rays::List(_) => RAYS_PER_PART,
    };
    let n = n.max(1);
    let mut t = hits.t.chunks_mut(n);
    let mut normal = hits.normal.chunks_mut(n);
    let mut level = hits.level.chunks_mut(n);
    let part = |(number, ids)| Strip {
        first: number * n,
        ids,
        t: t.next().unwrap_or_default(),
        normal: normal.next().unwrap_or_default(),
        level: level.next().unwrap_or_default(),
    };
    hits.id.chunks_mut(n).enumerate().map(part).collect()
}

/// The rows of so many pixels from the one with index `first` on.
fn rows_of(pixels: &Pixels, first: usize, n_pixels: usize) -> Pixels {
    let [first, n_rows] = [first, n_pixels].map(|n| n as u32 / pixels.width);
    pixels.rows(first, n_rows)
}

/// The f32 stage of the kernel `certified`: finds what consecutive rays see, the first of which has this index.
type FirstStage<'a> = dyn Fn(usize, &mut [u32], &mut visibility::SearchScratch) + Sync + 'a;

/// Makes the f32 stage for some rays. It leaves all open where f64 begins.
fn first_stage<'a>(prepared: &'a Prepared, rays: &'a Rays) -> Box<FirstStage<'a>> {
    match rays {
        _ if prepared.starts_in_f64() || rays.is_empty() => {
            Box::new(|_, ids, _| ids.fill(UNDECIDED))
        }
        Rays::Pixels(pixels) => {
            let search = Search::new(prepared, pixels, 1);
            Box::new(move |first, ids, room| {
                search.look(&rows_of(pixels, first, ids.len()), ids, room);
            })
        }
        Rays::List(rays) => {
            let search = ListSearch::new(prepared);
            Box::new(move |first, ids, _| search.look(&rays[first..][..ids.len()], ids))
        }
    }
}

/// Replaces `open` by those of some consecutive rays that f32 leaves to the stages after it.
fn find_open((prepared, rays): (&Prepared, &Rays), first: usize, ids: &[u32], open: &mut Vec<u32>) {
    open.clear();
    open.extend(places_of(UNDECIDED, ids).map(|at| (first + at) as u32));
    if let Rays::List(all) = rays {
        let origins = prepared.origins();
        let is_left = |ray| !is_ordinary(ray, prepared.unit) || origins.is_far(ray.origin);
        let left = (first..).zip(&all[first..][..ids.len()]).filter(|(_, ray)| is_left(ray));
        open.extend(left.map(|(ray, _)| ray as u32));
        open.sort_unstable();
        open.dedup();
    }
}

/// What is known of all rays, after a device has `proposed` their ids, or without one: [`Tracer::trace`](crate::tracer::Tracer::trace).
///
/// # Errors
/// Those of [`Prepared::check`]; [`crate::Error::Interrupted`].
pub fn trace(
    prepared: &Prepared,
    wants: Outputs,
    rays: &Rays,
    proposed: Option<Timing>,
    control: &Control,
    hits: &mut Hits,
) -> Result<Timing> {
    let is_proposed = proposed.is_some();
    if !is_proposed {
        prepared.check(rays)?;
        hits.make_room(rays.len(), wants)?;
    }
    let (start, mut timing) = (Instant::now(), proposed.unwrap_or_default());
    if prepared.kernel != Kernel::Certified {
        if !is_proposed {
            baseline::trace(prepared, rays, control, hits)?;
            timing.trace = start.elapsed();
        }
        let level = Stage::of(prepared.kernel);
        hits.level.fill(level as u8);
        hits.counts = StageCounts::of(rays.len() as u64, level);
        return Ok(timing);
    }
    let stage = Resolver::new(prepared, rays);
    let look = (!is_proposed).then(|| first_stage(prepared, rays));
    let surfaces = wants.surface.then(|| Surfaces::to_be_rounded(&stage));
    let of_part = |room: &mut StripScratch, part: Strip| {
        let Strip { first, ids, t, normal, level } = part;
        let StripScratch { search, open, packs } = room;
        let mut timing = Timing::default();
        control.check()?;
        fpu_check::check()?;
        if let Some(look) = &look {
            let start = Instant::now();
            look(first, ids, search);
            timing.trace = start.elapsed();
        }
        find_open((prepared, rays), first, ids, open);
        let decided = stage.decide(open, control, &mut timing)?;
        for (&ray, &id) in open.iter().zip(&decided.ids) {
            ids[ray as usize - first] = id;
        }
        if !level.is_empty() {
            open.iter().for_each(|&ray| level[ray as usize - first] = Stage::F64 as u8);
            let exactly = decided.exactly.iter().map(|&at| open[at] as usize - first);
            exactly.for_each(|at| level[at] = Stage::Exact as u8);
        }
        if let Some(surfaces) = &surfaces {
            let start = Instant::now();
            stage.complete(surfaces, (first, ids), (t, normal), control, packs)?;
            timing.refine += start.elapsed();
        }
        if !is_proposed {
            control.advance(ids.len() as u64);
        }
        Ok(StripCounts { counts: decided.counts(ids.len()), timing })
    };
    let mut done = StripCounts::default();
    for of_part in parallel::try_map_in(parts(rays, LARGEST, hits), of_part)? {
        done.add(of_part);
    }
    hits.counts = done.counts;
    timing.add(done.timing.within(start.elapsed()));
    Ok(timing)
}

/// How many rays of a part each stage decided, and the time of its thread.
#[derive(Default)]
struct StripCounts {
    counts: StageCounts,
    timing: Timing,
}

impl StripCounts {
    fn add(&mut self, other: StripCounts) {
        self.counts.add(other.counts);
        self.timing.add(other.timing);
    }
}

/// What a thread works in, from part to part.
#[derive(Default)]
struct StripScratch {
    search: visibility::SearchScratch,
    /// Rays that are left open.
    open: Vec<u32>,
    packs: Vec<PackF64>,
}

/// What samples of pixels see, `n` × `n` of each: pixels that show one object alone are proven to be such (see
/// [`crate::bounds::Footprint`]), and only those that are left are sampled. `None` where samples are better traced each.
///
/// # Errors
/// Those of [`trace`].
pub fn trace_samples(
    prepared: &Prepared,
    pixels: &Pixels,
    n: u32,
    control: &Control,
    samples: &mut SampleIds,
) -> Result<Option<Timing>> {
    let is_proven = prepared.kernel == Kernel::Certified && !prepared.starts_in_f64();
    if n == 1 || pixels.is_empty() || !is_proven {
        return Ok(None);
    }
    let all = Rays::Pixels(pixels.samples(n));
    prepared.check(&all)?;
    let start = Instant::now();
    let (search, stage) = (Search::new(prepared, pixels, n), Resolver::new(prepared, &all));
    let (width, n) = (pixels.width as usize, n as usize);
    let of_part = |room: &mut visibility::SearchScratch, (part, whole): (usize, &mut [u32])| {
        control.check()?;
        fpu_check::check()?;
        let mut timing = Timing::default();
        let start = Instant::now();
        let first = part * LARGEST as usize * width;
        let (mut mixed, mut ids) = search.look(&rows_of(pixels, first, whole.len()), whole, room);
        timing.trace = start.elapsed();
        mixed.iter_mut().for_each(|pixel| *pixel += first as u32);
        let places: Vec<usize> = places_of(UNDECIDED, &ids).collect();
        let ray = |&at: &usize| {
            let (pixel, sample) = (mixed[at / (n * n)] as usize, at % (n * n));
            let (x, y) = (pixel % width * n + sample % n, pixel / width * n + sample / n);
            (y * width * n + x) as u32
        };
        let open: Vec<u32> = places.iter().map(ray).collect();
        let decided = stage.decide(&open, control, &mut timing)?;
        places.iter().zip(&decided.ids).for_each(|(&at, &id)| ids[at] = id);
        let n_samples = whole.len() * n * n;
        control.advance(n_samples as u64);
        Ok(((mixed, ids), StripCounts { counts: decided.counts(n_samples), timing }))
    };
    resize(&mut samples.whole, pixels.len());
    let parts = samples.whole.chunks_mut(LARGEST as usize * width).enumerate();
    let (mut mixed, mut done) = (Vec::new(), StripCounts::default());
    for (mixed_of_part, done_of_part) in parallel::try_map_in(parts, of_part)? {
        mixed.push(mixed_of_part);
        done.add(done_of_part);
    }
    samples.set_mixed(mixed, n);
    samples.counts = done.counts;
    Ok(Some(done.timing.within(start.elapsed())))
}
