//! What a tree's points are at the moment: positions, balls, boxes, still or moving.

use glam::DVec3;

use crate::directions::{is_monotone, norm, project};
use crate::error::TreeError;

/// Where a tree's numbered points are, and how far they reach.
///
/// ```
/// use glam::DVec3;
/// use kdop::{Extents, Leaves, Tree};
///
/// let centres = [DVec3::ZERO, DVec3::X * 10.0];
/// // A cone: the hull of two balls, and a millimetre around it.
/// let cone = Extents::balls(&centres, &[1.0, 2.0]).inflated(1.0);
/// let tree = Tree::build_from(Leaves::Edges(&[[0, 1]]), cone)?;
/// assert_eq!(tree.root().interval(0), [-2.0, 13.0]);
/// # Ok::<(), kdop::TreeError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Extents<'a> {
    shape: Shape<'a>,
    inflation: f64,
}

#[derive(Clone, Copy, Debug)]
enum Shape<'a> {
    Points(&'a [DVec3]),
    Swept(&'a [DVec3], &'a [DVec3]),
    Balls(&'a [DVec3], &'a [f64]),
    SweptBalls([&'a [DVec3]; 2], [&'a [f64]; 2]),
    Boxes(&'a [[DVec3; 2]]),
}

impl<'a> Extents<'a> {
    /// Points at rest (|P|).
    #[must_use]
    pub const fn points(points: &'a [DVec3]) -> Self {
        Self { shape: Shape::Points(points), inflation: 0.0 }
    }

    /// Points on their straight ways from `before` to `after` (|P| each).
    #[must_use]
    pub const fn swept(before: &'a [DVec3], after: &'a [DVec3]) -> Self {
        Self { shape: Shape::Swept(before, after), inflation: 0.0 }
    }

    /// Balls about `centres` (|P|), of radius `radii` (|P|, `>= 0`).
    #[must_use]
    pub const fn balls(centres: &'a [DVec3], radii: &'a [f64]) -> Self {
        Self { shape: Shape::Balls(centres, radii), inflation: 0.0 }
    }

    /// Balls whose centres and radii change linearly between two states (|P| each).
    #[must_use]
    pub const fn swept_balls(
        before: (&'a [DVec3], &'a [f64]),
        after: (&'a [DVec3], &'a [f64]),
    ) -> Self {
        let shape = Shape::SweptBalls([before.0, after.0], [before.1, after.1]);
        Self { shape, inflation: 0.0 }
    }

    /// Boxes along the axes, each by its lower and its upper corner (|P| × 2); with
    /// [`Leaves::Points`](crate::Leaves::Points) each is a leaf.
    #[must_use]
    pub const fn boxes(boxes: &'a [[DVec3; 2]]) -> Self {
        Self { shape: Shape::Boxes(boxes), inflation: 0.0 }
    }

    /// The same with all radii larger by `by` (a length, `>= 0`); points become balls of that
    /// radius: bounds move outward by `by · ‖n‖`.
    #[must_use]
    pub const fn inflated(self, by: f64) -> Self {
        Self { shape: self.shape, inflation: self.inflation + by }
    }

    /// How many points, balls or boxes there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self.shape {
            Shape::Points(p)
            | Shape::Swept(p, _)
            | Shape::Balls(p, _)
            | Shape::SweptBalls([p, _], _) => p.len(),
            Shape::Boxes(boxes) => boxes.len(),
        }
    }

    /// Whether there is nothing.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Some of the points.
    #[cfg(feature = "rayon")]
    pub(crate) fn part(&self, range: std::ops::Range<usize>) -> Self {
        let r = || range.clone();
        let shape = match self.shape {
            Shape::Points(p) => Shape::Points(&p[r()]),
            Shape::Swept(p, q) => Shape::Swept(&p[r()], &q[r()]),
            Shape::Balls(p, radii) => Shape::Balls(&p[r()], &radii[r()]),
            Shape::SweptBalls([p, q], [before, after]) => {
                Shape::SweptBalls([&p[r()], &q[r()]], [&before[r()], &after[r()]])
            }
            Shape::Boxes(boxes) => Shape::Boxes(&boxes[r()]),
        };
        Self { shape, inflation: self.inflation }
    }

    /// Checks lengths, finiteness and radii.
    pub(crate) fn check(&self) -> Result<(), TreeError> {
        check_radius(0, self.inflation)?;
        let expected = self.len();
        match self.shape {
            Shape::Points(points) => check_finite(points),
            Shape::Swept(before, after) => check_states([before, after], expected),
            Shape::Balls(centres, radii) => {
                check_finite(centres)?;
                check_radii(radii, expected)
            }
            Shape::SweptBalls(centres, radii) => {
                check_states(centres, expected)?;
                radii.into_iter().try_for_each(|radii| check_radii(radii, expected))
            }
            Shape::Boxes(boxes) => check_boxes(boxes),
        }
    }

    /// The one list of points whose projections are the bounds, where there is one.
    pub(crate) const fn exact_points<const S: usize>(&self) -> Option<&'a [DVec3]> {
        match self.shape {
            Shape::Points(points) if is_monotone::<S>() && self.inflation == 0.0 => Some(points),
            _ => None,
        }
    }

    /// Bounds of every point in turn, along every direction, in f64.
    pub(crate) fn for_each<const S: usize>(&self, write: impl FnMut([f64; S], [f64; S])) {
        let e = self.inflation;
        match self.shape {
            Shape::Points(points) => each(points.iter().map(|&p| ball(p, e)), write),
            Shape::Swept(before, after) => {
                let states = before.iter().zip(after);
                each(states.map(|(&p, &q)| union(ball(p, e), ball(q, e))), write);
            }
            Shape::Balls(centres, radii) => {
                each(centres.iter().zip(radii).map(|(&c, &r)| ball(c, r + e)), write);
            }
            Shape::SweptBalls([p, q], [r, s]) => {
                let before = p.iter().zip(r).map(|(&c, &r)| ball(c, r + e));
                let after = q.iter().zip(s).map(|(&c, &r)| ball(c, r + e));
                each(before.zip(after).map(|(a, b)| union(a, b)), write);
            }
            Shape::Boxes(boxes) => each(boxes.iter().map(|&b| box_interval(b, e)), write),
        }
    }
}

type Interval<const S: usize> = ([f64; S], [f64; S]);

fn each<const S: usize>(
    intervals: impl Iterator<Item = Interval<S>>,
    mut write: impl FnMut([f64; S], [f64; S]),
) {
    intervals.for_each(|(lo, hi)| write(lo, hi));
}

/// Bounds of a ball: `n·c ± r‖n‖`, widened by what f64 rounds where it rounds more than once.
fn ball<const S: usize>(centre: DVec3, radius: f64) -> Interval<S> {
    let at = project(centre);
    if is_monotone::<S>() && radius == 0.0 {
        return (at, at);
    }
    let slack = rounding_slack(centre);
    let reach: [f64; S] = std::array::from_fn(|k| reach(radius, norm::<S>(k), slack));
    (std::array::from_fn(|k| at[k] - reach[k]), std::array::from_fn(|k| at[k] + reach[k]))
}

/// More than the rounding errors of a projection and of one addition to it.
///
/// Three roundings of at most half an ulp of `|x| + |y| + |z|` each are below
/// `2 ε (|x| + |y| + |z|)`; twice that also covers the summation of the absolute values.
fn rounding_slack(p: DVec3) -> f64 {
    let p = p.abs();
    4.0 * f64::EPSILON * (p.x + p.y + p.z)
}

/// `r‖n‖` and the slack, rounded up, kept finite so that no difference of infinities arises.
fn reach(radius: f64, norm: f64, slack: f64) -> f64 {
    (radius * norm * (1.0 + 4.0 * f64::EPSILON) + slack).min(f64::MAX)
}

fn union<const S: usize>(a: Interval<S>, b: Interval<S>) -> Interval<S> {
    let lo = std::array::from_fn(|k| a.0[k].min(b.0[k]));
    (lo, std::array::from_fn(|k| a.1[k].max(b.1[k])))
}

/// Bounds of a box: each direction takes the corner that lies furthest along it.
fn box_interval<const S: usize>([lower, upper]: [DVec3; 2], inflation: f64) -> Interval<S> {
    let corner = |i: usize| {
        let pick = |axis: usize| if i & (1 << axis) == 0 { lower[axis] } else { upper[axis] };
        ball(DVec3::new(pick(0), pick(1), pick(2)), inflation)
    };
    (1..8).map(corner).fold(corner(0), union)
}

fn check_states(states: [&[DVec3]; 2], expected: usize) -> Result<(), TreeError> {
    states.into_iter().try_for_each(|points| {
        check_length(points.len(), expected)?;
        check_finite(points)
    })
}

/// Multiplying by zero maps every finite number to zero and the others to NaN, so one sum over a
/// block tells whether to look closer.
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

fn check_radii(radii: &[f64], expected: usize) -> Result<(), TreeError> {
    check_length(radii.len(), expected)?;
    radii.iter().enumerate().try_for_each(|(point, &radius)| check_radius(point, radius))
}

fn check_radius(point: usize, radius: f64) -> Result<(), TreeError> {
    if radius >= 0.0 && radius.is_finite() {
        return Ok(());
    }
    Err(TreeError::BadRadius { point, radius })
}

fn check_boxes(boxes: &[[DVec3; 2]]) -> Result<(), TreeError> {
    for (point, [lower, upper]) in boxes.iter().enumerate() {
        if !(lower.is_finite() && upper.is_finite()) {
            return Err(TreeError::NonFinite { point });
        }
        if !lower.cmple(*upper).all() {
            return Err(TreeError::InvertedBox { point });
        }
    }
    Ok(())
}

pub(crate) fn check_length(given: usize, expected: usize) -> Result<(), TreeError> {
    if given == expected { Ok(()) } else { Err(TreeError::WrongLength { expected, given }) }
}
