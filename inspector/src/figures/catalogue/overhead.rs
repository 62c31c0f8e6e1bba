//! What each stage of a method takes, against the trace that it is to make faster.

use formats::manifest::Stage;

use super::building::{figure, leading, left_out, of, panel_title, recordings, settings};
use super::{Findings, Made};
use crate::analysis::RecordingAnalysis;
use crate::analysis::break_even::BreakEven;
use crate::analysis::frame::FrameStage;
use crate::analysis::summary::RayClass;
use crate::analysis::timing::{stacked, stage_name};
use crate::figures::model::{Axis, Content, Of, Panel, Point, Series};
use crate::figures::style::STAGE_STYLES;

/// Time of each stage per method, one after the other, over the trace of unsorted rays.
pub fn overhead(findings: &Findings<'_>) -> Made {
    figure(
        "Where the time goes, per method",
        format!(
            "Time of all stages over all bounces, as a multiple of the trace of unsorted rays. A row ends at one over the net speedup, left of the line where that is above 1; `net-speedup` has its interval. What is traced, and what is added to it, are those of `break-even`, shared out among stages by their median times; what is added is never less than nothing. Gather, trace and scatter count, or the trace through indices: what the recording chose for the method. None is given for two-point-real, which must trace the rays before it can sort them, for orders of another tracer, whose key and sort were not timed, nor for auto where it left all of them alone.{}",
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
    let row = |method| Some((method, shares(recording, rays, method)?));
    let methods: Vec<(&str, Vec<(&FrameStage, f64)>)> =
        leading(findings, recording, rays).into_iter().filter_map(row).collect();
    let series = |(at, stage): (usize, Stage)| -> Series {
        let points = methods.iter().enumerate().filter_map(|(place, (method, shares))| {
            let (found, share) = shares.iter().find(|(found, _)| found.stage == stage)?;
            let of = Of { detail: stage_name(stage).to_owned(), ..of(recording, rays.name(), None, method) };
            Some(Point::new(place as f64, *share, found.n, of))
        });
        Series::new(stage_name(stage), STAGE_STYLES + at, points.collect())
    };
    Panel::new(
        panel_title(findings, recording, &format!("{} rays", rays.name())),
        Axis::categories("", methods.iter().map(|(method, _)| *method)),
        Axis::from_zero("time (unsorted trace = 1)"),
        Content::Stacks(stacked().map(series).collect()),
    )
    .with_reference("break-even: trace of unsorted rays", 1.0)
}

/// The stages of a method, and how long each takes of the trace of unsorted rays.
fn shares<'a>(
    recording: &'a RecordingAnalysis,
    rays: RayClass,
    method: &str,
) -> Option<Vec<(&'a FrameStage, f64)>> {
    let BreakEven { saved_ns, cost_ns, unsorted_ns, .. } = BreakEven::of(recording, rays, method)?;
    let frame = recording.frame(rays, method)?;
    frame.net_speedup.known()?;
    let stages = &frame.stages;
    let is_trace = |stage: &FrameStage| matches!(stage.stage, Stage::Trace | Stage::TraceIndirect);
    let sum = |of_trace: bool| -> f64 {
        stages.iter().filter(|stage| is_trace(stage) == of_trace).map(|stage| stage.median_ns).sum()
    };
    let (traces, others) = (Some(sum(true)).filter(|traces| *traces > 0.0)?, sum(false));
    // Ratios of few rounds may leave less than nothing for the rest.
    let cost = if others > 0.0 { cost_ns.max(0.0) } else { 0.0 };
    let trace = unsorted_ns - saved_ns + cost_ns - cost;
    let share = |stage: &'a FrameStage| {
        let (ns, all) = if is_trace(stage) { (trace, traces) } else { (cost, others) };
        (stage, ns / unsorted_ns * stage.median_ns / all.max(f64::MIN_POSITIVE))
    };
    Some(stages.iter().map(share).collect())
}
