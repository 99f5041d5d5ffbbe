//! The command `nndd`, see the library of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    nndd_cli::run()
}
