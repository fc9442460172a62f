//! One look at a body near a bone.
//!
//! The body's tree is descended where the field's value in the middle of a box may
//! sink to the margin within it. Vertices are asked all at once; edges that may come
//! lower than their ends, judged by these and by their middles, are searched.

use distance_field::{QueryParams, SampleBatch, SegmentMinimum};
use glam::DVec3;
use kdop::Workspace;
use proximity::{ContactSurface, SurfaceTree};
use surface::{NO_EDGE, RigidState, Stencil, Term, TriangleSurface};

use super::{FieldContact, FieldDetector, FieldFeature};

/// What of a body is near a bone, in memory that is used again.
#[derive(Debug, Default)]
pub struct FieldScratch {
    traversal: Workspace,
    faces: Vec<u32>,
    /// Vertices and edges of the faces, each once.
    vertices: Vec<u32>,
    edges: Vec<u32>,
    /// By vertex, and by edge: whether it is in the list.
    listed: [Vec<bool>; 2],
    points: Vec<DVec3>,
    samples: SampleBatch,
    /// By vertex; outside the grid, a height that is as good for the edges there.
    heights: Vec<f64>,
    /// What was found.
    pub contacts: Vec<FieldContact>,
}

impl FieldScratch {
    /// Finds the contacts of a body, whose tree is up to date, in place of what
    /// was found before.
    pub fn look(
        &mut self,
        detector: &FieldDetector<'_>,
        state: &RigidState,
        tree: &SurfaceTree,
        body: ContactSurface<'_>,
    ) {
        self.contacts.clear();
        let Some(bounds) = detector.bounds(state) else {
            return;
        };
        let Self { traversal, faces, .. } = self;
        faces.clear();
        let near = |corners| detector.may_reach(state, corners);
        tree.tree().query_where(&bounds, near, traversal, |face| faces.push(face));
        self.list_features(body.surface);
        self.find_heights(detector, state, body.positions.as_slice());
        let near = Near { detector, state, body };
        self.keep_dipping(&near);
        self.find_contacts(&near);
    }

    /// Adds the deepest of the vertices that the body looked at stands for, where it
    /// is deeper than what was found: `whole` has them, `tied` names those of a face.
    pub fn look_closer<'a>(
        &mut self,
        (detector, state): (&FieldDetector<'_>, &RigidState),
        body: &SurfaceTree,
        whole: ContactSurface<'_>,
        tied: impl Fn(u32) -> &'a [u32],
    ) {
        let Self { faces, vertices, points, samples, heights, contacts, .. } = self;
        let is_inside = |face: &u32| {
            let corners = body.surface().faces()[*face as usize];
            corners.iter().any(|&corner| heights[corner as usize] < 0.0)
        };
        vertices.clear();
        vertices.extend(faces.iter().filter(|face| is_inside(face)).flat_map(|&face| tied(face)));
        points.clear();
        points.extend(vertices.iter().map(|&vertex| whole.positions.at(vertex)));
        let query = QueryParams { pose: state.pose, ..QueryParams::default() };
        detector.field.query_batch(points, &query, samples);
        let asked = samples.distance.iter().zip(&*vertices);
        let deepest = asked.min_by(|p, q| p.0.total_cmp(q.0).then(p.1.cmp(q.1)));
        let known = contacts.iter().map(|found| found.contact.gap).fold(f64::INFINITY, f64::min);
        if let Some((&height, &vertex)) = deepest
            && height < known
        {
            contacts.extend(Near { detector, state, body: whole }.vertex(vertex));
        }
    }

    fn list_features(&mut self, surface: &TriangleSurface) {
        let Self { faces, vertices, edges, listed: [is_vertex, is_edge], .. } = self;
        let of_face = |face: &u32| *face as usize;
        let corners = faces.iter().flat_map(|face| surface.faces()[of_face(face)]);
        list_once(corners, surface.vertex_count(), is_vertex, vertices);
        let sides = faces.iter().flat_map(|face| surface.face_edges()[of_face(face)]);
        let sides = sides.filter(|&edge| edge != NO_EDGE);
        list_once(sides, surface.edges().len(), is_edge, edges);
    }

    fn find_heights(&mut self, detector: &FieldDetector<'_>, state: &RigidState, x: &[DVec3]) {
        let Self { vertices, points, samples, heights, .. } = self;
        points.clear();
        points.extend(vertices.iter().map(|&vertex| x[vertex as usize]));
        let query = QueryParams { pose: state.pose, ..QueryParams::default() };
        detector.field.query_batch(points, &query, samples);
        heights.clear();
        heights.resize(x.len(), f64::INFINITY);
        for (&vertex, &height) in vertices.iter().zip(&samples.distance) {
            let is_outside = height == f64::INFINITY;
            let at = x[vertex as usize];
            heights[vertex as usize] =
                if is_outside { detector.height_outside(state, at) } else { height };
        }
    }

    /// Leaves the edges that may come within the margin between ends that don't: by
    /// their ends' heights and then, all at once, by those of their middles.
    fn keep_dipping(&mut self, near: &Near<'_>) {
        let Self { edges, points, samples, heights, .. } = self;
        edges.retain(|&edge| near.may_dip(edge, heights));
        points.clear();
        points.extend(edges.iter().map(|&edge| near.middle(edge)));
        let query = QueryParams { pose: near.state.pose, ..QueryParams::default() };
        near.detector.field.query_batch(points, &query, samples);
        let mut middles = samples.distance.iter();
        edges.retain(|&edge| {
            let middle = middles.next().copied().unwrap_or(f64::INFINITY);
            near.may_half_dip(edge, heights, middle)
        });
    }

    fn find_contacts(&mut self, near: &Near<'_>) {
        let Self { vertices, edges, heights, contacts, .. } = self;
        let margin = near.detector.margin;
        let touching = vertices.iter().filter(|&&vertex| heights[vertex as usize] <= margin);
        contacts.extend(touching.filter_map(|&vertex| near.vertex(vertex)));
        contacts.extend(edges.iter().filter_map(|&edge| near.edge(edge)));
        contacts.sort_unstable_by_key(|contact| contact.feature);
    }
}

/// Lists numbers below `count`, each once, in the order of their first mention.
fn list_once(
    numbers: impl Iterator<Item = u32>,
    count: usize,
    listed: &mut Vec<bool>,
    out: &mut Vec<u32>,
) {
    listed.clear();
    listed.resize(count, false);
    out.clear();
    out.extend(numbers.filter(|&n| !std::mem::replace(&mut listed[n as usize], true)));
}

/// A body near a bone.
struct Near<'a> {
    detector: &'a FieldDetector<'a>,
    state: &'a RigidState,
    body: ContactSurface<'a>,
}

impl Near<'_> {
    fn vertex(&self, vertex: u32) -> Option<FieldContact> {
        let stencil = Stencil::single(self.term(vertex, 1.0));
        let at = self.body.positions.at(vertex);
        self.detector.contact(self.state, (at, stencil, FieldFeature::Vertex(vertex)))
    }

    fn ends(&self, edge: u32) -> [u32; 2] {
        self.body.surface.edges()[edge as usize]
    }

    fn span(&self, edge: u32) -> [DVec3; 2] {
        self.ends(edge).map(|end| self.body.positions.at(end))
    }

    fn span_in_field(&self, edge: u32) -> [DVec3; 2] {
        self.span(edge).map(|end| self.state.pose.inverse_transform_point(end))
    }

    fn middle(&self, edge: u32) -> DVec3 {
        let [a, b] = self.span(edge);
        a.midpoint(b)
    }

    /// Whether an edge may come within the margin between two ends that don't.
    fn may_dip(&self, edge: u32, heights: &[f64]) -> bool {
        let ends = self.ends(edge).map(|end| heights[end as usize]);
        let FieldDetector { volume, margin, .. } = self.detector;
        ends.iter().all(|height| height > margin)
            && !volume.stays_out(ends, self.length(edge))
            && !volume.stays_out_between(self.span_in_field(edge), ends)
    }

    /// Whether either half of an edge may, given the height of its middle.
    fn may_half_dip(&self, edge: u32, heights: &[f64], middle: f64) -> bool {
        let [a, b] = self.span_in_field(edge);
        let stays_out = |end: DVec3, vertex: u32| {
            let heights = [heights[vertex as usize], middle];
            self.detector.volume.stays_out_between([end, a.midpoint(b)], heights)
        };
        let [from, to] = self.ends(edge);
        !(stays_out(a, from) && stays_out(b, to))
    }

    fn length(&self, edge: u32) -> f64 {
        let [a, b] = self.span(edge);
        a.distance(b)
    }

    /// The lowest point of an edge whose ends are both outside the margin.
    fn edge(&self, edge: u32) -> Option<FieldContact> {
        let (ends, x) = (self.ends(edge), self.span(edge));
        let FieldDetector { field, margin, .. } = self.detector;
        let SegmentMinimum { t: share, .. } =
            field.min_along_segment(self.span_in_field(edge), *margin)?;
        let stencil = Stencil::new(&[self.term(ends[0], 1.0 - share), self.term(ends[1], share)])?;
        let at = x[0].lerp(x[1], share);
        self.detector.contact(self.state, (at, stencil, FieldFeature::Edge(edge)))
    }

    fn term(&self, vertex: u32, share: f64) -> Term {
        Term { particle: self.body.particles.particle(vertex), weight: -share }
    }
}
