//! Result of one frame of detection by a plan.

use std::ops::Range;

use scene::{BodyId, PairId};
use surface::Contact;

/// Result of one frame; its memory is reused for the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detection {
    contacts: Vec<Contact>,
    pairs: Vec<PairDetection>,
    pub(crate) out_of_range: Vec<BodyId>,
}

/// Result for one pair of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct PairDetection {
    /// The two bodies.
    pub pair: PairId,
    /// True if they overlap, within the error of the pair.
    pub overlaps: bool,
    /// Depth of the deepest vertex of either body, `>= 0`; 0 where none is inside. With a field, all
    /// vertices of both count; with surfaces, those that reduced surfaces have kept.
    pub max_depth: f64,
    /// Smallest gap of a vertex's contact; `None` where no vertex is in contact.
    pub min_gap: Option<f64>,
    /// Range of the pair's contacts among all contacts.
    pub contacts: Range<usize>,
}

impl Detection {
    /// Returns all contacts, pair after pair, with particles numbered by
    /// [`Body::particles`](scene::Body::particles). Rigid bodies are anchors, at rest.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Returns the pairs that have contacts or overlap: those of the plan in the order of the
    /// bodies, then the others that came near, likewise.
    #[must_use]
    pub fn pairs(&self) -> &[PairDetection] {
        &self.pairs
    }

    /// Returns the bodies that moved farther than the plan has prepared for. Their pairs that are
    /// not in the plan are detected by the surfaces of both bodies, without error.
    #[must_use]
    pub fn out_of_range(&self) -> &[BodyId] {
        &self.out_of_range
    }

    pub(crate) fn clear(&mut self) {
        self.contacts.clear();
        self.pairs.clear();
        self.out_of_range.clear();
    }

    /// Adds the result of a pair, if it has contacts or overlaps.
    pub(crate) fn add(
        &mut self,
        pair: PairId,
        overlaps: bool,
        min_gap: Option<f64>,
        contacts: &[Contact],
    ) {
        if contacts.is_empty() && !overlaps {
            return;
        }
        let start = self.contacts.len();
        self.contacts.extend_from_slice(contacts);
        self.pairs.push(PairDetection {
            pair,
            overlaps,
            max_depth: min_gap.map_or(0.0, |gap| (-gap).max(0.0)),
            min_gap,
            contacts: start..self.contacts.len(),
        });
    }
}
