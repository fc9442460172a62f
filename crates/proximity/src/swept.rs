//! Swept proximity of two surfaces: first contacts during a step.
//!
//! Trees over both states give pairs of faces whose paths come near. Each vertex and each edge is
//! represented by one of its faces, so that a pair of faces stands for its own vertices and edges
//! only and no query is made twice. Queries go to [`ccd`] in batches.
//!
//! Source: S. Curtis, R. Tamstorf and D. Manocha, "Fast Collision Detection for Deformable Models
//! using Representative-Triangles", I3D 2008, section 4, for the assignment of features to faces.

use ccd::MovingPoints;
use kdop::{Tree, Workspace};
use surface::progress::Progress;
use surface::{Contact, Stencil, Term, TriangleSurface};

use crate::SweptError;

/// Surface as one side of a swept query.
#[derive(Clone, Copy, Debug)]
pub struct SweptSide<'a> {
    /// The surface.
    pub surface: &'a TriangleSurface,
    /// Bounds of its faces during the step: of a surface at rest, those of its state.
    pub tree: &'a Tree,
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
#[derive(Clone, Debug, PartialEq)]
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

impl SweptSide<'_> {
    fn particles(&self, face: u32) -> [u32; 3] {
        self.surface.faces()[face as usize].map(|vertex| self.first_particle + vertex)
    }

    /// Returns the corners that a face represents: those of which it is the first face.
    fn own_vertices(&self, face: u32) -> impl Iterator<Item = u32> {
        let corners = self.surface.faces()[face as usize];
        let is_own = move |&vertex: &u32| self.surface.vertex_faces(vertex)[0] == face;
        corners.into_iter().filter(is_own).map(|vertex| self.first_particle + vertex)
    }

    /// Returns the ends of the edges that a face represents.
    fn own_edges(&self, face: u32) -> impl Iterator<Item = [u32; 2]> {
        let edges = self.surface.face_edges()[face as usize];
        let is_own =
            move |&edge: &u32| edge != surface::NO_EDGE && self.surface.edge_faces(edge)[0] == face;
        let ends = |edge: u32| self.surface.edges()[edge as usize].map(|v| self.first_particle + v);
        edges.into_iter().filter(is_own).map(ends)
    }
}

/// First contacts of two surfaces during a step, with queries gathered into batches.
#[derive(Debug)]
pub struct SweptQuery<'a> {
    motion: &'a MovingPoints<'a>,
    params: &'a ccd::CcdParams,
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
            vertex_faces: Vec::new(),
            edge_edges: Vec::new(),
            candidates: 0,
            contacts: Vec::new(),
        }
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
        let margin = self.params.min_separation;
        let mut state = Ok(());
        a.tree.pairs(b.tree, margin, workspace, |face_a, face_b| {
            if state.is_ok() {
                state = self.add_faces(a, face_a, b, face_b, progress);
            }
        });
        state?;
        self.flush()?;

        let time = |found: &SweptContact| found.contact.time.unwrap_or(1.0);
        // Stable: contacts at one time stay in the order of the traversal.
        self.contacts.sort_by(|p, q| time(p).total_cmp(&time(q)));
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
        let ([a0, a1, a2], [b0, b1, b2]) = (a.particles(face_a), b.particles(face_b));
        self.vertex_faces.extend(a.own_vertices(face_a).map(|vertex| [vertex, b0, b1, b2]));
        self.vertex_faces.extend(b.own_vertices(face_b).map(|vertex| [vertex, a0, a1, a2]));
        for [p, q] in a.own_edges(face_a) {
            self.edge_edges.extend(b.own_edges(face_b).map(|[r, s]| [p, q, r, s]));
        }
        if self.vertex_faces.len() + self.edge_edges.len() < Self::BATCH {
            return Ok(());
        }
        progress.report(0.0)?;
        self.flush()
    }

    /// Runs the queries gathered so far.
    fn flush(&mut self) -> Result<(), SweptError> {
        self.candidates += self.vertex_faces.len() + self.edge_edges.len();

        let kind = ContactKind::VertexFace;
        for found in self.motion.vertex_face_contacts(&self.vertex_faces, self.params)? {
            let particles = self.vertex_faces[found.candidate];
            self.contacts.push(self.swept_contact(kind, particles, &found.contact));
        }
        let kind = ContactKind::EdgeEdge;
        for found in self.motion.edge_edge_contacts(&self.edge_edges, self.params)? {
            let particles = self.edge_edges[found.candidate];
            self.contacts.push(self.swept_contact(kind, particles, &found.contact));
        }

        self.vertex_faces.clear();
        self.edge_edges.clear();
        Ok(())
    }

    fn swept_contact(
        &self,
        kind: ContactKind,
        particles: [u32; 4],
        found: &ccd::CcdContact,
    ) -> SweptContact {
        let terms: [Term; 4] =
            std::array::from_fn(|k| Term { particle: particles[k], weight: found.weights[k] });
        let stencil = Stencil::new(&terms).expect("four terms are a stencil");
        let separation = stencil.combine(|particle| self.motion.at(particle, found.lo));
        let offset = self.params.min_separation;
        let contact = Contact {
            stencil,
            anchor: None,
            normal: found.normal,
            offset,
            gap: -separation.dot(found.normal) - offset,
            time: Some(found.lo),
        };
        SweptContact {
            contact,
            kind,
            latest: found.hi,
            certain: found.is_certain(),
            at_start: found.at_start,
        }
    }
}
