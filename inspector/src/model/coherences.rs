//! How coherent the orders of a queue are: found on another thread, one order after the other.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

use formats::manifest::QueueId;
use formats::reader::Dump;
use rayon::ThreadPoolBuilder;

use super::background::Waker;
use super::order::Order;
use super::queue::Queue;
use super::recording::Recording;
use crate::analysis::coherence::{Coherence, LaneUtilisation, coherence, lanes};
use crate::analysis::{GroupWidth, Metric};

/// How coherent one order is.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderCoherence {
    /// The method, or `unsorted`.
    pub method: String,
    /// Capsules and direction spread.
    pub coherence: Metric<Coherence>,
    /// Lane utilisation by width. A model.
    pub lanes: Metric<Vec<LaneUtilisation>>,
}

/// Which numbers: opening of a recording, queue and width of a group.
type Wanted = (u64, QueueId, usize);

/// What is known so far.
#[derive(Debug, Default)]
pub struct Coherences {
    known: BTreeMap<Wanted, Vec<OrderCoherence>>,
    running: Option<(Wanted, Receiver<OrderCoherence>)>,
    /// What is found next, and in which frame it was asked for: in a later one, a picture without it was drawn.
    next: Option<(Wanted, u64)>,
}

impl Coherences {
    /// What is known of a queue's orders; asks for the rest unless it is being found. It waits until nothing
    /// else is being read or made and all of that was drawn, that is, for a later `frame`: a software GPU draws
    /// on the same processors.
    pub fn of(
        &mut self,
        recording: &Recording,
        queue: &Arc<Queue>,
        width: GroupWidth,
        (waker, frame): (&Waker, u64),
    ) -> &[OrderCoherence] {
        self.receive();
        let wanted = (recording.opening, queue.id, width.rays());
        let is_due = self.running.is_none() && !self.known.contains_key(&wanted) && !waker.is_busy();
        let asked = self.next.filter(|(next, _)| *next == wanted);
        if is_due && asked.is_none() {
            self.next = Some((wanted, frame));
            waker.wake();
        } else if is_due && asked.is_some_and(|(_, asked)| asked < frame) {
            self.next = None;
            self.known.insert(wanted, Vec::new());
            let (sender, receiver) = channel();
            let (dump, queue) = (recording.dump.clone(), queue.clone());
            let methods = recording.methods(queue.id).to_vec();
            let (waker, working) = (waker.clone(), waker.start());
            thread::spawn(move || {
                // Threads of its own: what a window waits for does not stand in line behind all rays of an order.
                let threads = ThreadPoolBuilder::new().build();
                for method in methods {
                    let find = || of_order(&dump, &queue, &method, width);
                    let found = threads.as_ref().map_or_else(|_| find(), |threads| threads.install(find));
                    // No one listens any more once the window is closed.
                    if sender.send(found).is_err() {
                        return;
                    }
                    waker.wake();
                }
                drop((sender, working));
            });
            self.running = Some((wanted, receiver));
        }
        self.known.get(&wanted).map_or(&[], Vec::as_slice)
    }

    fn receive(&mut self) {
        let Some((wanted, receiver)) = &self.running else { return };
        loop {
            match receiver.try_recv() {
                Ok(found) => self.known.entry(*wanted).or_default().push(found),
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => break,
            }
        }
        self.running = None;
    }
}

fn of_order(dump: &Dump, queue: &Arc<Queue>, method: &str, width: GroupWidth) -> OrderCoherence {
    match Order::open(dump, queue.clone(), method) {
        Ok(order) => OrderCoherence::of(&order, width),
        Err(reason) => OrderCoherence::missing(method, &reason),
    }
}

impl OrderCoherence {
    /// Of an order that cannot be shown, for this reason.
    pub fn missing(method: &str, reason: &str) -> Self {
        let (coherence, lanes) = (Metric::missing(reason), Metric::missing(reason));
        Self { method: method.to_owned(), coherence, lanes }
    }

    /// Of an order in groups of this width.
    pub fn of(order: &Order, width: GroupWidth) -> Self {
        let queue = &order.queue;
        let coherence = coherence(&queue.traced, &queue.lengths, &order.places, width.rays());
        let coherence = coherence.ok_or_else(|| "there are no rays".to_owned());
        let lanes = queue.work.as_ref().map(|work| lanes(work, &order.places));
        Self { method: order.method.clone(), coherence: coherence.into(), lanes: lanes.into() }
    }
}
