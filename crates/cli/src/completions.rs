//! `kugelblitz completions`

use clap::CommandFactory;
use kugelblitz::Result;

use crate::args::{Cli, CompletionsArgs};
use crate::output::print;

/// Prints a completion script.
pub fn run(args: &CompletionsArgs) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "kugelblitz", &mut script);
    print(&script)
}
