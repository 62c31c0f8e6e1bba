//! Trace and net speedup per scene and method, trace speedup per kernel and method.

use super::building::{by_method, figure, mean_speedup, queues, reason, recordings, settings};
use super::{Findings, Made};
use crate::analysis::labels::scene_name;
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

/// Trace speedup by kernel: a panel per scene and kind of rays, of scenes that several kernels traced.
pub fn kernels(findings: &Findings<'_>) -> Made {
    let recordings = recordings(findings);
    let mut panels = Vec::new();
    let scenes = distinct(recordings.iter().map(|recording| recording.scene.as_str()));
    for scene in &scenes {
        let same = recordings.iter().filter(|recording| recording.scene == *scene);
        let same: Vec<&RecordingAnalysis> = same.copied().collect();
        if distinct(same.iter().map(kernel)).len() < 2 {
            continue;
        }
        for rays in RayClass::ALL {
            let mut title = format!("{} rays", rays.name());
            if scenes.len() > 1 {
                title = format!("{}: {title}", scene_name(scene));
            }
            panels.push(kernel_panel(findings, &same, rays, title));
        }
    }
    figure(
        "Trace speedup per kernel and method",
        "Trace time of unsorted rays over that of sorted rays, without the cost of sorting, by trace kernel. Geometric means over bounces; whiskers reach from the lowest to the highest bounce. The line is what Meister et al. 2020, \"On Ray Reordering Techniques for Faster GPU Ray Tracing\", give as the mean of their software kernel (CUDA, RTX 2080 Ti, scenes of their own).",
        settings(findings),
        panels,
        "it takes two or more trace kernels on one scene: replay a recording with another --trace",
    )
}

fn kernel<'a>(recording: &&'a RecordingAnalysis) -> &'a str {
    &recording.options.trace_kernel
}

fn kernel_panel(
    findings: &Findings<'_>,
    recordings: &[&RecordingAnalysis],
    rays: RayClass,
    title: String,
) -> Panel {
    let kernels = distinct(recordings.iter().map(kernel));
    let point = |place: usize, method: &str| -> Option<Point> {
        let own = recordings.iter().filter(|recording| kernel(recording) == kernels[place]);
        let queues = own.flat_map(|recording| queues(recording, rays));
        let lines = queues.filter_map(|queue| queue.order(method)?.trace_speedup.known());
        mean_speedup(place as f64, lines, format!("{}, {}, {method}", kernels[place], rays.name()))
    };
    let points = |method: &str| (0..kernels.len()).filter_map(|place| point(place, method)).collect();
    let (label, paper) = match rays {
        RayClass::Secondary => ("Meister et al. 2020, secondary rays: 1.41×", 1.41),
        RayClass::Shadow => ("Meister et al. 2020, shadow rays: 2.21×", 2.21),
    };
    Panel::new(
        title,
        Axis::categories("kernel", kernels.iter().copied()),
        Axis::from_zero("trace speedup (×)"),
        Content::Bars(by_method(findings, points)),
    )
    .with_reference(label, paper)
}
