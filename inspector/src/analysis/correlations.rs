//! How capsule area and trace time go together, over scenes, bounces, kinds and methods: both over those of the same
//! queue unsorted, since queues differ in both for reasons of their own.

use formats::key::method::{CONTROL, UNSORTED};
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
    /// Of mean capsule area with trace time, both over those of the queue unsorted.
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
    /// Mean capsule area over that of the queue unsorted.
    pub area: f64,
    /// Median trace time over that of the queue unsorted.
    pub time: f64,
    /// How long the trace took.
    pub trace: &'a Time,
}

impl<'a> AreaAndTime<'a> {
    fn of(
        recording: &'a RecordingAnalysis,
        queue: &'a QueueAnalysis,
        order: &'a OrderAnalysis,
    ) -> Option<Self> {
        let of = |order: &'a OrderAnalysis| {
            Some((order.coherence.known()?.mean_capsule_area, &order.stage(Stage::Trace)?.time))
        };
        let ((unsorted_area, unsorted), (area, trace)) = (of(queue.order(UNSORTED)?)?, of(order)?);
        let (area, time) = (area / unsorted_area, trace.median_ns / unsorted.median_ns);
        Some(Self { recording: &recording.label, queue, order, area, time, trace })
    }
}

/// Every order of a recording whose capsules and trace time are known, variants of methods not. Nor is canonical order,
/// as `unsorted`, `control` or what `auto` left alone: one more point at (1, 1) for each queue says nothing.
pub fn points(recording: &RecordingAnalysis) -> Vec<AreaAndTime<'_>> {
    let is_order = |order: &&OrderAnalysis| {
        let is_canonical = [UNSORTED, CONTROL].contains(&order.method.as_str()) || order.is_left_alone();
        order.base == order.method && !is_canonical
    };
    let mut points = Vec::new();
    for queue in recording.measured() {
        let orders = queue.orders.iter().filter(is_order);
        points.extend(orders.filter_map(|order| AreaAndTime::of(recording, queue, order)));
    }
    points
}

/// The correlation of some orders.
pub fn correlation<'a>(points: impl Iterator<Item = &'a AreaAndTime<'a>>) -> Metric<Correlation> {
    let pairs: Vec<(f64, f64)> = points.map(|point| (point.area, point.time)).collect();
    Correlation::of(&pairs).ok_or(TOO_FEW).into()
}

/// Of each recording, and of all recordings of each configuration that has several.
pub fn correlations(recordings: &[RecordingAnalysis]) -> Vec<CorrelationLine> {
    let mut lines = Vec::new();
    let mut add = |of: &str, points: &[AreaAndTime<'_>]| {
        for kind in [Some(Kind::Closest), Some(Kind::Shadow), None] {
            let own = points.iter().filter(|point| kind.is_none_or(|kind| point.queue.kind == kind));
            lines.push(CorrelationLine { of: of.to_owned(), kind, correlation: correlation(own) });
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
