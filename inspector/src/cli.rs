//! The command line: what was typed, and the exit code that comes of it.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::analysis::{Depth, GroupWidth, Options};
use crate::{info, recover, verify};

/// The command failed, and said why on standard error.
const FAILED: u8 = 1;
/// The command line cannot be understood.
const USAGE: u8 = 2;

const EXAMPLES: &str = "\
Examples:
  inspector info sponza.raydump             what was recorded, on which machine, with which times
  inspector info sponza.raydump --json      the same as one JSON object
  inspector info sponza.raydump --metrics   how coherent the rays of each order are
  inspector verify sponza.raydump           whether every array is what the format says it is
  inspector recover sponza.raydump.partial  make a recording of what a killed recorder left

Exit codes: 0 done, 1 failed (for verify: something is wrong), 2 the command line is wrong.";

const INFO_EXAMPLES: &str = "\
Examples:
  inspector info sponza.raydump
  inspector info sponza.raydump --metrics   capsules, direction spread, lanes and length tables too
  inspector info sponza.raydump --metrics --group-width 32
  inspector info sponza.raydump.partial     what a running or killed recorder has written so far
  inspector info sponza.raydump --json | jq '.timings[] | select(.stage == \"trace\")'
  inspector info sponza.raydump --json --metrics | jq '.metrics.summaries'";

const VERIFY_EXAMPLES: &str = "\
Checks checksums, shapes and element types; that permutations are bijections and keys ascend under
them; keys recomputed from the stored rays; hits against their rays and triangles; length tables.

Examples:
  inspector verify sponza.raydump           exit code 1 if anything is wrong
  inspector verify sponza.raydump --json | jq '.checks[] | select(.problems.count > 0)'";

const RECOVER_EXAMPLES: &str = "\
Keeps the longest run of complete arrays and gives it the recording's name. Nothing is deleted: what
does not belong to it is moved to NAME.raydump.leftover.

Examples:
  inspector recover sponza.raydump.partial  after a crash, a kill or a full disk
  inspector recover sponza.raydump          the same, or a recording whose files were damaged";

/// Looks at Rayscope recordings.
#[derive(Debug, Parser)]
#[command(name = "inspector", version, after_help = EXAMPLES)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show what a recording holds.
    #[command(after_help = INFO_EXAMPLES)]
    Info(InfoTarget),
    /// Check whether a recording is what the format says it is.
    #[command(after_help = VERIFY_EXAMPLES)]
    Verify(Target),
    /// Make a recording of what a killed recorder or a damaged disk left.
    #[command(after_help = RECOVER_EXAMPLES)]
    Recover(Target),
}

/// What a command looks at.
#[derive(Debug, Args)]
struct Target {
    /// The recording: a folder NAME.raydump, or NAME.raydump.partial.
    #[arg(value_name = "X.raydump")]
    dump: PathBuf,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
}

/// What `info` looks at, and how deep.
#[derive(Debug, Args)]
struct InfoTarget {
    #[command(flatten)]
    target: Target,
    /// Read the arrays too: capsules, direction spread, lane utilisation, length tables, correlations.
    #[arg(long)]
    metrics: bool,
    /// Rays of a group, whose capsule and direction spread are taken.
    #[arg(long, value_enum, default_value_t, requires = "metrics")]
    group_width: GroupWidth,
    /// Threads that read the arrays; the numbers do not depend on it [default: one per processor].
    #[arg(long, value_name = "N", requires = "metrics", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

impl InfoTarget {
    fn options(&self) -> Options {
        Options {
            group_width: self.group_width,
            threads: self.threads.map(usize::from),
            depth: if self.metrics { Depth::Arrays } else { Depth::Manifest },
        }
    }
}

/// Runs the command that `arguments` (the program's name first) ask for.
pub fn run(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    let command_line = match CommandLine::try_parse_from(arguments) {
        Ok(command_line) => command_line,
        Err(error) => {
            // Nothing can be said where even this cannot be printed.
            let _ = error.print();
            return if error.use_stderr() { ExitCode::from(USAGE) } else { ExitCode::SUCCESS };
        }
    };
    let done = match command_line.command {
        Command::Info(info) => info::run(&info.target.dump, info.target.json, &info.options()),
        Command::Verify(Target { dump, json }) => verify::run(&dump, json),
        Command::Recover(Target { dump, json }) => recover::run(&dump, json),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(FAILED)
        }
    }
}
