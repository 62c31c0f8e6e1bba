//! Which tables recordings and benchmarks give: the numbers that a paper on reordering reports.

use formats::bench_result::{BenchResult, Rows, SortRow};
use formats::key::method::{AUTO, CONTROL, UNSORTED};
use formats::manifest::{LEFT_ALONE, Stage};
use formats::metrics::correlation::Correlation;
use formats::metrics::speedup::{Verdict, median};
use formats::ray::Kind;

use super::table::{Cell, Table};
use crate::analysis::order::Varied;
use crate::analysis::study::StudyGroup;
use crate::analysis::summary::{RayClass, distinct};
use crate::analysis::{Analysis, FrameAnalysis, Metric, OrderAnalysis, QueueAnalysis, RecordingAnalysis};
use crate::figures::catalogue::building::machine;
use crate::figures::catalogue::study::label;
use crate::output::counted;

/// Every table that has a number.
pub fn tables(analysis: &Analysis, benches: &[BenchResult]) -> Vec<Table> {
    let rays = || RayClass::ALL.into_iter();
    let sweeps = SWEPT.iter().filter_map(|swept| sweep(analysis, swept));
    rays()
        .filter_map(|rays| study(analysis, rays))
        .chain(studied_sweeps(analysis))
        .chain(rays().filter_map(|rays| speedups(analysis, rays)))
        .chain(rays().filter_map(|rays| overhead(analysis, rays)))
        .chain(rays().filter_map(|rays| models(analysis, rays)))
        .chain(correlations(analysis))
        .chain(sweeps)
        .chain(benches.iter().filter_map(sort))
        .collect()
}

/// A table, if it has rows.
fn table(title: String, caption: &str, header: Vec<String>, rows: Vec<Vec<Cell>>) -> Option<Table> {
    (!rows.is_empty()).then(|| Table { title, caption: caption.to_owned(), header, rows })
}

/// The methods of some recordings, without variants of others, `unsorted` and the control.
fn methods(analysis: &Analysis, rays: RayClass) -> Vec<&str> {
    let frames = analysis.recordings.iter().flat_map(|recording| &recording.frames);
    let own = frames.filter(|frame| frame.rays == rays && frame.base == frame.method);
    distinct(own.map(|frame| frame.method.as_str()).filter(|name| ![UNSORTED, CONTROL].contains(name)))
}

fn header(first: &str, columns: impl IntoIterator<Item = impl ToString>) -> Vec<String> {
    std::iter::once(first.to_owned()).chain(columns.into_iter().map(|name| name.to_string())).collect()
}

/// Trace and net speedup of a method over a frame.
fn of_frame(frame: &FrameAnalysis) -> Option<(f64, f64)> {
    Some((frame.trace_speedup.known()?.ratio, frame.net_speedup.known()?.ratio))
}

/// A row of trace and net speedups. The largest of the net speedups that come with them is marked.
fn row_of(name: &str, cells: impl IntoIterator<Item = (Cell, Option<f64>)>) -> Vec<Cell> {
    let cells: Vec<(Cell, Option<f64>)> = cells.into_iter().collect();
    let best = cells.iter().filter_map(|(_, net)| *net).fold(f64::NEG_INFINITY, f64::max);
    let marked = cells.into_iter().map(|(cell, net)| Cell { is_best: net == Some(best), ..cell });
    std::iter::once(Cell::plain(name)).chain(marked).collect()
}

/// The net speedup of an order of another tracer is not known.
fn both(trace: f64, net: Option<f64>) -> Cell {
    Cell::plain(format!("{trace:.2} / {}", net.map_or("–".to_owned(), |net| format!("{net:.2}"))))
}

/// A cell of a recording's row, with its net speedup if it is shown to pay: only such ones are called the best.
fn speedup_cell(frame: Option<&FrameAnalysis>) -> (Cell, Option<f64>) {
    if frame.is_some_and(|frame| frame.left_alone) {
        return (Cell::plain(LEFT_ALONE), None);
    }
    let Some((frame, trace)) = frame.and_then(|frame| Some((frame, frame.trace_speedup.known()?))) else {
        return (Cell::plain("–"), None);
    };
    let net = frame.net_speedup.known();
    let pays = net.filter(|line| line.verdict == Verdict::Faster);
    (both(trace.ratio, net.map(|line| line.ratio)), pays.map(|line| line.ratio))
}

/// Means over a study: a row a method, a column a machine and kind of recording.
fn study(analysis: &Analysis, rays: RayClass) -> Option<Table> {
    let groups = analysis.study.iter().flat_map(|study| &study.groups).filter(|group| !group.is_sweep());
    study_table("Study", &groups.collect::<Vec<_>>(), rays)
}

/// Means over the replays of a study with sweeps, each by itself: a row a variant, a column a machine.
fn studied_sweeps(analysis: &Analysis) -> impl Iterator<Item = Table> {
    let groups = || analysis.study.iter().flat_map(|study| &study.groups).filter(|group| group.is_sweep());
    let of_name = move |name: &str| {
        let own: Vec<&StudyGroup> = groups().filter(|group| group.name == name).collect();
        RayClass::ALL.map(|rays| study_table(&format!("Study, {name}"), &own, rays)).into_iter().flatten()
    };
    distinct(groups().map(|group| group.name.as_str())).into_iter().flat_map(of_name)
}

fn study_table(title: &str, groups: &[&StudyGroup], rays: RayClass) -> Option<Table> {
    let groups: Vec<&StudyGroup> =
        groups.iter().copied().filter(|group| group.methods(rays).count() > 0).collect();
    let methods =
        distinct(groups.iter().flat_map(|group| group.methods(rays)).map(|row| row.method.as_str()));
    let row = |method: &str| {
        let cell = |group: &&StudyGroup| {
            let Some(row) = group.methods(rays).find(|row| row.method == method) else {
                return Cell::plain("–");
            };
            let best = group.methods(rays).find(|row| row.method != CONTROL && group.is_shown_to_pay(row));
            let best = best.map(|row| row.method.as_str());
            let trace = row.trace.mean.ratio;
            let net = row.net.as_ref().map(|net| {
                let interval = net.mean.interval.map(|(low, high)| format!(" [{low:.2}, {high:.2}]"));
                format!(" / {:.2}{}", net.mean.ratio, interval.unwrap_or_default())
            });
            let (own, all) = (row.trace.views, group.views_of(rays));
            let part = if own < all { format!(" ({own} of {all} views)") } else { String::new() };
            let text = format!("{trace:.2}{}{part}", net.unwrap_or_default());
            Cell { text, is_best: best == Some(method) }
        };
        std::iter::once(Cell::plain(method)).chain(groups.iter().map(cell)).collect()
    };
    table(
        format!("{title}: trace / net speedup, {} rays", rays.name()),
        "Geometric means over scenes of geometric means over their views (cameras and seeds), of each recording the whole frame; 95 % intervals by bootstrap over views and rounds. Marked is the best of those whose interval lies beyond 1 and what the control misses it by; a mean over fewer views is not compared.",
        header(
            "method",
            groups.iter().map(|group| {
                format!(
                    "{} ({} of {})",
                    label(group),
                    counted(group.views as u64, "view", "views"),
                    counted(group.scenes.len() as u64, "scene", "scenes")
                )
            }),
        ),
        methods.into_iter().map(row).collect(),
    )
}

fn speedups(analysis: &Analysis, rays: RayClass) -> Option<Table> {
    let mut methods = methods(analysis, rays);
    // None is given for a method that must trace the rays before it can sort them.
    let is_timed =
        |frame: Option<&FrameAnalysis>| frame.is_some_and(|one| one.trace_speedup.known().is_some());
    methods
        .retain(|method| analysis.recordings.iter().any(|recording| is_timed(recording.frame(rays, method))));
    let mut rows = Vec::new();
    for configuration in distinct(analysis.recordings.iter().map(|recording| &recording.configuration)) {
        let same = analysis.recordings.iter().filter(|recording| recording.configuration == *configuration);
        let mut count = 0;
        for recording in same {
            let frames: Vec<_> = methods.iter().map(|method| recording.frame(rays, method)).collect();
            if !frames.iter().any(|frame| is_timed(*frame)) {
                continue;
            }
            let mut row = row_of(&recording.label, frames.into_iter().map(speedup_cell));
            let control = recording.control(rays);
            row.push(Cell::plain(control.map_or("–".to_owned(), |line| format!("{:.2}", line.ratio))));
            rows.push(row);
            count += 1;
        }
        if count > 1 {
            let mean = |method: &&str| {
                let is_own = |summary: &&crate::analysis::MethodSummary| {
                    (summary.rays, &summary.configuration, summary.method.as_str())
                        == (rays, configuration, *method)
                };
                let summary = analysis.summaries.iter().find(is_own);
                let known =
                    summary.and_then(|one| Some((one.trace_speedup.known()?, one.net_speedup.known())));
                let Some((trace, net)) = known else { return (Cell::plain("–"), None) };
                let net = net.filter(|net| net.n == trace.n);
                let cell = both(trace.mean, net.map(|net| net.mean));
                // A mean over other recordings is not to be compared.
                if trace.n < count {
                    return (Cell::plain(format!("{} ({} of {count})", cell.text, trace.n)), None);
                }
                let pays = net.filter(|net| net.faster == net.n);
                (cell, pays.map(|net| net.mean))
            };
            let mut row = row_of(&format!("mean: {configuration}"), methods.iter().map(mean));
            row.push(Cell::default());
            rows.push(row);
        }
    }
    table(
        format!("Trace / net speedup, {} rays", rays.name()),
        "Unsorted trace over sorted trace, and over all that the method costs (– where what keys and sort cost is not known): the whole frame, times of all bounces summed round by round. Marked is the best of those that are shown to pay. Means are geometric, over recordings (of as many as is said where others have no such order), those that `auto` left alone with what they measured, and marked where each one pays. The control is canonical order measured like a method: what it misses 1 by is the instrument's error.",
        header("recording", methods.iter().copied().chain([CONTROL])),
        rows,
    )
}

/// Time of each stage of the method that is best net, and of the paper's best.
fn overhead(analysis: &Analysis, rays: RayClass) -> Option<Table> {
    let mut rows = Vec::new();
    for recording in &analysis.recordings {
        let own = recording
            .frames
            .iter()
            .filter(|frame| frame.rays == rays && frame.base == frame.method && frame.is_candidate());
        let net = |frame: &&FrameAnalysis| of_frame(frame).map_or(f64::NEG_INFINITY, |(_, net)| net);
        let best = own.filter(|frame| of_frame(frame).is_some()).max_by(|a, b| net(a).total_cmp(&net(b)));
        let paper = recording.frame(rays, "two-point-adaptive");
        for frame in distinct(best.into_iter().chain(paper)) {
            rows.extend(overhead_row(recording, frame));
        }
    }
    let columns = [
        "method",
        "decide",
        "key",
        "sort",
        "gather",
        "scatter",
        "accumulate",
        "together",
        "unsorted trace",
        "sorted trace",
        "trace speedup, gathered",
        "net speedup",
    ];
    table(
        format!("Overhead, {} rays, ms", rays.name()),
        "The method that is best net, and two-point-adaptive, which the paper proposes: medians over rounds of sums over bounces, in parentheses the share of what sorting costs. Where rays are traced through indices, nothing is gathered or scattered, and the sorted trace has it in itself; the trace speedup is that of gathered rays, as in the other tables. `auto` traces each queue one way: its sorted trace is the sum, with queues that it left alone.",
        header("recording", columns),
        rows,
    )
}

fn overhead_row(recording: &RecordingAnalysis, frame: &FrameAnalysis) -> Option<Vec<Cell>> {
    let time = |stage: Stage| {
        frame.stages.iter().find(|found| found.stage == stage).map(|found| found.median_ns / 1e6)
    };
    let unsorted = recording.frame(frame.rays, UNSORTED)?;
    let unsorted = unsorted.stages.iter().find(|found| found.stage == Stage::Trace)?.median_ns / 1e6;
    let parts =
        [Stage::Decide, Stage::Key, Stage::Sort, Stage::Gather, Stage::Scatter, Stage::Accumulate].map(time);
    // The sum of nothing is −0, which would be printed.
    let sum = parts.iter().flatten().sum::<f64>() + 0.0;
    let [stored, indirect] = [Stage::Trace, Stage::TraceIndirect].map(time);
    // Others are traced either way, to be compared; `auto` traces each queue one way.
    let sorted = if frame.method == AUTO {
        stored.unwrap_or(0.0) + indirect.unwrap_or(0.0)
    } else {
        stored.or(indirect)?
    };
    let part = |part: &Option<f64>| match part {
        Some(ms) => Cell::plain(format!("{ms:.2} ({:.0} %)", ms / sum.max(f64::MIN_POSITIVE) * 100.0)),
        None => Cell::plain("–"),
    };
    let names = [recording.label.clone(), frame.method.clone()].into_iter().map(Cell::plain);
    let rest = [format!("{sum:.2}"), format!("{unsorted:.2}"), format!("{sorted:.2}")];
    let speedups = of_frame(frame).map_or([None; 2], |(trace, net)| [Some(trace), Some(net)]);
    let speedups = speedups.map(|one| one.map_or("–".to_owned(), |ratio| format!("{ratio:.2}")));
    Some(
        names
            .chain(parts.iter().map(part))
            .chain(rest.into_iter().chain(speedups).map(Cell::plain))
            .collect(),
    )
}

/// A share of an order, percent, and what weighs it.
type Share = fn(&QueueAnalysis, &OrderAnalysis) -> Option<(f64, f64)>;

/// What lanes and caches would say, by method: lanes at each bounce, too.
fn models(analysis: &Analysis, rays: RayClass) -> Option<Table> {
    let lanes: Share = |queue, order| Some((order.warp_utilisation()?, queue.rays as f64));
    let first: Share = |queue, order| order.caches.known().map(|hits| (hits.l1, hits.lines(queue.rays)));
    let either: Share = |queue, order| order.caches.known().map(|hits| (hits.either, hits.lines(queue.rays)));
    let methods: Vec<&str> = std::iter::once(UNSORTED).chain(methods(analysis, rays)).collect();
    let mut bounces = distinct(queues(analysis, rays).map(|(_, queue)| queue.bounce));
    bounces.sort_unstable();
    let mut wanted: Vec<(String, Share, Option<u32>)> = vec![("lanes".to_owned(), lanes, None)];
    wanted.extend(bounces.into_iter().map(|bounce| (format!("lanes, bounce {bounce}"), lanes, Some(bounce))));
    wanted.push(("L1".to_owned(), first, None));
    wanted.push(("L1 or L2".to_owned(), either, None));
    let row = |(name, share, bounce): (String, Share, Option<u32>)| {
        let means = methods.iter().map(|method| mean_share(analysis, rays, method, share, bounce));
        let means: Vec<Option<(f64, usize)>> = means.collect();
        let all = means.iter().flatten().map(|(_, n)| *n).max()?;
        let cells = means.iter().map(|mean| match mean {
            Some((percent, n)) if *n < all => format!("{percent:.1} ({n} of {all})"),
            Some((percent, _)) => format!("{percent:.1}"),
            None => "–".to_owned(),
        });
        Some(std::iter::once(name).chain(cells).map(Cell::plain).collect())
    };
    table(
        format!("What lanes and caches would say, {} rays, %", rays.name()),
        "Models, which do not depend on the machine's load: lanes that work of 32 that wait for each other, and lines found in a modelled L1 and L2. Means over recordings (of as many as is said where others have no such order); in each the bounces are weighted by their rays, or by the lines that these ask for.",
        header("", methods.iter().copied()),
        wanted.into_iter().filter_map(row).collect(),
    )
}

fn queues(analysis: &Analysis, rays: RayClass) -> impl Iterator<Item = (&RecordingAnalysis, &QueueAnalysis)> {
    let all = analysis.recordings.iter();
    all.flat_map(move |recording| recording.measured_of(rays).map(move |queue| (recording, queue)))
}

/// Mean over recordings, percent, and of how many.
fn mean_share(
    analysis: &Analysis,
    rays: RayClass,
    method: &str,
    share: Share,
    bounce: Option<u32>,
) -> Option<(f64, usize)> {
    let of_recording = |recording: &RecordingAnalysis| {
        let of_rays = recording.measured_of(rays);
        let own = of_rays.filter(|queue| bounce.is_none_or(|bounce| queue.bounce == bounce));
        let shares = own.filter_map(|queue| share(queue, queue.order(method)?));
        let (sum, weight) =
            shares.fold((0.0, 0.0), |(sum, weight), (share, part)| (sum + share * part, weight + part));
        (weight > 0.0).then(|| sum / weight * 100.0)
    };
    let means: Vec<f64> = analysis.recordings.iter().filter_map(of_recording).collect();
    (!means.is_empty()).then(|| (means.iter().sum::<f64>() / means.len() as f64, means.len()))
}

fn correlations(analysis: &Analysis) -> Option<Table> {
    let of = |name: &str, kind: Kind| {
        let line = analysis.correlations.iter().find(|line| line.of == name && line.kind == Some(kind));
        match line.map(|line| &line.correlation) {
            Some(Metric::Known(Correlation { pearson, spearman, n })) => {
                Some(format!("{pearson:.2}, {spearman:.2} ({n})").replace('-', "−"))
            }
            _ => None,
        }
    };
    let row = |name: &str| {
        let cells = Kind::ALL.map(|kind| of(name, kind));
        cells.iter().any(Option::is_some).then(|| {
            let cells = cells.into_iter().map(|cell| Cell::plain(cell.unwrap_or("–".to_owned())));
            std::iter::once(Cell::plain(name)).chain(cells).collect()
        })
    };
    table(
        "Capsule area against trace time".to_owned(),
        "Pearson's and Spearman's coefficients over the orders of all bounces (their number), area and time over those of the same queue unsorted.",
        header("recording", ["closest rays", "shadow rays"]),
        distinct(analysis.correlations.iter().map(|line| line.of.as_str()))
            .into_iter()
            .filter_map(row)
            .collect(),
    )
}

/// What variants of a method differ in, and what that is called.
const SWEPT: [(&str, Varied); 3] = [
    ("bits of the key", Varied::KEY_BITS),
    ("bits of the origin", Varied::ORIGIN_BITS),
    ("assumed length, unit lengths", Varied::LENGTH),
];

fn sweep(analysis: &Analysis, (what, swept): &(&str, Varied)) -> Option<Table> {
    let mut lines: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for (recording, rays) in analysis.recordings.iter().flat_map(|one| RayClass::ALL.map(|rays| (one, rays)))
    {
        let frames = || recording.frames.iter().filter(move |frame| frame.rays == rays);
        for base in distinct(frames().map(|frame| frame.base.as_str()).filter(|base| *base != UNSORTED)) {
            let order = |frame: &FrameAnalysis| {
                let mut orders = recording.measured_of(rays).flat_map(|queue| &queue.orders);
                orders.find(|order| order.method == frame.method).cloned()
            };
            let orders: Vec<_> = frames()
                .filter(|frame| frame.base == base)
                .filter_map(|frame| Some((frame, order(frame)?)))
                .collect();
            let others = distinct(
                orders
                    .iter()
                    .filter(|(_, order)| (swept.of)(order).is_some())
                    .map(|(_, order)| (swept.other)(order)),
            );
            let number = |(frame, order): &(&FrameAnalysis, OrderAnalysis)| {
                Some(((swept.of)(order)?, frame.net_speedup.known()?.ratio))
            };
            let points: Vec<(f64, f64)> = orders.iter().filter_map(number).collect();
            if distinct(points.iter().map(|(varied, _)| *varied)).len() > 1 && others.len() == 1 {
                lines.push((format!("{}, {}, {base}", recording.label, rays.name()), points));
            }
        }
    }
    let mut columns = distinct(lines.iter().flat_map(|(_, points)| points.iter().map(|(varied, _)| *varied)));
    columns.sort_by(f64::total_cmp);
    let row = |(name, points): &(String, Vec<(f64, f64)>)| {
        let best = points.iter().map(|(_, net)| *net).fold(f64::NEG_INFINITY, f64::max);
        let cell = |column: &f64| match points.iter().find(|(varied, _)| varied == column) {
            Some((_, net)) => Cell { text: format!("{net:.2}"), is_best: *net == best },
            None => Cell::plain("–"),
        };
        std::iter::once(Cell::plain(name.as_str())).chain(columns.iter().map(cell)).collect()
    };
    table(
        format!("Net speedup by {what}"),
        "Unsorted trace over all that the method costs, the whole frame.",
        header("recording, rays, method", columns.iter().map(|column| (column * 1e3).round() / 1e3)),
        lines.iter().map(row).collect(),
    )
}

fn sort(bench: &BenchResult) -> Option<Table> {
    let Rows::Sort(rows) = &bench.rows else { return None };
    let mut bits = distinct(rows.iter().map(|row| row.key_bits));
    bits.sort_unstable();
    let mut numbers = distinct(rows.iter().map(|row| row.n));
    numbers.sort_unstable();
    let rate = |n: u64, key_bits: u32| {
        let is_it = |row: &&SortRow| (row.n, row.key_bits) == (n, key_bits);
        Some(n as f64 / median(&rows.iter().find(is_it)?.samples_ns)? * 1e3)
    };
    let row = |n: u64| {
        let cells =
            bits.iter().map(|&bits| rate(n, bits).map_or("–".to_owned(), |rate| format!("{rate:.1}")));
        std::iter::once(n.to_string()).chain(cells).map(Cell::plain).collect()
    };
    table(
        format!("Sort throughput, Mkeys/s, {}", machine(bench)),
        "Medians; random keys with their indices.",
        header("keys", bits.iter().map(|bits| format!("{bits} bits"))),
        numbers.into_iter().map(row).collect(),
    )
}
