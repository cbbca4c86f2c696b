//! The program `kugelblitz`.

use std::process::ExitCode;

fn main() -> ExitCode {
    kugelblitz_cli::main_of::<kugelblitz_cli::Cli>()
}
