//! Joint contact of two bodies of a scene.

use overlap::{JointContact, JointContactParams, OverlapDetector};

use crate::{PairId, Scene, SceneError};

impl Scene {
    /// Measures the contact of the first body's surface with the second's, and of the second's with
    /// the first's: area, center, gaps and pressure, of each region and each face.
    ///
    /// ```
    /// use overlap::{ElasticFoundation, FoundationLaw, JointContactParams};
    /// use scene::{BodyKind, PairId, Scene, glam::DVec3};
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
    /// let [of_femur, _] = scene.joint_contact(PairId::new(femur, tibia), &params)?;
    /// assert!((of_femur.total.area - 62.8).abs() < 3.0);
    /// assert!((of_femur.total.force.z / 67.5 - 1.0).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::JointContact`] when a parameter is out of range.
    /// - [`SceneError::NoSuchBody`] when a body is of another scene.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    pub fn joint_contact(
        &mut self,
        pair: PairId,
        params: &JointContactParams,
    ) -> Result<[JointContact; 2], SceneError> {
        params.validate()?;
        for id in pair.bodies() {
            self.get_mut(id)?.fit()?;
        }
        let trees = (self.body(pair.a).tree(), self.body(pair.b).tree());
        let (Some(a), Some(b)) = trees else { return Ok(<[JointContact; 2]>::default()) };

        // The overlap says which faces lie deeper than the margin.
        let mut detector = OverlapDetector::default();
        detector.measure(a, b);
        Ok(detector.joint_contact([a, b], params)?)
    }
}
