//! Swept proximity of two surfaces: first contacts during a step.
//!
//! Trees at both states give pairs of faces whose paths come near. Each vertex and each edge is
//! represented by one of its faces, so that a pair of faces stands for its own vertices and edges
//! only and no query is made twice. Queries go to [`ccd`] in batches.
//!
//! Source: S. Curtis, R. Tamstorf and D. Manocha, "Fast Collision Detection for Deformable Models
//! using Representative-Triangles", I3D 2008, section 4, for the assignment of features to faces.

use ccd::MovingPoints;
use glam::DVec3;
use kdop::{MovingPairs, StepTree, Workspace};
use surface::progress::Progress;
use surface::{Contact, NO_EDGE, Stencil, Term, TriangleSurface, parallel};

use crate::SweptError;

/// Surface as one side of a swept query.
#[derive(Clone, Copy, Debug)]
pub struct SweptSide<'a> {
    /// The surface.
    pub surface: &'a TriangleSurface,
    /// Bounds of its faces at both ends of the step.
    pub tree: StepTree<'a>,
    /// Number of its first vertex among the particles of the motion.
    pub first_particle: u32,
}

/// Two primitives that met during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SweptContact {
    /// The contact at its earliest time; particles of a rigid body are among its stencil. Its
    /// identity holds for the particles' positions at that time, with the minimum separation for
    /// an offset.
    pub contact: Contact,
    /// Kind of the two primitives.
    pub kind: ContactKind,
    /// End of the interval in which the contact begins.
    pub latest: f64,
    /// True if it is proven, rather than only not excluded by rounding.
    pub certain: bool,
    /// True if it may have been there at the start of the step.
    pub at_start: bool,
}

/// First contacts of two surfaces during a step.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SweptContacts {
    /// First contacts of vertices, edges and faces, by time.
    pub contacts: Vec<SweptContact>,
    /// Pairs of primitives that were queried.
    pub candidates: usize,
}

/// Kind of two primitives that meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ContactKind {
    /// A vertex and a face.
    VertexFace,
    /// Two edges.
    EdgeEdge,
}

impl SweptContact {
    /// Returns the contact of the particles of a query, which are at `points` at its earliest time.
    #[must_use]
    pub fn new(
        kind: ContactKind,
        particles: [u32; 4],
        points: [DVec3; 4],
        min_separation: f64,
        found: &ccd::CcdContact,
    ) -> Self {
        // The gap at the first time, by the contact's identity.
        let (mut terms, mut separation) = ([Term { particle: 0, weight: 0.0 }; 4], DVec3::ZERO);
        for k in 0..4 {
            terms[k] = Term { particle: particles[k], weight: found.weights[k] };
            separation += found.weights[k] * points[k];
        }
        let contact = Contact {
            stencil: Stencil::from_terms(terms),
            anchor: None,
            normal: found.normal,
            offset: min_separation,
            gap: -separation.dot(found.normal) - min_separation,
            time: Some(found.lo),
        };
        let (certain, at_start) = (found.is_certain(), found.at_start);
        Self { contact, kind, latest: found.hi, certain, at_start }
    }

    fn time(&self) -> f64 {
        self.contact.time.unwrap_or(1.0)
    }
}

impl SweptSide<'_> {
    fn particles(&self, face: u32) -> [u32; 3] {
        self.surface.faces()[face as usize].map(|vertex| self.first_particle + vertex)
    }

    /// Returns the `k`th corner of a face, if the face represents it: if it is its first face.
    fn own_vertex(&self, face: u32, k: usize) -> Option<u32> {
        let vertex = self.surface.faces()[face as usize][k];
        let is_own = self.surface.vertex_faces(vertex)[0] == face;
        is_own.then_some(self.first_particle + vertex)
    }

    /// Returns the ends of the `k`th edge of a face, if the face represents it.
    fn own_edge(&self, face: u32, k: usize) -> Option<[u32; 2]> {
        let edge = self.surface.face_edges()[face as usize][k];
        if edge == NO_EDGE || self.surface.edge_faces(edge)[0] != face {
            return None;
        }
        let [from, to] = self.surface.edges()[edge as usize];
        Some([self.first_particle + from, self.first_particle + to])
    }
}

/// First contacts of two surfaces during a step, with queries gathered into batches.
#[derive(Debug)]
pub struct SweptQuery<'a> {
    motion: &'a MovingPoints<'a>,
    params: &'a ccd::CcdParams,
    /// Distance within which faces may meet.
    margin: f64,
    vertex_faces: Vec<[u32; 4]>,
    edge_edges: Vec<[u32; 4]>,
    candidates: usize,
    contacts: Vec<SweptContact>,
}

impl<'a> SweptQuery<'a> {
    /// Candidates held before they are queried: half a megabyte, so that they stay in the cache
    /// and no number of candidates exhausts the memory.
    const BATCH: usize = 1 << 15;

    /// Prepares queries about particles on their way.
    #[must_use]
    pub fn new(motion: &'a MovingPoints<'a>, params: &'a ccd::CcdParams) -> Self {
        Self {
            motion,
            params,
            margin: params.min_separation,
            vertex_faces: Vec::new(),
            edge_edges: Vec::new(),
            candidates: 0,
            contacts: Vec::new(),
        }
    }

    /// Sets the distance within which faces may meet, where points deviate from straight lines: the
    /// minimum separation and the largest deviations of both surfaces.
    #[must_use]
    pub fn with_margin(self, margin: f64) -> Self {
        Self { margin, ..self }
    }

    /// Finds the first contacts of all vertices, edges and faces of two surfaces.
    ///
    /// No contact is missed, and no time is after the true one.
    ///
    /// # Errors
    ///
    /// [`SweptError::Ccd`] for parameters out of range, and
    /// [`SweptError::Interrupted`] when `progress` ends the call.
    pub fn run(
        mut self,
        a: &SweptSide<'_>,
        b: &SweptSide<'_>,
        workspace: &mut Workspace,
        progress: Progress<'_>,
    ) -> Result<SweptContacts, SweptError> {
        // Batches run as they fill; after an error, the traversal only ends.
        self.params.validate()?;
        let mut state = Ok(());
        a.tree.pairs(&b.tree, self.margin, workspace, |face_a, face_b| {
            if state.is_ok() {
                state = self.add_faces(a, face_a, b, face_b, progress);
            }
        });
        state?;
        self.finish(progress)
    }

    /// Finds the first contacts of a surface `a` that moves rigidly with one at rest, as
    /// [`run`](Self::run) does, by the pairs of faces that may come close. The particles move on the
    /// chords of the motion.
    ///
    /// # Errors
    ///
    /// As [`run`](Self::run).
    pub fn run_rigid(
        mut self,
        a: &SweptSide<'_>,
        b: &SweptSide<'_>,
        near: MovingPairs<'_, 9>,
        progress: Progress<'_>,
    ) -> Result<SweptContacts, SweptError> {
        self.params.validate()?;
        let mut state = Ok(());
        near.visit(|face_a, face_b| {
            if state.is_ok() {
                state = self.add_faces(a, face_a, b, face_b, progress);
            }
        });
        state?;
        self.finish(progress)
    }

    fn finish(mut self, progress: Progress<'_>) -> Result<SweptContacts, SweptError> {
        self.flush(progress)?;

        // Stable: contacts at one time stay in the order of the traversal.
        self.contacts.sort_by(|p, q| p.time().total_cmp(&q.time()));
        Ok(SweptContacts { contacts: self.contacts, candidates: self.candidates })
    }

    /// Adds the queries that a pair of faces represents, and runs those that fill a batch.
    fn add_faces(
        &mut self,
        a: &SweptSide<'_>,
        face_a: u32,
        b: &SweptSide<'_>,
        face_b: u32,
        progress: Progress<'_>,
    ) -> Result<(), SweptError> {
        // Vertices of each against the face of the other, and edges against edges.
        let ([a0, a1, a2], [b0, b1, b2]) = (a.particles(face_a), b.particles(face_b));
        for k in 0..3 {
            if let Some(vertex) = a.own_vertex(face_a, k) {
                self.vertex_faces.push([vertex, b0, b1, b2]);
            }
        }
        for k in 0..3 {
            if let Some(vertex) = b.own_vertex(face_b, k) {
                self.vertex_faces.push([vertex, a0, a1, a2]);
            }
        }
        for i in 0..3 {
            let Some([p, q]) = a.own_edge(face_a, i) else {
                continue;
            };
            for j in 0..3 {
                if let Some([r, s]) = b.own_edge(face_b, j) {
                    self.edge_edges.push([p, q, r, s]);
                }
            }
        }

        if self.vertex_faces.len() + self.edge_edges.len() < Self::BATCH {
            return Ok(());
        }
        self.flush(progress)
    }

    /// Runs the queries gathered so far.
    fn flush(&mut self, progress: Progress<'_>) -> Result<(), SweptError> {
        self.candidates += self.vertex_faces.len() + self.edge_edges.len();

        let vertex_faces = std::mem::take(&mut self.vertex_faces);
        for piece in vertex_faces.chunks(piece_length()) {
            progress.report(0.0)?;
            for found in self.motion.vertex_face_contacts(piece, self.params)? {
                self.add_contact(ContactKind::VertexFace, piece[found.candidate], &found.contact);
            }
        }
        let edge_edges = std::mem::take(&mut self.edge_edges);
        for piece in edge_edges.chunks(piece_length()) {
            progress.report(0.0)?;
            for found in self.motion.edge_edge_contacts(piece, self.params)? {
                self.add_contact(ContactKind::EdgeEdge, piece[found.candidate], &found.contact);
            }
        }

        // The lists keep their memory.
        (self.vertex_faces, self.edge_edges) = (vertex_faces, edge_edges);
        self.vertex_faces.clear();
        self.edge_edges.clear();
        Ok(())
    }

    fn add_contact(&mut self, kind: ContactKind, particles: [u32; 4], found: &ccd::CcdContact) {
        let points = particles.map(|particle| self.motion.at(particle, found.lo));
        let separation = self.params.min_separation;
        self.contacts.push(SweptContact::new(kind, particles, points, separation, found));
    }
}

/// Returns the largest number of queries that are handed over together: pieces of a batch stay on
/// the calling thread where other loops do.
fn piece_length() -> usize {
    if parallel::is_alone() { MovingPoints::CHUNK } else { usize::MAX }
}
