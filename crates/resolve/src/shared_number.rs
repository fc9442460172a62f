//! Numbers that one thread after the other changes, without a lock.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use glam::DVec3;

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
        self.set(self.get() + change);
    }
}

/// Vector that one thread at a time reads or changes, as a [`SharedNumber`].
#[derive(Default)]
pub(crate) struct SharedVector([SharedNumber; 3]);

impl SharedVector {
    pub(crate) fn new(vector: DVec3) -> Self {
        let shared = Self::default();
        shared.add(vector);
        shared
    }

    pub(crate) fn get(&self) -> DVec3 {
        DVec3::from(self.0.each_ref().map(SharedNumber::get))
    }

    pub(crate) fn add(&self, change: DVec3) {
        for (component, change) in self.0.iter().zip(change.to_array()) {
            component.add(change);
        }
    }
}
