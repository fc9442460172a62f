//! First contacts on curved paths: conservative pieces of straight motion.
//!
//! Over a piece of length `h` of the step, a point whose second derivative by time is at most `b`
//! stays within `b h² / 8` of its chord (the error bound of linear interpolation, which holds for
//! vectors as well, and for every convex combination of such points). So primitives that meet on
//! their true paths come within the sum of both deviations on their chords: a certified query with
//! that for a minimum separation misses none, and is never late.
//!
//! Pieces are halved only where they decide: from the earliest time that a piece leaves open, its
//! first half is searched, then its second. The deviation falls by four with each halving.

use glam::DVec3;

use crate::contact::{CcdContact, CcdParams, Certainty};
use crate::error::CcdError;
use crate::search::{CERTAIN_SLACK, OPEN_SLACK, first_contact_within};

/// Bounds on the paths of two primitives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathBounds {
    /// Upper bound of the second derivative of positions by the time of the step, summed over both
    /// primitives: for each, the largest of its points. 0 for straight paths.
    pub bend: f64,
    /// Upper bound of the rounding error of their positions, summed over both primitives.
    pub rounding: f64,
}

/// Pair of primitives of a query, with their four points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitives {
    /// A vertex, then the corners of a face.
    VertexFace,
    /// Two edges.
    EdgeEdge,
}

/// Earliness, as a share of the step, at which pieces are short enough.
///
/// Smaller takes more pieces: each factor of four takes another halving per contact.
const EARLINESS: f64 = 1.0 / 268_435_456.0;

/// Shortest piece: rounding of times would be felt below.
const MIN_PIECE: f64 = 1.0 / 1_073_741_824.0;

/// Length of the first part of what is left of a piece, in times that its deviation takes at the
/// speed of approach. Smaller parts may end before the contact; larger ones deviate more.
const ROOM: f64 = 6.0;

/// Finds the first contact of two primitives whose points move on curved paths, from time
/// `from` to time `to` of the step.
///
/// `at` returns the four points at a time, as [`vertex_face`](crate::vertex_face) and
/// [`edge_edge`](crate::edge_edge) take them. No contact is missed, and [`CcdContact::lo`] is never after the first one. A vertex that passes
/// through the inner part of a face is [`Certainty::Certain`]; contacts near the rim of a face, of
/// edges, and with a separation are [`Certainty::Possible`]. The time is at most a
/// few 1e-9 of the step early, unless the primitives approach each other that much more slowly than
/// they move, or touch within rounding.
///
/// # Errors
///
/// As [`vertex_face`](crate::vertex_face); [`CcdError::MinSeparation`] also for bounds that are
/// negative or not finite.
pub fn first_contact_on_paths(
    primitives: Primitives,
    at: impl Fn(f64) -> [DVec3; 4],
    bounds: PathBounds,
    [from, to]: [f64; 2],
    params: &CcdParams,
) -> Result<Option<CcdContact>, CcdError> {
    params.validate()?;
    for bound in [bounds.bend, bounds.rounding] {
        if !(bound >= 0.0 && bound.is_finite()) {
            return Err(CcdError::MinSeparation(bound));
        }
    }
    let search = PathSearch { primitives, at, bounds, params };
    let start = PathPoint { time: from, points: (search.at)(from) };
    let end = PathPoint { time: to, points: (search.at)(to) };
    let found = search.first_contact(start, end)?;

    let Some(contact) = found else { return Ok(None) };

    // A later piece begins within the step: only the first may begin with the contact.
    let contact = CcdContact { at_start: contact.lo <= from, ..contact };
    if primitives == Primitives::VertexFace
        && params.min_separation <= 0.0
        && let Some(latest) = search.passed_by(contact.lo, [from, to])
    {
        return Ok(Some(CcdContact { hi: latest, certainty: Certainty::Certain, ..contact }));
    }
    Ok(Some(contact))
}

/// Longest interval around a contact in which a crossing is proved, as a power of one half.
const LONGEST_PROOF: i32 = 8;

/// Clearance of a crossing from the rim of a face, in relative displacements during the interval.
///
/// With eight, corners that move by one tilt the plane by less than a third, so that a point that
/// comes to lie in the plane is still within the rim.
const CLEARANCE: f64 = 8.0;

/// Returns the distance of paths from their chords over a piece of a step, rounded up.
#[must_use]
pub fn chord_deviation(bend: f64, piece: f64) -> f64 {
    // Three products, each rounded once.
    0.125 * bend * piece * piece * (1.0 + 4.0 * f64::EPSILON)
}

/// Points at a time.
#[derive(Clone, Copy)]
struct PathPoint {
    time: f64,
    points: [DVec3; 4],
}

struct PathSearch<'a, F> {
    primitives: Primitives,
    at: F,
    bounds: PathBounds,
    params: &'a CcdParams,
}

impl<F: Fn(f64) -> [DVec3; 4]> PathSearch<'_, F> {
    fn first_contact(
        &self,
        mut start: PathPoint,
        end: PathPoint,
    ) -> Result<Option<CcdContact>, CcdError> {
        loop {
            let piece = end.time - start.time;
            let bend = chord_deviation(self.bounds.bend, piece);
            let separation = self.params.min_separation + (bend + self.bounds.rounding);
            let Some(found) = self.on_chords(&start, &end, separation * (1.0 + f64::EPSILON))?
            else {
                return Ok(None);
            };

            // The contact is not before this, whatever the rounding of times.
            let time = start.time + (found.lo * piece - 4.0 * f64::EPSILON).max(0.0);
            let speed = relative_speed(&start, &end) / piece;
            let is_short =
                piece <= MIN_PIECE || bend <= EARLINESS * speed || bend <= self.bounds.rounding;
            if is_short || time >= end.time {
                let time = time.min(end.time);
                return Ok(Some(CcdContact {
                    lo: time,
                    hi: end.time,
                    certainty: Certainty::Possible,
                    ..found
                }));
            }

            // What is left is divided behind where the contact is expected, or in the middle. A short
            // first part deviates by the square of its length: as in Newton's method, a few parts do.
            let left = self.point(time.max(start.time));
            let rate = approach(&found, &start, &end) / piece;
            let expected = ROOM * (bend + self.bounds.rounding) / rate;
            let middle = f64::midpoint(left.time, end.time);
            let shortest = left.time + MIN_PIECE;
            let behind = left.time + if expected >= 0.0 { expected } else { f64::INFINITY };
            let middle = self.point(middle.min(behind.max(shortest)));
            if let Some(contact) = self.first_contact(left, middle)? {
                return Ok(Some(contact));
            }
            start = middle;
        }
    }

    /// Returns a time until which the vertex has certainly passed through the face, if there is one
    /// near a time.
    ///
    /// The signed distance from the face's plane changes its sign between two times, and so
    /// vanishes between them. Then the vertex is in the face if it was far enough from the rim.
    fn passed_by(&self, time: f64, [from, to]: [f64; 2]) -> Option<f64> {
        for power in (LONGEST_PROOF..=28).rev().step_by(2) {
            let half = 0.5_f64.powi(power);
            let start = self.point((time - half).max(from));
            let end = self.point((time + half).min(to));
            let [before, after] = [&start, &end].map(|point| FaceView::new(&point.points));
            let (Some(before), Some(after)) = (before, after) else { continue };

            // Distances of rounding have no sign.
            let threshold = 2.0 * self.bounds.rounding;
            let has_sign = |view: &FaceView| view.height.abs() > threshold + view.rounding;
            let changes = before.height * after.height < 0.0;
            if !changes || !has_sign(&before) || !has_sign(&after) {
                continue;
            }
            let bend = chord_deviation(self.bounds.bend, end.time - start.time);
            let moved = relative_speed(&start, &end) + 2.0 * bend + threshold;
            if before.clearance > CLEARANCE * (moved + before.height.abs()) {
                return Some(end.time);
            }
        }
        None
    }

    fn point(&self, time: f64) -> PathPoint {
        PathPoint { time, points: (self.at)(time) }
    }

    fn on_chords(
        &self,
        start: &PathPoint,
        end: &PathPoint,
        min_separation: f64,
    ) -> Result<Option<CcdContact>, CcdError> {
        let params = CcdParams { min_separation, t_max: 1.0, ..*self.params };
        params.validate()?;

        // The separation of the caller may be far larger than the way of a piece: its last digits
        // decide the time.
        let slack = if self.params.min_separation > 0.0 { OPEN_SLACK } else { CERTAIN_SLACK };
        let (x0, x1) = (&start.points, &end.points);
        match self.primitives {
            Primitives::VertexFace => first_contact_within::<3>(x0, x1, &params, slack),
            Primitives::EdgeEdge => first_contact_within::<4>(x0, x1, &params, slack),
        }
    }
}

/// Position of a vertex relative to a face.
struct FaceView {
    /// Signed distance from the plane.
    height: f64,
    /// Bound on the rounding of that distance.
    rounding: f64,
    /// Distance of the foot in the plane from the nearest edge; negative outside.
    clearance: f64,
}

impl FaceView {
    /// Smallest area of a face, relative to the product of two edges, whose normal is trusted.
    const MIN_SINE: f64 = 1e-6;

    /// Rounding of a height, per unit of the distance from a corner and of the inverse sine of the
    /// angle there: less than 8 u of the normal, by which a thin face tilts, and 6 u of the product.
    const ROUNDING: f64 = 8.0 * f64::EPSILON;

    /// Returns the position, if the face has a normal.
    fn new(&[vertex, a, b, c]: &[DVec3; 4]) -> Option<Self> {
        let area = (b - a).cross(c - a);
        let product = (b - a).length() * (c - a).length();
        if area.length() <= Self::MIN_SINE * product {
            return None;
        }
        let normal = area.normalize();
        let rounding = Self::ROUNDING * product / area.length() * (vertex - a).length();

        let mut clearance = f64::INFINITY;
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let inward = normal.cross(to - from).normalize_or_zero();
            clearance = clearance.min(inward.dot(vertex - from));
        }
        Some(Self { height: normal.dot(vertex - a), rounding, clearance })
    }
}

/// Returns how far the points of a contact on chords approach each other along its normal.
fn approach(found: &CcdContact, start: &PathPoint, end: &PathPoint) -> f64 {
    let mut moved = DVec3::ZERO;
    for (k, weight) in found.weights.iter().enumerate() {
        moved += *weight * (end.points[k] - start.points[k]);
    }
    moved.dot(found.normal).abs()
}

/// Returns how far two primitives move relative to each other: the largest difference of the
/// displacements of a point of the first and one of the second.
fn relative_speed(start: &PathPoint, end: &PathPoint) -> f64 {
    let moves: [DVec3; 4] = std::array::from_fn(|k| end.points[k] - start.points[k]);
    let mut largest = 0.0_f64;
    for k in 1..4 {
        largest = largest.max(moves[k].distance(moves[0]));
    }
    largest
}
