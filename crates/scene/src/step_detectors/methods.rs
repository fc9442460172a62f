//! Detection of one pair by each method.

use decimate::CoarseSurface;
use distance_field::{FieldContact, FieldFeature};
use glam::DVec3;
use kdop::Workspace;
use proximity::{ContactSurface, NearVertex, SurfaceTree, contact};
use surface::{Contact, RigidState};

use super::{DetectorScratch, FallbackReason, FoundContacts, StepDetectors};
use crate::closest_pairs::{ActingGaps, SurfaceState, may_touch};
use crate::medial_contacts::{follow, medial_error};
use crate::{Body, BodyId, PairId, Scene, SceneError, StepError};

/// Gap up to which all vertices were detected, or the reason against the method.
type Detected = Result<f64, FallbackReason>;

/// Surface of a body as it is compared.
#[derive(Clone, Copy)]
pub(super) struct ComparedSurface<'a> {
    pub(super) tree: &'a SurfaceTree,
    pub(super) contact: ContactSurface<'a>,
}

impl StepDetectors {
    /// Detects the vertices and ridges of both bodies by surfaces; returns the gap up to which all
    /// are found.
    pub(super) fn detect_surfaces(
        &mut self,
        scene: &Scene,
        pair: PairId,
        is_coarse: [bool; 2],
        reach: f64,
    ) -> Result<f64, StepError> {
        let [a, b] = pair.bodies();
        let sides = [(a, is_coarse[0]), (b, is_coarse[1])].map(|(id, is_coarse)| {
            let coarse = self.bodies.get(id.index()).and_then(|own| own.coarse.as_ref());
            ComparedSurface::new(scene.body(id), coarse.filter(|_| is_coarse))
        });
        let [Some(a), Some(b)] = sides else { return Ok(reach) };

        // Vertices of each against the other, and ridges that cross without a vertex inside.
        let gaps = self.params.gaps();
        let DetectorScratch { surfaces, ridges, found, .. } = &mut self.scratch;
        let computed = surfaces.compute(a.tree, b.tree, reach);
        computed.map_err(|error| SceneError::of_pair(scene.names(pair), error))?;
        for (near, [of, on]) in surfaces.sides().into_iter().zip([[a, b], [b, a]]) {
            found.add_vertices(&of, &on, near.near(), gaps);
        }
        found.ridges = ridges.add_contacts(surfaces, [a, b], reach, &mut found.contacts);
        found.is_unheld = surfaces.overlaps() && !found.touches(gaps);
        Ok(reach)
    }

    /// Detects a pair by coarse surfaces of one body or both.
    pub(super) fn detect_coarse(
        &mut self,
        scene: &Scene,
        pair: PairId,
        reach: f64,
    ) -> Result<Detected, StepError> {
        // Both surfaces may be off in one place, so that the second has what the first leaves.
        let (mut is_coarse, mut allowed) = ([false; 2], self.params.tolerance);
        for (id, is_coarse) in pair.bodies().into_iter().zip(&mut is_coarse) {
            let body = scene.body(id);
            let Some(coarse) = &mut self.structures(id).coarse else { continue };
            *is_coarse = true;
            if let Err(source) = coarse.follow(body.positions()) {
                return Err(StepError::Coarse { name: body.name().to_owned(), source });
            }

            // The coarse surface leaves the full one where the body deforms.
            let bound = coarse.deviation();
            if bound > allowed {
                let reason = FallbackReason::CoarseDeviation { body: id, bound, allowed };
                return Ok(Err(reason));
            }
            allowed -= bound;
        }
        if is_coarse == [false; 2] {
            return Ok(Err(FallbackReason::NoStructure));
        }
        let found = self.detect_surfaces(scene, pair, is_coarse, reach)?;
        Ok(Ok(found - self.params.tolerance))
    }

    /// Detects a pair by the field of one body.
    pub(super) fn detect_field(
        &mut self,
        scene: &Scene,
        pair: PairId,
        reach: f64,
    ) -> Result<Detected, StepError> {
        // The first rigid body that has one.
        let [a, b] = pair.bodies();
        let has_field = |id: &BodyId| scene.body(*id).is_rigid() && self.field(*id).is_some();
        let Some(bone) = [a, b].into_iter().find(has_field) else {
            return Ok(Err(FallbackReason::NoStructure));
        };
        let Some(pose) = scene.body(bone).pose() else { return Ok(Err(FallbackReason::NoPose)) };
        let other = if bone == a { b } else { a };
        let sides = [bone, other].map(|id| ComparedSurface::new(scene.body(id), None));
        let [Some(bone_side), Some(side)] = sides else { return Ok(Ok(reach)) };

        // Vertices and edges by the field, and the bone's own vertices, which it does not see.
        let structures = &self.bodies[bone.index()];
        let Some(detector) = structures.field.as_ref() else {
            return Ok(Err(FallbackReason::NoStructure));
        };
        let gaps = self.params.gaps();
        let DetectorScratch { surfaces, field, closest, found, .. } = &mut self.scratch;
        field.compute(detector, &RigidState::at_rest(pose), side.tree, side.contact.particles);
        let mut bone_query = ClosestFaces { of: &bone_side, hint: None, workspace: closest };
        for of_field in field.contacts() {
            let acts = match of_field.feature {
                FieldFeature::Vertex(vertex) => {
                    let particle = side.contact.particles.particle(vertex);
                    found.has_touched(particle, of_field.contact.gap, gaps)
                }
                FieldFeature::Edge(_) => false,
            };
            let acts = acts || field_may_touch(&side, &mut bone_query, of_field, gaps);
            found.push(of_field.contact, acts);
        }
        let computed = surfaces.compute_first(bone_side.tree, side.tree, reach);
        computed.map_err(|error| SceneError::of_pair(scene.names(pair), error))?;
        found.add_vertices(&bone_side, &side, surfaces.sides()[0].near(), gaps);
        found.is_unheld = surfaces.overlaps() && !found.touches(gaps);
        Ok(Ok(reach.min(detector.margin())))
    }

    /// Detects the vertices of bodies by the balls of the other.
    pub(super) fn detect_balls(
        &mut self,
        scene: &Scene,
        pair: PairId,
        reach: f64,
    ) -> Result<Detected, StepError> {
        if self.crossing.contains(&pair) {
            return Ok(Err(FallbackReason::CrossingEdges));
        }

        // Where both have balls that can be trusted, before anything is added.
        let tolerance = self.params.tolerance;
        let (mut has_balls, mut held) = (false, reach);
        for id in pair.bodies() {
            let body = scene.body(id);
            let own = self.bodies.get_mut(id.index());
            let Some(balls) = own.and_then(|own| own.balls.as_mut()) else { continue };
            has_balls = true;
            follow(balls, body)?;
            let (allowed, scratch) = (balls.margin() + tolerance, &mut self.scratch.medial);
            let bound = balls.surface_bound(body.surface(), allowed, scratch);
            let bound = bound.map_err(|error| medial_error(body, error))?;
            if bound > allowed {
                return Ok(Err(FallbackReason::BallDeviation { body: id, bound, allowed }));
            }
            held = held.min(balls.margin() - bound);
        }
        if !has_balls {
            return Ok(Err(FallbackReason::NoStructure));
        }

        // Balls are trusted: they select, surfaces measure.
        let ([a, b], gaps) = (pair.bodies(), self.params.gaps());
        for [of, on] in [[a, b], [b, a]] {
            let own = self.bodies.get(on.index());
            let Some(balls) = own.and_then(|own| own.balls.as_ref()) else { continue };
            let bodies = [of, on].map(|id| scene.body(id).contact_body());
            let sides = [of, on].map(|id| ComparedSurface::new(scene.body(id), None));
            let ([Some(body), Some(own)], [Some(of), Some(on)]) = (bodies, sides) else { continue };
            let DetectorScratch { medial, near, found, .. } = &mut self.scratch;
            near.clear();
            balls.near_vertices(&body, &own, reach, medial, near);
            found.add_vertices(&of, &on, near, gaps);
        }

        // Balls do not compare edges, which may cross without a vertex inside, also beside one that touches.
        let sides = [a, b].map(|id| ComparedSurface::new(scene.body(id), None));
        if let [Some(a), Some(b)] = sides {
            let DetectorScratch { surfaces, ridges, found, .. } = &mut self.scratch;
            let computed = surfaces.compute(a.tree, b.tree, 0.0);
            computed.map_err(|error| SceneError::of_pair(scene.names(pair), error))?;
            if surfaces.overlaps()
                && (!found.touches(gaps)
                    || ridges.add_contacts(surfaces, [a, b], 0.0, &mut found.contacts) > 0)
            {
                found.clear();
                return Ok(Err(FallbackReason::CrossingEdges));
            }
        }
        Ok(Ok(held))
    }
}

impl<'a> ComparedSurface<'a> {
    /// Returns a body by its coarse surface, where one is given, or by its own; `None` where the
    /// body's tree is not up to date.
    fn new(body: &'a Body, coarse: Option<&'a CoarseSurface>) -> Option<Self> {
        let whole = body.contact_surface();
        match coarse {
            None => body.tree().map(|tree| Self { tree, contact: whole }),
            Some(coarse) => {
                Some(Self { tree: coarse.tree(), contact: coarse.contact_surface(whole) })
            }
        }
    }
}

impl ComparedSurface<'_> {
    pub(super) fn state(&self) -> SurfaceState<'_> {
        SurfaceState::of_tree(self.tree, self.contact.is_rigid)
    }
}

impl FoundContacts {
    /// Returns true if a vertex touches now, or did before in the same step.
    fn has_touched(&mut self, particle: u32, gap: f64, gaps: ActingGaps) -> bool {
        let Some(pair) = self.pair else { return false };
        if gap <= gaps.touch {
            self.touched.add(pair, particle);
            return true;
        }
        self.touched.contains(pair, particle)
    }

    /// Adds a contact, which acts at once or only where bodies have moved.
    fn push(&mut self, contact: Contact, acts: bool) {
        if acts { self.contacts.push(contact) } else { self.ghosts.push(contact) }
    }

    /// Adds the contacts of near vertices.
    fn add_vertices(
        &mut self,
        of: &ComparedSurface<'_>,
        on: &ComparedSurface<'_>,
        near: &[NearVertex],
        gaps: ActingGaps,
    ) {
        let [of_state, on_state] = [of, on].map(ComparedSurface::state);
        for near in near {
            let particle = of.contact.particles.particle(near.vertex);
            let acts = self.has_touched(particle, near.gap, gaps)
                || may_touch(of_state, on_state, near, gaps);
            self.push(contact(&of.contact, &on.contact, near), acts);
        }
    }

    /// Returns true if a contact touches: its faces may cross those of the other body by rounding.
    fn touches(&self, gaps: ActingGaps) -> bool {
        self.contacts.iter().any(|contact| contact.gap <= gaps.touch)
    }
}

/// Closest faces of a surface to points that are near each other: each search begins with the face
/// of the last.
struct ClosestFaces<'a> {
    of: &'a ComparedSurface<'a>,
    hint: Option<u32>,
    workspace: &'a mut Workspace,
}

impl ClosestFaces<'_> {
    /// Returns true if the point of the surface closest to `p` is on a ridge.
    fn is_ridge(&mut self, p: DVec3, normal: DVec3) -> bool {
        let Self { of, hint, workspace } = self;
        let Some(closest) = of.tree.closest_point(p, f64::INFINITY, *hint, workspace) else {
            return false;
        };
        *hint = Some(closest.face);
        of.state().is_ridge_at(closest.face, closest.foot.barycentric, normal)
    }
}

/// Returns true if a contact with a field is inside, or can touch the bone next.
///
/// A field has no faces: those of the bone that are closest are searched for.
fn field_may_touch(
    side: &ComparedSurface<'_>,
    bone: &mut ClosestFaces<'_>,
    FieldContact { contact, feature, .. }: &FieldContact,
    gaps: ActingGaps,
) -> bool {
    let (gap, normal) = (contact.gap, contact.normal);
    let foot = contact.anchor.map_or(DVec3::ZERO, |anchor| anchor.point);
    let p = foot + gap * normal;
    let state = side.state();
    let point = match feature {
        FieldFeature::Vertex(vertex) => state.vertex(*vertex),
        FieldFeature::Edge(edge) => state.point_of_edge(*edge, p),
    };
    gap <= gaps.touch || point.may_touch(normal, || bone.is_ridge(p, normal))
}
