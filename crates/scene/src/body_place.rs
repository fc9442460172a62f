//! Places that bodies move to.

use glam::DVec3;
use surface::Pose;

use crate::BodyId;

/// New positions of a body, at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMove<'a> {
    /// The body.
    pub body: BodyId,
    /// |V| positions.
    pub positions: &'a [DVec3],
}

/// Place of a body in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyPlace<'a> {
    /// Positions of its vertices, |V|.
    Positions(&'a [DVec3]),
    /// Pose of a rigid body, which maps the positions that it was added with to the world.
    Pose(Pose),
}
