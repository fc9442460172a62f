//! Search for the vertices and edges of a surface within the margin of a rigid body.

use glam::DVec3;
use kdop::Workspace;
use proximity::{ParticleNumbers, SurfaceTree};
use surface::{NO_EDGE, Pose, Positions, RigidState, Term, TriangleSurface};

use super::{FieldContact, FieldDetector, FieldFeature};
use crate::{DistanceField, QueryParams, SampleBatch, SegmentMinimum};

/// Contacts of a surface with a rigid body, in memory that is reused.
///
/// ```
/// use distance_field::{DistanceField, FieldContacts, FieldDetector, FieldFeature, FieldParams};
/// use distance_field::glam::{DQuat, DVec3};
/// use proximity::{ParticleNumbers, SurfaceTree};
/// use surface::progress::Progress;
/// use surface::{Pose, RigidState, TriangleSurface};
///
/// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 30.0 * corner);
/// let surface = TriangleSurface::new(4, faces)?;
/// let x = surface.positions(&corners)?;
/// let bone = DistanceField::build(&surface, x, &FieldParams::new(1.0), Progress::none())?;
/// let detector = FieldDetector::new(bone, 0.0)?;
/// let muscle = SurfaceTree::new(surface, corners.to_vec())?;
///
/// // The bone has moved: one corner of the muscle is 3 above its base.
/// let pose = Pose::new(DQuat::IDENTITY, DVec3::new(-5.0, -8.0, -3.0));
/// let state = RigidState::at_rest(pose);
/// let mut contacts = FieldContacts::default();
/// contacts.compute(&detector, &state, &muscle, ParticleNumbers::from(0));
///
/// let deepest = contacts.contacts()[0];
/// assert_eq!(deepest.feature, FieldFeature::Vertex(0));
/// assert!((deepest.contact.gap + 3.0).abs() < 1e-4);
/// assert!((deepest.contact.normal + DVec3::Z).length() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct FieldContacts {
    workspace: Workspace,
    /// Faces near the rigid body; after the search those with a vertex inside it.
    faces: Vec<u32>,
    /// Vertices and edges of the near faces, each once.
    vertices: Distinct,
    edges: Distinct,
    batch: PointBatch,
    /// Value of the field per vertex of the surface, infinite for vertices that are not
    /// near; outside the grid, a value that bounds the edges there as well.
    values: Vec<f64>,
    contacts: Vec<FieldContact>,
}

impl FieldContacts {
    /// Finds the contacts of a surface with the rigid body of a detector.
    ///
    /// These are the vertices within the margin, and the edges that come within the margin
    /// between two ends outside it, each at its deepest point. The field is taken as it is:
    /// outside its grid there is no contact. A rigid body that pokes through a face without
    /// crossing an edge is not detected.
    pub fn compute(
        &mut self,
        detector: &FieldDetector,
        state: &RigidState,
        body: &SurfaceTree,
        particles: ParticleNumbers<'_>,
    ) {
        self.contacts.clear();
        self.faces.clear();
        let Some(bounds) = detector.bounds(&state.pose) else {
            return;
        };

        // Descend the tree where the field may come within the margin.
        let near = |corners| detector.may_contain_contact(&state.pose, corners);
        body.tree().query_where(&bounds, near, &mut self.workspace, |face| self.faces.push(face));
        self.list_features(body.surface());

        // Vertices all at once; edges by two bounds that exclude most of them.
        let search = Search { detector, state, body, particles };
        self.evaluate_vertices(&search);
        self.retain_dipping_edges(&search);

        for &vertex in &self.vertices.list {
            if self.values[vertex as usize] <= detector.margin() {
                self.contacts.extend(search.vertex_contact(vertex));
            }
        }
        for &edge in &self.edges.list {
            self.contacts.extend(search.edge_contact(edge));
        }
        self.contacts.sort_unstable_by_key(|contact| contact.feature);
    }

    /// Returns the contacts: vertices, then edges, both ascending.
    #[must_use]
    pub fn contacts(&self) -> &[FieldContact] {
        &self.contacts
    }

    /// Adds the contact of the deepest vertex of a finer surface, if it is deeper than all
    /// contacts that were found.
    ///
    /// For a surface that represents a finer one: `represented` lists the vertices of the
    /// finer surface that a face stands for. Its positions and particles are given.
    pub fn add_deepest<'a>(
        &mut self,
        detector: &FieldDetector,
        state: &RigidState,
        fine: Positions<'_>,
        particles: ParticleNumbers<'_>,
        represented: impl Fn(u32) -> &'a [u32],
    ) {
        // Only faces with a vertex inside represent vertices that may be deeper.
        let vertices = &mut self.vertices.list;
        vertices.clear();
        for &face in &self.faces {
            vertices.extend(represented(face));
        }
        let points = vertices.iter().map(|&vertex| fine.at(vertex));
        let values = self.batch.evaluate(detector.field(), &state.pose, points);

        // Of equally deep vertices the first.
        let (mut deepest, mut value) = (u32::MAX, f64::INFINITY);
        for (&vertex, &other) in vertices.iter().zip(values) {
            if (other, vertex) < (value, deepest) {
                (deepest, value) = (vertex, other);
            }
        }

        if self.contacts.iter().all(|found| value < found.contact.gap) && value < f64::INFINITY {
            let term = Term { particle: particles.particle(deepest), weight: 1.0 };
            let feature = FieldFeature::Vertex(deepest);
            self.contacts.extend(detector.contact(state, fine.at(deepest), &[term], feature));
        }
    }

    /// Lists the vertices and edges of the near faces.
    fn list_features(&mut self, surface: &TriangleSurface) {
        self.vertices.reset(surface.vertex_count());
        self.edges.reset(surface.edges().len());
        for &face in &self.faces {
            for vertex in surface.faces()[face as usize] {
                self.vertices.add(vertex);
            }
            for edge in surface.face_edges()[face as usize] {
                if edge != NO_EDGE {
                    self.edges.add(edge);
                }
            }
        }
    }

    /// Evaluates the field at the near vertices, and retains the faces with one inside.
    fn evaluate_vertices(&mut self, search: &Search<'_>) {
        let x = search.body.positions();
        let pose = &search.state.pose;
        let points = self.vertices.list.iter().map(|&vertex| x.at(vertex));
        let found = self.batch.evaluate(search.detector.field(), pose, points);

        // Outside the grid, a bound takes the place of the value.
        self.values.clear();
        self.values.resize(x.as_slice().len(), f64::INFINITY);
        for (&vertex, &value) in self.vertices.list.iter().zip(found) {
            let is_outside = value == f64::INFINITY;
            self.values[vertex as usize] =
                if is_outside { search.detector.value_outside(pose, x.at(vertex)) } else { value };
        }

        let (faces, values) = (search.body.surface().faces(), &self.values);
        self.faces.retain(|&face| {
            let [a, b, c] = faces[face as usize].map(|vertex| values[vertex as usize]);
            a < 0.0 || b < 0.0 || c < 0.0
        });
    }

    /// Retains the edges that may come within the margin between ends outside it: by the
    /// values at their ends, then by those at their midpoints.
    fn retain_dipping_edges(&mut self, search: &Search<'_>) {
        let (edges, values) = (&mut self.edges.list, &self.values);
        edges.retain(|&edge| search.may_dip(edge, values));

        // `retain` visits the edges in their order, which is that of the midpoints.
        let midpoints = edges.iter().map(|&edge| search.midpoint(edge));
        let found = self.batch.evaluate(search.detector.field(), &search.state.pose, midpoints);
        let mut found = found.iter();
        edges.retain(|&edge| {
            let midpoint = found.next().copied().unwrap_or(f64::INFINITY);
            search.may_dip_beside_midpoint(edge, values, midpoint)
        });
    }
}

/// Numbers without repetition, in the order of their first mention.
#[derive(Debug, Default)]
struct Distinct {
    list: Vec<u32>,
    is_listed: Vec<bool>,
}

impl Distinct {
    /// Empties the list, for numbers below `count`.
    fn reset(&mut self, count: usize) {
        self.list.clear();
        self.is_listed.clear();
        self.is_listed.resize(count, false);
    }

    /// Adds a number, unless it is listed.
    fn add(&mut self, number: u32) {
        if !std::mem::replace(&mut self.is_listed[number as usize], true) {
            self.list.push(number);
        }
    }
}

/// Points that are evaluated together, in memory that is reused.
#[derive(Debug, Default)]
struct PointBatch {
    points: Vec<DVec3>,
    samples: SampleBatch,
}

impl PointBatch {
    /// Evaluates a field at points of the world; infinite outside its grid.
    fn evaluate(
        &mut self,
        field: &DistanceField,
        pose: &Pose,
        points: impl Iterator<Item = DVec3>,
    ) -> &[f64] {
        self.points.clear();
        self.points.extend(points);
        let params = QueryParams { pose: *pose, ..QueryParams::default() };
        field.query_batch(&self.points, &params, &mut self.samples);
        &self.samples.distance
    }
}

/// Surface near a rigid body.
struct Search<'a> {
    detector: &'a FieldDetector,
    state: &'a RigidState,
    body: &'a SurfaceTree,
    particles: ParticleNumbers<'a>,
}

impl Search<'_> {
    fn vertex_contact(&self, vertex: u32) -> Option<FieldContact> {
        let p = self.body.position(vertex);
        let feature = FieldFeature::Vertex(vertex);
        self.detector.contact(self.state, p, &[self.term(vertex, 1.0)], feature)
    }

    /// Builds the contact of an edge at its deepest point.
    fn edge_contact(&self, edge: u32) -> Option<FieldContact> {
        let segment = self.segment(edge);
        let local = self.to_local(segment);
        let SegmentMinimum { t, .. } =
            self.detector.field().min_along_segment(local, self.detector.margin())?;

        let [from, to] = self.ends(edge);
        let terms = [self.term(from, 1.0 - t), self.term(to, t)];
        let p = segment[0].lerp(segment[1], t);
        self.detector.contact(self.state, p, &terms, FieldFeature::Edge(edge))
    }

    /// Returns true if an edge may come within the margin between two ends outside it.
    fn may_dip(&self, edge: u32, values: &[f64]) -> bool {
        let ends = self.end_values(edge, values);
        if ends[0].min(ends[1]) <= self.detector.margin() {
            return false;
        }

        // The bound over the whole field decides most; that around the edge costs more.
        let bounds = self.detector.field_bounds();
        let [a, b] = self.segment(edge);
        !bounds.clears_length(ends, a.distance(b))
            && !bounds.clears_segment(self.to_local([a, b]), ends)
    }

    /// Returns true if either half of an edge may come within the margin, given the value
    /// at its midpoint.
    fn may_dip_beside_midpoint(&self, edge: u32, values: &[f64], midpoint: f64) -> bool {
        let [from, to] = self.end_values(edge, values);
        let [a, b] = self.to_local(self.segment(edge));
        let bounds = self.detector.field_bounds();
        let middle = a.midpoint(b);
        !(bounds.clears_segment([a, middle], [from, midpoint])
            && bounds.clears_segment([b, middle], [to, midpoint]))
    }

    fn midpoint(&self, edge: u32) -> DVec3 {
        let [a, b] = self.segment(edge);
        a.midpoint(b)
    }

    fn ends(&self, edge: u32) -> [u32; 2] {
        self.body.surface().edges()[edge as usize]
    }

    fn end_values(&self, edge: u32, values: &[f64]) -> [f64; 2] {
        let [from, to] = self.ends(edge);
        [values[from as usize], values[to as usize]]
    }

    /// Returns the ends of an edge in the world.
    fn segment(&self, edge: u32) -> [DVec3; 2] {
        let [from, to] = self.ends(edge);
        [self.body.position(from), self.body.position(to)]
    }

    /// Transforms a segment from the world to the frame of the field.
    fn to_local(&self, [a, b]: [DVec3; 2]) -> [DVec3; 2] {
        let pose = &self.state.pose;
        [pose.inverse_transform_point(a), pose.inverse_transform_point(b)]
    }

    fn term(&self, vertex: u32, weight: f64) -> Term {
        Term { particle: self.particles.particle(vertex), weight }
    }
}
