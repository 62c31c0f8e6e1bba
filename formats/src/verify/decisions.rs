//! What `auto` chose: what its calibration and the queue's rays say.

use super::{Check, Subject};
use crate::auto::{Calibrated, method_record, sample, sampled_area};
use crate::key::method::AUTO;
use crate::manifest::{DecisionRecord, Manifest, QueueArray, QueueId};
use crate::ray::Ray;
use crate::reader::DumpState;

pub(super) fn check(subject: &Subject<'_>) -> Check {
    let manifest = subject.dump.manifest();
    let mut check = Check::new("decisions");
    for calibration in &manifest.calibration {
        for candidate in &calibration.candidates {
            check.find(method_record(&candidate.choice, &manifest.header).err(), || {
                format!("the calibration of bounce {}, {} rays", calibration.bounce, calibration.kind)
            });
        }
    }
    for decision in &manifest.decisions {
        check.find(subject.decision_problem(decision), || format!("the order of {}", decision.queue));
        let QueueId { bounce, kind, .. } = decision.queue;
        let rays = subject.queue_array::<Ray>(decision.queue, QueueArray::Rays);
        // A recording that was ended early may lack the record.
        let recorded = subject.record_of(decision.queue).map(|record| record.rays);
        let count = recorded.or(rays.as_ref().map(|rays| rays.len() as u64));
        let needs_none = |count| !calibrated(manifest).is_worth_a_look(bounce, kind, count);
        // Recorders of before took a sample in any case.
        if decision.area == 0.0 && count.is_some_and(needs_none) {
            continue;
        }
        let Some(rays) = rays else {
            let absence = subject.queue_absence(decision.queue, QueueArray::Rays);
            check.not_checked.push(format!("the order of {}: rays were {absence}", decision.queue));
            continue;
        };
        let sampled: Vec<Ray> = sample(rays.len()).flat_map(|range| &rays[range]).copied().collect();
        let area = sampled_area(&subject.unit, &sampled);
        check.require(area == decision.area, || {
            format!("the order of {}: its sample has area {}, expected {area}", decision.queue, decision.area)
        });
    }
    if subject.dump.state() == DumpState::Complete {
        let decided = |queue| manifest.decisions.iter().any(|decision| decision.queue == queue);
        for queue in manifest.queues.iter().filter(|queue| queue.methods.iter().any(|name| name == AUTO)) {
            check.require(decided(queue.id), || {
                format!("there is no record of what {AUTO} chose for {}", queue.id)
            });
        }
    }
    check
}

fn calibrated(manifest: &Manifest) -> Calibrated<'_> {
    Calibrated { queues: &manifest.calibration, version: manifest.version }
}

impl Subject<'_> {
    fn decision_problem(&self, decision: &DecisionRecord) -> Option<String> {
        let DecisionRecord { queue, area, choice } = decision;
        // A recording that was ended early may lack the record of the queue.
        let Some(record) = self.record_of(*queue) else { return self.unknown_queue(*queue) };
        let calibrated = calibrated(self.dump.manifest());
        let expected = calibrated.decide(queue.bounce, queue.kind, record.rays, *area);
        let expected = expected.map(|candidate| &candidate.choice);
        (choice.as_ref() != expected)
            .then(|| format!("{choice:?} was chosen, by the calibration it is {expected:?}"))
    }
}
