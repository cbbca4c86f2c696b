//! `kugelblitz trace`

use std::time::Instant;

use kugelblitz::Result;
use kugelblitz::lighting::RenderStats;
use kugelblitz::output::OutputFile;
use kugelblitz::picture::{read_rays, write_hits};
use kugelblitz::query::{Hits, Outputs, Rays};
use kugelblitz::words::count;

use crate::args::TraceArgs;
use crate::device;
use crate::head::{Done, Drawn, Traced, WorkSummary, traced_in_words};
use crate::output::{check_ending, is_stdout, refuse_overwriting};
use crate::picture::PictureArgs;
use crate::progress::Progress;
use crate::{Run, wrong_usage};

/// Traces a file of rays into a file of hits.
pub fn run(args: &TraceArgs, run: &Run) -> Result<Done<Traced>> {
    run.refuse_sharing_stdout([(&args.output, "the hits")])?;
    if !is_stdout(&args.output) {
        check_ending(&args.output, "npy", "hits are")?;
    }
    if is_stdout(&args.rays) && is_stdout(&args.scene) {
        return wrong_usage("standard input cannot be both the scene and the rays");
    }
    let wants = Outputs { surface: true, level: args.certificates };
    let start = Instant::now();
    let picture = PictureArgs { data: args.data.clone(), ..PictureArgs::default() };
    let scene = picture.scene_of_rays(&args.scene, None, run)?;
    refuse_overwriting([&args.output], [&args.scene, &args.rays], &scene)?;
    let mut file = OutputFile::create(&args.output, false)?;
    let read = || read_rays(&args.rays, &run.control);
    let rays = Rays::List(Progress::of_bytes(run).during(read)?);
    let n_rays = rays.len();
    let read = start.elapsed();

    let kernel = args.kernel.kernel;
    let mut session = device::session(&args.device, kernel, &scene, n_rays, run)?;
    let making = Progress::of_preparing(run, &scene, kernel)
        .during(|| session.make_ready(&rays, wants, &run.control))?;

    let mut hits = Hits::default();
    let timing = Progress::start(run, n_rays as u64)
        .during(|| session.trace(&rays, wants, &run.control, &mut hits))?;
    let start = Instant::now();
    Progress::of_bytes(run).during(|| write_hits(&mut file, &hits, &run.control))?;
    let write = start.elapsed();

    let (n_hits, counts) = (hits.n_hits(), hits.counts);
    let done = RenderStats { hits: n_hits, counts, timing, write, ..RenderStats::default() };
    let line = format!(
        "{}, {}, {}",
        count(n_rays, "ray"),
        count(n_hits as usize, "hit"),
        traced_in_words(&session, run)
    );
    let drawn = Drawn::new(&done, making, Some(read), run.start.elapsed(), false);
    let (work, bytes_device) = (WorkSummary::new(&session, None), session.bytes_device());
    let summary = Traced { work, drawn, show: None, legend: None, bytes_device, ms_runs: None };
    Ok(Done::with_file(summary, None, file, &line))
}
