//! Displacement of two bodies against each other, which bounds what a list of contacts does not hold.

use glam::{DQuat, DVec3};
use surface::Pose;

use crate::{BodyId, PairId, Scene};

/// Places of both bodies when a list was detected, in the frame of the rigid one where there is
/// one.
#[derive(Debug, Default)]
pub(crate) struct PairFrame {
    bone: Option<Bone>,
    /// Positions of the bodies that are not that bone.
    positions: [Vec<DVec3>; 2],
}

/// Rigid body of a pair.
#[derive(Clone, Copy, Debug)]
struct Bone {
    id: BodyId,
    /// Pose that its anchors are at.
    pose: Pose,
}

impl PairFrame {
    /// Takes the present places of both bodies; the memory is kept.
    pub(crate) fn renew(&mut self, scene: &Scene, pair: PairId) {
        self.bone = None;
        for id in pair.bodies() {
            let body = scene.body(id);
            if self.bone.is_none() && body.is_rigid() {
                self.bone = body.pose().map(|pose| Bone { id, pose });
            }
        }

        for (id, positions) in pair.bodies().into_iter().zip(&mut self.positions) {
            positions.clear();
            if self.bone.is_some_and(|bone| bone.id == id) {
                continue;
            }
            positions.extend_from_slice(scene.body(id).positions());
            let Some(bone) = self.bone else { continue };
            for x in positions {
                *x = bone.pose.inverse_transform_point(*x);
            }
        }
    }

    /// Bounds the displacement of vertices of both bodies against each other; `None` where a rigid
    /// body has no pose.
    pub(crate) fn displacement(&self, scene: &Scene, pair: PairId) -> Option<f64> {
        let [a, b] = [scene.body(pair.a), scene.body(pair.b)];
        let [from_a, from_b] = &self.positions;

        // In the frame of the bone, the other body alone moves.
        if let Some(bone) = self.bone {
            let pose = scene.body(bone.id).pose()?;
            let of_a = largest_move(from_a, a.positions(), &pose);
            return Some(of_a + largest_move(from_b, b.positions(), &pose));
        }
        if a.is_rigid() || b.is_rigid() {
            return None;
        }

        // Of two soft bodies, less the translation that both have in common.
        let common = 0.5 * (mean_move(from_a, a.positions()) + mean_move(from_b, b.positions()));
        let pose = Pose::new(DQuat::IDENTITY, common);
        let of_a = largest_move(from_a, a.positions(), &pose);
        Some(of_a + largest_move(from_b, b.positions(), &pose))
    }

    /// Returns the poses of the bone that anchors are at and have to be moved to; `None` where it
    /// rests.
    pub(crate) fn follow_bone(&mut self, scene: &Scene) -> Option<[Pose; 2]> {
        let bone = self.bone.as_mut()?;
        let [from, to] = [bone.pose, scene.body(bone.id).pose()?];
        bone.pose = to;
        (from != to).then_some([from, to])
    }
}

/// Computes the largest distance of positions from earlier ones at a pose; 0 without any.
fn largest_move(from: &[DVec3], to: &[DVec3], pose: &Pose) -> f64 {
    let mut largest: f64 = 0.0;
    for (from, to) in from.iter().zip(to) {
        largest = largest.max(pose.transform_point(*from).distance_squared(*to));
    }
    largest.sqrt()
}

/// Computes the mean displacement of positions.
fn mean_move(from: &[DVec3], to: &[DVec3]) -> DVec3 {
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for (from, to) in from.iter().zip(to) {
        sum += *to - *from;
        count += 1.0;
    }
    sum / f64::max(count, 1.0)
}
