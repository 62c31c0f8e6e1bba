//! Turns: every contestant once in each round, and what their times come to.

use std::collections::BTreeMap;

use formats::metrics::speedup::{Speedup, median};
use recorder::clock::Clock;
use serde::Serialize;

/// Whose work a time is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// This project.
    Ours,
    /// Somebody else.
    Peer,
    /// The first peer once more: its ratio over itself must be 1, and misses it by the instrument's error.
    Control,
}

/// One contestant at one task.
#[derive(Debug, Serialize)]
pub struct Row {
    /// What a table is about: a scene, or sorting.
    pub subject: String,
    /// Which rays or keys.
    pub task: String,
    /// Rays or pairs.
    pub items: usize,
    /// Threads.
    pub threads: usize,
    /// Kernel, library or crate.
    pub name: String,
    /// Whose it is.
    pub side: Side,
    /// One sample per round, nanoseconds.
    pub samples_ns: Vec<u64>,
    /// Million items per second at the median.
    pub rate: f64,
    /// How many times as fast as each peer, for what is no peer.
    pub over: BTreeMap<String, Speedup>,
    /// Results that are not those of our first kernel, or sort: rays that hit and do not or elsewhere, pairs out of
    /// their stable order.
    pub differing: usize,
}

/// A task for several contestants.
pub struct Contest<'a> {
    /// See [`Row::subject`].
    pub subject: &'a str,
    /// See [`Row::task`].
    pub task: String,
    /// See [`Row::items`].
    pub items: usize,
    /// Name and side of each; with a peer among them the first one has another turn as control.
    pub contestants: Vec<(String, Side)>,
    /// Results of each that differ, found in a run that is not timed and so is the warm-up.
    pub differing: Vec<usize>,
}

impl Contest<'_> {
    /// Rows of `rounds` rounds; `run` gives a contestant its turn and times its work alone.
    pub fn rows(self, rounds: usize, mut run: impl FnMut(usize, &mut Clock)) -> Vec<Row> {
        let mut turns: Vec<usize> = (0..self.contestants.len()).collect();
        let control = self.contestants.iter().position(|(_, side)| *side == Side::Peer);
        turns.extend(control);
        let of_turn = turns.clone();
        let samples = samples(of_turn.len(), rounds, |turn, clock| run(of_turn[turn], clock));
        let peers = || (0..self.contestants.len()).filter(|&at| self.contestants[at].1 == Side::Peer);
        let row = |(turn, samples_ns): (usize, &Vec<u64>)| {
            let at = of_turn[turn];
            let (name, mut side) = self.contestants[at].clone();
            if turn >= self.contestants.len() {
                side = Side::Control;
            }
            let rivals: Vec<usize> = match side {
                Side::Ours => peers().collect(),
                Side::Control => vec![at],
                Side::Peer => Vec::new(),
            };
            let over = |peer: usize| {
                Some((self.contestants[peer].0.clone(), Speedup::of(&samples[peer], samples_ns)?))
            };
            Row {
                subject: self.subject.to_owned(),
                task: self.task.clone(),
                items: self.items,
                threads: rayon::current_num_threads(),
                name,
                side,
                rate: median(samples_ns).map_or(0.0, |ns| self.items as f64 / ns * 1e3),
                over: rivals.into_iter().filter_map(over).collect(),
                differing: self.differing[at],
                samples_ns: samples_ns.clone(),
            }
        };
        samples.iter().enumerate().map(row).collect()
    }
}

/// The samples of each turn, one per round, nanoseconds.
fn samples(turns: usize, rounds: usize, mut run: impl FnMut(usize, &mut Clock)) -> Vec<Vec<u64>> {
    let mut clock = Clock::of_processor();
    let mut random = fastrand::Rng::with_seed(0);
    let mut order: Vec<usize> = (0..turns).collect();
    let mut samples = vec![Vec::with_capacity(rounds); turns];
    for _ in 0..rounds {
        random.shuffle(&mut order);
        for &turn in &order {
            run(turn, &mut clock);
            samples[turn].push(clock.last().elapsed_ns);
        }
    }
    samples
}
