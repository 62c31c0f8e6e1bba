//! Threads that wait for each other awake.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::thread::yield_now;

use rayon::prelude::*;

/// How often a thread makes way for others before it waits no longer: 0.1 to 0.2 ms.
const PATIENCE: usize = 300;

/// Calls `work` with the number of each item and the item, of which there is one for each thread of the current
/// pool or fewer.
///
/// A thread of a pool that finds nothing to do sleeps after some ten microseconds and takes tens to wake. So where
/// threads do not end at once, the section itself ends late, and the next one begins late. Here they stay awake
/// until the last has ended, unless that takes longer. They do not wait for a thread that has yet to wake: one of
/// them takes its item.
pub(super) fn together<T: Send>(items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    let (count, begun, ended) = (items.len(), AtomicUsize::new(0), AtomicUsize::new(0));
    items.par_iter_mut().enumerate().with_max_len(1).for_each(|(number, item)| {
        begun.fetch_add(1, Relaxed);
        work(number, item);
        ended.fetch_add(1, Relaxed);
        let others_work = |_: &usize| begun.load(Relaxed) == count && ended.load(Relaxed) < count;
        (0..PATIENCE).take_while(others_work).for_each(|_| yield_now());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_item_is_seen_once_with_its_number() {
        for (count, threads) in [(0, 2), (1, 2), (2, 2), (3, 2), (3, 1), (5, 8)] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut items = vec![0; count];
            pool.install(|| together(&mut items, |number, item| *item += number + 1));
            assert!(items.iter().zip(1..).all(|(&item, expected)| item == expected), "{count} on {threads}");
        }
    }
}
