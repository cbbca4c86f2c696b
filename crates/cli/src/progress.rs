//! The progress bar.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use kugelblitz::Control;
use kugelblitz::query::Kernel;
use kugelblitz::scene::Scene;
use kugelblitz::words::count;

use crate::Run;

/// Work that takes less time has no bar.
const DELAY: Duration = Duration::from_millis(500);

/// Time between two looks at what is done.
const STEP: Duration = Duration::from_millis(100);

/// Shows a bar on a terminal while it lives.
pub struct Progress(Option<(Sender<()>, JoinHandle<()>)>);

impl Progress {
    /// Follows the rays of `control` up to `n_rays`.
    pub fn start(run: &Run, n_rays: u64) -> Progress {
        Progress::follow(run, "{human_pos} of {human_len} rays", move |control, _| {
            (control.rays_done(), n_rays)
        })
    }

    /// Follows the frames of a film, of so many rays each.
    pub fn of_frames(run: &Run, n_rays_each: u64, n_frames: u64) -> Progress {
        let n_rays = n_rays_each.saturating_mul(n_frames);
        Progress::follow(run, "{msg}", move |control, bar| {
            let n_done = control.rays_done().min(n_rays);
            let frame = (n_done / n_rays_each.max(1) + 1).min(n_frames);
            bar.set_message(format!("frame {frame} of {n_frames}"));
            (n_done, n_rays)
        })
    }

    /// Follows the bytes that `control` expects.
    pub fn of_bytes(run: &Run) -> Progress {
        Progress::follow(run, "{bytes} of {total_bytes}", |control, _| control.bytes())
    }

    /// Says that preparing a scene goes on, which takes a while where it has large clouds.
    pub fn of_preparing(run: &Run, scene: &Scene, kernel: Kernel) -> Progress {
        let has_hierarchy = kernel == Kernel::Certified;
        let what = if has_hierarchy { "building the hierarchy over" } else { "preparing" };
        let n_spheres = count(scene.spheres.len(), "sphere");
        let what = format!("{what} {n_spheres}, {}", kernel.name());
        // Nobody knows how far it is.
        Progress::show(run, "{spinner} {elapsed} {msg}".into(), move |bar| {
            bar.set_message(what.clone());
            bar.tick();
            true
        })
    }

    /// Does some work while it shows the bar.
    pub fn during<T>(self, work: impl FnOnce() -> T) -> T {
        work()
    }

    /// `look` gives what is done and what is to be done, and `what` is indicatif's text for it.
    fn follow(
        run: &Run,
        what: &str,
        look: impl Fn(&Control, &ProgressBar) -> (u64, u64) + Send + 'static,
    ) -> Progress {
        let template = format!("{{bar:40}} {{percent:>3}} %, {what}, {{eta}} left");
        let control = Arc::clone(&run.control);
        Progress::show(run, template, move |bar| {
            let (n_done, n_all) = look(&control, bar);
            bar.set_length(n_all);
            bar.set_position(n_done.min(n_all));
            n_all > 0
        })
    }

    /// `template` is indicatif's; `draw` brings the bar up to date, and says whether there is anything to show at all.
    fn show(
        run: &Run,
        template: String,
        draw: impl Fn(&ProgressBar) -> bool + Send + 'static,
    ) -> Progress {
        if run.talk.quiet || !std::io::stderr().is_terminal() {
            return Progress(None);
        }
        let (stop, stopped) = channel();
        let follow = move || {
            let goes_on = |time| stopped.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
            if !goes_on(DELAY) {
                return;
            }
            let bar = ProgressBar::new(0);
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style);
            }
            while draw(&bar) && goes_on(STEP) {}
            bar.finish_and_clear();
        };
        // Without a thread to spare there is no bar.
        Progress(std::thread::Builder::new().spawn(follow).ok().map(|thread| (stop, thread)))
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((stop, thread)) = self.0.take() {
            drop(stop);
            let _ = thread.join();
        }
    }
}
