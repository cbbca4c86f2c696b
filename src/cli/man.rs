//! `kugelblitz man`

use clap::CommandFactory;
use kugelblitz::{Error, Result};

use super::output::{STDOUT, print};
use super::{Cli, ManArgs};

/// Prints the manual page of the program or of one command.
pub fn run(args: &ManArgs) -> Result<()> {
    let mut program = Cli::command();
    program.build();
    let command = match &args.of {
        None => program,
        Some(name) => program.find_subcommand(name).cloned().ok_or_else(|| {
            Error::Usage(format!("there is no command `{name}`; see kugelblitz --help"))
        })?,
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page).map_err(Error::io(STDOUT))?;
    print(&page)
}
