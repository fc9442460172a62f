//! Detectors of a contact step: a method per pair, structures per body, and fallbacks.
//!
//! Whatever the method, contacts are measured at surfaces or fields, not at what a method reduces
//! a body to: balls select the vertices near a body, and its surface measures them. Where a
//! structure that follows a deforming body deviates too much from it, its pairs are detected
//! exactly in that frame, and reported as such.

mod methods;
mod params;
mod ridges;
mod touched;

use std::collections::{BTreeMap, BTreeSet};

use decimate::CoarseSurface;
use distance_field::{FieldContacts, FieldDetector};
use kdop::Workspace;
use medial::{MedialDetector, MedialScratch};
use proximity::{NearVertex, PairProximity};
use response::{Follower, Followers, ResponseError};
use surface::Contact;

pub use self::params::{DetectorParams, Fallback, FallbackReason, StepMethod};
use self::ridges::RidgeScratch;
use self::touched::TouchedVertices;
use crate::broad_phase::SweepAndPrune;
use crate::closest_pairs::ActingGaps;
use crate::kept_contacts::{DetectedList, KeptList};
use crate::step_sides::KeptSide;
use crate::{BodyId, KeptPair, PairContacts, PairId, PermanentParams, Renewal, Scene, StepError};

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
    permanent: BTreeMap<PairId, PermanentParams>,
    kept: BTreeMap<PairId, KeptList>,
    bodies: Vec<BodyStructures>,
    fallbacks: Vec<Fallback>,
    unheld: Vec<PairId>,
    /// Pairs of which ridges are in contact, and whose method does not compare them.
    crossing: BTreeSet<PairId>,
    /// Step that the fallbacks and unheld overlaps are of.
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
    sweep: SweepAndPrune,
    /// Per body, true if it is in one of the pairs to detect.
    is_member: Vec<bool>,
    surfaces: PairProximity,
    ridges: RidgeScratch,
    field: FieldContacts,
    /// Search for the closest face.
    closest: Workspace,
    medial: MedialScratch,
    near: Vec<NearVertex>,
    found: FoundContacts,
    kept: Vec<Contact>,
    sides: Vec<KeptSide>,
}

/// Contacts of one pair.
#[derive(Debug, Default)]
struct FoundContacts {
    /// Contacts that act.
    contacts: Vec<Contact>,
    /// Contacts of points outside that cannot touch the other body next, but may do so once the
    /// bodies have moved.
    ghosts: Vec<Contact>,
    /// Pair that is detected.
    pair: Option<PairId>,
    touched: TouchedVertices,
    /// Number of contacts of ridges.
    ridges: usize,
    /// True if the bodies overlap, and no contact touches.
    is_unheld: bool,
}

impl FoundContacts {
    fn clear(&mut self) {
        self.contacts.clear();
        self.ghosts.clear();
        (self.ridges, self.is_unheld) = (0, false);
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
            permanent: BTreeMap::new(),
            kept: BTreeMap::new(),
            bodies: Vec::new(),
            fallbacks: Vec::new(),
            unheld: Vec::new(),
            crossing: BTreeSet::new(),
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
        self.kept.remove(&pair);
        self.methods.insert(pair, method);
    }

    /// Keeps the contacts of a pair from step to step: they are carried, and detected again only on
    /// doubt ([`Renewal`]). Contacts still open and push as the [`Material`](response::Material)
    /// says. A pair with contacts of ridges is not kept, unless its material is permanent.
    /// [`Self::clear_permanent`] ends it.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] for a skin or a distance out of range.
    pub fn set_permanent(
        &mut self,
        pair: PairId,
        params: PermanentParams,
    ) -> Result<(), ResponseError> {
        response::not_negative("skin", params.skin)?;
        response::not_negative("distance of attachment", params.attach_within)?;
        self.kept.remove(&pair);
        self.permanent.insert(pair, params);
        Ok(())
    }

    /// Ends the keeping of a pair's contacts: they are detected anew in each step, as those of other pairs.
    pub fn clear_permanent(&mut self, pair: PairId) {
        self.kept.remove(&pair);
        self.permanent.remove(&pair);
    }

    /// Returns the pairs whose contacts are kept, in the order of the bodies.
    pub fn kept(&self) -> impl Iterator<Item = &KeptPair> {
        self.lists_that_hold().map(|list| &list.report)
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

    /// Returns the pairs that overlapped in some detection of the last step without a contact that
    /// touches: edges cross that no vertex and no pair of ridges holds. Refine the bodies there.
    #[must_use]
    pub fn unheld_overlaps(&self) -> &[PairId] {
        &self.unheld
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
            for (particle, leaders) in coarse.followers(scene.body(id).particles()) {
                followers.push(Follower { particle, leaders });
            }
        }
        Followers::new(followers)
    }

    /// Detects the contacts of all pairs with a soft body that come within the margin, each by its
    /// method, and adds them.
    ///
    /// # Errors
    ///
    /// - [`StepError::Scene`] where a body is too large for a tree, or a structure is of another
    ///   body.
    /// - [`StepError::NotKept`] for a pair whose material is permanent and whose contacts are not
    ///   kept.
    pub fn detect(
        &mut self,
        scene: &mut Scene,
        contacts: &mut PairContacts<'_>,
    ) -> Result<(), StepError> {
        if self.step_number != contacts.step_number() {
            self.step_number = contacts.step_number();
            self.fallbacks.clear();
            self.unheld.clear();
            self.scratch.found.touched.clear();
        }
        self.scratch.found.touched.begin_detection();

        // Kept contacts first: their pairs need no trees.
        self.carry_kept(scene, contacts)?;

        // Then the other pairs, of which some are kept from now on.
        self.find_pairs(scene)?;
        for number in 0..self.scratch.sweep.pairs.len() {
            let pair = self.scratch.sweep.pairs[number];
            let reach = self.reach(pair);
            self.scratch.found.clear();
            self.scratch.found.pair = Some(pair);
            let held = self.detect_pair(scene, pair, reach)?;
            let found = &mut self.scratch.found;
            if found.is_unheld && !self.unheld.contains(&pair) {
                self.unheld.push(pair);
            }

            // Ridges slide along each other, which no list follows: they are found anew.
            let pulls = contacts.material(pair).permanent.is_some();
            let params = self.permanent.get(&pair).filter(|_| pulls || found.ridges == 0);
            let Some(params) = params else {
                if pulls {
                    return Err(not_kept(scene, pair));
                }
                contacts.add(pair, &found.contacts);
                continue;
            };

            // A list holds what may touch later, and the sides that vertices came in by.
            found.contacts.append(&mut found.ghosts);
            contacts.correct_sides(scene, pair, &mut found.contacts);
            let margins = contacts.material(pair).margins;
            let attach_gap = margins.clearance() + params.attach_within;
            let detected =
                DetectedList { contacts: &found.contacts, reach: held, attach_gap, margins };
            let list =
                self.kept.entry(pair).or_insert_with(|| KeptList::new(pair, params, margins));
            list.renew(scene, contacts.step_number(), detected, contacts.x)?;
            add_list(scene, list, self.params.gaps(), contacts, &mut self.scratch);
        }
        Ok(())
    }

    /// Carries kept contacts and adds them. Lists in doubt no longer hold.
    fn carry_kept(
        &mut self,
        scene: &Scene,
        contacts: &mut PairContacts<'_>,
    ) -> Result<(), StepError> {
        let (gaps, tolerance) = (self.params.gaps(), self.params.tolerance);
        for list in self.kept.values_mut() {
            // One that was not detected again since is that of bodies far from each other.
            if list.doubt.is_some() || scene.is_ignored(list.report.pair) {
                list.doubt = Some(Renewal::First);
                continue;
            }
            list.doubt = list.carry(scene, contacts.x, tolerance)?;
            if list.doubt.is_none() {
                add_list(scene, list, gaps, contacts, &mut self.scratch);
            }
        }
        Ok(())
    }

    /// Returns the lists that need not be detected again.
    fn lists_that_hold(&self) -> impl Iterator<Item = &KeptList> {
        self.kept.values().filter(|list| list.doubt.is_none())
    }

    /// Finds the pairs with a soft body that come near and are not kept, with their trees.
    fn find_pairs(&mut self, scene: &mut Scene) -> Result<(), StepError> {
        // Where all are kept, no body needs a box.
        let is_all_kept = self.lists_that_hold().count() == count_of_soft_pairs(scene);
        let Self { params, permanent, kept, scratch, .. } = self;
        let DetectorScratch { sweep, is_member, .. } = scratch;
        if is_all_kept {
            sweep.pairs.clear();
            return Ok(());
        }

        let mut largest: f64 = 0.0;
        for params in permanent.values() {
            largest = largest.max(params.skin);
        }
        scene.compute_boxes(&mut sweep.boxes);
        sweep.find_pairs(params.margin + largest);
        sweep.pairs.retain(|pair| {
            let is_soft = pair.bodies().iter().any(|id| !scene.body(*id).is_rigid());
            let is_kept = kept.get(pair).is_some_and(|list| list.doubt.is_none());
            is_soft && !is_kept && !scene.is_ignored(*pair)
        });

        // The bounds of a tree are tighter than boxes.
        scene.mark_members(&sweep.pairs, is_member);
        scene.fit(is_member)?;
        sweep.pairs.retain(|pair| {
            let skin = permanent.get(pair).map_or(0.0, |params| params.skin);
            scene.roots_are_close(*pair, params.margin + skin)
        });
        Ok(())
    }

    /// Returns the gap up to which a pair is detected.
    fn reach(&self, pair: PairId) -> f64 {
        self.params.margin + self.permanent.get(&pair).map_or(0.0, |params| params.skin)
    }

    /// Detects one pair by its method up to the gap `reach`, or exactly where there is a reason
    /// against that. Returns the gap up to which all vertices were detected.
    fn detect_pair(&mut self, scene: &Scene, pair: PairId, reach: f64) -> Result<f64, StepError> {
        let method = *self.methods.get(&pair).unwrap_or(&self.default);
        let found = match method {
            StepMethod::Exact => Ok(self.detect_surfaces(scene, pair, [false; 2], reach)?),
            StepMethod::Coarse => self.detect_coarse(scene, pair, reach)?,
            StepMethod::Field => self.detect_field(scene, pair, reach)?,
            StepMethod::Balls => self.detect_balls(scene, pair, reach)?,
        };

        // Reported once, exact instead.
        let reason = match found {
            Ok(held) => return Ok(held),
            Err(reason) => reason,
        };
        if !self.fallbacks.iter().any(|fallback| fallback.pair == pair) {
            self.fallbacks.push(Fallback { pair, method, reason });
        }
        let held = self.detect_surfaces(scene, pair, [false; 2], reach)?;

        // Ridges that have come apart by rounding stay in contact.
        if reason == FallbackReason::CrossingEdges {
            if self.scratch.found.ridges > 0 {
                self.crossing.insert(pair);
            } else {
                self.crossing.remove(&pair);
            }
        }
        Ok(held)
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

/// Returns the refusal of a pair that pulls on contacts that nobody has chosen.
fn not_kept(scene: &Scene, pair: PairId) -> StepError {
    let [a, b] = pair.bodies().map(|id| scene.body(id).name().to_owned());
    StepError::NotKept { a, b }
}

/// Adds the contacts of a list that act, with their sides.
fn add_list(
    scene: &Scene,
    list: &KeptList,
    gaps: ActingGaps,
    contacts: &mut PairContacts<'_>,
    DetectorScratch { kept, sides, .. }: &mut DetectorScratch,
) {
    kept.clear();
    sides.clear();
    let pair = list.report.pair;
    let pulls = contacts.material(pair).permanent.is_some();
    let add_side = |particle, face| sides.push(KeptSide { particle, face });
    list.extend(scene, (!pulls).then_some(gaps), kept, add_side);
    contacts.add_kept(pair, kept, sides);
}

/// Returns the number of pairs with a soft body.
fn count_of_soft_pairs(scene: &Scene) -> usize {
    let (mut count, mut bodies, mut bones) = (0, 0, 0);
    for body in scene.bodies() {
        // Bones make no pairs with each other.
        count += if body.is_rigid() { bodies - bones } else { bodies };
        bodies += 1;
        bones += usize::from(body.is_rigid());
    }
    count
}
