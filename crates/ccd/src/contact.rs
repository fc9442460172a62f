//! What a query is asked, and what it answers.

use glam::DVec3;

use crate::error::CcdError;

/// How close is a contact, up to when, and how hard to try.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CcdParams {
    /// Euclidean distance \[length unit of the points\] that counts as contact,
    /// `>= 0`. With 0 the primitives must meet. Nothing that comes closer is
    /// missed; what stays further than this by 1e-9 of it, and by more than
    /// rounding, is reported only where [`CcdParams::max_directions`] are used up.
    pub min_separation: f64,
    /// Last time of interest, in `0.0..=1.0` of the step: contacts after it may
    /// be left out.
    pub t_max: f64,
    /// Directions tried, at most, in an interval of time in which the cubic
    /// says nothing: coplanar motion, parallel edges, a minimum separation.
    ///
    /// Where they are used up the contact is reported as possible, or early. A
    /// few suffice for most motion, and with a separation some tens where it is
    /// kept by 1e-9 of itself; what takes hundreds are edges that sweep over
    /// each other nearly parallel. Each costs about 0.15 us.
    pub max_directions: u32,
    /// What to do with a contact that rounding cannot tell from a near miss.
    pub undecided: Undecided,
}

impl CcdParams {
    /// Touching, during the whole step, conservatively.
    pub const DEFAULT: Self =
        Self { min_separation: 0.0, t_max: 1.0, max_directions: 400, undecided: Undecided::Report };

    /// As [`CcdParams::DEFAULT`], but what rounding leaves open is decided in
    /// exact arithmetic.
    #[cfg(feature = "exact")]
    pub const EXACT: Self = Self { undecided: Undecided::DecideExactly, ..Self::DEFAULT };

    /// Refuses values that mean nothing.
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

/// What to do with a contact that rounding cannot tell from a near miss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Undecided {
    /// Report it as [`Certainty::Possible`].
    Report,
    /// Decide it in exact arithmetic, which takes tens of microseconds. With a
    /// minimum separation, and for coordinates whose exponents are too far
    /// apart, it is reported all the same.
    #[cfg(feature = "exact")]
    DecideExactly,
}

/// How sure a contact is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Certainty {
    /// They do meet, and first so between `lo` and `hi`.
    Certain,
    /// They certainly do not meet before `lo`. From there to `hi` they come
    /// within rounding of it and may or may not; what follows `hi` was not
    /// looked at.
    Possible,
}

/// A contact of two moving primitives.
///
/// The fields satisfy, for the points `x_i` of the query at the time of contact,
/// `|sum weights_i x_i| <= min_separation`, up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CcdContact {
    /// Start of the interval of the contact, in `0.0..=1.0` of the step: never
    /// after the first contact, whatever [`CcdContact::certainty`] says.
    pub lo: f64,
    /// End of the interval, `>= lo`.
    pub hi: f64,
    /// Whether the contact is proven.
    pub certainty: Certainty,
    /// Whether the contact may already be there at the start of the step.
    /// When false, the primitives are certainly apart at time 0.
    pub at_start: bool,
    /// Weights of the four points, which sum to zero: of the point on the
    /// second primitive (the face, the second edge) minus that on the first
    /// (the vertex, whose weight is -1, or the first edge).
    pub weights: [f64; 4],
    /// Unit normal, from the second primitive to the first as they were before
    /// the contact: the direction in which the first one has to be held back.
    pub normal: DVec3,
}

impl CcdContact {
    /// Whether the contact is proven.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.certainty == Certainty::Certain
    }
}
