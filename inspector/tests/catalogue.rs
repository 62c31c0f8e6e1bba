//! Every figure of the catalogue from a small recording: none empty, all numbers finite, in one style.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::path::Path;

use formats::bench_result::{BENCH_VERSION, BenchResult, Rows, SortRow, TraceRow};
use formats::manifest::Stage;
use formats::metrics::speedup::median;
use formats::ray::Kind;
use formats::reader::Dump;
use inspector::analysis::{Analysis, Depth, Options, analyse};
use inspector::figures::catalogue::{CATALOGUE, Material, Skipped, make_all};
use inspector::figures::model::{Content, Figure, Panel, Scale, Series};

#[path = "../../formats/tests/sample/mod.rs"]
mod sample;

fn analysis(folder: &Path, depth: Depth) -> Analysis {
    let dump = Dump::open(&sample::write(folder)).unwrap();
    analyse(&[dump], &Options { depth, ..Options::default() }).unwrap()
}

fn bench(rows: Rows) -> BenchResult {
    BenchResult {
        rayscope_bench: BENCH_VERSION,
        program_version: "0".into(),
        command: "recorder bench".into(),
        backend: "cpu".into(),
        adapter: "a processor".into(),
        driver: String::new(),
        threads: 2,
        time_source: "monotonic clock".into(),
        rows,
    }
}

fn benches() -> [BenchResult; 2] {
    let sort = |n, key_bits, ns| SortRow { n, key_bits, samples_ns: vec![ns, ns + 10, ns + 20] };
    let trace = |kernel: &str, order: &str, ns| TraceRow {
        scene: "box".into(),
        triangles: 11,
        kernel: kernel.into(),
        bounce: 1,
        kind: Kind::Closest,
        order: order.into(),
        rays: 1000,
        samples_ns: vec![ns, ns + 10, ns + 20],
    };
    [
        bench(Rows::Sort(vec![sort(2048, 32, 900), sort(1024, 32, 500), sort(1024, 64, 800)])),
        bench(Rows::Trace(vec![
            trace("cwbvh", "unsorted", 900),
            trace("cwbvh", "aila", 700),
            trace("bvh2", "aila", 800),
        ])),
    ]
}

/// The figure, or why not.
fn figure(material: &Material<'_>, name: &str) -> Result<Figure, Skipped> {
    let entry = CATALOGUE.iter().find(|entry| entry.name == name).unwrap();
    (entry.make)(material)
}

fn series(panel: &Panel) -> &[Series] {
    match &panel.content {
        Content::Lines(series)
        | Content::Scatter(series)
        | Content::Bars(series)
        | Content::Stacks(series) => series,
        Content::Picture(_) => &[],
    }
}

#[test]
fn every_figure_is_made_and_sound() {
    let folder = tempfile::tempdir().unwrap();
    let analysis = analysis(folder.path(), Depth::Arrays);
    let material = Material { analysis: &analysis, benches: &benches() };
    let mut styles: BTreeMap<String, usize> = BTreeMap::new();
    for (entry, made) in make_all(&material) {
        // The sample has no variants of one method, so there is nothing to sweep over.
        if ["key-bits", "two-point-length"].contains(&entry.name) {
            assert!(made.unwrap_err().reason.contains("two or more values"), "{}", entry.name);
            continue;
        }
        let figure = made.unwrap_or_else(|skipped| panic!("{}: {skipped}", entry.name));
        assert_eq!(figure.name, entry.name);
        assert!(!figure.caption.is_empty() && !figure.settings.is_empty() && !figure.panels.is_empty());
        for panel in &figure.panels {
            if let Content::Picture(picture) = &panel.content {
                assert_eq!(picture.rgb.len(), (picture.width * picture.height) as usize);
                continue;
            }
            assert!(!series(panel).is_empty(), "{}", entry.name);
            for series in series(panel) {
                let is_method = analysis.summaries.iter().any(|summary| summary.method == series.label);
                if is_method {
                    let style = *styles.entry(series.label.clone()).or_insert(series.style);
                    assert_eq!(style, series.style, "{} in {}", series.label, entry.name);
                }
                for point in &series.points {
                    assert!(
                        point.x.is_finite() && point.y.is_finite() && point.n > 0,
                        "{}: {point:?}",
                        entry.name
                    );
                    let holds = |(low, high): (f64, f64)| low <= point.y && point.y <= high;
                    assert!(point.spread.is_none_or(holds), "{}: {point:?}", entry.name);
                    if let Scale::Categories(names) = &panel.x.scale {
                        assert!((point.x as usize) < names.len(), "{}: {point:?}", entry.name);
                    }
                }
            }
        }
    }
    assert_eq!(styles.len(), 6, "methods that have a style: {styles:?}");
}

#[test]
fn a_stack_is_as_high_as_the_total_and_its_line_the_unsorted_trace() {
    let folder = tempfile::tempdir().unwrap();
    let analysis = analysis(folder.path(), Depth::Manifest);
    let material = Material { analysis: &analysis, benches: &[] };
    let figure = figure(&material, "overhead").unwrap();
    let shadow = figure.panels.iter().find(|panel| panel.title.contains("shadow")).unwrap();
    let Scale::Categories(methods) = &shadow.x.scale else { panic!("methods") };
    let queues = || analysis.recordings[0].measured().filter(|queue| queue.kind == Kind::Shadow);
    for (place, method) in methods.iter().enumerate() {
        let points = series(shadow).iter().flat_map(|series| &series.points);
        let height: f64 = points.filter(|point| point.x == place as f64).map(|point| point.y).sum();
        let orders = queues().flat_map(|queue| &queue.orders).filter(|order| order.method == *method);
        // Sums of medians are not medians of sums, but here every stage has its samples in one order.
        let stages = |order: &inspector::analysis::OrderAnalysis| {
            let of = |stage: Stage| {
                let found = order.stages.iter().find(|found| found.stage == stage);
                found.map_or(0.0, |found| median(&found.time.samples_ns).unwrap())
            };
            let gathered = of(Stage::Gather) + of(Stage::Trace);
            let indirect = of(Stage::TraceIndirect);
            let traced = if indirect > 0.0 && indirect < gathered { indirect } else { gathered };
            of(Stage::Key) + of(Stage::Sort) + traced + of(Stage::Accumulate)
        };
        let expected: f64 = orders.map(stages).sum::<f64>() / 1e6;
        assert!((height - expected).abs() < 1e-9, "{method}: {height}, expected {expected}");
    }
    let unsorted = series(shadow).iter().find(|series| series.label == "trace").unwrap();
    let first = unsorted.points.iter().find(|point| point.x == 0.0).unwrap();
    assert_eq!((methods[0].as_str(), shadow.references[0].y), ("unsorted", first.y));
}

#[test]
fn variants_of_a_base_make_a_sweep() {
    let folder = tempfile::tempdir().unwrap();
    let mut analysis = analysis(folder.path(), Depth::Manifest);
    for order in analysis.recordings[0].queues.iter_mut().flat_map(|queue| &mut queue.orders) {
        // As a replay with 16-bit and 32-bit keys of one method would have it.
        if ["aila", "mine"].contains(&order.method.as_str()) {
            order.base = "aila".into();
            order.two_point_length = None;
        }
    }
    let material = Material { analysis: &analysis, benches: &[] };
    let figure = figure(&material, "key-bits").unwrap();
    assert_eq!(figure.panels.len(), 4);
    let [line] = series(&figure.panels[0]) else { panic!("one line") };
    assert_eq!(line.label, "aila");
    assert_eq!(line.points.iter().map(|point| point.x).collect::<Vec<_>>(), [16.0, 32.0]);
    let speedups = self::figure(&material, "trace-speedup").unwrap();
    let labels: Vec<&str> = series(&speedups.panels[0]).iter().map(|series| series.label.as_str()).collect();
    assert!(
        labels.contains(&"aila") && !labels.contains(&"mine"),
        "a variant belongs to its sweep: {labels:?}"
    );
}

/// A recording of variants alone is left out beside others, but shown where there is nothing else; tables
/// and pictures that two recordings share are shown once.
#[test]
fn replays_do_not_repeat_what_their_source_shows() {
    let folder = tempfile::tempdir().unwrap();
    let mut analysis = analysis(folder.path(), Depth::Arrays);
    let panels = |analysis: &Analysis| {
        let material = Material { analysis, benches: &[] };
        ["overhead", "lane-utilisation", "table-fill", "pixel-cost"]
            .map(|name| figure(&material, name).unwrap().panels.len())
    };
    let alone = panels(&analysis);
    let mut replay = analysis.recordings[0].clone();
    replay.label = "replay".into();
    for order in replay.queues.iter_mut().flat_map(|queue| &mut queue.orders) {
        if order.method != "unsorted" {
            order.method = format!("{}-8-bits", order.base);
        }
    }
    analysis.recordings.push(replay);
    assert_eq!(panels(&analysis), alone);
    analysis.recordings.remove(0);
    assert_eq!(panels(&analysis), alone);
}

#[test]
fn what_recordings_cannot_give_is_skipped_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let analysis = analysis(folder.path(), Depth::Manifest);
    let material = Material { analysis: &analysis, benches: &[] };
    for (name, part) in [
        ("capsule-area", "not read"),
        ("lane-utilisation", "not read"),
        ("table-fill", "not read"),
        ("sort-throughput", "bench sort"),
        ("trace-rate", "bench trace"),
    ] {
        let skipped = figure(&material, name).unwrap_err();
        assert!(skipped.reason.contains(part), "{name}: {skipped}");
    }
}

/// README has a table of the figures: these and no others, in this order, in these words.
#[test]
fn the_readme_lists_every_figure() {
    let readme = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md")).unwrap();
    let section = readme.split("\n## ").find(|section| section.starts_with("Figures\n")).unwrap();
    let rows: Vec<&str> =
        section.lines().filter(|line| line.starts_with("| `") && !line.contains("--figure")).collect();
    let expected: Vec<String> =
        CATALOGUE.iter().map(|entry| format!("| `{}` | {} |", entry.name, entry.description)).collect();
    assert_eq!(rows, expected);
}
