//! Floating-point numbers as keys of heaps and sorts.

use std::cmp::Ordering;

/// `f64` in the total order of IEEE 754, so that it can be a key of a heap.
///
/// ```
/// use std::collections::BinaryHeap;
/// use surface::TotalF64;
///
/// let mut heap: BinaryHeap<TotalF64> = [1.5, 3.0, 2.0].map(TotalF64).into();
/// assert_eq!(heap.pop(), Some(TotalF64(3.0)));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TotalF64(pub f64);

impl Ord for TotalF64 {
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for TotalF64 {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for TotalF64 {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for TotalF64 {}
