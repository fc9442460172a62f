//! Restoration of shape: no face turns over, no edge is torn, no sheet is pressed through itself,
//! and volumes are kept.

use glam::DVec3;
use proximity::SurfaceTree;
use surface::progress::{Interrupted, Progress};
use surface::triangle;

use crate::damage::self_crossings_at;
use crate::free_step::MAX_HOLD_PASSES;
use crate::tissue::{Tissue, corners_at};

/// Smoothing passes over strained tissue. Each halves the difference between a
/// vertex and its surroundings. Below, strain remains; above, deep folds take longer.
const SMOOTHING_PASSES: usize = 20;

/// Passes in which corners are made to move as one. Faces share corners: below, one face
/// undoes another's; above, little changes.
const STIFFENING_PASSES: usize = 3;

impl Tissue {
    /// Holds back vertices of faces that a step would turn over, or let cross others of the body, but for those of one
    /// tangle; returns the faces that the step would turn over as it is.
    ///
    /// `shares` are the parts of the displacements `d` that are taken, |V|.
    pub(crate) fn limit_step(
        &self,
        tree: &SurfaceTree,
        d: &[DVec3],
        shares: &mut [f64],
        progress: Progress<'_>,
    ) -> Result<Vec<u32>, Interrupted> {
        let from = tree.positions().as_slice();
        let (mut turned_before, mut crossed_before) = (None, None);
        let mut turning = Vec::new();
        for pass in 0..2 * MAX_HOLD_PASSES {
            let mut x = from.to_vec();
            for (x, (d, share)) in x.iter_mut().zip(d.iter().zip(shares.iter())) {
                *x += *share * *d;
            }
            let x = self.written(x);

            // Faces that were turned or crossed before hold nobody back: found where any are now.
            let mut faces = self.turned_faces(&x, 0.0);
            if !faces.is_empty() {
                let before = turned_before.get_or_insert_with(|| self.turned_faces(from, 0.0));
                faces.retain(|face| before.binary_search(face).is_err());
            }
            if pass == 0 {
                turning.clone_from(&faces);
            }
            let crossing = self_crossings_at(&x, tree, progress)?;
            if !crossing.is_empty() {
                let before = match crossed_before.take() {
                    Some(before) => before,
                    None => self.self_crossings(tree, progress)?,
                };
                let is_anew = |pair: &[u32; 2]| !before.contains(pair) && !self.is_tangled(pair);
                faces.extend(crossing.into_iter().filter(is_anew).flatten());
                crossed_before = Some(before);
            }
            if faces.is_empty() {
                return Ok(turning);
            }

            // With a ring around them, so that the hold does not end steeply.
            let mut held: Vec<u32> =
                faces.into_iter().flat_map(|face| self.corners(face)).collect();
            for i in 0..held.len() {
                held.extend(self.links(held[i]).iter().map(|link| link.neighbor));
            }
            sort_dedup(&mut held);
            let factor = if pass >= MAX_HOLD_PASSES { 0.0 } else { 0.5 };
            for vertex in held {
                shares[vertex as usize] *= factor;
            }
        }

        // Where holding back single vertices does not end, all of them rest.
        shares.fill(0.0);
        Ok(turning)
    }

    /// Smooths the displacement where a limit on strain is exceeded, until none is or all passes
    /// are done.
    ///
    /// Tissue that is stretched along a sheet thins: a sheet is pressed where it is thinner than one that
    /// is stretched both ways by the limit and keeps its volume.
    pub(crate) fn limit_strain(
        &self,
        max_strain: f64,
        x: &mut [DVec3],
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        let mut moved = self.displaced_vertices(x);
        for _ in 0..SMOOTHING_PASSES {
            progress.report(0.0)?;

            // The corners of all that is turned, torn or pressed.
            let mut strained = Vec::new();
            for face in self.turned_among(&moved, x, self.params.tuning.min_cosine) {
                strained.extend(self.corners(face));
            }
            self.add_torn(&moved, x, max_strain, &mut strained);
            self.add_pressed(&moved, x, (1.0 + max_strain).powi(-2), &mut strained);
            if strained.is_empty() {
                break;
            }
            sort_dedup(&mut strained);
            self.smooth(&strained, x);
            mark_only(&strained, &mut moved);
        }
        Ok(())
    }

    /// Moves the corners of faces that are about to turn over as one, as far as the one that
    /// moves farthest. Smoothing alone would be undone by the next push.
    pub(crate) fn stiffen(
        &self,
        x: &mut [DVec3],
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        let mut moved = self.displaced_vertices(x);
        for _ in 0..STIFFENING_PASSES {
            progress.report(0.0)?;
            let turned = self.turned_among(&moved, x, self.params.tuning.min_cosine);
            if turned.is_empty() {
                break;
            }
            let mut stiffened = Vec::new();
            for face in turned {
                // The mean displacement, lengthened to the largest along it.
                let corners = self.corners(face);
                let u = corners.map(|v| self.displacement(v, x));
                let mean = u.iter().sum::<DVec3>() / 3.0;
                let direction = mean.normalize_or_zero();
                let mut beyond: f64 = 0.0;
                for u in u {
                    beyond = beyond.max((u - mean).dot(direction));
                }
                for v in corners {
                    x[v as usize] = self.rest[v as usize] + mean + beyond * direction;
                }
                stiffened.extend(corners);
            }
            mark_only(&stiffened, &mut moved);
        }
        Ok(())
    }

    /// Moves free vertices along their normals until the volume is that at rest.
    ///
    /// Free are vertices that have moved and that are not near another body.
    pub(crate) fn restore_volume(&self, x: &mut [DVec3]) {
        let Some(volume) = self.volume else { return };
        let missing = volume - self.volume_at(x);
        if missing.abs() <= self.params.volume_tolerance() * volume.abs() {
            return;
        }

        // Each vertex moves in proportion to its displacement so far, by no more than that.
        let mut weights = vec![0.0; x.len()];
        for (v, weight) in weights.iter_mut().enumerate() {
            if !self.is_near[v] {
                *weight = self.rest[v].distance(x[v]);
            }
        }

        // To first order, the volume grows in proportion to the rate of all.
        let volume_per_rate = self.swept_volume(&weights);
        if volume_per_rate > 0.0 {
            let rate = (missing / volume_per_rate).clamp(-1.0, 1.0);
            let normals = surface::vertex_normals(self.surface.faces(), x);
            for ((x, weight), normal) in x.iter_mut().zip(weights).zip(normals) {
                *x += rate * weight * normal;
            }
        }
    }

    /// Returns the displacement of a vertex from rest.
    fn displacement(&self, vertex: u32, x: &[DVec3]) -> DVec3 {
        x[vertex as usize] - self.rest[vertex as usize]
    }

    /// Returns true for each vertex that is not at rest. Between others nothing is strained.
    fn displaced_vertices(&self, x: &[DVec3]) -> Vec<bool> {
        x.iter().zip(&self.rest).map(|(x, rest)| x != rest).collect()
    }

    /// Finds the faces whose normals have turned until their cosine is at most `limit`.
    pub(crate) fn turned_faces(&self, x: &[DVec3], limit: f64) -> Vec<u32> {
        self.turned_among(&self.displaced_vertices(x), x, limit)
    }

    /// Finds the faces with a corner that has `moved` whose normals have turned until their cosine is at
    /// most `limit`.
    fn turned_among(&self, moved: &[bool], x: &[DVec3], limit: f64) -> Vec<u32> {
        let mut turned = Vec::new();
        for (number, &face) in (0..).zip(self.surface.faces()) {
            if !any_of(face, moved) {
                continue;
            }

            // Compared with the lengths, so that no square root of a sliver divides.
            let before = self.rest_face_normals[number as usize];
            let after = triangle::normal(corners_at(face, x));
            let is_turned = before.dot(after) <= limit * before.length() * after.length();
            if before != DVec3::ZERO && is_turned {
                turned.push(number);
            }
        }
        turned
    }

    /// Adds the ends of edges of which one has `moved` and whose displacements differ by more than `limit`
    /// edge lengths.
    fn add_torn(&self, moved: &[bool], x: &[DVec3], limit: f64, strained: &mut Vec<u32>) {
        for &[p, q] in self.surface.edges() {
            if !any_of([p, q], moved) {
                continue;
            }
            let before = self.rest[q as usize] - self.rest[p as usize];
            let after = x[q as usize] - x[p as usize];
            if before != after && (after - before).length() > limit * before.length() {
                strained.extend([p, q]);
            }
        }
    }

    /// Adds both sides of sheets of which one has `moved` and that are thinner than `limit` of their thickness
    /// at rest.
    fn add_pressed(&self, moved: &[bool], x: &[DVec3], limit: f64, strained: &mut Vec<u32>) {
        for v in (0..).take(x.len()) {
            let Some(strut) = self.strut(v) else { continue };
            if !any_of([v], moved) && !any_of(strut.corners, moved) {
                continue;
            }
            let before = strut.interpolate(|v| self.rest[v as usize]) - self.rest[v as usize];
            let after = strut.interpolate(|v| x[v as usize]) - x[v as usize];
            if after.dot(before) < limit * before.length_squared() {
                strained.push(v);
                strained.extend(strut.corners);
            }
        }
    }

    /// Moves each vertex halfway to its equilibrium with its links.
    fn smooth(&self, vertices: &[u32], x: &mut [DVec3]) {
        for &vertex in vertices {
            let mean = self.equilibrium(vertex, |v| self.displacement(v, x), 0.0);
            if let Some(mean) = mean {
                let u = 0.5 * (self.displacement(vertex, x) + mean);
                x[vertex as usize] = self.rest[vertex as usize] + u;
            }
        }
    }
}

/// Returns true if one of some vertices is marked.
fn any_of<const N: usize>(vertices: [u32; N], marks: &[bool]) -> bool {
    vertices.iter().any(|vertex| marks[*vertex as usize])
}

/// Marks some vertices, and no others.
fn mark_only(vertices: &[u32], marks: &mut [bool]) {
    marks.fill(false);
    for &vertex in vertices {
        marks[vertex as usize] = true;
    }
}

fn sort_dedup(vertices: &mut Vec<u32>) {
    vertices.sort_unstable();
    vertices.dedup();
}

#[cfg(test)]
mod tests {
    use fixtures::{Mesh, shapes};
    use scene::{BodyKind, Scene};

    use super::*;
    use crate::ResolveParams;
    use crate::damage::rounded_to_single;
    use crate::tissue::fitted_tree;

    /// Builds a scene of one body, and its tissue.
    fn planted(mesh: Mesh) -> (Scene, Tissue) {
        let mut scene = Scene::new();
        let surface = mesh.surface();
        scene.add("muscle", BodyKind::Deformable, surface, mesh.positions).expect("a body");
        scene.fit_all().expect("a tree");
        let params = ResolveParams::with_smoothing(6.0);
        let tissues = Tissue::of_bodies(&scene, &params, Progress::none());
        let mut tissues = tissues.expect("no interruption");
        (scene, tissues.remove(0))
    }

    /// Returns the largest difference between the displacements of the two ends of an edge
    /// \[its length\].
    fn stretch(tissue: &Tissue, x: &[DVec3]) -> f64 {
        let u = |v: u32| x[v as usize] - tissue.rest[v as usize];
        let length = |p: u32, q: u32| tissue.rest[p as usize].distance(tissue.rest[q as usize]);
        let edges = tissue.surface.edges().iter();
        edges.map(|&[p, q]| u(p).distance(u(q)) / length(p, q)).fold(0.0, f64::max)
    }

    #[test]
    fn a_vertex_torn_out_is_brought_back_until_no_edge_turns_round() {
        let (_, tissue) = planted(shapes::icosphere(10.0, 3));
        let mut x = tissue.rest.clone();
        x[40] += 4.0 * tissue.rest_normals[40];
        assert!(stretch(&tissue, &x) > 2.0, "torn out by more than two edges");
        tissue.limit_strain(0.8, &mut x, Progress::none()).expect("no interruption");
        let left = stretch(&tissue, &x);
        assert!(left <= 1.0, "{left} lengths of an edge");
        let mut loose = tissue.rest.clone();
        loose[40] += 4.0 * tissue.rest_normals[40];
        tissue.limit_strain(1.6, &mut loose, Progress::none()).expect("no interruption");
        let looser = stretch(&tissue, &loose);
        assert!(looser > left, "the limit is wider: {looser}, not {left}");
    }

    /// Limits strain as [`Tissue::limit_strain`] does, with all that there is measured in every pass.
    fn limit_strain_of_all(tissue: &Tissue, max_strain: f64, x: &mut [DVec3]) -> usize {
        let all = vec![true; x.len()];
        for pass in 0..SMOOTHING_PASSES {
            let mut strained = Vec::new();
            for face in tissue.turned_among(&all, x, tissue.params.tuning.min_cosine) {
                strained.extend(tissue.corners(face));
            }
            tissue.add_torn(&all, x, max_strain, &mut strained);
            tissue.add_pressed(&all, x, (1.0 + max_strain).powi(-2), &mut strained);
            if strained.is_empty() {
                return pass;
            }
            sort_dedup(&mut strained);
            tissue.smooth(&strained, x);
        }
        SMOOTHING_PASSES
    }

    #[test]
    fn only_what_has_moved_is_strained_anew() {
        let (scene, mut tissue) = planted(shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3));
        let (tree, workspace) = (fitted_tree(&scene.bodies()[0]), &mut Default::default());
        for vertex in (0..).take(tissue.rest.len()) {
            tissue.find_strut(tree, vertex, 9.0, workspace);
        }
        let mut passes = 0;
        for (step, max_strain) in [(0.0, 0.4), (1.0, 0.8), (2.0, 1.5)] {
            // One side is pressed onto the other, and shaken.
            let mut x = tissue.rest.clone();
            for (number, x) in (0..).zip(&mut x) {
                let shake = f64::sin(17.0 * f64::from(number) + step);
                let is_pressed = x.z > 0.0 && x.truncate().length() < 5.0;
                *x += if is_pressed { DVec3::new(shake, 0.3, -3.0) } else { DVec3::ZERO };
            }
            let mut of_all = x.clone();
            passes += limit_strain_of_all(&tissue, max_strain, &mut of_all);
            tissue.limit_strain(max_strain, &mut x, Progress::none()).expect("no interruption");
            assert_eq!(x, of_all, "to the bit");
        }
        assert!(passes > 9, "{passes} passes");
    }

    /// Builds a flat grid of cells four times as long as wide, with a vertex lifted and pushed
    /// across its long edges: faces turn over, no edge is torn.
    fn turned_over() -> (Tissue, Vec<DVec3>) {
        let plate = shapes::plate(DVec3::new(12.0, 3.0, 4.0), [12, 12]);
        let (_, tissue) = planted(plate);
        let vertex =
            (0..).zip(&tissue.rest).find(|(_, x)| x.z > 1.9 && x.x.abs() < 0.1 && x.y.abs() < 0.1);
        let (vertex, _): (usize, _) = vertex.expect("the middle of the upper side");
        let mut x = tissue.rest.clone();
        x[vertex] += DVec3::new(0.0, 0.3, 0.05);
        assert!(tissue.count_flipped(&x) > 0, "turned over");
        (tissue, x)
    }

    #[test]
    fn faces_that_turned_over_are_brought_back_though_no_edge_is_torn() {
        let (tissue, mut x) = turned_over();
        tissue.limit_strain(10.0, &mut x, Progress::none()).expect("no interruption");
        assert_eq!(tissue.count_flipped(&x), 0);
        let leans = tissue.turned_faces(&x, 0.15);
        assert!(leans.is_empty(), "nor does one stand on its edge: {leans:?}");
    }

    /// Builds a thin ellipsoid, and the displacements that press its upper side through its lower one.
    fn pressed_through() -> (Scene, Tissue, Vec<DVec3>) {
        let (scene, tissue) = planted(shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3));
        let mut d = vec![DVec3::ZERO; tissue.rest.len()];
        for (d, rest) in d.iter_mut().zip(&tissue.rest) {
            if rest.z > 0.0 && rest.truncate().length() < 3.0 {
                d.z = -4.5;
            }
        }
        (scene, tissue, d)
    }

    fn count_self_crossings(x: &[DVec3], tree: &SurfaceTree) -> usize {
        self_crossings_at(x, tree, Progress::none()).expect("no interruption").len()
    }

    #[test]
    fn a_step_that_would_cross_the_body_itself_is_held_back_there() {
        let (scene, tissue, mut d) = pressed_through();
        let tree = fitted_tree(&scene.bodies()[0]);
        let far = tissue.rest.iter().position(|x| x.x < -11.0).expect("the rim");
        d[far] = 0.1 * DVec3::Y;
        let mut shares = vec![1.0; d.len()];
        let none = Progress::none();
        tissue.limit_step(tree, &d, &mut shares, none).expect("no interruption");
        let taken = |v: usize| tissue.rest[v] + shares[v] * d[v];
        let x: Vec<DVec3> = (0..d.len()).map(taken).collect();
        assert_eq!(tissue.count_flipped(&x) + count_self_crossings(&x, tree), 0);
        assert!(shares[far] >= 1.0 && shares.iter().any(|share| *share < 1.0));
    }

    #[test]
    fn a_step_is_held_back_where_the_body_would_cross_itself_in_single_precision() {
        // So far from the origin that coordinates are rounded to 64ths.
        let middle = f64::from(1 << 17);
        let mut ellipsoid = shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3);
        for (number, x) in (0..).zip(&mut ellipsoid.positions) {
            *x += middle + 0.02 * f64::sin(7.0 * f64::from(number)) * DVec3::Z;
        }
        let (scene, mut tissue) = planted(ellipsoid);
        tissue.is_written_single = true;
        let tree = fitted_tree(&scene.bodies()[0]);

        let mut crossed_by_rounding = 0;
        for step in 0..20 {
            let mut d = vec![DVec3::ZERO; tissue.rest.len()];
            for (number, (d, rest)) in (0..).zip(d.iter_mut().zip(&tissue.rest)) {
                let jitter = 0.02 * f64::sin(f64::from(11 * number + step));
                let from_middle = *rest - middle;
                if from_middle.z > 0.0 && from_middle.truncate().length() < 3.0 {
                    *d = DVec3::new(0.4, 0.2, jitter - 3.925);
                }
            }
            let ends = |shares: &[f64]| -> Vec<DVec3> {
                (0..d.len()).map(|v| tissue.rest[v] + shares[v] * d[v]).collect()
            };
            let crossings = |x: &[DVec3]| count_self_crossings(x, tree);

            let mut shares = vec![1.0; d.len()];
            let whole = ends(&shares);
            let crosses_rounded = crossings(&rounded_to_single(&whole)) > 0;
            crossed_by_rounding += u32::from(crossings(&whole) == 0 && crosses_rounded);
            let none = Progress::none();
            tissue.limit_step(tree, &d, &mut shares, none).expect("no interruption");
            assert_eq!(crossings(&rounded_to_single(&ends(&shares))), 0, "step {step}");
        }
        assert!(crossed_by_rounding > 0, "some steps cross by rounding alone");
    }

    #[test]
    fn what_is_far_from_a_face_that_stands_upright_goes_on() {
        let block = shapes::plate(DVec3::new(8.0, 8.0, 3.0), [8, 8]);
        let vertex_at = |at: DVec3| {
            let is_there = |p: &DVec3| p.distance(at) < 1e-9;
            block.positions.iter().position(is_there).expect("a vertex of the grid")
        };
        let [lifted, far] = [(0.0, 0.0, -1.5), (-4.0, -4.0, 1.5)].map(|at| vertex_at(at.into()));
        let mut x = block.positions.clone();
        x[lifted] = DVec3::new(1.0 - 1e-6, 0.5, 0.5);
        let (mut scene, tissue) = planted(block);
        scene.move_body(tissue.id, &x).expect("positions");
        scene.fit_all().expect("a tree");

        let mut d = vec![DVec3::ZERO; x.len()];
        (d[lifted], d[far]) = (0.1 * DVec3::X, 0.1 * DVec3::Z);
        let mut shares = vec![1.0; x.len()];
        let tree = fitted_tree(&scene.bodies()[0]);
        let turning = tissue.limit_step(tree, &d, &mut shares, Progress::none());
        assert_eq!(turning.expect("no interruption").len(), 1);
        assert!(shares[lifted] <= 0.0 && shares[far] >= 1.0, "{} {}", shares[lifted], shares[far]);
    }
}
