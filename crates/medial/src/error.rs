//! Why balls are not a medial surface, or a surface cannot be given one.

use surface::SurfaceError;

/// What is wrong with a medial surface, its text, or the surface that one was
/// asked for, and where.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MedialError {
    /// A ball's center is not finite, or its radius not finite or negative.
    #[error("ball {ball} at ({x}, {y}, {z}) with radius {radius} is not a ball")]
    NotABall {
        /// The first such ball.
        ball: usize,
        /// Its center's first coordinate, as given.
        x: f64,
        /// Its center's second coordinate, as given.
        y: f64,
        /// Its center's third coordinate, as given.
        z: f64,
        /// Its radius, as given.
        radius: f64,
    },
    /// A cone or slab refers to a ball that does not exist.
    #[error("{what} {index} refers to ball {ball}, but there are {balls} balls")]
    BallOutOfRange {
        /// `"cone"` or `"slab"`.
        what: &'static str,
        /// Its place in its list.
        index: usize,
        /// The number it holds.
        ball: u32,
        /// How many balls there are.
        balls: usize,
    },
    /// A cone or slab uses one ball twice.
    #[error("{what} {index} uses ball {ball} more than once")]
    RepeatedBall {
        /// `"cone"` or `"slab"`.
        what: &'static str,
        /// Its place in its list.
        index: usize,
        /// The ball it repeats.
        ball: u32,
    },
    /// There are no balls, so there is no volume.
    #[error("a medial surface needs at least one ball")]
    Empty,
    /// More balls or primitives than 32-bit numbers can tell apart.
    #[error("{count} {what} are more than the {limit} that can be numbered")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many were given.
        count: usize,
        /// How many are possible.
        limit: usize,
    },
    /// A list that holds one entry a ball is of another length.
    #[error("there are {expected} balls, but {got} values were given")]
    BallCount {
        /// Balls of the medial surface.
        expected: usize,
        /// Values given.
        got: usize,
    },
    /// A line of a medial surface's text is not what it should be.
    #[error("line {line}: {reason}")]
    Text {
        /// Number of the line, from 1.
        line: usize,
        /// What was expected there.
        reason: &'static str,
    },
    /// A parameter is outside its range.
    #[error("{name} is {value}, but must be {range}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A tree over it cannot be built or refitted.
    #[error(transparent)]
    Tree(#[from] kdop::TreeError),
    /// The surface has no inside, or its positions are wrong.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The surface's faces point inwards.
    #[error("the surface is inside out: its signed volume is {volume}")]
    InsideOut {
        /// The signed volume, in cubed length units.
        volume: f64,
    },
    /// The surface has several parts; each needs a medial surface of its own.
    #[error("the surface has {components} parts that are not connected")]
    Disconnected {
        /// How many parts it has.
        components: usize,
    },
    /// Faces of the surface cross each other, so its inside is not defined.
    #[error("{count} pairs of faces cross each other, the first are faces {first} and {second}")]
    SelfCrossing {
        /// Pairs of faces that cross.
        count: usize,
        /// The first face of the first pair.
        first: u32,
        /// Its second face.
        second: u32,
    },
    /// The surface is thinner than its faces are wide, so its vertices do not
    /// show where its middle is.
    #[error(
        "the surface is too thin for its faces: half of its maximal balls are no more than {thickness} across, while its edges are {edge} long on average"
    )]
    TooThin {
        /// Median diameter of the maximal balls.
        thickness: f64,
        /// Mean length of the surface's edges.
        edge: f64,
    },
    /// More balls were asked for than the surface has vertices.
    #[error("{asked} balls were asked for, but the surface has {vertices} vertices")]
    TooManyBalls {
        /// Balls asked for.
        asked: usize,
        /// Vertices of the surface.
        vertices: usize,
    },
    /// No number of balls that was tried comes within the tolerance.
    #[error("the tolerance {tolerance} was not reached: {balls} balls deviate by {reached}")]
    ToleranceNotReached {
        /// The tolerance asked for.
        tolerance: f64,
        /// The least deviation bound reached.
        reached: f64,
        /// Balls it took.
        balls: usize,
    },
}
