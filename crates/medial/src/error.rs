//! Errors of medial surfaces: of their balls, of the surfaces they are generated from, and of
//! queries.

use surface::progress::Interrupted;
use surface::{Finding, SurfaceError};

/// Failure to build, read, generate, move or query a medial surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MedialError {
    /// A center that is not finite, or a radius that is not finite or negative.
    #[error("ball {ball} at ({x}, {y}, {z}) has radius {radius}: it must be finite and at least 0")]
    InvalidBall {
        /// The first such ball.
        ball: usize,
        /// First coordinate of its center, as given.
        x: f64,
        /// Second coordinate of its center, as given.
        y: f64,
        /// Third coordinate of its center, as given.
        z: f64,
        /// Its radius, as given.
        radius: f64,
    },
    /// A cone or slab that refers to a ball that does not exist.
    #[error("{kind} {index} refers to ball {ball}, but there are {balls} balls")]
    BallOutOfRange {
        /// `"cone"` or `"slab"`.
        kind: &'static str,
        /// Its place in its list.
        index: usize,
        /// The number that it holds.
        ball: u32,
        /// Number of balls.
        balls: usize,
    },
    /// A cone or slab that uses a ball twice.
    #[error("{kind} {index} uses ball {ball} more than once")]
    RepeatedBall {
        /// `"cone"` or `"slab"`.
        kind: &'static str,
        /// Its place in its list.
        index: usize,
        /// The ball that it repeats.
        ball: u32,
    },
    /// No balls, and so no volume.
    #[error("a medial surface needs at least one ball")]
    Empty,
    /// More balls or primitives than 32-bit numbers distinguish, or a grid that is too fine.
    #[error("{count} {kind} are more than the limit of {limit}")]
    TooMany {
        /// Kind of elements, in the plural.
        kind: &'static str,
        /// Number of elements.
        count: usize,
        /// Largest possible number.
        limit: usize,
    },
    /// A list of another length than one entry per ball.
    #[error("there are {expected} balls, but {got} values were given")]
    BallCount {
        /// Number of balls of the medial surface.
        expected: usize,
        /// Number of values given.
        got: usize,
    },
    /// Links to another number of primitives than those of the medial surface.
    #[error("there are links to {expected} primitives, but the medial surface has {got}")]
    PrimitiveCount {
        /// Number of primitives that the links were made for.
        expected: usize,
        /// Number of primitives given.
        got: usize,
    },
    /// A line of text that does not follow the format.
    #[error("line {line}: {reason}")]
    Text {
        /// Number of the line, from 1.
        line: usize,
        /// The fault.
        reason: &'static str,
    },
    /// A parameter outside its range.
    #[error("{name} is {value}, but must be {range}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value as given.
        value: f64,
        /// Accepted values, in words.
        range: &'static str,
    },
    /// Bounds that cannot be stored, or a tree of other balls.
    #[error(transparent)]
    Tree(#[from] kdop::TreeError),
    /// A surface without an inside, or positions that do not fit it.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A surface whose faces point inward.
    #[error("the surface is inside out: its signed volume is {volume}")]
    InsideOut {
        /// The signed volume, in cubed length units.
        volume: f64,
    },
    /// A surface of several parts, each of which needs a medial surface of its own.
    #[error("the surface has {components} parts that are not connected")]
    Disconnected {
        /// Number of parts.
        components: usize,
    },
    /// Vertices without a face, at which no ball touches the surface, or faces that repeat a vertex,
    /// which have no normal.
    #[error("the surface has {0}: remove what bounds no volume")]
    Defect(Finding),
    /// A surface that crosses itself, so that its inside is not defined.
    #[error("{count} pairs of faces cross each other, the first are faces {first} and {second}")]
    SelfCrossing {
        /// Number of pairs of faces that cross.
        count: usize,
        /// First face of the first pair.
        first: u32,
        /// Second face of the first pair.
        second: u32,
    },
    /// A surface that is thinner than its faces are wide, so that its vertices do not show where
    /// its middle is.
    #[error(
        "the surface is too thin for its faces: half of its maximal balls have a diameter of at most {thickness}, with a mean edge of {edge}: refine it"
    )]
    TooThin {
        /// Median diameter of the maximal balls.
        thickness: f64,
        /// Mean length of the surface's edges.
        edge: f64,
    },
    /// More balls than the surface has vertices.
    #[error("{requested} balls were requested, but the surface has {vertices} vertices")]
    TooManyBalls {
        /// Number of balls requested.
        requested: usize,
        /// Number of vertices of the surface.
        vertices: usize,
    },
    /// A tolerance that no number of balls meets.
    #[error("the tolerance {tolerance} was not reached: {balls} balls deviate by {reached}")]
    ToleranceNotReached {
        /// The tolerance requested.
        tolerance: f64,
        /// Smallest bound of the deviation.
        reached: f64,
        /// Number of balls with that bound.
        balls: usize,
    },
    /// A distance that is unknown at the center of a ball that may be in contact.
    #[error(
        "a ball may touch the rigid body, whose distance is known up to {known}, but {needed} is needed: build its field with more padding and without truncation"
    )]
    DistanceRange {
        /// Lower bound of the distance at the center of the ball.
        known: f64,
        /// Distance that has to be available.
        needed: f64,
    },
    /// The caller interrupted the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
