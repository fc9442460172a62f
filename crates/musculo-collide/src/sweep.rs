//! Swept detection: which surfaces met between two successive states, and when.
//!
//! Trees over both states give pairs of faces whose paths come near. Each
//! vertex and each edge belongs to one of its faces, so that a pair of faces
//! stands for its own vertices and edges only and no question is asked twice.
//! The questions go to [`ccd`] in batches.
//!
//! Source: S. Curtis, R. Tamstorf and D. Manocha, "Fast Collision Detection for
//! Deformable Models using Representative-Triangles", I3D 2008, section 4, for
//! the assignment of features to faces.

use ccd::{CandidateContact, MovingPoints};
use glam::DVec3;
use kdop::Workspace;
use surface::{Contact, Stencil, Term, TriangleSurface};

use crate::scene::Body;
use crate::{BodyId, Scene, SceneError, parallel};

/// Who met whom during a step.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepReport {
    /// Pairs that met, in the order of the bodies.
    pub pairs: Vec<PairSweep>,
    /// Share of the step, in `0.0..=1.0`, before which no contact begins: 1
    /// where nothing meets. Never after the first contact.
    pub largest_free_step: f64,
    /// Questions asked of two primitives, over all pairs.
    pub candidates: usize,
}

/// What happened between two bodies during a step.
#[derive(Clone, Debug, PartialEq)]
pub struct PairSweep {
    /// The first body.
    pub a: BodyId,
    /// The second body, of the higher number.
    pub b: BodyId,
    /// First contacts of their vertices, edges and faces, by time; never empty.
    pub contacts: Vec<SweptContact>,
}

/// Two primitives that met during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SweptContact {
    /// The contact at its earliest time, with particles numbered by
    /// [`Body::particles`]; those of a rigid body are among them. Its identity
    /// holds for the particles' positions at that time, with the minimum
    /// separation for an offset.
    pub contact: Contact,
    /// What met.
    pub kind: ContactKind,
    /// End of the interval in which the contact begins.
    pub latest: f64,
    /// Whether it is proven, rather than only not excluded by rounding.
    pub certain: bool,
    /// Whether it may have been there at the start of the step.
    pub at_start: bool,
}

/// Which primitives met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ContactKind {
    /// A vertex and a face.
    VertexFace,
    /// Two edges.
    EdgeEdge,
}

impl Scene {
    /// Finds who meets while each body named in `moves` goes to its new
    /// positions, every vertex on a straight line; other bodies rest.
    ///
    /// The bodies are not moved: [`move_body`](Self::move_body) does that. A
    /// contact is never missed, and its time never after the true one.
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] and [`SceneError::Surface`] for moves that
    ///   do not fit their bodies.
    /// - [`SceneError::Ccd`] for parameters out of range.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    pub fn sweep(
        &mut self,
        moves: &[(BodyId, &[DVec3])],
        params: &ccd::CcdParams,
    ) -> Result<SweepReport, SceneError> {
        self.sweep_among(moves, params, |_, _| true)
    }

    /// As [`Self::sweep`], for the pairs that are wanted.
    pub(crate) fn sweep_among(
        &mut self,
        moves: &[(BodyId, &[DVec3])],
        params: &ccd::CcdParams,
        is_wanted: impl Fn(BodyId, BodyId) -> bool,
    ) -> Result<SweepReport, SceneError> {
        params.validate().map_err(|source| SceneError::Ccd { source })?;
        let x0 = self.particle_positions();
        let x1 = self.moved_positions(moves, &x0)?;
        let motion = MovingPoints::new(&x0, &x1).map_err(|source| SceneError::Ccd { source })?;
        self.bound_sweeps(&x1)?;
        let scene = &*self;
        let mut pairs = scene.pairs_within(params.min_separation);
        pairs.retain(|&(a, b)| is_wanted(a, b));
        let swept = parallel::map_with(&pairs, Workspace::default, |workspace, &(a, b)| {
            sweep_pair((a, scene.body(a)), (b, scene.body(b)), &motion, params, workspace)
        });
        let swept: Vec<(PairSweep, usize)> = swept
            .into_iter()
            .collect::<Result<_, ccd::CcdError>>()
            .map_err(|source| SceneError::Ccd { source })?;
        let candidates = swept.iter().map(|(_, candidates)| candidates).sum();
        let pairs: Vec<PairSweep> =
            swept.into_iter().map(|(pair, _)| pair).filter(|p| !p.contacts.is_empty()).collect();
        let times = pairs.iter().filter_map(PairSweep::first_time);
        Ok(SweepReport { largest_free_step: times.fold(1.0, f64::min), pairs, candidates })
    }

    /// Positions of all particles after `moves`.
    fn moved_positions(
        &self,
        moves: &[(BodyId, &[DVec3])],
        x0: &[DVec3],
    ) -> Result<Vec<DVec3>, SceneError> {
        let mut x1 = x0.to_vec();
        for &(id, positions) in moves {
            self.check_move(id, positions)?;
            let particles = self.body(id).particles();
            x1[particles.start as usize..particles.end as usize].copy_from_slice(positions);
        }
        Ok(x1)
    }
}

impl PairSweep {
    /// Earliest time of a contact.
    #[must_use]
    pub fn first_time(&self) -> Option<f64> {
        self.contacts.first().and_then(|first| first.contact.time)
    }
}

type Numbered<'a> = (BodyId, &'a Body);

/// What happens between two bodies, and how many questions that took.
fn sweep_pair(
    (a_id, a): Numbered<'_>,
    (b_id, b): Numbered<'_>,
    motion: &MovingPoints<'_>,
    params: &ccd::CcdParams,
    workspace: &mut Workspace,
) -> Result<(PairSweep, usize), ccd::CcdError> {
    let mut questions = Questions::new(motion, params);
    let (of_a, of_b) = (Features::of(a), Features::of(b));
    a.tree().pairs(b.tree(), params.min_separation, workspace, |fa, fb| {
        questions.ask(&of_a, fa, &of_b, fb);
    });
    let (mut contacts, candidates) = questions.finish()?;
    let key = |c: &SweptContact| c.contact.time.unwrap_or(1.0);
    // Stable: contacts at one time stay in the order of the traversal.
    contacts.sort_by(|p, q| key(p).total_cmp(&key(q)));
    Ok((PairSweep { a: a_id, b: b_id, contacts }, candidates))
}

/// A body's vertices and edges by the faces that stand for them.
struct Features<'a> {
    surface: &'a TriangleSurface,
    first_particle: u32,
}

impl<'a> Features<'a> {
    fn of(body: &'a Body) -> Self {
        Self { surface: body.surface(), first_particle: body.particles().start }
    }

    fn corners(&self, face: u32) -> [u32; 3] {
        self.surface.faces()[face as usize].map(|vertex| self.first_particle + vertex)
    }

    /// Corners that this face stands for: those of which it is the first face.
    fn own_vertices(&self, face: u32) -> impl Iterator<Item = u32> {
        let corners = self.surface.faces()[face as usize];
        let own = move |&vertex: &u32| self.surface.vertex_faces(vertex)[0] == face;
        corners.into_iter().filter(own).map(|vertex| self.first_particle + vertex)
    }

    /// Edges that this face stands for, by their ends.
    fn own_edges(&self, face: u32) -> impl Iterator<Item = [u32; 2]> {
        let edges = self.surface.face_edges()[face as usize];
        let own =
            move |&edge: &u32| edge != surface::NO_EDGE && self.surface.edge_faces(edge)[0] == face;
        let ends = |edge: u32| self.surface.edges()[edge as usize].map(|v| self.first_particle + v);
        edges.into_iter().filter(own).map(ends)
    }
}

/// Questions gathered until there are enough for a batch.
struct Questions<'a> {
    motion: &'a MovingPoints<'a>,
    params: &'a ccd::CcdParams,
    vertex_faces: Vec<[u32; 4]>,
    edge_edges: Vec<[u32; 4]>,
    asked: usize,
    contacts: Vec<SweptContact>,
    failed: Option<ccd::CcdError>,
}

impl<'a> Questions<'a> {
    /// Candidates held before they are answered: half a megabyte, so that they
    /// stay in the cache and no number of candidates exhausts the memory.
    const BATCH: usize = 1 << 15;

    fn new(motion: &'a MovingPoints<'a>, params: &'a ccd::CcdParams) -> Self {
        Self {
            motion,
            params,
            vertex_faces: Vec::new(),
            edge_edges: Vec::new(),
            asked: 0,
            contacts: Vec::new(),
            failed: None,
        }
    }

    /// All questions that a pair of faces stands for.
    fn ask(&mut self, a: &Features<'_>, fa: u32, b: &Features<'_>, fb: u32) {
        let ([a0, a1, a2], [b0, b1, b2]) = (a.corners(fa), b.corners(fb));
        self.vertex_faces.extend(a.own_vertices(fa).map(|vertex| [vertex, b0, b1, b2]));
        self.vertex_faces.extend(b.own_vertices(fb).map(|vertex| [vertex, a0, a1, a2]));
        for [p, q] in a.own_edges(fa) {
            self.edge_edges.extend(b.own_edges(fb).map(|[r, s]| [p, q, r, s]));
        }
        if self.vertex_faces.len() + self.edge_edges.len() >= Self::BATCH {
            self.answer();
        }
    }

    fn finish(mut self) -> Result<(Vec<SweptContact>, usize), ccd::CcdError> {
        self.answer();
        self.failed.map_or(Ok((self.contacts, self.asked)), Err)
    }

    fn answer(&mut self) {
        self.asked += self.vertex_faces.len() + self.edge_edges.len();
        let answers = self.motion.vertex_face_contacts(&self.vertex_faces, self.params);
        let vertex_faces = std::mem::take(&mut self.vertex_faces);
        self.keep(ContactKind::VertexFace, &vertex_faces, answers);
        let answers = self.motion.edge_edge_contacts(&self.edge_edges, self.params);
        let edge_edges = std::mem::take(&mut self.edge_edges);
        self.keep(ContactKind::EdgeEdge, &edge_edges, answers);
        self.vertex_faces = emptied(vertex_faces);
        self.edge_edges = emptied(edge_edges);
    }

    fn keep(
        &mut self,
        kind: ContactKind,
        candidates: &[[u32; 4]],
        answers: Result<Vec<CandidateContact>, ccd::CcdError>,
    ) {
        match answers {
            Err(error) => self.failed = self.failed.or(Some(error)),
            Ok(found) => {
                for CandidateContact { candidate, contact } in found {
                    let contact = self.swept_contact(kind, &candidates[candidate], &contact);
                    self.contacts.push(contact);
                }
            }
        }
    }

    fn swept_contact(
        &self,
        kind: ContactKind,
        particles: &[u32; 4],
        found: &ccd::CcdContact,
    ) -> SweptContact {
        let terms: [Term; 4] =
            std::array::from_fn(|k| Term { particle: particles[k], weight: found.weights[k] });
        let stencil = Stencil::new(&terms).expect("four terms are a stencil");
        let separation = stencil.combine(|particle| self.motion.at(particle, found.lo));
        let offset = self.params.min_separation;
        let gap = -separation.dot(found.normal) - offset;
        let contact = Contact {
            stencil,
            anchor: None,
            normal: found.normal,
            offset,
            gap,
            time: Some(found.lo),
        };
        let (certain, at_start) = (found.is_certain(), found.at_start);
        SweptContact { contact, kind, latest: found.hi, certain, at_start }
    }
}

/// The same memory, empty.
fn emptied<T>(mut list: Vec<T>) -> Vec<T> {
    list.clear();
    list
}
