//! Contacts of balls, cones and slabs with a rigid body that is given by its distance.
//!
//! The gap of a ball is the distance of its center less its radius. Between balls, the minimum is
//! found by branch and bound. For the point q of the rigid body nearest to a ball of a piece,
//! `|q − c| − r` is convex, and its curvature is at most the inverse of the distance: so it is below
//! its minimum at the corners by at most the square of the piece's size over six times that
//! distance, and few pieces are left after a few halvings. Near the rigid body and inside it, where
//! that bound is useless, slopes of at most 1 bound it. Pieces of smaller bounds come first.
//!
//! Source: S. A. Piyavskii, "An algorithm for finding the absolute extremum of a function", USSR
//! Computational Mathematics and Mathematical Physics 12, 1972. Differs in bounding curvature as
//! well as slopes, on triangles.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec3;
use kdop::{Dop18, Workspace};
use surface::{Anchor, Contact, ContactSide, RigidState, Term, TotalF64};

use super::on_surface::with_ball_gap;
use super::{
    ContactBody, MedialContact, MedialDetector, MedialFeature, MedialScratch, PrimitiveBall,
};
use crate::{Ball, MedialError};

/// Maximum number of pieces of a primitive that are divided before its smallest evaluated gap is
/// reported, whatever that is: a smaller one, within the margin, may be between.
///
/// Only primitives that are many times larger than their distance from the rigid body, or whose
/// centers are inside it, need more than some hundred.
const MAX_PIECES: usize = 4096;

/// Rigid body as one side of contacts with balls.
#[derive(Clone, Copy, Debug)]
pub struct RigidSide {
    /// Pose and velocity.
    pub state: RigidState,
    /// Bounds of all points of the world within the margin.
    pub bounds: Dop18,
    /// Gap up to which every contact is reported, `>= 0`. A contact between balls outside it whose
    /// gap is larger is reported where the smallest one may be within it.
    pub margin: f64,
    /// Excess over the minimum gap of a primitive that is accepted, `> 0`.
    pub tolerance: f64,
}

/// Signed distance of a point from a rigid body, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidDistance {
    /// The distance.
    Value {
        /// Signed distance, negative inside.
        distance: f64,
        /// Unit direction away from the body.
        normal: DVec3,
    },
    /// A lower bound.
    AtLeast(f64),
}

/// Ball with its gap to the rigid body.
#[derive(Clone, Copy, Debug)]
struct BallGap {
    ball: Ball,
    /// Distance of the center less the radius, or a lower bound beyond the margin.
    gap: f64,
    /// Direction away from the rigid body; `None` for a bound.
    normal: Option<DVec3>,
}

/// Ball of a primitive with its weights there.
#[derive(Clone, Copy, Debug)]
struct WeightedGap {
    weights: [f64; 3],
    at: BallGap,
}

/// Contact of a ball of a primitive.
struct Found {
    ball: PrimitiveBall,
    at: BallGap,
}

/// Rigid body with its distance function.
struct Rigid<'a, D> {
    side: &'a RigidSide,
    distance: D,
}

impl MedialDetector {
    /// Finds the contacts of the balls, which are those of `own`, with a rigid body that `distance`
    /// returns the signed distance of points of the world from: balls within the margin, ascending,
    /// then cones and slabs within the margin, ascending, at the smallest gap between their balls.
    /// Cones and slabs with a ball within the margin are among the latter where that gap is smaller
    /// than those of their balls by more than the tolerance.
    ///
    /// The smallest gap is found up to the tolerance, so that it may be beyond the margin by that
    /// much, or by more in a primitive that is many times larger than its distance, or whose centers
    /// are inside the rigid body. Where the ball of that gap is one of the medial surface, it is
    /// reported once, among the balls.
    ///
    /// The distance has to be known at the centers of the balls, which are as deep in the body as
    /// it is thick.
    ///
    /// # Errors
    ///
    /// [`MedialError::DistanceRange`] where a ball may be in contact and the distance of its center
    /// is unknown, or of all centers of a primitive.
    pub fn rigid_contacts(
        &self,
        own: &ContactBody<'_>,
        side: &RigidSide,
        distance: impl Fn(DVec3) -> RigidDistance,
        scratch: &mut MedialScratch,
    ) -> Result<Vec<MedialContact>, MedialError> {
        // Primitives whose bounds come near the rigid body.
        let workspace = &mut scratch.workspace;
        let mut near = Vec::new();
        self.tree.tree().query(&side.bounds, workspace, |primitive| near.push(primitive));
        near.sort_unstable();

        let rigid = Rigid { side, distance };
        let found = rigid.find(self, &near)?;
        Ok(found
            .iter()
            .filter_map(|found| self.rigid_contact(own, found, side, workspace))
            .collect())
    }

    /// Transfers a contact to the surface; `None` for a surface without faces.
    fn rigid_contact(
        &self,
        own: &ContactBody<'_>,
        Found { ball, at }: &Found,
        side: &RigidSide,
        workspace: &mut Workspace,
    ) -> Option<MedialContact> {
        let BallGap { ball: Ball { center, radius }, gap, normal } = *at;
        let normal = normal?;
        let border = center - radius * normal;
        let on = self.closest_on(own, ball.primitive, border, -normal, workspace)?;
        let corners = own.tree.surface().faces()[on.face as usize];
        let terms: [Term; 3] = std::array::from_fn(|k| Term {
            particle: own.particles.particle(corners[k]),
            weight: on.foot.barycentric[k],
        });

        // The point of the rigid body under the center of the ball, and its velocity.
        let point = center - (gap + radius) * normal;
        let velocity = side.state.velocity_at(point);
        let anchor = ContactSide::Rigid(Anchor { point, velocity, acceleration: DVec3::ZERO });
        let height = (on.foot.point - point).dot(normal);
        let contact = Contact::between(ContactSide::Particles(&terms), anchor, normal, height);
        let contact = with_ball_gap(contact, gap);
        Some(MedialContact { contact, ball: *ball, feature: MedialFeature::Rigid })
    }
}

impl<D: Fn(DVec3) -> RigidDistance> Rigid<'_, D> {
    /// Finds the balls within the margin, then the smallest gaps between balls within it.
    fn find(&self, detector: &MedialDetector, near: &[u32]) -> Result<Vec<Found>, MedialError> {
        let medial = &detector.medial;
        let mut gaps: Vec<Option<BallGap>> = vec![None; medial.balls().len()];
        let (mut balls, mut between) = (BTreeMap::new(), Vec::new());
        for &primitive in near {
            // Each ball is evaluated once, by the first primitive that has it.
            let mut corners = [None; 3];
            for (k, ball) in medial.primitives()[primitive as usize].into_iter().enumerate() {
                let mut weights = [0.0; 3];
                weights[k] = 1.0;
                let at = match gaps[ball as usize] {
                    Some(at) => at,
                    None => {
                        let at = self.evaluate(medial.balls()[ball as usize])?;
                        if self.is_contact(&at) {
                            let ball_of = PrimitiveBall { primitive, weights };
                            balls.insert(ball, Found { ball: ball_of, at });
                        }
                        *gaps[ball as usize].insert(at)
                    }
                };
                corners[k] = Some(WeightedGap { weights, at });
            }

            // Between balls outside the margin, some may be within it, and deeper ones between others.
            if let [Some(a), Some(b), Some(c)] = corners
                && let Some(lowest) = self.min_gap(&medial.primitive_balls(primitive), [a, b, c])?
            {
                let ball = PrimitiveBall { primitive, weights: lowest.weights };
                let found = Found { ball, at: lowest.at };
                // Primitives that share the ball of their smallest gap report it once.
                match single_ball(medial.primitives()[primitive as usize], lowest.weights) {
                    Some(ball) => _ = balls.entry(ball).or_insert(found),
                    None => between.push(found),
                }
            }
        }

        Ok(balls.into_values().chain(between).collect())
    }

    fn is_contact(&self, at: &BallGap) -> bool {
        at.gap <= self.side.margin
    }

    /// Evaluates the gap of a ball, or a lower bound beyond the margin.
    fn evaluate(&self, ball: Ball) -> Result<BallGap, MedialError> {
        let Ball { center, radius } = ball;
        match (self.distance)(center) {
            RigidDistance::Value { distance, normal } => {
                Ok(BallGap { ball, gap: distance - radius, normal: Some(normal) })
            }
            RigidDistance::AtLeast(bound) if bound - radius > self.side.margin => {
                Ok(BallGap { ball, gap: bound - radius, normal: None })
            }
            RigidDistance::AtLeast(known) => {
                let needed = radius + self.side.margin;
                Err(MedialError::DistanceRange { known, needed })
            }
        }
    }

    /// Finds the smallest gap between three balls; `None` where it is certainly outside the margin,
    /// or where that of a ball within it is as small up to the tolerance.
    fn min_gap(
        &self,
        balls: &[Ball; 3],
        corners: [WeightedGap; 3],
    ) -> Result<Option<WeightedGap>, MedialError> {
        let RigidSide { margin, tolerance, .. } = *self.side;

        // Balls within the margin are reported: only smaller gaps than theirs count.
        let reported =
            corners.map(|corner| corner.at.gap).into_iter().fold(f64::INFINITY, f64::min);
        let is_reported = reported <= margin;
        let needed = if is_reported { reported - tolerance } else { f64::INFINITY };
        let is_needed = |at: &WeightedGap| at.at.gap < needed;
        let mut lowest = lowest_of(None, corners).filter(is_needed);

        // Pieces by their bounds, the first of equals first.
        let mut pieces = vec![corners];
        let mut queue = BinaryHeap::from([Reverse((TotalF64(lower_bound(&corners)), 0))]);
        let mut may_be_within = false;
        while let Some(Reverse((TotalF64(bound), number))) = queue.pop() {
            let [a, b, c] = pieces[number];
            // All other pieces have larger bounds.
            let lowest_gap = lowest.map_or(f64::INFINITY, |lowest| lowest.at.gap);
            if bound > margin || bound >= needed {
                break;
            }
            if bound >= lowest_gap - tolerance {
                may_be_within = true;
                break;
            }
            if pieces.len() > 4 * MAX_PIECES {
                let unknown = || MedialError::DistanceRange {
                    known: a.at.gap + a.at.ball.radius,
                    needed: a.at.gap + a.at.ball.radius + margin - bound,
                };
                return if is_reported { Ok(lowest) } else { lowest.map(Some).ok_or_else(unknown) };
            }

            // Quarters, by the middles of the sides.
            let ab = self.middle(balls, &a, &b)?;
            let bc = self.middle(balls, &b, &c)?;
            let ca = self.middle(balls, &c, &a)?;
            lowest = lowest_of(lowest, [ab, bc, ca]).filter(is_needed);
            for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                queue.push(Reverse((TotalF64(lower_bound(&corners)), pieces.len())));
                pieces.push(corners);
            }
        }
        Ok(lowest.filter(|lowest| may_be_within || self.is_contact(&lowest.at)))
    }

    /// Evaluates the ball in the middle of two balls of a primitive.
    fn middle(
        &self,
        balls: &[Ball; 3],
        a: &WeightedGap,
        b: &WeightedGap,
    ) -> Result<WeightedGap, MedialError> {
        let weights = std::array::from_fn(|k| 0.5 * (a.weights[k] + b.weights[k]));
        let at = self.evaluate(Ball::interpolate(balls, weights))?;
        Ok(WeightedGap { weights, at })
    }
}

/// Returns the ball of a primitive that has all of the weight, if one has.
fn single_ball(primitive: [u32; 3], weights: [f64; 3]) -> Option<u32> {
    // Cones have one of their balls twice.
    primitive.into_iter().find(|ball| {
        let of_ball = primitive.iter().zip(weights).filter(|(other, _)| *other == ball);
        of_ball.map(|(_, weight)| weight).sum::<f64>() >= 1.0
    })
}

/// Returns the one with the smallest gap, the first of equals; bounds do not count.
fn lowest_of(first: Option<WeightedGap>, others: [WeightedGap; 3]) -> Option<WeightedGap> {
    let mut lowest = first;
    for other in others {
        let is_lower = lowest.is_none_or(|lowest| other.at.gap < lowest.at.gap);
        if other.at.normal.is_some() && is_lower {
            lowest = Some(other);
        }
    }
    lowest
}

/// Computes a lower bound on the gaps of the balls of a piece.
fn lower_bound(piece: &[WeightedGap; 3]) -> f64 {
    let edge = |i: usize, j: usize| piece[i].at.ball.center.distance(piece[j].at.ball.center);
    let size = edge(0, 1).max(edge(1, 2)).max(edge(2, 0));
    let (mut min_gap, mut min_distance) = (f64::INFINITY, f64::INFINITY);
    let mut max_radius = 0.0_f64;
    for WeightedGap { at, .. } in piece {
        min_gap = min_gap.min(at.gap);
        min_distance = min_distance.min(at.gap + at.ball.radius);
        max_radius = max_radius.max(at.ball.radius);
    }

    // By the slope of the distance: the mean of the squared distances from the corners, weighted as
    // the ball, is at most the square of the radius of the smallest circle around the piece.
    let mut bound = min_gap - size / 3.0_f64.sqrt();

    // By the slopes of the distance and of the radius, from each corner.
    for WeightedGap { at, .. } in piece {
        bound = bound.max(at.gap - size - (max_radius - at.ball.radius));
    }

    // By the curvature, away from the rigid body.
    let distance = min_distance - size;
    if distance > 0.0 { bound.max(min_gap - size * size / (6.0 * distance)) } else { bound }
}
