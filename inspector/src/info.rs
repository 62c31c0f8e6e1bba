//! `inspector info`: what a recording holds.

use std::collections::BTreeMap;
use std::path::Path;

use formats::manifest::{Header, Manifest, Options, Source};
use formats::metrics::frame::{COLUMNS, Frame};
use formats::metrics::queue_times;
use formats::reader::Dump;
use formats::study::Study;
use formats::summary::{Summary, hexadecimal};
use formats::text::wrapped;
use serde::Serialize;

use crate::analysis::{Analysis, AnalysisOptions, Depth, StudyAnalysis, analyse};
use crate::method_table;
use crate::output::{count, counted, print, print_json, say, size, sum, table, time};
use crate::shown;

/// What `--json` prints: the summary's fields, and more.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// Of a replay.
    #[serde(skip_serializing_if = "Option::is_none")]
    source_is: Option<SourceIs>,
    /// With `--metrics`.
    #[serde(skip_serializing_if = "Option::is_none")]
    metrics: Option<&'a Analysis>,
}

/// What there is in the place where a replay's source should be.
#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
enum SourceIs {
    /// It.
    Here,
    /// Another recording, or something else.
    Changed,
    /// Nothing.
    Missing,
}

impl SourceIs {
    /// `None` if the recording is no replay.
    fn of(dump: &Dump) -> Option<Self> {
        let Source::Replayed { name, .. } = &dump.manifest().header.source else { return None };
        // As readers find it, without following a link.
        let is_there = || {
            let beside = std::path::absolute(dump.root()).ok()?.parent()?.join(name);
            std::fs::symlink_metadata(beside).ok()
        };
        let is_plain = Path::new(name).file_name().is_some_and(|plain| plain == name.as_str());
        Some(match dump.source() {
            Some(_) => Self::Here,
            None if is_plain && is_there().is_some() => Self::Changed,
            None => Self::Missing,
        })
    }
}

/// What there is to see of a recording, or of a study.
pub(crate) fn run(path: &Path, json: bool, details: bool, options: &AnalysisOptions) -> anyhow::Result<()> {
    if Study::is_at(path) {
        return study(path, json);
    }
    let dump = Dump::open(path)?;
    let summary = Summary::new(path, dump.manifest());
    let source_is = SourceIs::of(&dump);
    let reads_arrays = options.depth == Depth::Arrays;
    let analysis = reads_arrays.then(|| analyse(std::slice::from_ref(&dump), options)).transpose()?;
    if json {
        return print_json(&Printed { summary: &summary, source_is, metrics: analysis.as_ref() });
    }
    let shown = shown::header(&dump.manifest().header);
    let mut parts = if details {
        vec![facts(&summary, &shown, source_is), queue_times::text(dump.manifest())]
    } else {
        vec![in_short(&summary, &shown, source_is)]
    };
    parts.push(Frame::of(dump.manifest()).text());
    parts.extend(without_cost(dump.manifest()));
    parts.extend(analysis.as_ref().map(|found| method_table::arrays(found, details)));
    parts.push(match (details, reads_arrays) {
        (true, _) => arrays(&summary),
        (false, true) => "More: --details (each bounce by itself)".into(),
        (false, false) => {
            "More: --details (settings, queues, stages, arrays), --metrics (capsules, lanes)".into()
        }
    });
    print(&parts.join("\n\n"))
}

/// The jobs of a study and the means over what is finished.
fn study(path: &Path, json: bool) -> anyhow::Result<()> {
    let study = Study::open(path)?;
    let analysis = StudyAnalysis::of(std::slice::from_ref(&study));
    for notice in &analysis.notices {
        say(notice);
    }
    if json {
        return print_json(&analysis);
    }
    let failed: Vec<String> = study
        .jobs
        .iter()
        .filter_map(|job| {
            let name = job.folder.file_name().unwrap_or_default().to_string_lossy();
            Some(format!("failed      {}: {}", shown::name(&name), job.record.failure.as_ref()?))
        })
        .collect();
    let finished = counted((study.jobs.len() - failed.len()) as u64, "job", "jobs");
    let mut parts =
        vec![format!("study       {}: {finished} finished, {} failed", path.display(), failed.len())];
    if !failed.is_empty() {
        parts.push(failed.iter().map(|line| wrapped(line, COLUMNS, 12)).collect::<Vec<_>>().join("\n"));
    }
    parts.extend(analysis.groups.iter().map(method_table::study_group));
    print(&parts.join("\n\n"))
}

/// Which orders have no net speedup, since they came with imported rays.
fn without_cost(manifest: &Manifest) -> Option<String> {
    let names: Vec<String> = manifest.foreign_orders().map(|order| shown::name(&order.name)).collect();
    (!names.is_empty()).then(|| {
        format!("No net speedup for {}: another tracer made and sorted their keys.", names.join(", "))
    })
}

/// Most notices that are shown among other things.
const MOST_NOTICES: usize = 3;

/// State, scene, machine and settings, as much as a screen has room for.
fn in_short(summary: &Summary, shown: &Header, source_is: Option<SourceIs>) -> String {
    let mut lines = vec![("recording", format!("{} ({})", summary.dump, state(summary)))];
    lines.extend(source_line(shown, source_is).map(|line| ("source", line)));
    lines.push(("scene", scene_line(summary, shown)));
    lines.push(("backend", machine_line(shown)));
    lines.push(("options", options_line(&shown.options)));
    lines.extend(shown.notices.iter().take(MOST_NOTICES).map(|notice| ("notice", notice.clone())));
    let more = shown.notices.len().saturating_sub(MOST_NOTICES);
    lines.extend((more > 0).then(|| ("", format!("… and {more} more (--details)"))));
    let fitted = |(name, value): (&str, String)| wrapped(&format!("{name:<11} {value}"), COLUMNS, 12);
    lines.into_iter().map(fitted).collect::<Vec<_>>().join("\n")
}

fn state(summary: &Summary) -> &'static str {
    match (summary.complete, summary.recovered) {
        (true, _) => "complete",
        (false, true) => "recovered: the recording was ended early",
        (false, false) => "not finished: being recorded, or to be recovered",
    }
}

fn options_line(options: &Options) -> String {
    format!(
        "camera {}, {}×{}, {} ({} kept), {}, {}, seed {}",
        options.camera,
        options.width,
        options.height,
        counted(options.passes.into(), "pass", "passes"),
        options.keep_passes,
        counted(options.bounces.into(), "bounce", "bounces"),
        counted(options.repeats.into(), "repeat", "repeats"),
        options.seed
    )
}

/// What was recorded, line by line.
fn facts(summary: &Summary, shown: &Header, source_is: Option<SourceIs>) -> String {
    let options = &shown.options;
    let took = summary.wall_ns.map_or(String::new(), |ns| format!(" in {}", time(ns as f64)));
    let mut lines = vec![
        ("recording", format!("{} ({})", summary.dump, state(summary))),
        (
            "recorded",
            format!("by version {}{took}, format {}", shown.program_version, summary.format_version),
        ),
    ];
    lines.extend(source_line(shown, source_is).map(|line| ("source", line)));
    lines.extend(scene_lines(summary, shown));
    lines.push(("backend", format!("{}, timed by {}", machine_line(shown), shown.time_source)));
    lines.push(("options", options_line(options)));
    lines.push((
        "",
        format!(
            "{}-bit keys, two-point length {}, table of 2^{} cells by {}{}",
            options.key_bits,
            options.two_point_length,
            options.table_bits,
            options.table_method,
            if options.russian_roulette { ", Russian roulette" } else { "" }
        ),
    ));
    lines.push(("methods", options.methods.join(", ")));
    lines.push(("features", or_none(&shown.features.used)));
    lines.push(("skipped", or_none(&shown.features.skipped)));
    for check in &shown.self_check {
        let detail = if check.detail.is_empty() { String::new() } else { format!(" ({})", check.detail) };
        lines.push(("self-check", format!("{}: {}{detail}", check.name, check.outcome)));
    }
    lines.extend(shown.notices.iter().map(|notice| ("notice", notice.clone())));
    let mut last = "";
    let aligned = lines.iter().map(|(name, value)| {
        let shown = if *name == last { "" } else { name };
        last = name;
        format!("{shown:<11} {value}")
    });
    aligned.collect::<Vec<_>>().join("\n")
}

/// Whose rays they are, if they were not traced for this recording.
fn source_line(shown: &Header, source_is: Option<SourceIs>) -> Option<String> {
    let digits = |sha256: &[u8; 32]| hexadecimal(&sha256[..6]);
    match &shown.source {
        Source::Traced => None,
        Source::Imported { name, sha256 } => {
            Some(format!("an import: its rays are those of {name} (sha256 {}…)", digits(sha256)))
        }
        Source::Replayed { name, manifest_sha256 } => {
            let digits = digits(manifest_sha256);
            let where_it_is = match source_is {
                Some(SourceIs::Here) => "which lies beside it, as it was".to_owned(),
                Some(SourceIs::Changed) => format!(
                    "but what is called so beside it is another recording by now (expected the one whose \
                     manifest has sha256 {digits}…), so that its rays are not to be had"
                ),
                _ => format!(
                    "which is not beside it, so that its rays are not to be had: put the recording there \
                     whose manifest has sha256 {digits}…"
                ),
            };
            Some(format!("a replay: its rays are those of {name}, {where_it_is}"))
        }
    }
}

fn scene_line(summary: &Summary, shown: &Header) -> String {
    let scene = &summary.scene;
    format!(
        "{}: {}, {}, {}",
        shown.scene.name,
        counted(scene.triangles, "triangle", "triangles"),
        counted(scene.vertices, "vertex", "vertices"),
        counted(scene.lights as u64, "light", "lights")
    )
}

fn scene_lines(summary: &Summary, shown: &Header) -> Vec<(&'static str, String)> {
    let scene = &summary.scene;
    let corner = |point: [f32; 3]| format!("({}, {}, {})", point[0], point[1], point[2]);
    let image = &summary.image;
    let hash = image.sha256.as_ref().map_or("no picture".to_owned(), |hash| format!("sha256 {hash}"));
    vec![
        ("scene", scene_line(summary, shown)),
        ("", format!("from {} to {}", corner(scene.bounds_min), corner(scene.bounds_max))),
        ("image", format!("{}×{}, {hash}", image.width, image.height)),
    ]
}

/// Backend, adapter, driver, threads and kernel.
fn machine_line(shown: &Header) -> String {
    let adapter = &shown.adapter;
    let driver = if adapter.driver.is_empty() { String::new() } else { format!(", {}", adapter.driver) };
    let threads = match shown.options.threads {
        0 => String::new(),
        threads => format!(", {}", counted(threads.into(), "thread", "threads")),
    };
    format!(
        "{}: {} ({}, {}{driver}{threads}), kernel {}",
        shown.backend.name(),
        adapter.name,
        adapter.device_type,
        adapter.backend,
        shown.options.trace_kernel
    )
}

fn or_none(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Arrays of one name together: there are hundreds of files, but few kinds of them.
fn arrays(summary: &Summary) -> String {
    let mut kinds: BTreeMap<(String, &str), (u64, u64)> = BTreeMap::new();
    for array in &summary.arrays {
        let path = array.place.to_string();
        let name = path.rsplit('/').next().unwrap_or(&path);
        let (files, bytes) = kinds.entry((name.to_owned(), array.dtype.descr())).or_default();
        *files += 1;
        *bytes = bytes.saturating_add(array.bytes);
    }
    let mut table = table(&["array", "element", "files", "data"], 2);
    for ((name, dtype), (files, bytes)) in kinds {
        table.add_row([name, element(dtype), count(files), size(bytes)]);
    }
    let bytes = sum(summary.arrays.iter().map(|array| array.bytes));
    format!("Arrays: {} files, {}\n{table}", count(summary.arrays.len() as u64), size(bytes))
}

/// An element type, records by their fields: `{t, triangle, u, v}`.
fn element(dtype: &str) -> String {
    // Each field is a tuple that starts with its quoted name.
    let names: Vec<&str> =
        dtype.split("('").skip(1).filter_map(|field| Some(field.split_once('\'')?.0)).collect();
    if names.is_empty() { dtype.to_owned() } else { format!("{{{}}}", names.join(", ")) }
}
