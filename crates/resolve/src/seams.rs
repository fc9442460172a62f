//! Seams: vertices of soft bodies that are tied at one place, and move as one particle.
//!
//! A bond between two such vertices would let the contacts of one be undone by the other, in each round a little.

use std::collections::BTreeMap;

use glam::DVec3;
use scene::{BodyId, Scene};
use surface::{Contact, Stencil, Term, UnionFind, triangle};

use crate::conditions::TieBond;
use crate::count::as_f64;
use crate::damage::rounded_to_single;
use crate::elastic::{MAX_TERMS, Terms};
use crate::seam_faces::SeamFaces;
use crate::tissue::Tissue;

/// Rounding of a weight that is the difference of two others \[their sum\].
const WEIGHT_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Cosine of the angle between the normals of two faces at a seam, above which they do not face each other. Near -1,
/// faces that are bent apart by rounding are missed; near 0, those beside the seam are taken for faces at it.
const MAX_FACING: f64 = -0.9;

/// Marks particles of no seam.
const NO_POINT: u32 = u32::MAX;

/// Points of seams, each with the particles that are there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seams {
    /// Particles of each point, ascending: two or more.
    points: Vec<Vec<u32>>,
    /// Point of each particle; empty where there is none.
    point_of: Vec<u32>,
}

impl Seams {
    /// Joins the vertices of soft bodies that are tied at one place, to the bit.
    pub(crate) fn new(scene: &Scene, bonds: &[TieBond]) -> Self {
        let particle = |id: BodyId, vertex: u32| scene.body(id).particles().start + vertex;
        let count = scene.bodies().last().map_or(0, |body| body.particles().end);
        let mut joined = Vec::new();
        for bond in bonds {
            if let Some(corner) = bond.corner_at_follower(scene) {
                joined.push([particle(bond.follower, bond.vertex), particle(bond.leader, corner)]);
            }
        }
        Self::default().with_joined(&joined, count)
    }

    /// Returns these points with more pairs of particles joined, of `count` in all.
    pub(crate) fn with_joined(&self, pairs: &[[u32; 2]], count: u32) -> Self {
        if pairs.is_empty() {
            return self.clone();
        }
        let mut sets = UnionFind::new(count as usize);
        let known = self.points.iter().flat_map(|point| point.windows(2));
        for pair in known.chain(pairs.iter().map(|pair| &pair[..])) {
            sets.join(pair[0], pair[1]);
        }

        // By the first particle of each point.
        let mut points: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut particles = self.points.concat();
        particles.extend(pairs.as_flattened());
        particles.sort_unstable();
        particles.dedup();
        for particle in particles {
            points.entry(sets.find(particle)).or_default().push(particle);
        }
        Self::of_points(points.into_values().collect(), count)
    }

    /// Joins the particles of each point, of `count` in all.
    pub(crate) fn of_points(points: Vec<Vec<u32>>, count: u32) -> Self {
        let mut point_of = vec![NO_POINT; count as usize];
        for (number, point) in (0..).zip(&points) {
            for &particle in point {
                point_of[particle as usize] = number;
            }
        }
        Self { points, point_of }
    }

    /// Returns true if there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Returns the particles of each point.
    pub(crate) fn points(&self) -> &[Vec<u32>] {
        &self.points
    }

    /// Returns all particles at the place of one.
    pub(crate) fn together_with(&self, particle: u32) -> Vec<u32> {
        self.point_of(particle).map_or(vec![particle], |point| self.points[point].clone())
    }

    /// Returns the number of the point that a particle is at.
    pub(crate) fn point_of(&self, particle: u32) -> Option<usize> {
        let point = *self.point_of.get(particle as usize)?;
        (point != NO_POINT).then_some(point as usize)
    }

    /// Finds the faces at seams, as the scene is. The trees of all bodies are up to date.
    pub(crate) fn faces(&self, scene: &Scene) -> SeamFaces {
        if self.is_empty() {
            return SeamFaces::default();
        }
        let mut behind = vec![Vec::new(); scene.bodies().len()];
        for (id, own) in scene.ids().zip(&mut behind) {
            let body = scene.body(id);
            let first = body.particles().start;
            for (number, face) in (0..).zip(body.surface().faces()) {
                let points = face.map(|corner| self.point_of(first + corner));
                let [Some(p), Some(q), Some(r)] = points else { continue };
                if let Some(other) = self.body_behind(scene, id, number, [p, q, r]) {
                    own.resize(body.surface().faces().len(), None);
                    own[number as usize] = Some(other);
                }
            }
        }
        SeamFaces { behind }
    }

    /// Returns the body that has a face against a face of another, by the points of the seam at its corners.
    fn body_behind(
        &self,
        scene: &Scene,
        body: BodyId,
        face: u32,
        points: [usize; 3],
    ) -> Option<BodyId> {
        let vertices = |point: usize| self.points()[point].iter().map(|p| place(scene, *p));
        let normal = triangle::unit_normal(scene.body(body).corners(face));
        let is_inside_out = scene.body(body).is_inside_out();
        for (number, vertex) in vertices(points[0]) {
            let other = &scene.bodies()[number];
            let has = |point: usize| vertices(point).any(|(body, _)| body == number);
            if number == body.index() || !has(points[1]) || !has(points[2]) {
                continue;
            }

            // Diagonals of quadrilaterals may differ: any face against this one, with all corners at the seam.
            let first = other.particles().start;
            for &face in other.surface().vertex_faces(vertex) {
                let corners = other.surface().faces()[face as usize];
                let is_at_seam = corners.iter().all(|v| self.point_of(first + v).is_some());
                let facing = normal.dot(triangle::unit_normal(other.corners(face)));
                let facing = if is_inside_out == other.is_inside_out() { facing } else { -facing };
                if is_at_seam && facing < MAX_FACING {
                    return scene.ids().nth(number);
                }
            }
        }
        None
    }

    /// Fixes all vertices at a point of which one is fixed.
    pub(crate) fn fix(&self, scene: &Scene, tissues: &mut [Tissue]) {
        for point in &self.points {
            let places: Vec<(usize, u32)> = point.iter().map(|p| place(scene, *p)).collect();
            let is_fixed = |&(body, vertex): &(usize, u32)| !tissues[body].is_free(vertex);
            if places.iter().any(is_fixed) {
                for (body, vertex) in places {
                    tissues[body].fix(vertex);
                }
            }
        }
    }

    /// Computes the positions of bodies that are not rounded, by their numbers, with the vertices rounded that share a
    /// point with one of a body that is. Bodies in which that changes nothing are left out.
    pub(crate) fn rounded(&self, scene: &Scene, tissues: &[Tissue]) -> Vec<(usize, Vec<DVec3>)> {
        let mut rounded: BTreeMap<usize, Vec<DVec3>> = BTreeMap::new();
        for point in &self.points {
            let places = || point.iter().map(|particle| place(scene, *particle));
            if !places().any(|(body, _)| tissues[body].is_written_single) {
                continue;
            }
            for (body, vertex) in places().filter(|(body, _)| !tissues[*body].is_written_single) {
                let x = scene.bodies()[body].positions();
                let to = rounded_to_single(&x[vertex as usize..=vertex as usize])[0];
                if to != x[vertex as usize] {
                    rounded.entry(body).or_insert_with(|| x.to_vec())[vertex as usize] = to;
                }
            }
        }
        rounded.into_iter().collect()
    }

    /// Sets the inverse mass of each particle to that of all at its point.
    pub(crate) fn add_masses(&self, inverse_masses: &mut [f64]) {
        for point in &self.points {
            let mass: f64 = point.iter().map(|p| inverse_masses[*p as usize].recip()).sum();
            for &particle in point {
                inverse_masses[particle as usize] = mass.recip();
            }
        }
    }

    /// Moves the particles of each point to their mean, where they differ.
    pub(crate) fn join(&self, x: &mut [DVec3]) {
        for point in &self.points {
            if let Some(mean) = mean_of_different(point.iter().map(|p| x[*p as usize])) {
                for &particle in point {
                    x[particle as usize] = mean;
                }
            }
        }
    }

    /// Moves the ends of a step at each point to their mean, where they differ; bodies without an end rest.
    pub(crate) fn join_ends(&self, scene: &Scene, ends: &mut [Option<Vec<DVec3>>]) {
        for point in &self.points {
            let places = || point.iter().map(|particle| place(scene, *particle));
            let end = |(body, vertex): (usize, u32)| {
                let x = ends[body].as_deref().unwrap_or(scene.bodies()[body].positions());
                x[vertex as usize]
            };
            if let Some(mean) = mean_of_different(places().map(end)) {
                for (body, vertex) in places() {
                    let at_rest = || scene.bodies()[body].positions().to_vec();
                    ends[body].get_or_insert_with(at_rest)[vertex as usize] = mean;
                }
            }
        }
    }

    /// Moves the particles of each point to the first one.
    pub(crate) fn lead(&self, x: &mut [DVec3]) {
        for point in &self.points {
            for &particle in &point[1..] {
                x[particle as usize] = x[point[0] as usize];
            }
        }
    }

    /// Gives all particles of a point the step of the one of them that moves.
    pub(crate) fn follow(&self, steps: &mut [DVec3]) {
        for point in &self.points {
            let moving = point.iter().find(|p| steps[**p as usize] != DVec3::ZERO);
            if let Some(&moving) = moving {
                for &particle in point {
                    steps[particle as usize] = steps[moving as usize];
                }
            }
        }
    }

    /// Lowers the shares of a step that particles of one point take to the least of them, and marks the bodies of
    /// those that are lowered. Returns true if there are any.
    pub(crate) fn lower(&self, scene: &Scene, shares: &mut [f64], lowered: &mut [bool]) -> bool {
        let mut is_any = false;
        for point in &self.points {
            let least = point.iter().map(|p| shares[*p as usize]).fold(f64::INFINITY, f64::min);
            for &particle in point {
                if shares[particle as usize] > least {
                    shares[particle as usize] = least;
                    lowered[place(scene, particle).0] = true;
                    is_any = true;
                }
            }
        }
        is_any
    }

    /// Returns true if both sides of a contact have a particle at one point: they are joined there, as faces of one
    /// body at a common corner.
    pub(crate) fn joins(&self, contact: &Contact, first_of_b: u32) -> bool {
        let terms = contact.stencil.terms();
        let is_common = |p: &Term, q: &Term| {
            let point = self.point_of(p.particle);
            point.is_some() && point == self.point_of(q.particle)
        };
        let (a, b): (Vec<&Term>, Vec<&Term>) =
            terms.iter().partition(|term| term.particle < first_of_b);
        a.iter().any(|p| b.iter().any(|q| is_common(p, q)))
    }

    /// Returns contacts by the first particle of each point; those that no step opens or closes are left out.
    pub(crate) fn contacts(&self, contacts: Vec<Contact>) -> Vec<Contact> {
        if self.is_empty() {
            return contacts;
        }
        let first = |particle| self.point_of(particle).map(|point| self.points[point][0]);
        let mut merged = Vec::with_capacity(contacts.len());
        for contact in contacts {
            let terms = contact.stencil.terms().iter().map(|term| (term.particle, term.weight));
            let terms = merged_terms(terms, |particle| first(particle).unwrap_or(particle));
            let terms: Vec<Term> =
                terms.into_iter().map(|(particle, weight)| Term { particle, weight }).collect();
            merged.extend(Stencil::new(&terms).map(|stencil| Contact { stencil, ..contact }));
        }
        merged
    }
}

impl TieBond {
    /// Returns the corner of the leader that is where the follower is, to the bit.
    pub(crate) fn corner_at_follower(&self, scene: &Scene) -> Option<u32> {
        let [follower, leader] = [self.follower, self.leader].map(|id| scene.body(id));
        if follower.is_rigid() || leader.is_rigid() {
            return None;
        }
        let x = follower.positions()[self.vertex as usize];
        self.corners.into_iter().find(|corner| leader.positions()[*corner as usize] == x)
    }
}

/// Returns the number of the body of a particle, and its vertex.
pub(crate) fn place(scene: &Scene, particle: u32) -> (usize, u32) {
    let bodies = scene.bodies();
    let number = bodies.partition_point(|body| body.particles().end <= particle);
    (number, particle - bodies[number].particles().start)
}

/// Adds up the weights of particles that are one by `merged`. Weights that cancel are left out.
pub(crate) fn merged_terms(
    terms: impl Iterator<Item = (u32, f64)>,
    merged: impl Fn(u32) -> u32,
) -> Terms {
    let mut sums = Terms::new();
    let mut sizes = [0.0; MAX_TERMS];
    for (particle, weight) in terms {
        let particle = merged(particle);
        let known = sums.iter().position(|(other, _)| *other == particle);
        let place = known.unwrap_or(sums.len());
        match known {
            Some(known) => sums[known].1 += weight,
            None => sums.push((particle, weight)),
        }
        sizes[place] += weight.abs();
    }
    let mut size = sizes.iter();
    sums.retain(|(_, weight)| {
        size.next().is_some_and(|size| weight.abs() > WEIGHT_ROUNDING * size || *size == 0.0)
    });
    sums
}

/// Returns the mean of vectors; `None` where they are the same.
fn mean_of_different(vectors: impl Iterator<Item = DVec3> + Clone) -> Option<DVec3> {
    let mut all = vectors.clone();
    let first = all.next()?;
    if all.all(|other| other == first) {
        return None;
    }
    Some(vectors.clone().sum::<DVec3>() / as_f64(vectors.count()))
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::BodyKind;

    use super::*;

    use crate::run::Run;
    use crate::{Conditions, ResolveParams, Tie};

    /// Builds two soft cubes of 2 side by side, that share the corners between them, and a bone.
    fn two_cubes(bone: fixtures::Mesh) -> (Scene, Conditions) {
        let mut scene = Scene::new();
        let mut ids = Vec::new();
        for x in [-1.0, 1.0] {
            let cube = shapes::cube(2.0).translated(DVec3::X * x);
            let name = if x < 0.0 { "left" } else { "right" };
            let id = scene.add(name, BodyKind::Deformable, cube.surface(), cube.positions);
            ids.push(id.expect("a body"));
        }
        scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions).expect("a body");
        let ties = vec![Tie { bodies: [ids[0], ids[1]], distance: f64::MIN_POSITIVE }];
        (scene, Conditions { ties, ..Conditions::default() })
    }

    /// Checks that each point is one place of vertices that have moved by the step of the body in part.
    fn assert_one_place(run: &Run<'_>) {
        let x = run.scene.particle_positions();
        let points = run.ties.seams.points();
        assert_eq!(points.len(), 4, "the corners of a face");
        for point in points {
            let places: Vec<DVec3> = point.iter().map(|particle| x[*particle as usize]).collect();
            assert!(places.len() == 2 && places[0] == places[1], "{places:?}");
        }
    }

    #[test]
    fn what_holds_one_body_at_a_seam_holds_the_other_there() {
        // A small bone below one cube, which comes down on it.
        let bone = shapes::cube(0.5).translated(DVec3::new(-0.9, 0.1, -2.0));
        let (mut scene, conditions) = two_cubes(bone);
        let params = ResolveParams { gap: 0.1, ..ResolveParams::with_smoothing(6.0) };
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        let mut displacements = vec![DVec3::ZERO; run.inverse_masses.len()];
        displacements[..16].fill(DVec3::new(0.0, 0.0, -1.5));
        run.move_freely(&displacements, &[]).expect("a step");
        assert_one_place(&run);
        let lowest = run.scene.bodies()[1].positions().iter().map(|x| x.z).fold(9.0, f64::min);
        assert!(lowest < -2.4, "what is free goes on: {lowest}");
    }

    #[test]
    fn pushes_of_one_body_move_the_seam_in_both() {
        for x in [-0.9, 0.9] {
            let bone = shapes::cube(0.5).translated(DVec3::new(x, 0.1, -1.1));
            let (mut scene, conditions) = two_cubes(bone);
            let params = ResolveParams { gap: 0.1, ..ResolveParams::with_smoothing(6.0) };
            let run = Run::start(&mut scene, params, &conditions);
            let mut run = run.expect("a run");
            run.push().expect("a push");
            run.move_soft(Tissue::pushed).expect("positions");
            assert_one_place(&run);
            let moved = run.displacements()[0..16].iter().any(|u| u.length() > 0.1);
            assert!(moved, "the bone pushes");
        }
    }

    #[test]
    fn bodies_that_are_moved_by_themselves_meet_halfway() {
        let bone = shapes::cube(0.5).translated(9.0 * DVec3::Z);
        let (mut scene, conditions) = two_cubes(bone);
        let params = ResolveParams { gap: 0.1, ..ResolveParams::with_smoothing(6.0) };
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        let up = |x: &DVec3| *x + 0.5 * DVec3::Z;
        let is_left = |tissue: &Tissue| tissue.id.index() == 0;
        run.move_soft(|tissue, x| is_left(tissue).then(|| x.iter().map(up).collect()))
            .expect("positions");
        assert_one_place(&run);
        for point in run.ties.seams.points() {
            let u = run.displacements()[point[0] as usize];
            assert!((u - 0.25 * DVec3::Z).length() < 1e-12, "{u}");
        }
    }

    #[test]
    fn what_is_rounded_in_one_body_at_a_seam_is_in_the_other() {
        let bone = shapes::cube(0.5).translated(9.0 * DVec3::Z);
        let (mut scene, mut conditions) = two_cubes(bone);
        conditions.unrounded = scene.find("right").into_iter().collect();
        let precision = crate::WrittenPrecision::Single;
        let params = ResolveParams { gap: 0.1, precision, ..ResolveParams::with_smoothing(6.0) };
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        let aside = |x: &DVec3| *x + DVec3::splat(0.1);
        run.move_soft(|_, x| Some(x.iter().map(aside).collect())).expect("positions");
        let before = run.scene.bodies()[1].positions().to_vec();
        run.round_positions().expect("positions");
        assert_one_place(&run);
        let after = run.scene.bodies()[1].positions();
        let stay = before.iter().zip(after).filter(|(before, after)| before == after).count();
        assert_eq!(stay, 4, "all but the seam");
    }

    #[test]
    fn a_seam_that_is_tied_to_bone_follows_it() {
        // The bone is below the left cube, and tied to it at a distance.
        let bone = shapes::cube(2.0).translated(DVec3::new(-1.0, 0.0, -2.1));
        let (mut scene, mut conditions) = two_cubes(bone);
        let [left, bone] = ["left", "bone"].map(|name| scene.find(name).expect("a body"));
        conditions.ties.push(Tie { bodies: [left, bone], distance: 0.2 });
        let params = ResolveParams::with_smoothing(6.0);
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        for tissue in &mut run.tissues[..2] {
            tissue.u.fill(DVec3::X);
        }
        run.follow_ties();
        let count_at_rest =
            |tissue: &Tissue| tissue.u.iter().filter(|u| **u == DVec3::ZERO).count();
        assert_eq!(count_at_rest(&run.tissues[0]), 4, "the lower side");
        assert_eq!(count_at_rest(&run.tissues[1]), 2, "the lower end of the seam");
    }

    #[test]
    fn weights_of_one_particle_add_up_and_those_that_cancel_are_left_out() {
        let terms = [(3, -0.5), (4, -0.5), (7, 0.1), (9, 0.6), (8, 0.3)];
        let one_of_each = |particle| if particle >= 7 { particle - 4 } else { particle };
        let merged = merged_terms(terms.into_iter(), one_of_each);
        assert_eq!(merged.as_slice(), [(3, -0.4), (4, -0.2), (5, 0.6)]);
        let terms = [(3, -0.1), (3, -0.2), (7, 0.3)];
        assert!(merged_terms(terms.into_iter(), one_of_each).is_empty());
    }
}
