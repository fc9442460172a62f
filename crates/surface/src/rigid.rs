//! Rigid motion: the pose of a body and its velocity.

use glam::{DMat3, DQuat, DVec3};

/// Rigid transform from a body's own frame to the world: `p ↦ rotation · p + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose {
    rotation: DMat3,
    translation: DVec3,
}

/// Pose of a rigid body with its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RigidState {
    /// Transform from the body's own frame to the world.
    pub pose: Pose,
    /// Point of the world that `linear_velocity` is the velocity of.
    pub center: DVec3,
    /// Velocity, in lengths per time.
    pub linear_velocity: DVec3,
    /// Angular velocity, in radians per time.
    pub angular_velocity: DVec3,
}

impl Pose {
    /// The pose of a body whose own frame is the world.
    pub const IDENTITY: Self = Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// Returns a rotation, which is normalized, followed by a translation.
    #[must_use]
    pub fn new(rotation: DQuat, translation: DVec3) -> Self {
        Self { rotation: DMat3::from_quat(rotation.normalize()), translation }
    }

    /// Returns the rotation.
    #[inline]
    #[must_use]
    pub fn rotation(&self) -> DMat3 {
        self.rotation
    }

    /// Returns the translation.
    #[inline]
    #[must_use]
    pub fn translation(&self) -> DVec3 {
        self.translation
    }

    /// Transforms a point of the body's frame to the world.
    #[inline]
    #[must_use]
    pub fn transform_point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.translation
    }

    /// Transforms a point of the world to the body's frame.
    #[inline]
    #[must_use]
    pub fn inverse_transform_point(&self, p: DVec3) -> DVec3 {
        let p = p - self.translation;
        let DMat3 { x_axis, y_axis, z_axis } = self.rotation;
        DVec3::new(x_axis.dot(p), y_axis.dot(p), z_axis.dot(p))
    }

    /// Rotates a direction of the body's frame to the world.
    #[inline]
    #[must_use]
    pub fn transform_vector(&self, v: DVec3) -> DVec3 {
        self.rotation * v
    }
}

impl RigidState {
    /// Returns the state of a body that does not move.
    #[must_use]
    pub fn at_rest(pose: Pose) -> Self {
        let zero = DVec3::ZERO;
        Self { pose, center: zero, linear_velocity: zero, angular_velocity: zero }
    }

    /// Computes the velocity of the body's point at `p`, a point of the world.
    #[inline]
    #[must_use]
    pub fn velocity_at(&self, p: DVec3) -> DVec3 {
        self.linear_velocity + self.angular_velocity.cross(p - self.center)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes_a_pose() {
        // Not normalized: a pose takes care of that.
        let rotation = DQuat::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 1.1) * 3.0;
        let pose = Pose::new(rotation, DVec3::new(4.0, -1.0, 0.5));
        let p = DVec3::new(1.0, 2.0, 3.0);
        assert!(pose.inverse_transform_point(pose.transform_point(p)).distance(p) < 1e-14);
        let moved = pose.transform_point(p + DVec3::X) - pose.transform_point(p);
        assert!(moved.distance(pose.transform_vector(DVec3::X)) < 1e-14);
    }

    #[test]
    fn velocities_are_those_of_a_small_turn() {
        let (center, angular_velocity) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.3, -0.2, 0.9));
        let linear_velocity = DVec3::new(-4.0, 5.0, 0.5);
        let state = RigidState {
            center,
            linear_velocity,
            angular_velocity,
            ..RigidState::at_rest(Pose::IDENTITY)
        };
        let (p, step) = (DVec3::new(5.0, 0.0, -1.0), 1e-6);
        let turn = DQuat::from_scaled_axis(angular_velocity * step);
        let later = center + linear_velocity * step + turn * (p - center);
        assert!(((later - p) / step).distance(state.velocity_at(p)) < 1e-4);
    }
}
