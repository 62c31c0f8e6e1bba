//! What a GPU does not do, said in place of ending the program.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::model::background::Waker;

/// Why the last picture of a view lacks something; set when it is drawn, which is after the view was laid out.
#[derive(Clone, Debug, Default)]
pub struct Refusal(Arc<Mutex<Option<String>>>);

impl Refusal {
    /// Why something is not drawn, if anything is not.
    pub fn reason(&self) -> Option<String> {
        locked(&self.0).clone()
    }

    /// Takes another reason, and has the window drawn again to show it.
    pub(super) fn set(&self, reason: Option<String>, waker: &Waker) {
        let mut known = locked(&self.0);
        if *known != reason {
            *known = reason;
            waker.wake();
        }
    }
}

/// Errors of a device that no one waits for, each of them once.
#[derive(Clone, Debug, Default)]
pub struct Errors(Arc<Mutex<Reported>>);

#[derive(Debug, Default)]
struct Reported {
    known: Vec<String>,
    taken: usize,
}

impl Errors {
    /// Of a device, from now on. Without this, wgpu ends the program at the first of them.
    pub fn of(device: &wgpu::Device, waker: &Waker) -> Self {
        let errors = Self::default();
        let (reported, waker) = (errors.0.clone(), waker.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let (mut reported, error) = (locked(&reported), error.to_string());
            if !reported.known.contains(&error) {
                reported.known.push(error);
                waker.wake();
            }
        }));
        errors
    }

    /// Those that were not taken before.
    pub fn take(&self) -> Vec<String> {
        let Reported { known, taken } = &mut *locked(&self.0);
        let new = known[*taken..].to_vec();
        *taken = known.len();
        new
    }
}

fn locked<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    // What is in it is whole even if something happened to the thread that held it.
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
