//! The program `kugelblitz`: parse, run, print the error, exit code.

#![deny(clippy::print_stdout, clippy::print_stderr)]

mod cli;

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use clap::Parser;
use kugelblitz::control::Control;
use kugelblitz::output;
use kugelblitz::{Error, Result};

use cli::complain::{complain, complain_about_usage};
use cli::head::failed_in_json;
use cli::output::talk;
use cli::process::exit_at_once;
use cli::{Cli, Command, Run, quiet};

fn main() -> ExitCode {
    let run = Run { start: Instant::now(), control: Arc::new(Control::default()) };
    stop_on_interrupt(Arc::clone(&run.control));
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return ExitCode::from(complain_about_usage(&error)),
    };
    let writes = cli.command.writes_files();
    WRITES.store(writes, Ordering::Relaxed);
    let result = start_threads().and_then(|()| dispatch(cli.command, &run));
    // What was cancelled is not done, even where nothing noticed.
    ExitCode::from(match run.control.check().and(result) {
        Ok(()) => end(0, || {}),
        Err(error) => end(error.exit_code(), || {
            complain(&error, writes);
            failed_in_json(&error);
        }),
    })
}

/// What a thread sets aside of the address space is so before anything measures how much is left.
fn start_threads() -> Result<()> {
    let touch = |_| drop(std::hint::black_box(vec![0_u8; 64]));
    rayon::ThreadPoolBuilder::new().start_handler(touch).build_global().map_err(|error| {
        let advice = "set RAYON_NUM_THREADS to fewer, or raise the limits (`ulimit`)";
        Error::TooLarge(format!("the threads can't be started ({error}): {advice}"))
    })
}

fn dispatch(command: Command, run: &Run) -> Result<()> {
    match command {
        Command::Render(args) => cli::render::run(&args, run),
        Command::Verify(args) => cli::verify::run(&args, run),
        Command::Check(args) => cli::check::run(&args, run),
        Command::Trace(args) => cli::trace::run(&args, run),
        Command::Explain(args) => cli::explain::run(&args, run),
        Command::Judge(args) => cli::judge::run(&args, run),
        Command::Compare(args) => cli::compare::run(&args, run),
        Command::Info(args) => cli::info::run(&args),
        Command::Report(args) => cli::report::run(&args, run),
        Command::Export(args) => cli::export::run(&args, run),
        Command::Figure(args) => cli::figure::run(&args, run),
        #[cfg(feature = "view")]
        Command::View(args) => cli::view::run(&args, run),
        #[cfg(not(feature = "view"))]
        Command::View(_) => Err(kugelblitz::Error::Usage(
            "this program has no window; `cargo build --release --features view` builds one that has"
                .into(),
        )),
        Command::Generate(args) => cli::generate::run(&args, run),
        Command::Digest(args) => cli::digest::run(&args, run),
        Command::Probe(args) => cli::probe::run(&args),
        Command::Completions(args) => cli::completions::run(&args),
        Command::Man(args) => cli::man::run(&args, run),
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
        output::remove_unfinished();
        quiet::break_off();
        match control.is_cancelled() {
            true => complain(&interrupted, WRITES.load(Ordering::Relaxed)),
            false => talk("error: interrupted while output files were put in their places"),
        }
    }))
}
