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
    /// Rows of `rounds` rounds; `run` gives a contestant its turn and times its work alone. Each turn comes twice in a
    /// row, and the second time counts.
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
            // Not timed: who follows its like, as a peer does its control, would find more of its data in the caches.
            run(turn, &mut clock);
            run(turn, &mut clock);
            samples[turn].push(clock.last().elapsed_ns);
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn whoever_is_timed_ran_right_before() {
        let mut turns = Vec::new();
        samples(3, 5, |turn, clock| {
            turns.push(turn);
            clock.time(|| ());
        });
        assert_eq!(turns.len(), 2 * 3 * 5);
        assert!(turns.chunks(2).all(|turn| turn[0] == turn[1]), "{turns:?}");
    }

    fn rows(contestants: [(&str, Side, u64); 3]) -> Vec<Row> {
        let contest = Contest {
            subject: "scene",
            task: "rays".to_owned(),
            items: 1000,
            contestants: contestants.iter().map(|(name, side, _)| ((*name).to_owned(), *side)).collect(),
            differing: vec![0, 1, 2],
        };
        contest.rows(6, |at, clock| {
            clock.time(|| std::thread::sleep(Duration::from_millis(contestants[at].2)));
        })
    }

    #[test]
    fn what_takes_a_third_of_the_time_is_three_times_as_fast_and_a_control_is_as_fast_as_itself() {
        let rows = rows([("ours", Side::Ours, 4), ("first", Side::Peer, 12), ("second", Side::Peer, 2)]);
        let names: Vec<(&str, Side)> = rows.iter().map(|row| (row.name.as_str(), row.side)).collect();
        let peer = Side::Peer;
        assert_eq!(
            names,
            [("ours", Side::Ours), ("first", peer), ("second", peer), ("first", Side::Control)]
        );
        let over = |row: usize, peer: &str| rows[row].over[peer].ratio;
        assert!((1.5..6.0).contains(&over(0, "first")), "{rows:?}");
        assert!((0.2..0.9).contains(&over(0, "second")), "{rows:?}");
        assert!((0.5..2.0).contains(&over(3, "first")), "{rows:?}");
        assert!(rows[1].over.is_empty() && rows.iter().all(|row| row.samples_ns.len() == 6));
        assert_eq!(rows.iter().map(|row| row.differing).collect::<Vec<_>>(), [0, 1, 2, 1]);
        assert!((50.0..90.0).contains(&(rows[1].rate * 1e3)), "1000 items in 12 ms: {} a µs", rows[1].rate);
    }
}
