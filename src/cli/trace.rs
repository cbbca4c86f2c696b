//! `kugelblitz trace`

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use kugelblitz::output::{self, OutputFile};
use kugelblitz::rays::{read_rays_with, write_hits};
use kugelblitz::render::{available_memory, hits_bytes};
use kugelblitz::trace::{Hits, Ray, Rays, Wants};
use kugelblitz::{Error, Result, Session};
use serde::Serialize;

use super::device;
use super::head::{Head, Ms, MsStages, Objects, On, RayCounts};
use super::output::{building, bytes, count, human, ms, objects, print_json};
use super::progress::Progress;
use super::{Run, TraceArgs, scene};

/// Bytes of a ray in a file of float64.
const FILE_RAY_BYTES: u64 = 48;

#[derive(Serialize)]
struct Summary {
    #[serde(flatten)]
    head: Head,
    #[serde(flatten)]
    on: On,
    kernel: &'static str,
    objects: Objects,
    rays: RayCounts,
    hits: u64,
    bytes_device: u64,
    ms: Ms,
}

/// Traces a file of rays into a file of hits.
pub fn run(args: &TraceArgs, run: &Run) -> Result<()> {
    if args.talk.json && args.output == Path::new(OutputFile::STDOUT) {
        return Err(Error::Usage(
            "the hits and --json can't both go to standard output; write the hits to a file".into(),
        ));
    }
    let wants = Wants { surface: true, level: args.certificates };
    let start = Instant::now();
    let scene = scene::read(&args.scene, &args.talk, run)?;
    refuse_what_cannot_fit(&args.rays, wants)?;
    scene::refuse_overwriting(&[&args.output], &[&args.scene, &args.rays], &scene)?;
    let mut file = OutputFile::create(&args.output, false)?;
    let progress = Progress::of_bytes(&args.talk, &run.control);
    let rays = Rays::List(read_rays_with(&args.rays, &run.control)?);
    drop(progress);
    let read = start.elapsed();
    if rays.is_empty() {
        return Err(Error::Input {
            path: args.rays.clone(),
            message: "there are no rays in it; give at least one row".into(),
        });
    }

    let device = device::open_for_list(&args.device.device, args.kernel, &scene, &args.talk)?;
    let mut session = Session::new(Arc::clone(&scene), device, args.kernel);
    let progress = scene::preparing(&scene, args.kernel, &args.talk);
    let making = session.make_ready(&rays, wants, &run.control)?;
    drop(progress);

    let progress = Progress::start(&args.talk, &run.control, rays.len() as u64);
    let mut hits = Hits::default();
    let timing = session.trace(&rays, wants, &run.control, &mut hits)?;
    drop(progress);
    let start = Instant::now();
    let progress = Progress::of_bytes(&args.talk, &run.control);
    write_hits(&mut file, &hits, &run.control)?;
    drop(progress);
    let write = start.elapsed();

    if args.talk.json {
        print_json(&Summary {
            head: Head::new("trace"),
            on: On::from(session.device()),
            kernel: args.kernel.name(),
            objects: Objects::from(&*scene),
            rays: RayCounts::from(hits.counts),
            hits: hits.n_hits(),
            bytes_device: session.bytes_device(),
            ms: Ms {
                read: ms(read),
                prepare: ms(making.prepare),
                build: ms(making.build),
                upload: ms(making.upload),
                compile: ms(making.compile),
                stages: MsStages::from(timing),
                write: ms(write),
                total: ms(run.start.elapsed()),
                ..Ms::default()
            },
        })?;
    }
    output::commit([file], &run.control)?;
    args.talk.say(&format!(
        "{}: {}, {} hits, {}, {} on {}, {}{} tracing",
        args.output.display(),
        count(rays.len(), "ray"),
        hits.n_hits(),
        objects(&scene),
        args.kernel.name(),
        session.device().label(),
        building(making.build),
        human(timing.trace + timing.refine + timing.decide + timing.readback)
    ));
    Ok(())
}

/// A file of float64 needs a ray and a hit for each row; one of float32 needs twice that for its
/// size, so this refuses only what is certain not to fit.
fn refuse_what_cannot_fit(rays: &Path, wants: Wants) -> Result<()> {
    let file_bytes = std::fs::metadata(rays).map_err(Error::io(rays))?.len();
    let n_rays = file_bytes / FILE_RAY_BYTES;
    let needed = n_rays * size_of::<Ray>() as u64 + hits_bytes(n_rays, wants);
    let available = available_memory();
    if needed > available {
        return Err(Error::TooLarge(format!(
            "{}: its rays and their hits need at least {} of memory, but only {} are available; \
             give the rays in parts",
            rays.display(),
            bytes(needed),
            bytes(available)
        )));
    }
    Ok(())
}
