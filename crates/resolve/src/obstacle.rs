//! Reasons why pairs still overlap.

/// Reason why a pair still overlaps.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Obstacle {
    /// Neither body may move.
    #[error("both are rigid, and neither moves")]
    BothRigid,
    /// Rounds no longer improved anything.
    #[error("no push improved it any more: there is no room to yield, or too far at once")]
    Stuck,
    /// The maximum number of rounds was reached while rounds still improved.
    #[error("the maximum number of rounds was reached: more may separate them")]
    Rounds,
    /// A soft body is between two rigid ones that leave it less room than it is thick, and no better state
    /// was found within its limits.
    #[error("no room: rigid bodies leave {room:.3e}, the body is {thickness:.3e} thick")]
    Squeezed {
        /// Distance between the two rigid bodies there; 0 where they overlap.
        room: f64,
        /// Thickness of the soft body there, at the start.
        thickness: f64,
    },
    /// Two soft bodies lie on each other between rigid ones that leave them less room than both are thick, and no better
    /// state was found within their limits.
    #[error(
        "no room: rigid bodies leave {room:.3e}, both bodies together are {thickness:.3e} thick"
    )]
    SqueezedTogether {
        /// Distance between the two rigid bodies through the place where the soft ones are deepest in each other.
        room: f64,
        /// Thicknesses of the soft bodies there, at the start, together.
        thickness: f64,
    },
    /// Every state that is better leaves the limits of a body, of which
    /// [`Resolution::broken_limits`](crate::Resolution::broken_limits) tells how.
    #[error("separating them further breaks the limits of a body")]
    Limits,
    /// One body is wholly inside the other.
    #[error("one is wholly inside the other: ignore the pair, or take one out")]
    Enclosed,
    /// A body without an inside crosses the other: it has no side to be pushed to, or no room on that side.
    #[error(
        "a surface without an inside is pierced: there is no side to push it to, or no room there"
    )]
    Pierced,
    /// No face crosses another, and no vertex is inside: the surfaces share a volume where they
    /// coincide.
    #[error("the surfaces coincide: there is no side to push them to; take one out, or move it")]
    Coincident,
    /// A body covers a place more than once, since it crosses itself or has parts in each other: what is inside it by the
    /// volume is outside by the parity of crossings.
    #[error(
        "a body covers a place more than once, which has no side to be pushed to: join its parts, or take one out"
    )]
    CoversTwice,
    /// Most of the vertices of one body were within the tolerance of the other one's surface at the start,
    /// on faces that look the same way.
    #[error(
        "the surfaces nearly coincide: there is no side to push them to; take one out, or move it"
    )]
    NearlyCoincident,
    /// Tied surfaces cross beside tied vertices, where they bend and their meshes differ.
    #[error("tied surfaces of meshes that differ cross where they bend")]
    Tied,
    /// Surfaces that came apart cross at positions that are rounded to the precision of the file.
    #[error("rounding to the precision of the file makes them cross: save it in double precision")]
    Rounding,
}

impl Obstacle {
    /// Returns true if rigid bodies leave less room than what is between them is thick.
    pub(crate) fn is_of_room(self) -> bool {
        matches!(self, Self::Squeezed { .. } | Self::SqueezedTogether { .. })
    }

    /// Returns true if no push has a side to take a pair to.
    pub(crate) fn is_sideless(self) -> bool {
        matches!(self, Self::Enclosed | Self::Pierced | Self::NearlyCoincident)
    }
}
