//! The `nereus` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    nereus::cli::main(std::env::args_os())
}
