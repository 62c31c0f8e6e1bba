//! Work on another thread, of which only the latest result is wanted.

use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::thread;
use std::time::Duration;

/// How long a caller waits for work that it has just asked for: what is found at once is shown at once,
/// without a frame in between that lacks it.
const PATIENCE: Duration = Duration::from_millis(12);

/// Has the window drawn again; does nothing where there is no window.
#[derive(Clone, Default)]
pub struct Waker(Option<Arc<dyn Fn() + Send + Sync>>);

impl Waker {
    /// Calls this whenever there is more to show.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(wake)))
    }

    /// Whether there is a window to draw.
    pub fn is_set(&self) -> bool {
        self.0.is_some()
    }

    /// Has the window drawn again.
    pub fn wake(&self) {
        if let Some(wake) = &self.0 {
            wake();
        }
    }
}

impl fmt::Debug for Waker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Waker").field(&self.is_set()).finish()
    }
}

/// Results that are kept: those of two orders that are compared, and one to go back to.
const KEPT: usize = 3;

/// One thing at a time that another thread makes; the latest few are kept.
#[derive(Debug)]
pub struct Background<K, T> {
    done: Vec<(K, T)>,
    running: Option<(K, Receiver<T>)>,
}

impl<K, T> Default for Background<K, T> {
    fn default() -> Self {
        Self { done: Vec::new(), running: None }
    }
}

impl<K: PartialEq, T: Send + 'static> Background<K, T> {
    /// What `make` makes for `wanted`; `None` until it is made. Something else that is still being made
    /// is waited for first, so that no more than one thread is at work.
    pub fn of(&mut self, wanted: K, waker: &Waker, make: impl FnOnce() -> T + Send + 'static) -> Option<&T> {
        self.receive(Duration::ZERO);
        let is_done = self.done.iter().any(|(known, _)| *known == wanted);
        if !is_done && self.running.is_none() {
            let (sender, receiver) = channel();
            let waker = waker.clone();
            thread::spawn(move || {
                // No one listens any more once the window is closed.
                let _ = sender.send(make());
                waker.wake();
            });
            self.running = Some((wanted, receiver));
            self.receive(PATIENCE);
            // Still running, or the last one that was done.
            return self.done.last().filter(|_| self.running.is_none()).map(|(_, made)| made);
        }
        self.done.iter().find(|(known, _)| *known == wanted).map(|(_, made)| made)
    }

    /// Waits for what is being made; whether anything was.
    pub fn finish(&mut self) -> bool {
        let Some((wanted, receiver)) = self.running.take() else { return false };
        if let Ok(made) = receiver.recv() {
            self.keep(wanted, made);
        }
        true
    }

    fn keep(&mut self, wanted: K, made: T) {
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
        match made {
            Ok(made) => {
                if let Some((wanted, _)) = self.running.take() {
                    self.keep(wanted, made);
                }
            }
            Err(true) => {}
            // The thread is gone without a result, so it is asked for again.
            Err(false) => self.running = None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_is_made_after_what_is_running() {
        let mut squares = Background::default();
        let (start, wait) = channel::<()>();
        let slow = move || wait.recv().map_or(0, |()| 1);
        assert_eq!(squares.of(1, &Waker::default(), slow), None);
        assert_eq!(squares.of(2, &Waker::default(), || 4), None, "one thread at a time");
        start.send(()).unwrap();
        assert!(squares.finish());
        while squares.of(2, &Waker::default(), || 4).is_none() {}
        assert_eq!(squares.of(2, &Waker::default(), || panic!("made twice")), Some(&4));
        assert!(!squares.finish());
    }
}
