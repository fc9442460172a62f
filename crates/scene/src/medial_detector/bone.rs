//! Balls, cones and slabs against the field of a bone.
//!
//! A ball's distance is the field's value at its center less its radius. Between
//! balls, the lowest place is found by branch and bound. For the bone's point q
//! that is nearest to a ball between those of a piece, `|q − c| − r` is convex, and
//! bends by no more than the inverse of the distance: so it is below its least
//! value at the corners by no more than the square of the piece's size over six
//! times that distance, and few pieces are left after a few halvings. Near the bone
//! itself, where that says nothing, slopes of at most 1 do.
//!
//! Source: S. A. Piyavskii, "An algorithm for finding the absolute extremum of a
//! function", USSR Computational Mathematics and Mathematical Physics 12, 1972.
//! Differs in bounding bends as well as slopes, on triangles.

use distance_field::{FieldDetector, FieldDistance};
use glam::DVec3;
use medial::Ball;
use surface::{Anchor, RigidState};

use super::hold::SurfacePoint;
use super::{MedialContact, MedialDetector, MedialFeature, MedialScratch, PrimitiveBall};
use crate::Body;
use crate::SceneError;

/// Pieces of a primitive that are looked at before the lowest place seen counts as
/// the lowest: only a primitive whose balls' centers are in the bone needs more
/// than some hundred.
const MAX_PIECES: usize = 4096;

/// Contacts of the detector's balls, which are those of `body`, with a bone. Trees
/// must be built.
pub(super) fn contacts(
    (detector, body): (&MedialDetector, &Body),
    field: &FieldDetector,
    state: &RigidState,
    scratch: &mut MedialScratch,
) -> Result<Vec<MedialContact>, SceneError> {
    let Some(bounds) = field.bounds(&state.pose) else {
        return Ok(Vec::new());
    };
    let mut near = Vec::new();
    detector.tree.tree().query(&bounds, &mut scratch.workspace, |primitive| near.push(primitive));
    near.sort_unstable();
    let bone = Bone { field, state, name: body.name() };
    let lowest = bone.lowest_places(detector, &near)?;
    let contact = |(ball, place): (PrimitiveBall, Place)| {
        let hint = detector.hints.of(&detector.medial, ball.primitive, -place.normal);
        let border = place.ball.center - place.ball.radius * place.normal;
        let hold = SurfacePoint::nearest(body, border, hint, &mut scratch.workspace)?;
        let point = place.ball.center - (place.gap + place.ball.radius) * place.normal;
        let anchor =
            Anchor { point, velocity: state.velocity_at(point), acceleration: DVec3::ZERO };
        let contact = hold.anchored(anchor, place.normal, place.gap);
        Some(MedialContact { contact, ball, feature: MedialFeature::Bone })
    };
    Ok(lowest.into_iter().filter_map(contact).collect())
}

/// A bone, for balls of the body of this name.
struct Bone<'a> {
    field: &'a FieldDetector,
    state: &'a RigidState,
    name: &'a str,
}

/// A ball over the bone.
#[derive(Clone, Copy, Debug)]
struct Place {
    ball: Ball,
    /// The field's value less the radius, or a bound below where the field tells
    /// no more than that the ball does not touch.
    gap: f64,
    /// Direction away from the bone.
    normal: DVec3,
}

/// Balls at the corners of a piece of a primitive, with their weights there.
type Piece = [([f64; 3], Place); 3];

impl Bone<'_> {
    /// Balls of the primitives within the margin, then the lowest of other primitives.
    fn lowest_places(
        &self,
        detector: &MedialDetector,
        near: &[u32],
    ) -> Result<Vec<(PrimitiveBall, Place)>, SceneError> {
        let medial = &detector.medial;
        let mut places: Vec<Option<Place>> = vec![None; medial.balls().len()];
        let (mut touching, mut between) = (Vec::new(), Vec::new());
        for &primitive in near {
            let mut corners = [None; 3];
            for (k, ball) in medial.primitives()[primitive as usize].into_iter().enumerate() {
                let mut weights = [0.0; 3];
                weights[k] = 1.0;
                let place = match places[ball as usize] {
                    Some(place) => place,
                    None => {
                        let place = self.place(medial.balls()[ball as usize])?;
                        if place.gap <= self.field.margin() {
                            touching.push((ball, PrimitiveBall { primitive, weights }, place));
                        }
                        *places[ball as usize].insert(place)
                    }
                };
                corners[k] = Some((weights, place));
            }
            if let [Some(a), Some(b), Some(c)] = corners
                && [a, b, c].iter().all(|(_, place)| place.gap > self.field.margin())
                && let Some((weights, place)) =
                    self.dip(&medial.primitive_balls(primitive), [a, b, c])?
            {
                between.push((PrimitiveBall { primitive, weights }, place));
            }
        }
        touching.sort_by_key(|&(ball, ..)| ball);
        let balls = touching.into_iter().map(|(_, ball, place)| (ball, place));
        Ok(balls.chain(between).collect())
    }

    /// Returns how far a ball between others may be above the lowest of them: a twentieth of the
    /// spacing.
    fn tolerance(&self) -> f64 {
        self.field.field().grid().spacing() / 20.0
    }

    fn place(&self, ball: Ball) -> Result<Place, SceneError> {
        let Ball { center, radius } = ball;
        match self.field.distance(&self.state.pose, center) {
            FieldDistance::Value { distance, normal } => {
                Ok(Place { ball, gap: distance - radius, normal })
            }
            FieldDistance::AtLeast(bound) if bound - radius > self.field.margin() => {
                Ok(Place { ball, gap: bound - radius, normal: DVec3::Z })
            }
            FieldDistance::AtLeast(known) => {
                let needed = radius + self.field.margin();
                Err(SceneError::FieldRange { name: self.name.to_owned(), known, needed })
            }
        }
    }

    /// The lowest ball between three that are outside the margin, if it is not.
    fn dip(
        &self,
        balls: &[Ball; 3],
        whole: Piece,
    ) -> Result<Option<([f64; 3], Place)>, SceneError> {
        let (margin, tolerance) = (self.field.margin(), self.tolerance());
        let lower =
            |a: ([f64; 3], Place), b: ([f64; 3], Place)| if b.1.gap < a.1.gap { b } else { a };
        let [a, b, c] = whole;
        let mut lowest = lower(lower(a, b), c);
        let mut pieces = vec![whole];
        let mut count = 0;
        while let Some(piece) = pieces.pop() {
            let bound = bound(&piece);
            if bound > margin || bound >= lowest.1.gap - tolerance {
                continue;
            }
            if count == MAX_PIECES {
                return Ok(Some(lowest));
            }
            count += 1;
            let [a, b, c] = piece;
            let between = |a: &[f64; 3], b: &[f64; 3]| {
                let weights = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
                let place = self.place(Ball::interpolate(balls, weights))?;
                Ok::<_, SceneError>((weights, place))
            };
            let [ab, bc, ca] = [between(&a.0, &b.0)?, between(&b.0, &c.0)?, between(&c.0, &a.0)?];
            lowest = [ab, bc, ca].into_iter().fold(lowest, lower);
            pieces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        Ok((lowest.1.gap - tolerance <= margin).then_some(lowest))
    }
}

/// No ball between those of a piece is lower.
fn bound(piece: &Piece) -> f64 {
    let [a, b, c] = piece.each_ref().map(|(_, place)| place);
    let edge = |a: &Place, b: &Place| a.ball.center.distance(b.ball.center);
    let size = edge(a, b).max(edge(b, c)).max(edge(c, a));
    let least = |f: fn(&Place) -> f64| f(a).min(f(b)).min(f(c));
    let largest_radius = -least(|place| -place.ball.radius);
    let sloped = |place: &Place| place.gap - size - (largest_radius - place.ball.radius);
    let by_slope = sloped(a).max(sloped(b)).max(sloped(c));
    let distance = least(|place| place.gap + place.ball.radius) - size;
    if distance > 0.0 {
        by_slope.max(least(|place| place.gap) - size * size / (6.0 * distance))
    } else {
        by_slope
    }
}
