//! `inspector plot` and `inspector report`: figures as files, and all of them on one page.

use std::path::{Path, PathBuf};

use clap::Args;
use formats::key::Termination;
use formats::key::method::{CONTROL, Method, WITHOUT_LAYOUT};
use formats::manifest::{Backend, Header, Manifest, MethodRecord, Options, Source};
use formats::metrics::speedup::Verdict;
use formats::reader::Dump;
use formats::summary::hexadecimal;
use formats::text::shell_word;
use serde::Serialize;

use crate::analysis::study::StudyGroup;
use crate::analysis::summary::{RayClass, distinct};
use crate::analysis::{Analysis, FrameAnalysis, RecordingAnalysis};
use crate::figures::catalogue::Skipped;
use crate::figures::catalogue::study::label;
use crate::figures::files;
use crate::figures::model::{Content, Figure, Panel, Picture};
use crate::figures::style::Width;
use crate::inputs::{Inputs, check_names, quoted};
use crate::output::{counted, print, print_json, say};
use crate::report::table::{latex, markdown};
use crate::report::tables::tables;
use crate::report::{self, Report};
use crate::shown;

/// File name of the page.
const PAGE_NAME: &str = "report.html";

const HOW_TO_HAVE_ARRAYS: &str = "arrays are kept with `recorder record --keep`; those of a replay's source are found if it lies beside the replay";

/// What files are made of, and where they go.
#[derive(Debug, Args)]
pub(crate) struct Sources {
    /// Recordings (folders NAME.raydump), folders of studies and files that `recorder bench --json` printed.
    #[arg(value_name = "X", required = true)]
    inputs: Vec<PathBuf>,
    /// The folder for the files; it is made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
}

/// Figures as files.
#[derive(Debug, Args)]
pub(crate) struct Plot {
    #[command(flatten)]
    sources: Sources,
    /// Only these figures.
    #[arg(long = "figure", value_name = "NAME", num_args = 1.., value_delimiter = ',')]
    figures: Vec<String>,
    /// Only these methods and their variants, beside unsorted rays; `control` is one of them.
    #[arg(long, value_name = "LIST", num_args = 1.., value_delimiter = ',')]
    methods: Vec<String>,
    /// How wide figures are on paper.
    #[arg(long, value_enum, default_value_t = Width::OneColumn)]
    width: Width,
}

/// What was written, as `--json` prints it.
#[derive(Debug, Serialize)]
pub(crate) struct Made {
    pub(crate) files: Vec<PathBuf>,
    skipped: Vec<Skipped>,
    /// Why inputs could not be used.
    left_out: Vec<String>,
}

/// Writes the files of every figure, or of those that are named.
pub(crate) fn plot(Plot { sources, figures, methods, width }: &Plot) -> anyhow::Result<()> {
    check_names(figures)?;
    make_folder(&sources.out)?;
    let inputs = Inputs::open(&sources.inputs)?;
    let mut analysis = inputs.analysis()?;
    if !methods.is_empty() {
        analysis = analysis.only(methods).map_err(anyhow::Error::msg)?;
    }
    let made = make(&inputs, &analysis, figures, *width, &sources.out, say)?;
    print_made(&made, sources.json)
}

/// Writes the files of every figure, or of those that are named, into a folder, which is made if there are any;
/// `begun` takes the name of each.
pub(crate) fn make(
    inputs: &Inputs,
    analysis: &Analysis,
    names: &[String],
    width: Width,
    out: &Path,
    begun: impl Fn(&str),
) -> anyhow::Result<Made> {
    let (figures, skipped) = inputs.figures(analysis, names)?;
    if !figures.is_empty() {
        make_folder(out)?;
    }
    let mut written = Vec::new();
    for figure in &figures {
        begun(&figure.name);
        written.extend(files::write(figure, width, out)?);
    }
    Ok(Made { files: written, skipped, left_out: inputs.left_out.clone() })
}

/// Writes one page with every figure, every table and how to repeat it, and the tables for other documents.
pub(crate) fn report(sources: &Sources) -> anyhow::Result<()> {
    let inputs = Inputs::open(&sources.inputs)?;
    make_folder(&sources.out)?;
    let analysis = inputs.analysis()?;
    let (figures, skipped) = inputs.figures(&analysis, &[])?;
    let report = Report {
        title: title(&inputs.recordings),
        pictures: photographs(&figures),
        findings: findings(&analysis),
        tables: tables(&analysis, &inputs.benches),
        left_out: inputs.left_out.clone(),
        facts: inputs.recordings.iter().zip(&analysis.recordings).map(facts).collect(),
        figures,
        skipped,
        commands: commands(&inputs, sources),
    };
    let page = report::html(&report)?;
    let mut written = vec![files::replace(&sources.out.join(PAGE_NAME), page.as_bytes())?];
    if !report.tables.is_empty() {
        for (name, text) in [("tables.md", markdown(&report.tables)), ("tables.tex", latex(&report.tables))] {
            written.push(files::replace(&sources.out.join(name), text.as_bytes())?);
        }
    }
    let Report { skipped, left_out, .. } = report;
    print_made(&Made { files: written, skipped, left_out }, sources.json)
}

/// The pictures of the scenes, as a figure has them.
fn photographs(figures: &[Figure]) -> Vec<Picture> {
    let panels =
        figures.iter().filter(|figure| figure.name == "pixel-cost").flat_map(|figure| &figure.panels);
    let photograph = |panel: &Panel| match &panel.content {
        Content::Picture(picture) if picture.colour_bar.is_none() => Some(picture.clone()),
        _ => None,
    };
    panels.filter_map(photograph).collect()
}

/// What studies say, else what recordings do.
fn findings(analysis: &Analysis) -> Vec<String> {
    match &analysis.study {
        Some(study) => study.groups.iter().filter(|group| !group.is_sweep()).filter_map(of_study).collect(),
        None => analysis.recordings.iter().filter_map(of_recording).collect(),
    }
}

/// What means over a study say of sorting.
fn of_study(group: &StudyGroup) -> Option<String> {
    let nets = |rays: RayClass| {
        let own = group.methods(rays).filter(|row| row.method != CONTROL);
        own.filter_map(|row| {
            let net = row.net.as_ref()?.mean;
            Some((row.method.as_str(), net.ratio, net.interval, group.is_shown_to_pay(row)))
        })
        .collect()
    };
    let views = counted(group.views as u64, "view", "views");
    let scenes = counted(group.scenes.len() as u64, "scene", "scenes");
    finding(&format!("{}, mean over {views} of {scenes}", label(group)), nets)
}

/// What a recording says of sorting.
fn of_recording(recording: &RecordingAnalysis) -> Option<String> {
    let is_method = |frame: &&FrameAnalysis| frame.is_candidate() && frame.base == frame.method;
    let nets = |rays: RayClass| {
        let own = recording.frames.iter().filter(|frame| frame.rays == rays).filter(is_method);
        own.filter_map(|frame| {
            let net = frame.net_speedup.known()?;
            Some((frame.method.as_str(), net.ratio, net.interval, net.verdict == Verdict::Faster))
        })
        .collect()
    };
    finding(&format!("{}, best over the whole frame", recording.label), nets)
}

/// A method, its net speedup, the interval of that, and whether it is shown to pay.
type Net<'a> = (&'a str, f64, Option<(f64, f64)>, bool);

/// The best method of each kind of rays, and whether it is shown to pay.
fn finding<'a>(of: &str, nets: impl Fn(RayClass) -> Vec<Net<'a>>) -> Option<String> {
    let best = |rays: RayClass| {
        // One that surely pays goes before one that gains more, perhaps by chance.
        let by_gain = |a: &Net<'_>, b: &Net<'_>| a.3.cmp(&b.3).then(a.1.total_cmp(&b.1));
        let (method, ratio, interval, pays) = nets(rays).into_iter().max_by(by_gain)?;
        let interval = interval.map_or(String::new(), |(low, high)| format!(" [{low:.2}, {high:.2}]"));
        let verdict = if pays { "" } else { ", which is not shown to pay" };
        Some(format!("{} rays: {method}, {ratio:.2}× net{interval}{verdict}", rays.name()))
    };
    let found: Vec<String> = RayClass::ALL.into_iter().filter_map(best).collect();
    (!found.is_empty()).then(|| format!("{of}: {}.", found.join("; ")))
}

/// The folder for what is written.
fn make_folder(out: &Path) -> anyhow::Result<()> {
    files::make_folder(out).map_err(|error| anyhow::anyhow!("{error}; name another folder with --out"))
}

fn print_made(made: &Made, json: bool) -> anyhow::Result<()> {
    let Made { files, skipped, left_out } = made;
    if json {
        print_json(made)?;
        return all_used(left_out);
    }
    let mut lines: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    lines.extend(skipped.iter().map(|one| format!("left out: {}: {}", one.figure, one.reason)));
    if skipped.iter().any(|one| one.reason.contains(".npy")) {
        // The reasons name an array: both ways to have it.
        lines.push(HOW_TO_HAVE_ARRAYS.to_owned());
    }
    lines.push(format!("{} written", counted(files.len() as u64, "file", "files")));
    print(&lines.join("\n"))?;
    anyhow::ensure!(!files.is_empty(), "nothing could be drawn of what was given");
    all_used(left_out)
}

/// What could not be used was said when it was opened; that there was some is a failure.
fn all_used(left_out: &[String]) -> anyhow::Result<()> {
    let count = counted(left_out.len() as u64, "input", "inputs");
    anyhow::ensure!(left_out.is_empty(), "{count} could not be used; all of this is of the others");
    Ok(())
}

/// What was recorded, where and how: the name of a recording and a line about it.
fn facts((dump, analysis): (&Dump, &RecordingAnalysis)) -> (String, String) {
    let header = shown::header(&dump.manifest().header);
    let options = &header.options;
    let driver = &header.adapter.driver;
    let driver = if driver.is_empty() { String::new() } else { format!(", {driver}") };
    let line = format!(
        "{}, camera {}, {}×{}, {}, {}, {}, seed {}; {}{driver}; {} keys; timed by {}{}; version {}",
        counted(header.scene.triangles, "triangle", "triangles"),
        options.camera,
        options.width,
        options.height,
        counted(options.bounces.into(), "bounce", "bounces"),
        counted(options.passes.into(), "pass", "passes"),
        counted(options.repeats.into(), "repeat", "repeats"),
        options.seed,
        analysis.configuration,
        analysis.key_bits(),
        header.time_source,
        analysis.disturbed(),
        header.program_version,
    );
    (analysis.label.clone(), line)
}

fn title(recordings: &[Dump]) -> String {
    let name = |recording: &Dump| shown::name(&recording.manifest().header.scene.name);
    let scenes = distinct(recordings.iter().map(name));
    if scenes.is_empty() {
        "Ray reordering".to_owned()
    } else {
        format!("Ray reordering: {}", scenes.join(", "))
    }
}

/// The commands that make the recordings, the measurements and this page.
fn commands(inputs: &Inputs, sources: &Sources) -> Vec<String> {
    let mut commands: Vec<String> = inputs.recordings.iter().map(record_command).collect();
    commands.extend(inputs.benches.iter().map(|bench| bench.command.clone()));
    let inputs: Vec<String> = sources.inputs.iter().map(|path| quoted(path)).collect();
    commands.push(format!("inspector report {} --out {}", inputs.join(" "), quoted(&sources.out)));
    commands
}

/// The command that makes a recording again. A recording knows its scene by name and content, not
/// where its file was.
fn record_command(recording: &Dump) -> String {
    let header = shown::header(&recording.manifest().header);
    let scene = &header.scene;
    let out = quoted(recording.root().file_name().map_or(recording.root(), Path::new));
    let (verb, comment) = match &header.source {
        Source::Replayed { name, .. } => {
            (format!("recorder replay {}", quoted(Path::new(name))), String::new())
        }
        source => {
            let hash = hexadecimal(&scene.content_hash[..6]);
            let verb = match source {
                Source::Imported { name, .. } => import_command(recording.manifest(), name),
                _ => format!("recorder record SCENE {}", path_options(&header.options)),
            };
            (verb, format!("    # SCENE: {}, content {hash}…", scene.name))
        }
    };
    format!("{verb} --out {out} {}{comment}", measuring_options(recording.manifest(), &header))
}

/// What was imported, and as what: a file of rays does not say.
fn import_command(manifest: &Manifest, name: &str) -> String {
    let from = if name.ends_with(".npy") { "--rays" } else { "--queues" };
    let rays = manifest.queues.first().filter(|_| from == "--rays").map(|queue| queue.id);
    let rays = rays.map_or(String::new(), |id| format!(" --kind {} --bounce {}", id.kind, id.bounce));
    let Options { width, height, .. } = manifest.header.options;
    let size = if height > 1 { format!(" --size {width}x{height}") } else { String::new() };
    format!("recorder import --scene SCENE {from} {}{rays}{size}", quoted(Path::new(name)))
}

/// The options that decide which rays there are.
fn path_options(options: &Options) -> String {
    format!(
        "--width {} --height {} --bounces {} --passes {} --seed {} --camera {} --keep-passes {}{}",
        options.width,
        options.height,
        options.bounces,
        options.passes,
        options.seed,
        quoted(Path::new(&options.camera)),
        shell_word(&options.keep_passes),
        if options.russian_roulette { " --russian-roulette" } else { "" },
    )
}

/// The options that decide what is measured on them, and what is kept. Variants go by the method that they are
/// variants of and by the values that they were swept over; orders of another tracer come with its rays again.
fn measuring_options(manifest: &Manifest, header: &Header) -> String {
    let options = &header.options;
    let bases = distinct(manifest.methods.iter().map(|method| method.base.as_str()));
    let (builtin, others): (Vec<&str>, Vec<&str>) =
        bases.into_iter().partition(|name| Method::builtin(name).is_ok());
    let is_listed = |name: &&str| options.methods.iter().any(|listed| listed == name);
    let listed: Vec<&str> = WITHOUT_LAYOUT.into_iter().filter(is_listed).chain(builtin).collect();
    let is_own = |name: &&str| !manifest.foreign_orders().any(|order| order.name == *name);
    let own = others.into_iter().filter(is_own).filter_map(|name| {
        // Of variants by the origin's share, whose text is made of coordinates alone, one that has all of them.
        let variants = manifest.methods.iter().filter(|method| method.base == name);
        let method = variants.max_by_key(|method| (!method.name.contains("-split-"), method.text.len()))?;
        let estimate = match method.termination {
            Termination::Adaptive if !method.text.contains('@') => " @adaptive",
            Termination::Real if !method.text.contains('@') => " @real",
            _ => "",
        };
        let own = shown::sentence(format!("{name}={}{estimate}", method.text));
        Some(format!(" --method {}", shell_word(&own)))
    });
    let threads = match header.backend {
        Backend::Cpu => format!(" --threads {}", options.threads),
        Backend::Gpu => format!(" --adapter {}", shell_word(&header.adapter.name)),
    };
    let modelled = manifest.caches.first().map(|caches| format!(" --l2-kib {}", caches.l2_bytes >> 10));
    format!(
        "--backend {} --trace {}{threads} --repeats {} --keep {}{} --methods {}{}{}",
        header.backend.name(),
        shell_word(&options.trace_kernel),
        options.repeats,
        if options.keep.is_empty() {
            "none".into()
        } else {
            shell_word(&options.keep.join(",")).into_owned()
        },
        modelled.unwrap_or_default(),
        listed.join(","),
        own.collect::<String>(),
        key_options(manifest, header),
    )
}

/// What keys and length tables are made of; an import takes the bits of its keys alone.
fn key_options(manifest: &Manifest, header: &Header) -> String {
    let options = &header.options;
    let variants = || manifest.methods.iter().filter(|method| method.base != method.name);
    let mut key_bits: Vec<u32> = variants().map(|method| method.key_bits).collect();
    key_bits.sort_unstable();
    let key_bits = format!(" --key-bits {}", list(key_bits, options.key_bits));
    if matches!(header.source, Source::Imported { .. }) {
        return key_bits;
    }
    let with_length = variants().filter(|method| method.termination == Termination::Fixed);
    let mut lengths: Vec<f32> = with_length.map(|method| method.two_point_length).collect();
    lengths.sort_by(f32::total_cmp);
    let origin_bits = |method: &MethodRecord| {
        let split = method.name.strip_prefix(&method.base)?.strip_prefix("-split-")?;
        split.split('-').next()?.parse::<u32>().ok()
    };
    let mut splits: Vec<u32> = variants().filter_map(origin_bits).collect();
    splits.sort_unstable();
    let split = splits.first().copied().map(|first| format!(" --split {}", list(splits, first)));
    format!(
        "{key_bits} --two-point-length {}{} --table-bits {} --table-method {}",
        list(lengths, options.two_point_length),
        split.unwrap_or_default(),
        options.table_bits,
        shell_word(&options.table_method),
    )
}

/// Numbers in their order, each once, as the command line takes them; `otherwise` if there are none.
fn list<T: PartialEq + ToString>(mut numbers: Vec<T>, otherwise: T) -> String {
    numbers.dedup();
    if numbers.is_empty() {
        numbers.push(otherwise);
    }
    numbers.iter().map(T::to_string).collect::<Vec<_>>().join(",")
}
