//! Parameters of a plan.

use std::time::Duration;

use scene::PairId;

use crate::cost::count;
use crate::{DetectionMethod, PlanError};

/// Parameters of a [`Plan`](crate::Plan). Lengths are in the scene's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlanParams {
    /// Largest accepted error of a contact's gap, `> 0`.
    pub tolerance: f64,
    /// Largest gap that is still reported as a contact, `>= 0`.
    pub margin: f64,
    /// Largest displacement of any vertex from its present position that the plan prepares for,
    /// `>= 0`.
    ///
    /// Pairs that may come within the margin by such displacements are planned. Any other pair is
    /// detected by the surfaces of both bodies once it comes near, without error and at a higher
    /// cost. With infinity, every pair is planned: their number grows with the square of the
    /// bodies.
    pub max_displacement: f64,
    /// Largest accepted time of a detection frame. A plan that is predicted to take longer is
    /// replaced by a coarser one, with a larger [tolerance](crate::Plan::tolerance).
    pub budget: Option<Duration>,
    /// Time of an operation over its time on the
    /// [reference machine](crate::OperationCounts::SECONDS), `> 0`. It scales all predicted times
    /// alike, and so changes a choice only under a budget. [`machine_factor`] measures it.
    ///
    /// [`machine_factor`]: crate::machine_factor()
    pub machine_factor: f64,
    /// Number of threads that share a frame, `>= 1`; divides the predicted time.
    pub threads: usize,
}

/// Method that the caller has chosen for a pair, whatever its error and cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ForcedMethod {
    /// The two bodies.
    pub pair: PairId,
    /// The method.
    pub method: DetectionMethod,
}

impl PlanParams {
    /// Returns the parameters of a plan with this tolerance, which prepares for the pairs that are
    /// in contact now.
    #[must_use]
    pub const fn with_tolerance(tolerance: f64) -> Self {
        Self {
            tolerance,
            margin: 0.0,
            max_displacement: 0.0,
            budget: None,
            machine_factor: 1.0,
            threads: 1,
        }
    }

    /// Checks that all parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// [`PlanError::Parameter`] for the first one that is not.
    pub fn validate(&self) -> Result<(), PlanError> {
        const POSITIVE: &str = "finite and above 0";
        let Self { tolerance, margin, max_displacement, machine_factor, threads, .. } = *self;
        let is_positive = |value: f64| value.is_finite() && value > 0.0;

        let ranges = [
            ("tolerance", tolerance, is_positive(tolerance), POSITIVE),
            ("margin", margin, margin == 0.0 || is_positive(margin), "finite and at least 0"),
            ("max_displacement", max_displacement, max_displacement >= 0.0, "at least 0"),
            ("machine_factor", machine_factor, is_positive(machine_factor), POSITIVE),
            ("threads", count(threads), threads > 0, "at least 1"),
        ];
        match ranges.into_iter().find(|&(_, _, is_valid, _)| !is_valid) {
            Some((name, value, _, range)) => Err(PlanError::Parameter { name, value, range }),
            None => Ok(()),
        }
    }
}
