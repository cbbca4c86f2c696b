//! The program `kugelblitz`: parse, run, print the error, exit code. The window, `kugelblitz-view`, is a second
//! [`CommandLine`] that goes the same way.

#![deny(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod compare;
mod complain;
mod completions;
mod device;
mod digest;
mod explain;
mod export;
mod figure;
mod film;
mod generate;
mod head;
mod info;
mod man;
mod manual;
mod new;
mod options;
mod output;
mod picture;
mod probe;
#[cfg_attr(windows, path = "process_windows.rs")]
mod process;
mod progress;
pub mod quiet;
mod render;
mod report;
mod show;
mod trace;
mod verify;
mod version;
mod view;

use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use clap::Parser;
use kugelblitz::Control;
use kugelblitz::error::wrong_usage;
use kugelblitz::{Error, Result};

pub use args::{Cli, EXIT_CODES, TalkArgs, ViewArgs};
pub use options::check_size;
pub use output::{print_text, printed_line, talk};
pub use picture::read_composed;
pub use version::long as long_version;

use args::Command;
use complain::{complain, complain_about_usage};
use head::failed_in_json;
use process::exit_at_once;

/// One run of the program, from its start.
pub struct Run {
    /// When it began.
    pub start: Instant,
    /// Counts its rays and stops it.
    pub control: Arc<Control>,
    /// How much it says.
    pub talk: TalkArgs,
}

/// What a program is asked for on its command line.
pub trait CommandLine: Parser {
    /// The command of `kugelblitz` that it is; `None` where its first word says that.
    const COMMAND: Option<&str> = None;

    /// How much the program says.
    fn talk(&self) -> TalkArgs;

    /// True where there are output files that all appear in the end.
    fn writes_files(&self) -> bool;

    /// Does what is asked for.
    ///
    /// # Errors
    /// Those of the work; their exit code is the program's.
    fn run(self, run: &Run) -> Result<()>;
}

/// Runs the program whose command line is a `C` with the arguments of the process. Returns its exit code.
pub fn main_of<C: CommandLine>() -> ExitCode {
    ExitCode::from(main_with::<C>(std::env::args_os()))
}

/// Runs the program whose command line is a `C` with these arguments, starting with the name of the program. Returns
/// its exit code. Handles Ctrl-C and SIGTERM of the whole process from then on, so call it once.
pub fn main_with<C: CommandLine>(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let (start, control) = (Instant::now(), Arc::new(Control::default()));
    stop_on_interrupt(Arc::clone(&control));
    let line = COMMAND_LINE.get_or_init(|| arguments.into_iter().collect());
    let line = match C::try_parse_from(line) {
        Ok(line) => line,
        Err(error) => return complain_about_usage::<C>(error),
    };
    let run = Run { start, control, talk: line.talk() };
    let writes = line.writes_files();
    WRITES.store(writes, Ordering::Relaxed);
    let result = start_threads().and_then(|()| line.run(&run));
    // What was cancelled is not done, even where nothing noticed.
    match run.control.check().and(result) {
        Ok(()) => end(0, || {}),
        Err(error) => end(error.exit_code(), || {
            complain(&error, writes);
            failed_in_json::<C>(&error);
        }),
    }
}

/// The name of the program and its arguments.
static COMMAND_LINE: OnceLock<Vec<OsString>> = OnceLock::new();

/// Returns the command line of this run, with the name of the program. Empty before [`main_with`].
fn command_line() -> &'static [OsString] {
    COMMAND_LINE.get().map_or(&[], Vec::as_slice)
}

/// Returns the arguments of this run.
fn arguments() -> &'static [OsString] {
    command_line().get(1..).unwrap_or_default()
}

/// What a thread sets aside of the address space is so before anything measures how much is left.
fn start_threads() -> Result<()> {
    let touch = |_| drop(std::hint::black_box(vec![0_u8; 64]));
    rayon::ThreadPoolBuilder::new().start_handler(touch).build_global().map_err(|error| {
        let advice = "set RAYON_NUM_THREADS to fewer, or raise the limits (`ulimit`)";
        Error::TooLarge(format!("the threads can't be started ({error}): {advice}").into())
    })
}

impl CommandLine for Cli {
    fn talk(&self) -> TalkArgs {
        self.talk
    }

    fn writes_files(&self) -> bool {
        match &self.command {
            // Its frames appear one after the other, and it says how many are whole.
            Command::Render(args) => !args.film.is_film(),
            Command::Verify(_)
            | Command::Explain(_)
            | Command::Info(_)
            | Command::Probe
            | Command::Completions(_) => false,
            _ => true,
        }
    }

    fn run(self, run: &Run) -> Result<()> {
        match self.command {
            Command::Render(args) => render::run(&args, run),
            Command::Verify(args) => verify::run(&args, run)?.finish("verify", run),
            Command::Trace(args) => trace::run(&args, run)?.finish("trace", run),
            Command::Explain(args) => explain::run(&args, run)?.finish("explain", run),
            Command::Compare(args) => compare::run(&args, run)?.finish("compare", run),
            Command::Info(args) => info::run(&args, run)?.finish("info", run),
            Command::Report(args) => report::run(&args, run)?.finish("report", run),
            Command::Export(args) => export::run(&args, run),
            Command::Figure(args) => figure::run(&args, run)?.finish("figure", run),
            Command::View(_) => view::run(),
            Command::Generate(args) => generate::run(&args, run)?.finish("generate", run),
            Command::Digest(args) => digest::run(&args, run)?.finish("digest", run),
            Command::New(args) => new::run(&args, run)?.finish("new", run),
            Command::Probe => probe::run(run)?.finish("probe", run),
            Command::Completions(_) | Command::Man(_) if run.talk.json => {
                wrong_usage("--json: this command has no summary; leave it out")
            }
            Command::Completions(args) => completions::run(&args),
            Command::Man(args) => man::run(&args, run),
        }
    }
}

/// True once the command is known and has output files.
static WRITES: AtomicBool = AtomicBool::new(false);

/// The exit code, once it is known.
static CODE: OnceLock<u8> = OnceLock::new();

/// Settles the exit code with these last words, or gives the one that is settled already.
fn end(code: u8, last_words: impl FnOnce()) -> u8 {
    if CODE.set(code).is_ok() {
        last_words();
    }
    *CODE.get_or_init(|| code)
}

/// What the work may take to end by itself. The rest of the promised second is the system's.
const PATIENCE: Duration = Duration::from_millis(500);

/// Ctrl-C and SIGTERM let the work end by itself, and end it where that takes too long: drivers that
/// compile, pipes that nobody opens and other people's code know nothing of a [`Control`]. Nothing
/// half done stays behind, as cancelled work changes no output file. Once the outputs are being put in
/// their places it is too late; only a second one, if that should hang, is then heard.
fn stop_on_interrupt(control: Arc<Control>) {
    let mut was_late = false;
    let stop = move || {
        if control.cancel() {
            std::thread::sleep(PATIENCE);
        } else if !std::mem::replace(&mut was_late, true) {
            return;
        }
        stop_now(&control);
    };
    if let Err(error) = ctrlc::set_handler(stop) {
        // The program does its work without it too; Ctrl-C then kills it.
        talk(&format!("warning: Ctrl-C can't be handled: {error}"));
    }
}

/// Says nothing on standard output, where the work may be in the midst of a word.
fn stop_now(control: &Control) -> ! {
    let interrupted = Error::Interrupted;
    exit_at_once(end(interrupted.exit_code(), || {
        kugelblitz::output::remove_unfinished();
        quiet::break_off();
        if control.is_cancelled() {
            complain(&interrupted, WRITES.load(Ordering::Relaxed))
        } else {
            talk("error: interrupted while output files were put in their places")
        }
    }))
}
