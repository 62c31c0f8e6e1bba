//! The recorder's binary.

use std::process::ExitCode;

fn main() -> ExitCode {
    recorder::cli::run()
}
