//! Errors of queries.

/// Input that a query rejects.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CcdError {
    /// A coordinate is infinite or not a number.
    #[error("point {point} at {end} of the step is not finite: {value}")]
    NotFinite {
        /// Position of the point in the query, or in the positions of a batch.
        point: usize,
        /// End of the step at which it is not finite.
        end: StepEnd,
        /// The first coordinate that is not finite.
        value: f64,
    },
    /// A minimum separation is negative or not finite.
    #[error("minimum separation {0} is not a finite length of at least 0")]
    MinSeparation(f64),
    /// The last time of interest is not within the step.
    #[error("t_max {0} is not in 0..=1")]
    TimeMax(f64),
    /// Positions at the start and the end of a step differ in number.
    #[error("{start} positions at the start of the step, but {end} at its end")]
    PositionCount {
        /// Number of positions at the start.
        start: usize,
        /// Number of positions at the end.
        end: usize,
    },
    /// A candidate refers to a point that does not exist.
    #[error("candidate {candidate} refers to point {point}, but there are {count} points")]
    PointOutOfRange {
        /// Position of the candidate in its list.
        candidate: usize,
        /// Index that the candidate holds.
        point: u32,
        /// Number of points.
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
