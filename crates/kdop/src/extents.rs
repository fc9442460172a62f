//! Geometry of a tree's points: at rest, swept over a step, or with radii.

use glam::DVec3;

use crate::directions::{is_monotone, norm, project};
use crate::error::TreeError;

/// Positions and radii of the numbered points of a tree.
///
/// Points and balls of leaf `k` are those that [`Leaves`](crate::Leaves) lists by number.
///
/// ```
/// use glam::DVec3;
/// use kdop::{Extents, Leaves, Tree};
///
/// // A cone: the convex hull of two balls.
/// let centers = [DVec3::ZERO, DVec3::X * 10.0];
/// let balls = Extents::Balls { centers: &centers, radii: &[1.0, 2.0] };
/// let tree = Tree::build_from(Leaves::Edges(&[[0, 1]]), balls)?;
///
/// assert_eq!(tree.root().interval(0), [-1.0, 12.0]);
/// # Ok::<(), kdop::TreeError>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Extents<'a> {
    /// Points at rest (|P|).
    Points(&'a [DVec3]),
    /// Points that move on straight lines from `start` to `end` (|P| each).
    Swept {
        /// Positions at the start of the step.
        start: &'a [DVec3],
        /// Positions at its end.
        end: &'a [DVec3],
    },
    /// Balls (|P|).
    Balls {
        /// Centers (|P|).
        centers: &'a [DVec3],
        /// Radii (|P|, `>= 0`).
        radii: &'a [f64],
    },
}

impl<'a> Extents<'a> {
    /// Returns the number of points or balls.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::Points(points) => points.len(),
            Self::Swept { start, .. } => start.len(),
            Self::Balls { centers, .. } => centers.len(),
        }
    }

    /// Returns true if there are no points.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Checks lengths, coordinates and radii.
    pub(crate) fn validate(&self) -> Result<(), TreeError> {
        match *self {
            Self::Points(points) => check_finite(points),
            Self::Swept { start, end } => {
                check_length(end.len(), start.len())?;
                check_finite(start)?;
                check_finite(end)
            }
            Self::Balls { centers, radii } => {
                check_finite(centers)?;
                check_length(radii.len(), centers.len())?;
                check_radii(radii)
            }
        }
    }

    /// Returns the points whose projections are the bounds, with no rounding to allow for.
    pub(crate) const fn exact_points<const S: usize>(&self) -> Option<&'a [DVec3]> {
        match *self {
            Self::Points(points) if is_monotone::<S>() => Some(points),
            _ => None,
        }
    }

    /// Calls `write` with the bounds of every point in turn.
    pub(crate) fn for_each<const S: usize>(&self, mut write: impl FnMut(Intervals<S>)) {
        match *self {
            Self::Points(points) => points.iter().for_each(|&p| write(Intervals::ball(p, 0.0))),
            Self::Swept { start, end } => {
                for (&p, &q) in start.iter().zip(end) {
                    write(Intervals::ball(p, 0.0).union(Intervals::ball(q, 0.0)));
                }
            }
            Self::Balls { centers, radii } => {
                for (&center, &radius) in centers.iter().zip(radii) {
                    write(Intervals::ball(center, radius));
                }
            }
        }
    }
}

/// Extent along each of `S` directions, before it is rounded to f32.
pub(crate) struct Intervals<const S: usize> {
    pub(crate) lower: [f64; S],
    pub(crate) upper: [f64; S],
}

impl<const S: usize> Intervals<S> {
    /// Bounds a ball by `n·c ± r‖n‖`, widened by the rounding of f64 where more than one
    /// operation rounds.
    fn ball(center: DVec3, radius: f64) -> Self {
        // A single rounding is monotone, so the projection of a point is its own bound.
        let at: [f64; S] = project(center);
        if is_monotone::<S>() && radius == 0.0 {
            return Self { lower: at, upper: at };
        }

        let slack = rounding_slack(center);
        let extent: [f64; S] = std::array::from_fn(|k| ball_extent(radius, norm::<S>(k), slack));
        Self {
            lower: std::array::from_fn(|k| at[k] - extent[k]),
            upper: std::array::from_fn(|k| at[k] + extent[k]),
        }
    }

    fn union(self, other: Self) -> Self {
        Self {
            lower: std::array::from_fn(|k| self.lower[k].min(other.lower[k])),
            upper: std::array::from_fn(|k| self.upper[k].max(other.upper[k])),
        }
    }
}

/// Returns more than the rounding error of a projection and of one addition to it.
///
/// Three roundings of at most half an ulp of `|x| + |y| + |z|` each are below
/// `2 ε (|x| + |y| + |z|)`; twice that also covers the summation of the absolute values.
fn rounding_slack(p: DVec3) -> f64 {
    let p = p.abs();
    4.0 * f64::EPSILON * (p.x + p.y + p.z)
}

/// Returns `r‖n‖` plus the slack, rounded up; finite, so that no difference of infinities arises.
fn ball_extent(radius: f64, norm: f64, slack: f64) -> f64 {
    (radius * norm * (1.0 + 4.0 * f64::EPSILON) + slack).min(f64::MAX)
}

/// Checks that all coordinates are finite.
///
/// Zero times a coordinate is zero for finite numbers and NaN for the others, so one sum per block
/// shows whether its points need a closer check.
fn check_finite(points: &[DVec3]) -> Result<(), TreeError> {
    const BLOCK: usize = 64;

    for (block, points) in points.chunks(BLOCK).enumerate() {
        let sum = points.iter().fold(DVec3::ZERO, |sum, &p| sum + p * 0.0);
        if sum.x + sum.y + sum.z == 0.0 {
            continue;
        }
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(TreeError::NonFinite { point: block * BLOCK + i });
        }
    }
    Ok(())
}

fn check_radii(radii: &[f64]) -> Result<(), TreeError> {
    match radii.iter().position(|&radius| !(radius >= 0.0 && radius.is_finite())) {
        Some(point) => Err(TreeError::BadRadius { point, radius: radii[point] }),
        None => Ok(()),
    }
}

/// Checks that a list holds one value per point.
pub(crate) fn check_length(given: usize, expected: usize) -> Result<(), TreeError> {
    if given == expected { Ok(()) } else { Err(TreeError::WrongLength { expected, given }) }
}
