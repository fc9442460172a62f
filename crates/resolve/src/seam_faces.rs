//! Faces at seams, by which nothing leaves a body: behind them is the one it is tied to.

use kdop::Workspace;
use proximity::{ClosestPoint, NearVertex};
use scene::{BodyId, PairReport, Scene};

use crate::tissue::fitted_tree;

/// Faces of which another body has the same corners, on the other side.
#[derive(Debug, Default)]
pub(crate) struct SeamFaces {
    /// The other body of each face, by bodies; empty for bodies without any.
    pub(crate) behind: Vec<Vec<Option<BodyId>>>,
}

impl SeamFaces {
    /// Returns true if there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.behind.is_empty()
    }

    /// Returns true if a face of a body has a body behind it other than `entered`.
    pub(crate) fn closes(&self, body: BodyId, face: u32, entered: BodyId) -> bool {
        let own = self.behind.get(body.index());
        let behind = own.and_then(|own| own.get(face as usize)).copied().flatten();
        behind.is_some_and(|behind| behind != entered)
    }

    /// Moves the feet of both bodies' vertices to the nearest faces by which they can leave the other body, and drops
    /// crossings of faces at seams. Vertices outside that are within `margin` of a seam alone are left out.
    pub(crate) fn open(&self, scene: &Scene, report: &mut PairReport, margin: f64) {
        if self.is_empty() {
            return;
        }
        let [a, b] = report.pair.bodies();
        let workspace = &mut Workspace::default();
        for (pair, side) in [([a, b], &mut report.a_against_b), ([b, a], &mut report.b_against_a)] {
            let mut open = Vec::with_capacity(side.near.len());
            for near in std::mem::take(&mut side.near) {
                if self.closes(pair[1], near.face, pair[0]) {
                    open.extend(self.opened(scene, pair, &near, margin, workspace));
                } else {
                    open.push(near);
                }
            }
            side.near = open;
        }

        let is_open = |face_a, face_b| !self.closes(a, face_a, b) && !self.closes(b, face_b, a);
        report.crossing_faces.retain(|[face_a, face_b]| is_open(*face_a, *face_b));
        let near = report.a_against_b.near.iter().chain(&report.b_against_a.near);
        report.max_vertex_depth = near.fold(0.0, |depth: f64, near| depth.max(-near.gap));
    }

    /// Projects a vertex of one body to the nearest face of another by which it can leave that one; `None` where it is
    /// outside, and none is within the margin. A vertex in a body without such faces keeps its foot.
    fn opened(
        &self,
        scene: &Scene,
        [own, other]: [BodyId; 2],
        near: &NearVertex,
        margin: f64,
        workspace: &mut Workspace,
    ) -> Option<NearVertex> {
        let is_inside = near.gap < 0.0;
        let position = scene.body(own).positions()[near.vertex as usize];
        let tree = fitted_tree(scene.body(other));
        let reach = if is_inside { f64::INFINITY } else { margin };
        let mut nearest: Option<ClosestPoint> = None;
        tree.tree().nearest(position, reach, workspace, |face, _| {
            if !self.closes(other, face, own) {
                let found = tree.closest_on_face(position, face);
                let is_nearer = nearest.is_none_or(|nearest| found.is_before(&nearest));
                if is_nearer && found.distance <= reach {
                    nearest = Some(found);
                }
            }
            nearest.map_or(reach, |nearest| nearest.distance)
        });

        let Some(ClosestPoint { face, foot, distance, .. }) = nearest else {
            return is_inside.then_some(*near);
        };
        let outward = if is_inside { foot.point - position } else { position - foot.point };
        let gap = if is_inside { -distance } else { distance };
        let normal = outward.try_normalize().unwrap_or(near.normal);
        let (foot, barycentric) = (foot.point, foot.barycentric);
        Some(NearVertex { vertex: near.vertex, gap, foot, face, barycentric, normal })
    }
}

#[cfg(test)]
mod tests {
    use fixtures::{Mesh, shapes};
    use glam::DVec3;
    use proximity::PairProximity;
    use scene::{BodyKind, PairId};
    use surface::progress::Progress;

    use std::collections::BTreeSet;

    use super::*;
    use crate::exempt::Exempt;
    use crate::near_pairs::NearPairs;
    use crate::ties::Ties;
    use crate::tissue::Tissue;
    use crate::{Conditions, ResolveParams, Tie};

    const MARGIN: f64 = 0.5;

    /// Builds soft cubes of 2 side by side, of which the second is `right`, and a post .9 deep in the first.
    fn two_cubes_and_post(right: Mesh) -> (Scene, [BodyId; 3]) {
        let left = shapes::cube(2.0).translated(-DVec3::X);
        let post = shapes::plate(DVec3::new(0.2, 0.2, 2.0), [1, 1]);
        let post = post.translated(DVec3::new(-0.2, 0.0, 1.1));
        let mut scene = Scene::new();
        let mut ids = Vec::new();
        for (name, kind, mesh) in [
            ("left", BodyKind::Deformable, left),
            ("right", BodyKind::Deformable, right.translated(DVec3::X)),
            ("post", BodyKind::Rigid, post),
        ] {
            ids.push(scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body"));
        }
        scene.fit_all().expect("trees");
        (scene, ids.try_into().expect("three bodies"))
    }

    fn seam_faces(scene: &Scene, [left, right, _]: [BodyId; 3]) -> SeamFaces {
        let ties = vec![Tie { bodies: [left, right], distance: f64::MIN_POSITIVE }];
        let conditions = Conditions { ties, ..Conditions::default() };
        let params = ResolveParams::with_smoothing(6.0);
        let tissues = Tissue::of_bodies(scene, &params, Progress::none());
        let near = NearPairs::new(scene, &Exempt::NONE);
        let ties = Ties::new(
            &conditions,
            scene,
            &mut tissues.expect("tissues"),
            &near,
            &BTreeSet::new(),
            None,
        );
        ties.expect("ties").seams.faces(scene)
    }

    /// Lists the faces of a body that a bone cannot leave it by.
    fn closed(faces: &SeamFaces, scene: &Scene, body: BodyId, bone: BodyId) -> Vec<u32> {
        let count = u32::try_from(scene.body(body).surface().faces().len()).expect("few faces");
        (0..count).filter(|face| faces.closes(body, *face, bone)).collect()
    }

    #[test]
    fn both_halves_of_a_quadrilateral_are_at_the_seam_whatever_its_diagonals() {
        let cube = shapes::cube(2.0);
        let other_diagonals = Mesh {
            positions: cube.positions.iter().map(|x| DVec3::new(x.x, -x.y, x.z)).collect(),
            faces: cube.faces.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
        };
        let inside_out = Mesh {
            positions: cube.positions.clone(),
            faces: cube.faces.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
        };
        for right in [cube, other_diagonals, inside_out] {
            let (scene, ids) = two_cubes_and_post(right);
            let faces = seam_faces(&scene, ids);
            for (body, other) in [(ids[0], ids[1]), (ids[1], ids[0])] {
                let found = closed(&faces, &scene, body, ids[2]);
                assert_eq!(found.len(), 2, "{found:?}");
                for face in found {
                    let corners = scene.body(body).corners(face);
                    assert!(corners.iter().all(|corner| corner.x == 0.0), "{corners:?}");
                    assert!(
                        !faces.closes(body, face, other),
                        "the tied body itself is not kept in"
                    );
                }
            }
        }
    }

    #[test]
    fn a_vertex_goes_to_the_nearest_face_that_it_can_leave_by() {
        let (scene, ids) = two_cubes_and_post(shapes::cube(2.0));
        let faces = seam_faces(&scene, ids);
        let [left, right, post] = ids;
        let report = |body: BodyId| {
            let mut found = PairProximity::default();
            let [a, b] = [body, post].map(|id| fitted_tree(scene.body(id)));
            found.try_compute(a, b, MARGIN, Progress::none()).expect("no interruption");
            PairReport::new(PairId::new(body, post), &found)
        };

        // The seam is .1 to .3 away, the upper side .9.
        let mut in_left = report(left);
        assert!(in_left.max_vertex_depth < 0.31, "{}", in_left.max_vertex_depth);
        faces.open(&scene, &mut in_left, MARGIN);
        let deep: Vec<_> = in_left.b_against_a.near.iter().filter(|near| near.gap < 0.0).collect();
        assert_eq!(deep.len(), 4);
        for near in deep {
            let is_up = near.normal.distance(DVec3::Z) < 1e-12;
            assert!((near.gap + 0.9).abs() < 1e-12 && is_up, "{near:?}");
        }
        assert!((in_left.max_vertex_depth - 0.9).abs() < 1e-12);

        // In the body behind the seam there is nothing of it, and only the upper side is near.
        let mut near_right = report(right);
        let vertices = |report: &PairReport| report.b_against_a.near.len();
        assert!(vertices(&near_right) > 0);
        faces.open(&scene, &mut near_right, MARGIN);
        let is_upper = |near: &NearVertex| near.foot.z >= 1.0;
        assert!(near_right.b_against_a.near.iter().all(is_upper), "{near_right:?}");
    }

    #[test]
    fn what_crosses_a_seam_alone_is_left_out() {
        let (mut scene, ids) = two_cubes_and_post(shapes::cube(2.0));
        let [left, _, post] = ids;
        let across = |x: &DVec3| DVec3::new(x.z - 1.1, x.y, x.x + 0.2);
        let x: Vec<DVec3> = scene.body(post).positions().iter().map(across).collect();
        scene.move_body(post, &x).expect("positions");
        scene.fit_all().expect("trees");
        let faces = seam_faces(&scene, ids);
        let mut found = PairProximity::default();
        let [a, b] = [left, post].map(|id| fitted_tree(scene.body(id)));
        found.try_compute(a, b, MARGIN, Progress::none()).expect("no interruption");
        let mut report = PairReport::new(PairId::new(left, post), &found);
        let closed = closed(&faces, &scene, left, post);
        assert!(report.crossing_faces.iter().any(|[face, _]| closed.contains(face)));
        faces.open(&scene, &mut report, MARGIN);
        assert!(report.crossing_faces.iter().all(|[face, _]| !closed.contains(face)));
    }
}
