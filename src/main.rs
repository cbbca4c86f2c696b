//! The program `kugelblitz`: parse, run, print the error, exit code.

mod cli;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use kugelblitz::Result;
use kugelblitz::trace::Control;

use cli::{Cli, Command, Run, threads};

fn main() -> ExitCode {
    let run = Run { start: Instant::now(), control: Arc::new(Control::default()) };
    let cli = Cli::parse();
    stop_on_interrupt(Arc::clone(&run.control));
    let result = threads::start().and_then(|()| dispatch(cli.command, &run));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            cli::complain::complain(&error);
            ExitCode::from(error.exit_code())
        }
    }
}

fn dispatch(command: Command, run: &Run) -> Result<()> {
    match command {
        Command::Render(args) => cli::render::run(&args, run),
        Command::Verify(args) => cli::verify::run(&args, run),
        Command::Check(args) => cli::check::run(&args, run),
        Command::Trace(args) => cli::trace::run(&args, run),
        Command::Explain(args) => cli::explain::run(&args, run),
        Command::Report(args) => cli::report::run(&args, run),
        Command::Export(args) => cli::export::run(&args, run),
        #[cfg(feature = "view")]
        Command::View(args) => cli::view::run(&args, run),
        Command::Generate(args) => cli::generate::run(&args, run),
        Command::Probe(args) => cli::probe::run(&args),
        Command::Completions(args) => cli::completions::run(&args),
        Command::Man(args) => cli::man::run(&args),
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
        eprintln!("warning: Ctrl-C can't be handled: {error}");
    }
}
