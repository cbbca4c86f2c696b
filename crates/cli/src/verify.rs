//! `kugelblitz verify`

use kugelblitz::Result;
use kugelblitz::plain::Shown;
use kugelblitz::query::Kernel;
use kugelblitz_judge::cost::ObjectCounts;
use kugelblitz_judge::verify::{Verification, Verified};
use serde::Serialize;

use crate::Run;
use crate::args::VerifyArgs;
use crate::device;
use crate::head::{Done, On};
use crate::progress::Progress;
use crate::render::size;

/// The verification of a picture.
#[derive(Serialize)]
pub struct VerifySummary {
    #[serde(flatten)]
    on: On,
    #[serde(flatten)]
    verified: Verified,
}

/// Compares the devices with each other and with exact arithmetic.
pub fn run(args: &VerifyArgs, run: &Run) -> Result<Done<VerifySummary>> {
    let scene = args.scene.scene(run)?;
    let pixels = args.scene.pixels(&scene)?;
    let verification = Verification::new(&scene, &pixels, args.samples, args.seed);
    let only = (!args.all_kernels).then_some(args.kernel.kernel);
    let device = device::open(&args.device.device, only, run)?;
    run.control.check()?;

    let kernels = only.map_or(Kernel::ALL.to_vec(), |kernel| vec![kernel]);
    let n_steps = verification.n_steps(&kernels, device.facts().is_some());
    let device_of = |kernel| device::or_cpu(&device, kernel, run);
    let verify = || verification.run(&kernels, device_of, &run.control);
    let verified = Progress::start(run, n_steps).during(verify)?;

    let Verified { rays, samples, seed, .. } = verified;
    let share = if samples == rays {
        "all pixels".to_string()
    } else {
        format!("{samples} of {rays} pixels (seed {seed})")
    };
    let head = format!(
        "{}: {}, {}, on {}; {share} against exact arithmetic\n",
        args.scene.path.shown(),
        size(&pixels),
        ObjectCounts::of(&scene),
        device.label()
    );
    let (words, broken) = (head + &verified.in_words(), verified.broken());
    let summary = VerifySummary { on: On::from(&device), verified };
    Ok(Done::compared(summary, words, None, &broken))
}
