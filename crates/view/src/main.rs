//! The program `kugelblitz-view`, which `kugelblitz view` becomes: the window and its command line.

use std::process::ExitCode;
use std::sync::Arc;

use clap::Parser;
use kugelblitz::Result;
use kugelblitz::device::DeviceChoice;
use kugelblitz::error::wrong_usage;
use kugelblitz::gpu::has_software_alone;
use kugelblitz::plain::Shown;
use kugelblitz::prepare::FEW_SPHERES;
use kugelblitz::query::Kernel;
use kugelblitz::scene::{Scene, recompose_scene};
use kugelblitz_cli::{
    CommandLine, EXIT_CODES, Run, TalkArgs, ViewArgs, check_size, long_version, main_of,
    print_text, printed_line,
    quiet::{self, Quiet},
    read_composed, talk,
};
use kugelblitz_view::{Notice, Options};

fn main() -> ExitCode {
    main_of::<Window>()
}

#[derive(Parser)]
#[command(
    name = "kugelblitz-view",
    version,
    long_version = long_version(),
    max_term_width = 100,
    after_help = EXIT_CODES
)]
struct Window {
    #[command(flatten)]
    talk: TalkArgs,
    #[command(flatten)]
    view: ViewArgs,
}

impl CommandLine for Window {
    const COMMAND: Option<&str> = Some("view");

    fn talk(&self) -> TalkArgs {
        self.talk
    }

    fn writes_files(&self) -> bool {
        true
    }

    fn run(self, run: &Run) -> Result<()> {
        open(&self.view, run)
    }
}

/// Opens the window.
fn open(args: &ViewArgs, run: &Run) -> Result<()> {
    if run.talk.json {
        return wrong_usage("--json: this command has no summary; leave it out");
    }
    let overrides = args.picture.overrides(args.size.size)?;
    if args.picture.print_scene.is_some() {
        return args.picture.print_alone(&args.scene, &overrides, run);
    }
    let (scene, _) = read_composed(&args.scene, &overrides, run)?;
    let size = args.size.size.map(check_size).transpose()?;
    let options = Options {
        path: args.scene.clone(),
        reread: Arc::new(move |path, control| {
            recompose_scene(path, &overrides, control).map(|composed| composed.scene)
        }),
        device: pick_device(&args.device.device, args.kernel.kernel, &scene),
        scene,
        kernel: args.kernel.kernel,
        size,
        lang: args.lang,
        control: Arc::clone(&run.control),
        lose_device_after: args.lose_device_after,
    };
    // What drivers print while devices are opened.
    let (mut failed, mut quiet) = (None, Quiet::start());
    let ran = kugelblitz_view::run(options, |notice| {
        if matches!(notice, Notice::Opened { .. }) {
            let noise = quiet.take().map(Quiet::end);
            if run.talk.verbose {
                quiet::show(&noise.unwrap_or_default(), true);
            }
        }
        if let Err(error) = tell(args, run, notice) {
            failed.get_or_insert(error);
        }
    });
    if let Some(noise) = quiet.take().map(Quiet::end) {
        quiet::show(&noise, run.talk.verbose);
    }
    ran?;
    failed.map_or(Ok(()), Err)
}

/// The device for a window: `auto` lets the CPU trace many spheres where there is no GPU in hardware. Few
/// of them stay on the device that shows the picture, whose shaders are there by then.
fn pick_device(choice: &DeviceChoice, kernel: Kernel, scene: &Scene) -> Option<String> {
    let is_quicker = scene.spheres.len() > FEW_SPHERES || kernel == Kernel::Double;
    choice.adapter().filter(|_| !(choice.is_free() && is_quicker && has_software_alone()))
}

/// Data to standard output, talk to standard error.
fn tell(args: &ViewArgs, run: &Run, notice: &Notice) -> Result<()> {
    if args.log_events {
        return printed_line(notice);
    }
    match notice {
        Notice::Camera { toml } => print_text(toml)?,
        Notice::Saved { path, size: [width, height] } => {
            run.say(&format!("{}: {width}×{height}", path.shown()));
        }
        Notice::SceneWrong { error } => talk(&format!("error: {error}")),
        Notice::Trouble { message } => run.warn(message),
        _ => {}
    }
    Ok(())
}
