//! What orders are worth on this machine, measured before a recording: what `auto` chooses by.

use anyhow::Result;
use formats::manifest::{CalibrationRecord, Candidate, Choice, QueueId, Stage, Way};
use formats::metrics::speedup::Speedup;
use formats::ray::Kind;

use crate::auto::{Auto, room};
use crate::backends::{Backend, Queue};
use crate::measure::{Measured, Measurement, QueueMeasurement, Queued, Subject};
use crate::progress::Progress;
use crate::stages::setup::Setup;
use crate::wavefront::Observer;

/// Fewest rays that candidates are tried on. No shorter queue gained what keys and a sort of it cost in two
/// recordings, and of many orders that are measured on so few rays one looks good by chance.
const FEWEST_RAYS: usize = 1 << 13;
/// Candidates that are measured in all rounds, after one round that all take part in.
const FINALISTS: usize = 3;
/// Rounds of a pass that a candidate's worth is taken from: enough to tell a few percent from nothing.
const ROUNDS: u32 = 9;
/// Passes that are measured, whose rounds count together. On a graphics card a trace ends with its slowest ray, and
/// whether an order has that one earlier than canonical order is chance: two passes that say different things give an
/// interval that holds both.
pub const PASSES: u32 = 2;
/// How often a closest ray of each pass is traced, by each order in two ways; a shadow ray has fewer candidates. First
/// pass: all candidates in the warm-up and in the round that finds the best, then these in a trial round and those
/// that count. Second pass: the best in a warm-up, in a trial round and those that count.
pub fn traces(setup: &Setup) -> [u64; PASSES as usize] {
    let (all, best, rounds) =
        (tried_on(setup, Kind::Closest).count() as u64, FINALISTS as u64, 1 + ROUNDS as u64);
    [2 * (2 * all + rounds * best), 2 * (best + rounds * best)]
}

/// The candidates for rays of a kind.
fn tried_on(setup: &Setup, kind: Kind) -> impl Iterator<Item = Subject> {
    let candidates = setup.named().len()..setup.methods.len();
    candidates.filter(move |&number| setup.methods[number].applies_to(kind)).map(Subject::Method)
}

/// Measures the candidates on every queue.
pub struct Calibrator<'a> {
    setup: &'a Setup,
    /// What takes samples.
    auto: &'a Auto,
    progress: &'a Progress,
    found: Vec<Found>,
}

/// What was found of a queue of each pass.
struct Found {
    /// Without candidates until all passes were seen.
    queue: CalibrationRecord,
    /// Canonical order and the finalists; nothing of a short queue.
    entries: QueueMeasurement,
}

impl<B: Backend> Observer<B> for Calibrator<'_> {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let (QueueId { bounce, kind, .. }, count) = (rays.id(), rays.len());
        self.progress.traced(rays.id(), count);
        let queue = Queued { rays, hits, methods: &self.setup.methods, foreign: &[], auto: None };
        let is_long = count >= FEWEST_RAYS;
        match self.found.iter().position(|found| (found.queue.bounce, found.queue.kind) == (bounce, kind)) {
            None => {
                let entries = if is_long { self.finalists(backend, &queue)? } else { Vec::new() };
                let area = self.auto.area(backend, rays, &mut room(count))?;
                let queue =
                    CalibrationRecord { bounce, kind, rays: count as u64, area, candidates: Vec::new() };
                self.found.push(Found { queue, entries });
            }
            Some(at) if is_long => self.measure_again(backend, &queue, at)?,
            Some(_) => {}
        }
        self.progress.measured(rays.id(), count);
        Ok(())
    }
}

/// What `auto` chooses by, measured on the queues that `run` shows a calibrator, of one pass or of [`PASSES`]; the
/// picture begins anew.
///
/// # Errors
/// Any of the backend or of `run`.
pub fn calibrate<B: Backend>(
    backend: &mut B,
    setup: &Setup,
    progress: &Progress,
    run: impl FnOnce(&mut B, &mut Calibrator<'_>) -> Result<()>,
) -> Result<Auto> {
    let auto = Auto::new(setup, Vec::new())?;
    let mut calibrator = Calibrator { setup, auto: &auto, progress, found: Vec::new() };
    run(backend, &mut calibrator)?;
    let calibration = calibrator.records();
    backend.restart()?;
    Auto::new(setup, calibration)
}

impl Calibrator<'_> {
    /// The best candidates on a queue, and canonical order.
    fn finalists<B: Backend>(&self, backend: &mut B, queue: &Queued<'_, B>) -> Result<QueueMeasurement> {
        let tried = tried_on(self.setup, queue.rays.id().kind);
        let orders = [Subject::Unsorted].into_iter().chain(tried).collect();
        let mut measured = Measured { orders, repeats: 0, seed: self.setup.seed };
        let mut orders = queue.warm_up(backend, &measured, |_, _, _, _| Ok(()))?;
        let mut all = queue.measure(backend, &measured, &orders)?;
        all.retain(|entry| entry.subject != Subject::Unsorted);
        all.sort_by_key(|entry| entry.trial_ns.into_iter().min());
        all.truncate(FINALISTS);
        orders.retain(|subject| {
            subject == Subject::Unsorted || all.iter().any(|entry| entry.subject == subject)
        });
        measured.repeats = ROUNDS;
        queue.measure(backend, &measured, &orders)
    }

    /// Adds rounds of the same orders on the queue of another pass.
    fn measure_again<B: Backend>(&mut self, backend: &mut B, queue: &Queued<'_, B>, at: usize) -> Result<()> {
        let entries = &mut self.found[at].entries;
        let orders = entries.iter().map(|entry| entry.subject).collect();
        let measured = Measured { orders, repeats: ROUNDS, seed: self.setup.seed };
        let orders = queue.warm_up(backend, &measured, |_, _, _, _| Ok(()))?;
        for (entry, again) in entries.iter_mut().zip(queue.measure(backend, &measured, &orders)?) {
            for (stage, samples) in again.stages.iter() {
                entry.stages.of_mut(stage).extend(samples);
            }
        }
        Ok(())
    }

    /// What is kept of all queues.
    fn records(&self) -> Vec<CalibrationRecord> {
        let record = |Found { queue, entries }: &Found| CalibrationRecord {
            candidates: self.worths(entries),
            ..queue.clone()
        };
        self.found.iter().map(record).collect()
    }

    /// What orders were worth by each way.
    fn worths(&self, found: &[Measurement]) -> Vec<Candidate> {
        let unsorted = found.iter().find(|entry| entry.subject == Subject::Unsorted);
        let unsorted = unsorted.map_or(&[][..], |entry| entry.stages.of(Stage::Trace));
        let worth = |entry: &Measurement, way: Way| {
            let Subject::Method(number) = entry.subject else { return None };
            let plan = &self.setup.methods[number];
            let Speedup { ratio: net, interval } = Speedup::of(unsorted, &entry.stages.totals(way))?;
            let (net_low, _) = interval?;
            let choice = Choice { method: plan.name.clone(), key_bits: plan.key_bits, way };
            Some(Candidate { choice, net, net_low })
        };
        found.iter().flat_map(|entry| Way::ALL.into_iter().filter_map(move |way| worth(entry, way))).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use formats::manifest;
    use formats::ray::Ray;

    use super::*;
    use crate::auto;
    use crate::backends::cpu::CpuBackend;
    use crate::stages::trace::Order;

    #[test]
    fn two_passes_that_disagree_give_an_interval_that_holds_both() {
        let setup = Setup { width: 128, height: 128, ..Setup::made_up(false, 32) };
        let tried = |backend| auto::candidates(backend, &[], setup.extent(), 0.25).unwrap();
        let of_kinds = |backend| {
            let is_for = |kind| tried(backend).iter().filter(|plan| plan.applies_to(kind)).count();
            (tried(backend).len(), Kind::ALL.map(is_for))
        };
        assert_eq!(of_kinds(manifest::Backend::Cpu), (7, [6, 4]));
        assert_eq!(of_kinds(manifest::Backend::Gpu), (8, [5, 4]));
        let candidates = tried(manifest::Backend::Cpu);
        let setup = Arc::new(setup.with_candidates(candidates));
        let mut backend = CpuBackend::in_cornell(setup.clone());
        let auto = Auto::new(&setup, Vec::new()).unwrap();
        let progress = Progress::new(2, traces(&setup).to_vec());
        let mut calibrator =
            Calibrator { setup: &setup, auto: &auto, progress: &progress, found: Vec::new() };
        assert_eq!(Kind::ALL.map(|kind| tried_on(&setup, kind).count()), [6, 4]);
        let ray = |at: usize| Ray {
            origin: [at as f32 * 1e-5, 0.0, 0.0],
            t_min: 0.0,
            direction: [0.0, 0.0, 1.0],
            t_max: 1.0,
        };
        let rays: Vec<Ray> = (0..FEWEST_RAYS).map(ray).collect();
        let mut show = |calibrator: &mut Calibrator<'_>, pass| {
            let queue = backend.shadow_queue(pass, &rays);
            let hits = backend.trace(&queue, Order::Stored).unwrap();
            calibrator.measure(&mut backend, &queue, &hits).unwrap();
        };
        show(&mut calibrator, 0);
        // As if canonical order had been slow in the first pass.
        let unsorted = &mut calibrator.found[0].entries[0];
        assert_eq!(unsorted.subject, Subject::Unsorted);
        unsorted.stages.of_mut(Stage::Trace).iter_mut().for_each(|ns| *ns *= 1000);
        let first = calibrator.records();
        show(&mut calibrator, 1);
        let both = calibrator.records();
        let [first, both] = [&first, &both].map(|records| match &records[..] {
            [CalibrationRecord { candidates, .. }] => candidates,
            _ => panic!("one record for both passes: {records:?}"),
        });
        assert_eq!(first.len(), 2 * FINALISTS, "each by both ways");
        for (first, both) in first.iter().zip(both) {
            assert_eq!(first.choice, both.choice);
            assert!(both.net_low < first.net_low / 50.0, "{first:?}, {both:?}");
        }
    }
}
