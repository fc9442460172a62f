//! Why a query cannot be answered.

/// Input that no query accepts, and where it is.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CcdError {
    /// A coordinate is infinite or not a number.
    #[error("point {point} at {end} of the step is not finite: {value}")]
    NotFinite {
        /// Which point: its place in the query, or in the positions of a batch.
        point: usize,
        /// Whether it is a position at the start or at the end.
        end: StepEnd,
        /// The first coordinate that is not finite.
        value: f64,
    },
    /// A minimum separation is negative or not finite.
    #[error("minimum separation {0} is not a finite length of at least 0")]
    MinSeparation(f64),
    /// The last time asked for is not within the step.
    #[error("t_max {0} is not in 0..=1")]
    TimeMax(f64),
    /// Positions at the start and the end of a step differ in number.
    #[error("{start} positions at the start of the step, but {end} at its end")]
    PositionCount {
        /// Positions at the start.
        start: usize,
        /// Positions at the end.
        end: usize,
    },
    /// A candidate names a point that does not exist.
    #[error("candidate {candidate} refers to point {point}, but there are {count} points")]
    PointOutOfRange {
        /// Place of the candidate in its list.
        candidate: usize,
        /// The index it holds.
        point: u32,
        /// Points there are.
        count: usize,
    },
}

/// One end of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepEnd {
    /// Time 0.
    Start,
    /// Time 1.
    Finish,
}

impl std::fmt::Display for StepEnd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Start => "the start",
            Self::Finish => "the end",
        })
    }
}
