//! Parameters and results of queries.

use glam::DVec3;

use crate::error::CcdError;

/// Parameters of continuous collision detection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CcdParams {
    /// Euclidean distance \[length unit of the points\] that counts as contact, `>= 0`.
    ///
    /// With 0 the primitives must meet. No closer approach is missed. One that stays farther than
    /// this by 1e-9 of it, and by more than rounding, is reported only where
    /// [`CcdParams::max_directions`] are used up.
    pub min_separation: f64,
    /// Last time of interest, in `0.0..=1.0` of the step: later contacts may be left out.
    pub t_max: f64,
    /// Maximum number of directions tried in an interval of time in which the cubic excludes
    /// nothing: coplanar motion, parallel edges, a minimum separation.
    ///
    /// Where they are used up, the contact is reported as possible, or early. A few suffice for
    /// most motion. With a separation that is kept by 1e-9 of itself it takes some tens, and
    /// hundreds for edges that sweep over each other nearly parallel. Each costs about 0.15 µs.
    pub max_directions: u32,
    /// Policy for contacts that rounding cannot distinguish from a near miss.
    pub undecided: Undecided,
}

impl CcdParams {
    /// Contact without separation during the whole step, decided conservatively.
    pub const DEFAULT: Self =
        Self { min_separation: 0.0, t_max: 1.0, max_directions: 400, undecided: Undecided::Report };

    /// [`CcdParams::DEFAULT`], but exact arithmetic decides what rounding leaves open.
    #[cfg(feature = "exact")]
    pub const EXACT: Self = Self { undecided: Undecided::DecideExactly, ..Self::DEFAULT };

    /// Checks that all values are in range.
    ///
    /// # Errors
    ///
    /// [`CcdError::MinSeparation`] and [`CcdError::TimeMax`].
    pub fn validate(&self) -> Result<(), CcdError> {
        if !(self.min_separation >= 0.0 && self.min_separation.is_finite()) {
            return Err(CcdError::MinSeparation(self.min_separation));
        }
        if !(0.0..=1.0).contains(&self.t_max) {
            return Err(CcdError::TimeMax(self.t_max));
        }
        Ok(())
    }
}

impl Default for CcdParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Policy for contacts that rounding cannot distinguish from a near miss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Undecided {
    /// Report the contact as [`Certainty::Possible`].
    Report,
    /// Decide in exact arithmetic, which takes tens of microseconds, and up to some milliseconds
    /// for coordinates whose exponents differ by hundreds.
    ///
    /// Every query without a minimum separation is decided. With one, the contact is still
    /// reported as possible.
    #[cfg(feature = "exact")]
    DecideExactly,
}

/// Certainty of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Certainty {
    /// The primitives do meet, for the first time between `lo` and `hi`.
    Certain,
    /// The primitives do not meet before `lo`. From there to `hi` they come within rounding of it
    /// and may or may not meet; times after `hi` were not examined.
    Possible,
}

/// Contact of two moving primitives.
///
/// The fields satisfy, for the points `x_i` of the query at a time between `lo` and `hi`,
/// `|sum weights_i x_i| <= min_separation`, up to rounding and 1e-6 of the separation. Points of a
/// [`Certainty::Possible`] contact may be farther apart where [`CcdParams::max_directions`] are used
/// up.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CcdContact {
    /// Start of the interval of the contact, in `0.0..=1.0` of the step.
    ///
    /// It is never after the first contact, whatever [`CcdContact::certainty`] is.
    pub lo: f64,
    /// End of the interval, `>= lo`.
    pub hi: f64,
    /// Certainty of the contact.
    pub certainty: Certainty,
    /// True if the contact may already be there at the start of the step. If false, the primitives
    /// are certainly apart at time 0.
    pub at_start: bool,
    /// Weights of the four points, which sum to zero.
    ///
    /// They form the point on the second primitive (the face, the second edge) minus that on the
    /// first (the vertex, whose weight is -1, or the first edge).
    pub weights: [f64; 4],
    /// Unit normal from the second primitive to the first as they were before the contact: the
    /// direction in which to hold back the first one.
    pub normal: DVec3,
}

impl CcdContact {
    /// Returns true if the contact is proven.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.certainty == Certainty::Certain
    }
}
