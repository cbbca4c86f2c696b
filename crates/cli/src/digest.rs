//! `kugelblitz digest`

use kugelblitz::Result;
use kugelblitz::render::n_steps;
use kugelblitz::trace::Kernel;
use kugelblitz_judge::compare::ObjectCounts;
use serde::Serialize;

use crate::args::DigestArgs;
use crate::device;
use crate::head::{Done, On};
use crate::progress::Progress;
use crate::{Run, scene};

#[derive(Serialize)]
pub struct Summary {
    #[serde(flatten)]
    on: On,
    size: [u32; 2],
    samples: u32,
    objects: ObjectCounts,
    digest: String,
}

/// Prints the digest of one picture.
pub fn run(args: &DigestArgs, run: &Run) -> Result<Done<Summary>> {
    let scene = scene::read(&args.scene, run)?;
    let pixels = args.size.pixels(&scene, &args.scene)?;
    let samples = args.samples.or(scene.samples).unwrap_or_default();
    let mut session = device::session(&args.device, Kernel::Certified, &scene, pixels.len(), run)?;
    let n_steps = n_steps(&pixels, samples, scene.is_lit());
    let digest = || session.digest(&pixels, samples, &run.control);
    let digest = Progress::start(run, n_steps).during(digest)?;
    let words = format!("{digest}\n");
    let summary = Summary {
        on: On::from(session.device()),
        size: [pixels.width, pixels.height],
        samples: samples.across(),
        objects: ObjectCounts::of(&scene),
        digest,
    };
    Ok(Done::in_words(summary, words))
}
