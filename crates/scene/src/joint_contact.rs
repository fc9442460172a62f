//! Joint contact of pairs of bodies of a scene.

use overlap::{JointContact, JointContactError, JointContactParams, Overlap, OverlapDetector};
use proximity::SurfaceTree;
use surface::progress::Progress;

use crate::{PairId, Scene, SceneError};

impl Scene {
    /// Measures the contact of some pairs: of the first body's surface with the second's, and of the
    /// second's with the first's. Each has area, center, gaps and pressure, of the whole, of each
    /// region and of each face.
    ///
    /// ```
    /// use overlap::{ElasticFoundation, FoundationLaw, JointContactParams};
    /// use scene::{BodyKind, PairId, Progress, Scene, glam::DVec3};
    ///
    /// // A condyle of 20 mm, pressed 0.5 mm into a plateau with 5 mm of cartilage between them.
    /// let condyle = fixtures::shapes::icosphere(20.0, 4).translated(DVec3::new(0.0, 0.0, 19.5));
    /// let plateau = fixtures::shapes::cube(60.0).translated(DVec3::new(0.0, 0.0, -30.0));
    /// let mut scene = Scene::new();
    /// let femur = scene.add("femur", BodyKind::Rigid, condyle.surface(), condyle.positions)?;
    /// let tibia = scene.add("tibia", BodyKind::Rigid, plateau.surface(), plateau.positions)?;
    ///
    /// let (youngs_modulus, poissons_ratio, thickness) = (5.0, 0.46, 5.0);
    /// let law = FoundationLaw::Linear;
    /// let layer = ElasticFoundation { youngs_modulus, poissons_ratio, thickness, law };
    /// let params = JointContactParams { margin: 0.0, resolution: 0.2, foundation: Some(layer) };
    /// let pairs = [PairId::new(femur, tibia)];
    /// let contacts = scene.joint_contacts(&pairs, &params, Progress::none())?;
    /// let [of_femur, _] = &contacts[0];
    /// assert!((of_femur.total.area - 62.8).abs() < 3.0);
    /// assert!((of_femur.total.force.z / 67.5 - 1.0).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::JointContact`] when a parameter is out of range, or the resolution too fine.
    /// - [`SceneError::NearFaces`] when more than 2²⁶ pairs of faces of two bodies are within the margin
    ///   of each other.
    /// - [`SceneError::NoSuchBody`] when a body is of another scene.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - [`SceneError::Interrupted`] when `progress` ends the call.
    pub fn joint_contacts(
        &mut self,
        pairs: &[PairId],
        params: &JointContactParams,
        progress: Progress<'_>,
    ) -> Result<Vec<[JointContact; 2]>, SceneError> {
        params.validate()?;
        for id in pairs.iter().copied().flat_map(PairId::bodies) {
            self.get_mut(id)?.fit()?;
        }
        self.map_pairs(pairs, OverlapDetector::default, progress, |detector, pair, progress| {
            let Some(bodies) = self.outward_trees(pair) else { return Ok(None) };
            match contact(bodies, params, detector, progress) {
                Ok(found) => Ok(Some(found)),
                Err(JointContactError::NearFaces(error)) => {
                    Err(SceneError::of_pair(self.names(pair), error))
                }
                Err(error) => Err(error.into()),
            }
        })
    }
}

fn contact(
    bodies: [&SurfaceTree; 2],
    params: &JointContactParams,
    detector: &mut OverlapDetector,
    progress: Progress<'_>,
) -> Result<[JointContact; 2], JointContactError> {
    // The overlap says which faces lie deeper than the margin.
    detector.try_measure_into(bodies, &mut Overlap::default(), progress)?;
    detector.joint_contact(bodies, params, progress)
}
