//! What orders are worth on this machine, measured before a recording: what `auto` chooses by.

use anyhow::Result;
use formats::manifest::{CalibrationRecord, Candidate, Choice, Stage, Way};
use formats::metrics::speedup::Speedup;

use crate::auto::{Auto, CANDIDATES, room};
use crate::backends::{Backend, Queue};
use crate::measure::{Measured, Measurement, Queued, Subject};
use crate::progress::Progress;
use crate::stages::setup::Setup;
use crate::wavefront::Observer;

/// Fewest rays that candidates are tried on. No shorter queue gained what keys and a sort of it cost in two
/// recordings, and of many orders that are measured on so few rays one looks good by chance.
const FEWEST_RAYS: usize = 1 << 13;
/// Candidates that are measured in all rounds, after one round that all take part in.
const FINALISTS: usize = 3;
/// Rounds that a candidate's worth is taken from: enough to tell a few percent from nothing.
const ROUNDS: u32 = 11;
/// How often a ray is traced: once in the warm-up and once more by all, then in each round, twice by each.
pub const TRACES: u64 = 2 * (2 * CANDIDATES.len() as u64 + (1 + ROUNDS as u64) * FINALISTS as u64);

/// Measures the candidates on every queue.
pub struct Calibrator<'a> {
    setup: &'a Setup,
    /// What takes samples.
    auto: &'a Auto,
    progress: &'a Progress,
    found: Vec<CalibrationRecord>,
}

impl<B: Backend> Observer<B> for Calibrator<'_> {
    fn measure(&mut self, backend: &mut B, rays: &B::Rays, hits: &B::Hits) -> Result<()> {
        let (id, count) = (rays.id(), rays.len());
        self.progress.traced(id, count);
        let candidates = if count < FEWEST_RAYS { Vec::new() } else { self.candidates(backend, rays, hits)? };
        let area = self.auto.area(backend, rays, &mut room(count))?;
        self.found.push(CalibrationRecord {
            bounce: id.bounce,
            kind: id.kind,
            rays: count as u64,
            area,
            candidates,
        });
        self.progress.measured(id, count);
        Ok(())
    }
}

/// What `auto` chooses by, measured on the queues that `run` shows a calibrator; the picture begins anew.
///
/// # Errors
/// Any of the backend or of `run`.
pub fn calibrate<B: Backend>(
    backend: &mut B,
    setup: &Setup,
    progress: &Progress,
    run: impl FnOnce(&mut B, &mut Calibrator<'_>) -> Result<()>,
) -> Result<Auto> {
    let mut auto = Auto::new(setup, Vec::new());
    let mut calibrator = Calibrator { setup, auto: &auto, progress, found: Vec::new() };
    run(backend, &mut calibrator)?;
    auto.calibration = calibrator.found;
    backend.restart()?;
    Ok(auto)
}

impl Calibrator<'_> {
    /// What the best candidates were worth on a queue.
    fn candidates<B: Backend>(
        &self,
        backend: &mut B,
        rays: &B::Rays,
        hits: &B::Hits,
    ) -> Result<Vec<Candidate>> {
        let first = self.setup.named().len();
        let candidates = (first..self.setup.methods.len()).map(Subject::Method);
        let orders = [Subject::Unsorted].into_iter().chain(candidates).collect();
        let queue = Queued { rays, hits, methods: &self.setup.methods, foreign: &[], auto: None };
        let mut measured = Measured { orders, repeats: 0, seed: self.setup.seed };
        let mut orders = queue.warm_up(backend, &measured, |_, _, _, _| Ok(()))?;
        let mut all = queue.measure(backend, &measured, &orders)?;
        all.retain(|entry| entry.subject != Subject::Unsorted);
        all.sort_by_key(|entry| entry.deciding_ns.into_iter().min());
        all.truncate(FINALISTS);
        orders.retain(|subject| {
            subject == Subject::Unsorted || all.iter().any(|entry| entry.subject == subject)
        });
        measured.repeats = ROUNDS;
        let found = queue.measure(backend, &measured, &orders)?;
        let unsorted: Vec<u64> = found
            .iter()
            .filter(|entry| entry.subject == Subject::Unsorted)
            .flat_map(|entry| entry.stages.of(Stage::Trace).to_vec())
            .collect();
        Ok(found.iter().filter_map(|entry| self.candidate(entry, &unsorted)).collect())
    }

    /// What an order was worth, by its better way.
    fn candidate(&self, entry: &Measurement, unsorted: &[u64]) -> Option<Candidate> {
        let Subject::Method(number) = entry.subject else { return None };
        let plan = &self.setup.methods[number];
        let worth = |way: Way| Some((way, Speedup::of(unsorted, &entry.stages.totals(way))?));
        let worths = [Way::Gathered, Way::Indices].into_iter().filter_map(worth);
        let (way, Speedup { ratio: net, interval }) =
            worths.max_by(|a, b| a.1.ratio.total_cmp(&b.1.ratio))?;
        let (net_low, _) = interval?;
        let choice = Choice { method: plan.name.clone(), key_bits: plan.key_bits, way };
        Some(Candidate { choice, net, net_low })
    }
}
