//! Contacts of bodies that are given by their medial surfaces.

use distance_field::{FieldDetector, FieldDistance};
use medial::{MedialContact, MedialDetector, MedialError, MedialScratch, RigidDistance, RigidSide};
use surface::RigidState;

use crate::{Body, BodyId, Scene, SceneError};

/// Spacing of the field over the accepted excess of a gap between balls.
///
/// Above, more balls are evaluated; below, gaps between balls are less accurate than the field.
const SPACING_PER_TOLERANCE: f64 = 20.0;

impl Scene {
    /// Finds the contacts of a body's vertices with another body by its medial surface, with
    /// particles numbered by [`Body::particles`]. The detector, made for `owner`, follows it first.
    ///
    /// See [`MedialDetector::vertex_contacts`] for the contacts that are found.
    ///
    /// ```
    /// use medial::{MedialDetector, MedialFeature, MedialParams};
    /// use scene::glam::DVec3;
    /// use scene::{BodyKind, Progress, Scene};
    ///
    /// let muscle = fixtures::shapes::ellipsoid(DVec3::new(60.0, 20.0, 10.0), 4);
    /// let pin = fixtures::shapes::tetrahedron(3.0).translated(DVec3::new(7.0, 0.0, 11.0));
    /// let mut scene = Scene::new();
    /// let kind = BodyKind::Deformable;
    /// let muscle = scene.add("muscle", kind, muscle.surface(), muscle.positions)?;
    /// let pin = scene.add("pin", kind, pin.surface(), pin.positions)?;
    ///
    /// let (surface, x) = (scene.body(muscle).surface(), scene.body(muscle).checked_positions());
    /// let params = MedialParams::balls(60);
    /// let mut detector = MedialDetector::new(surface, x, 0.0, &params, Progress::none())?;
    /// let contacts = scene.medial_contacts(pin, muscle, &mut detector)?;
    /// assert!(contacts.len() == 2 && contacts[0].contact.normal.z > 0.9);
    /// assert!(matches!(contacts[0].feature, MedialFeature::Vertex(_)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] when a body is of another scene, and [`SceneError::Itself`] when
    ///   both are the same.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - [`SceneError::Medial`] when the detector cannot follow `owner`.
    pub fn medial_contacts(
        &mut self,
        body: BodyId,
        owner: BodyId,
        detector: &mut MedialDetector,
    ) -> Result<Vec<MedialContact>, SceneError> {
        let [body, owner] = self.fit_pair([body, owner])?;
        follow(detector, owner)?;
        let sides = body.contact_body().zip(owner.contact_body());
        let Some((body, owner)) = sides else { return Ok(Vec::new()) };
        Ok(detector.vertex_contacts(&body, &owner, &mut MedialScratch::default()))
    }

    /// Finds the contacts between two bodies by the medial surfaces of both. The detectors, made for
    /// `bodies`, follow them first.
    ///
    /// See [`MedialDetector::pair_contacts`] for the contacts that are found.
    ///
    /// # Errors
    ///
    /// As [`Self::medial_contacts`].
    pub fn medial_pair_contacts(
        &mut self,
        bodies: [BodyId; 2],
        detectors: [&mut MedialDetector; 2],
    ) -> Result<Vec<MedialContact>, SceneError> {
        let [a, b] = self.fit_pair(bodies)?;
        let [of_a, of_b] = detectors;
        follow(of_a, a)?;
        follow(of_b, b)?;
        let sides = a.contact_body().zip(b.contact_body());
        let Some((a, b)) = sides else { return Ok(Vec::new()) };
        Ok(of_a.pair_contacts(&a, of_b, &b, &mut MedialScratch::default()))
    }

    /// Finds the contacts of a body by its medial surface with the rigid body of a field. The
    /// detector, made for `owner`, follows it first; the margin is that of the field.
    ///
    /// See [`MedialDetector::rigid_contacts`] for the contacts that are found. The field has to hold
    /// distances at the centers of the balls, which are as deep in the body as it is thick: it needs
    /// that much padding, no truncation below it, and a band of exact distances as wide. Beyond its
    /// band, the distances of a field are up to half its spacing too large or too small near medial
    /// planes and edges, as measured, and so are these gaps.
    ///
    /// # Errors
    ///
    /// As [`Self::medial_contacts`], and [`SceneError::Medial`] with
    /// [`MedialError::DistanceRange`] where a ball may be in contact and the field does not hold the
    /// distance of its center.
    pub fn medial_field_contacts(
        &mut self,
        owner: BodyId,
        detector: &mut MedialDetector,
        field: &FieldDetector,
        state: &RigidState,
    ) -> Result<Vec<MedialContact>, SceneError> {
        self.get_mut(owner)?.fit()?;
        let owner = self.body(owner);
        follow(detector, owner)?;
        let side = field.bounds(&state.pose).zip(owner.contact_body());
        let Some((bounds, body)) = side else { return Ok(Vec::new()) };

        let tolerance = field.field().grid().spacing() / SPACING_PER_TOLERANCE;
        let side = RigidSide { state: *state, bounds, margin: field.margin(), tolerance };
        let distance = |p| match field.distance(&state.pose, p) {
            FieldDistance::Value { distance, normal } => RigidDistance::Value { distance, normal },
            FieldDistance::AtLeast(bound) => RigidDistance::AtLeast(bound),
        };
        let contacts =
            detector.rigid_contacts(&body, &side, distance, &mut MedialScratch::default());
        contacts.map_err(|error| medial_error(owner, error))
    }

    /// Brings the trees of two different bodies to their present state.
    fn fit_pair(&mut self, bodies: [BodyId; 2]) -> Result<[&Body; 2], SceneError> {
        for id in bodies {
            self.get_mut(id)?.fit()?;
        }
        let [a, b] = bodies.map(|id| self.body(id));
        if bodies[0] == bodies[1] {
            return Err(SceneError::Itself { name: a.name().to_owned() });
        }
        Ok([a, b])
    }
}

pub(crate) fn follow(detector: &mut MedialDetector, owner: &Body) -> Result<(), SceneError> {
    let followed = detector.follow(owner.checked_positions());
    followed.map_err(|error| medial_error(owner, error))
}

pub(crate) fn medial_error(body: &Body, source: MedialError) -> SceneError {
    SceneError::Medial { name: body.name().to_owned(), source }
}
