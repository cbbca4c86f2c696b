//! `kugelblitz completions`

use clap::CommandFactory;
use kugelblitz::Result;

use super::output::print;
use super::{Cli, CompletionsArgs};

/// Prints a completion script.
pub fn run(args: &CompletionsArgs) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "kugelblitz", &mut script);
    print(&script)
}
