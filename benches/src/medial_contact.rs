//! Contact of two bodies by medial surfaces, beside the projection of vertices on faces.

use kdop::{Leaves, Tree, Workspace};
use medial::{
    FootRule, MedialBounds, MedialContactParams, MedialSurface, ParticleOffsets, PrimitiveTree,
    QueryPoints, TestCounts, point_contacts, primitive_contacts,
};
use proximity::SurfaceTree;
use surface::Contact;

use crate::measure::Report;

/// Maximum distance of a vertex from the face that it is projected on \[mm\].
///
/// Deeper vertices need more, and whether they are inside is not part of the work.
const MARGIN: f64 = 1.0;

/// Two bodies in contact: vertices of one against faces or balls of the other.
#[derive(Debug)]
pub struct ContactScene<'a> {
    points: &'a SurfaceTree,
    other: &'a SurfaceTree,
    point_tree: Tree,
}

/// Medial surface with its tree.
#[derive(Debug)]
pub struct Balls {
    medial: MedialSurface,
    tree: PrimitiveTree,
}

impl Balls {
    /// Builds the tree of a medial surface.
    ///
    /// # Panics
    ///
    /// When its balls are not finite.
    #[must_use]
    pub fn new(medial: MedialSurface) -> Self {
        let tree = PrimitiveTree::new(&medial).expect("finite balls");
        Self { medial, tree }
    }

    /// Returns the balls moved by a vector.
    ///
    /// # Panics
    ///
    /// When the vector is not finite.
    #[must_use]
    pub fn moved(&self, by: glam::DVec3) -> Self {
        let mut medial = self.medial.clone();
        let mut centers = Vec::new();
        for ball in medial.balls() {
            centers.push(ball.center + by);
        }
        medial.set_centers(&centers).expect("as many balls");
        Self::new(medial)
    }

    fn bounds(&self) -> MedialBounds<'_> {
        MedialBounds { medial: &self.medial, tree: &self.tree }
    }
}

/// Contacts that a method found, with its work.
#[derive(Clone, Debug)]
pub struct MethodWork {
    /// Contacts of vertices; empty for a method that reports none.
    pub contacts: Vec<Contact>,
    /// Elementary tests.
    pub counts: TestCounts,
    /// Minimum time \[ns\], and that of the projection on faces in the same turns.
    pub times: [f64; 2],
}

impl<'a> ContactScene<'a> {
    /// Sets up the vertices of the first body against the second.
    ///
    /// # Panics
    ///
    /// Never: the positions are finite.
    #[must_use]
    pub fn new(points: &'a SurfaceTree, other: &'a SurfaceTree) -> Self {
        let x = points.positions().as_slice();
        let point_tree = Tree::build(Leaves::Points, x).expect("finite positions");
        Self { points, other, point_tree }
    }

    /// Projects vertices on faces: tests of bounds, of vertices against faces, and time.
    #[must_use]
    pub fn projection(&self, budget: u64, report: &mut Report) -> MethodWork {
        let mut workspace = Workspace::default();
        let leaf_tests = self.candidates(&mut workspace).len() as u64;
        let bound_tests = workspace.counters().bound_tests;
        let counts = TestCounts { bound_tests, direction_tests: 0, leaf_tests };

        let mut project = || self.project(&mut workspace);
        let [time] = report.interleave("projection", budget, [("on faces", &mut project)]);
        MethodWork { contacts: Vec::new(), counts, times: [time, time] }
    }

    /// Returns vertices of one body's faces with faces of the other whose bounds are within
    /// [`MARGIN`], each pair once.
    fn candidates(&self, workspace: &mut Workspace) -> Vec<(u32, u32)> {
        let faces = self.points.surface().faces();
        let mut pairs = Vec::new();
        self.points.tree().pairs(self.other.tree(), MARGIN, workspace, |a, b| {
            for vertex in faces[a as usize] {
                pairs.push((vertex, b));
            }
        });

        // Faces share vertices.
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Returns the number of projections on faces within [`MARGIN`].
    fn project(&self, workspace: &mut Workspace) -> usize {
        let mut near = 0;
        for (vertex, face) in self.candidates(workspace) {
            let closest = self.other.closest_on_face(self.points.position(vertex), face);
            near += usize::from(closest.distance < MARGIN);
        }
        near
    }

    /// Detects the vertices in the balls of the other body.
    #[must_use]
    pub fn vertices_in_balls(
        &self,
        balls: &Balls,
        rule: FootRule,
        budget: u64,
        report: &mut Report,
    ) -> MethodWork {
        let points = self.points.positions().as_slice();
        let query = QueryPoints { tree: &self.point_tree, points, radii: None };
        let params = MedialContactParams { rule, max_contacts: 1, ..MedialContactParams::new(0.0) };
        let offsets = ParticleOffsets::default();
        let mut workspace = Workspace::default();
        let mut detect =
            || point_contacts(&query, balls.bounds(), &params, offsets, &mut workspace);

        // One detection gives contacts and counts; those after it are timed.
        let (contacts, counts) = detect();
        let times = self.beside_projection("vertices × balls", || detect().0.len(), budget, report);
        MethodWork { contacts, counts, times }
    }

    /// Detects pairs of overlapping balls, cones and slabs.
    #[must_use]
    pub fn balls_in_balls(
        &self,
        [a, b]: [&Balls; 2],
        budget: u64,
        report: &mut Report,
    ) -> MethodWork {
        let mut workspace = Workspace::default();
        let mut detect = || primitive_contacts(a.bounds(), b.bounds(), 0.0, &mut workspace);
        let (_, counts) = detect();
        let times = self.beside_projection("balls × balls", || detect().0.len(), budget, report);
        MethodWork { contacts: Vec::new(), counts, times }
    }

    /// Times a detection in turns with the projection on faces.
    fn beside_projection(
        &self,
        name: &str,
        mut detect: impl FnMut() -> usize,
        budget: u64,
        report: &mut Report,
    ) -> [f64; 2] {
        let mut workspace = Workspace::default();
        let mut project = || self.project(&mut workspace);
        report.interleave(name, budget, [(name, &mut detect), ("projection", &mut project)])
    }
}

/// Bounds on a method's work over that of the projection on faces.
#[derive(Clone, Copy, Debug)]
pub struct WorkLimits {
    /// Tests of bounds.
    pub bounds: f64,
    /// Tests of leaves.
    pub leaves: f64,
    /// Time.
    pub time: f64,
}

impl MethodWork {
    /// Reports the work over that of the projection on faces.
    pub fn report(
        &self,
        name: &str,
        projection: &TestCounts,
        limits: WorkLimits,
        report: &mut Report,
    ) {
        let (ours, other) = (&self.counts, projection);
        let bounds = [ours.bound_tests, other.bound_tests].map(to_f64);
        report.ratio(format!("{name}, tests of bounds"), bounds, "", limits.bounds);
        let leaves = [ours.leaf_tests, other.leaf_tests].map(to_f64);
        report.ratio(format!("{name}, tests of leaves"), leaves, "", limits.leaves);
        report.times(format!("{name}, time"), self.times, limits.time);
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts stay far below 2^53")]
fn to_f64(count: u64) -> f64 {
    count as f64
}
