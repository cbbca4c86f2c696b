//! `kugelblitz verify`

use kugelblitz::plain::Shown;
use kugelblitz::trace::Kernel;
use kugelblitz::{Error, Result};
use kugelblitz_judge::verify::{Verification, Verified};
use serde::Serialize;

use crate::args::VerifyArgs;
use crate::device;
use crate::head::{On, print_verdict};
use crate::output::{objects, print_text};
use crate::progress::Progress;
use crate::render::size;
use crate::{Run, scene};

#[derive(Serialize)]
struct Summary<'a> {
    #[serde(flatten)]
    on: On,
    #[serde(flatten)]
    verified: &'a Verified,
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
    let n_steps = verification.n_steps(kernels.len(), device.facts().is_some());
    let progress = Progress::start(&args.talk, &run.control, n_steps);
    let device_of = |kernel| device::or_cpu(&device, kernel, &args.talk);
    let verified = verification.run(&kernels, device_of, &run.control)?;
    drop(progress);

    let broken = verified.broken().join("; ");
    let failure = (!broken.is_empty()).then_some(Error::Comparison(broken));
    if args.talk.json {
        let summary = Summary { on: On::from(&device), verified: &verified };
        print_verdict("verify", &summary, failure.as_ref())?;
    } else {
        let Verified { rays, samples, seed, .. } = verified;
        let share = match samples == rays {
            true => "all pixels".to_string(),
            false => format!("{samples} of {rays} pixels (seed {seed})"),
        };
        let head = format!(
            "{}: {}, {}, on {}; {share} against exact arithmetic\n",
            args.scene.shown(),
            size(&pixels),
            objects(&scene),
            device.label()
        );
        print_text(&(head + &verified.in_words()))?;
    }
    failure.map_or(Ok(()), Err)
}
