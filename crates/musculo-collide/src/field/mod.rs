//! A bone by its distance field against the vertices and edges of a body.
//!
//! The body's tree leaves the faces whose bounds meet the box around the bone;
//! their vertices cost one look at the field each. An edge between two vertices
//! outside may still dip into the bone: the lowest point of its span is searched
//! for with the field (`edge`), so that no offset has to be guessed that keeps
//! edges out.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2: rigid
//! bodies as distance maps, contacts as linear combinations of particles. There,
//! vertices alone are tested, kept away by an offset for the sake of edges.

mod edge;
pub(crate) mod volume;

use distance_field::{DistanceField, Interpolation, Pose, Query, Sample, Samples};
use glam::DVec3;
use kdop::{Dop18, Workspace};
use surface::{Anchor, Contact, NO_EDGE, Stencil, Term, TriangleSurface};

use self::volume::Volume;
use crate::pair::Party;
use crate::{BodyId, Scene, SceneError};

/// A bone's distance field, ready to be asked for contacts.
#[derive(Debug)]
pub struct FieldDetector<'a> {
    field: &'a DistanceField,
    reach: f64,
    volume: Volume,
}

/// Where a rigid body is, and how it moves there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidState {
    /// From the frame of its field to the world.
    pub pose: Pose,
    /// Point of the world that `linear` is the velocity of.
    pub about: DVec3,
    /// Velocity, in lengths per time.
    pub linear: DVec3,
    /// Angular velocity, in radians per time.
    pub angular: DVec3,
}

/// A vertex or an edge of the body at the bone.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FieldContact {
    /// The contact, with particles numbered by [`Body::particles`](crate::Body::particles)
    /// and the bone for its anchor. Its gap is the field's value.
    pub contact: Contact,
    /// What touches.
    pub feature: FieldFeature,
    /// Length of the field's gradient: near 1 where the normal can be relied on,
    /// less where several parts of the bone are equally near. Where it is 0, the
    /// normal points away from the middle of the bone's box.
    pub steepness: f64,
}

/// What of the body touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum FieldFeature {
    /// A vertex, by its number in the body.
    Vertex(u32),
    /// The span of an edge, by its number in the body's surface, whose ends are
    /// both out of reach.
    Edge(u32),
}

impl RigidState {
    /// At rest.
    #[must_use]
    pub fn at(pose: Pose) -> Self {
        Self { pose, about: DVec3::ZERO, linear: DVec3::ZERO, angular: DVec3::ZERO }
    }

    /// Velocity of the body's point that is at `p`.
    #[must_use]
    pub fn velocity(&self, p: DVec3) -> DVec3 {
        self.linear + self.angular.cross(p - self.about)
    }

    /// From the body's frame into the world.
    fn to_world(self, p: DVec3) -> DVec3 {
        self.pose.direction_to_world(p - self.pose.into_body(DVec3::ZERO))
    }
}

impl<'a> FieldDetector<'a> {
    /// Looks once at every node, for what bounds the bone and its slopes.
    ///
    /// Values of at most `reach` are contacts: 0 reports what is inside by the
    /// field; the error of the field, of which its report has a measure, reports
    /// also what may be.
    ///
    /// # Errors
    ///
    /// [`SceneError::Reach`] when the reach is negative or not finite.
    pub fn new(field: &'a DistanceField, reach: f64) -> Result<Self, SceneError> {
        if !(reach.is_finite() && reach >= 0.0) {
            return Err(SceneError::Reach { reach });
        }
        Ok(Self { field, reach, volume: Volume::of(field, reach) })
    }

    /// A detector whose field has been looked at before, with the same reach.
    pub(crate) fn with_volume(field: &'a DistanceField, reach: f64, volume: Volume) -> Self {
        Self { field, reach, volume }
    }

    /// The most that an edge's gap may be above the field's lowest value along
    /// it: a thousandth of the spacing.
    #[must_use]
    pub fn edge_tolerance(&self) -> f64 {
        self.field.grid().spacing() / 1000.0
    }

    /// Values of at most this are contacts.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// The most that a ball between others may be above the lowest of them: a
    /// twentieth of the spacing.
    #[must_use]
    pub fn ball_tolerance(&self) -> f64 {
        self.field.grid().spacing() / 20.0
    }

    /// The distance at a point of the world, or a bound below where the field does
    /// not tell it: outside of its grid, or where it is truncated.
    pub(crate) fn tell(&self, state: &RigidState, p: DVec3) -> Result<Sample, f64> {
        let query = Query { interpolation: Interpolation::Smooth, offset: 0.0, pose: state.pose };
        match self.field.ask(p, &query) {
            Some(sample) if sample.distance < self.volume.highest => Ok(sample),
            Some(_) => Err(self.volume.highest),
            // What is within reach is in the box.
            None => {
                let p = state.pose.into_body(p);
                Err(self.reach + p.distance(self.volume.clamp(p)))
            }
        }
    }

    /// The direction of a gradient at a point of the world; where there is none,
    /// that away from the middle of the bone's box.
    pub(crate) fn normal(&self, state: &RigidState, p: DVec3, gradient: DVec3) -> DVec3 {
        let away = || p - state.to_world(self.volume.middle());
        let normal = gradient.try_normalize().or_else(|| away().try_normalize());
        normal.unwrap_or(DVec3::Z)
    }

    /// Bounds in the world of all that may be within reach; none where nothing is.
    pub(crate) fn bounds(&self, state: &RigidState) -> Option<Dop18> {
        let corners = self.volume.corners()?.map(|corner| state.to_world(corner));
        // Turning a point in and back may move it by rounding.
        let rounding = 1e-12 * corners.iter().fold(0.0, |most: f64, p| most.max(p.length()));
        Some(Dop18::from_points(&corners).inflated(rounding))
    }

    /// Whether a value within reach may be in a box of the world, given by its
    /// lowest and highest corner: none is where the value in the middle is too
    /// high for the steepest slope to come down from.
    fn may_reach(&self, state: &RigidState, [lo, hi]: [DVec3; 2]) -> bool {
        let centre = 0.5 * (lo + hi);
        // Rounding may carry a point of the box outside the ball around it.
        let radius = 0.5 * lo.distance(hi) + 1e-12 * centre.length();
        let p = state.pose.into_body(centre);
        let nearest = self.volume.clamp(p);
        if p.distance(nearest) > radius {
            return false;
        }
        let sample = self.field.sample(nearest, Interpolation::Trilinear);
        sample.is_none_or(|found| self.volume.descent(found.distance) <= radius)
    }

    /// A height for a point outside the grid: that of the nearest point of the box,
    /// which is no farther from whatever is in reach. Infinite where that is in reach.
    fn height_outside(&self, state: &RigidState, p: DVec3) -> f64 {
        let nearest = self.volume.clamp(state.pose.into_body(p));
        let sample = self.field.sample(nearest, Interpolation::Trilinear);
        let height = sample.map_or(f64::INFINITY, |sample| sample.distance);
        if height > self.reach { height } else { f64::INFINITY }
    }

    fn contact(
        &self,
        state: &RigidState,
        (p, stencil, feature): (DVec3, Stencil, FieldFeature),
    ) -> Option<FieldContact> {
        let query = Query { interpolation: Interpolation::Smooth, offset: 0.0, pose: state.pose };
        let Sample { distance: gap, gradient } = self.field.ask(p, &query)?;
        let steepness = gradient.length();
        let normal = self.normal(state, p, gradient);
        let point = p - gap * normal;
        let velocity = state.velocity(point);
        let anchor = Some(Anchor { point, velocity, acceleration: DVec3::ZERO });
        let contact = Contact { stencil, anchor, normal, offset: 0.0, gap, time: None };
        Some(FieldContact { contact, feature, steepness })
    }
}

impl Scene {
    /// Contacts of a body with a bone that is known by its field: vertices
    /// within reach, ascending, then edges that come within reach between two
    /// ends that don't, ascending.
    ///
    /// The field is taken as it is: no vertex or edge that it has within reach is
    /// missed, and an edge whose lowest value is above the reach by less than
    /// [`FieldDetector::edge_tolerance`] may be reported. A bone that pokes
    /// through a face without touching its edges is not seen. Outside the
    /// field's grid nothing touches.
    ///
    /// ```
    /// use musculo_collide::distance_field::{BuildOptions, DistanceField, Pose};
    /// use musculo_collide::glam::{DQuat, DVec3};
    /// use musculo_collide::surface::TriangleSurface;
    /// use musculo_collide::{BodyKind, FieldDetector, FieldFeature, RigidState, Scene};
    ///
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 30.0 * corner);
    /// let bone = TriangleSurface::new(4, faces.clone())?;
    /// let field = DistanceField::build(&bone, bone.positions(&corners)?, &BuildOptions::default())?;
    ///
    /// let mut scene = Scene::new();
    /// let muscle = TriangleSurface::new(4, faces)?;
    /// let muscle = scene.add("muscle", BodyKind::Deformable, muscle, corners.to_vec())?;
    ///
    /// // The bone has moved, so that one corner of the muscle is 3 over its base.
    /// let state = RigidState::at(Pose::new(DQuat::IDENTITY, DVec3::new(-5.0, -8.0, -3.0)));
    /// let detector = FieldDetector::new(&field, 0.0)?;
    /// let contacts = scene.field_contacts(muscle, &detector, &state)?;
    /// assert_eq!(contacts[0].feature, FieldFeature::Vertex(0));
    /// assert!((contacts[0].contact.gap + 3.0).abs() < 1e-4);
    /// assert!((contacts[0].contact.normal + DVec3::Z).length() < 1e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] when `body` is of another scene.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    pub fn field_contacts(
        &mut self,
        body: BodyId,
        detector: &FieldDetector<'_>,
        state: &RigidState,
    ) -> Result<Vec<FieldContact>, SceneError> {
        if body.index() >= self.bodies().len() {
            let count = self.bodies().len();
            return Err(SceneError::NoSuchBody { index: body.index(), count });
        }
        self.bound_states()?;
        let mut scratch = FieldScratch::default();
        scratch.look(detector, state, Party::of(self.body(body)));
        Ok(scratch.contacts)
    }
}

/// What of a body is near a bone, in memory that is used again.
#[derive(Debug, Default)]
pub(crate) struct FieldScratch {
    traversal: Workspace,
    faces: Vec<u32>,
    /// Vertices and edges of the faces, each once.
    vertices: Vec<u32>,
    edges: Vec<u32>,
    /// By vertex, and by edge: whether it is in the list.
    listed: [Vec<bool>; 2],
    points: Vec<DVec3>,
    samples: Samples,
    /// By vertex; outside the grid, a height that is as good for the edges there.
    heights: Vec<f64>,
    pub(crate) contacts: Vec<FieldContact>,
}

impl FieldScratch {
    /// Finds the contacts of a body, whose tree is up to date, in place of what
    /// was found before.
    pub(crate) fn look(
        &mut self,
        detector: &FieldDetector<'_>,
        state: &RigidState,
        body: Party<'_>,
    ) {
        self.contacts.clear();
        let Some(bounds) = detector.bounds(state) else {
            return;
        };
        let Self { traversal, faces, .. } = self;
        faces.clear();
        let near = |corners| detector.may_reach(state, corners);
        body.shape.tree().query_where(&bounds, near, traversal, |face| faces.push(face));
        self.list_features(body.shape.surface());
        self.find_heights(detector, state, body.shape.positions());
        let near = Near { detector, state, body };
        self.keep_dipping(&near);
        self.find_contacts(&near);
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
        let query = Query { pose: state.pose, ..Query::default() };
        detector.field.ask_all(points, &query, samples);
        heights.clear();
        heights.resize(x.len(), f64::INFINITY);
        for (&vertex, &height) in vertices.iter().zip(&samples.distance) {
            let is_outside = height == f64::INFINITY;
            let at = x[vertex as usize];
            heights[vertex as usize] =
                if is_outside { detector.height_outside(state, at) } else { height };
        }
    }

    /// Leaves the edges that may come within reach between ends that don't: by
    /// their ends' heights and then, all at once, by those of their middles.
    fn keep_dipping(&mut self, near: &Near<'_>) {
        let Self { edges, points, samples, heights, .. } = self;
        edges.retain(|&edge| near.may_dip(edge, heights));
        points.clear();
        points.extend(edges.iter().map(|&edge| near.middle(edge)));
        let query = Query { pose: near.state.pose, ..Query::default() };
        near.detector.field.ask_all(points, &query, samples);
        let mut middles = samples.distance.iter();
        edges.retain(|&edge| {
            let middle = middles.next().copied().unwrap_or(f64::INFINITY);
            near.may_half_dip(edge, heights, middle)
        });
    }

    fn find_contacts(&mut self, near: &Near<'_>) {
        let Self { vertices, edges, heights, contacts, .. } = self;
        let reach = near.detector.reach;
        let touching = vertices.iter().filter(|&&vertex| heights[vertex as usize] <= reach);
        contacts.extend(touching.filter_map(|&vertex| near.vertex(vertex)));
        contacts.extend(edges.iter().filter_map(|&edge| near.edge(edge)));
        contacts.sort_unstable_by_key(|contact| contact.feature);
    }
}

impl FieldScratch {
    /// Adds the deepest of the vertices that the body looked at stands for, where it
    /// is deeper than what was found: `whole` has them, `tied` names those of a face.
    pub(crate) fn look_closer<'a>(
        &mut self,
        (detector, state): (&FieldDetector<'_>, &RigidState),
        body: Party<'_>,
        whole: Party<'_>,
        tied: impl Fn(u32) -> &'a [u32],
    ) {
        let Self { faces, vertices, points, samples, heights, contacts, .. } = self;
        let is_inside = |face: &u32| {
            let corners = body.shape.surface().faces()[*face as usize];
            corners.iter().any(|&corner| heights[corner as usize] < 0.0)
        };
        vertices.clear();
        vertices.extend(faces.iter().filter(|face| is_inside(face)).flat_map(|&face| tied(face)));
        points.clear();
        points.extend(vertices.iter().map(|&vertex| whole.shape.positions()[vertex as usize]));
        let query = Query { pose: state.pose, ..Query::default() };
        detector.field.ask_all(points, &query, samples);
        let asked = samples.distance.iter().zip(&*vertices);
        let deepest = asked.min_by(|p, q| p.0.total_cmp(q.0).then(p.1.cmp(q.1)));
        let known = contacts.iter().map(|found| found.contact.gap).fold(f64::INFINITY, f64::min);
        if let Some((&height, &vertex)) = deepest
            && height < known
        {
            contacts.extend(Near { detector, state, body: whole }.vertex(vertex));
        }
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
    body: Party<'a>,
}

impl Near<'_> {
    fn vertex(&self, vertex: u32) -> Option<FieldContact> {
        let stencil = Stencil::single(self.term(vertex, 1.0));
        let at = self.body.shape.positions()[vertex as usize];
        self.detector.contact(self.state, (at, stencil, FieldFeature::Vertex(vertex)))
    }

    fn ends(&self, edge: u32) -> [u32; 2] {
        self.body.shape.surface().edges()[edge as usize]
    }

    fn span(&self, edge: u32) -> [DVec3; 2] {
        self.ends(edge).map(|end| self.body.shape.positions()[end as usize])
    }

    fn middle(&self, edge: u32) -> DVec3 {
        let [a, b] = self.span(edge);
        a.midpoint(b)
    }

    /// Whether an edge may come within reach between two ends that don't.
    fn may_dip(&self, edge: u32, heights: &[f64]) -> bool {
        let ends = self.ends(edge).map(|end| heights[end as usize]);
        let FieldDetector { volume, reach, .. } = self.detector;
        ends.iter().all(|height| height > reach) && !volume.stays_out(ends, self.length(edge))
    }

    /// Whether either half of an edge may, given the height of its middle.
    fn may_half_dip(&self, edge: u32, heights: &[f64], middle: f64) -> bool {
        let (volume, half) = (&self.detector.volume, 0.5 * self.length(edge));
        let stays_out = |end| volume.stays_out([heights[end as usize], middle], half);
        !self.ends(edge).into_iter().all(stays_out)
    }

    fn length(&self, edge: u32) -> f64 {
        let [a, b] = self.span(edge);
        a.distance(b)
    }

    /// The lowest point of an edge whose ends are both out of reach.
    fn edge(&self, edge: u32) -> Option<FieldContact> {
        let (ends, x) = (self.ends(edge), self.span(edge));
        let FieldDetector { field, volume, reach } = self.detector;
        let in_field = x.map(|end| self.state.pose.into_body(end));
        let tolerance = self.detector.edge_tolerance();
        let share = edge::lowest(field, volume, in_field, *reach, tolerance)?;
        let stencil = Stencil::new(&[self.term(ends[0], 1.0 - share), self.term(ends[1], share)])?;
        let at = x[0].lerp(x[1], share);
        self.detector.contact(self.state, (at, stencil, FieldFeature::Edge(edge)))
    }

    fn term(&self, vertex: u32, share: f64) -> Term {
        Term { particle: self.body.particle(vertex), weight: -share }
    }
}
