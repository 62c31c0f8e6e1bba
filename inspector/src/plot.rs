//! `inspector plot` and `inspector report`: figures as files, and all of them on one page.

use std::path::{Path, PathBuf};

use formats::key::method::{Method, UNSORTED};
use formats::manifest::Source;
use formats::reader::Dump;
use serde::Serialize;

use crate::analysis::RecordingAnalysis;
use crate::figures::files;
use crate::figures::style::Width;
use crate::inputs::{Inputs, check_names, quoted};
use crate::method_table;
use crate::output::{counted, print, print_json};
use crate::report::{self, Report};

/// File name of the page.
const PAGE_NAME: &str = "report.html";

/// What `--json` prints.
#[derive(Serialize)]
struct Made {
    files: Vec<PathBuf>,
    skipped: Vec<Skipped>,
}

#[derive(Serialize)]
struct Skipped {
    figure: String,
    reason: String,
}

/// Writes the files of every figure, or of those of these names.
pub(crate) fn plot(
    paths: &[PathBuf],
    out: &Path,
    names: &[String],
    width: Width,
    json: bool,
) -> anyhow::Result<()> {
    check_names(names)?;
    let inputs = Inputs::open(paths)?;
    files::make_folder(out)?;
    let made = inputs.figures(&inputs.analysis()?, names)?;
    let mut written = Vec::new();
    for figure in &made.figures {
        eprintln!("{}", figure.name);
        written.extend(files::write(figure, width, out)?);
    }
    say(written, made.skipped, json)
}

/// Writes one page with every figure, the summary and how to repeat it.
pub(crate) fn report(paths: &[PathBuf], out: &Path, json: bool) -> anyhow::Result<()> {
    let inputs = Inputs::open(paths)?;
    files::make_folder(out)?;
    let analysis = inputs.analysis()?;
    let made = inputs.figures(&analysis, &[])?;
    let skipped = made.skipped.clone();
    let page = report::html(&Report {
        title: title(&inputs.recordings),
        facts: inputs.recordings.iter().zip(&analysis.recordings).map(facts).collect(),
        summary_header: method_table::COLUMNS.map(str::to_owned).to_vec(),
        summary: method_table::rows(&analysis),
        figures: made.figures,
        skipped: made.skipped,
        commands: commands(&inputs, paths, out),
    })?;
    let path = files::replace(&out.join(PAGE_NAME), page.as_bytes())?;
    say(vec![path], skipped, json)
}

fn say(files: Vec<PathBuf>, skipped: Vec<(String, String)>, json: bool) -> anyhow::Result<()> {
    let skipped: Vec<Skipped> =
        skipped.into_iter().map(|(figure, reason)| Skipped { figure, reason }).collect();
    if json {
        print_json(&Made { files, skipped })?;
    } else {
        let mut lines: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
        lines.extend(skipped.iter().map(|one| format!("left out: {}: {}", one.figure, one.reason)));
        lines.push(format!("{} written", counted(files.len() as u64, "file", "files")));
        print(&lines.join("\n"))?;
        if files.is_empty() {
            anyhow::bail!("nothing could be drawn of what was given");
        }
    }
    Ok(())
}

/// What was recorded, where and how: the name of a recording and a line about it.
fn facts((dump, analysis): (&Dump, &RecordingAnalysis)) -> (String, String) {
    let header = &dump.manifest().header;
    let options = &header.options;
    let line = format!(
        "{}, camera {}, {}×{}, {}, {}, {}; {}; {}-bit keys; timed by {}",
        counted(header.scene.triangles, "triangle", "triangles"),
        options.camera,
        options.width,
        options.height,
        counted(options.bounces.into(), "bounce", "bounces"),
        counted(options.passes.into(), "pass", "passes"),
        counted(options.repeats.into(), "repeat", "repeats"),
        analysis.configuration,
        options.key_bits,
        header.time_source
    );
    (analysis.label.clone(), line)
}

fn title(recordings: &[Dump]) -> String {
    let mut scenes: Vec<&str> = Vec::new();
    for recording in recordings {
        let name = recording.manifest().header.scene.name.as_str();
        if !scenes.contains(&name) {
            scenes.push(name);
        }
    }
    if scenes.is_empty() {
        "Ray reordering".to_owned()
    } else {
        format!("Ray reordering: {}", scenes.join(", "))
    }
}

/// The commands that make the recordings, the measurements and this page.
fn commands(inputs: &Inputs, paths: &[PathBuf], out: &Path) -> Vec<String> {
    let mut commands: Vec<String> = inputs.recordings.iter().map(record_command).collect();
    commands.extend(inputs.benches.iter().map(|bench| bench.command.clone()));
    let inputs: Vec<String> = paths.iter().map(|path| quoted(path)).collect();
    commands.push(format!("inspector report {} --out {}", inputs.join(" "), quoted(out)));
    commands
}

/// The command that makes a recording again. A recording knows its scene by name and content, not
/// where its file was.
fn record_command(recording: &Dump) -> String {
    let header = &recording.manifest().header;
    let scene = &header.scene;
    let out = quoted(recording.root().file_name().map_or(recording.root(), Path::new));
    let (verb, comment) = match &header.source {
        Source::Replayed { name, .. } => {
            (format!("recorder replay {}", quoted(Path::new(name))), String::new())
        }
        source => {
            let hash: String = scene.content_hash[..6].iter().map(|byte| format!("{byte:02x}")).collect();
            let verb = match source {
                Source::Imported { name, .. } => {
                    format!("recorder import --scene SCENE --rays {}", quoted(Path::new(name)))
                }
                _ => format!("recorder record SCENE {}", path_options(recording)),
            };
            (verb, format!("    # SCENE: {}, content {hash}…", scene.name))
        }
    };
    format!("{verb} --out {out} {}{comment}", measuring_options(recording))
}

/// The options that decide which rays there are.
fn path_options(recording: &Dump) -> String {
    let options = &recording.manifest().header.options;
    format!(
        "--width {} --height {} --bounces {} --passes {} --seed {} --camera {} --keep {} --keep-passes {}",
        options.width,
        options.height,
        options.bounces,
        options.passes,
        options.seed,
        quoted(Path::new(&options.camera)),
        options.keep.join(","),
        options.keep_passes,
    )
}

/// The options that decide what is measured on them.
fn measuring_options(recording: &Dump) -> String {
    let manifest = recording.manifest();
    let options = &manifest.header.options;
    let is_builtin = |name: &str| name == UNSORTED || Method::builtin(name).is_ok();
    let builtin: Vec<&str> =
        options.methods.iter().map(String::as_str).filter(|name| is_builtin(name)).collect();
    let own =
        manifest.methods.iter().filter(|method| method.base == method.name && !is_builtin(&method.name));
    let own: String = own.map(|method| format!(" --method '{}={}'", method.name, method.text)).collect();
    format!(
        "--backend {} --trace {} --repeats {} --methods {}{own} --key-bits {} --two-point-length {} \
         --table-bits {} --table-method {}",
        manifest.header.backend.name(),
        options.trace_kernel,
        options.repeats,
        builtin.join(","),
        options.key_bits,
        options.two_point_length,
        options.table_bits,
        options.table_method,
    )
}
