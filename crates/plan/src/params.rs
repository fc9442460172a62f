//! Parameters of a plan.

use response::{ParameterError, not_negative, parameter, positive};
use scene::PairId;

use crate::DetectionMethod;
use crate::cost::count;

/// Parameters of a [`Plan`](crate::Plan). Lengths are in the scene's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlanParams {
    /// Largest accepted error of a depth or of a contact's gap, `> 0` and above the rounding of distances
    /// between the bodies: the bound of each pair's method is proved to be within it.
    pub tolerance: f64,
    /// Largest gap that is still reported as a contact, `>= 0`.
    pub margin: f64,
    /// Largest displacement of any vertex from its present position that the plan prepares for,
    /// `>= 0`.
    ///
    /// Pairs that may come within the margin by such displacements are planned. Any other pair is
    /// detected by the surfaces of both bodies once it comes near, its depth within the tolerance,
    /// at a higher cost. With infinity, every pair is planned: their number grows with the square of
    /// the bodies.
    pub max_displacement: f64,
    /// Number of frames that the plan will serve, `>= 1`. A structure is built where it saves more
    /// than it costs over so many frames; for one frame hardly anything is.
    pub frames: u32,
    /// Time of an operation over its time on the
    /// [reference machine](crate::OperationCounts::SECONDS), `> 0`. It scales all predicted times
    /// alike, and so changes no choice. [`machine_factor`] measures it.
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
    /// Returns the parameters of a plan with this tolerance for one frame, which prepares for the
    /// pairs that are in contact now.
    #[must_use]
    pub const fn with_tolerance(tolerance: f64) -> Self {
        Self {
            tolerance,
            margin: 0.0,
            max_displacement: 0.0,
            frames: 1,
            machine_factor: 1.0,
            threads: 1,
        }
    }

    /// Checks that all parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] for the first one that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        positive("tolerance", self.tolerance)?;
        not_negative("margin", self.margin)?;
        let (name, value) = ("max_displacement", self.max_displacement);
        if value.is_nan() || value < 0.0 {
            return Err(ParameterError { name, value, range: "at least 0" });
        }
        positive("machine_factor", self.machine_factor)?;
        parameter("frames", f64::from(self.frames), "at least 1", self.frames > 0)?;
        parameter("threads", count(self.threads), "at least 1", self.threads > 0)?;
        Ok(())
    }
}
