//! The `nereus` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(unix)]
    nereus::cli::with_large_pages();
    nereus::cli::main(std::env::args_os())
}
