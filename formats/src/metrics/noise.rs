//! What disturbed the times of a recording.

use serde::Serialize;

use super::samples::Samples;
use super::speedup::{interquartile_range, median};
use crate::manifest::{Manifest, Stage};

/// Interquartile range of a trace's rounds over their median, from which on it counts as wide.
const WIDE: f64 = 0.1;
/// More than one in so many are worth a word.
const NOTED_SHARE: usize = 4;

/// How many of a recording's times were disturbed. They count, since nothing says that the others were not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Noise {
    /// Samples of all stages that belong to a queue.
    pub samples: usize,
    /// Of these, taken while the machine did other work.
    pub disturbed: usize,
    /// Traces of gathered rays, by queue and method.
    pub traces: usize,
    /// Of these, such as spread by more than a tenth of their median.
    pub wide: usize,
}

impl Noise {
    /// Of a recording.
    pub fn of(manifest: &Manifest) -> Self {
        let samples = Samples::of(manifest);
        let of_queues = manifest.timings.iter().filter(|timing| timing.kind.is_some());
        let orders = samples.orders().filter_map(|(queue, method)| samples.get(queue, method));
        let spread = |trace: &[u64]| Some(interquartile_range(trace)? / median(trace)?.max(1.0));
        let spreads: Vec<f64> = orders.filter_map(|stages| spread(stages.of(Stage::Trace))).collect();
        Self {
            samples: of_queues.map(|timing| timing.samples_ns.len()).sum(),
            disturbed: manifest.disturbed.iter().map(|record| record.samples.len()).sum(),
            traces: spreads.len(),
            wide: spreads.iter().filter(|spread| **spread > WIDE).count(),
        }
    }

    /// Whether so many samples were taken while the machine did other work that it must be said.
    pub fn is_disturbed(&self) -> bool {
        self.disturbed * NOTED_SHARE > self.samples
    }

    /// What must be said, a sentence each.
    pub fn sentences(&self) -> impl Iterator<Item = String> {
        let Self { samples, disturbed, traces, wide } = *self;
        let busy = self.is_disturbed().then(|| {
            format!("{disturbed} of {samples} samples were taken while the machine did other work; they count, and are marked in the recording")
        });
        let is_wide = wide * NOTED_SHARE > traces;
        let wide = is_wide.then(|| {
            format!("{wide} of {traces} trace times spread by more than 10 % of their median: an idle machine, --pin and more --repeats help")
        });
        busy.into_iter().chain(wide)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn much_is_said_and_little_is_not() {
        let said = |disturbed, wide| {
            let noise = Noise { samples: 100, disturbed, traces: 8, wide };
            noise.sentences().collect::<Vec<_>>()
        };
        assert!(said(25, 2).is_empty());
        let [busy, wide] = &said(26, 3)[..] else { panic!("two sentences") };
        assert!(
            busy.starts_with("26 of 100 samples") && wide.starts_with("3 of 8 trace times"),
            "{busy} {wide}"
        );
    }
}
