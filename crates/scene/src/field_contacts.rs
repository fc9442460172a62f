//! Contacts of a body with a rigid body that is given by its distance field.

use distance_field::{FieldContact, FieldContacts, FieldDetector};
use surface::RigidState;

use crate::{BodyId, Scene, SceneError};

impl Scene {
    /// Finds the contacts of a body with the rigid body of a detector, with particles numbered
    /// by [`Body::particles`](crate::Body::particles): vertices, then edges, both ascending.
    ///
    /// The field is taken as it is: outside its grid there is no contact, and a rigid body that
    /// pokes through a face without crossing an edge is not detected.
    ///
    /// ```
    /// use distance_field::{DistanceField, FieldDetector, FieldFeature, FieldParams};
    /// use scene::glam::{DQuat, DVec3};
    /// use scene::{BodyKind, Scene};
    /// use surface::{Pose, RigidState, TriangleSurface, progress::Progress};
    ///
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 30.0 * corner);
    /// let bone = TriangleSurface::new(4, faces.clone())?;
    /// let x = bone.positions(&corners)?;
    /// let field = DistanceField::build(&bone, x, &FieldParams::new(1.0), Progress::none())?;
    ///
    /// let mut scene = Scene::new();
    /// let muscle = TriangleSurface::new(4, faces)?;
    /// let muscle = scene.add("muscle", BodyKind::Deformable, muscle, corners.to_vec())?;
    ///
    /// // The bone has moved: one corner of the muscle is 3 above its base.
    /// let state = RigidState::at_rest(Pose::new(DQuat::IDENTITY, DVec3::new(-5.0, -8.0, -3.0)));
    /// let detector = FieldDetector::new(field, 0.0)?;
    /// let contacts = scene.field_contacts(muscle, &detector, &state)?;
    /// assert_eq!(contacts[0].feature, FieldFeature::Vertex(0));
    /// assert!((contacts[0].contact.gap + 3.0).abs() < 1e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] when `body` is of another scene.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    pub fn field_contacts(
        &mut self,
        body: BodyId,
        detector: &FieldDetector,
        state: &RigidState,
    ) -> Result<Vec<FieldContact>, SceneError> {
        self.get_mut(body)?.fit()?;
        let body = self.body(body);
        let mut contacts = FieldContacts::default();
        if let Some(tree) = body.tree() {
            contacts.compute(detector, state, tree, body.contact_surface().particles);
        }
        Ok(contacts.contacts().to_vec())
    }
}
