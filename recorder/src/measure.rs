//! Measures every order of one queue: key → sort → gather → trace → scatter, in rounds.
//!
//! The stages are those that Meister et al. (2020) count: computing keys, sorting them, reordering rays or tracing them
//! through indices, and for adaptive ends adding lengths to the table. The speedup of the trace is what their tables have;
//! net counts the rest, too.
//!
//! A round has the baseline, the control and every method once by each way of tracing what was sorted, in an order
//! drawn for it, so that drift hits all alike and nothing always follows the same. Each way of a method has keys and
//! a sort of its own before it, and finds in the caches what those left there. What a section writes was there and
//! was touched before: the first round is not timed, and backends use their memory again. The second is on trial: by it
//! the way of tracing sorted rays that counts is chosen, so that no figure is taken from the samples that it was chosen
//! by. A turn of `auto` decides on an order, and goes on with a device that has forgotten how the queue was traced
//! before, where it could know a short one by heart.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use fastrand::Rng;
use formats::key::Termination;
use formats::key::method::{AUTO, CONTROL, SHUFFLED, UNSORTED};
use formats::manifest::{QueueId, Stage, Way};
use formats::metrics::speedup::StageSamples;
use formats::ray::Kind;

use crate::auto::Auto;
use crate::backends::{Backend, Queue, Table};
use crate::clock::Sample;
use crate::foreign::{self, ForeignOrder};
use crate::stages::setup::MethodPlan;
use crate::stages::trace::Order;

const NOTHING_CHOOSES: &str = "nothing chooses an order";

/// What is measured on every queue.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The orders, canonical order first.
    pub orders: Vec<Subject>,
    /// Timed rounds that figures are taken from.
    pub repeats: u32,
    /// Of the orders of rounds, and of the shuffled order.
    pub seed: u64,
}

/// An order that is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Canonical order: the baseline, traced and nothing else.
    Unsorted,
    /// Canonical order, gathered, traced and scattered like a method's.
    Control,
    /// A random order.
    Shuffled,
    /// The order that is chosen for the queue.
    Auto,
    /// The order of a method, by its number.
    Method(usize),
    /// An order that came with the queue from another tracer, by its number.
    Foreign(usize),
}

impl Subject {
    /// Name in recordings and tables.
    pub fn name(self, methods: &[MethodPlan]) -> &str {
        match self {
            Self::Unsorted => UNSORTED,
            Self::Control => CONTROL,
            Self::Shuffled => SHUFFLED,
            Self::Auto => AUTO,
            Self::Method(number) | Self::Foreign(number) => &methods[number].name,
        }
    }
}

/// What measuring one order of a queue gave.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The order.
    pub subject: Subject,
    /// Samples per stage, one per round.
    pub stages: StageSamples,
    /// Rounds in which a stage was disturbed.
    pub disturbed: BTreeMap<Stage, Vec<u32>>,
    /// Most results of any of its traces, those that are not timed among them, that differed from those of canonical
    /// order.
    pub mismatches: u64,
    /// Nanoseconds of the trial round, by which the way that counts is chosen, in all by each way; 0 for one not taken.
    pub trial_ns: [u64; 2],
}

/// What measuring one queue gave: an entry for each order that applies, canonical order first.
pub type QueueMeasurement = Vec<Measurement>;

/// A queue to measure.
pub struct Queued<'a, B: Backend> {
    /// Its rays.
    pub rays: &'a B::Rays,
    /// What they found, in canonical order.
    pub hits: &'a B::Hits,
    /// The methods of the run.
    pub methods: &'a [MethodPlan],
    /// Orders that came with the queues of the run.
    pub foreign: &'a [ForeignOrder],
    /// What chooses an order, where one is to be chosen.
    pub auto: Option<&'a Auto>,
}

/// The orders of a queue.
pub struct Orders<P>(Vec<Ordered<P>>);

/// An order, warmed up.
struct Ordered<P> {
    subject: Subject,
    /// Where there is none, it is chosen in each turn.
    source: Option<Source<P>>,
    /// Most results of its first traces that differed from those of canonical order.
    mismatches: u64,
}

/// Where the permutation of an order comes from.
enum Source<P> {
    /// There is none: rays are traced as they lie.
    AsTheyLie,
    /// It is given.
    Given(P),
    /// The keys of a method are sorted, by its number.
    Keys(usize),
}

impl<P> Source<P> {
    fn as_ref(&self) -> Source<&P> {
        match self {
            Self::AsTheyLie => Source::AsTheyLie,
            Self::Given(permutation) => Source::Given(permutation),
            Self::Keys(number) => Source::Keys(*number),
        }
    }
}

impl<P> Orders<P> {
    /// What takes its turn in a round: an order by its place here, and the way if that is not the order's own.
    fn turns(&self) -> Vec<(usize, Way)> {
        let ways = |subject| match subject {
            Subject::Method(_) | Subject::Shuffled | Subject::Foreign(_) => &Way::ALL[..],
            Subject::Unsorted | Subject::Control | Subject::Auto => &[Way::Gathered],
        };
        let orders = self.0.iter().enumerate();
        orders.flat_map(|(at, order)| ways(order.subject).iter().map(move |&way| (at, way))).collect()
    }

    /// Leaves out those that do not count any more.
    pub fn retain(&mut self, mut counts: impl FnMut(Subject) -> bool) {
        self.0.retain(|order| counts(order.subject));
    }
}

impl<B: Backend> Queued<'_, B> {
    /// Runs everything once, so that no timed section is the first to compile or to touch memory; hands each
    /// order's keys, where it has any, and its permutation to `ordered`.
    ///
    /// # Errors
    /// Any of the backend or of `ordered`.
    pub fn warm_up(
        &self,
        backend: &mut B,
        measured: &Measured,
        mut ordered: impl FnMut(&mut B, Subject, Option<&B::Keys>, &B::Permutation) -> Result<()>,
    ) -> Result<Orders<B::Permutation>> {
        let (id, count) = (self.rays.id(), self.rays.len() as u32);
        let mut orders = Orders(Vec::new());
        for &subject in &measured.orders {
            let source = match subject {
                Subject::Unsorted => Some(Source::AsTheyLie),
                Subject::Control | Subject::Shuffled => {
                    let mut indices: Vec<u32> = (0..count).collect();
                    if subject == Subject::Shuffled {
                        Rng::with_seed(seed_of(measured.seed, id)).shuffle(&mut indices);
                    }
                    let permutation = backend.upload_permutation(&indices)?;
                    ordered(backend, subject, None, &permutation)?;
                    Some(Source::Given(permutation))
                }
                Subject::Foreign(number) => {
                    let order = foreign::of(self.foreign, id, &self.methods[number].name);
                    let Some(order) = order else { continue };
                    ensure!(order.permutation.len() == count as usize, "an order of another queue");
                    let permutation = backend.upload_permutation(&order.permutation)?;
                    ordered(backend, subject, None, &permutation)?;
                    Some(Source::Given(permutation))
                }
                Subject::Auto => {
                    let auto = self.auto.context(NOTHING_CHOOSES)?;
                    let permutation = match auto.decide(backend, self.rays)?.0.order {
                        None => backend.upload_permutation(&(0..count).collect::<Vec<_>>())?,
                        Some((number, _)) => {
                            let keys = backend.key(self.rays, Some(self.hits), number)?;
                            backend.sort(&keys)?
                        }
                    };
                    ordered(backend, subject, None, &permutation)?;
                    None
                }
                Subject::Method(number) if !self.methods[number].applies_to(id.kind) => continue,
                Subject::Method(number) => {
                    let keys = backend.key(self.rays, Some(self.hits), number)?;
                    let permutation = backend.sort(&keys)?;
                    ordered(backend, subject, Some(&keys), &permutation)?;
                    Some(Source::Keys(number))
                }
            };
            orders.0.push(Ordered { subject, source, mismatches: 0 });
        }
        let mut nowhere = empty(&orders);
        for (at, way) in orders.turns() {
            self.turn(backend, &orders.0[at], way, &mut nowhere[at], 0)?;
            orders.0[at].mismatches = nowhere[at].mismatches;
        }
        backend.accumulate(self.rays, self.hits, Table::Scratch)?;
        Ok(orders)
    }

    /// Measures all orders.
    ///
    /// # Errors
    /// Any of the backend.
    pub fn measure(
        &self,
        backend: &mut B,
        measured: &Measured,
        orders: &Orders<B::Permutation>,
    ) -> Result<QueueMeasurement> {
        let (mut trial, mut entries) = (empty(orders), empty(orders));
        let seed = seed_of(!measured.seed, self.rays.id());
        let turns = orders.turns();
        in_rounds(turns.len(), measured.repeats, seed, |turn, round| {
            let (at, way) = turns[turn];
            let entries = if round.is_some() { &mut entries } else { &mut trial };
            self.turn(backend, &orders.0[at], way, &mut entries[at], round.unwrap_or(0))
        })?;
        for (entry, trial) in entries.iter_mut().zip(trial) {
            let is_taken = |way: Way| way.stages().iter().any(|&stage| !trial.stages.of(stage).is_empty());
            let sum = |way: Way| if is_taken(way) { trial.stages.totals(way).iter().sum() } else { 0 };
            entry.trial_ns = Way::ALL.map(sum);
            entry.mismatches = entry.mismatches.max(trial.mismatches);
        }
        Ok(entries)
    }

    /// One turn: a sample of each stage of an order by a way, or by that which `auto` decides on with its order.
    fn turn(
        &self,
        backend: &mut B,
        Ordered { subject, source, .. }: &Ordered<B::Permutation>,
        asked: Way,
        entry: &mut Measurement,
        round: u32,
    ) -> Result<()> {
        let Self { rays, hits, methods, .. } = *self;
        // What both ways of an order need is sampled once; `auto` is asked once.
        let counts_both = asked == Way::Gathered;
        // Chosen before the device forgets: the clock of a decision reads the system's counters, which leaves traces
        // in the caches that a short queue feels.
        let (source, way) = match source {
            Some(source) => (source.as_ref(), asked),
            None => {
                let (decision, taken) = self.auto.context(NOTHING_CHOOSES)?.decide(backend, rays)?;
                entry.add(taken, Stage::Decide, round);
                decision.order.map_or((Source::AsTheyLie, asked), |(number, way)| (Source::Keys(number), way))
            }
        };
        backend.forget(rays)?;
        let sorted;
        let permutation = match source {
            Source::AsTheyLie => {
                backend.trace(rays, Order::Stored)?;
                entry.keep(backend, Stage::Trace, round);
                return Ok(());
            }
            Source::Given(permutation) => permutation,
            Source::Keys(number) => {
                let keys = backend.key(rays, Some(hits), number)?;
                let taken = backend.sample();
                sorted = backend.sort(&keys)?;
                if counts_both {
                    entry.add(taken, Stage::Key, round);
                    entry.keep(backend, Stage::Sort, round);
                }
                &sorted
            }
        };
        let found = self.traced(backend, permutation, way, entry, round)?;
        entry.mismatches = entry.mismatches.max(backend.differences(hits, &found)?);
        if let Subject::Method(number) = subject
            && counts_both
            && methods[*number].termination == Termination::Adaptive
        {
            backend.accumulate(rays, hits, Table::Scratch)?;
            entry.keep(backend, Stage::Accumulate, round);
        }
        Ok(())
    }

    /// What the rays find in an order, at home in canonical order.
    fn traced(
        &self,
        backend: &mut B,
        permutation: &B::Permutation,
        way: Way,
        entry: &mut Measurement,
        round: u32,
    ) -> Result<B::Hits> {
        match way {
            Way::Gathered => {
                let gathered = backend.gather(self.rays, permutation)?;
                entry.keep(backend, Stage::Gather, round);
                let found = backend.trace(&gathered, Order::Stored)?;
                entry.keep(backend, Stage::Trace, round);
                let found = backend.scatter(&found, permutation)?;
                entry.keep(backend, Stage::Scatter, round);
                Ok(found)
            }
            Way::Indices => {
                let found = backend.trace(self.rays, Order::Indirect(permutation))?;
                entry.keep(backend, Stage::TraceIndirect, round);
                Ok(found)
            }
        }
    }
}

impl Measurement {
    fn keep<B: Backend>(&mut self, backend: &B, stage: Stage, round: u32) {
        self.add(backend.sample(), stage, round);
    }

    fn add(&mut self, sample: Sample, stage: Stage, round: u32) {
        self.stages.of_mut(stage).push(sample.elapsed_ns);
        if sample.is_disturbed {
            self.disturbed.entry(stage).or_default().push(round);
        }
    }
}

/// Entries without samples.
fn empty<P>(orders: &Orders<P>) -> QueueMeasurement {
    let entry = |&Ordered { subject, mismatches, .. }: &Ordered<P>| Measurement {
        subject,
        stages: StageSamples::default(),
        disturbed: BTreeMap::new(),
        mismatches,
        trial_ns: [0; 2],
    };
    orders.0.iter().map(entry).collect()
}

/// A seed that depends on the queue.
pub fn seed_of(seed: u64, id: QueueId) -> u64 {
    let queue = (u64::from(id.pass) << 32 | u64::from(id.bounce)) << 1 | id.kind as u64;
    seed ^ queue.wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

/// Lets each of `count` take its turn once a round, in an order drawn for the round: first in a round without
/// a number, whose samples no figure takes, then in `repeats` that count.
///
/// # Errors
/// The first of any turn.
pub fn in_rounds(
    count: usize,
    repeats: u32,
    seed: u64,
    mut turn: impl FnMut(usize, Option<u32>) -> Result<()>,
) -> Result<()> {
    let mut rng = Rng::with_seed(seed);
    let mut places: Vec<usize> = (0..count).collect();
    for round in [None].into_iter().chain((0..repeats).map(Some)) {
        rng.shuffle(&mut places);
        places.iter().try_for_each(|&at| turn(at, round))?;
    }
    Ok(())
}

/// What each of `count` gave in the rounds that count: see [`in_rounds`].
///
/// # Errors
/// The first of any turn.
pub fn sampled<T>(
    count: usize,
    repeats: u32,
    seed: u64,
    mut sample: impl FnMut(usize) -> Result<T>,
) -> Result<Vec<Vec<T>>> {
    let mut samples: Vec<Vec<T>> = (0..count).map(|_| Vec::new()).collect();
    in_rounds(count, repeats, seed, |at, round| {
        let sample = sample(at)?;
        samples[at].extend(round.map(|_| sample));
        Ok(())
    })?;
    Ok(samples)
}

/// Name of a queue for messages.
pub fn queue_name(bounce: u32, kind: Kind) -> String {
    format!("bounce {bounce}, {kind} rays")
}

#[cfg(test)]
mod tests;
