//! Every figure of the catalogue from a small recording: none empty, all numbers finite, in one style.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::path::Path;

use formats::bench_result::BenchResult;
use formats::manifest::{Stage, Way};
use formats::ray::Kind;
use formats::reader::Dump;
use inspector::analysis::break_even::BreakEven;
use inspector::analysis::headline::Headline;
use inspector::analysis::summary::RayClass;
use inspector::analysis::timing::SpeedupLine;
use inspector::analysis::{
    Analysis, AnalysisOptions, Depth, FrameAnalysis, Metric, RecordingAnalysis, analyse,
};
use inspector::figures::catalogue::{CATALOGUE, Findings, Skipped};
use inspector::figures::csv;
use inspector::figures::model::{Content, Figure, Panel, Scale, Series};
use inspector::report::tables::tables;
use on_disk::written;
use tempfile::TempDir;

mod benches;
#[path = "../on_disk/mod.rs"]
mod on_disk;
mod several;

/// Of the sample, and the folder that it is in.
fn analysis(depth: Depth) -> (TempDir, Analysis) {
    let (folder, dump) = written();
    let options = AnalysisOptions { depth, ..AnalysisOptions::default() };
    (folder, analyse(&[Dump::open(&dump).unwrap()], &options).unwrap())
}

#[test]
fn curves_of_run_time_against_error_show_what_was_measured() {
    let analysis = Analysis::default();
    let benches = benches::of_each_kind();
    let panel = |name: &str, at: usize| figure(&analysis, &benches, name).unwrap().panels.swap_remove(at);
    let place = |panel: &Panel, label: &str| -> Vec<(f64, f64)> {
        let found = series(panel).iter().find(|series| series.label == label).unwrap();
        found.points.iter().map(|point| (point.x, point.y)).collect()
    };
    let [rates, wrong] = [0, 2].map(|at| panel("precision-error", at));
    let Scale::Categories(tests) = &rates.x.scale else { panic!("a row for each test") };
    assert_eq!(tests, &["bvh2, watertight, padded", "bvh2, Möller–T., padded"]);
    let [(_, careful), (row, plain)] = place(&rates, "box")[..] else { panic!("two tests") };
    assert!(careful == 1.0 && row == 1.0 && (plain - 910.0 / 810.0).abs() < 1e-12, "{plain}");
    assert_eq!(place(&wrong, "box"), [(0.0, 2.0), (1.0, 8.0)]);
    // Errors over 0.2 of the constant; six nanoseconds to add, five more for the key than without a table.
    let [by_bits, by_pass, cost] = [0, 1, 2].map(|at| panel("estimator-cost", at));
    let near = |found: &[(f64, f64)], expected: &[(f64, f64)]| {
        let is_near = |(a, b): (&(f64, f64), &(f64, f64))| a.0 == b.0 && (a.1 - b.1).abs() < 1e-12;
        assert!(found.len() == expected.len() && found.iter().zip(expected).all(is_near), "{found:?}");
    };
    near(&place(&by_bits, "aila"), &[(10.0, 0.75), (20.0, 0.5)]);
    near(&place(&by_pass, "aila"), &[(8.0, 0.5)]);
    near(&place(&cost, "aila"), &[(0.0, 11.0)]);
    // Three milliseconds of tracing, with one and two for the key and as many for the sort.
    near(&place(&panel("key-bits-cost", 0), "aila"), &[(8.0, 1.0), (32.0, 1.0)]);
    near(&place(&panel("key-bits-cost", 1), "aila"), &[(8.0, 0.6), (32.0, 3.0 / 7.0)]);
    near(&place(&panel("image-error", 0), "box"), &[(0.0, 1.25)]);
    near(&place(&panel("image-error", 1), "box"), &[(0.001, 0.5), (0.002, 0.25)]);
    let skipped = panel("skipped", 0);
    assert_eq!(place(&skipped, "box"), [(0.0, 1.5), (1.0, 1.5), (2.0, 1.5)]);
    // Only what is skipped of several things says of which.
    let Scale::Categories(names) = &skipped.x.scale else { panic!("names along the axis") };
    assert_eq!(names, &["textures (shade)", "textures (trace)", "masks"]);
}

/// The figure, or why not.
fn figure(analysis: &Analysis, benches: &[BenchResult], name: &str) -> Result<Figure, Skipped> {
    let entry = CATALOGUE.iter().find(|entry| entry.name == name).unwrap();
    entry.make(&Findings { analysis, benches })
}

/// The figure of recordings alone.
fn of_recordings(analysis: &Analysis, name: &str) -> Figure {
    figure(analysis, &[], name).unwrap()
}

fn series(panel: &Panel) -> &[Series] {
    panel.content.series()
}

#[test]
fn every_figure_is_made_and_sound() {
    let (_folder, analysis) = analysis(Depth::Arrays);
    let findings = Findings { analysis: &analysis, benches: &benches::of_each_kind() };
    let mut styles: BTreeMap<String, usize> = BTreeMap::new();
    for entry in CATALOGUE {
        let made = entry.make(&findings);
        // The sample has no variants of one method, so there is nothing to sweep over.
        if ["key-bits", "origin-bits", "two-point-length"].contains(&entry.name) {
            assert!(made.unwrap_err().reason.contains("two or more values"), "{}", entry.name);
            continue;
        }
        // Nor a study.
        if entry.name == "study-speedup" {
            assert_eq!(made.unwrap_err().reason, "no study was given");
            continue;
        }
        // Nor of one kernel.
        if entry.name == "kernel-speedup" {
            assert!(made.unwrap_err().reason.contains("two or more trace kernels"));
            continue;
        }
        let figure = made.unwrap_or_else(|skipped| panic!("{skipped:?}"));
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
    assert_eq!(styles.len(), 7, "methods that have a style: {styles:?}");
}

/// The same recording with other speedups of traces.
fn scaled(recording: &RecordingAnalysis, factor: f64) -> RecordingAnalysis {
    let mut recording = recording.clone();
    let orders = recording.queues.iter_mut().flat_map(|queue| &mut queue.orders);
    let of_orders = orders.map(|order| &mut order.trace_speedup);
    for speedup in of_orders.chain(recording.frames.iter_mut().map(|frame| &mut frame.trace_speedup)) {
        if let Metric::Known(line) = speedup {
            line.ratio *= factor;
            line.interval = line.interval.map(|(low, high)| (factor * low, factor * high));
        }
    }
    recording
}

#[test]
fn speedups_by_kernel_are_those_of_its_recordings() {
    let (_folder, mut analysis) = analysis(Depth::Manifest);
    let first = analysis.recordings[0].clone();
    let mut other = scaled(&first, 2.0);
    other.options.trace_kernel = "lanes".into();
    other.configuration = "lanes, elsewhere".into();
    analysis.recordings = vec![first.clone(), other.clone()];
    let made = of_recordings(&analysis, "kernel-speedup");
    let titles: Vec<&str> = made.panels.iter().map(|panel| panel.title.as_str()).collect();
    assert_eq!(
        titles,
        ["bvh2: secondary rays", "bvh2: shadow rays", "lanes: secondary rays", "lanes: shadow rays"]
    );
    let rays: u64 = first.measured_of(RayClass::Shadow).map(|queue| queue.rays).sum();
    let frame = first.frame(RayClass::Shadow, "unsorted").unwrap();
    let trace = frame.stages.iter().find(|found| found.stage == Stage::Trace).unwrap();
    let unsorted = format!("bvh2 {:.1} of shadow rays", rays as f64 / trace.median_ns * 1e3);
    assert!(made.caption.contains(&unsorted), "{unsorted}: {}", made.caption);
    for (at, paper) in [1.41, 2.21].into_iter().enumerate() {
        let [bvh2, lanes] = [&made.panels[at], &made.panels[at + 2]];
        assert_eq!((bvh2.reference.as_ref().unwrap().y, &bvh2.reference), (paper, &lanes.reference));
        assert_eq!(bvh2.x, lanes.x, "the same methods in the same rows");
        let points = |panel| series(panel).iter().flat_map(|series| &series.points).collect::<Vec<_>>();
        let (bvh2, lanes) = (points(bvh2), points(lanes));
        assert!(bvh2.len() > 3 && bvh2.len() == lanes.len());
        for (bvh2, lanes) in bvh2.iter().zip(lanes) {
            assert!((lanes.y / bvh2.y - 2.0).abs() < 1e-9, "{bvh2:?} {lanes:?}");
        }
    }
    // Of two scenes each the means: as many panels, and a scene of one kernel alone has no part in them.
    let of_scene = |recording: &RecordingAnalysis, scene: &str, factor| RecordingAnalysis {
        scene: scene.into(),
        ..scaled(recording, factor)
    };
    let [second, alone] = ["second", "alone"].map(|scene| of_scene(&first, scene, 4.0));
    let several = vec![first, other.clone(), second, of_scene(&other, "second", 4.0), alone];
    let several = Analysis { recordings: several, ..analysis.clone() };
    let means = of_recordings(&several, "kernel-speedup");
    assert_eq!(means.panels.len(), 4);
    for (single, mean) in made.panels.iter().zip(&means.panels) {
        let totals = |panel| -> Vec<f64> {
            let all = series(panel).iter().filter(|series| !series.is_part);
            all.flat_map(|series| &series.points).map(|point| point.y).collect()
        };
        let (single, mean) = (totals(single), totals(mean));
        assert!(!single.is_empty() && single.len() == mean.len());
        assert!(single.iter().zip(&mean).all(|(single, mean)| (mean / single - 2.0).abs() < 1e-9));
    }
}

/// A row of stages ends where the net speedup says, and its trace where `break-even` does.
#[test]
fn a_stack_agrees_with_other_figures() {
    let (_folder, mut analysis) = analysis(Depth::Manifest);
    // Not what medians of stages say.
    for frame in analysis.recordings[0].frames.iter_mut().filter(|frame| frame.method == "aila") {
        let Metric::Known(line) = &mut frame.net_speedup else { panic!("it was timed") };
        line.ratio *= 0.75;
    }
    let figure = of_recordings(&analysis, "overhead");
    let recording = &analysis.recordings[0];
    for (panel, rays) in figure.panels.iter().zip(RayClass::ALL) {
        let Scale::Categories(methods) = &panel.x.scale else { panic!("methods") };
        assert!(methods.contains(&"aila".to_owned()) && !methods.contains(&"unsorted".to_owned()));
        assert_eq!(panel.reference.as_ref().unwrap().y, 1.0);
        for (place, method) in methods.iter().enumerate() {
            let sum = |of_trace: Option<bool>| -> f64 {
                let is_meant =
                    |series: &&Series| of_trace.is_none_or(|is| series.label.starts_with("trace") == is);
                let points = series(panel).iter().filter(is_meant).flat_map(|series| &series.points);
                points.filter(|point| point.x == place as f64).map(|point| point.y).sum()
            };
            let net = recording.frame(rays, method).unwrap().net_speedup.known().unwrap().ratio;
            assert!((sum(None) * net - 1.0).abs() < 1e-9, "{method}: {}", sum(None));
            let even = BreakEven::of(recording, rays, method).unwrap();
            let added = even.cost_ns.max(0.0) / even.unsorted_ns;
            assert!((sum(Some(false)) - added).abs() < 1e-9, "{method}: {}", sum(Some(false)));
            let points = series(panel).iter().flat_map(|series| &series.points);
            assert!(points.filter(|point| point.x == place as f64).all(|point| point.y >= 0.0), "{method}");
        }
    }
}

/// A mean over bounces counts each ray once, and each bounce is shown beside it.
#[test]
fn a_model_shows_all_rays_together_and_each_bounce() {
    let (_folder, analysis) = analysis(Depth::Arrays);
    let lanes = of_recordings(&analysis, "lane-utilisation");
    let shadow = lanes.panels.iter().find(|panel| panel.title.contains("shadow")).unwrap();
    let queues: Vec<_> =
        analysis.recordings[0].measured().filter(|queue| queue.kind == Kind::Shadow).collect();
    assert!(queues.len() > 1, "several bounces");
    let of = |queue: &inspector::analysis::QueueAnalysis| {
        let order = queue.order("aila").unwrap();
        let lane = order.lanes.known().unwrap().iter().find(|lane| lane.width == 32).unwrap();
        (queue.rays as f64, 100.0 * lane.utilisation)
    };
    let rays: f64 = queues.iter().map(|queue| of(queue).0).sum();
    let mean = queues.iter().map(|queue| of(queue).0 * of(queue).1).sum::<f64>() / rays;
    let aila: Vec<&Series> = series(shadow).iter().filter(|series| series.label == "aila").collect();
    let [bounces, all] = aila[..] else { panic!("bounces and all of them") };
    let shown: Vec<f64> = bounces.points.iter().map(|point| point.y).collect();
    assert_eq!(shown, queues.iter().map(|queue| of(queue).1).collect::<Vec<_>>());
    assert!(bounces.is_part && !all.is_part && (all.points[0].y - mean).abs() < 1e-9);
}

/// A program finds a number by what it is of, whatever the figure looks like.
#[test]
fn a_csv_has_one_number_a_row_and_says_what_it_is_of() {
    let (_folder, analysis) = analysis(Depth::Manifest);
    let recording = &analysis.recordings[0];
    let bytes = csv::write(&of_recordings(&analysis, "net-speedup")).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.starts_with("scene,machine,kind,bounce,method,detail,x_axis,x,metric,value,low,high,n\n"));
    let frame = recording.frame(RayClass::Shadow, "aila").unwrap().net_speedup.known().unwrap();
    let row = format!(
        "{},{},shadow,,aila,,,,net speedup,{},",
        recording.scene, recording.configuration, frame.ratio
    );
    assert!(text.lines().any(|line| line.replace('"', "").starts_with(&row)), "no {row} in {text}");
    let sizes = csv::write(&figure(&analysis, &benches::of_each_kind(), "sort-throughput").unwrap());
    let sizes = String::from_utf8(sizes.unwrap()).unwrap();
    assert!(sizes.contains(",keys,1024,throughput (Mkeys/s),"), "where to the right: {sizes}");
    let queue = recording.measured().find(|queue| queue.kind == Kind::Shadow && queue.bounce == 1).unwrap();
    let order = queue.order("aila").unwrap();
    let row = format!(",shadow,1,aila,,,,net speedup,{},", order.net_speedup.known().unwrap().ratio);
    assert!(text.contains(&row), "no {row} in {text}");
}

/// The numbers of a table are those of the analysis.
#[test]
fn tables_hold_what_was_measured() {
    let (_folder, analysis) = analysis(Depth::Arrays);
    let benches = benches::of_each_kind();
    let tables = tables(&analysis, &benches);
    let table = |start: &str| tables.iter().find(|table| table.title.starts_with(start)).unwrap();
    let recording = &analysis.recordings[0];
    let speedups = table("Trace / net speedup, shadow");
    let column = speedups.header.iter().position(|name| name == "aila").unwrap();
    let frame = recording.frame(RayClass::Shadow, "aila").unwrap();
    let [trace, net] = [&frame.trace_speedup, &frame.net_speedup].map(|line| line.known().unwrap().ratio);
    assert_eq!(speedups.rows[0][column].text, format!("{trace:.2} / {net:.2}"));
    assert_eq!(speedups.rows[0].iter().filter(|cell| cell.is_best).count(), 1);
    let overhead = table("Overhead, shadow");
    let shares = overhead.rows[0].iter().filter_map(|cell| cell.text.split_once(" (")?.1.strip_suffix(" %)"));
    let sum: f64 = shares.map(|share| share.parse::<f64>().unwrap()).sum();
    assert!((sum - 100.0).abs() <= 2.0, "shares of {sum} %: {:?}", overhead.rows[0]);
    let lanes = table("What lanes and caches would say, shadow");
    let aila = lanes.header.iter().position(|name| name == "aila").unwrap();
    let queue = recording.measured().find(|queue| queue.kind == Kind::Shadow && queue.bounce == 0).unwrap();
    let order = queue.order("aila").unwrap();
    let lane = order.lanes.known().unwrap().iter().find(|lane| lane.width == 32).unwrap();
    let row = lanes.rows.iter().find(|row| row[0].text == "lanes, bounce 0").unwrap();
    assert_eq!(row[aila].text, format!("{:.1}", 100.0 * lane.utilisation));
    for table in &tables {
        assert!(table.rows.iter().all(|row| row.len() == table.header.len()), "{}", table.title);
    }
    let sort = table("Sort throughput");
    assert!(sort.rows[0].iter().all(|cell| cell.text.parse::<f64>().is_ok()), "{:?}", sort.rows);
}

#[test]
fn variants_of_a_base_make_a_sweep() {
    let (_folder, mut analysis) = analysis(Depth::Manifest);
    for order in analysis.recordings[0].queues.iter_mut().flat_map(|queue| &mut queue.orders) {
        // As a replay with 16-bit and 32-bit keys of one method would have it.
        if ["aila", "mine"].contains(&order.method.as_str()) {
            order.base = "aila".into();
            order.two_point_length = None;
        }
    }
    let figure = of_recordings(&analysis, "key-bits");
    assert_eq!(figure.panels.len(), 4);
    let [line] = series(&figure.panels[0]) else { panic!("one line") };
    assert_eq!(line.label, "aila");
    assert_eq!(line.points.iter().map(|point| point.x).collect::<Vec<_>>(), [16.0, 32.0]);
    let speedups = of_recordings(&analysis, "trace-speedup");
    let labels: Vec<&str> = series(&speedups.panels[0]).iter().map(|series| series.label.as_str()).collect();
    assert!(
        labels.contains(&"aila") && !labels.contains(&"mine"),
        "a variant belongs to its sweep: {labels:?}"
    );
    // It is the whole frame with its interval, as everywhere.
    let frame = analysis.recordings[0].frame(RayClass::Secondary, "aila").unwrap();
    let SpeedupLine { ratio, interval, .. } = *frame.trace_speedup.known().unwrap();
    assert_eq!((line.points[0].y, line.points[0].spread), (ratio, interval));
    // A recording of the same scene with a single number of bits has no part in a sweep.
    let mut single = analysis.recordings[0].clone();
    single.frames.retain(|frame| frame.method == "aila");
    for line in single.frames.iter_mut().map(|frame| &mut frame.trace_speedup) {
        *line = Metric::Known(SpeedupLine { ratio: 9.0, ..*line.known().unwrap() });
    }
    analysis.recordings.push(single);
    let beside = of_recordings(&analysis, "key-bits");
    assert_eq!(beside.panels[0], figure.panels[0]);
}

/// What `auto` left alone is a word in the table, and not the best.
#[test]
fn nothing_is_the_best_of_a_row() {
    let (_folder, mut analysis) = analysis(Depth::Manifest);
    let frames = &mut analysis.recordings[0].frames;
    let is_auto = |frame: &FrameAnalysis| frame.method == "auto" && frame.rays == RayClass::Secondary;
    frames
        .retain(|frame| frame.rays == RayClass::Secondary && (is_auto(frame) || frame.method == "unsorted"));
    let row = |analysis: &Analysis| tables(analysis, &[])[0].rows[0].clone();
    let sorted = row(&analysis);
    let net = of_recordings(&analysis, "net-speedup");
    assert!(series(&net.panels[0]).iter().any(|series| series.label == "auto"));
    assert!(sorted.iter().any(|cell| cell.is_best), "{sorted:?}");
    analysis.recordings[0]
        .frames
        .iter_mut()
        .filter(|frame| is_auto(frame))
        .for_each(|frame| frame.left_alone = true);
    let alone = row(&analysis);
    let net = of_recordings(&analysis, "net-speedup");
    assert!(
        series(&net.panels[0]).iter().all(|series| series.label != "auto"),
        "what was not sorted gains nothing"
    );
    assert!(alone.iter().any(|cell| cell.text == "left alone"), "{alone:?}");
    assert!(alone.iter().all(|cell| !cell.is_best), "{alone:?}");
}

/// Of an order of another tracer it is known what it saves, and what moving rays takes; its key and sort are not.
#[test]
fn what_saves_is_shown_where_nobody_knows_what_a_sort_takes() {
    let (_folder, mut analysis) = analysis(Depth::Manifest);
    let even =
        |analysis: &Analysis| RayClass::ALL.map(|rays| BreakEven::of(&analysis.recordings[0], rays, "aila"));
    let known = even(&analysis);
    for frame in analysis.recordings[0].frames.iter_mut().filter(|frame| frame.method == "aila") {
        frame.net_speedup = Metric::missing("not timed");
    }
    assert!(known.iter().all(Option::is_some) && even(&analysis) == known, "from the sums of what was timed");
    let [even, overhead] = ["break-even", "overhead"].map(|name| of_recordings(&analysis, name));
    let row = |panel: &Panel| match &panel.x.scale {
        Scale::Categories(methods) => methods.iter().position(|method| method == "aila"),
        _ => None,
    };
    for panel in &even.panels {
        let place = row(panel).unwrap() as f64;
        let count = |series: &Series| series.points.iter().filter(|point| point.x == place).count();
        let counts = series(panel).iter().map(|one| (one.label.as_str(), count(one)));
        assert_eq!(counts.collect::<Vec<_>>(), [("sorting takes", 1), ("sorting saves", 1)]);
    }
    assert!(overhead.panels.iter().all(|panel| row(panel).is_none()));
}

/// Times by hand: the figure agrees with the net speedups, in nanoseconds a ray, by the trace that counts.
#[test]
fn a_sort_pays_where_it_takes_less_than_it_saves() {
    let (_folder, mut analysis) = analysis(Depth::Manifest);
    for queue in &mut analysis.recordings[0].queues {
        let Some(unsorted) = queue.order("unsorted").map(|order| order.stages[0].time.samples_ns.clone())
        else {
            continue;
        };
        for (method, way, stage, part) in
            [("aila", Way::Gathered, Stage::Trace, 2), ("two-point", Way::Indices, Stage::TraceIndirect, 4)]
        {
            let Some(order) = queue.orders.iter_mut().find(|order| order.method == method) else { continue };
            order.way = way;
            let found = order.stages.iter_mut().find(|found| found.stage == stage).unwrap();
            found.time.samples_ns = unsorted.iter().map(|ns| ns / part).collect();
        }
    }
    for frame in &mut analysis.recordings[0].frames {
        if let ("aila" | "two-point", Metric::Known(line)) = (frame.method.as_str(), &mut frame.net_speedup) {
            line.ratio = 0.8;
        }
    }
    let made = of_recordings(&analysis, "break-even");
    let recording = &analysis.recordings[0];
    for (panel, rays) in made.panels.iter().zip(RayClass::ALL) {
        let Scale::Categories(methods) = &panel.x.scale else { panic!("methods") };
        assert!(!methods.iter().any(|method| ["unsorted", "two-point-real"].contains(&method.as_str())));
        let unsorted = recording.frame(rays, "unsorted").unwrap().stages[0].median_ns;
        let queues = recording.measured().filter(|queue| RayClass::of(queue) == Some(rays));
        let unsorted = unsorted / queues.map(|queue| queue.rays).sum::<u64>() as f64;
        let [takes, saves] = series(panel) else { panic!("two numbers a method") };
        for ((takes, saves), method) in takes.points.iter().zip(&saves.points).zip(methods) {
            let net = recording.frame(rays, method).unwrap().net_speedup.known().unwrap().ratio;
            assert_eq!(takes.y < saves.y, net > 1.0, "{method}: {takes:?} {saves:?}");
            let expected = match method.as_str() {
                "aila" => [0.5, 0.75],
                "two-point" => [0.75, 1.0],
                _ => continue,
            };
            for (found, expected) in [saves.y, takes.y].into_iter().zip(expected) {
                assert!(
                    (found / unsorted - expected).abs() < 1e-3,
                    "{method}: {found} of {unsorted}, expected {expected}"
                );
            }
            let (low, high) = saves.spread.unwrap();
            assert!((low / saves.y - 1.0).abs() < 1e-3 && (high / saves.y - 1.0).abs() < 1e-3);
        }
        let limit = format!("ns a {} ray (two-point)", rays.name());
        assert!(made.caption.contains(&limit), "{}", made.caption);
    }
}

/// Views of the sample: over all rays their areas have the means that the analysis has, and rates are the clock's.
#[test]
fn a_view_has_the_areas_of_its_groups_and_the_rates_of_its_traces() {
    let (_folder, analysis) = analysis(Depth::Arrays);
    let recording = &analysis.recordings[0];
    let queue = recording.measured().find(|queue| queue.bounce == 1 && queue.kind == Kind::Closest).unwrap();
    let methods: Vec<&str> = queue.orders.iter().map(|order| order.method.as_str()).collect();
    let found = Headline::of(recording, &methods, analysis.group_width);
    let Headline { views, bounce: 1, .. } = found.known().unwrap() else { panic!("{found:?}") };
    let made = of_recordings(&analysis, "headline");
    for (view, panel) in views.iter().zip(&made.panels) {
        let order = queue.order(&view.method).unwrap();
        let areas: Vec<f64> = view.areas.iter().flatten().copied().collect();
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        assert_eq!(areas.len() as u64, queue.rays);
        assert!(
            (mean / order.coherence.known().unwrap().mean_capsule_area - 1.0).abs() < 1e-9,
            "{}",
            view.method
        );
        let unsorted = queue.order("unsorted").unwrap();
        let trace = unsorted.stages.iter().find(|found| found.stage == Stage::Trace).unwrap();
        let speedup = order.trace_speedup.known().map(|line| line.ratio);
        let rate = trace.time.mrays_per_second * speedup.unwrap_or(1.0);
        assert!((10.0..100.0).contains(&rate), "{rate}");
        let net = order.net_speedup.known().map(|line| format!(", net {:.2}\u{d7}", line.ratio));
        let net = net.unwrap_or_default();
        let said = speedup.map_or(String::new(), |speedup| format!(" (trace {speedup:.2}\u{d7}{net})"));
        assert_eq!(panel.title, format!("{}: {rate:.1} Mrays/s{said}", view.method));
        let Content::Picture(picture) = &panel.content else { panic!("a picture") };
        let is_dark = |(colour, area): (&[u8; 3], &Option<f64>)| (*colour == [0; 3]) == area.is_none();
        assert!(picture.rgb.iter().zip(&view.areas).all(is_dark), "pixels without a ray are dark");
    }
    let net = |method: &str| queue.order(method).unwrap().net_speedup.known().map_or(0.0, |line| line.ratio);
    assert!(methods.iter().all(|method| net(method) <= net(&views[1].method)), "{}", views[1].method);
    assert_eq!(views[0].method, "unsorted");
}

#[test]
fn a_curve_is_drawn_beside_orders_that_were_timed() {
    let (_folder, mut analysis) = analysis(Depth::Manifest);
    let titles: Vec<String> =
        of_recordings(&analysis, "curve").panels.into_iter().map(|panel| panel.title).collect();
    assert_eq!(
        titles,
        [
            "Morton, 8 × 8: 7 jumps",
            "Hilbert, 8 × 8: no jump",
            "Morton, 64 × 64: 511 jumps",
            "Hilbert, 64 × 64: no jump"
        ]
    );
    analysis.recordings[0]
        .queues
        .iter_mut()
        .flat_map(|queue| &mut queue.orders)
        .for_each(|order| order.stages.clear());
    assert!(figure(&analysis, &[], "curve").is_err());
}

/// Frames by hand: a third of the time is tracing, sorting costs a tenth and saves a fifth of shading.
#[test]
fn frames_are_stacked_from_their_parts_beside_their_speedup() {
    let analysis = Analysis::default();
    let benches = benches::of_each_kind();
    let made = figure(&analysis, &benches, "shading").unwrap();
    let [parts, speedups] = &made.panels[..] else { panic!("{} panels", made.panels.len()) };
    let Scale::Categories(orders) = &parts.x.scale else { panic!("orders along the axis") };
    assert_eq!((orders, &parts.x), (&vec!["none".to_owned(), "material".to_owned()], &speedups.x));
    let numbers = |panel: &Panel| -> Vec<(String, Vec<f64>)> {
        let of =
            |series: &Series| (series.label.clone(), series.points.iter().map(|point| point.y).collect());
        series(panel).iter().map(of).collect()
    };
    let expected =
        [("trace", [0.5, 0.5]), ("generate and shade", [0.5, 0.3]), ("sort and move hits", [0.0, 0.1])];
    assert_eq!(numbers(parts), expected.map(|(label, numbers)| (label.to_owned(), numbers.to_vec())));
    assert_eq!(numbers(speedups), [("whole frame".to_owned(), vec![1.0 / 0.9])]);
    assert_eq!(series(speedups)[0].points[0].x, 1.0, "in the row of its stack");
    assert!(made.caption.contains("none 4.5, material 1.0"), "{}", made.caption);
}

#[test]
fn what_recordings_cannot_give_is_skipped_with_a_reason() {
    let (_folder, analysis) = analysis(Depth::Manifest);
    for (name, part) in [
        ("capsule-area", "not read"),
        ("lane-utilisation", "not read"),
        ("table-fill", "not read"),
        ("sort-throughput", "bench sort"),
        ("trace-rate", "bench trace"),
        ("precision-error", "bench error"),
        ("image-error", "bench error"),
        ("skipped", "bench skip"),
        ("shading", "bench render"),
    ] {
        let skipped = figure(&analysis, &[], name).unwrap_err();
        assert!(skipped.reason.contains(part), "{skipped:?}");
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
