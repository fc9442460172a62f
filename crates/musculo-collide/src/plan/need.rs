//! What is asked of a plan.

use std::time::Duration;

use crate::PlanError;

/// What a scene is needed for. Lengths are in the scene's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Need {
    /// How wrong the gap of a contact may be, `> 0`.
    pub tolerance: f64,
    /// How far outside contact is still reported, `>= 0`.
    pub reach: f64,
    /// How far any vertex may go from where it is now while the plan serves,
    /// `>= 0`. Pairs that cannot come within reach by that are left out; with
    /// infinity, none is.
    pub travel: f64,
    /// Whether it matters what bodies meet between two states. If so, the pairs
    /// are also [swept](crate::Plan::sweep), with every vertex they have.
    pub swept: bool,
    /// Time that one frame of detection may take. A plan that would take longer
    /// is replaced by a coarser one, which says what tolerance it serves.
    pub budget: Option<Duration>,
}

impl Need {
    /// Contacts of what overlaps, wherever bodies go, within a tolerance.
    #[must_use]
    pub fn within(tolerance: f64) -> Self {
        Self { tolerance, reach: 0.0, travel: f64::INFINITY, swept: false, budget: None }
    }

    /// # Errors
    ///
    /// [`PlanError::Need`] for the first value out of its range.
    pub(super) fn check(&self) -> Result<(), PlanError> {
        let refuse = |name, value| Err(PlanError::Need { name, value });
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            return refuse("tolerance", self.tolerance);
        }
        if !(self.reach.is_finite() && self.reach >= 0.0) {
            return refuse("reach", self.reach);
        }
        if self.travel.is_nan() || self.travel < 0.0 {
            return refuse("travel", self.travel);
        }
        Ok(())
    }
}
