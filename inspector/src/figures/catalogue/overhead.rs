//! What each stage of a method takes, against the trace that it is to make faster.

use formats::key::method::UNSORTED;
use formats::manifest::Stage;

use super::building::{figure, leading, left_out, of, panel_title, queues, recordings, settings};
use super::{Findings, Made};
use crate::analysis::summary::RayClass;
use crate::analysis::timing::{stacked, stage_name};
use crate::analysis::{QueueAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Of, Panel, Point, Series};
use crate::figures::style::STAGE_STYLES;

/// Time of each stage per method, one after the other, over the trace of unsorted rays.
pub fn overhead(findings: &Findings<'_>) -> Made {
    figure(
        "Where the time goes, per method",
        format!(
            "Median times of the stages, summed over bounces, as multiples of the trace of unsorted rays: a row that ends left of the line is faster in the median, and whether it is beyond chance says `net-speedup`. Gather, trace and scatter count, or the trace through indices: what the recording chose for the method.{}",
            left_out(findings)
        ),
        settings(recordings(findings)),
        recordings(findings)
            .into_iter()
            .flat_map(|recording| RayClass::ALL.map(|rays| panel(findings, recording, rays))),
        "no stage of any method was timed",
    )
}

fn panel(findings: &Findings<'_>, recording: &RecordingAnalysis, rays: RayClass) -> Panel {
    let measured: Vec<&QueueAnalysis> = queues(recording, rays).collect();
    let unsorted = stage_time(&measured, UNSORTED, Stage::Trace).map_or(f64::NAN, |(ns, _)| ns);
    let methods = leading(findings, recording, rays);
    let series = |(at, stage): (usize, Stage)| -> Series {
        let points = methods.iter().enumerate().filter_map(|(place, method)| {
            let (ns, n) = stage_time(&measured, method, stage)?;
            let of = Of { detail: stage_name(stage).to_owned(), ..of(recording, rays.name(), None, method) };
            Some(Point { x: place as f64, y: ns / unsorted, spread: None, n, of })
        });
        let style = STAGE_STYLES + at;
        Series { label: stage_name(stage).to_owned(), style, points: points.collect(), is_part: false }
    };
    Panel::new(
        panel_title(findings, recording, &format!("{} rays", rays.name())),
        Axis::categories("", methods.iter().copied()),
        Axis::from_zero("time (unsorted trace = 1)"),
        Content::Stacks(stacked().map(series).collect()),
    )
    .with_reference("break-even: trace of unsorted rays", 1.0)
}

/// Sum over queues of a stage's median times, and its samples; `None` if it is not part of the way taken.
fn stage_time(queues: &[&QueueAnalysis], method: &str, stage: Stage) -> Option<(f64, usize)> {
    let orders = queues.iter().filter_map(|queue| queue.order(method));
    let times: Vec<(f64, usize)> = orders
        .filter(|order| order.way.counts(stage))
        .filter_map(|order| order.stage(stage))
        .map(|found| (found.time.median_ns, found.time.samples_ns.len()))
        .collect();
    let ns = times.iter().map(|(ns, _)| ns).sum();
    Some((ns, times.iter().map(|(_, n)| *n).min()?))
}
