//! Shared storage of the unknowns during a sweep: cells or atomics.
//!
//! Rows that share no particle may be swept at once, though all have access to the whole
//! list. A list of cells permits that on one thread, a list of atomics on many;
//! loads and stores are relaxed, which costs no more than plain ones, since the end of
//! the parallel loop separates the batches. The arithmetic is the same.

use std::cell::Cell;

use glam::DVec3;

/// Vector that can be changed through a shared reference.
pub(super) trait Slot {
    fn load(&self) -> DVec3;
    fn store(&self, value: DVec3);
}

impl Slot for Cell<DVec3> {
    #[inline]
    fn load(&self) -> DVec3 {
        self.get()
    }

    #[inline]
    fn store(&self, value: DVec3) {
        self.set(value);
    }
}

/// Returns a list as cells.
pub(super) fn cells(q: &mut [DVec3]) -> &[Cell<DVec3>] {
    Cell::from_mut(q).as_slice_of_cells()
}

#[cfg(feature = "rayon")]
pub(super) use self::atomic::AtomicSlot;

#[cfg(feature = "rayon")]
mod atomic {
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

    use glam::DVec3;

    /// Vector of three atomics. A load returns its own thread's last store, or the value
    /// before the parallel loop; nothing else is relied on.
    pub(in crate::solve) struct AtomicSlot([AtomicU64; 3]);

    impl AtomicSlot {
        pub(in crate::solve) fn new(value: DVec3) -> Self {
            Self(value.to_array().map(|component| AtomicU64::new(component.to_bits())))
        }
    }

    impl super::Slot for AtomicSlot {
        #[inline]
        fn load(&self) -> DVec3 {
            DVec3::from_array(
                self.0.each_ref().map(|component| f64::from_bits(component.load(Relaxed))),
            )
        }

        #[inline]
        fn store(&self, value: DVec3) {
            for (slot, component) in self.0.iter().zip(value.to_array()) {
                slot.store(component.to_bits(), Relaxed);
            }
        }
    }
}
