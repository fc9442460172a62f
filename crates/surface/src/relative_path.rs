//! Motion of one rigid body as another one sees it.
//!
//! Two bodies a and b turn by `A(t)` and `B(t)` about centers that shift by `s_a` and `s_b`. In the
//! frame of b, a point of a that is at `x` at time 0 is at
//!
//! ```text
//! y(t) = c_b + B(t)ᵀ u(t),   u = c + t s + v,   v = A(t) (x − c_a),   c = c_a − c_b,   s = s_a − s_b
//! ```
//!
//! This is no screw. With the angular velocities `α` and `β`, whose cross products are `[α]` and
//! `[β]`, the second derivative is `B y″ = [β]² u − 2 [β] u′ + u″`, where `u′ = s + [α] v` and
//! `u″ = [α]² v`. Since `[α] [β] − [β] [α] = [α × β]`, the terms of `v` and the others are
//!
//! ```text
//! B y″ = ([α − β]² + [α × β]) v  +  [β]² (c + t s) − 2 [β] s
//! ```
//!
//! so that `|y″| ≤ (|α − β|² + |α × β|) |x − c_a| + |β| max(|β × c|, |β × (c + s)|) + 2 |β × s|`. It
//! vanishes where both bodies turn as one about the same center.

use glam::{DAffine3, DVec3};

use crate::RigidPath;

/// Motion of a rigid body in the frame of another one, as that is at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativePath {
    of: RigidPath,
    seen_from: RigidPath,
    bend_at_center: f64,
    bend_per_length: f64,
}

impl RelativePath {
    /// Returns the motion of a body as seen from another one; `None` stands for a body at rest.
    #[must_use]
    pub fn new(of: Option<RigidPath>, seen_from: Option<RigidPath>) -> Self {
        // A body at rest turns by nothing about any center: the other's leaves no term of `c`.
        let center = of.or(seen_from).map_or(DVec3::ZERO, |path| path.center());
        let at_rest = RigidPath::at_rest(center);
        let of = of.unwrap_or(at_rest);
        let seen_from = seen_from.unwrap_or(RigidPath::at_rest(of.center()));

        let [alpha, beta] = [&of, &seen_from].map(RigidPath::angular_velocity);
        let c = of.center() - seen_from.center();
        let s = of.shift() - seen_from.shift();

        // Differences and cross products are rounded relative to their largest operands.
        const ROUNDINGS: f64 = 16.0 * f64::EPSILON;
        let (turn, distance) = (alpha.length() + beta.length(), c.length() + s.length());
        let centers = of.center().length() + seen_from.center().length();
        let bend_per_length = (alpha - beta).length_squared() + alpha.cross(beta).length();
        let of_shift = beta.length() * beta.cross(c).length().max(beta.cross(c + s).length());
        let bend_at_center = of_shift + 2.0 * beta.cross(s).length();
        Self {
            of,
            seen_from,
            bend_at_center: bend_at_center
                + ROUNDINGS * beta.length() * turn.max(1.0) * (distance + centers),
            bend_per_length: bend_per_length + ROUNDINGS * turn * turn,
        }
    }

    /// Returns the rigid map from the points of the body at time 0 to their places at a time, in the
    /// frame of the other body.
    #[must_use]
    pub fn map(&self, time: f64) -> DAffine3 {
        let (of, from) = (self.of.map(time), self.seen_from.map(time));
        let inverse = from.matrix3.transpose();
        DAffine3::from_mat3_translation(
            inverse * of.matrix3,
            inverse * (of.translation - from.translation),
        )
    }

    /// Returns the point of the body, as it is at time 0, about which the bend is the least.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.of.center()
    }

    /// Returns an upper bound of the second derivative of the way of the center.
    #[must_use]
    pub fn bend_at_center(&self) -> f64 {
        self.bend_at_center
    }

    /// Returns an upper bound of what each unit of distance from the center adds to the second
    /// derivative.
    #[must_use]
    pub fn bend_per_length(&self) -> f64 {
        self.bend_per_length
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    fn paths() -> [RigidPath; 2] {
        let first = DQuat::from_rotation_x(1.1) * DQuat::from_rotation_z(0.4);
        let second = DQuat::from_rotation_y(-1.4);
        [
            RigidPath::new(first, DVec3::new(3.0, -1.0, 9.0), DVec3::new(1.0, 2.0, 3.0)),
            RigidPath::new(second, DVec3::new(-7.0, 0.5, 2.0), DVec3::new(-20.0, 4.0, 11.0)),
        ]
    }

    #[test]
    fn a_relative_place_is_the_place_seen_from_the_other_body() {
        let [a, b] = paths();
        let relative = RelativePath::new(Some(a), Some(b));
        for time in [0.0, 0.3, 1.0] {
            let x = DVec3::new(4.0, -2.0, 30.0);
            let y = relative.map(time).transform_point3(x);
            let distance = b.transform_point(y, time).distance(a.transform_point(x, time));
            assert!(distance < 1e-13, "{distance} at {time}");
        }
    }

    /// The second derivative of skew turns by differences is below the bound, and near it somewhere.
    #[test]
    fn bends_bound_second_differences() {
        let step = 1e-3;
        let [a, b] = paths();
        for (of, from) in [(Some(a), Some(b)), (Some(b), Some(a)), (Some(a), None), (None, Some(b))]
        {
            let relative = RelativePath::new(of, from);
            let mut largest = 0.0_f64;
            for number in 0..200_u32 {
                let time = 0.01 + f64::from(number) / 205.0;
                let direction = DQuat::from_rotation_z(f64::from(number)) * DVec3::X;
                let x = relative.center()
                    + 40.0 * (DQuat::from_rotation_x(0.7 * f64::from(number)) * direction);
                let at = |time| relative.map(time).transform_point3(x);
                let second = at(time - step) - 2.0 * at(time) + at(time + step);
                let measured = second.length() / (step * step);
                let bound = relative.bend_at_center() + 40.0 * relative.bend_per_length();
                assert!(measured <= bound * (1.0 + 1e-6), "{measured} above {bound}");
                largest = largest.max(measured / bound);
            }
            assert!(largest > 0.5, "the bound is {largest} of what it needs to be");
        }
    }

    #[test]
    fn bodies_that_turn_as_one_do_not_bend() {
        let [a, _] = paths();
        let relative = RelativePath::new(Some(a), Some(a));
        assert!(relative.bend_at_center() < 1e-12, "{relative:?}");
        assert!(relative.bend_per_length() < 1e-13, "{relative:?}");
    }
}
