//! Fill of the length table and errors of estimated lengths, over bounces and passes.

use formats::metrics::estimator::EstimateError;
use formats::ray::Kind;

use super::building::{
    each, figure, method_style, of, panel_title, range, settings, without, without_repeated,
};
use super::{Findings, Made};
use crate::analysis::summary::distinct;
use crate::analysis::tables::Estimators;
use crate::analysis::{QueueAnalysis, RecordingAnalysis, lacking};
use crate::figures::model::{Axis, Content, Of, Panel, Point, Series};

/// Share of the table's cells that a ray was added to.
pub fn fill(findings: &Findings<'_>) -> Made {
    let panels = each(Kind::ALL, &with_own_tables(findings), |recording, kind| {
        over_bounces(findings, recording, kind, "table fill (%)", &|pass| {
            let points = of_pass(recording, kind, pass).filter_map(|queue| {
                let fill = queue.table.known()?;
                Some(point(recording, queue, fill.fill * 100.0, 1))
            });
            vec![Series::new(format!("pass {pass}"), pass as usize, points.collect())]
        })
    });
    figure(
        "Fill of the length table over bounces and passes",
        format!(
            "Share of the length table's cells that at least one ray was added to before the bounce was sorted. Closest and shadow rays have a table each, which lives on from pass to pass; passes that were not kept (`--keep-passes all`) are not shown. Along axes that are shorter than the longest one, cells beyond the scene's box stay empty: 100 % is out of reach.{}",
            without(with_own_tables(findings), |recording| lacking::of_queues(recording, |queue| &queue
                .table))
        ),
        settings(with_own_tables(findings)),
        panels,
        reason(findings, |queue| queue.table.reason()),
    )
}

/// How far the lengths that two-point and two-point-adaptive take are from the traced ones.
pub fn errors(findings: &Findings<'_>) -> Made {
    let panels = each(Kind::ALL, &with_own_tables(findings), |recording, kind| {
        let known = recording.queues.iter().filter(|queue| queue.estimators.known().is_some());
        let last = known.map(|queue| queue.pass).max();
        over_bounces(findings, recording, kind, "mean error (unit lengths)", &|pass| {
            let line = |label: String, style: usize, error: fn(&Estimators) -> &EstimateError| {
                let points = of_pass(recording, kind, pass).filter_map(|queue| {
                    let error = error(queue.estimators.known()?);
                    let ends = [error.median_absolute, error.root_mean_square, error.mean_absolute];
                    let point = point(recording, queue, error.mean_absolute, error.n as usize);
                    Some(Point { spread: range(&ends), ..point })
                });
                Series::new(label, style, points.collect())
            };
            if Some(pass) != last {
                // Earlier passes take the styles after those of all methods. The constant learns nothing,
                // so that its last pass stands for all.
                return vec![line(format!("two-point-adaptive, pass {pass}"), 20 + pass as usize, |of| {
                    &of.table
                })];
            }
            let style = |method| method_style(findings, method);
            vec![
                line("two-point-adaptive".to_owned(), style("two-point-adaptive"), |of| &of.table),
                line("two-point".to_owned(), style("two-point"), |of| &of.constant),
            ]
        })
    });
    figure(
        "Errors of estimated ray lengths over bounces and passes",
        format!(
            "Mean of |estimate − traced length| in unit lengths, for the mean of a ray's cell in the length table (two-point-adaptive) and for one length for all rays (two-point); both cut by the ray's own end and the scene's box, as in the keys. Whiskers span the median error, the mean and the root of the mean square.{}",
            without(with_own_tables(findings), |recording| {
                lacking::of_queues(recording, |queue| &queue.estimators)
            })
        ),
        settings(with_own_tables(findings)),
        panels,
        reason(findings, |queue| queue.estimators.reason()),
    )
}

/// The recordings without those whose tables are another's, as those of most replays are.
fn with_own_tables<'a>(findings: &Findings<'a>) -> Vec<&'a RecordingAnalysis> {
    let table = |queue: &'a QueueAnalysis| {
        let known = queue.table.known().is_some() || queue.estimators.known().is_some();
        known.then_some((queue.pass, queue.bounce, queue.kind, &queue.table, &queue.estimators))
    };
    without_repeated(findings.analysis.recordings.iter().collect(), |recording| {
        recording.queues.iter().filter_map(table).collect()
    })
}

fn of_pass(recording: &RecordingAnalysis, kind: Kind, pass: u32) -> impl Iterator<Item = &QueueAnalysis> {
    recording.queues.iter().filter(move |queue| queue.kind == kind && queue.pass == pass)
}

/// A panel with the series of each pass.
fn over_bounces(
    findings: &Findings<'_>,
    recording: &RecordingAnalysis,
    kind: Kind,
    axis: &str,
    series: &dyn Fn(u32) -> Vec<Series>,
) -> Panel {
    let mut passes = distinct(recording.queues.iter().map(|queue| queue.pass));
    passes.sort_unstable();
    Panel::new(
        panel_title(findings, recording, &format!("{kind} rays")),
        Axis::from_zero("bounce"),
        Axis::from_zero(axis),
        Content::Lines(passes.into_iter().flat_map(series).collect()),
    )
}

fn point(recording: &RecordingAnalysis, queue: &QueueAnalysis, y: f64, n: usize) -> Point {
    let detail = format!("pass {}", queue.pass);
    Point::new(queue.bounce.into(), y, n, Of { detail, ..of(recording, queue.kind, Some(queue.bounce), "") })
}

fn reason<'a>(findings: &Findings<'a>, of: impl Fn(&'a QueueAnalysis) -> Option<&'a str>) -> String {
    let queues = findings.analysis.recordings.iter().flat_map(|recording| &recording.queues);
    queues.rev().find_map(of).unwrap_or("there are no queues").to_owned()
}
