//! Faces that stand upright on their place at rest, and would turn over: their corners take steps as one.
//!
//! Steps are held back for such a face until nothing around it moves. A step that all of its corners take keeps its
//! normal, and solutions find another way for the tissue around it.

use crate::run::Run;

impl Run<'_> {
    /// Joins the corners of faces for which the last step was held back. Those with corners that stay are left.
    pub(crate) fn join_turning_faces(&mut self) {
        let mut pairs = Vec::new();
        for &(id, face) in &self.turning_faces {
            let tissue = &self.tissues[id.index()];
            let corners = tissue.corners(face);
            if corners.iter().all(|corner| tissue.is_free(*corner)) {
                let [a, b, c] =
                    corners.map(|corner| self.scene.body(id).particles().start + corner);
                pairs.extend([[a, b], [b, c]]);
            }
        }
        let count = self.scene.bodies().last().map_or(0, |body| body.particles().end);
        self.joints = self.joints.with_joined(&pairs, count);
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::DVec3;

    use crate::run::Run;
    use crate::test_scenes::bone_and_muscle;
    use crate::{Conditions, ResolveParams};

    /// The lower side of a block has a face that stands upright below a lifted vertex, and a small bone beside its tip,
    /// which pushes that beyond the corners at the foot.
    #[test]
    fn a_face_that_stands_upright_goes_aside_as_one() {
        let block = shapes::plate(DVec3::new(8.0, 8.0, 3.0), [8, 8]).translated(1.5 * DVec3::Z);
        let vertex_at = |x: f64, y: f64| {
            let is_there = |p: &DVec3| p.distance(DVec3::new(x, y, 0.0)) < 1e-9;
            block.positions.iter().position(is_there).expect("a vertex of the grid")
        };
        let corners = [vertex_at(0.0, 0.0), vertex_at(1.0, 0.0), vertex_at(1.0, 1.0)];
        let mut x = block.positions.clone();
        x[corners[0]] = DVec3::new(1.0 - 1e-4, 0.5, 2.0);

        let bone = shapes::icosphere(0.05, 2).translated(DVec3::new(0.94, 0.5, 1.5));
        let mut scene = bone_and_muscle(bone, block);
        let params =
            ResolveParams { gap: 0.05, max_strain: 10.0, ..ResolveParams::with_smoothing(6.0) };
        let conditions = Conditions::default();
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        run.move_soft(|tissue, _| (!tissue.is_rigid).then(|| x.clone())).expect("positions");
        let turned = |run: &Run<'_>, limit: f64| {
            run.tissues[1].turned_faces(run.scene.bodies()[1].positions(), limit)
        };
        let upright = turned(&run, 1e-3);
        assert!(upright.len() == 1 && turned(&run, 0.0).is_empty(), "{upright:?}");
        let of_face = run.tissues[1].corners(upright[0]).map(|corner| corner as usize);
        assert!(corners.iter().all(|corner| of_face.contains(corner)), "{of_face:?}");

        let broken = run.open_gaps(0).expect("rounds");
        let left = run.gap_rounds.last().map(|round| round.short_features);
        assert!(left == Some(0) && broken.is_empty(), "{broken:?}: {:?}", run.gap_rounds);
        assert!(turned(&run, 0.0).is_empty(), "none is turned");
        assert!(run.joints.is_empty(), "corners are joined in these rounds only");
    }
}
