//! The progress bar.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use kugelblitz::trace::Control;

use super::TalkArgs;

/// Work that takes less time has no bar.
const DELAY: Duration = Duration::from_millis(500);

/// Time between two looks at the rays done.
const STEP: Duration = Duration::from_millis(100);

/// Shows a bar on a terminal while it lives.
pub struct Progress(Option<(Sender<()>, JoinHandle<()>)>);

impl Progress {
    /// Follows `control` up to `n_rays`.
    pub fn start(talk: &TalkArgs, control: &Arc<Control>, n_rays: u64) -> Progress {
        if talk.quiet || !std::io::stderr().is_terminal() {
            return Progress(None);
        }
        let control = Arc::clone(control);
        let (stop, stopped) = channel();
        let thread = std::thread::spawn(move || {
            let goes_on = |time| stopped.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
            if !goes_on(DELAY) {
                return;
            }
            let bar = ProgressBar::new(n_rays);
            if let Ok(style) = ProgressStyle::with_template(
                "{bar:40} {percent:>3} %, {human_pos} of {human_len} rays, {eta} left",
            ) {
                bar.set_style(style);
            }
            loop {
                bar.set_position(control.rays_done().min(n_rays));
                if !goes_on(STEP) {
                    break;
                }
            }
            bar.finish_and_clear();
        });
        Progress(Some((stop, thread)))
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
