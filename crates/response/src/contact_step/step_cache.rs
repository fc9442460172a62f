//! Warm starting across steps of different lengths.

use crate::{ContactSet, Impulse, ImpulseCache, ResponseError, SolveLevel, StepLength};

/// Impulses of the last step that solved for them, with its length: the steps between may have
/// solved for nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct StepCache {
    impulses: ImpulseCache,
    /// Length of that step.
    length: Option<StepLength>,
}

impl StepCache {
    /// Replaces `start` by impulses for `contacts` to start from in a step of length `h`.
    pub(super) fn warm_start(
        &mut self,
        contacts: &ContactSet,
        h: StepLength,
        start: &mut Vec<Impulse>,
    ) {
        let ratio = self.length.map_or(1.0, |length| h.get() / length.get());
        self.impulses.warm_start(contacts, SolveLevel::Velocity.impulse_scale(ratio), start);
    }

    /// Replaces the stored impulses by those of a step of length `h`.
    pub(super) fn store(
        &mut self,
        contacts: &ContactSet,
        h: StepLength,
        impulses: &[Impulse],
    ) -> Result<(), ResponseError> {
        self.length = Some(h);
        self.impulses.store(contacts, impulses)
    }

    /// Removes all impulses.
    pub(super) fn clear(&mut self) {
        self.impulses.clear();
    }
}
