//! How capsule area and trace time go together, over scenes, bounces, kinds and methods.

use formats::manifest::Stage;
use formats::metrics::correlation::Correlation;
use formats::ray::Kind;
use serde::Serialize;

use super::summary::distinct;
use super::{Metric, RecordingAnalysis};

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
#[derive(Clone, Debug, PartialEq)]
pub struct AreaAndTime<'a> {
    /// Label of the recording.
    pub recording: &'a str,
    /// Bounce of the queue.
    pub bounce: u32,
    /// Kind of its rays.
    pub kind: Kind,
    /// The order.
    pub method: &'a str,
    /// The method that it is a variant of; itself if it is none.
    pub base: &'a str,
    /// Mean capsule area in unit space.
    pub mean_capsule_area: f64,
    /// Trace time of a ray: median and quartiles.
    pub ns_per_ray: f64,
    /// First and third quartile of it.
    pub quartiles_ns_per_ray: (f64, f64),
    /// Samples behind it.
    pub n: usize,
}

/// Every order of a recording whose capsules and trace time are known, `unsorted` included.
pub fn points(recording: &RecordingAnalysis) -> Vec<AreaAndTime<'_>> {
    let orders = recording.measured().flat_map(|queue| queue.orders.iter().map(move |order| (queue, order)));
    let point = |(queue, order): (&super::QueueAnalysis, &'_ super::OrderAnalysis)| {
        let trace = &order.stages.iter().find(|stage| stage.stage == Stage::Trace)?.time;
        let rays = queue.rays as f64;
        let area = order.coherence.known()?.mean_capsule_area;
        let (low, high) = trace.quartiles_ns;
        Some((area, trace.median_ns / rays, (low / rays, high / rays), trace.samples_ns.len()))
    };
    orders
        .filter_map(|(queue, order)| {
            let (mean_capsule_area, ns_per_ray, quartiles_ns_per_ray, n) = point((queue, order))?;
            let (recording, method) = (recording.label.as_str(), order.method.as_str());
            let (bounce, kind) = (queue.bounce, queue.kind);
            Some(AreaAndTime {
                recording,
                bounce,
                kind,
                method,
                base: &order.base,
                mean_capsule_area,
                ns_per_ray,
                quartiles_ns_per_ray,
                n,
            })
        })
        .collect()
}

/// The correlation of some orders, those of one kind or all.
pub fn correlation(points: &[AreaAndTime<'_>], kind: Option<Kind>) -> Metric<Correlation> {
    let pairs: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| kind.is_none_or(|kind| point.kind == kind))
        .map(|point| (point.mean_capsule_area, point.ns_per_ray))
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
