//! All that panels see: open recordings, the selection, and the order that it names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use formats::key::method::UNSORTED;
use formats::manifest::QueueId;

use super::coherences::Coherences;
use super::order::Order;
use super::queue::Queue;
use super::recording::Recording;
use super::selection::Selection;

/// Something that went wrong, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// What was tried.
    pub what: String,
    /// Why it failed; says what to do where something can be done.
    pub why: String,
}

/// What was opened, or why it could not be.
type Opened<T> = Result<Arc<T>, String>;

/// Recording and queue.
type QueueKey = (usize, QueueId);

/// Recording, queue and method.
type OrderKey = (usize, QueueId, String);

/// Orders that are kept: two that are compared, and one to go back to.
const ORDERS_KEPT: usize = 3;

/// All that panels see.
#[derive(Debug, Default)]
pub struct Context {
    /// The open recordings.
    pub recordings: Vec<Recording>,
    /// What is selected.
    pub selection: Selection,
    /// What went wrong and was not dismissed yet.
    pub problems: Vec<Problem>,
    /// Numbers that are found in the background.
    pub coherences: Coherences,
    queue: Option<(QueueKey, Opened<Queue>)>,
    /// The orders that were looked at last, the latest at the end.
    orders: Vec<(OrderKey, Opened<Order>)>,
}

impl Context {
    /// Opens recordings and selects the first one that can be read.
    pub fn open(paths: &[PathBuf]) -> Self {
        let mut context = Self::default();
        for path in paths {
            context.add(path);
        }
        context
    }

    /// Opens one more recording and selects it; a problem if it cannot be read.
    pub fn add(&mut self, path: &Path) {
        match Recording::open(path) {
            Ok(recording) => {
                self.recordings.push(recording);
                self.select_recording(self.recordings.len() - 1);
            }
            Err(error) => self.problems.push(Problem {
                what: format!("{} cannot be opened", path.display()),
                why: error.to_string(),
            }),
        }
    }

    /// Looks at another recording, at the same queue and order if it has them.
    pub fn select_recording(&mut self, at: usize) {
        let Some(recording) = self.recordings.get(at) else { return };
        let has_queue = recording.queues().iter().any(|record| record.id == self.selection.queue);
        let is_first = self.recordings.len() == 1;
        let queue = if has_queue && !is_first { Some(self.selection.queue) } else { recording.first_queue() };
        self.selection.recording = at;
        self.selection.clear();
        if let Some(queue) = queue {
            self.selection.queue = queue;
        }
        self.keep_method();
    }

    /// The recording that is looked at.
    pub fn recording(&self) -> Option<&Recording> {
        self.recordings.get(self.selection.recording)
    }

    /// Reads the recording that is looked at again: more of it if it is still being written.
    pub fn refresh(&mut self) {
        let Some(recording) = self.recording() else { return };
        match recording.again() {
            Ok(again) => {
                let queue = again.first_queue();
                let has_queue = again.queues().iter().any(|record| record.id == self.selection.queue);
                self.recordings[self.selection.recording] = again;
                (self.queue, self.coherences) = (None, Coherences::default());
                self.orders.clear();
                if let Some(queue) = queue.filter(|_| !has_queue) {
                    self.go_to(queue);
                }
            }
            Err(error) => {
                let what = format!("{} cannot be read again", recording.dump.root().display());
                self.problems.push(Problem { what, why: error.to_string() });
            }
        }
    }

    /// Goes to another queue, in the same order if it was measured there.
    pub fn go_to(&mut self, queue: QueueId) {
        self.selection.go_to(queue);
        self.keep_method();
    }

    fn keep_method(&mut self) {
        let Selection { queue, method, .. } = &self.selection;
        let has_method = self
            .recording()
            .is_some_and(|recording| recording.methods(*queue).iter().any(|known| known == method));
        if !has_method {
            self.selection.order_by(UNSORTED);
        }
    }

    /// The queue that is looked at.
    ///
    /// # Errors
    /// Why it cannot be shown.
    pub fn queue(&mut self) -> Result<Arc<Queue>, String> {
        let wanted = (self.selection.recording, self.selection.queue);
        match &self.queue {
            Some((known, queue)) if *known == wanted => return queue.clone(),
            _ => {}
        }
        let recording = self.recordings.get(wanted.0).ok_or("no recording is open")?;
        let queue = Queue::open(&recording.dump, wanted.1).map(Arc::new);
        self.queue = Some((wanted, queue.clone()));
        queue
    }

    /// The order that is looked at.
    ///
    /// # Errors
    /// Why it cannot be shown.
    pub fn order(&mut self) -> Result<Arc<Order>, String> {
        let Selection { recording, queue, method, .. } = &self.selection;
        let wanted = (*recording, *queue, method.clone());
        if let Some((_, order)) = self.orders.iter().find(|(known, _)| *known == wanted) {
            return order.clone();
        }
        let queue = self.queue()?;
        let recording = self.recordings.get(wanted.0).ok_or("no recording is open")?;
        let order = Order::open(&recording.dump, queue, &wanted.2).map(Arc::new);
        if self.orders.len() == ORDERS_KEPT {
            drop(self.orders.remove(0));
        }
        self.orders.push((wanted, order.clone()));
        order
    }

    /// Selects a ray of the queue with its group, or nothing.
    pub fn select_ray(&mut self, ray: Option<usize>) {
        let width = self.selection.group_width.rays();
        let place = ray.and_then(|ray| Some(*self.order().ok()?.place_of_ray().get(ray)? as usize));
        self.selection.ray = ray.filter(|_| place.is_some());
        self.selection.group = place.map(|place| place / width);
    }

    /// Selects a group of the order.
    pub fn select_group(&mut self, group: Option<usize>) {
        let width = self.selection.group_width.rays();
        let rays = self.order().map_or(0, |order| order.len());
        self.selection.group = group.filter(|group| group * width < rays);
    }
}
