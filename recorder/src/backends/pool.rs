//! Memory that is used again: what a timed section writes was there and was touched before.

use std::sync::Arc;

/// Buffers of one kind. One is lent to a single holder at a time, and is free again once nobody holds it.
#[derive(Debug)]
pub(super) struct Pool<T>(Vec<Arc<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Pool<T> {
    /// A buffer that nobody holds, else a new one.
    ///
    /// # Errors
    /// Those of making it.
    pub(super) fn get<E>(&mut self, make: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        if let Some(free) = self.0.iter().find(|buffer| Arc::strong_count(buffer) == 1) {
            return Ok(Arc::clone(free));
        }
        let buffer = Arc::new(make()?);
        self.0.push(Arc::clone(&buffer));
        Ok(buffer)
    }

    /// A buffer that nobody holds, filled, and what filling it gave.
    pub(super) fn filled<R>(&mut self, fill: impl FnOnce(&mut T) -> R) -> (Arc<T>, R)
    where
        T: Default,
    {
        let free = self.0.iter_mut().position(|buffer| Arc::get_mut(buffer).is_some());
        let at = free.unwrap_or_else(|| {
            self.0.push(Arc::default());
            self.0.len() - 1
        });
        let Some(buffer) = Arc::get_mut(&mut self.0[at]) else { unreachable!("nobody else holds it") };
        let filled = fill(buffer);
        (Arc::clone(&self.0[at]), filled)
    }
}

/// A value whose arrays are lent.
#[derive(Debug)]
pub struct Lent<T> {
    value: T,
    _memory: Arc<T>,
}

impl<T> Lent<T> {
    /// A view of memory, which is not free before it is dropped.
    pub(super) fn new(memory: Arc<T>, view: impl FnOnce(&T) -> T) -> Self {
        Self { value: view(&memory), _memory: memory }
    }
}

impl<T> std::ops::Deref for Lent<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_is_not_written_and_what_is_free_is_used_again() {
        let mut pool = Pool::<Vec<u32>>::default();
        let (first, ()) = pool.filled(|buffer| buffer.push(1));
        let (second, ()) = pool.filled(|buffer| buffer.push(2));
        assert_eq!((&*first, &*second), (&vec![1], &vec![2]));
        drop(first);
        let (third, ()) = pool.filled(|buffer| buffer.push(3));
        assert_eq!((&*third, &*second), (&vec![1, 3], &vec![2]));
        assert_eq!(pool.0.len(), 2);
    }
}
