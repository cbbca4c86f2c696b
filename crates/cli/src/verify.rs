//! `kugelblitz verify`

use kugelblitz::plain::Shown;
use kugelblitz::trace::Kernel;
use kugelblitz::verify::{OfKernel, Verification, broken_of, table};
use kugelblitz::{Error, Result};
use serde::Serialize;

use crate::args::VerifyArgs;
use crate::device;
use crate::head::{Objects, On, print_verdict};
use crate::output::{objects, print_text};
use crate::progress::Progress;
use crate::render::size;
use crate::{Run, scene};

#[derive(Serialize)]
struct Summary {
    #[serde(flatten)]
    on: On,
    size: [u32; 2],
    objects: Objects,
    rays: u64,
    samples: usize,
    seed: u64,
    kernels: Vec<OfKernel>,
}

/// Compares the devices with each other and with exact arithmetic.
pub fn run(args: &VerifyArgs, run: &Run) -> Result<()> {
    let scene = scene::read(&args.scene, &args.talk, run)?;
    let pixels = args.size.pixels(&scene, &args.scene)?;
    let verification = Verification::new(&scene, &pixels, args.samples, args.seed)?;
    let only = (!args.all_kernels).then_some(args.kernel.kernel);
    let device = device::open(&args.device.device, only, &args.talk)?;
    run.control.check()?;

    let kernels = only.map_or(Kernel::ALL.to_vec(), |kernel| vec![kernel]);
    let n_samples = verification.n_samples();
    let n_steps = verification.n_steps(kernels.len(), device.facts().is_some());
    let progress = Progress::start(&args.talk, &run.control, n_steps);
    let device_of = |kernel| device::or_cpu(&device, kernel, &args.talk);
    let results = verification.run(&kernels, device_of, &run.control)?;
    drop(progress);

    let broken = broken_of(&results);
    let failure = (!broken.is_empty()).then(|| Error::Comparison(broken.join("; ")));
    if args.talk.json {
        let summary = Summary {
            on: On::from(&device),
            size: [pixels.width, pixels.height],
            objects: Objects::from(&*scene),
            rays: pixels.len() as u64,
            samples: n_samples,
            seed: args.seed,
            kernels: results,
        };
        print_verdict("verify", &summary, failure.as_ref())?;
    } else {
        let share = match n_samples == pixels.len() {
            true => "all pixels".to_string(),
            false => format!("{n_samples} of {} pixels (seed {})", pixels.len(), args.seed),
        };
        let head = format!(
            "{}: {}, {}, on {}; {share} against exact arithmetic\n",
            args.scene.shown(),
            size(&pixels),
            objects(&scene),
            device.label()
        );
        print_text(&(head + &table(&results)))?;
    }
    failure.map_or(Ok(()), Err)
}
