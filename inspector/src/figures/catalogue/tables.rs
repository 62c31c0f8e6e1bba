//! Fill of the length table and errors of estimated lengths, over bounces and passes.

use formats::metrics::estimator::EstimateError;
use formats::ray::Kind;

use super::building::{figure, kind_title, linear, method_style, panel_title, settings};
use super::{Material, Skipped};
use crate::analysis::tables::Estimators;
use crate::analysis::{QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Content, Figure, Panel, Point, Series};

/// Share of the table's cells that a ray was added to.
pub fn fill(material: &Material<'_>) -> Result<Figure, Skipped> {
    let panels = each_kind(material).map(|(recording, kind)| {
        over_bounces(material, recording, kind, "table fill (%)", &|pass| {
            let points = of_pass(recording, kind, pass).filter_map(|queue| {
                let fill = queue.table.known()?;
                Some(point(recording, queue, fill.fill * 100.0, 1))
            });
            vec![Series { label: format!("pass {pass}"), style: pass as usize, points: points.collect() }]
        })
    });
    let parts = Figure {
        name: "table-fill".to_owned(),
        title: "Fill of the length table over bounces and passes".to_owned(),
        caption: "Share of the length table's cells that at least one ray was added to before the bounce was sorted. Closest and shadow rays have a table each, which lives on from pass to pass.".to_owned(),
        settings: settings(material),
        panels: panels.collect(),
    };
    figure(parts, reason(material, |queue| queue.table.reason()))
}

/// How far the lengths that two-point and two-point-adaptive take are from the traced ones.
pub fn errors(material: &Material<'_>) -> Result<Figure, Skipped> {
    let panels = each_kind(material).map(|(recording, kind)| {
        let last = recording.queues.iter().filter(|queue| queue.estimators.known().is_some());
        let last = last.map(|queue| queue.pass).max();
        over_bounces(material, recording, kind, "mean error (unit lengths)", &|pass| {
            let suffix = if Some(pass) == last { String::new() } else { format!(", pass {pass}") };
            let mut series = vec![estimator(
                recording,
                kind,
                pass,
                format!("table{suffix}"),
                // Earlier passes take the styles after those of all methods.
                if suffix.is_empty() {
                    method_style(material, "two-point-adaptive")
                } else {
                    20 + pass as usize
                },
                |estimators| &estimators.table,
            )];
            // The constant learns nothing, so that its last pass stands for all.
            series.extend(suffix.is_empty().then(|| {
                let style = method_style(material, "two-point");
                estimator(recording, kind, pass, "constant".to_owned(), style, |estimators| {
                    &estimators.constant
                })
            }));
            series
        })
    });
    let parts = Figure {
        name: "estimator-error".to_owned(),
        title: "Errors of estimated ray lengths over bounces and passes".to_owned(),
        caption: "Mean of |estimate − traced length| in unit lengths, for the mean of a ray's cell in the length table (two-point-adaptive) and for one length for all rays (two-point); both cut by the ray's own end and the scene's box, as in the keys. Whiskers reach from the median error to the root of the mean square.".to_owned(),
        settings: settings(material),
        panels: panels.collect(),
    };
    figure(parts, reason(material, |queue| queue.estimators.reason()))
}

/// Each kind and recording; without recordings whose tables are another's, as those of most replays are.
fn each_kind<'a>(material: &Material<'a>) -> impl Iterator<Item = (&'a RecordingAnalysis, Kind)> {
    let recordings = &material.analysis.recordings;
    let tables = |recording: &'a RecordingAnalysis| {
        recording
            .queues
            .iter()
            .map(|queue| (queue.pass, queue.bounce, queue.kind, &queue.table, &queue.estimators))
    };
    let is_new = move |(at, recording): &(usize, &'a RecordingAnalysis)| {
        let same = |earlier: &'a RecordingAnalysis| {
            earlier.content_hash == recording.content_hash && tables(earlier).eq(tables(recording))
        };
        !recordings[..*at].iter().any(same)
    };
    let new: Vec<_> = recordings.iter().enumerate().filter(is_new).map(|(_, recording)| recording).collect();
    Kind::ALL
        .into_iter()
        .flat_map(move |kind| new.clone().into_iter().map(move |recording| (recording, kind)))
}

fn of_pass(recording: &RecordingAnalysis, kind: Kind, pass: u32) -> impl Iterator<Item = &QueueAnalysis> {
    recording.queues.iter().filter(move |queue| queue.kind == kind && queue.pass == pass)
}

/// A panel with the series of each pass.
fn over_bounces(
    material: &Material<'_>,
    recording: &RecordingAnalysis,
    kind: Kind,
    axis: &str,
    series: &dyn Fn(u32) -> Vec<Series>,
) -> Panel {
    let mut passes: Vec<u32> = recording.queues.iter().map(|queue| queue.pass).collect();
    passes.sort_unstable();
    passes.dedup();
    Panel {
        title: panel_title(material, recording, &kind_title(kind)),
        x: linear("bounce", true),
        y: linear(axis, true),
        content: Content::Lines(passes.into_iter().flat_map(series).collect()),
        references: Vec::new(),
    }
}

fn estimator(
    recording: &RecordingAnalysis,
    kind: Kind,
    pass: u32,
    label: String,
    style: usize,
    error: fn(&Estimators) -> &EstimateError,
) -> Series {
    let points = of_pass(recording, kind, pass).filter_map(|queue| {
        let error = error(queue.estimators.known()?);
        let mut point = point(recording, queue, error.mean_absolute, error.n as usize);
        let ends = [error.median_absolute, error.root_mean_square, error.mean_absolute];
        point.spread = super::building::range(&ends);
        Some(point)
    });
    Series { points: points.collect(), label, style }
}

fn point(recording: &RecordingAnalysis, queue: &QueueAnalysis, y: f64, n: usize) -> Point {
    Point {
        x: f64::from(queue.bounce),
        y,
        spread: None,
        n,
        name: format!("{}, pass {}, bounce {}, {}", recording.label, queue.pass, queue.bounce, queue.kind),
    }
}

fn reason<'a>(material: &Material<'a>, of: impl Fn(&'a QueueAnalysis) -> Option<&'a str>) -> String {
    let queues = material.analysis.recordings.iter().flat_map(|recording| &recording.queues);
    queues.rev().find_map(of).unwrap_or("there are no queues").to_owned()
}
