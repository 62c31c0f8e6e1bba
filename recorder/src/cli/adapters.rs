//! `recorder adapters`.

use anyhow::Result;
use clap::Args;

use crate::gpu::adapters;

#[derive(Debug, Args)]
pub(super) struct AdaptersArguments {
    /// Print the list as JSON on stdout.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &AdaptersArguments) -> Result<()> {
    let reports = adapters::reports();
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&reports)?);
        return Ok(());
    }
    if reports.is_empty() {
        println!(
            "No GPU adapter was found; recordings run on the cpu backend. {}",
            crate::gpu::GpuError::NoAdapter
        );
    }
    for report in &reports {
        println!("{report}");
    }
    Ok(())
}
