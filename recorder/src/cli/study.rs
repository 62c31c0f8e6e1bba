//! `recorder study`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{Args, Subcommand};
use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{CellAlignment, Table};
use formats::study::SLURM_NAME;
use formats::text::counted;
use indicatif::HumanBytes;
use serde_json::{Value, json};

use super::parse_words;
use super::record::RecordArguments;
use super::replay::ReplayArguments;
use crate::output::{print, print_json, say};
use crate::study::PlanError;
use crate::study::estimate::Estimate;
use crate::study::jobs::{Job, Jobs, jobs};
use crate::study::plan::{self, Plan};
use crate::study::run::{self, LOG_NAME};
use crate::study::slurm::Array;
use crate::study::state::{Experience, State, folder, state, strays};
use crate::study::words::{Commands, Parser};

pub(super) const EXAMPLES: &str = "\
Examples:
  recorder study plan quick.toml
  recorder study run quick.toml --out quick
  recorder study status quick.toml --out quick
  recorder study run paper.toml --scenes rooms/ --out paper
  recorder study run paper.toml --out paper --job 3
  SBATCH_PARTITION=gpu SBATCH_GPUS=1 recorder study run paper.toml --out paper --slurm --constraint a100
  inspector report quick --out report

A plan:
  scenes = [\"builtin:cornell\", { file = \"sponza.glb\", cameras = [\"nave\"] }]
  cameras = 3                # of the other scenes: \"first\" (the default), \"all\", names, or n automatic views
  seeds = [0, 1]
  [record]                   # options of `recorder record` by their long names
  width = 640
  methods = [\"aila\", \"two-point\"]
  [replay.bits]              # bits.raydump: a replay of each recording, made in the same job
  key-bits = [8, 16, 32]

Killed at any time, the same command makes what is not finished. A job whose scene, camera or options are other
ones by now, or that failed, is made again.

With Slurm: --slurm hands the jobs that are left to one array, each a task with a node to itself. The program, the
plan, its scenes and the folder lie where all nodes see them. Further options of sbatch are taken from its environment
variables: SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_TIMELIMIT, SBATCH_GPUS and so on.";

#[derive(Debug, Args)]
pub(super) struct StudyArguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Check a plan and list its jobs: about how long they take and how much they write.
    Plan(PlanArguments),
    /// Make all jobs of a plan that are not finished, one after the other.
    Run(RunArguments),
    /// What is finished, what failed and why, and what is left.
    Status(FolderArguments),
}

#[derive(Debug, Args)]
struct PlanArguments {
    /// The plan, a TOML file; its scenes are relative to it.
    #[arg(value_name = "STUDY.toml")]
    file: PathBuf,
    /// Take all .glb and .gltf files of this folder in place of the plan's scenes.
    #[arg(long, value_name = "FOLDER")]
    scenes: Option<PathBuf>,
    /// Print the result as one JSON object on stdout.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct FolderArguments {
    #[command(flatten)]
    plan: PlanArguments,
    /// Folder of the study.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Debug, Args)]
struct RunArguments {
    #[command(flatten)]
    folder: FolderArguments,
    /// Make this job alone, by its number in `recorder study plan`.
    #[arg(long, value_name = "N")]
    job: Option<usize>,
    /// Hand the jobs that are left to Slurm, as one array, and return.
    #[arg(long, conflicts_with = "job")]
    slurm: bool,
    /// Take only nodes with these features, as `sbatch --constraint` does.
    #[arg(long, value_name = "FEATURES", requires = "slurm")]
    constraint: Option<String>,
    /// Wait until Slurm has ended all tasks, and say how they ended.
    #[arg(long, requires = "slurm")]
    wait: bool,
}

pub(super) fn run(arguments: &StudyArguments) -> Result<()> {
    match &arguments.what {
        What::Plan(arguments) => show_plan(arguments),
        What::Run(arguments) => make(arguments),
        What::Status(arguments) => show_status(arguments),
    }
}

fn read(arguments: &PlanArguments) -> Result<(Plan, Jobs)> {
    let record = Parser {
        command: RecordArguments::augment_args(clap::Command::new("record")),
        options: |words| Ok(parse_words::<RecordArguments>("record", words)?.options()?),
    };
    let replay = Parser {
        command: ReplayArguments::augment_args(clap::Command::new("replay")),
        options: |words| Ok(parse_words::<ReplayArguments>("replay", words)?.options()?),
    };
    let commands = Commands { record, replay };
    let plan = plan::read(&arguments.file, arguments.scenes.as_deref(), &commands)?;
    let jobs = jobs(&plan).with_context(|| format!("{} cannot be run", arguments.file.display()))?;
    Ok((plan, jobs))
}

fn show_plan(arguments: &PlanArguments) -> Result<()> {
    let (plan, Jobs { jobs, problems }) = read(arguments)?;
    if !problems.is_empty() {
        let place = arguments.file.display();
        let problems = problems.iter().map(|problem| format!("{place}: {problem}")).collect();
        return Err(PlanError { problems }.into());
    }
    let experience = Experience::of(std::iter::empty());
    let left: Estimate = jobs.iter().map(|job| job.estimate).sum();
    if arguments.json {
        let rows: Vec<Value> = jobs.iter().map(|job| job_json(job, None, &experience)).collect();
        return print_json(&json!({ "jobs": rows, "left": left_json(left, &experience) }));
    }
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY);
    table.set_header(["job", "name", "scene", "camera", "seed", "recordings", "about", "on disk"]);
    let recordings = std::iter::once(&plan.record.name).chain(plan.replays.iter().map(|replay| &replay.name));
    let recordings = recordings.cloned().collect::<Vec<_>>().join(", ");
    for job in &jobs {
        table.add_row([
            job.number.to_string(),
            job.name.clone(),
            job.scene.clone(),
            job.camera.clone(),
            job.seed.to_string(),
            recordings.clone(),
            duration(job.estimate.seconds),
            bytes(job.estimate.bytes),
        ]);
    }
    for column in [0, 4, 6, 7] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let of_jobs = counted(jobs.len() as u64, "job", "jobs");
    print(format_args!("{table}\n{of_jobs}: {}", left_words(left, &experience)))
}

fn make(arguments: &RunArguments) -> Result<()> {
    let FolderArguments { plan: planned, out } = &arguments.folder;
    // What is wrong with scenes and cameras is what their jobs fail by.
    let (plan, Jobs { jobs, problems }) = read(planned)?;
    let chosen: Vec<&Job> = match arguments.job {
        None => jobs.iter().collect(),
        Some(number) => {
            let job = number.checked_sub(1).and_then(|at| jobs.get(at));
            vec![job.with_context(|| format!("--job {number}: the plan has jobs 1 to {}", jobs.len()))?]
        }
    };
    run::prepare(out, &plan)?;
    if problems.is_empty() {
        say_strays(out, &jobs)?;
    }
    let states = match arguments.slurm {
        false => run::run(out, &chosen)?,
        true => match by_slurm(arguments, &jobs)? {
            Some(states) => states,
            None => return Ok(()),
        },
    };
    let ended: Vec<(&Job, &State)> = chosen.iter().copied().zip(&states).collect();
    if planned.json {
        print_json(&result_json(&ended))?;
    } else {
        print(result_words(&ended, out))?;
    }
    let failed = ended.iter().filter(|(_, state)| matches!(state, State::Failed(_)));
    let failed: Vec<&Job> = failed.map(|(job, _)| *job).collect();
    let all = counted(chosen.len() as u64, "job", "jobs");
    if !failed.is_empty() {
        // Without a scene or camera there is no log, and nothing more to say.
        let begun = failed.iter().find(|job| job.problem.is_none());
        let log = begun.map(|job| format!("; see {}", folder(out, job).join(LOG_NAME).display()));
        bail!("{} of {all} failed{}", failed.len(), log.unwrap_or_default());
    }
    let unfinished = states.iter().filter(|state| !matches!(state, State::Finished(_))).count();
    if unfinished > 0 {
        let logs = out.join(SLURM_NAME);
        let all = counted(chosen.len() as u64, "job is", "jobs are");
        bail!("{unfinished} of {all} not finished; see {}", logs.display());
    }
    Ok(())
}

/// Hands what is left to Slurm; how it ended, if that was waited for.
fn by_slurm(arguments: &RunArguments, jobs: &[Job]) -> Result<Option<Vec<State>>> {
    let FolderArguments { plan: planned, out } = &arguments.folder;
    let before = states(out, jobs)?;
    let is_left = |state: &State| matches!(state, State::Failed(_) | State::Waiting);
    let numbers: Vec<usize> =
        jobs.iter().zip(&before).filter(|(_, state)| is_left(state)).map(|(job, _)| job.number).collect();
    if numbers.is_empty() {
        return Ok(Some(before));
    }
    let array = Array {
        file: &planned.file,
        scenes: planned.scenes.as_deref(),
        out,
        numbers: &numbers,
        constraint: arguments.constraint.as_deref(),
        wait: arguments.wait,
    };
    let submitted = |number: &str| {
        let all = counted(jobs.len() as u64, "job", "jobs");
        let words = format!("Slurm has {} of {all} as array {number}", numbers.len());
        match (arguments.wait, planned.json) {
            (true, _) => say(format_args!("{words}; waiting for them")),
            (false, true) => return print_json(&json!({ "array": number, "jobs": numbers })),
            (false, false) => {
                let how = "`recorder study status` says how far they are, `squeue` what waits for what";
                return print(format_args!("{words}; {how}"));
            }
        }
        Ok(())
    };
    array.submit(submitted)?;
    arguments.wait.then(|| states(out, jobs)).transpose()
}

fn states(out: &Path, jobs: &[Job]) -> Result<Vec<State>> {
    Ok(jobs.iter().map(|job| state(out, job)).collect::<Result<_, _>>()?)
}

fn show_status(arguments: &FolderArguments) -> Result<()> {
    let FolderArguments { plan, out } = arguments;
    let (_, Jobs { jobs, problems }) = read(plan)?;
    let states = states(out, &jobs)?;
    let found: Vec<(&Job, &State)> = jobs.iter().zip(&states).collect();
    if plan.json {
        return print_json(&result_json(&found));
    }
    if problems.is_empty() {
        say_strays(out, &jobs)?;
    }
    print(result_words(&found, out))
}

/// Of a plan whose scenes and cameras are there: without them the names of its jobs are not known.
fn say_strays(out: &Path, jobs: &[Job]) -> Result<()> {
    let strays = strays(out, jobs).with_context(|| format!("cannot list {}", out.display()))?;
    if let Some(first) = strays.first() {
        say(format_args!(
            "{} of the jobs in {} are none of the plan's, such as {first}; what reads the study reads them, too: remove them if they are of no use",
            strays.len(),
            out.display()
        ));
    }
    Ok(())
}

/// What is left of these jobs, and what the finished ones say about it.
fn left(found: &[(&Job, &State)]) -> (Estimate, Experience) {
    let unfinished = found.iter().filter(|(_, state)| !matches!(state, State::Finished(_)));
    (unfinished.map(|(job, _)| job.estimate).sum(), Experience::of(found.iter().copied()))
}

fn result_words(found: &[(&Job, &State)], out: &Path) -> String {
    let counts = ["finished", "failed", "running", "waiting"].into_iter().filter_map(|word| {
        let count = found.iter().filter(|(_, state)| state.word() == word).count();
        (count > 0).then(|| format!("{count} {word}"))
    });
    let records = || found.iter().filter_map(|(_, state)| state.record());
    let (seconds, written) =
        records().fold((0.0, 0_u64), |(s, b), record| (s + record.seconds, b.saturating_add(record.bytes)));
    let mut lines = vec![format!(
        "{} of {} in {}: {}, {}",
        counts.collect::<Vec<_>>().join(", "),
        counted(found.len() as u64, "job", "jobs"),
        out.display(),
        duration(seconds),
        HumanBytes(written)
    )];
    for (job, state) in found {
        if let Some(failure) = state.record().and_then(|record| record.failure.as_ref()) {
            lines.push(format!("job {} {} failed: {failure}", job.number, job.name));
        }
        if matches!(state, State::Running) {
            lines.push(format!("job {} {} is running", job.number, job.name));
        }
    }
    let (left, experience) = left(found);
    if left.seconds > 0.0 {
        lines.push(format!("left: {}", left_words(left, &experience)));
    }
    lines.join("\n")
}

fn left_words(left: Estimate, experience: &Experience) -> String {
    let [least, median, most] = experience.seconds.map(|factor| duration(factor * left.seconds));
    let (about, at_most) = (bytes(experience.bytes(left)), bytes(left.bytes_max));
    format!("about {median} ({least} to {most}), about {about} on disk (at most {at_most})")
}

fn left_json(left: Estimate, experience: &Experience) -> Value {
    let [least, median, most] = experience.seconds.map(|factor| factor * left.seconds);
    json!({
        "seconds": median,
        "seconds_from": least,
        "seconds_to": most,
        "bytes": experience.bytes(left),
        "bytes_at_most": left.bytes_max,
    })
}

fn result_json(found: &[(&Job, &State)]) -> Value {
    let (left, experience) = left(found);
    let rows: Vec<Value> = found.iter().map(|(job, state)| job_json(job, Some(state), &experience)).collect();
    json!({ "jobs": rows, "left": left_json(left, &experience) })
}

fn job_json(job: &Job, state: Option<&State>, experience: &Experience) -> Value {
    let mut row = json!({
        "number": job.number,
        "name": job.name,
        "scene": job.scene,
        "camera": job.camera,
        "seed": job.seed,
        "commands": job.commands.iter().map(|command| command.typed()).collect::<Vec<_>>(),
        "estimated_seconds": experience.seconds(job.estimate),
        "estimated_bytes": experience.bytes(job.estimate),
    });
    if let Some(state) = state {
        let record = state.record();
        row["state"] = state.word().into();
        row["seconds"] = json!(record.map(|record| record.seconds));
        row["bytes"] = json!(record.map(|record| record.bytes));
        row["failure"] = json!(record.and_then(|record| record.failure.as_ref()));
    }
    row
}

fn bytes(bytes: f64) -> String {
    HumanBytes(bytes as u64).to_string()
}

/// Seconds in the unit that fits.
fn duration(seconds: f64) -> String {
    match seconds {
        ..100.0 => format!("{seconds:.1} s"),
        ..6000.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}
