//! Motions of bodies during a step, as Python gives them.

use glam::{DMat3, DQuat, DVec3};
use musculo_collide::surface::Pose;
use musculo_collide::{Body, Path, RigidBodyPath, RigidPath, StraightPath};
use pyo3::prelude::*;

use crate::arrays::{Points, points};
use crate::error::refused;

/// Pose of a rigid body: the nine numbers of a rotation, row by row, and a translation.
#[derive(Debug, FromPyObject)]
pub(crate) struct Placement([f64; 9], [f64; 3]);

/// Motion of a body from where it is.
#[derive(Debug, FromPyObject)]
pub(crate) enum Motion<'py> {
    /// Every vertex on a straight line to a new position.
    Straight(Points<'py>),
    /// A turn about an axis through a center, by an angle in radians.
    Turn { center: [f64; 3], axis: [f64; 3], angle: f64 },
    /// A rigid motion to a pose, about a center that moves on a straight line.
    Posed { pose: Placement, center: Option<[f64; 3]> },
}

impl Placement {
    pub(crate) fn pose(&self) -> Pose {
        let Self(rotation, translation) = self;
        let rotation = DQuat::from_mat3(&DMat3::from_cols_array(rotation).transpose());
        Pose::new(rotation, DVec3::from_array(*translation))
    }
}

impl Motion<'_> {
    /// Returns the paths of a body that moves like this; `start` are its present positions.
    pub(crate) fn paths<'a>(
        &'a self,
        body: &Body,
        start: &'a [DVec3],
    ) -> PyResult<Box<dyn Path + 'a>> {
        let path = match self {
            Self::Straight(array) => {
                let to = points(array)?;
                body.surface()
                    .positions(to)
                    .map_err(|error| refused(format!("body {:?}: {error}", body.name())))?;
                return Ok(Box::new(StraightPath { from: start, to }));
            }
            Self::Turn { center, axis, angle } => {
                RigidPath::turn(DVec3::from_array(*center), DVec3::from_array(*axis), *angle)
            }
            Self::Posed { pose, center } => path_to(body, &pose.pose(), *center)?,
        };
        Ok(Box::new(RigidBodyPath { from: start, path }))
    }
}

/// Returns the motion of a rigid body from its pose to another one.
fn path_to(body: &Body, to: &Pose, center: Option<[f64; 3]>) -> PyResult<RigidPath> {
    let Some(from) = body.pose() else {
        return Err(refused(format!(
            "body {:?} has no pose: it is not rigid, or its vertices were moved one by one",
            body.name()
        )));
    };
    let center = center.map_or_else(|| middle(body.positions()), DVec3::from_array);
    let turn = to.rotation() * from.rotation().transpose();
    let shift = to.translation() - turn * from.translation();
    Ok(RigidPath::new(DQuat::from_mat3(&turn), shift, center))
}

/// Returns the middle of the box around some points.
fn middle(points: &[DVec3]) -> DVec3 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &point in points {
        (min, max) = (min.min(point), max.max(point));
    }
    0.5 * (min + max)
}
