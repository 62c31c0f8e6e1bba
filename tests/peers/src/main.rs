//! Our tracing and sorting beside that of others: the same rays and keys, in the same process, in turns.
//!
//! - [`rays`]: the rays of a recording
//! - [`contest`]: turns, rates and ratios
//! - [`tracing`]: our kernels beside [`embree`] and [`obvhs_tracer`]
//! - [`sorting`]: our sort beside crates
//! - [`table`]: all of it as Markdown

mod contest;
mod embree;
mod obvhs_tracer;
mod rays;
mod sorting;
mod table;
mod tracing;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};

use contest::Row;

/// Our tracing and sorting beside that of others, in turns
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Timed rounds; each contestant has a turn in each, in an order drawn for the round
    #[arg(long, global = true, default_value_t = 11)]
    rounds: usize,
    /// Numbers of threads
    #[arg(long, global = true, value_delimiter = ',', default_value = "1,2")]
    threads: Vec<usize>,
    /// Only contestants whose names contain one of these
    #[arg(long, global = true, value_delimiter = ',')]
    only: Vec<String>,
    /// JSON in place of Markdown
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Rays of recordings: camera, secondary, shuffled secondary and shadow rays
    Trace {
        /// Recordings of three bounces or more
        #[arg(required = true)]
        recordings: Vec<PathBuf>,
        /// Only these rays: camera, secondary, shuffled, shadow, secondary-shadow
        #[arg(long, value_delimiter = ',')]
        rays: Vec<String>,
        /// Another Embree, 3 or 4, beside the one that the system has; may be repeated
        #[arg(long, value_name = "LIBRARY")]
        embree: Vec<PathBuf>,
    },
    /// Random keys with 32-bit values
    Sort {
        /// Numbers of pairs
        #[arg(long, value_delimiter = ',', default_value = "65536,524288,2097152,8388608")]
        counts: Vec<usize>,
    },
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let mut rows = Vec::new();
    for &threads in &arguments.threads {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("starting threads")?;
        pool.install(|| in_pool(arguments, &mut rows))?;
    }
    if arguments.json {
        println!("{}", serde_json::to_string(&rows)?);
    } else {
        print!("{}", table::markdown(&rows));
    }
    Ok(())
}

/// What was asked for on the threads of the current pool.
fn in_pool(arguments: &Arguments, rows: &mut Vec<Row>) -> Result<()> {
    let is_wanted =
        |name: &str| arguments.only.is_empty() || arguments.only.iter().any(|part| name.contains(part));
    match &arguments.command {
        Command::Trace { recordings, rays, embree } => {
            for recording in recordings {
                rows.extend(tracing::compare(recording, rays, embree, &is_wanted, arguments.rounds)?);
            }
        }
        Command::Sort { counts } => {
            for &count in counts {
                rows.extend(sorting::compare(count, &is_wanted, arguments.rounds));
            }
        }
    }
    Ok(())
}
