//! How far a medial surface and a closed surface are from each other, bounded
//! in both directions.
//!
//! Each bound is found by branch and bound: what may be largest is split until
//! the bound on the rest is hardly above what has been seen.
//!
//! *From the surface to the medial surface*: the largest φ(p) over surface points
//! p, with φ the signed distance of the union. The distance `φ_s` of one primitive
//! is convex, so on a triangle it is at most the largest of its corners' values;
//! φ is at most `φ_s` for any s. Where the corners have the same nearest
//! primitive, the bound is exact.
//!
//! *From the medial surface to the surface*: the largest `r − D(c)` over all balls
//! of the union, with D the depth of a centre. No point of a ball is farther
//! outside than that. `D` is the least distance to any face, and each of these is
//! convex in c, so its tangent at one centre bounds it at the others; and only
//! faces within twice a patch's radius beyond the nearest can be nearest anywhere
//! on it.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;
use kdop::Workspace;
use surface::{OneSidedDistance, Positions, TriangleSurface};

use crate::surface_distance::SurfaceDistance;
use crate::{
    Ball, FootRule, MedialError, MedialSurface, NearestPrimitive, PrimitiveTree, parallel,
};

/// How far a medial surface is from the closed surface it stands for, in the
/// caller's length unit. Each bound is within a twentieth of what was seen, unless
/// the work for that exceeds its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Deviation {
    /// How far points of the surface are outside the union of balls.
    pub surface_to_medial: OneSidedDistance,
    /// How far balls reach out of the surface.
    pub medial_to_surface: OneSidedDistance,
    /// Root of the mean square of the union's signed distance over the surface,
    /// at its vertices by their areas.
    pub rms: f64,
    /// The size of that distance which 95 % of the vertices do not exceed.
    pub p95: f64,
}

impl Deviation {
    /// Measures `medial` against a closed, manifold, oriented surface.
    ///
    /// # Errors
    ///
    /// [`MedialError::Surface`] for a surface without inside, and
    /// [`MedialError::Tree`] where its bounds cannot be stored.
    pub fn measure(
        medial: &MedialSurface,
        surface: &TriangleSurface,
        x: Positions<'_>,
    ) -> Result<Self, MedialError> {
        surface.require_closed()?;
        surface.require_manifold()?;
        surface.require_oriented()?;
        Self::of(medial, &SurfaceDistance::new(surface, x)?)
    }

    pub(crate) fn of(
        medial: &MedialSurface,
        distance: &SurfaceDistance<'_>,
    ) -> Result<Self, MedialError> {
        let tree = PrimitiveTree::new(medial)?;
        let x = distance.x.as_slice();
        // Vertices next to each other in the list mostly are so on the surface.
        let start = || (0, Workspace::default());
        let nearest = parallel::map(x.len(), start, |(guess, workspace), vertex| {
            let found = tree.nearest_from(medial, x[vertex], *guess, workspace);
            *guess = found.primitive;
            found
        });
        let (rms, p95) = statistics(distance, &nearest);
        Ok(Self {
            surface_to_medial: surface_to_medial(medial, &tree, distance, &nearest),
            medial_to_surface: medial_to_surface(medial, distance),
            rms,
            p95,
        })
    }

    /// The larger of the two bounds.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.surface_to_medial.at_most.max(self.medial_to_surface.at_most)
    }
}

/// Excess of a bound over what was seen at which splitting ends, relative to
/// the latter.
const SLACK: f64 = 0.05;

/// The same relative to the size of the medial surface, for deviations that
/// are hardly there: a micrometre on a muscle.
const LEAST_SLACK: f64 = 1e-5;

/// Pieces looked at before splitting ends anyway: seconds of work.
const MOST_PIECES: usize = 400_000;

fn statistics(distance: &SurfaceDistance<'_>, nearest: &[NearestPrimitive]) -> (f64, f64) {
    let mut area = vec![0.0; nearest.len()];
    for (face, corners) in (0_u32..).zip(distance.surface.faces()) {
        let [a, b, c] = distance.corners(face);
        for &corner in corners {
            area[corner as usize] += (b - a).cross(c - a).length();
        }
    }
    let values = nearest.iter().map(|n| n.foot.distance);
    let squares: f64 = values.clone().zip(&area).map(|(value, area)| area * value * value).sum();
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    let p95 = sizes.get(sizes.len() * 95 / 100).copied().unwrap_or(0.0);
    ((squares / area.iter().sum::<f64>()).sqrt(), p95)
}

/// Something with a bound, the largest first.
struct Piece<T> {
    bound: f64,
    /// Breaks ties, so that the order is fixed.
    number: usize,
    content: T,
}

impl<T> Ord for Piece<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then_with(|| other.number.cmp(&self.number))
    }
}

impl<T> PartialOrd for Piece<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> PartialEq for Piece<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<T> Eq for Piece<T> {}

/// A search for the largest value over pieces that can be bounded and split.
struct Largest<T> {
    pieces: BinaryHeap<Piece<T>>,
    number: usize,
    seen: f64,
    least_slack: f64,
}

impl<T> Largest<T> {
    fn new(least_slack: f64) -> Self {
        Self { pieces: BinaryHeap::new(), number: 0, seen: 0.0, least_slack }
    }

    fn enough(&self) -> f64 {
        self.seen + self.least_slack.max(SLACK * self.seen)
    }

    /// Adds a piece on which `seen` occurs and nothing above `bound`.
    fn add(&mut self, seen: f64, bound: f64, content: T) {
        self.seen = self.seen.max(seen);
        if bound > self.enough() {
            self.pieces.push(Piece { bound, number: self.number, content });
            self.number += 1;
        }
    }

    /// Splits what may be largest until the rest hardly matters.
    fn run(mut self, mut split: impl FnMut(&mut Self, T)) -> OneSidedDistance {
        // What `add` leaves out is bounded by what was enough then, which only grows.
        while self.number < MOST_PIECES {
            let Some(top) = self.pieces.pop() else { break };
            if top.bound <= self.enough() {
                break;
            }
            split(&mut self, top.content);
        }
        let rest = self.pieces.peek().map_or(0.0, |piece| piece.bound);
        OneSidedDistance { seen: self.seen, at_most: rest.max(self.enough()) }
    }
}

/// A piece of a face: its corners with their nearest primitives and distances.
type Patch = [(DVec3, u32, f64); 3];

fn surface_to_medial(
    medial: &MedialSurface,
    tree: &PrimitiveTree,
    distance: &SurfaceDistance<'_>,
    nearest: &[NearestPrimitive],
) -> OneSidedDistance {
    let mut workspace = Workspace::default();
    let mut search = Largest::new(least_slack(medial));
    let add = |search: &mut Largest<Patch>, patch: Patch| {
        let seen = patch.iter().map(|&(.., value)| value).fold(0.0, f64::max);
        search.add(seen, patch_bound(medial, &patch), patch);
    };
    for corners in distance.surface.faces() {
        let corner = |vertex: u32| {
            let found = &nearest[vertex as usize];
            (distance.x.at(vertex), found.primitive, found.foot.distance)
        };
        add(&mut search, corners.map(corner));
    }
    search.run(|search, [a, b, c]| {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            let p = from.0.midpoint(to.0);
            let found = tree.nearest_from(medial, p, from.1, &mut workspace);
            (p, found.primitive, found.foot.distance)
        });
        for patch in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            add(search, patch);
        }
    })
}

/// The least over the corners' primitives of the largest distance at a corner.
fn patch_bound(medial: &MedialSurface, patch: &Patch) -> f64 {
    let largest = |primitive: u32| {
        let at = |&(p, own, value): &(DVec3, u32, f64)| {
            if own == primitive {
                value
            } else {
                medial.foot(p, primitive, FootRule::Exact).distance
            }
        };
        patch.iter().map(at).fold(f64::NEG_INFINITY, f64::max)
    };
    patch.iter().map(|&(_, primitive, _)| largest(primitive)).fold(f64::INFINITY, f64::min)
}

fn medial_to_surface(medial: &MedialSurface, distance: &SurfaceDistance<'_>) -> OneSidedDistance {
    let mut workspace = Workspace::default();
    let mut search = Largest::new(least_slack(medial));
    let whole = (0_u32..).zip(medial.primitives()).map(|(i, _)| medial.primitive_balls(i));
    for balls in whole {
        let (seen, bound) = excess(distance, &balls, &mut workspace);
        search.add(seen, bound, balls);
    }
    search.run(|search, [a, b, c]| {
        let middle =
            |a: Ball, b: Ball| Ball::new(a.center.midpoint(b.center), a.radius.midpoint(b.radius));
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        for balls in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            let (seen, bound) = excess(distance, &balls, &mut workspace);
            search.add(seen, bound, balls);
        }
    })
}

fn least_slack(medial: &MedialSurface) -> f64 {
    let [low, high] = medial.bounds();
    LEAST_SLACK * low.distance(high)
}

/// How far the ball in the middle of three reaches out, and a bound on how far
/// any ball between them does.
fn excess(
    distance: &SurfaceDistance<'_>,
    balls: &[Ball; 3],
    workspace: &mut Workspace,
) -> (f64, f64) {
    let middle = Ball::interpolate(balls, [1.0 / 3.0; 3]);
    let spread = balls.iter().map(|b| b.center.distance(middle.center)).fold(0.0, f64::max);
    let (depth, facing) = distance.depth_and_facing(middle.center, 2.0 * spread, workspace);
    let seen = middle.radius - depth;
    let bound = if depth > spread {
        let slope = |away: DVec3, gap: f64| {
            let at = |ball: &Ball| ball.radius - gap - away.dot(ball.center - middle.center);
            balls.iter().map(at).fold(f64::NEG_INFINITY, f64::max)
        };
        facing.iter().map(|&(away, gap)| slope(away, gap)).fold(seen, f64::max)
    } else {
        // The surface may pass through the patch: only the slope of D is known.
        let at = |ball: &Ball| ball.radius - depth + ball.center.distance(middle.center);
        balls.iter().map(at).fold(seen, f64::max)
    };
    (seen, bound)
}
