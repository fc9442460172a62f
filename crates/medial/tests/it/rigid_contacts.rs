//! Contacts of balls with rigid bodies of known distance.

use fixtures::random::Random;
use glam::{DQuat, DVec3};
use kdop::Dop18;
use medial::{
    Ball, MedialContact, MedialError, MedialFeature, MedialScratch, MedialSurface, RigidDistance,
    RigidSide,
};
use surface::{Pose, RigidState};

use crate::support::{Detected, assert_consistent, grid_weights, number, small_muscle, vector};

/// Round bone.
struct Sphere {
    center: DVec3,
    radius: f64,
    /// Distance beyond which only a lower bound is known.
    range: f64,
}

impl Sphere {
    fn side(&self, margin: f64, tolerance: f64) -> RigidSide {
        let corners: [DVec3; 8] = std::array::from_fn(|k| {
            let sign = |axis: usize| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
            self.center + (self.radius + margin) * DVec3::new(sign(0), sign(1), sign(2))
        });
        let pose = Pose::new(DQuat::IDENTITY, self.center);
        let bounds = Dop18::from_points(&corners);
        RigidSide { state: RigidState::at_rest(pose), bounds, margin, tolerance }
    }

    fn distance(&self, p: DVec3) -> RigidDistance {
        let distance = p.distance(self.center) - self.radius;
        if distance > self.range {
            return RigidDistance::AtLeast(self.range);
        }
        let normal = (p - self.center).try_normalize().unwrap_or(DVec3::Z);
        RigidDistance::Value { distance, normal }
    }

    fn contacts(
        &self,
        body: &Detected,
        side: &RigidSide,
    ) -> Result<Vec<MedialContact>, MedialError> {
        let scratch = &mut MedialScratch::default();
        body.detector.rigid_contacts(&body.body(), side, |p| self.distance(p), scratch)
    }

    fn gap(&self, ball: Ball) -> f64 {
        ball.center.distance(self.center) - self.radius - ball.radius
    }
}

/// Balls and slabs over a round bone, beside dense sampling of every primitive.
#[test]
fn balls_and_slabs_meet_what_dense_samples_meet() {
    let (margin, tolerance) = (0.3, 0.02);
    let body = Detected::new(&small_muscle(), 24, 0.0, 8);
    let medial = body.detector.medial();
    let mut random = Random(4);
    let (mut balls, mut between, mut deeper) = (0, 0, 0);
    for _ in 0..120 {
        let center = vector(&mut random, 1.0) * DVec3::new(40.0, 20.0, 16.0);
        let radius = number(&mut random, 3.0, 7.0);
        let bone = Sphere { center, radius, range: 12.0 };
        let contacts = bone.contacts(&body, &bone.side(margin, tolerance)).expect("a large range");
        assert_consistent(&contacts, &[&body]);
        assert!(contacts.iter().all(|found| found.feature == MedialFeature::Rigid));

        // Every ball within the margin.
        for (number, &ball) in (0_u32..).zip(medial.balls()) {
            let found = contacts.iter().find(|found| {
                let corner = found.ball.weights.iter().position(|&w| w >= 1.0);
                let of_primitive = medial.primitives()[found.ball.primitive as usize];
                corner.is_some_and(|k| of_primitive[k] == number)
            });
            let gap = bone.gap(ball);
            match found {
                Some(MedialContact { contact, .. }) => {
                    // The surface may extend beyond the ball.
                    assert!(contact.gap <= gap + 1e-9, "{gap} {contact:?}");
                    assert!(gap <= margin + tolerance, "{gap} {contact:?}");
                    let away = (ball.center - center).normalize();
                    assert!(contact.normal.dot(away) > 1.0 - 1e-9, "{away} {contact:?}");
                    balls += 1;
                }
                None => assert!(gap > margin - 1e-9, "ball {number} at {gap}"),
            }
        }

        // Every primitive within the margin, by its balls or by the contact between them.
        for (number, corners) in (0_u32..).zip(medial.primitives()) {
            let corners = corners.map(|ball| medial.balls()[ball as usize]);
            let of_balls = corners.map(|ball| bone.gap(ball)).into_iter().fold(f64::MAX, f64::min);
            let mut lowest = f64::INFINITY;
            for weights in grid_weights(40) {
                lowest = lowest.min(bone.gap(Ball::interpolate(&corners, weights)));
            }
            let is_between = |found: &&MedialContact| found.ball.weights.iter().all(|&w| w < 1.0);
            let mut of_primitive = contacts.iter().filter(|found| found.ball.primitive == number);
            let found = of_primitive.find(is_between);
            if of_balls > margin && lowest <= margin {
                let found = found.unwrap_or_else(|| panic!("primitive {number} at {lowest}"));
                assert!(found.contact.gap <= lowest + tolerance, "{lowest} {found:?}");
                between += 1;
            }
            if of_balls <= margin {
                let of_found = found.map_or(f64::INFINITY, |found| {
                    bone.gap(Ball::interpolate(&corners, found.ball.weights))
                });
                let reported = of_balls.min(of_found);
                assert!(reported <= lowest + tolerance, "{number}: {reported}, not {lowest}");
                assert!(found.is_none() || of_found < of_balls - tolerance, "{number}: {found:?}");
                deeper += usize::from(found.is_some());
            }
        }
    }
    assert!(balls > 50 && between > 10, "{balls} balls, {between} between");
    assert!(deeper > 10, "{deeper} are deeper between their balls");
}

/// Where the distance of a ball in reach is unknown, that is reported, not estimated.
#[test]
fn an_unknown_distance_is_refused() {
    let body = Detected::new(&small_muscle(), 24, 0.0, 0);
    let at = |z: f64| Sphere { center: DVec3::new(0.0, 0.0, z), radius: 6.0, range: 2.0 };
    let near = at(13.5);
    let error = near.contacts(&body, &near.side(0.0, 0.02)).unwrap_err();
    let MedialError::DistanceRange { known, needed } = error else { panic!("{error}") };
    assert!(known < needed, "{error}");
    let far = at(40.0);
    assert_eq!(far.contacts(&body, &far.side(0.0, 0.02)), Ok(Vec::new()));
}

/// A lower bound is no distance, however little it is beyond the margin.
#[test]
fn a_bound_beyond_the_margin_is_no_contact() {
    let body = Detected::new(&small_muscle(), 24, 0.0, 0);
    let radii = body.detector.medial().balls().iter().map(|ball| ball.radius);
    let (radius, margin) = (radii.fold(0.0, f64::max), 0.3);
    let all = Sphere { center: DVec3::ZERO, radius: 100.0, range: 0.0 };
    let side = RigidSide { margin, tolerance: 0.5, ..all.side(margin, 0.5) };
    let distance = |_| RigidDistance::AtLeast(radius + margin + 0.1);
    let scratch = &mut MedialScratch::default();
    let contacts = body.detector.rigid_contacts(&body.body(), &side, distance, scratch);
    assert_eq!(contacts, Ok(Vec::new()));
}

/// Contacts of six slabs around one ball in the plane z = 0, of radius 1, with a rigid body of this
/// distance.
fn contacts_of_a_fan(
    distance: impl Fn(DVec3) -> RigidDistance,
    margin: f64,
    tolerance: f64,
) -> Result<Vec<MedialContact>, MedialError> {
    let mut balls = vec![Ball::new(DVec3::ZERO, 1.0)];
    let mut slabs = Vec::new();
    for k in 0..6 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 6.0).sin_cos();
        balls.push(Ball::new(10.0 * DVec3::new(cos, sin, 0.0), 1.0));
        slabs.push([0, 1 + k, 1 + (k + 1) % 6]);
    }
    let medial = MedialSurface::new(balls, Vec::new(), slabs).expect("valid");
    let mesh = fixtures::shapes::plate(DVec3::new(22.0, 20.0, 2.0), [8, 8]);
    let body = Detected::from_medial(&mesh, medial, 0.0, 0);
    let everywhere = Dop18::from_points(&[DVec3::splat(-50.0), DVec3::splat(50.0)]);
    let state = RigidState::at_rest(Pose::new(DQuat::IDENTITY, DVec3::ZERO));
    let side = RigidSide { state, bounds: everywhere.inflated(50.0), margin, tolerance };
    let scratch = &mut MedialScratch::default();
    body.detector.rigid_contacts(&body.body(), &side, distance, scratch)
}

/// A cone below the middle comes within the tolerance beyond the margin at the ball that all slabs
/// share: one contact, not one per slab.
#[test]
fn a_ball_that_slabs_share_is_one_contact() {
    let (margin, tolerance) = (0.1, 0.5);
    let tip = |height: f64| {
        let distance = move |p: DVec3| p.z - height + 0.5 * p.truncate().length();
        let value = move |p| RigidDistance::Value { distance: distance(p), normal: DVec3::Z };
        contacts_of_a_fan(value, margin, tolerance).expect("a known distance")
    };
    let contacts = tip(-1.2);
    assert_eq!(contacts.len(), 1, "{contacts:?}");
    let weights = contacts[0].ball.weights;
    assert!(weights.contains(&1.0), "{weights:?}");

    // Within the margin it is one contact, too, and far from it none.
    assert_eq!((tip(-1.05).len(), tip(-1.7).len()), (1, 0));
}

/// A slab whose balls are just within the margin, and whose middle is deep in the rigid body.
#[test]
fn balls_within_the_margin_hide_no_deeper_ones() {
    let (margin, tolerance, radius) = (1.0, 0.05, 4.0);
    let middle = (DVec3::X * 10.0 + DVec3::new(5.0, 75.0_f64.sqrt(), 0.0)) / 3.0;
    let distance = |p: DVec3| RigidDistance::Value {
        distance: p.distance(middle) - radius,
        normal: (p - middle).try_normalize().unwrap_or(DVec3::Z),
    };
    let contacts = contacts_of_a_fan(distance, margin, tolerance).expect("a known distance");
    let is_ball = |found: &&MedialContact| found.ball.weights.contains(&1.0);
    assert_eq!(contacts.iter().filter(is_ball).count(), 3, "{contacts:?}");
    let deepest = contacts.iter().map(|found| found.contact.gap).fold(f64::INFINITY, f64::min);
    assert!(deepest <= -radius - 1.0 + tolerance, "{deepest}");
}

/// A gap that is certainly beyond the margin is no contact, though by less than the tolerance.
#[test]
fn gaps_that_are_certainly_beyond_the_margin_are_no_contacts() {
    let flat = |p: DVec3| RigidDistance::Value { distance: p.z + 20.0, normal: DVec3::Z };
    assert_eq!(contacts_of_a_fan(flat, 18.6, 0.5), Ok(Vec::new()));
}

/// Where lower bounds do not exclude a contact between balls, that is reported.
#[test]
fn bounds_that_exclude_no_contact_are_refused() {
    let (margin, tolerance) = (0.1, 0.5);
    let bound = |excess: f64| {
        contacts_of_a_fan(|_| RigidDistance::AtLeast(1.0 + margin + excess), margin, tolerance)
    };
    assert_eq!(bound(11.0), Ok(Vec::new()));
    let refused = bound(1e-6);
    assert!(matches!(refused, Err(MedialError::DistanceRange { .. })), "{refused:?}");
}
