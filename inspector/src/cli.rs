//! The command line: what was typed, and the exit code that comes of it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::LazyLock;

use clap::{Args, Parser, Subcommand};

use crate::analysis::{AnalysisOptions, Depth, GroupWidth};
use crate::output::{print, say, sentence};
use crate::session::Session;
use crate::shot::Shot;
use crate::shot::draw::STARTED;
use crate::{app, export, info, plot, recover, verify};

/// The command failed, and said why on standard error.
const FAILED: u8 = 1;
/// The command line cannot be understood.
const USAGE: u8 = 2;

const EXAMPLES: &str = "\
Examples:
  inspector sponza.raydump                  look at it in the window
  inspector --session view.json             as it was saved by File > Save session
  inspector shot sponza.raydump --view order --method two-point --out order.png
  inspector info sponza.raydump             what was recorded, on which machine, with which times
  inspector info sponza.raydump --json      the same as one JSON object
  inspector info sponza.raydump --metrics   how coherent the rays of each order are
  inspector verify sponza.raydump           whether every array is what the format says it is
  inspector recover sponza.raydump.partial  make a recording of what a killed recorder left
  inspector plot *.raydump --out figures/   every figure as SVG, PDF, PNG, CSV, LaTeX and caption
  inspector report *.raydump --out page/    one page with all of them
  inspector export sponza.raydump --format ply --out rays/

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
Keeps every complete array whose record can be read and gives it the recording's name. Nothing is deleted: what
does not belong to it is moved to NAME.raydump.leftover.

Examples:
  inspector recover sponza.raydump.partial  after a crash, a kill or a full disk
  inspector recover sponza.raydump          the same, or a recording whose files were damaged";

const PLOT_EXAMPLES: &str = "\
Each figure is NAME.svg, .pdf, .png (300 dpi), .csv (every number), .tex (pgfplots, reads the CSV), .txt (caption
and settings) and .caption.tex (the same for LaTeX). Widths are those of a two-column page: 3.5 in and 7 in.

Examples:
  inspector plot sponza.raydump kitchen.raydump --out figures/
  inspector plot sort.json --out figures/   what `recorder bench sort --json > sort.json` measured
  inspector plot *.raydump sort.json --out figures/ --figure trace-speedup --width two-column
  inspector plot *.raydump --out figures/ --figure net-speedup --methods aila,two-point,auto";

const REPORT_EXAMPLES: &str = "\
Writes DIR/report.html, which needs no other file, no network and no scripts, and prints well; tables.md; tables.tex.

Examples:
  inspector report sponza.raydump --out page/
  inspector report *.raydump sort.json trace.json --out page/";

const SHOT_EXAMPLES: &str = "\
Draws what the window draws, without a screen; the same command gives the same file. Where something that the
view shows was not kept or is damaged, the picture says so and is written, and the exit code is 1.

Examples:
  inspector shot sponza.raydump --view window --out window.png
  inspector shot sponza.raydump --view order --bounce 2 --method two-point --out order.png
  inspector shot sponza.raydump --view capsules --method costa --set mesh=ghost --out capsules.png
  inspector shot sponza.raydump --view window --size 2560x1440 --scale 2 --theme light --out window.png
  inspector shot sponza.raydump --view capsules --film orbit --frames 240 --out film.png    film-0000.png and so on
  inspector shot --session view.json --view order --out view.png         as it was saved in the window
  inspector shot other.raydump --session view.json --out other.png       the same of another recording
  inspector shot sponza.raydump --view order --set mesh=wire --set clip_at=0.5 --camera \"0.5 0.2 0.3 1.2 -0.3 0.8\" --out c.png
  inspector shot sponza.raydump --view rays --set colour_by=length --set detail=5000 --out rays.png
  inspector shot sponza.raydump --view capsules --set group_width=32 --set group=7 --set capsule_choice=selected --out g.png
  inspector shot sponza.raydump --view rays --json --out rays.png        frame times, draws, memory

Each panel of the window saves its session and shows the command that draws it: ... > Show command.";

const EXPORT_EXAMPLES: &str = "\
csv: one file of rays with their hits, in the order of a method. ply: rays and the curve of the order
as edges, hits as points, capsules as meshes, all coloured by place in the order. parquet: all rays in all
orders, all times, and what `info --metrics` says, of a recording or a study, as tables for DuckDB, Polars,
Spark and their like.

Examples:
  inspector export sponza.raydump --format csv --out rays/
  inspector export sponza.raydump --format ply --out rays/ --bounce 2 --method two-point
  inspector export sponza.raydump --format ply --out rays/ --kind shadow --method aila --group 100
  inspector export sponza.raydump --format csv --out rays/ --filter 'hit && length < 0.1'
  inspector export sponza.raydump --format parquet --out sponza/
  inspector export study/ --format parquet --out tables/ --kind closest --method two-point";

/// Looks at Rayscope recordings.
#[derive(Debug, Parser)]
#[command(
    name = "inspector",
    version,
    after_help = EXAMPLES,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    /// Recordings (folders NAME.raydump) to open in the window.
    #[arg(value_name = "X.raydump")]
    dumps: Vec<PathBuf>,
    /// Opens the window as it was saved by File > Save session.
    #[arg(long, value_name = "FILE")]
    session: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show what a recording holds and what sorting was worth, or the means of a study.
    #[command(after_help = INFO_EXAMPLES)]
    Info(InfoTarget),
    /// Check whether a recording is what the format says it is.
    #[command(after_help = VERIFY_EXAMPLES)]
    Verify(Target),
    /// Make a recording of what a killed recorder or a damaged disk left.
    #[command(after_help = RECOVER_EXAMPLES)]
    Recover(Target),
    /// Draw figures for a paper from recordings, studies and benchmark results.
    #[command(after_help = PLOT_EXAMPLES)]
    Plot(plot::Plot),
    /// Make one page of figures and tables from recordings, studies and benchmark results.
    #[command(after_help = REPORT_EXAMPLES)]
    Report(plot::Sources),
    /// Draw the window, or one view of it, into a file.
    #[command(after_help = SHOT_EXAMPLES)]
    Shot(Box<Shot>),
    /// Write rays, hits, orders and capsules for other programs.
    #[command(after_help = EXPORT_EXAMPLES)]
    Export(export::Export),
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
    /// Also show all settings, queues, the times of every stage by bounce, and arrays.
    #[arg(long, conflicts_with = "json")]
    details: bool,
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
    fn options(&self) -> AnalysisOptions {
        AnalysisOptions {
            group_width: self.group_width,
            threads: self.threads.map(usize::from),
            depth: if self.metrics { Depth::Arrays } else { Depth::Manifest },
        }
    }
}

/// Runs the command that `arguments` (the program's name first) ask for.
pub fn run(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> ExitCode {
    LazyLock::force(&STARTED);
    if rayon::ThreadPoolBuilder::new().build_global().is_err() {
        // Where the system gives no more threads, this one does the work; what fails then, fails by itself.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
    }
    let command_line = match CommandLine::try_parse_from(arguments) {
        Ok(command_line) => command_line,
        Err(error) => return explain(&error),
    };
    let Some(command) = command_line.command else {
        return window(command_line.dumps, command_line.session.as_deref());
    };
    let done = match command {
        Command::Info(info) => info::run(&info.target.dump, info.target.json, info.details, &info.options()),
        Command::Verify(Target { dump, json }) => verify::run(&dump, json),
        Command::Recover(Target { dump, json }) => recover::run(&dump, json),
        Command::Plot(plot) => plot::plot(&plot),
        Command::Report(sources) => plot::report(&sources),
        Command::Export(export) => export::run(&export),
        Command::Shot(shot) => shot.run(),
    };
    exit_code(done)
}

/// Prints what is wrong with a command line, or the help or version that it asks for.
fn explain(error: &clap::Error) -> ExitCode {
    if error.use_stderr() {
        // It quotes what was typed, and a shell types names of files.
        say(error.render().to_string().trim_end());
        return ExitCode::from(USAGE);
    }
    exit_code(print(&error.render().to_string()))
}

/// Opens the window on recordings. A word that is neither a file nor looks like one is a mistyped command.
fn window(dumps: Vec<PathBuf>, session: Option<&Path>) -> ExitCode {
    let is_word =
        |path: &&PathBuf| path.extension().is_none() && path.components().count() == 1 && !path.exists();
    match dumps.iter().find(is_word) {
        None => exit_code(
            session.map(Session::read).transpose().and_then(|session| app::run::run(&dumps, session)),
        ),
        Some(word) => {
            say(&format!(
                "error: there is no command and no recording '{}'; `inspector --help` lists the commands",
                word.display()
            ));
            ExitCode::from(USAGE)
        }
    }
}

fn exit_code(done: anyhow::Result<()>) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("error: {}", sentence(&error)));
            ExitCode::from(FAILED)
        }
    }
}
