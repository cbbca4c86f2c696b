//! `kugelblitz digest`

use std::sync::Arc;

use kugelblitz::render::n_steps;
use kugelblitz::trace::Kernel;
use kugelblitz::{Result, Session};
use serde::Serialize;

use crate::args::DigestArgs;
use crate::device;
use crate::head::{Done, Objects, On};
use crate::progress::Progress;
use crate::{Run, scene};

#[derive(Serialize)]
pub struct Summary {
    #[serde(flatten)]
    on: On,
    size: [u32; 2],
    samples: u32,
    objects: Objects,
    digest: String,
}

/// Prints the digest of one picture.
pub fn run(args: &DigestArgs, run: &Run) -> Result<Done<Summary>> {
    let scene = scene::read(&args.scene, &args.talk, run)?;
    let pixels = args.size.pixels(&scene, &args.scene)?;
    let samples = args.samples.or(scene.samples).unwrap_or_default();
    let (choice, kernel) = (&args.device.device, Kernel::Certified);
    let device = device::open_for(choice, kernel, &scene, pixels.len(), &args.talk)?;
    let mut session = Session::new(Arc::clone(&scene), device, kernel);
    let n_steps = n_steps(&pixels, samples, scene.is_lit());
    let progress = Progress::start(&args.talk, &run.control, n_steps);
    let digest = session.digest(&pixels, samples, &run.control)?;
    drop(progress);
    let words = format!("{digest}\n");
    let summary = Summary {
        on: On::from(session.device()),
        size: [pixels.width, pixels.height],
        samples: samples.across(),
        objects: Objects::from(&*scene),
        digest,
    };
    Ok(Done::in_words(summary, words))
}
