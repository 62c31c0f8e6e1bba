//! All that panels see: open recordings, the selection, and the order that it names.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use formats::key::method::UNSORTED;
use formats::manifest::{QueueId, QueueRecord};

use super::absent::Absent;
use super::background::Background;
use super::derived::Derived;
use super::order::Order;
use super::queue::Queue;
use super::recording::Recording;
use super::selection::{Baseline, Playhead, Selection};
use super::what_if::{self, WHAT_IF};
use crate::analysis::Versus;
use crate::analysis::versus::OrderOf;
use crate::figures::method_style::method_style;

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

/// Opening of a recording, and queue.
type QueueKey = (u64, QueueId);

/// A queue that is opened by the first that needs it.
type Opening = LazyLock<Opened<Queue>, Box<dyn FnOnce() -> Opened<Queue> + Send>>;

/// Queues that can be asked for at once: those of two orders that are compared and one to go back to.
const OPENINGS: usize = 3;

/// Of the order that is made here: grey, and of a round that no method of `all` reaches.
const WHAT_IF_STYLE: usize = 26;

/// Opening of a recording, queue and method.
type OrderKey = (u64, QueueId, String);

/// All that panels see.
#[derive(Debug, Default)]
pub struct Context {
    /// The open recordings.
    pub recordings: Vec<Recording>,
    /// What is selected.
    pub selection: Selection,
    /// How far along the order panels are.
    pub playhead: Playhead,
    /// Whether a picture of a panel is made, in which nobody can press buttons.
    pub is_bare: bool,
    /// What went wrong and was not dismissed yet.
    pub problems: Vec<Problem>,
    /// What the what-if order is made by, once it was asked for.
    pub what_if: Option<what_if::Settings>,
    /// Whether B was chosen, and stays where another recording is looked at; otherwise it is the best order there.
    pub(crate) is_b_chosen: bool,
    pub(super) derived: Derived,
    openings: Vec<(QueueKey, Arc<Opening>)>,
    queues: Background<QueueKey, Opened<Queue>>,
    orders: Background<OrderKey, Opened<Order>>,
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

    /// Opens one more recording and selects it; whether it can be read: a problem if not.
    pub fn add(&mut self, path: &Path) -> bool {
        match Recording::open(path) {
            Ok(recording) => {
                self.recordings.push(recording);
                self.select_recording(self.recordings.len() - 1);
                true
            }
            Err(error) => {
                let what = format!("{} cannot be opened", path.display());
                self.problems.push(Problem { what, why: error.to_string() });
                false
            }
        }
    }

    /// Looks at another recording, at the same queue and the order that was chosen if it has them.
    pub fn select_recording(&mut self, at: usize) {
        let Some(recording) = self.recordings.get(at) else { return };
        let is_first = self.recordings.len() == 1;
        let same = recording.queue(self.selection.queue).filter(|_| !is_first).map(|record| record.id);
        let queue = same.or_else(|| recording.first_queue());
        self.selection.recording = at;
        self.selection.clear();
        if let Some(queue) = queue {
            self.selection.queue = queue;
        }
        if !self.is_b_chosen {
            self.order_by_best();
        }
        self.keep_orders();
    }

    /// Makes the best method of the queue order B.
    fn order_by_best(&mut self) {
        let best = self.recording().map(|open| open.best_method(self.selection.queue).to_owned());
        self.selection.order_by(&best.unwrap_or_else(|| UNSORTED.to_owned()));
    }

    /// The selected recording.
    pub fn recording(&self) -> Option<&Recording> {
        self.recordings.get(self.selection.recording)
    }

    /// Reads the selected recording again: more of it if it is still being written.
    pub fn refresh(&mut self) {
        let Some(recording) = self.recording() else { return };
        match recording.again() {
            Ok(again) => {
                let has_queue = again.queue(self.selection.queue).is_some();
                let queue = again.first_queue().filter(|_| !has_queue);
                self.recordings[self.selection.recording] = again;
                if let Some(queue) = queue {
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
        self.keep_orders();
    }

    /// Leaves orders that the queue has not got, and takes up again what was left for that.
    pub(crate) fn keep_orders(&mut self) {
        let Selection { queue, method, wanted, .. } = self.selection.clone();
        let measured = self.recording().map_or(&[][..], |open| open.methods(queue));
        let is_there = |method: &String| method == WHAT_IF || measured.contains(method);
        match wanted {
            Some(wanted) if is_there(&wanted) => self.selection.order_by(&wanted),
            _ if is_there(&method) => {}
            wanted => {
                self.order_by_best();
                self.selection.wanted = wanted.or(Some(method));
            }
        }
        let Baseline { recording, method } = self.selection.baseline.clone();
        self.hold_against(recording, &method);
    }

    /// Goes where a method was measured, if the queue is not: to rays of this kind before others, to the nearest bounce
    /// of the pass.
    pub fn go_where_measured(&mut self, method: &str) {
        let QueueId { pass, bounce, kind } = self.selection.queue;
        let Some(recording) = self.recording().filter(|_| !self.methods().iter().any(|one| one == method))
        else {
            return;
        };
        let is_measured = |record: &&QueueRecord| record.methods.iter().any(|one| one == method);
        let queues = recording.queues().iter().filter(|record| record.id.pass == pass).filter(is_measured);
        let distance = |id: &QueueId| (id.kind != kind, id.bounce.abs_diff(bounce));
        if let Some(queue) = queues.map(|record| record.id).min_by_key(distance) {
            self.go_to(queue);
        }
    }

    /// Makes an order A: of that of the open recordings, or of B's if `None`. It is `unsorted` where there is no
    /// such order.
    pub fn hold_against(&mut self, recording: Option<usize>, method: &str) {
        let is_other = |at: &usize| *at < self.recordings.len() && *at != self.selection.recording;
        let recording = recording.filter(is_other);
        let known = self.methods_of(recording.unwrap_or(self.selection.recording));
        let method = if known.iter().any(|known| known == method) { method } else { UNSORTED };
        self.selection.baseline = Baseline { recording, method: method.to_owned() };
    }

    /// The recording of order A.
    pub fn baseline_recording(&self) -> Option<&Recording> {
        self.recordings.get(self.selection.baseline.recording.unwrap_or(self.selection.recording))
    }

    /// What is asked with order A in the place of B, and with those rays of it selected that `a_of` says of B's.
    pub fn of_baseline<T>(
        &mut self,
        a_of: impl Fn(usize) -> Option<usize>,
        ask: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let Baseline { recording, method } = self.selection.baseline.clone();
        let recording = recording.unwrap_or(self.selection.recording);
        let mut a = Selection { recording, method, ..self.selection.clone() };
        a.select(self.selection.rays().into_iter().filter_map(a_of).collect());
        let b = std::mem::replace(&mut self.selection, a);
        let found = ask(self);
        self.selection = b;
        found
    }

    /// How much faster B is than A on the whole frame, and on the selected rays; nothing while one of them is not
    /// finished.
    pub fn versus(&self) -> Option<[Versus; 2]> {
        let [a, b] = [self.baseline_recording()?, self.recording()?];
        let Selection { baseline, method, queue, .. } = &self.selection;
        let a = OrderOf { recording: a.times.as_ref()?, method: &baseline.method };
        let b = OrderOf { recording: b.times.as_ref()?, method };
        Some([Versus::on_frame([a, b]), Versus::on([a, b], |found| found.id() == *queue)])
    }

    /// Number of the style of a method: as in figures of what is open.
    pub fn style_of(&self, method: &str) -> usize {
        if method == WHAT_IF {
            return WHAT_IF_STYLE;
        }
        method_style(self.recordings.iter().filter_map(|open| open.times.as_ref()), method)
    }

    /// The selected queue: read by another thread.
    ///
    /// # Errors
    /// Why it cannot be shown, or not yet.
    pub fn queue(&mut self) -> Result<Arc<Queue>, Absent> {
        let (wanted, opening) = self.opening()?;
        opened(self.queues.of(wanted, &self.derived.waker, move || LazyLock::force(&opening).clone()))
    }

    /// The selected queue, for threads that can wait for it.
    fn opening(&mut self) -> Result<(QueueKey, Arc<Opening>), Absent> {
        let recording = self.recording().ok_or("no recording is open")?;
        let wanted = (recording.opening, self.selection.queue);
        if let Some((_, opening)) = self.openings.iter().find(|(known, _)| *known == wanted) {
            return Ok((wanted, opening.clone()));
        }
        let (dump, known) = (recording.dump.clone(), self.queues.known(|known| *known == wanted).cloned());
        let open = move || known.unwrap_or_else(|| Queue::open(&dump, wanted.1).map(Arc::new));
        let opening: Arc<Opening> = Arc::new(LazyLock::new(Box::new(open)));
        if self.openings.len() == OPENINGS {
            self.openings.remove(0);
        }
        self.openings.push((wanted, opening.clone()));
        Ok((wanted, opening))
    }

    /// Has other threads read what is selected, before there is a window that asks for it.
    pub fn read_ahead(&mut self) {
        // Panels say why if something cannot be read.
        drop(self.queue());
        drop(self.order());
    }

    /// The selected order: read by another thread.
    ///
    /// # Errors
    /// Why it cannot be shown, or not yet.
    pub fn order(&mut self) -> Result<Arc<Order>, Absent> {
        let order = self.order_by_itself()?;
        self.place_selected_ray(&order);
        Ok(order)
    }

    fn order_by_itself(&mut self) -> Result<Arc<Order>, Absent> {
        if self.selection.method == WHAT_IF {
            return self.what_if_order();
        }
        let ((at, queue), opening) = self.opening()?;
        let dump = self.recording().ok_or("no recording is open")?.dump.clone();
        let wanted = (at, queue, self.selection.method.clone());
        let method = wanted.2.clone();
        let open = move || {
            let order = Order::open(&dump, LazyLock::force(&opening).clone()?, &method)?;
            // What panels ask for, so that none of them makes the window wait for it.
            order.place_of_ray();
            Ok(Arc::new(order))
        };
        opened(self.orders.of(wanted, &self.derived.waker, open))
    }

    /// The selected order, however long it takes.
    ///
    /// # Errors
    /// Why it cannot be shown.
    pub fn awaited_order(&mut self) -> Result<Arc<Order>, String> {
        loop {
            match self.order() {
                Err(Absent::Awaited) => self.finish(),
                found => return Ok(found?),
            };
        }
    }

    /// Selects a ray of the queue with its group, or nothing. The group is known when the order is.
    pub fn select_ray(&mut self, ray: Option<usize>) {
        self.select_rays(ray.into_iter().collect());
    }

    /// Selects rays of the queue, the latest first, with the group of that one.
    pub fn select_rays(&mut self, mut rays: Vec<usize>) {
        let queue = self.recording().and_then(|open| open.queue(self.selection.queue));
        let all = queue.map_or(0, |queue| queue.rays);
        rays.retain(|&ray| (ray as u64) < all);
        self.selection.select(rays);
        // Finds the group; panels say why if there is no order.
        drop(self.order());
    }

    /// Selects a ray besides those that are, or no longer.
    pub fn toggle_ray(&mut self, ray: usize) {
        let mut rays = self.selection.rays();
        match rays.iter().position(|&selected| selected == ray) {
            Some(at) => drop(rays.remove(at)),
            None => rays.insert(0, ray),
        }
        self.select_rays(rays);
    }

    /// Looks at another order of the same rays.
    pub fn order_by(&mut self, method: &str) {
        self.is_b_chosen = true;
        self.selection.order_by(method);
        self.select_rays(self.selection.rays());
    }

    /// Selects the group of the selected ray, unless one is selected.
    fn place_selected_ray(&mut self, order: &Order) {
        let Selection { ray, group, group_width, .. } = &mut self.selection;
        let Some(selected) = *ray else { return };
        match order.place_of_ray().get(selected) {
            Some(&place) => *group = group.or(Some(place as usize / group_width.rays())),
            None => *ray = None,
        }
    }
}

pub(super) fn opened<T>(found: Result<&Opened<T>, Absent>) -> Result<Arc<T>, Absent> {
    found?.as_ref().map(Arc::clone).map_err(Absent::from)
}
