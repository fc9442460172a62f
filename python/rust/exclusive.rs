//! Objects that one call at a time may use.

use std::sync::{Mutex, MutexGuard, TryLockError};

use pyo3::prelude::*;

use crate::error::in_use;

/// Value of an object that several Python threads may have, and one call at a time may use.
#[derive(Debug, Default)]
pub(crate) struct Exclusive<T>(Mutex<T>);

impl<T> Exclusive<T> {
    pub(crate) fn new(value: T) -> Self {
        Self(Mutex::new(value))
    }

    /// Holds the value for a call; an exception where another call has it. No call waits here: it
    /// would do so with the interpreter's lock.
    pub(crate) fn hold(&self, what: &str) -> PyResult<MutexGuard<'_, T>> {
        match self.0.try_lock() {
            Ok(held) => Ok(held),
            Err(TryLockError::Poisoned(held)) => Ok(held.into_inner()),
            Err(TryLockError::WouldBlock) => {
                Err(in_use(format!("{what} is in use by another call: have one per thread")))
            }
        }
    }
}
