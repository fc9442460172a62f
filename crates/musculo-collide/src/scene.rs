//! Bodies by name, where they are, and which pairs are of no interest.

use std::ops::Range;

use distance_field::Pose;
use glam::DVec3;
use kdop::{Dop18, Tree, TreeError};
use surface::{SurfaceError, TriangleSurface};

use crate::shape::Shape;
use crate::{NoInside, SceneError, parallel};

/// Number of a body in its scene, in the order they were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyId(u32);

/// How a body moves, and whether it is meant to have an inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum BodyKind {
    /// Moves as one: a bone.
    Rigid,
    /// Every vertex moves by itself: a muscle.
    Deformable,
    /// A sheet without an inside: nothing is ever inside it.
    Open,
}

/// One surface of a scene.
#[derive(Debug)]
pub struct Body {
    name: String,
    kind: BodyKind,
    first_particle: u32,
    shape: Shape,
    frame: Option<Frame>,
}

/// Where a rigid body was when it was added, and how it was moved since.
#[derive(Debug)]
struct Frame {
    reference: Vec<DVec3>,
    /// From the reference; unknown once its vertices were moved one by one.
    pose: Option<Pose>,
}

/// Bodies that may touch each other.
#[derive(Debug, Default)]
pub struct Scene {
    bodies: Vec<Body>,
    ignored: Vec<(BodyId, BodyId)>,
}

impl BodyId {
    /// The number itself, from 0.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Scene {
    /// No bodies.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a body at `positions`, one for each vertex of `surface`, in the
    /// length unit that all bodies share.
    ///
    /// # Errors
    ///
    /// [`SceneError::DuplicateName`], [`SceneError::NoFaces`],
    /// [`SceneError::TooManyParticles`], and [`SceneError::Surface`] where the
    /// positions do not fit the surface or are not finite.
    pub fn add(
        &mut self,
        name: impl Into<String>,
        kind: BodyKind,
        surface: TriangleSurface,
        positions: Vec<DVec3>,
    ) -> Result<BodyId, SceneError> {
        let name = name.into();
        if self.bodies.iter().any(|body| body.name == name) {
            return Err(SceneError::DuplicateName { name });
        }
        if surface.faces().is_empty() {
            return Err(SceneError::NoFaces { name });
        }
        if let Err(source) = surface.positions(&positions) {
            return Err(SceneError::Surface { name, source });
        }
        let first_particle = self.first_free_particle(&name, positions.len())?;
        let frame = (kind == BodyKind::Rigid).then(|| Frame::new(&positions));
        let shape = Shape::new(kind, surface, positions);
        let id = self.next_id();
        self.bodies.push(Body { name, kind, first_particle, shape, frame });
        Ok(id)
    }

    /// Leaves a pair out of every answer, whichever is named first.
    pub fn ignore(&mut self, a: BodyId, b: BodyId) {
        self.ignored.push((a.min(b), a.max(b)));
    }

    /// The bodies, in the order they were added.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// One body.
    ///
    /// # Panics
    ///
    /// When `id` is of another scene with more bodies.
    #[must_use]
    pub fn body(&self, id: BodyId) -> &Body {
        &self.bodies[id.index()]
    }

    /// The body of a name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<BodyId> {
        self.ids().find(|&id| self.body(id).name == name)
    }

    /// All ids, ascending.
    pub fn ids(&self) -> impl Iterator<Item = BodyId> + use<> {
        (0..self.next_id().0).map(BodyId)
    }

    /// Moves a body's vertices. Its tree of bounds follows when it is next
    /// needed.
    ///
    /// # Errors
    ///
    /// [`SceneError::NoSuchBody`], and [`SceneError::Surface`] where the
    /// positions do not fit; the body then stays where it was.
    pub fn move_body(&mut self, id: BodyId, positions: &[DVec3]) -> Result<(), SceneError> {
        self.check_move(id, positions)?;
        let body = &mut self.bodies[id.index()];
        body.shape.positions_mut().copy_from_slice(positions);
        if let Some(frame) = &mut body.frame {
            frame.pose = None;
        }
        Ok(())
    }

    /// Places a rigid body by its pose, which takes the positions that it was
    /// added with to where it is now.
    ///
    /// # Errors
    ///
    /// [`SceneError::NoSuchBody`], [`SceneError::NotRigid`], and
    /// [`SceneError::Surface`] for a pose that is not finite; the body then
    /// stays where it was.
    pub fn pose_body(&mut self, id: BodyId, pose: &Pose) -> Result<(), SceneError> {
        let count = self.bodies.len();
        let no_such_body = SceneError::NoSuchBody { index: id.index(), count };
        let body = self.bodies.get_mut(id.index()).ok_or(no_such_body)?;
        body.place(pose)
    }

    /// Positions of all particles, body after body.
    #[must_use]
    pub fn particle_positions(&self) -> Vec<DVec3> {
        self.bodies.iter().flat_map(|body| body.positions().iter().copied()).collect()
    }

    /// Whether `positions` are ones that a body can take.
    pub(crate) fn check_move(&self, id: BodyId, positions: &[DVec3]) -> Result<(), SceneError> {
        let count = self.bodies.len();
        let no_such_body = SceneError::NoSuchBody { index: id.index(), count };
        let body = self.bodies.get(id.index()).ok_or(no_such_body)?;
        let checked = body.surface().positions(positions);
        checked
            .map(|_| ())
            .map_err(|source| SceneError::Surface { name: body.name.clone(), source })
    }

    /// Brings all trees to the bodies' present state.
    pub(crate) fn bound_states(&mut self) -> Result<(), SceneError> {
        parallel::map_mut(&mut self.bodies, Body::bound_state).into_iter().collect()
    }

    /// Brings the trees of some bodies, by their numbers, to their present state.
    pub(crate) fn bound_some(&mut self, wanted: &[bool]) -> Result<(), SceneError> {
        let bound = |number: usize, body: &mut Body| {
            if wanted[number] { body.bound_state() } else { Ok(()) }
        };
        parallel::try_each_mut(&mut self.bodies, bound)
    }

    /// Brings all trees around the way from the present state to `x1`,
    /// positions of all particles.
    pub(crate) fn bound_sweeps(&mut self, x1: &[DVec3]) -> Result<(), SceneError> {
        let bound = |body: &mut Body| {
            let particles = body.particles();
            body.bound_sweep(&x1[particles.start as usize..particles.end as usize])
        };
        parallel::map_mut(&mut self.bodies, bound).into_iter().collect()
    }

    /// Pairs of bodies whose bounds come within `margin` of each other and that
    /// are not ignored, in the order of their ids. Trees must be built.
    pub(crate) fn pairs_within(&self, margin: f64) -> Vec<(BodyId, BodyId)> {
        let reached: Vec<Dop18> =
            self.bodies.iter().map(|body| body.tree().root().inflated(margin)).collect();
        let touch = |a: BodyId, b: BodyId| reached[a.index()].overlaps(&self.body(b).tree().root());
        self.ids()
            .flat_map(|a| self.ids().skip(a.index() + 1).map(move |b| (a, b)))
            .filter(|&(a, b)| touch(a, b) && !self.is_ignored(a, b))
            .collect()
    }

    /// Whether a pair is left out of every answer.
    pub(crate) fn is_ignored(&self, a: BodyId, b: BodyId) -> bool {
        self.ignored.contains(&(a.min(b), a.max(b)))
    }

    fn next_id(&self) -> BodyId {
        // Each body has a vertex at least, and those are numbered in 32 bits.
        BodyId(u32::try_from(self.bodies.len()).unwrap_or(u32::MAX))
    }

    fn first_free_particle(&self, name: &str, more: usize) -> Result<u32, SceneError> {
        let first = self.bodies.last().map_or(0, |body| body.particles().end);
        let count = first as usize + more;
        let limit = u32::MAX as usize - 1;
        if count > limit {
            return Err(SceneError::TooManyParticles { name: name.to_owned(), count, limit });
        }
        Ok(first)
    }
}

impl Body {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How it moves.
    #[must_use]
    pub fn kind(&self) -> BodyKind {
        self.kind
    }

    /// Its connectivity.
    #[must_use]
    pub fn surface(&self) -> &TriangleSurface {
        self.shape.surface()
    }

    /// Where its vertices are.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        self.shape.positions()
    }

    /// Numbers of its vertices among all particles of the scene, in which the
    /// stencils of contacts are written.
    #[must_use]
    pub fn particles(&self) -> Range<u32> {
        let count = u32::try_from(self.positions().len()).unwrap_or(u32::MAX);
        self.first_particle..self.first_particle.saturating_add(count)
    }

    /// Whether "inside" means anything for this body, or why not.
    ///
    /// Counting crossings tells the inside of any surface whose edges all have
    /// an even number of faces, wound whichever way.
    ///
    /// # Errors
    ///
    /// [`NoInside`] where the body was declared open, or has an edge with an odd
    /// number of faces.
    pub fn has_inside(&self) -> Result<(), NoInside> {
        self.shape.has_inside()
    }

    /// Where a rigid body is, from where it was added; `None` for other bodies,
    /// and for a rigid one whose vertices were [moved](Scene::move_body) one by
    /// one.
    #[must_use]
    pub fn pose(&self) -> Option<Pose> {
        self.frame.as_ref().and_then(|frame| frame.pose)
    }

    pub(crate) fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Positions that a rigid body was added with.
    pub(crate) fn reference(&self) -> Option<&[DVec3]> {
        self.frame.as_ref().map(|frame| &frame.reference[..])
    }

    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.shape.corners(face)
    }

    /// The tree over its faces, which the scene has brought up to date.
    pub(crate) fn tree(&self) -> &Tree {
        self.shape.tree()
    }

    /// Says whose tree cannot be built.
    pub(crate) fn tree_error(&self, source: TreeError) -> SceneError {
        SceneError::Tree { name: self.name.clone(), source }
    }

    fn bound_state(&mut self) -> Result<(), SceneError> {
        self.shape.bound_state().map_err(|source| self.tree_error(source))
    }

    fn bound_sweep(&mut self, x1: &[DVec3]) -> Result<(), SceneError> {
        self.shape.bound_sweep(x1).map_err(|source| self.tree_error(source))
    }

    fn place(&mut self, pose: &Pose) -> Result<(), SceneError> {
        let Some(frame) = &mut self.frame else {
            return Err(SceneError::NotRigid { name: self.name.clone() });
        };
        let placed = frame.reference.iter().map(|&p| pose.transform_point(p));
        if let Some((vertex, at)) = placed.clone().enumerate().find(|(_, p)| !p.is_finite()) {
            let source = SurfaceError::NotFinite { vertex, at };
            return Err(SceneError::Surface { name: self.name.clone(), source });
        }
        for (x, placed) in self.shape.positions_mut().iter_mut().zip(placed) {
            *x = placed;
        }
        frame.pose = Some(*pose);
        Ok(())
    }
}

impl Frame {
    fn new(positions: &[DVec3]) -> Self {
        Self { reference: positions.to_vec(), pose: Some(Pose::IDENTITY) }
    }
}
