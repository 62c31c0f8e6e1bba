//! Trace and net speedup per scene and method.

use super::building::{by_method, figure, mean_speedup, queues, reason, recordings, settings};
use super::{Findings, Made};
use crate::analysis::summary::{RayClass, distinct};
use crate::analysis::timing::SpeedupLine;
use crate::analysis::{Metric, OrderAnalysis, RecordingAnalysis};
use crate::figures::model::{Axis, Content, Panel, Point};

type Speedup = fn(&OrderAnalysis) -> &Metric<SpeedupLine>;

/// Unsorted trace over sorted trace.
pub fn trace(findings: &Findings<'_>) -> Made {
    let words = Words {
        title: "Trace speedup",
        axis: "trace speedup (×)",
        reference: "unsorted",
        what: "Trace time of unsorted rays over that of sorted rays, without the cost of sorting",
    };
    speedups(findings, |order| &order.trace_speedup, &words)
}

/// Unsorted trace over everything that sorting takes.
pub fn net(findings: &Findings<'_>) -> Made {
    let words = Words {
        title: "Net speedup",
        axis: "net speedup (×)",
        reference: "break-even",
        what: "Trace time of unsorted rays over all that tracing in another order takes: keys, sort, gather and trace or trace through indices, and accumulate",
    };
    speedups(findings, |order| &order.net_speedup, &words)
}

struct Words {
    title: &'static str,
    axis: &'static str,
    reference: &'static str,
    what: &'static str,
}

fn speedups(findings: &Findings<'_>, speedup: Speedup, words: &Words) -> Made {
    let recordings = recordings(findings);
    let configurations = distinct(recordings.iter().map(|recording| recording.configuration.as_str()));
    let mut panels = Vec::new();
    for configuration in &configurations {
        let same = recordings.iter().filter(|recording| recording.configuration == *configuration);
        let same: Vec<&RecordingAnalysis> = same.copied().collect();
        for rays in RayClass::ALL {
            let mut title = format!("{} rays", rays.name());
            if configurations.len() > 1 {
                title = format!("{title}, {configuration}");
            }
            panels.push(panel(findings, &same, rays, speedup, words, title));
        }
    }
    let caption = format!(
        "{}. Geometric means over bounces; whiskers reach from the lowest to the highest bounce. Secondary rays are closest rays of bounces ≥ 1. None is given for two-point-real, which must trace the rays before it can sort them.",
        words.what
    );
    let title = format!("{} per scene and method", words.title);
    let reason = reason(findings, speedup, "no method was measured on secondary or shadow rays");
    figure(title, caption, settings(findings), panels, reason)
}

fn panel(
    findings: &Findings<'_>,
    recordings: &[&RecordingAnalysis],
    rays: RayClass,
    speedup: Speedup,
    words: &Words,
    title: String,
) -> Panel {
    // Each recording, then all of them.
    let mut shown: Vec<(&str, &[&RecordingAnalysis])> = recordings
        .iter()
        .map(|recording| (recording.label.as_str(), std::slice::from_ref(recording)))
        .collect();
    shown.extend((recordings.len() > 1).then_some(("all", recordings)));
    let point = |place: usize, method: &str| -> Option<Point> {
        let (label, recordings) = shown[place];
        let queues = recordings.iter().flat_map(|recording| queues(recording, rays));
        let lines = queues.filter_map(|queue| speedup(queue.order(method)?).known());
        mean_speedup(place as f64, lines, format!("{label}, {}, {method}", rays.name()))
    };
    let points = |method: &str| (0..shown.len()).filter_map(|place| point(place, method)).collect();
    Panel::new(
        title,
        Axis::categories("scene", shown.iter().map(|(label, _)| *label)),
        Axis::from_zero(words.axis),
        Content::Bars(by_method(findings, points)),
    )
    .with_reference(words.reference, 1.0)
}
