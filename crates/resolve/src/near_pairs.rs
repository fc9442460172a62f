//! Incremental detection: pairs of which neither body moved keep their report. Pairs of two bodies that
//! cannot move, which nothing separates, are left out.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use kdop::Workspace;
use proximity::PairProximity;
use scene::{Body, BodyId, PairId, PairReport, Scene, SceneError, VertexReport};
use surface::progress::Progress;
use surface::{Contact, TriangleSurface, parallel, triangle};

use crate::ResolveError;
use crate::count::as_f64;
use crate::edge_contacts::edge_contacts;
use crate::exempt::Exempt;
use crate::seam_faces::SeamFaces;
use crate::tissue::fitted_tree;

/// Pairs of bodies within the detection margin, of which one can move, in the order of the bodies.
#[derive(Debug)]
pub(crate) struct NearPairs {
    pairs: Vec<NearPair>,
    /// True for bodies that can move.
    can_move: Vec<bool>,
    /// Pairs that are left as they are.
    exempt: Vec<PairId>,
    /// Faces by which nothing leaves a body.
    pub(crate) seam_faces: SeamFaces,
}

/// Pair of bodies within the detection margin.
#[derive(Debug)]
pub(crate) struct NearPair {
    /// The report, without the distance between the surfaces and without patches.
    pub(crate) report: PairReport,
    /// Contacts of crossing faces without a vertex inside.
    pub(crate) edges: Vec<Contact>,
}

impl NearPair {
    /// Detects the contacts of a pair; `None` where nothing is within the margin.
    fn detect(
        scene: &Scene,
        pair: PairId,
        margin: f64,
        seam_faces: &SeamFaces,
        found: &mut PairProximity,
        progress: Progress<'_>,
    ) -> Result<Option<Self>, SceneError> {
        let (a, b) = (scene.body(pair.a), scene.body(pair.b));
        let computed = found.try_compute(fitted_tree(a), fitted_tree(b), margin, progress);
        computed.map_err(|error| SceneError::of_pair(scene.names(pair), error))?;
        if !found.has_contact() {
            return Ok(None);
        }
        let mut report = PairReport::new(pair, found);
        seam_faces.open(scene, &mut report, margin);
        Ok(Some(Self { edges: edge_contacts(scene, &report), report }))
    }

    /// Computes the depth of the overlap, of vertices or of edges.
    pub(crate) fn depth(&self) -> f64 {
        let mut depth = self.report.max_vertex_depth;
        for contact in &self.edges {
            depth = depth.max(-contact.gap);
        }
        depth
    }

    /// Computes the depth of the overlap that a report describes, of vertices or of edges.
    pub(crate) fn depth_of(scene: &Scene, report: &PairReport) -> f64 {
        Self { report: report.clone(), edges: edge_contacts(scene, report) }.depth()
    }

    /// Returns the relative time of work on all that is near.
    pub(crate) fn cost(&self) -> f64 {
        let near = self.report.a_against_b.near.len() + self.report.b_against_a.near.len();
        as_f64(near + self.report.crossing_faces.len())
    }

    /// Counts the faces of both bodies with all corners within a distance of the other one, which lie on its faces:
    /// none where the pair crosses.
    pub(crate) fn count_touching_faces(&self, scene: &Scene, distance: f64) -> usize {
        if self.report.overlaps {
            return 0;
        }
        let (mut count, mut workspace) = (0, Workspace::default());
        let pair = self.report.pair;
        for ((id, report), other) in self.sides().into_iter().zip([pair.b, pair.a]) {
            let (body, other) = (scene.body(id), scene.body(other));
            let near = report.near.iter().filter(|near| near.gap <= distance);
            let normals: BTreeMap<u32, DVec3> =
                near.map(|near| (near.vertex, near.normal)).collect();

            // Each face with its least corner.
            for &vertex in normals.keys() {
                for &face in body.surface().vertex_faces(vertex) {
                    let [a, b, c] = body.surface().faces()[face as usize];
                    let [p, q, r] = [a, b, c].map(|corner| normals.get(&corner).copied());
                    let (Some(p), Some(q), Some(r)) = (p, q, r) else { continue };
                    if vertex == a.min(b).min(c)
                        && (is_against([p, q, r], outer_normal(body, face))
                            || lies_on(body, face, other, distance, &mut workspace))
                    {
                        count += 1;
                    }
                }
            }
        }
        count
    }

    /// Returns each body with the report of its vertices.
    pub(crate) fn sides(&self) -> [(BodyId, &VertexReport); 2] {
        let PairReport { pair, a_against_b, b_against_a, .. } = &self.report;
        [(pair.a, a_against_b), (pair.b, b_against_a)]
    }
}

/// Returns true if a normal is against all others, those of a surface at the corners of its face.
fn is_against(others: [DVec3; 3], normal: DVec3) -> bool {
    others.iter().all(|other| other.dot(normal) < 0.0)
}

/// Returns true if the middle of a face is on a face of another body that faces the other way: at edges, normals at
/// its corners may be of others.
fn lies_on(body: &Body, face: u32, other: &Body, distance: f64, workspace: &mut Workspace) -> bool {
    let (middle, _) = triangle::radius_about_center(body.corners(face));
    let found = fitted_tree(other).closest_point(middle, distance, None, workspace);
    let normal = outer_normal(body, face);
    found.is_some_and(|found| outer_normal(other, found.face).dot(normal) < 0.0)
}

/// Computes the outer normal of a face, twice as long as its area.
fn outer_normal(body: &Body, face: u32) -> DVec3 {
    let normal = triangle::normal(body.corners(face));
    if body.is_inside_out() { -normal } else { normal }
}

impl NearPairs {
    /// Returns no pairs, of bodies of which those that are neither rigid nor `exempt` can move.
    pub(crate) fn new(scene: &Scene, exempt: &Exempt) -> Self {
        let can_move = |id: BodyId| !scene.body(id).is_rigid() && !exempt.bodies.contains(&id);
        let can_move = scene.ids().map(can_move).collect();
        let (exempt, seam_faces) = (exempt.pairs.clone(), SeamFaces::default());
        Self { pairs: Vec::new(), can_move, exempt, seam_faces }
    }

    /// Takes over the reports of all pairs at a margin. Pairs of which they do not tell whether anything
    /// of them is within it, or whether surfaces meet, are detected again.
    pub(crate) fn adopt(
        &mut self,
        scene: &Scene,
        reports: &[PairReport],
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<(), SceneError> {
        let mut known = Vec::new();
        for report in reports {
            if self.is_wanted(report.pair) {
                known.push(report);
            }
        }
        let near = parallel::map_slice_with(&known, PairProximity::default, |found, &report| {
            progress.report(0.0)?;
            let PairReport { a_against_b, b_against_a, crossing_faces, .. } = report;
            let is_near = !(a_against_b.near.is_empty() && b_against_a.near.is_empty());
            if crossing_faces.is_empty() && (report.overlaps || !is_near) {
                let (pair, seam_faces) = (report.pair, &self.seam_faces);
                return NearPair::detect(scene, pair, margin, seam_faces, found, progress);
            }
            let report = PairReport { distance: None, overlap: None, ..report.clone() };
            Ok(Some(NearPair { edges: edge_contacts(scene, &report), report }))
        });
        let near: Result<Vec<_>, SceneError> = near.into_iter().collect();
        self.pairs = near?.into_iter().flatten().collect();
        self.pairs.sort_unstable_by_key(|pair| pair.report.pair);
        Ok(())
    }

    /// Takes the contacts of all pairs off faces at seams, here and wherever pairs are detected from now on.
    pub(crate) fn open_seams(&mut self, scene: &Scene, seam_faces: SeamFaces, margin: f64) {
        self.seam_faces = seam_faces;
        if !self.seam_faces.is_empty() {
            for NearPair { report, edges } in &mut self.pairs {
                self.seam_faces.open(scene, report, margin);
                *edges = edge_contacts(scene, report);
            }
        }
    }

    /// Returns true if a body of a pair can move, and the pair is not exempt.
    fn is_wanted(&self, pair: PairId) -> bool {
        let can_move = pair.bodies().iter().any(|body| self.can_move[body.index()]);
        can_move && !self.exempt.contains(&pair)
    }

    /// Returns the pairs, in the order of the bodies.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &NearPair> {
        self.pairs.iter()
    }

    /// Returns the pairs that overlap.
    pub(crate) fn overlapping(&self) -> impl Iterator<Item = &NearPair> {
        self.iter().filter(|pair| pair.report.overlaps)
    }

    /// Returns the vertices of a body that are inside another, or that faces have which cross it.
    pub(crate) fn crossing_vertices(
        &self,
        body: BodyId,
        other: BodyId,
        surface: &TriangleSurface,
    ) -> BTreeSet<u32> {
        let (mut vertices, id) = (BTreeSet::new(), PairId::new(body, other));
        for pair in self.iter().filter(|pair| pair.report.pair == id) {
            let side = usize::from(id.b == body);
            for near in &pair.sides()[side].1.near {
                if near.gap < 0.0 {
                    vertices.insert(near.vertex);
                }
            }
            for faces in &pair.report.crossing_faces {
                vertices.extend(surface.faces()[faces[side] as usize]);
            }
        }
        vertices
    }

    /// Detects the pairs of moved bodies again, and fits the trees of all bodies. On an error,
    /// only pairs of unmoved bodies remain.
    pub(crate) fn update(
        &mut self,
        scene: &mut Scene,
        margin: f64,
        moved: &[bool],
        progress: Progress<'_>,
    ) -> Result<(), ResolveError> {
        let has_moved = |pair: PairId| moved[pair.a.index()] || moved[pair.b.index()];
        self.pairs.retain(|pair| !has_moved(pair.report.pair));

        // Pairs within the margin of which a body has moved.
        scene.fit_all()?;
        let mut stale = scene.close_pairs(margin)?;
        stale.retain(|&pair| has_moved(pair) && self.is_wanted(pair));

        // In the order of the bodies, whatever thread was first.
        let (scene, seam_faces) = (&*scene, &self.seam_faces);
        let detect = |found: &mut PairProximity, pair: &PairId| {
            progress.report(0.0)?;
            NearPair::detect(scene, *pair, margin, seam_faces, found, progress)
        };
        let cost = |pair: &PairId| detection_cost(scene, *pair);
        let detected = parallel::map_costly_first(&stale, cost, PairProximity::default, detect);
        let detected: Result<Vec<_>, SceneError> = detected.into_iter().collect();
        self.pairs.extend(detected?.into_iter().flatten());
        self.pairs.sort_unstable_by_key(|pair| pair.report.pair);
        Ok(())
    }
}

/// Returns the relative time of detection between two bodies.
pub(crate) fn detection_cost(scene: &Scene, pair: PairId) -> f64 {
    let [a, b] = pair.bodies().map(|id| scene.body(id).positions().len());
    as_f64(a + b)
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::DVec3;
    use scene::BodyKind;

    use super::*;
    use crate::detection::check;

    #[test]
    fn pairs_of_known_overlaps_are_those_that_are_detected() {
        // A cube in which one is deep, which one equals, which one touches, encloses and is near to, and one
        // far away.
        let mut scene = Scene::new();
        let places =
            [(2.0, 0.0), (2.0, 0.7), (2.0, 0.0), (2.0, 2.0), (0.5, 0.6), (2.0, 2.8), (2.0, 9.0)];
        for (number, (size, shift)) in places.into_iter().enumerate() {
            let cube = shapes::cube(size).translated(DVec3::X * shift);
            scene
                .add(number.to_string(), BodyKind::Deformable, cube.surface(), cube.positions)
                .expect("a cube");
        }
        let (margin, none) = (1.0, Progress::none());
        let reports = check(&mut scene, margin, 0.1, none).expect("reports");
        let [mut known, mut detected] = [(), ()].map(|()| NearPairs::new(&scene, &Exempt::NONE));
        known.adopt(&scene, &reports, margin, none).expect("pairs");
        detected.update(&mut scene, margin, &[true; 7], none).expect("pairs");
        assert!(known.pairs.len() > 9 && known.overlapping().count() > 2, "{}", known.pairs.len());
        assert_eq!(known.pairs.len(), detected.pairs.len());
        for (known, detected) in known.iter().zip(detected.iter()) {
            assert_eq!(known.report, detected.report);
            assert_eq!(known.edges, detected.edges);
        }
    }
}
