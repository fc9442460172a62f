//! Settings of a contact step.

use crate::{ResponseError, SolverParams, StepLength, SweepOrder, check};

/// Settings of a contact step. A tolerance of `None` leaves its correction out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepParams {
    /// Length of the move that follows.
    pub h: StepLength,
    /// Depth \[length\] up to which positions are not corrected, `>= 0`.
    pub depth_tolerance: Option<f64>,
    /// Speed of approach \[length / time\] up to which velocities are not corrected,
    /// `>= 0`.
    pub approach_tolerance: Option<f64>,
    /// Acceleration of approach \[length / time²\] up to which accelerations or forces are
    /// not corrected, `>= 0`: beyond the tolerance of approach, the speed of approach after
    /// the move may be as much times h.
    pub push_tolerance: Option<f64>,
    /// Settings of the solver.
    pub solver: SolverParams,
    /// Order of the rows in a sweep.
    pub order: SweepOrder,
    /// Maximum number of corrections of positions, with contacts detected anew after each.
    pub max_rounds: u32,
}

impl StepParams {
    /// Returns settings that correct all positions, in up to four rounds, and velocities.
    #[must_use]
    pub fn new(h: StepLength) -> Self {
        Self {
            h,
            depth_tolerance: Some(0.0),
            approach_tolerance: Some(0.0),
            push_tolerance: None,
            solver: SolverParams::default(),
            order: SweepOrder::default(),
            max_rounds: 4,
        }
    }

    /// Checks that no tolerance is negative or not finite.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] with the first such tolerance.
    pub fn validate(&self) -> Result<(), ResponseError> {
        check::not_negative("depth tolerance", self.depth_tolerance.unwrap_or(0.0))?;
        check::not_negative("approach tolerance", self.approach_tolerance.unwrap_or(0.0))?;
        check::not_negative("push tolerance", self.push_tolerance.unwrap_or(0.0))?;
        check::not_negative("tolerance", self.solver.tolerance)?;
        Ok(())
    }
}
