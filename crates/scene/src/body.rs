//! Bodies of a scene, and their motion.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use kdop::{StepTree, TreeError};
use medial::ContactBody;
use proximity::{
    ContactSurface, LazySurfaceTree, NoInside, ParticleNumbers, SurfaceTree, SweptSide,
};
use response::{Combinations, ResponseError};
use surface::progress::{Interrupted, Progress};
use surface::{Aabb, Pose, Positions, SimplexSurface, SurfaceError, Term, TriangleSurface};

use crate::SceneError;
use crate::outward::Outward;

/// Kind of motion of a body, and whether it is meant to have an inside.
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
#[derive(Clone, Debug)]
pub struct Body {
    name: String,
    kind: BodyKind,
    first_particle: u32,
    surface: LazySurfaceTree,
    /// The same surface with faces that look outward, where those of `surface` look inward.
    outward: Outward,
    /// Polygons that the faces are fans of.
    simplex: Option<SimplexSurface>,
    /// Box around the positions, once computed.
    bounds: Option<Aabb>,
    /// Positions that a rigid body was added with, once it has left them.
    reference: Option<Vec<DVec3>>,
    /// Pose of a rigid body from its reference, unless vertices were moved one by one.
    pose: Option<Pose>,
    /// Revision that it was added with.
    origin: Revision,
    revision: Revision,
}

/// State of a body's positions, of which no two are alike, in whatever scenes: what was computed of
/// the positions holds while it stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Revision(u64);

impl Revision {
    /// Returns a revision that no body has had.
    fn next() -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        Self(COUNT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Place of a body.
#[derive(Debug)]
pub(crate) struct BodyState {
    positions: Vec<DVec3>,
    pose: Option<Pose>,
    /// True if a rigid body has left the positions that it was added with.
    has_left: bool,
}

impl Body {
    pub(crate) fn new(
        name: String,
        kind: BodyKind,
        first_particle: u32,
        surface: TriangleSurface,
        positions: Vec<DVec3>,
    ) -> Result<Self, SceneError> {
        if surface.faces().is_empty() {
            return Err(SceneError::NoFaces { name });
        }
        let mut surface = match LazySurfaceTree::new(surface, positions) {
            Ok(surface) => surface,
            Err(source) => return Err(SceneError::Surface { name, source }),
        };
        if kind == BodyKind::Open {
            surface = surface.declared_open();
        }
        let outward = match Outward::of(&surface) {
            Ok(outward) => outward,
            Err(source) => return Err(SceneError::Surface { name, source }),
        };
        let pose = (kind == BodyKind::Rigid).then_some(Pose::IDENTITY);
        let origin = Revision::next();
        Ok(Self {
            name,
            kind,
            first_particle,
            surface,
            outward,
            simplex: None,
            bounds: None,
            reference: None,
            pose,
            origin,
            revision: origin,
        })
    }

    /// Returns the same body as the fans of a simplex surface.
    pub(crate) fn with_simplex(self, simplex: SimplexSurface) -> Self {
        Self { simplex: Some(simplex), ..self }
    }

    /// Returns the simplex surface, if it was [added](crate::Scene::add_simplex) as one.
    #[must_use]
    pub fn simplex(&self) -> Option<&SimplexSurface> {
        self.simplex.as_ref()
    }

    /// Returns true if the body deforms, and has polygons whose centers follow their corners.
    #[must_use]
    pub fn has_moving_centers(&self) -> bool {
        self.simplex.is_some() && !self.is_rigid()
    }

    /// Adds the centers of polygons as combinations of their vertices.
    pub(crate) fn add_centers(&self, out: &mut Combinations) -> Result<(), ResponseError> {
        let Some(simplex) = &self.simplex else { return Ok(()) };
        let (first, mut terms) = (self.first_particle, Vec::new());
        for center in self.particles().skip(simplex.vertex_count()) {
            simplex.spread(&[Term { particle: center - first, weight: 1.0 }], &mut terms);
            for term in &mut terms {
                term.particle += first;
            }
            out.push(center, &terms)?;
        }
        Ok(())
    }

    /// Returns the name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the kind.
    #[must_use]
    pub fn kind(&self) -> BodyKind {
        self.kind
    }

    /// Returns true if the body moves as one.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        self.kind == BodyKind::Rigid
    }

    /// Returns the connectivity.
    #[must_use]
    pub fn surface(&self) -> &TriangleSurface {
        self.surface.surface()
    }

    /// Returns the connectivity, shared with whoever keeps it.
    #[must_use]
    pub fn shared_surface(&self) -> Arc<TriangleSurface> {
        self.surface.shared_surface()
    }

    /// Returns the positions of the vertices.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        self.checked_positions().as_slice()
    }

    /// Returns the positions of the vertices, with the proof that they fit the surface.
    #[must_use]
    pub fn checked_positions(&self) -> Positions<'_> {
        self.surface.positions()
    }

    /// Returns the corners of one face.
    ///
    /// # Panics
    ///
    /// When `face` is not below the surface's face count.
    #[must_use]
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        self.checked_positions().corners(self.surface().faces()[face as usize])
    }

    /// Returns the positions that a body was added with, if it is rigid.
    #[must_use]
    pub fn reference(&self) -> Option<&[DVec3]> {
        let positions = self.reference.as_deref().unwrap_or(self.positions());
        self.is_rigid().then_some(positions)
    }

    /// Returns the absolute value of the largest coordinate, which bounds the rounding of all.
    #[must_use]
    pub fn largest_coordinate(&self) -> f64 {
        self.positions().iter().map(|x| x.abs().max_element()).fold(0.0, f64::max)
    }

    /// Returns the numbers of the vertices among all particles of the scene, in which the
    /// stencils of contacts are written.
    #[must_use]
    pub fn particles(&self) -> Range<u32> {
        let count = u32::try_from(self.positions().len()).unwrap_or(u32::MAX);
        self.first_particle..self.first_particle.saturating_add(count)
    }

    /// Returns the numbers of the vertices, as detectors take them.
    #[must_use]
    pub fn particle_numbers(&self) -> ParticleNumbers<'_> {
        ParticleNumbers::from(self.first_particle)
    }

    /// Returns the body as one side of a contact.
    #[must_use]
    pub fn contact_surface(&self) -> ContactSurface<'_> {
        ContactSurface {
            surface: self.surface(),
            positions: self.checked_positions(),
            particles: self.particle_numbers(),
            is_rigid: self.is_rigid(),
        }
    }

    /// Returns the body as one side of contacts by medial surfaces, where its tree is up to date.
    #[must_use]
    pub fn contact_body(&self) -> Option<ContactBody<'_>> {
        let (particles, is_rigid) = (self.particle_numbers(), self.is_rigid());
        self.tree().map(|tree| ContactBody { tree, particles, is_rigid })
    }

    /// Checks that "inside" is defined for this body.
    ///
    /// # Errors
    ///
    /// [`NoInside`] where the body was declared open, or has an edge with an odd number of faces.
    pub fn has_inside(&self) -> Result<(), NoInside> {
        self.surface.has_inside()
    }

    /// Returns true if the faces looked inward when the body was added, so that they enclosed a negative
    /// volume. Bodies without an inside, or without a volume beyond rounding, are not inside out.
    #[must_use]
    pub fn is_inside_out(&self) -> bool {
        self.surface.is_inside_out()
    }

    /// Returns the surface with faces that look outward, by the same numbers.
    pub(crate) fn outward(&self) -> &LazySurfaceTree {
        self.outward.or(&self.surface)
    }

    /// Returns the sign by which normals of faces point outward.
    pub(crate) fn orientation(&self) -> f64 {
        if self.is_inside_out() { -1.0 } else { 1.0 }
    }

    /// Returns the pose of a rigid body, from where it was added; `None` for other bodies, and
    /// for a rigid one whose vertices were [moved](crate::Scene::move_body) one by one.
    #[must_use]
    pub fn pose(&self) -> Option<Pose> {
        self.pose
    }

    /// Returns the revision that the body was added with: that of its clones, and of no other body. Its
    /// name, kind, faces and reference stay the same.
    #[must_use]
    pub fn origin(&self) -> Revision {
        self.origin
    }

    /// Returns the revision of the positions, which another move changes.
    #[must_use]
    pub fn revision(&self) -> Revision {
        self.revision
    }

    /// Returns the surface with its tree, where that is up to date: `None` unless the scene has
    /// [fitted](crate::Scene::fit) it since the body last moved.
    #[must_use]
    pub fn tree(&self) -> Option<&SurfaceTree> {
        self.surface.fitted()
    }

    /// Returns the box around all faces: vertices without a face may be out of it.
    #[must_use]
    pub fn face_bounds(&self) -> Aabb {
        self.surface.surface().bounds(self.surface.positions())
    }

    /// Returns the box around all positions.
    pub(crate) fn bounds(&mut self) -> Aabb {
        let x = self.surface.positions().as_slice();
        *self.bounds.get_or_insert_with(|| Aabb::of_points(x.iter().copied()))
    }

    /// Returns the box around the positions, if it was computed since the body last moved.
    pub(crate) fn known_bounds(&self) -> Option<Aabb> {
        self.bounds
    }

    /// Builds or refits the tree where it is not up to date.
    pub(crate) fn fit(&mut self) -> Result<(), SceneError> {
        self.fit_with(Progress::none())
    }

    /// Builds or refits the tree where it is not up to date, unless `progress` ends that.
    pub(crate) fn fit_with(&mut self, progress: Progress<'_>) -> Result<(), SceneError> {
        let keep_going = || progress.report(0.0).is_ok();
        match self.outward.fit_while(&mut self.surface, &keep_going) {
            Ok(true) => Ok(()),
            Ok(false) => Err(Interrupted.into()),
            Err(source) => Err(self.tree_error(source)),
        }
    }

    /// Bounds the way to `end`.
    pub(crate) fn fit_step(
        &mut self,
        end: Positions<'_>,
        progress: Progress<'_>,
    ) -> Result<(), SceneError> {
        if !self.surface.is_built() {
            self.fit_with(progress)?;
        }
        self.surface.fit_step(end).map_err(|source| self.tree_error(source))
    }

    /// Returns the body as one side of a swept query, where its bounds are up to date.
    pub(crate) fn swept_side(&self, is_moving: bool) -> Option<SweptSide<'_>> {
        let resting = self.tree().map(|surface| StepTree::at_rest(surface.tree()));
        let tree = if is_moving { self.surface.step_tree() } else { resting };
        let (surface, first_particle) = (self.surface(), self.first_particle);
        tree.map(|tree| SweptSide { surface, tree, first_particle })
    }

    /// Checks that the body can take these positions.
    pub(crate) fn check_positions<'a>(
        &self,
        positions: &'a [DVec3],
    ) -> Result<Positions<'a>, SceneError> {
        self.surface().positions(positions).map_err(|source| self.surface_error(source))
    }

    /// Moves the vertices one by one.
    pub(crate) fn set_positions(&mut self, positions: &[DVec3]) -> Result<(), SceneError> {
        self.keep_reference();
        let moved = self.outward.set_positions(&mut self.surface, positions.iter().copied());
        self.finish_move(moved, None)
    }

    /// Places a rigid body.
    pub(crate) fn set_pose(&mut self, pose: &Pose) -> Result<(), SceneError> {
        if !self.is_rigid() {
            return Err(SceneError::NotRigid { name: self.name.clone() });
        }
        // Where it is already, everything stays up to date.
        if self.pose == Some(*pose) {
            return Ok(());
        }
        self.keep_reference();
        let placed = self.reference.iter().flatten().map(|&p| pose.transform_point(p));
        let moved = self.outward.set_positions(&mut self.surface, placed);
        self.finish_move(moved, Some(*pose))
    }

    /// Returns where the body is, to go back to.
    pub(crate) fn state(&self) -> BodyState {
        BodyState {
            positions: self.positions().to_vec(),
            pose: self.pose,
            has_left: self.reference.is_some(),
        }
    }

    /// Goes back to a state.
    pub(crate) fn restore(&mut self, state: BodyState) -> Result<(), SceneError> {
        let moved = self.outward.set_positions(&mut self.surface, state.positions.into_iter());
        if !state.has_left {
            self.reference = None;
        }
        self.finish_move(moved, state.pose)
    }

    /// Keeps the positions that a rigid body was added with, before it leaves them.
    fn keep_reference(&mut self) {
        if self.is_rigid() && self.reference.is_none() {
            self.reference = Some(self.positions().to_vec());
        }
    }

    fn finish_move(
        &mut self,
        moved: Result<(), SurfaceError>,
        pose: Option<Pose>,
    ) -> Result<(), SceneError> {
        moved.map_err(|source| self.surface_error(source))?;
        self.bounds = None;
        self.pose = pose;
        self.revision = Revision::next();
        Ok(())
    }

    pub(crate) fn surface_error(&self, source: SurfaceError) -> SceneError {
        SceneError::Surface { name: self.name.clone(), source }
    }

    fn tree_error(&self, source: TreeError) -> SceneError {
        SceneError::Tree { name: self.name.clone(), source }
    }
}

#[cfg(test)]
mod tests {
    use ccd::CcdParams;
    use fixtures::shapes::tetrahedron;

    use super::*;
    use crate::{BodyId, BodyMove, CheckParams, Scene};

    /// A row of rigid tetrahedra of size 1, of which the first two overlap and the others are 3
    /// apart from each other.
    fn row(count: u32) -> Scene {
        let mut scene = Scene::new();
        for number in 0..count {
            let place = if number == 1 { 0.5 } else { 3.0 * f64::from(number) };
            let body = tetrahedron(1.0).translated(DVec3::X * place);
            let surface = body.surface();
            scene
                .add(number.to_string(), BodyKind::Rigid, surface, body.positions)
                .expect("a body");
        }
        scene
    }

    fn fitted(scene: &Scene) -> Vec<usize> {
        scene.ids().filter(|&id| scene.body(id).tree().is_some()).map(BodyId::index).collect()
    }

    #[test]
    fn trees_are_built_for_bodies_that_may_meet() {
        let mut scene = row(4);
        let reports = scene.check(&CheckParams::new(0.5), Progress::none()).expect("a check");
        assert_eq!(reports.len(), 1);
        assert_eq!(fitted(&scene), [0, 1]);

        // A body that moves is refit once it may meet another one.
        let [first, last] = [BodyId(0), BodyId(3)];
        let away = scene.body(first).positions().iter().map(|p| *p - 50.0 * DVec3::X);
        scene.move_body(first, &away.collect::<Vec<_>>()).expect("a move");
        assert_eq!(fitted(&scene), [1]);
        scene.check(&CheckParams::new(0.5), Progress::none()).expect("a check");
        assert_eq!(fitted(&scene), [1], "it meets none there");
        scene.segment(first, last).expect("regions");
        assert_eq!(fitted(&scene), [0, 1, 3], "a question about two bodies");
    }

    #[test]
    fn a_step_bounds_the_way_of_bodies_that_move() {
        let mut scene = row(4);
        let over_the_third: Vec<DVec3> =
            scene.body(BodyId(1)).positions().iter().map(|p| *p + 7.0 * DVec3::X).collect();
        let moves = [BodyMove { body: BodyId(1), positions: &over_the_third }];
        let report = scene.sweep(&moves, &CcdParams::EXACT, Progress::none()).expect("a sweep");
        assert_eq!(report.pairs.len(), 2, "it leaves the first and passes through the third");

        let has_step = |id: &BodyId| scene.body(*id).surface.step_tree().is_some();
        assert_eq!(scene.ids().filter(has_step).map(BodyId::index).collect::<Vec<_>>(), [1]);
        assert_eq!(fitted(&scene), [0, 1, 2], "the first and third rest, the fourth is far");
    }

    #[test]
    fn a_bone_holds_its_positions_once_until_it_leaves_them() {
        let mut scene = row(1);
        let id = BodyId(0);
        assert!(scene.body(id).reference.is_none());
        let start = scene.body(id).positions().to_vec();
        assert_eq!(scene.body(id).reference(), Some(&start[..]));

        let pose = Pose::new(glam::DQuat::from_rotation_z(1.0), DVec3::Y);
        scene.pose_body(id, &pose).expect("a pose");
        assert!(scene.body(id).reference.is_some() && scene.body(id).positions() != start);
        assert_eq!(scene.body(id).reference(), Some(&start[..]));
    }
}
