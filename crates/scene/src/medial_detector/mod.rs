//! A body by its medial surface against points, other medial surfaces, and bones.
//!
//! A muscle as a hundred balls, and the cones and slabs between them: how deep a
//! point is in it is a closed formula at a few slabs, and no ray has to tell first
//! whether it is inside. The balls follow the body as it deforms, by the surface
//! points that each of them touches.
//!
//! The balls are not particles of the scene, so their contacts are handed on to
//! the surface: where the ball that decides touches the body's surface along the
//! contact's normal, there the contact holds the body, by the vertices of the face.
//! So friction acts at the surface and not at the middle of the muscle. Where the
//! union of balls is wider than the surface there, the contact's offset is what
//! lies between; where it is narrower, the gap is that over the surface.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2: collisions
//! of medial surfaces; there, the medial surfaces are particles of their own, tied
//! to the surfaces by springs.

mod bone;
mod hold;
mod pairs;
mod points;

use glam::DVec3;
use kdop::Workspace;
use medial::{
    Deviation, FollowScratch, Links, MedialError, MedialParams, MedialSurface, PointContact,
    PrimitiveContact, PrimitiveTree, Progress, generate,
};
use surface::{Contact, Positions};

use self::hold::Hints;
use crate::Body;
use crate::{BodyId, FieldDetector, Scene, SceneError};
use surface::RigidState;

/// A body of a scene by its medial surface, ready to be asked for contacts.
///
/// It follows the body: each question first moves the balls with the body's
/// vertices and refits them, where the body has moved since the last one.
#[derive(Debug)]
pub struct MedialDetector {
    body: BodyId,
    margin: f64,
    most: usize,
    medial: MedialSurface,
    tree: PrimitiveTree,
    links: Links,
    hints: Hints,
    memory: FollowScratch,
    deviation: Deviation,
    /// Positions of the body that the balls are at.
    at: Vec<DVec3>,
}

/// A place where something touches a medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MedialContact {
    /// The contact, with particles numbered by [`Body::particles`](crate::Body::particles).
    pub contact: Contact,
    /// The ball of the detector's medial surface that decides.
    pub ball: PrimitiveBall,
    /// The part that touches it.
    pub feature: MedialFeature,
}

/// Part of a body that touches a medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum MedialFeature {
    /// A vertex of the other body, by its number there.
    Vertex(u32),
    /// A ball of the other body's medial surface.
    Ball(PrimitiveBall),
    /// A bone, by its field.
    Bone,
}

/// A ball between those of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrimitiveBall {
    /// Number of the primitive in its medial surface.
    pub primitive: u32,
    /// Weights of its balls, none negative, with sum one.
    pub weights: [f64; 3],
}

/// Memory that a thread reuses from pair to pair.
#[derive(Debug, Default)]
pub struct MedialScratch {
    workspace: Workspace,
    pairs: Vec<(u32, u32)>,
    points: Vec<PointContact>,
    primitives: Vec<PrimitiveContact>,
}

impl MedialDetector {
    /// Generates a medial surface of a body where it is now, its state at rest.
    ///
    /// A gap of at most `margin` is a contact: 0 reports what is inside by the
    /// balls; the bounds of the [deviation](Self::deviation), added to what is
    /// wanted, report also what may be.
    ///
    /// # Errors
    ///
    /// - [`SceneError::Margin`] when the margin is negative or not finite.
    /// - [`SceneError::NoSuchBody`] when `body` is of another scene.
    /// - [`SceneError::NoInside`] for a body that is declared open.
    /// - [`SceneError::Medial`] for what [`medial::generate`] refuses.
    pub fn new(
        scene: &Scene,
        body: BodyId,
        margin: f64,
        params: &MedialParams,
        progress: impl FnMut(Progress),
    ) -> Result<Self, SceneError> {
        let owner = closed_body(scene, body)?;
        let made = in_body(owner, |x| generate(owner.surface(), x, params, progress))?;
        Self::with(owner, body, margin, made.medial, made.deviation)
    }

    /// Takes a medial surface that was made of a body where it is now, and measures
    /// it.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], with [`SceneError::Medial`] for what
    /// [`Deviation::measure`] refuses.
    pub fn from_surface(
        scene: &Scene,
        body: BodyId,
        margin: f64,
        medial: MedialSurface,
    ) -> Result<Self, SceneError> {
        let owner = closed_body(scene, body)?;
        let deviation = in_body(owner, |x| Deviation::measure(&medial, owner.surface(), x))?;
        Self::with(owner, body, margin, medial, deviation)
    }

    fn with(
        owner: &Body,
        body: BodyId,
        margin: f64,
        medial: MedialSurface,
        deviation: Deviation,
    ) -> Result<Self, SceneError> {
        if !(margin.is_finite() && margin >= 0.0) {
            return Err(SceneError::Margin { margin });
        }
        let (tree, links) = in_body(owner, |x| {
            Ok((PrimitiveTree::new(&medial)?, Links::new(&medial, owner.surface(), x)?))
        })?;
        let hints = Hints::new(&medial, owner.surface(), &links);
        let at = owner.positions().to_vec();
        let memory = FollowScratch::default();
        Ok(Self { body, margin, most: 1, medial, tree, links, hints, memory, deviation, at })
    }

    /// Keeps up to `most` contacts of a vertex, `1..=`[`medial::MAX_CONTACTS`],
    /// whose normals are 30° apart or more; else, only the deepest.
    ///
    /// More than one help a vertex in the edge of a groove. But slabs overlap in
    /// the midst of a body, where no border is, and their rims count as well.
    #[must_use]
    pub fn with_max_contacts(self, most: usize) -> Self {
        Self { most: most.clamp(1, medial::MAX_CONTACTS), ..self }
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> BodyId {
        self.body
    }

    /// The medial surface, where the body was when it was last followed.
    #[must_use]
    pub fn medial(&self) -> &MedialSurface {
        &self.medial
    }

    /// Links between the balls and the body's vertices.
    #[must_use]
    pub fn links(&self) -> &Links {
        &self.links
    }

    /// Bounds on how far medial surface and body are from each other, in both
    /// directions: at rest, or when [last measured](Self::measure).
    #[must_use]
    pub fn deviation(&self) -> &Deviation {
        &self.deviation
    }

    /// Contacts of a body's vertices with the balls where these are. The trees of
    /// both bodies must be up to date.
    #[must_use]
    pub fn contacts(
        &self,
        scene: &Scene,
        body: BodyId,
        scratch: &mut MedialScratch,
    ) -> Vec<MedialContact> {
        points::contacts(scene.body(body), (self, scene.body(self.body)), scratch)
    }

    /// Bytes of its balls and of their ties to the body's vertices.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let balls = size_of_val(self.medial.balls()) + size_of_val(self.medial.primitives());
        balls + size_of_val(self.links.links()) + size_of_val(&self.at[..])
    }

    /// Moves the balls to where the body is now; linear in its vertices, and
    /// nothing to do where it has not moved.
    ///
    /// # Errors
    ///
    /// [`SceneError::NoSuchBody`] and [`SceneError::Medial`] when the scene is not
    /// the one the detector was made for.
    pub fn follow(&mut self, scene: &Scene) -> Result<(), SceneError> {
        let owner = scene.get(self.body)?;
        if owner.positions() == self.at {
            return Ok(());
        }
        let Self { medial, tree, links, memory, .. } = self;
        in_body(owner, |x| {
            if x.as_slice().len() != links.links().len() {
                let (expected, got) = (links.links().len(), x.as_slice().len());
                return Err(surface::SurfaceError::PositionCount { expected, got }.into());
            }
            links.follow_in(medial, x, memory)?;
            tree.refit(medial)
        })?;
        self.at.copy_from_slice(owner.positions());
        Ok(())
    }

    /// Follows the body and measures the deviation there. That takes far longer
    /// than following: it is a search over the whole surface.
    ///
    /// # Errors
    ///
    /// As [`Self::follow`].
    pub fn measure(&mut self, scene: &Scene) -> Result<&Deviation, SceneError> {
        self.follow(scene)?;
        let owner = scene.body(self.body);
        self.deviation = in_body(owner, |x| Deviation::measure(&self.medial, owner.surface(), x))?;
        Ok(&self.deviation)
    }
}

impl Scene {
    /// Contacts of a body's vertices with another one that is known by its balls,
    /// in ascending order of the vertices.
    ///
    /// The balls are taken as they are: no vertex that they have within the margin is
    /// missed. So outside of the body, none whose distance from it is less than the
    /// margin by the deviation's bound; with a margin of that bound, none that is
    /// inside, unless the union of balls has a void there.
    /// A ball that pokes through a face without reaching its corners is not seen;
    /// [`Self::medial_pair_contacts`] sees it.
    ///
    /// ```
    /// use scene::glam::DVec3;
    /// use scene::{BodyKind, MedialDetector, MedialFeature, Scene};
    ///
    /// let muscle = fixtures::shapes::ellipsoid(DVec3::new(60.0, 20.0, 10.0), 4);
    /// let pin = fixtures::shapes::tetrahedron(3.0).translated(DVec3::new(7.0, 0.0, 11.0));
    /// let mut scene = Scene::new();
    /// let kind = BodyKind::Deformable;
    /// let muscle = scene.add("muscle", kind, muscle.surface(), muscle.positions)?;
    /// let pin = scene.add("pin", kind, pin.surface(), pin.positions)?;
    ///
    /// let params = medial::MedialParams::balls(60);
    /// let mut detector = MedialDetector::new(&scene, muscle, 0.0, &params, |_| {})?;
    /// let contacts = scene.medial_contacts(pin, &mut detector)?;
    /// assert!(contacts.len() == 2 && contacts[0].contact.normal.z > 0.9);
    /// // The muscle shortens and thickens, and the balls with it.
    /// let short: Vec<DVec3> = scene.body(muscle).positions().iter()
    ///     .map(|p| *p * DVec3::new(0.8, 1.118, 1.118)).collect();
    /// scene.move_body(muscle, &short)?;
    /// let deeper = scene.medial_contacts(pin, &mut detector)?;
    /// assert!(deeper[0].contact.gap < contacts[0].contact.gap - 1.0);
    /// assert!(matches!(deeper[0].feature, MedialFeature::Vertex(_)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] when a body is of another scene, and
    ///   [`SceneError::Itself`] when both are the same.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - What [`MedialDetector::follow`] refuses.
    pub fn medial_contacts(
        &mut self,
        body: BodyId,
        detector: &mut MedialDetector,
    ) -> Result<Vec<MedialContact>, SceneError> {
        let mut found = self.medial_contacts_of(&[body], detector)?;
        Ok(found.pop().unwrap_or_default())
    }

    /// As [`Self::medial_contacts`] for several bodies, in their order, on the
    /// threads of the current pool.
    ///
    /// # Errors
    ///
    /// As [`Self::medial_contacts`].
    pub fn medial_contacts_of(
        &mut self,
        bodies: &[BodyId],
        detector: &mut MedialDetector,
    ) -> Result<Vec<Vec<MedialContact>>, SceneError> {
        for &body in bodies {
            self.check_pair(body, detector.body)?;
        }
        self.fit_all()?;
        detector.follow(self)?;
        let (scene, detector) = (&*self, &*detector);
        Ok(surface::parallel::map_slice_with(bodies, MedialScratch::default, |scratch, &body| {
            detector.contacts(scene, body, scratch)
        }))
    }

    /// Contacts between two bodies that are both known by their balls: pairs of
    /// primitives whose unions come within the margin of each other, each at the vertex
    /// of the first body that is nearest to where they do, the deepest of those at
    /// one vertex; in ascending order of these vertices. The margin is the first
    /// detector's.
    ///
    /// The depth is the exact one of the balls, wherever they meet: nothing is lost
    /// between vertices.
    ///
    /// # Errors
    ///
    /// As [`Self::medial_contacts`].
    pub fn medial_pair_contacts(
        &mut self,
        a: &mut MedialDetector,
        b: &mut MedialDetector,
    ) -> Result<Vec<MedialContact>, SceneError> {
        self.check_pair(a.body, b.body)?;
        self.fit_all()?;
        a.follow(self)?;
        b.follow(self)?;
        let [of_a, of_b] = [a.body, b.body].map(|body| self.body(body));
        Ok(pairs::contacts((a, of_a), (b, of_b), &mut MedialScratch::default()))
    }

    /// Contacts of a body that is known by its balls with a bone that is known by
    /// its field: balls within the margin, ascending, then cones and slabs that come
    /// within the margin between balls that don't, ascending, at their lowest place. The
    /// margin is the field detector's.
    ///
    /// The field has to tell distances at the balls' centers, which lie as deep in
    /// the body as it is thick: it needs that much padding, no truncation below it,
    /// and a band of exact distances as wide. Beyond its band, a field's distances
    /// are up to a fifth of its spacing too large, and so are these gaps.
    ///
    /// # Errors
    ///
    /// - [`SceneError::FieldRange`] where a ball may touch the bone, but its center
    ///   is where the field tells no distance.
    /// - As [`Self::medial_contacts`].
    pub fn medial_field_contacts(
        &mut self,
        detector: &mut MedialDetector,
        field: &FieldDetector,
        state: &RigidState,
    ) -> Result<Vec<MedialContact>, SceneError> {
        self.get(detector.body)?;
        self.fit_all()?;
        detector.follow(self)?;
        let body = self.body(detector.body);
        bone::contacts((detector, body), field, state, &mut MedialScratch::default())
    }

    fn check_pair(&self, a: BodyId, b: BodyId) -> Result<(), SceneError> {
        let name = self.get(a)?.name();
        self.get(b)?;
        if a == b { Err(SceneError::Itself { name: name.to_owned() }) } else { Ok(()) }
    }
}

fn closed_body(scene: &Scene, body: BodyId) -> Result<&Body, SceneError> {
    let owner = scene.get(body)?;
    let named = |source| SceneError::NoInside { name: owner.name().to_owned(), source };
    match owner.has_inside() {
        Err(source @ crate::NoInside::DeclaredOpen) => Err(named(source)),
        // Of the rest, `medial` tells more.
        _ => Ok(owner),
    }
}

/// Does something with a body's positions; names the body where that fails.
fn in_body<T>(
    body: &Body,
    f: impl FnOnce(Positions<'_>) -> Result<T, MedialError>,
) -> Result<T, SceneError> {
    let result = body.surface().positions(body.positions()).map_err(MedialError::from).and_then(f);
    result.map_err(|source| SceneError::Medial { name: body.name().to_owned(), source })
}
