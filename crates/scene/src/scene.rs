//! Scenes: bodies by name, and pairs that are ignored.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use surface::progress::{Interrupted, Progress};
use surface::{Aabb, Pose, SimplexSurface, TriangleSurface, parallel};

use crate::broad_phase::overlapping_pairs;
use crate::{Body, BodyId, BodyKind, BodyMove, BodyPlace, PairId, SceneError};

/// Bodies that may touch each other.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub(crate) bodies: Vec<Body>,
    ids: BTreeMap<String, BodyId>,
    ignored: BTreeSet<PairId>,
}

impl Scene {
    /// Returns a scene without bodies.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a body at `positions` (|V|), in the length unit that all bodies share.
    ///
    /// # Errors
    ///
    /// [`SceneError::DuplicateName`], [`SceneError::EmptyName`], [`SceneError::ControlCharacter`],
    /// [`SceneError::NoFaces`], [`SceneError::TooManyParticles`], and [`SceneError::Surface`] where the positions do not fit
    /// the surface or are not finite.
    pub fn add(
        &mut self,
        name: impl Into<String>,
        kind: BodyKind,
        surface: TriangleSurface,
        positions: Vec<DVec3>,
    ) -> Result<BodyId, SceneError> {
        let (name, first) = self.check_new(name.into(), positions.len())?;
        Ok(self.push(Body::new(name, kind, first, surface, positions)?))
    }

    /// Adds a body of polygons, of which three meet at each vertex (a 2-simplex mesh), at
    /// `positions` (|V|).
    ///
    /// Its faces are the [fans](SimplexSurface::fan) of the polygons about their centers, which are
    /// numbered as particles after the vertices. A center is the mean of its polygon: it has no mass
    /// of its own, and a [`SceneStep`](crate::SceneStep) carries contacts on it back to the vertices
    /// of the polygon.
    ///
    /// # Errors
    ///
    /// As [`Self::add`].
    pub fn add_simplex(
        &mut self,
        name: impl Into<String>,
        kind: BodyKind,
        simplex: SimplexSurface,
        positions: &[DVec3],
    ) -> Result<BodyId, SceneError> {
        let count = simplex.vertex_count() + simplex.polygon_count();
        let (name, first) = self.check_new(name.into(), count)?;
        let named = |source| SceneError::Surface { name: name.clone(), source };
        let mut fan_positions = Vec::new();
        simplex.fan_positions(simplex.positions(positions).map_err(named)?, &mut fan_positions);
        let surface = simplex.fan().map_err(named)?;
        let body = Body::new(name, kind, first, surface, fan_positions)?;
        Ok(self.push(body.with_simplex(simplex)))
    }

    /// Checks that a body can be added; returns the number of its first particle.
    fn check_new(&self, name: String, particles: usize) -> Result<(String, u32), SceneError> {
        if name.is_empty() {
            return Err(SceneError::EmptyName);
        }
        if name.contains(char::is_control) {
            return Err(SceneError::ControlCharacter { name });
        }
        if self.ids.contains_key(&name) {
            return Err(SceneError::DuplicateName { name });
        }
        let first = self.bodies.last().map_or(0, |body| body.particles().end);
        let count = first as usize + particles;
        let limit = u32::MAX as usize - 1;
        if count > limit {
            return Err(SceneError::TooManyParticles { name, count, limit });
        }
        Ok((name, first))
    }

    fn push(&mut self, body: Body) -> BodyId {
        let id = self.next_id();
        self.ids.insert(body.name().to_owned(), id);
        self.bodies.push(body);
        id
    }

    /// Leaves a pair out of every result, in whichever order it is named.
    pub fn ignore(&mut self, a: BodyId, b: BodyId) {
        self.ignored.insert(PairId::new(a, b));
    }

    /// Returns true if a pair is left out of every result.
    #[must_use]
    pub fn is_ignored(&self, pair: PairId) -> bool {
        self.ignored.contains(&pair)
    }

    /// Returns the bodies, in the order they were added.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the absolute value of the largest coordinate of all bodies.
    #[must_use]
    pub fn largest_coordinate(&self) -> f64 {
        let largest = |number: usize| self.bodies[number].largest_coordinate();
        parallel::map(self.bodies.len(), largest).into_iter().fold(0.0, f64::max)
    }

    /// Returns one body.
    ///
    /// # Panics
    ///
    /// When `id` is of another scene with more bodies.
    #[must_use]
    pub fn body(&self, id: BodyId) -> &Body {
        &self.bodies[id.index()]
    }

    /// Returns one body, if it is in this scene.
    ///
    /// # Errors
    ///
    /// [`SceneError::NoSuchBody`] when `id` is of another scene with more bodies.
    pub fn get(&self, id: BodyId) -> Result<&Body, SceneError> {
        let no_such_body = SceneError::NoSuchBody { index: id.index(), count: self.bodies.len() };
        self.bodies.get(id.index()).ok_or(no_such_body)
    }

    /// Returns the names of both bodies of a pair.
    ///
    /// # Panics
    ///
    /// When the pair is of another scene with more bodies.
    #[must_use]
    pub fn names(&self, pair: PairId) -> [&str; 2] {
        [self.body(pair.a).name(), self.body(pair.b).name()]
    }

    /// Finds the body of a name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<BodyId> {
        self.ids.get(name).copied()
    }

    /// Returns all ids, ascending.
    pub fn ids(&self) -> impl Iterator<Item = BodyId> + use<> {
        (0..self.next_id().0).map(BodyId)
    }

    /// Moves a body's vertices. Its tree follows when it is next needed.
    ///
    /// # Errors
    ///
    /// [`SceneError::NoSuchBody`], and [`SceneError::Surface`] where the positions do not fit;
    /// the body then stays where it was.
    pub fn move_body(&mut self, id: BodyId, positions: &[DVec3]) -> Result<(), SceneError> {
        self.get_mut(id)?.set_positions(positions)
    }

    /// Moves the vertices of several bodies, in all threads; of two moves of a body the last counts.
    ///
    /// # Errors
    ///
    /// As [`place_bodies`](Self::place_bodies).
    pub fn move_bodies(&mut self, moves: &[BodyMove<'_>]) -> Result<(), SceneError> {
        let mut places = Vec::new();
        for &BodyMove { body, positions } in moves {
            places.push((body, BodyPlace::Positions(positions)));
        }
        self.place_bodies(&places)
    }

    /// Places several bodies as they are in a frame, in all threads; of two places of a body the last
    /// counts.
    ///
    /// # Errors
    ///
    /// [`SceneError::NoSuchBody`], before any body has moved; else as [`move_body`](Self::move_body) and
    /// [`pose_body`](Self::pose_body), of the first body with an error, which stays where it was. Other
    /// bodies may have moved or not.
    pub fn place_bodies(&mut self, places: &[(BodyId, BodyPlace<'_>)]) -> Result<(), SceneError> {
        let mut of_bodies: Vec<Option<BodyPlace<'_>>> = vec![None; self.bodies.len()];
        for &(id, place) in places {
            self.get(id)?;
            of_bodies[id.index()] = Some(place);
        }
        parallel::try_for_each_mut(&mut self.bodies, |number, body| match of_bodies[number] {
            Some(BodyPlace::Positions(x)) => body.set_positions(x),
            Some(BodyPlace::Pose(pose)) => body.set_pose(&pose),
            None => Ok(()),
        })
    }

    /// Places a rigid body by its pose, which maps the positions that it was added with to the
    /// world.
    ///
    /// # Errors
    ///
    /// [`SceneError::NoSuchBody`], [`SceneError::NotRigid`], and [`SceneError::Surface`] for a
    /// pose that is not finite; the body then stays where it was.
    pub fn pose_body(&mut self, id: BodyId, pose: &Pose) -> Result<(), SceneError> {
        self.get_mut(id)?.set_pose(pose)
    }

    /// Returns the positions of all particles, body after body.
    #[must_use]
    pub fn particle_positions(&self) -> Vec<DVec3> {
        let mut positions = Vec::new();
        for body in &self.bodies {
            positions.extend_from_slice(body.positions());
        }
        positions
    }

    /// Brings the trees of some bodies, by their numbers, to their present state. Allocates
    /// nothing once they are built.
    ///
    /// # Errors
    ///
    /// [`SceneError::Tree`] when a body is too large to build bounds for.
    ///
    /// # Panics
    ///
    /// When `is_wanted` is shorter than the list of bodies.
    pub fn fit(&mut self, is_wanted: &[bool]) -> Result<(), SceneError> {
        self.fit_with(is_wanted, Progress::none())
    }

    /// As [`fit`](Self::fit), unless `progress` ends that.
    pub(crate) fn fit_with(
        &mut self,
        is_wanted: &[bool],
        progress: Progress<'_>,
    ) -> Result<(), SceneError> {
        let progress = progress.part(0.0, 0.0);
        parallel::try_for_each_mut(&mut self.bodies, |number, body| {
            if is_wanted[number] { body.fit_with(progress) } else { Ok(()) }
        })
    }

    /// Brings the trees of all bodies to their present state.
    ///
    /// # Errors
    ///
    /// As [`fit`](Self::fit).
    pub fn fit_all(&mut self) -> Result<(), SceneError> {
        parallel::try_for_each_mut(&mut self.bodies, |_, body| body.fit())
    }

    /// Finds the pairs of bodies whose bounds come within `margin` of each other, in the order of
    /// their ids, without the ignored ones. Trees of these bodies are brought to their present
    /// state; no others are touched.
    ///
    /// # Errors
    ///
    /// As [`fit`](Self::fit).
    pub fn close_pairs(&mut self, margin: f64) -> Result<Vec<PairId>, SceneError> {
        self.close_pairs_with(margin, Progress::none())
    }

    /// As [`close_pairs`](Self::close_pairs), unless `progress` ends that.
    pub(crate) fn close_pairs_with(
        &mut self,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<Vec<PairId>, SceneError> {
        let boxes = self.boxes();
        let mut pairs = self.candidate_pairs(&boxes, margin);
        self.fit_with(&self.members(&pairs), progress)?;

        // The bounds of a tree are tighter than boxes.
        pairs.retain(|&pair| self.roots_are_close(pair, margin));
        Ok(pairs)
    }

    /// Returns true if the bounds of two bodies come within `margin` of each other.
    pub(crate) fn roots_are_close(&self, pair: PairId, margin: f64) -> bool {
        let trees = (self.body(pair.a).tree(), self.body(pair.b).tree());
        let (Some(a), Some(b)) = trees else { return false };
        a.tree().root().inflated(margin).overlaps(&b.tree().root())
    }

    /// Finds the pairs of bodies whose boxes come within `margin` of each other, in the order of
    /// their ids, with the ignored ones. Touches no tree.
    #[must_use]
    pub fn box_pairs(&mut self, margin: f64) -> Vec<PairId> {
        overlapping_pairs(&self.boxes(), margin)
    }

    /// Returns the box around each body.
    pub(crate) fn boxes(&mut self) -> Vec<Aabb> {
        parallel::map_mut(&mut self.bodies, Body::bounds)
    }

    /// Computes the box around each body into a list that is replaced.
    pub(crate) fn compute_boxes(&mut self, boxes: &mut Vec<Aabb>) {
        boxes.clear();
        boxes.extend(self.bodies.iter_mut().map(Body::bounds));
    }

    /// Finds the pairs of bodies whose boxes come within `margin` of each other, without the
    /// ignored ones.
    pub(crate) fn candidate_pairs(&self, boxes: &[Aabb], margin: f64) -> Vec<PairId> {
        let mut pairs = overlapping_pairs(boxes, margin);
        pairs.retain(|&pair| !self.is_ignored(pair));
        pairs
    }

    /// Maps pairs on the threads of the current pool, and collects what is found in their order.
    ///
    /// Pairs of which more may be near begin first.
    pub(crate) fn map_pairs<S, R: Send, E: From<Interrupted> + Send>(
        &self,
        pairs: &[PairId],
        scratch: impl Fn() -> S + Sync + Send,
        progress: Progress<'_>,
        f: impl Fn(&mut S, PairId, Progress<'_>) -> Result<Option<R>, E> + Sync + Send,
    ) -> Result<Vec<R>, E> {
        let steps = progress.steps(pairs.len());
        let cost = |pair: &PairId| self.faces_in_common_box(*pair);
        let found = parallel::map_costly_first(pairs, cost, scratch, |scratch, &pair| {
            let found = f(scratch, pair, steps.within())?;
            steps.advance(1)?;
            Ok(found)
        });
        let found: Result<Vec<_>, E> = found.into_iter().collect();
        Ok(found?.into_iter().flatten().collect())
    }

    /// Estimates the number of faces of two bodies in the box that theirs have in common: a body's
    /// faces times the share of its box.
    pub(crate) fn faces_in_common_box(&self, pair: PairId) -> f64 {
        let bodies = pair.bodies().map(|id| self.body(id));
        let [a, b] = bodies.map(|body| body.known_bounds().unwrap_or(Aabb::EMPTY));
        let common = (a.max.min(b.max) - a.min.max(b.min)).max(DVec3::ZERO);

        let mut faces = 0.0;
        for (body, bounds) in bodies.into_iter().zip([a, b]) {
            let share = common / (bounds.max - bounds.min).max(DVec3::splat(f64::MIN_POSITIVE));
            let count = u32::try_from(body.surface().faces().len()).unwrap_or(u32::MAX);
            faces += f64::from(count) * share.element_product();
        }
        faces
    }

    /// Marks the bodies that are in one of the pairs, by their numbers.
    pub(crate) fn members(&self, pairs: &[PairId]) -> Vec<bool> {
        let mut is_member = Vec::new();
        self.mark_members(pairs, &mut is_member);
        is_member
    }

    /// Marks them in a list that is replaced.
    pub(crate) fn mark_members(&self, pairs: &[PairId], is_member: &mut Vec<bool>) {
        is_member.clear();
        is_member.resize(self.bodies.len(), false);
        for pair in pairs {
            is_member[pair.a.index()] = true;
            is_member[pair.b.index()] = true;
        }
    }

    pub(crate) fn get_mut(&mut self, id: BodyId) -> Result<&mut Body, SceneError> {
        self.get(id)?;
        Ok(&mut self.bodies[id.index()])
    }

    fn next_id(&self) -> BodyId {
        // Each body has a vertex at least, and those are numbered in 32 bits.
        BodyId(u32::try_from(self.bodies.len()).unwrap_or(u32::MAX))
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::tetrahedron;
    use glam::DQuat;

    use super::*;

    /// Four tetrahedra in a row.
    fn four() -> Scene {
        let mut scene = Scene::new();
        for x in [0.0, 3.0, 6.0, 9.0] {
            let body = tetrahedron(1.0).translated(DVec3::X * x);
            let (surface, name) = (body.surface(), x.to_string());
            scene.add(name, BodyKind::Rigid, surface, body.positions).expect("a body");
        }
        scene
    }

    #[test]
    fn bodies_move_together_as_one_by_one() {
        let [mut together, mut alone] = [four(), four()];
        let ids: Vec<BodyId> = alone.ids().collect();
        let at = |k: f64| tetrahedron(1.0).translated(DVec3::Y * k).positions;
        let places = [at(1.0), at(2.0), at(3.0)];
        let to = |body, place: usize| BodyMove { body: ids[body], positions: &places[place] };
        for BodyMove { body, positions } in [to(3, 0), to(1, 2)] {
            alone.move_body(body, positions).expect("a move");
        }
        together.move_bodies(&[to(1, 1), to(3, 0), to(1, 2)]).expect("moves");
        assert_eq!(together.particle_positions(), alone.particle_positions());

        // By poses and positions in one call, too.
        let pose = Pose::new(DQuat::from_rotation_z(0.4), DVec3::X);
        alone.pose_body(ids[0], &pose).expect("a pose");
        alone.move_body(ids[2], &places[2]).expect("a move");
        let [by_pose, by_positions] = [BodyPlace::Pose(pose), BodyPlace::Positions(&places[2])];
        together.place_bodies(&[(ids[2], by_positions), (ids[0], by_pose)]).expect("places");
        assert_eq!(together.particle_positions(), alone.particle_positions());
        assert_eq!(together.body(ids[0]).pose(), Some(pose));

        // Without the body nothing moves; positions that are refused leave theirs where it was.
        let unknown = BodyMove { body: BodyId(4), ..to(0, 0) };
        let none = together.move_bodies(&[to(0, 0), unknown]).expect_err("no such body");
        assert_eq!(none, SceneError::NoSuchBody { index: 4, count: 4 });
        assert_eq!(together.particle_positions(), alone.particle_positions());
        let wrong = [DVec3::NAN; 4];
        let refused = together.move_bodies(&[BodyMove { body: ids[2], positions: &wrong }]);
        assert!(matches!(refused, Err(SceneError::Surface { .. })), "{refused:?}");
        assert_eq!(together.particle_positions(), alone.particle_positions());
    }
}
