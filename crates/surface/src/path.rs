//! Paths of bodies during a step, with bounds on how they curve.

use glam::{DAffine3, DQuat, DVec3};

/// Paths of the points of a body from time 0 to time 1 of a step.
///
/// A path curves no more than its [bend](Self::bend) says: over a piece of length `h`, its points
/// stay within `bend h² / 8` of the straight way. Detection relies on it.
pub trait Path: Sync {
    /// Returns the position of a vertex at a time. At time 0 this is where the vertex is.
    ///
    /// The result is accurate to some dozen roundings of the largest coordinate on the way.
    fn position(&self, vertex: u32, time: f64) -> DVec3;

    /// Writes the positions of some vertices at one time, each as [`position`](Self::position)
    /// returns it, to the bit.
    ///
    /// Paths whose vertices share work, such as the sine of an angle, do it here once.
    fn positions(&self, vertices: &[u32], time: f64, out: &mut [DVec3]) {
        for (out, &vertex) in out.iter_mut().zip(vertices) {
            *out = self.position(vertex, time);
        }
    }

    /// Returns an upper bound of the length of the second derivative of a vertex's position by the
    /// time of the step: 0 for a straight path.
    fn bend(&self, vertex: u32) -> f64;

    /// Returns the positions of all vertices at time 1, if these are known and all paths straight.
    ///
    /// A step of such bodies takes no time for their paths.
    fn straight_to(&self) -> Option<&[DVec3]> {
        None
    }

    /// Returns the rigid motion that all vertices follow, if there is one.
    ///
    /// Detection between two such bodies takes their relative motion, and refits no tree.
    fn rigid(&self) -> Option<NearRigidPath> {
        None
    }
}

/// Rigid motion that vertices follow, up to a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearRigidPath {
    /// The motion.
    pub path: RigidPath,
    /// Maximum distance of a vertex from where the motion leads it, at any time.
    pub deviation: f64,
}

/// Rigid motion of a body from where it is.
#[derive(Clone, Copy, Debug)]
pub struct RigidBodyPath<'a> {
    /// |V| positions at time 0.
    pub from: &'a [DVec3],
    /// The motion.
    pub path: RigidPath,
}

impl Path for RigidBodyPath<'_> {
    fn position(&self, vertex: u32, time: f64) -> DVec3 {
        self.path.transform_point(self.from[vertex as usize], time)
    }

    fn positions(&self, vertices: &[u32], time: f64, out: &mut [DVec3]) {
        let place = self.path.place(time);
        for (out, &vertex) in out.iter_mut().zip(vertices) {
            *out = place.transform_point(self.from[vertex as usize]);
        }
    }

    fn bend(&self, vertex: u32) -> f64 {
        self.path.bend(self.from[vertex as usize])
    }

    fn rigid(&self) -> Option<NearRigidPath> {
        Some(NearRigidPath { path: self.path, deviation: 0.0 })
    }
}

/// Straight paths from one state to another.
#[derive(Clone, Copy, Debug)]
pub struct StraightPath<'a> {
    /// |V| positions at time 0.
    pub from: &'a [DVec3],
    /// |V| positions at time 1.
    pub to: &'a [DVec3],
}

impl Path for StraightPath<'_> {
    fn position(&self, vertex: u32, time: f64) -> DVec3 {
        let [from, to] = [self.from, self.to].map(|x| x[vertex as usize]);
        from.lerp(to, time)
    }

    fn bend(&self, _vertex: u32) -> f64 {
        0.0
    }

    fn straight_to(&self) -> Option<&[DVec3]> {
        Some(self.to)
    }
}

/// Rigid motion that turns with a constant angular velocity about a center, which moves on a
/// straight line.
///
/// The center is a joint's, where there is one. With a center on its screw axis the motion is a
/// screw. A screw axis itself would be ill defined where a body hardly turns; a center never is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidPath {
    center: DVec3,
    shift: DVec3,
    axis: DVec3,
    angle: f64,
}

/// Place of a body on its [`RigidPath`] at one time.
///
/// Points are turned about the center, and not about the origin: they are rounded as far as they
/// are from the center.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidPlace {
    rotation: DQuat,
    /// The center at time 0 and at the time.
    centers: [DVec3; 2],
}

impl RigidPlace {
    /// Returns where a point is that is at `x` at time 0.
    #[must_use]
    #[inline]
    pub fn transform_point(&self, x: DVec3) -> DVec3 {
        let [from, to] = self.centers;
        to + self.rotation * (x - from)
    }
}

impl RigidPath {
    /// Returns the motion that ends with the map `x ↦ rotation x + translation` of present
    /// positions. `center` is the present place of the center. The body turns the shorter way.
    #[must_use]
    pub fn new(rotation: DQuat, translation: DVec3, center: DVec3) -> Self {
        // Of both quaternions of a rotation, the one with the smaller angle.
        let rotation = rotation.normalize();
        let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
        let (axis, angle) = rotation.to_axis_angle();
        let shift = rotation * center + translation - center;
        Self { center, shift, axis, angle }
    }

    /// Returns the motion of a turn about an axis through a center, by an angle in radians of any
    /// size.
    #[must_use]
    pub fn turn(center: DVec3, axis: DVec3, angle: f64) -> Self {
        Self { center, shift: DVec3::ZERO, axis: direction(axis), angle }
    }

    /// Returns the motion of a body at rest, about any center.
    #[must_use]
    pub fn at_rest(center: DVec3) -> Self {
        Self { center, shift: DVec3::ZERO, axis: DVec3::Z, angle: 0.0 }
    }

    /// Returns the center at time 0.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Returns how far the center moves.
    #[must_use]
    pub fn shift(&self) -> DVec3 {
        self.shift
    }

    /// Returns the angle of the turn in radians.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Returns the angular velocity in radians per step.
    #[must_use]
    pub fn angular_velocity(&self) -> DVec3 {
        self.axis * self.angle
    }

    /// Returns the rigid map from points at time 0 to their places at a time.
    #[must_use]
    pub fn map(&self, time: f64) -> DAffine3 {
        let rotation = DQuat::from_axis_angle(self.axis, self.angle * time);
        let center = self.center + time * self.shift;
        DAffine3::from_rotation_translation(rotation, center - rotation * self.center)
    }

    /// Returns where a point is at a time that is at `x` at time 0.
    #[must_use]
    pub fn transform_point(&self, x: DVec3, time: f64) -> DVec3 {
        self.place(time).transform_point(x)
    }

    /// Returns the place at a time, which serves many points.
    #[must_use]
    pub fn place(&self, time: f64) -> RigidPlace {
        RigidPlace {
            rotation: DQuat::from_axis_angle(self.axis, self.angle * time),
            centers: [self.center, self.center + time * self.shift],
        }
    }

    /// Returns a direction as it is at time 1 that is `v` at time 0.
    #[must_use]
    pub fn transform_vector(&self, v: DVec3) -> DVec3 {
        DQuat::from_axis_angle(self.axis, self.angle) * v
    }

    /// Bounds the second derivative of the way of the point that is at `x` at time 0.
    #[must_use]
    pub fn bend(&self, x: DVec3) -> f64 {
        // The centripetal acceleration: distance from the axis by the square of the angle.
        let arm = (x - self.center).cross(self.axis).length();
        let roundings = 16.0 * f64::EPSILON * (x - self.center).length();
        (arm + roundings) * self.angle * self.angle * (1.0 + 8.0 * f64::EPSILON)
    }
}

/// Returns the direction of a vector of any length above 0. Squares of very long and of very short
/// vectors leave the range of numbers: these are scaled first.
fn direction(v: DVec3) -> DVec3 {
    let size = v.abs().max_element();
    let is_ordinary = (1e-100..=1e100).contains(&size);
    if is_ordinary { v.normalize() } else { (v / size).normalize() }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn a_turn_follows_its_arc() {
        let path = RigidPath::turn(DVec3::new(1.0, 0.0, 0.0), 2.0 * DVec3::Z, PI / 2.0);
        let x = DVec3::new(3.0, 0.0, 5.0);
        for (time, angle) in [(0.0, 0.0), (0.5, PI / 4.0), (1.0, PI / 2.0)] {
            let expected = DVec3::new(1.0 + 2.0 * f64::cos(angle), 2.0 * f64::sin(angle), 5.0);
            assert!(path.transform_point(x, time).distance(expected) < 1e-14, "{time}");
        }
        let centripetal = 2.0 * (PI / 2.0).powi(2);
        assert!((path.bend(x) / centripetal - 1.0).abs() < 1e-13, "{}", path.bend(x));
    }

    #[test]
    fn an_axis_has_any_length() {
        let x = DVec3::new(3.0, 0.0, 5.0);
        for length in [1e-320, 1e-200, 1e-160, 1e-3, 1e160, 1e300] {
            let path = RigidPath::turn(DVec3::ZERO, length * DVec3::Z, PI / 2.0);
            let end = path.transform_point(x, 1.0);
            assert!(end.distance(DVec3::new(0.0, 3.0, 5.0)) < 1e-14, "{length}: {end}");
        }
    }

    #[test]
    fn a_map_is_reached_at_the_end_by_the_shorter_way() {
        let rotation = DQuat::from_rotation_y(1.9) * DQuat::from_rotation_x(0.4);
        let (shift, center) = (DVec3::new(4.0, -2.0, 1.0), DVec3::new(9.0, 8.0, 7.0));
        for rotation in [rotation, -rotation] {
            let path = RigidPath::new(rotation, shift, center);
            assert!(path.angle() <= PI, "{}", path.angle());
            for x in [DVec3::ZERO, center, DVec3::new(-30.0, 5.0, 2.0)] {
                assert!(path.transform_point(x, 0.0).distance(x) < 1e-14);
                let end = rotation * x + shift;
                assert!(path.transform_point(x, 1.0).distance(end) < 1e-13, "{x}");
            }
        }
    }

    /// The deviation from chords of pieces of any length, by samples.
    #[test]
    fn paths_stay_near_their_chords() {
        let path = RigidPath::new(DQuat::from_rotation_z(2.5), DVec3::X, DVec3::new(0.0, 3.0, 0.0));
        let x = DVec3::new(100.0, -20.0, 4.0);
        for pieces in [1_u32, 2, 7, 100] {
            let piece = 1.0 / f64::from(pieces);
            for number in 0..pieces {
                let [from, to] = [number, number + 1].map(|k| f64::from(k) * piece);
                let ends = [from, to].map(|time| path.transform_point(x, time));
                for share in [0.1, 0.5, 0.77] {
                    let time = from + share * (to - from);
                    let chord = ends[0].lerp(ends[1], share);
                    let deviation = path.transform_point(x, time).distance(chord);
                    assert!(deviation <= path.bend(x) * piece * piece / 8.0, "{pieces} {number}");
                }
            }
        }
    }
}
