//! `kugelblitz trace`

use std::path::Path;
use std::time::Instant;

use kugelblitz::memory;
use kugelblitz::output::OutputFile;
use kugelblitz::picture::{STDIN, read_rays, write_hits};
use kugelblitz::plain::Shown;
use kugelblitz::render::{Rendered, hits_bytes};
use kugelblitz::trace::{Hits, Rays, Wants, WorldRay};
use kugelblitz::words::count;
use kugelblitz::{Error, Result};

use crate::args::TraceArgs;
use crate::device;
use crate::head::{Done, Drawn, Traced, Work, traced_in_words};
use crate::output::{check_ending, is_stdout, name};
use crate::picture::PictureArgs;
use crate::progress::Progress;
use crate::{Run, scene};

/// Bytes of a ray in a file of float64.
const FILE_RAY_BYTES: u64 = 48;

/// Traces a file of rays into a file of hits.
pub fn run(args: &TraceArgs, run: &Run) -> Result<Done<Traced>> {
    run.refuse_json_beside(&[&args.output], "the hits")?;
    if !is_stdout(&args.output) {
        check_ending(&args.output, "npy", "hits are")?;
    }
    let wants = Wants { surface: true, level: args.certificates };
    let start = Instant::now();
    let picture = PictureArgs { data: args.data.clone(), ..PictureArgs::default() };
    let scene = picture.scene(&args.scene, None, run)?;
    refuse_what_cannot_fit(&args.rays, wants)?;
    scene::refuse_overwriting(&[&args.output], &[&args.scene, &args.rays], &scene)?;
    let mut file = OutputFile::create(&args.output, false)?;
    let rays = Progress::of_bytes(run).during(|| read_rays(&args.rays, &run.control))?;
    let rays = Rays::List(rays);
    let read = start.elapsed();

    let kernel = args.kernel.kernel;
    let mut session = device::session(&args.device, kernel, &scene, rays.len(), run)?;
    let making = scene::preparing(&scene, kernel, run)
        .during(|| session.make_ready(&rays, wants, &run.control))?;

    let mut hits = Hits::default();
    let timing = Progress::start(run, rays.len() as u64)
        .during(|| session.trace(&rays, wants, &run.control, &mut hits))?;
    let start = Instant::now();
    Progress::of_bytes(run).during(|| write_hits(&mut file, &hits, &run.control))?;
    let write = start.elapsed();

    let (n_hits, counts) = (hits.n_hits(), hits.counts);
    let done = Rendered { hits: n_hits, counts, timing, write, ..Rendered::default() };
    let line = format!(
        "{}: {}, {n_hits} hits, {}",
        name(&args.output),
        count(rays.len(), "ray"),
        traced_in_words(&session, run)
    );
    let drawn = Drawn::new(&done, making, Some(read), run.start.elapsed(), false);
    let (work, bytes_device) = (Work::new(&session, None), session.bytes_device());
    let summary = Traced { work, drawn, show: None, legend: None, bytes_device, ms_runs: None };
    Ok(Done::with_files(summary, [file], line))
}

/// A file of float64 needs a ray, a hit and a place among the undecided for each row; one of
/// float32 needs twice that for its size, so this refuses only what is certain not to fit.
fn refuse_what_cannot_fit(rays: &Path, wants: Wants) -> Result<()> {
    if rays == Path::new(STDIN) {
        // Its header will tell.
        return Ok(());
    }
    let file_bytes = std::fs::metadata(rays).map_err(Error::io(rays))?.len();
    let n_rays = file_bytes / FILE_RAY_BYTES;
    let ray_bytes = size_of::<WorldRay>() + size_of::<u32>();
    let needed = n_rays * ray_bytes as u64 + hits_bytes(n_rays, wants);
    let what = format!("{}: tracing its {n_rays} rays", rays.shown());
    memory::require(what, needed, "give the rays in parts")
}
