//! How capsule area and trace time go together, over scenes, bounces, kinds and methods.

use formats::manifest::Stage;
use formats::metrics::correlation::Correlation;
use formats::ray::Kind;
use serde::Serialize;

use super::summary::distinct;
use super::timing::Time;
use super::{Metric, OrderAnalysis, QueueAnalysis, RecordingAnalysis};

/// Why there is no coefficient.
const TOO_FEW: &str = "it takes three orders or more with different capsule areas and trace times";

/// How capsule area and trace time go together in some recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CorrelationLine {
    /// The recordings: a label, or a configuration for all recordings of it.
    pub of: String,
    /// Kind of the rays; `null` for both together.
    pub kind: Option<Kind>,
    /// Of mean capsule area with trace time per ray.
    pub correlation: Metric<Correlation>,
}

/// One order as a point: how large its capsules are, how long its trace takes.
#[derive(Clone, Copy, Debug)]
pub struct AreaAndTime<'a> {
    /// Label of the recording.
    pub recording: &'a str,
    /// The queue.
    pub queue: &'a QueueAnalysis,
    /// The order.
    pub order: &'a OrderAnalysis,
    /// Mean capsule area in unit space.
    pub mean_capsule_area: f64,
    /// How long the trace took.
    pub trace: &'a Time,
}

impl<'a> AreaAndTime<'a> {
    fn of(
        recording: &'a RecordingAnalysis,
        queue: &'a QueueAnalysis,
        order: &'a OrderAnalysis,
    ) -> Option<Self> {
        let mean_capsule_area = order.coherence.known()?.mean_capsule_area;
        let trace = &order.stage(Stage::Trace)?.time;
        Some(Self { recording: &recording.label, queue, order, mean_capsule_area, trace })
    }

    /// Median trace time of a ray.
    pub fn ns_per_ray(&self) -> f64 {
        self.trace.median_ns / self.queue.rays as f64
    }
}

/// Every order of a recording whose capsules and trace time are known, `unsorted` included.
pub fn points(recording: &RecordingAnalysis) -> Vec<AreaAndTime<'_>> {
    let mut points = Vec::new();
    for queue in recording.measured() {
        points.extend(queue.orders.iter().filter_map(|order| AreaAndTime::of(recording, queue, order)));
    }
    points
}

/// The correlation of some orders, those of one kind or all.
pub fn correlation(points: &[AreaAndTime<'_>], kind: Option<Kind>) -> Metric<Correlation> {
    let pairs: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| kind.is_none_or(|kind| point.queue.kind == kind))
        .map(|point| (point.mean_capsule_area, point.ns_per_ray()))
        .collect();
    Correlation::of(&pairs).ok_or(TOO_FEW).into()
}

/// Of each recording, and of all recordings of each configuration that has several.
pub fn correlations(recordings: &[RecordingAnalysis]) -> Vec<CorrelationLine> {
    let mut lines = Vec::new();
    let mut add = |of: &str, points: &[AreaAndTime<'_>]| {
        for kind in [Some(Kind::Closest), Some(Kind::Shadow), None] {
            lines.push(CorrelationLine { of: of.to_owned(), kind, correlation: correlation(points, kind) });
        }
    };
    for recording in recordings {
        add(&recording.label, &points(recording));
    }
    for configuration in distinct(recordings.iter().map(|recording| recording.configuration.as_str())) {
        let same: Vec<_> =
            recordings.iter().filter(|recording| recording.configuration == configuration).collect();
        if same.len() > 1 {
            add(configuration, &same.into_iter().flat_map(points).collect::<Vec<_>>());
        }
    }
    lines
}
