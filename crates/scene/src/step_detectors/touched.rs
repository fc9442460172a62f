//! Vertices that touched before in the same step.
//!
//! A step detects contacts again after each correction of positions. A vertex that was pushed out
//! may then be none that can touch next, as those beside a contact are not. Without its contact the
//! next correction would push it in again, and so on to and fro. So vertices that touched once stay
//! in contact until the step ends.

use crate::PairId;

/// Vertex of a pair, by its particle.
type PairVertex = (PairId, u32);

/// Vertices that touched in the detections of a step.
#[derive(Debug, Default)]
pub(super) struct TouchedVertices {
    /// Of the detections before the present one, ascending.
    before: Vec<PairVertex>,
    /// Of the present one.
    present: Vec<PairVertex>,
}

impl TouchedVertices {
    /// Forgets all vertices: a step begins.
    pub(super) fn clear(&mut self) {
        self.before.clear();
        self.present.clear();
    }

    /// Begins another detection of the same step.
    pub(super) fn begin_detection(&mut self) {
        self.before.append(&mut self.present);
        self.before.sort_unstable();
        self.before.dedup();
    }

    /// Adds a vertex that touches.
    pub(super) fn add(&mut self, pair: PairId, particle: u32) {
        self.present.push((pair, particle));
    }

    /// Returns true if a vertex touched in an earlier detection.
    pub(super) fn contains(&self, pair: PairId, particle: u32) -> bool {
        self.before.binary_search(&(pair, particle)).is_ok()
    }
}
