//! Room that rigid bodies leave a soft one between them.

use glam::DVec3;
use kdop::Workspace;
use proximity::{ClosestPoint, NearVertex, SeparationBounds, SurfaceTree};
use scene::{BodyId, PairId, PairReport};
use surface::{closest_on_triangle, triangle};

use crate::obstacle::Obstacle;
use crate::resolution::Remaining;
use crate::run::Run;
use crate::tissue::{Tissue, fitted_tree};

/// Cosine of the angle between the normal of a vertex and the way into a wall, above which the thickness
/// under the vertex is that across the room. Below, corners of a body count, under which it is as wide as
/// it is long; above, few vertices of round bodies count.
const MIN_FACING: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Room between two rigid bodies that is less than a soft body between them is thick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Squeeze {
    /// Distance between the two rigid bodies; 0 where they overlap.
    pub(crate) room: f64,
    /// Thickness of the soft body there, at the start.
    pub(crate) thickness: f64,
}

impl Run<'_> {
    /// Names why pairs came to a standstill: the room, if there is less than a body is thick, and surfaces
    /// that nearly coincide.
    pub(crate) fn name_standstills(
        &self,
        remaining: &mut [Remaining],
        after: &[PairReport],
        standstill: Obstacle,
    ) {
        for left in remaining {
            if left.obstacle != standstill {
                continue;
            }
            let report = after.iter().find(|report| report.pair == left.pair);
            let squeeze = report.and_then(|report| self.squeeze_of_overlap(report));
            if let Some(Squeeze { room, thickness }) = squeeze {
                left.obstacle = Obstacle::Squeezed { room, thickness };
            } else if let Some(Squeeze { room, thickness }) = self.squeeze_of_both(left.pair) {
                left.obstacle = Obstacle::SqueezedTogether { room, thickness };
            } else if self.nearly_coincided(left.pair) {
                left.obstacle = Obstacle::NearlyCoincident;
            }
        }
    }

    /// Returns true if most vertices of one body were within the tolerance of the other one's surface at
    /// the start, on faces that look the same way.
    pub(crate) fn nearly_coincided(&self, pair: PairId) -> bool {
        let Some(report) = self.before.iter().find(|before| before.pair == pair) else {
            return false;
        };
        let sides = [(pair.a, &report.a_against_b), (pair.b, &report.b_against_a)];
        let mut coincided = false;
        for (id, side) in sides {
            let tissue = &self.tissues[id.index()];
            let mut count = 0;
            for near in &side.near {
                let is_on = near.gap.abs() <= self.params.tolerance;
                let outward = tissue.outward(near.vertex);
                count += usize::from(is_on && tissue.agrees(outward, near.normal));
            }
            coincided |= 2 * count > tissue.rest.len();
        }
        coincided
    }

    /// Returns the room and the thickness where a soft body and a rigid one are nearest, if there is less
    /// than the thickness and both gaps.
    pub(crate) fn squeeze_at_nearest(
        &self,
        pair: PairId,
        nearest: &SeparationBounds,
    ) -> Option<Squeeze> {
        for (soft, rigid) in [(0, 1), (1, 0)] {
            let [soft_id, rigid_id] = [soft, rigid].map(|side: usize| pair.bodies()[side]);
            let Some((tissue, wall)) = self.tissue_and_wall(soft_id, rigid_id) else { continue };

            // The thickness at the start, across the nearest face.
            let workspace = &mut Workspace::default();
            let at_rest = self.tree_at_rest(tissue)?;
            let (face, point) = (nearest.faces[soft], nearest.points[soft]);
            let foot = closest_on_triangle(point, self.scene.body(soft_id).corners(face));
            let thickness = tissue.thickness_across(&at_rest, face, foot.barycentric, workspace)?;

            // The nearest wall on the other side of the body, seen from this wall.
            let foot = nearest.points[rigid];
            let corners = self.scene.body(rigid_id).corners(nearest.faces[rigid]);
            let outward = wall.orientation() * triangle::unit_normal(corners);
            let room = self.room(rigid_id, foot, outward, thickness, workspace);
            if let Some(room) = room {
                return Some(Squeeze { room, thickness });
            }
        }
        None
    }

    /// Returns the room and the thickness where a soft body that faces a rigid one is deepest in it, if
    /// there is less than the thickness and both gaps.
    pub(crate) fn squeeze_of_overlap(&self, report: &PairReport) -> Option<Squeeze> {
        let PairId { a, b, .. } = report.pair;
        for (soft_id, rigid_id, near) in
            [(a, b, &report.a_against_b.near), (b, a, &report.b_against_a.near)]
        {
            let Some((tissue, _)) = self.tissue_and_wall(soft_id, rigid_id) else { continue };
            let faces_wall = |near: &&NearVertex| {
                near.gap < 0.0 && tissue.outward(near.vertex).dot(-near.normal) > MIN_FACING
            };
            let deepest = near.iter().filter(faces_wall).min_by(|p, q| p.gap.total_cmp(&q.gap))?;

            let workspace = &mut Workspace::default();
            let at_rest = self.tree_at_rest(tissue)?;
            let thickness = tissue.thickness_at(&at_rest, deepest.vertex, workspace)?;
            let room = self.room(rigid_id, deepest.foot, deepest.normal, thickness, workspace)?;
            return Some(Squeeze { room, thickness });
        }
        None
    }

    /// Returns the room and the thickness of both bodies where two soft ones that face each other are deepest in each other at the
    /// start, if there is less than the thickness and the gap between them.
    fn squeeze_of_both(&self, pair: PairId) -> Option<Squeeze> {
        let report = self.before.iter().find(|report| report.pair == pair)?;
        let [first, second] = pair.bodies().map(|id| &self.tissues[id.index()]);
        if first.is_rigid || second.is_rigid {
            return None;
        }
        for (own, other, near) in
            [(first, second, &report.a_against_b.near), (second, first, &report.b_against_a.near)]
        {
            let faces_other = |near: &&NearVertex| {
                near.gap < 0.0 && own.outward(near.vertex).dot(-near.normal) > MIN_FACING
            };
            let deepest = near.iter().filter(faces_other).min_by(|p, q| p.gap.total_cmp(&q.gap));
            let Some(deepest) = deepest else { continue };

            let workspace = &mut Workspace::default();
            let [own_rest, other_rest] = [self.tree_at_rest(own)?, self.tree_at_rest(other)?];
            let thickness = own.thickness_at(&own_rest, deepest.vertex, workspace)?
                + other.thickness_across(
                    &other_rest,
                    deepest.face,
                    deepest.barycentric,
                    workspace,
                )?;
            let needed = thickness + self.params.gap;
            let [behind_own, behind_other] = [deepest.normal, -deepest.normal]
                .map(|way| self.wall_distance(deepest.foot, way, needed, workspace));
            let room = behind_own? + behind_other?;
            return (room < needed).then_some(Squeeze { room, thickness });
        }
        None
    }

    /// Returns the distance from a point to the nearest rigid body in a direction, within a reach.
    fn wall_distance(
        &self,
        from: DVec3,
        direction: DVec3,
        reach: f64,
        workspace: &mut Workspace,
    ) -> Option<f64> {
        let mut nearest: Option<f64> = None;
        for wall in self.tissues.iter().filter(|tissue| tissue.is_rigid) {
            let tree = fitted_tree(self.scene.body(wall.id));
            let found = tree.closest_point(from, reach, None, workspace);
            let is_there = |found: &ClosestPoint| {
                let way = (found.foot.point - from).normalize_or_zero();
                wall.agrees(way, direction)
            };
            if let Some(found) = found.filter(is_there) {
                nearest = Some(nearest.map_or(found.distance, |last| last.min(found.distance)));
            }
        }
        nearest
    }

    /// Returns two bodies if the first is soft and the second rigid.
    fn tissue_and_wall(&self, soft: BodyId, rigid: BodyId) -> Option<(&Tissue, &Tissue)> {
        let [tissue, wall] = [soft, rigid].map(|id| &self.tissues[id.index()]);
        (!tissue.is_rigid && wall.is_rigid).then_some((tissue, wall))
    }

    /// Returns the distance from a point of a rigid body to the nearest other one on its outer side, if
    /// a body of a thickness does not fit between them; 0 where the point is inside another one.
    fn room(
        &self,
        rigid: BodyId,
        foot: DVec3,
        outward: DVec3,
        thickness: f64,
        workspace: &mut Workspace,
    ) -> Option<f64> {
        let is_opposite = |found: &ClosestPoint| {
            let way = (found.foot.point - foot).normalize_or_zero();
            self.tissues[rigid.index()].agrees(way, outward)
        };
        let needed = thickness + 2.0 * self.params.gap;
        let mut room: Option<f64> = None;
        for other in &self.tissues {
            if !other.is_rigid || other.id == rigid {
                continue;
            }
            let tree = fitted_tree(self.scene.body(other.id));
            if tree.has_inside().is_ok() && tree.contains(foot, workspace) {
                return Some(0.0);
            }
            let found = tree.closest_point(foot, needed, None, workspace);
            if let Some(found) = found.filter(is_opposite) {
                room = Some(room.map_or(found.distance, |room| room.min(found.distance)));
            }
        }
        room
    }

    /// Builds the tree of a body at the start.
    fn tree_at_rest(&self, tissue: &Tissue) -> Option<SurfaceTree> {
        let mut tree = fitted_tree(self.scene.body(tissue.id)).clone();
        tree.set_positions(tissue.rest.iter().copied()).ok()?;
        Some(tree)
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::{BodyKind, Scene};
    use surface::progress::Progress;

    use super::*;
    use crate::ResolveParams;

    /// Two soft plates 1 thick on each other, between rigid ones with less room than both are thick, and with more.
    #[test]
    fn two_soft_bodies_without_room_between_rigid_ones_are_named_so() {
        for room in [1.6_f64, 2.3] {
            let mut scene = Scene::new();
            for (name, kind, thickness, z) in [
                ("floor", BodyKind::Rigid, 4.0, -0.5 * room - 2.0),
                ("lower", BodyKind::Deformable, 1.0, 0.51 - 0.5 * room),
                ("upper", BodyKind::Deformable, 1.0, 0.5 * room.min(2.1) - 0.51),
                ("roof", BodyKind::Rigid, 4.0, 0.5 * room + 2.0),
            ] {
                let size = if thickness > 1.0 { 34.0 } else { 30.0 };
                let plate = shapes::plate(DVec3::new(size, size, thickness), [15, 15]);
                let plate = plate.translated(z * DVec3::Z);
                scene.add(name, kind, plate.surface(), plate.positions).expect("a plate");
            }
            let params = ResolveParams { gap: 0.02, ..ResolveParams::for_overlaps(0.8, 1.5) };
            let end = crate::resolve(&mut scene, &params, Progress::none()).expect("an end");
            assert_eq!(end.resolved, room > 2.0, "{:?}", end.remaining);
            for left in &end.remaining {
                let Obstacle::SqueezedTogether { room: found, thickness } = left.obstacle else {
                    panic!("{left:?}")
                };
                assert!((found - room).abs() < 0.1 && (thickness - 2.0).abs() < 0.1, "{left:?}");
            }
        }
    }
}
