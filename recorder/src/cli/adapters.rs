//! `recorder adapters`.

use anyhow::Result;
use clap::Args;

use crate::machine::adapters;
use crate::output::{print, print_json};

#[derive(Debug, Args)]
pub(super) struct AdaptersArguments {
    /// Print the list as JSON on stdout.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &AdaptersArguments) -> Result<()> {
    let reports = adapters::reports();
    if arguments.json {
        return print_json(&reports);
    }
    if reports.is_empty() {
        print(format_args!("Recordings run on the cpu backend: {}", crate::device::GpuError::NoAdapter))?;
    }
    for report in &reports {
        print(report)?;
    }
    Ok(())
}
