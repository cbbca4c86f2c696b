//! `kugelblitz view`

use std::sync::Arc;

use kugelblitz::Result;
use kugelblitz::scene::read_scene;
use kugelblitz::view::{self, Notice, Options};

use super::device;
use super::options::check_size;
use super::output::{print_text, printed_line, talk};
use super::quiet::{self, Quiet};
use super::scene::say_notes;
use super::{Run, ViewArgs};

/// Opens the window.
pub fn run(args: &ViewArgs, run: &Run) -> Result<()> {
    let scene = Arc::new(read_scene(&args.scene)?);
    say_notes(&scene, &args.talk);
    let size = args.size.size.map(check_size).transpose()?;
    let options = Options {
        path: args.scene.clone(),
        device: device::pick_for_window(&args.device.device, args.kernel.kernel, &scene),
        scene,
        kernel: args.kernel.kernel,
        size,
        control: Arc::clone(&run.control),
        on_display_lost,
        lose_device_after: args.lose_device_after,
    };
    let (mut failed, mut quiet) = (None, None);
    let ran = view::run(options, |notice| {
        match notice {
            Notice::Opening => quiet = Quiet::start(),
            Notice::Opened { .. } => {
                let noise = quiet.take().map(Quiet::end);
                if args.talk.verbose {
                    quiet::show(&noise.unwrap_or_default(), true);
                }
            }
            _ => {}
        }
        if let Err(error) = tell(args, notice) {
            failed.get_or_insert(error);
        }
    });
    if let Some(noise) = quiet.take().map(Quiet::end) {
        quiet::show(&noise, args.talk.verbose);
    }
    ran?;
    failed.map_or(Ok(()), Err)
}

/// Xlib ends the process after this.
fn on_display_lost() {
    talk("error: the display: the connection was lost");
}

/// Data to standard output, talk to standard error.
fn tell(args: &ViewArgs, notice: &Notice) -> Result<()> {
    if args.log_events {
        return printed_line(notice);
    }
    match notice {
        Notice::Camera { toml } => print_text(toml)?,
        Notice::Saved { path, size: [width, height] } => {
            talk(&format!("{}: {width}×{height}", path.display()));
        }
        Notice::SceneWrong { error } => talk(&format!("error: {error}")),
        Notice::Trouble { message } => talk(&format!("warning: {message}")),
        Notice::Destroyed => talk("the window was closed by another program"),
        Notice::Opening
        | Notice::Opened { .. }
        | Notice::Shown { .. }
        | Notice::Hover { .. }
        | Notice::Explained { .. }
        | Notice::Reloaded => {}
    }
    Ok(())
}
