//! The program `kugelblitz`: parse, run, print the error, exit code.

#![deny(clippy::print_stdout, clippy::print_stderr)]

mod cli;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use kugelblitz::trace::Control;

use cli::complain::{complain, complain_about_usage};
use cli::output::talk;
use cli::{Cli, Command, Run};

fn main() -> ExitCode {
    let run = Run { start: Instant::now(), control: Arc::new(Control::default()) };
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return ExitCode::from(complain_about_usage(&error)),
    };
    fail_writes_beyond_the_file_size_limit();
    stop_on_interrupt(Arc::clone(&run.control));
    let result = match cli.command {
        Command::Render(args) => cli::render::run(&args, &run),
        Command::Verify(args) => cli::verify::run(&args, &run),
        Command::Check(args) => cli::check::run(&args, &run),
        Command::Trace(args) => cli::trace::run(&args, &run),
        Command::Explain(args) => cli::explain::run(&args, &run),
        Command::Report(args) => cli::report::run(&args, &run),
        Command::Export(args) => cli::export::run(&args, &run),
        #[cfg(feature = "view")]
        Command::View(args) => cli::view::run(&args, &run),
        Command::Generate(args) => cli::generate::run(&args, &run),
        Command::Probe(args) => cli::probe::run(&args),
        Command::Completions(args) => cli::completions::run(&args),
        Command::Man(args) => cli::man::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => ExitCode::from(complain(&error)),
    }
}

/// The first Ctrl-C lets the work clean up behind itself; the second one ends it at once.
fn stop_on_interrupt(control: Arc<Control>) {
    let ask = move || {
        if control.check().is_err() {
            std::process::exit(i32::from(kugelblitz::Error::Interrupted.exit_code()));
        }
        control.cancel();
    };
    if let Err(error) = ctrlc::set_handler(ask) {
        // The program does its work without it too; Ctrl-C then kills it.
        talk(&format!("warning: Ctrl-C can't be handled: {error}"));
    }
}

/// Beyond the limit of `ulimit -f`, the system ends a program that doesn't ignore this signal before
/// the write can fail.
#[allow(unsafe_code)]
fn fail_writes_beyond_the_file_size_limit() {
    // SAFETY: ignoring a signal runs no code of ours in a handler, and no other thread is there yet
    // that could set it at the same time.
    unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
}
