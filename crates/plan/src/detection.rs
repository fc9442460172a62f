//! Result of one frame of detection by a plan.

use std::ops::Range;

use scene::{BodyId, DepthBracket, PairId};
use surface::Contact;

use crate::DetectionMethod;

/// Result of one frame; its memory is reused for the next.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Detection {
    contacts: Vec<Contact>,
    pairs: Vec<PairDetection>,
    pub(crate) left_out: Vec<LeftOutPair>,
    pub(crate) out_of_range: Vec<BodyId>,
}

/// Result for one pair of bodies.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PairDetection {
    /// The two bodies.
    pub pair: PairId,
    /// Method of this frame: that of the plan, or [`DetectionMethod::Exact`] where the coarser
    /// surfaces of both bodies, or the only one, were deformed beyond the tolerance. One alone is
    /// replaced by the body's own surface.
    pub method: DetectionMethod,
    /// Overlap, as far as the method decides it.
    pub state: PairState,
    /// Depth that the method found, `>= 0`: that of the deepest point of either surface, faces and
    /// edges included. It differs from that of the bodies' own surfaces by no more than the
    /// [bound](crate::PairPlan::accuracy) of the pair; by balls, by no more than the upper end of `depth`.
    pub max_depth: f64,
    /// Certified bracket on the depth of the bodies' own surfaces, up to twice as wide as the bound.
    pub depth: DepthBracket,
    /// Smallest gap of a vertex's contact; `None` where no vertex is in contact.
    pub min_gap: Option<f64>,
    /// Range of the pair's contacts among all contacts.
    pub contacts: Range<usize>,
}

/// Overlap of a pair, as far as a method decides it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum PairState {
    /// The bodies overlap by no more than the tolerance, or not at all.
    Apart,
    /// The bodies overlap, as they are compared.
    Overlapping,
    /// The method found no overlap, and cannot exclude one that is deeper than the tolerance.
    Undecided {
        /// Proved bound on the depth of the overlap.
        upper: f64,
    },
}

/// Pair that a budget has left out of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LeftOutPair {
    /// The two bodies.
    pub pair: PairId,
    /// Proved bound on the depth of their overlap: the last one, and the displacements of both
    /// bodies since.
    pub upper: f64,
}

impl PairDetection {
    /// Returns true if the bodies overlap, as they are compared.
    #[must_use]
    pub fn is_overlapping(&self) -> bool {
        self.state == PairState::Overlapping
    }
}

impl Detection {
    /// Returns all contacts, pair after pair, with particles numbered by
    /// [`Body::particles`](scene::Body::particles). Rigid bodies are anchors, at rest.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Returns the pairs that have contacts, overlap or are undecided: those of the plan in the
    /// order of the bodies, then the others that came near, likewise.
    #[must_use]
    pub fn pairs(&self) -> &[PairDetection] {
        &self.pairs
    }

    /// Returns the result of a pair; `None` where it is apart without contacts, or left out.
    #[must_use]
    pub fn pair(&self, pair: PairId) -> Option<&PairDetection> {
        self.pairs.iter().find(|found| found.pair == pair)
    }

    /// Returns the pairs that a [budget](crate::FrameBudget) has left out, deepest bound first.
    #[must_use]
    pub fn left_out(&self) -> &[LeftOutPair] {
        &self.left_out
    }

    /// Returns the bodies that moved farther than the plan has prepared for. Their pairs that are
    /// not in the plan are detected by the surfaces of both bodies, exactly.
    #[must_use]
    pub fn out_of_range(&self) -> &[BodyId] {
        &self.out_of_range
    }

    pub(crate) fn clear(&mut self) {
        self.contacts.clear();
        self.pairs.clear();
        self.left_out.clear();
        self.out_of_range.clear();
    }

    /// Adds the result of a pair, unless it is apart without contacts.
    pub(crate) fn add(&mut self, found: &PairDetection, contacts: &[Contact]) {
        if contacts.is_empty() && found.state == PairState::Apart {
            return;
        }
        let start = self.contacts.len();
        self.contacts.extend_from_slice(contacts);
        self.pairs.push(PairDetection { contacts: start..self.contacts.len(), ..found.clone() });
    }
}
