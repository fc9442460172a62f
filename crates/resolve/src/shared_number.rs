//! Numbers that one thread after the other changes, without a lock.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Number that one thread at a time reads or changes: those before have [finished](crate::turns) by then, which
/// orders their changes.
#[derive(Default)]
pub(crate) struct SharedNumber(AtomicU64);

impl SharedNumber {
    pub(crate) fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Relaxed))
    }

    pub(crate) fn set(&self, number: f64) {
        self.0.store(number.to_bits(), Relaxed);
    }

    pub(crate) fn add(&self, change: f64) {
        self.0.store((self.get() + change).to_bits(), Relaxed);
    }
}
