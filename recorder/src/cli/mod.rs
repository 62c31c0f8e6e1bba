//! The command line: one file per command.

mod adapters;
mod bench;
mod demo;
mod import;
mod record;
mod replay;
mod scenes;
mod study;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::interrupt;
use crate::options::OptionError;
use crate::output::say;
use crate::study::PlanError;

const EXAMPLES: &str = "\
Examples:
  recorder demo
  recorder record scene.glb --out scene.raydump
  recorder record 'builtin:atrium?triangles=100000' --out atrium.raydump --preset paper
  recorder replay scene.raydump --out bits.raydump --methods two-point --key-bits 8,16,32
  recorder record scene.glb --out x.raydump --methods aila,two-point --method 'mine=(ox oy oz)*4 (u v ex ey ez)*10'

Exit codes: 0 done, 1 failed, 2 the command line makes no sense. Ended by SIGINT or SIGTERM, a recording
leaves a .partial folder, of which `inspector recover` makes a recording.";

/// Most characters of an error that are shown.
const ERROR_CHARACTERS: usize = 4000;

/// Records what happens to rays when a GPU path tracer reorders them.
#[derive(Debug, Parser)]
#[command(name = "recorder", version, about, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Record a built-in scene with all methods and show the results; under a minute without a GPU.
    Demo(demo::DemoArguments),
    /// Trace a scene and write a recording.
    Record(Box<record::RecordArguments>),
    /// Measure the rays of a recording again: other methods, bits, lengths, kernels or adapters.
    #[command(after_help = replay::EXAMPLES)]
    Replay(Box<replay::ReplayArguments>),
    /// Record rays that another tracer wrote.
    #[command(after_help = import::EXAMPLES)]
    Import(Box<import::ImportArguments>),
    /// Measure single stages.
    #[command(after_help = bench::EXAMPLES)]
    Bench(bench::BenchArguments),
    /// Make many recordings from one plan: scenes, cameras, seeds, and replays of each.
    #[command(after_help = study::EXAMPLES)]
    Study(study::StudyArguments),
    /// List the adapters of this machine and what the self-check finds.
    Adapters(adapters::AdaptersArguments),
    /// List the built-in scenes.
    Scenes(scenes::ScenesArguments),
}

/// The options that these words after `recorder record` stand for.
///
/// # Errors
/// As the command line would report them.
pub fn parse_record(words: impl Iterator<Item = OsString>) -> anyhow::Result<crate::options::RecordOptions> {
    Ok(parse_words::<record::RecordArguments>("record", words)?.options()?)
}

/// As if these words had been typed after the name of a command.
fn parse_words<A: Args>(
    command: &'static str,
    words: impl IntoIterator<Item = impl Into<OsString>>,
) -> Result<A, clap::Error> {
    let words = words.into_iter().map(Into::into);
    let line = std::iter::once(OsString::from(command)).chain(words);
    A::from_arg_matches(&A::augment_args(clap::Command::new(command)).try_get_matches_from(line)?)
}

/// Runs the program on the arguments of the process.
pub fn run() -> ExitCode {
    interrupt::end_with_parent();
    let command = Cli::parse().command;
    if let Err(error) = interrupt::listen() {
        say(format_args!("signals end the program without a word: {error}"));
    }
    let result = match command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Record(arguments) => record::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Import(arguments) => import::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
        Command::Adapters(arguments) => adapters::run(&arguments),
        Command::Scenes(arguments) => scenes::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // A file may have lists of any length.
            let sentence: String = format!("{error:#}").chars().take(ERROR_CHARACTERS).collect();
            say(format_args!("error: {sentence}"));
            ExitCode::from(if error.is::<OptionError>() || error.is::<PlanError>() { 2 } else { 1 })
        }
    }
}
