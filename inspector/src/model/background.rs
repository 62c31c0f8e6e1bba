//! Work on another thread, of which only the latest result is wanted.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use super::absent::Absent;

/// How long a window waits for work that it has just asked for: what is found at once is shown at once,
/// without a frame in between that lacks it.
const PATIENCE: Duration = Duration::from_millis(12);

/// How many threads are at work.
#[derive(Debug, Default)]
struct AtWork {
    threads: Mutex<usize>,
    one_less: Condvar,
}

impl AtWork {
    fn threads(&self) -> MutexGuard<'_, usize> {
        // A number is whole even if something happened to the thread that held it.
        self.threads.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Has the window drawn again when a thread has done its work, and knows whether any is at work. Clones
/// speak of the same window and threads.
#[derive(Clone, Default)]
pub struct Waker {
    wake: Arc<OnceLock<Box<dyn Fn() + Send + Sync>>>,
    at_work: Arc<AtWork>,
}

impl Waker {
    /// Calls this whenever there is more to show, unless something else is called already; without it,
    /// nothing is called.
    pub fn set(&self, wake: impl Fn() + Send + Sync + 'static) {
        self.wake.get_or_init(|| Box::new(wake));
    }

    /// Whether there is a window to draw.
    pub fn is_set(&self) -> bool {
        self.wake.get().is_some()
    }

    /// Has the window drawn again.
    pub fn wake(&self) {
        if let Some(wake) = self.wake.get() {
            wake();
        }
    }

    /// Whether a thread is at work.
    pub fn is_busy(&self) -> bool {
        *self.at_work.threads() > 0
    }

    /// Waits until no thread is at work; whether any was.
    pub fn wait(&self) -> bool {
        let mut threads = self.at_work.threads();
        let was_busy = *threads > 0;
        while *threads > 0 {
            threads = self.at_work.one_less.wait(threads).unwrap_or_else(PoisonError::into_inner);
        }
        was_busy
    }

    /// Counts a thread as at work until what is returned is dropped, then has the window drawn again.
    pub fn start(&self) -> Working {
        *self.at_work.threads() += 1;
        Working(self.clone())
    }
}

impl fmt::Debug for Waker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Waker").field("is_set", &self.is_set()).field("at_work", &self.at_work).finish()
    }
}

/// A thread at work.
#[derive(Debug)]
pub struct Working(Waker);

impl Drop for Working {
    fn drop(&mut self) {
        *self.0.at_work.threads() -= 1;
        self.0.at_work.one_less.notify_all();
        self.0.wake();
    }
}

/// One thing at a time that another thread makes. The latest few are kept: those of two orders that are
/// compared and one to go back to, unless said otherwise.
#[derive(Debug)]
pub struct Background<K, T, const KEPT: usize = 3> {
    done: Vec<(K, Made<T>)>,
    running: Option<(K, Receiver<Made<T>>)>,
}

/// What was made, or what its thread died of.
type Made<T> = Result<T, Absent>;

impl<K, T, const KEPT: usize> Default for Background<K, T, KEPT> {
    fn default() -> Self {
        Self { done: Vec::new(), running: None }
    }
}

impl<K: PartialEq, T: Send + 'static, const KEPT: usize> Background<K, T, KEPT> {
    /// What `make` makes for `wanted`. Something else that is still being made is waited for first, so that
    /// no more than one thread is at work.
    ///
    /// # Errors
    /// While it is not made yet, and if `make` panicked, which is not tried again.
    pub fn of(
        &mut self,
        wanted: K,
        waker: &Waker,
        make: impl FnOnce() -> T + Send + 'static,
    ) -> Result<&T, Absent> {
        self.receive(Duration::ZERO);
        let is_done = self.done.iter().any(|(known, _)| *known == wanted);
        if is_done || self.running.is_some() {
            return match self.done.iter().rev().find(|(known, _)| *known == wanted) {
                Some((_, made)) => made.as_ref().map_err(Absent::clone),
                None => Err(Absent::Awaited),
            };
        }
        let (sender, receiver) = channel();
        let working = waker.start();
        thread::spawn(move || {
            // What it leaves half done is dropped with it.
            let made = catch_unwind(AssertUnwindSafe(make)).map_err(|panic| {
                let why = panic.downcast_ref::<&str>().copied();
                let why = why.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
                format!(
                    "the inspector failed at this, which is a fault of the program: {}",
                    why.unwrap_or("?")
                )
            });
            // No one listens any more once the window is closed.
            let _ = sender.send(made.map_err(Absent::from));
            drop(working);
        });
        self.running = Some((wanted, receiver));
        // Before there is a window, no one looks.
        self.receive(if waker.is_set() { PATIENCE } else { Duration::ZERO });
        match self.done.last().filter(|_| self.running.is_none()) {
            Some((_, made)) => made.as_ref().map_err(Absent::clone),
            None => Err(Absent::Awaited),
        }
    }

    /// The latest that was made and is kept whose key is such.
    pub fn known(&self, is_wanted: impl Fn(&K) -> bool) -> Option<&T> {
        let (_, made) = self.done.iter().rev().find(|(known, _)| is_wanted(known))?;
        made.as_ref().ok()
    }

    fn keep(&mut self, wanted: K, made: Made<T>) {
        if self.done.len() == KEPT {
            drop(self.done.remove(0));
        }
        self.done.push((wanted, made));
    }

    fn receive(&mut self, patience: Duration) {
        let Some((_, receiver)) = &self.running else { return };
        let made = if patience.is_zero() {
            receiver.try_recv().map_err(|error| error == TryRecvError::Empty)
        } else {
            receiver.recv_timeout(patience).map_err(|error| error == RecvTimeoutError::Timeout)
        };
        let made = match made {
            Ok(made) => made,
            Err(true) => return,
            // The thread always sends; were it gone all the same, nobody should wait for it.
            Err(false) => Err("the thread that made this is gone".into()),
        };
        if let Some((wanted, _)) = self.running.take() {
            self.keep(wanted, made);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_is_made_after_what_is_running() {
        let (mut squares, waker) = (Background::<_, _>::default(), Waker::default());
        let (start, wait) = channel::<()>();
        let slow = move || wait.recv().map_or(0, |()| 1);
        assert_eq!(squares.of(1, &waker, slow), Err(Absent::Awaited));
        assert!(waker.is_busy());
        assert_eq!(squares.of(2, &waker, || 4), Err(Absent::Awaited), "one thread at a time");
        start.send(()).unwrap();
        waker.wait();
        while squares.of(2, &waker, || 4).is_err() {}
        assert_eq!(squares.of(2, &waker, || panic!("made twice")), Ok(&4));
        assert_eq!(squares.known(|&known| known < 2), Some(&1));
        assert!(!waker.wait());
    }

    /// Nor is another result taken for that of a thread that dies while it is waited for, as a window waits.
    #[test]
    fn what_a_thread_died_of_is_said_and_not_tried_again() {
        let (mut squares, waker) = (Background::<_, u32>::default(), Waker::default());
        waker.set(|| ());
        while squares.of(1, &waker, || 1).is_err() {}
        let found = loop {
            match squares.of(2, &waker, || panic!("on purpose")) {
                Err(Absent::Awaited) => waker.wait(),
                found => break found,
            };
        };
        assert!(matches!(found, Err(Absent::Impossible(why)) if why.contains("on purpose")));
        assert!(matches!(squares.of(2, &waker, || 4), Err(Absent::Impossible(_))), "tried again");
        assert_eq!(squares.of(1, &waker, || panic!("made twice")), Ok(&1));
        assert_eq!(squares.known(|&known| known == 2), None);
    }
}
