//! The `inspector` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    inspector::cli::run(std::env::args_os())
}
