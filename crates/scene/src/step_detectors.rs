//! Detectors of a contact step: a method per pair, structures per body, and fallbacks.
//!
//! Whatever the method, contacts are measured at surfaces or fields, not at what a method reduces
//! a body to: balls select the vertices near a body, and its surface measures them. Where a
//! structure that follows a deforming body deviates too much from it, its pairs are detected
//! exactly in that frame, and reported as such.

use std::collections::BTreeMap;

use decimate::CoarseSurface;
use distance_field::{FieldContacts, FieldDetector};
use glam::DVec3;
use medial::{MedialDetector, MedialScratch};
use proximity::{ContactSurface, PairProximity, ParticleNumbers, SurfaceTree, contact};
use response::{Follower, Followers, ResponseError};
use surface::{Contact, RigidState, Term};

use crate::medial_contacts::{follow, medial_error};
use crate::{Body, BodyId, PairContacts, PairId, Scene, StepError};

/// Method by which a contact step detects a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum StepMethod {
    /// Vertices of both bodies against the surface of the other.
    #[default]
    Exact,
    /// The same with the coarse surface of a body in place of its own. Vertices that it left out
    /// follow those that it kept: see [`StepDetectors::followers`].
    Coarse,
    /// Vertices and edges of a body against the distance field of the other, which is rigid, and
    /// the vertices of the rigid one against the surface.
    Field,
    /// Vertices of both bodies against the balls of the other, measured at its surface.
    Balls,
}

/// Parameters of the detectors of a contact step, in the length unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DetectorParams {
    /// Gap up to which contacts are detected, finite and `>= 0`.
    pub margin: f64,
    /// Depth of an overlap that may go undetected, finite and `>= 0`.
    pub tolerance: f64,
}

/// Pair that was not detected by its method.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fallback {
    /// The pair, detected by [`StepMethod::Exact`].
    pub pair: PairId,
    /// Its method.
    pub method: StepMethod,
    /// Reason against it in this frame.
    pub reason: FallbackReason,
}

/// Reason why a pair is detected exactly instead of by its method.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum FallbackReason {
    /// Neither body has the structure that the method takes.
    NoStructure,
    /// The vertices of a rigid body with a field were moved one by one: it has no pose.
    NoPose,
    /// The surface of a body may extend beyond its balls by more than their margin and the
    /// tolerance allow: overlaps could go undetected.
    BallDeviation {
        /// The body.
        body: BodyId,
        /// Proved bound on the distance of the surface outside the balls.
        bound: f64,
        /// Distance up to which the balls are trusted.
        allowed: f64,
    },
    /// A vertex of a body is farther from its coarse surface than the tolerance.
    CoarseDeviation {
        /// The body.
        body: BodyId,
        /// Measured at the vertices: largest distance from the point that each follows.
        measured: f64,
        /// Distance up to which the coarse surface is trusted.
        allowed: f64,
    },
}

/// Detectors of a contact step: a method per pair, and the structures of bodies that the methods
/// take.
///
/// ```
/// use medial::{MedialDetector, MedialParams};
/// use scene::glam::DVec3;
/// use scene::response::{Margins, Material, ParticleLoads, StepLength, StepParams};
/// use scene::{
///     BodyKind, DetectorParams, PairId, Progress, Scene, SceneStates, SceneStep, StepDetectors,
///     StepMethod,
/// };
///
/// let bone = fixtures::shapes::ellipsoid(DVec3::new(40.0, 40.0, 8.0), 3);
/// let tissue = fixtures::shapes::icosphere(10.0, 2).translated(DVec3::Z * 17.9);
/// let mut scene = Scene::new();
/// let bone = scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions)?;
/// let kind = BodyKind::Deformable;
/// let tissue = scene.add("tissue", kind, tissue.surface(), tissue.positions)?;
///
/// // Balls of the bone, found up to 0.5 beyond the margin of 0.5.
/// let (surface, x) = (scene.body(bone).surface(), scene.body(bone).checked_positions());
/// let balls = MedialDetector::new(surface, x, 1.0, &MedialParams::balls(60), Progress::none())?;
/// let mut detectors = StepDetectors::new(DetectorParams { margin: 0.5, tolerance: 0.2 })?;
/// detectors.set_balls(bone, balls);
/// detectors.set_method(PairId::new(bone, tissue), StepMethod::Balls);
///
/// let mut step = SceneStep::new(Material::hard(Margins::new(0.0, 0.5)?));
/// let mut x = scene.particle_positions();
/// let (mut v, inverse_mass) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
/// let loads = ParticleLoads::None;
/// let states = SceneStates { x: &mut x, v: &mut v, loads, inverse_mass: &inverse_mass };
/// let params = StepParams::new(StepLength::new(0.001)?);
/// let report = step.correct(&mut scene, states, &params, |scene, contacts| {
///     detectors.detect(scene, contacts)
/// })?;
/// assert!(detectors.fallbacks().is_empty());
/// assert!(report.depth_before > 0.09 && report.depth < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct StepDetectors {
    params: DetectorParams,
    default: StepMethod,
    methods: BTreeMap<PairId, StepMethod>,
    bodies: Vec<BodyStructures>,
    fallbacks: Vec<Fallback>,
    /// Step that the fallbacks are of.
    step_number: u64,
    scratch: DetectorScratch,
}

/// Structures of one body.
#[derive(Debug, Default)]
struct BodyStructures {
    field: Option<FieldDetector>,
    coarse: Option<CoarseSurface>,
    balls: Option<MedialDetector>,
}

/// Memory that is reused from pair to pair.
#[derive(Debug, Default)]
struct DetectorScratch {
    surfaces: PairProximity,
    field: FieldContacts,
    medial: MedialScratch,
    found: Vec<Contact>,
}

/// Surface of a body as it is compared.
#[derive(Clone, Copy)]
struct ComparedSurface<'a> {
    tree: &'a SurfaceTree,
    contact: ContactSurface<'a>,
}

impl DetectorParams {
    /// Checks that both lengths are in their ranges.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] with the first that is not.
    pub fn validate(&self) -> Result<(), ResponseError> {
        response::not_negative("margin", self.margin)?;
        response::not_negative("tolerance", self.tolerance)?;
        Ok(())
    }
}

impl StepDetectors {
    /// Returns detectors that take [`StepMethod::Exact`] for all pairs.
    ///
    /// # Errors
    ///
    /// Those of [`DetectorParams::validate`].
    pub fn new(params: DetectorParams) -> Result<Self, ResponseError> {
        params.validate()?;
        Ok(Self {
            params,
            default: StepMethod::default(),
            methods: BTreeMap::new(),
            bodies: Vec::new(),
            fallbacks: Vec::new(),
            step_number: 0,
            scratch: DetectorScratch::default(),
        })
    }

    /// Sets the method of all pairs that have none of their own.
    pub fn set_default_method(&mut self, method: StepMethod) {
        self.default = method;
    }

    /// Sets the method of one pair.
    pub fn set_method(&mut self, pair: PairId, method: StepMethod) {
        self.methods.insert(pair, method);
    }

    /// Sets the distance field of a rigid body, in the frame that the body was added in. Its
    /// margin is that of the detector.
    pub fn set_field(&mut self, body: BodyId, field: FieldDetector) {
        self.structures(body).field = Some(field);
    }

    /// Sets the coarse surface of a body.
    pub fn set_coarse(&mut self, body: BodyId, coarse: CoarseSurface) {
        self.structures(body).coarse = Some(coarse);
    }

    /// Sets the balls of a body. Their margin has to exceed that of the contacts by how far the
    /// surface extends beyond them, also once it has deformed: where it does not, by more than the
    /// tolerance, pairs fall back to [`StepMethod::Exact`].
    pub fn set_balls(&mut self, body: BodyId, balls: MedialDetector) {
        self.structures(body).balls = Some(balls);
    }

    /// Returns the pairs that some detection of the last step did not detect by their methods, each
    /// with its first reason.
    #[must_use]
    pub fn fallbacks(&self) -> &[Fallback] {
        &self.fallbacks
    }

    /// Returns the particles that follow those of coarse surfaces, for
    /// [`SceneStep::set_followers`](crate::SceneStep::set_followers).
    ///
    /// # Errors
    ///
    /// Those of [`Followers::new`].
    pub fn followers(&self, scene: &Scene) -> Result<Followers, ResponseError> {
        let mut followers = Vec::new();
        for (id, structures) in scene.ids().zip(&self.bodies) {
            let Some(coarse) = &structures.coarse else { continue };
            let particles = scene.body(id).particles();
            for (vertex, particle) in (0..).zip(particles.clone()) {
                if coarse.reduced().kept.binary_search(&vertex).is_err() {
                    let leaders = coarse.leaders(vertex).map(|(leader, weight)| Term {
                        particle: particles.start + leader,
                        weight,
                    });
                    followers.push(Follower { particle, leaders });
                }
            }
        }
        Followers::new(followers)
    }

    /// Detects the contacts of all pairs with a soft body that come within the margin, each by its
    /// method, and adds them.
    ///
    /// # Errors
    ///
    /// [`StepError::Scene`] where a body is too large for a tree, or a structure is of another
    /// body.
    pub fn detect(
        &mut self,
        scene: &mut Scene,
        contacts: &mut PairContacts<'_>,
    ) -> Result<(), StepError> {
        if self.step_number != contacts.step_number() {
            self.step_number = contacts.step_number();
            self.fallbacks.clear();
        }
        for pair in scene.close_pairs(self.params.margin)? {
            if pair.bodies().iter().all(|&body| scene.body(body).is_rigid()) {
                continue;
            }
            self.scratch.found.clear();
            self.detect_pair(scene, pair)?;
            contacts.add(pair, &self.scratch.found);
        }
        Ok(())
    }

    /// Detects one pair by its method, or exactly where there is a reason against that.
    fn detect_pair(&mut self, scene: &Scene, pair: PairId) -> Result<(), StepError> {
        let method = *self.methods.get(&pair).unwrap_or(&self.default);
        let against = match method {
            StepMethod::Exact => {
                self.detect_surfaces(scene, pair, [false; 2]);
                None
            }
            StepMethod::Coarse => self.detect_coarse(scene, pair)?,
            StepMethod::Field => self.detect_field(scene, pair),
            StepMethod::Balls => self.detect_balls(scene, pair)?,
        };
        if let Some(reason) = against {
            if !self.fallbacks.iter().any(|fallback| fallback.pair == pair) {
                self.fallbacks.push(Fallback { pair, method, reason });
            }
            self.detect_surfaces(scene, pair, [false; 2]);
        }
        Ok(())
    }

    /// Detects the vertices of both bodies by surfaces.
    fn detect_surfaces(&mut self, scene: &Scene, pair: PairId, is_coarse: [bool; 2]) {
        let [a, b] = pair.bodies();
        let sides = [(a, is_coarse[0]), (b, is_coarse[1])].map(|(id, is_coarse)| {
            let coarse = self.bodies.get(id.index()).and_then(|own| own.coarse.as_ref());
            ComparedSurface::new(scene.body(id), coarse.filter(|_| is_coarse))
        });
        let [Some(a), Some(b)] = sides else { return };
        let DetectorScratch { surfaces, found, .. } = &mut self.scratch;
        surfaces.compute(a.tree, b.tree, self.params.margin);
        for (near, [of, on]) in surfaces.sides().into_iter().zip([[a, b], [b, a]]) {
            for near in near.near() {
                found.push(contact(&of.contact, &on.contact, near));
            }
        }
    }

    /// Detects a pair by coarse surfaces of one body or both; returns a reason against that.
    fn detect_coarse(
        &mut self,
        scene: &Scene,
        pair: PairId,
    ) -> Result<Option<FallbackReason>, StepError> {
        let mut is_coarse = [false; 2];
        for (id, is_coarse) in pair.bodies().into_iter().zip(&mut is_coarse) {
            let (body, allowed) = (scene.body(id), self.params.tolerance);
            let Some(coarse) = &mut self.structures(id).coarse else { continue };
            *is_coarse = true;
            if let Err(source) = coarse.follow(body.positions()) {
                return Err(StepError::Coarse { name: body.name().to_owned(), source });
            }

            // Vertices leave the points that they follow where the body deforms.
            let measured = largest_distance(coarse, body.positions());
            if measured > allowed {
                let reason = FallbackReason::CoarseDeviation { body: id, measured, allowed };
                return Ok(Some(reason));
            }
        }
        if is_coarse == [false; 2] {
            return Ok(Some(FallbackReason::NoStructure));
        }
        self.detect_surfaces(scene, pair, is_coarse);
        Ok(None)
    }

    /// Detects a pair by the field of one body; returns a reason against that.
    fn detect_field(&mut self, scene: &Scene, pair: PairId) -> Option<FallbackReason> {
        let [a, b] = pair.bodies();
        let has_field = |id: &BodyId| scene.body(*id).is_rigid() && self.field(*id).is_some();
        let Some(bone) = [a, b].into_iter().find(has_field) else {
            return Some(FallbackReason::NoStructure);
        };
        let Some(pose) = scene.body(bone).pose() else { return Some(FallbackReason::NoPose) };
        let other = if bone == a { b } else { a };
        let sides = [bone, other].map(|id| ComparedSurface::new(scene.body(id), None));
        let [Some(bone_side), Some(side)] = sides else { return None };

        // Vertices and edges by the field, and the bone's own vertices, which it does not see.
        let detector = self.bodies[bone.index()].field.as_ref()?;
        let DetectorScratch { surfaces, field, found, .. } = &mut self.scratch;
        field.compute(detector, &RigidState::at_rest(pose), side.tree, side.contact.particles);
        for of_field in field.contacts() {
            found.push(of_field.contact);
        }
        surfaces.compute_first(bone_side.tree, side.tree, self.params.margin);
        for near in surfaces.sides()[0].near() {
            found.push(contact(&bone_side.contact, &side.contact, near));
        }
        None
    }

    /// Detects the vertices of bodies by the balls of the other; returns a reason against that.
    fn detect_balls(
        &mut self,
        scene: &Scene,
        pair: PairId,
    ) -> Result<Option<FallbackReason>, StepError> {
        // Where both have balls that can be trusted, before anything is added.
        let tolerance = self.params.tolerance;
        let mut has_balls = false;
        for id in pair.bodies() {
            let body = scene.body(id);
            let Some(balls) = &mut self.structures(id).balls else { continue };
            has_balls = true;
            follow(balls, body)?;
            let allowed = balls.margin() + tolerance;
            let bound = balls.surface_bound(body.surface(), allowed);
            let bound = bound.map_err(|error| medial_error(body, error))?;
            if bound > allowed {
                return Ok(Some(FallbackReason::BallDeviation { body: id, bound, allowed }));
            }
        }
        if !has_balls {
            return Ok(Some(FallbackReason::NoStructure));
        }

        let [a, b] = pair.bodies();
        for [of, on] in [[a, b], [b, a]] {
            let Some(balls) = &self.bodies[on.index()].balls else { continue };
            let sides = [of, on].map(|id| scene.body(id).contact_body());
            let [Some(of), Some(on)] = sides else { continue };
            let DetectorScratch { medial, found, .. } = &mut self.scratch;
            balls.surface_contacts(&of, &on, self.params.margin, medial, found);
        }
        Ok(None)
    }

    /// Returns the structures of a body, to be set or moved.
    fn structures(&mut self, body: BodyId) -> &mut BodyStructures {
        if self.bodies.len() <= body.index() {
            self.bodies.resize_with(body.index() + 1, BodyStructures::default);
        }
        &mut self.bodies[body.index()]
    }

    fn field(&self, body: BodyId) -> Option<&FieldDetector> {
        self.bodies.get(body.index())?.field.as_ref()
    }
}

impl<'a> ComparedSurface<'a> {
    /// Returns a body by its coarse surface, where one is given, or by its own; `None` where the
    /// body's tree is not up to date.
    fn new(body: &'a Body, coarse: Option<&'a CoarseSurface>) -> Option<Self> {
        let whole = body.contact_surface();
        let Some(coarse) = coarse else {
            return body.tree().map(|tree| Self { tree, contact: whole });
        };

        // Contacts of a coarse surface are of the vertices that it has kept.
        let tree = coarse.tree();
        let particles = ParticleNumbers { kept: Some(&coarse.reduced().kept), ..whole.particles };
        let (surface, positions) = (tree.surface(), tree.positions());
        let contact = ContactSurface { surface, positions, particles, is_rigid: whole.is_rigid };
        Some(Self { tree, contact })
    }
}

/// Measures how far vertices are from the points of a coarse surface that they follow.
fn largest_distance(coarse: &CoarseSurface, x: &[DVec3]) -> f64 {
    let mut largest: f64 = 0.0;
    for (vertex, p) in (0..).zip(x) {
        let mut led = DVec3::ZERO;
        for (leader, weight) in coarse.leaders(vertex) {
            led += weight * x[leader as usize];
        }
        largest = largest.max(led.distance_squared(*p));
    }
    largest.sqrt()
}
