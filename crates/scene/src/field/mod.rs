//! A bone by its distance field against the vertices and edges of a body.
//!
//! The body's tree leaves the faces that the field may have within the margin; their
//! vertices cost one look at the field each. An edge between two vertices
//! outside may still dip into the bone: the field tells the lowest point of its
//! span, so that no offset has to be guessed that keeps edges out.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2: rigid
//! bodies as distance maps, contacts as linear combinations of particles. There,
//! vertices alone are tested, kept away by an offset for the sake of edges.

mod scratch;
mod slopes;
mod volume;

use std::borrow::Cow;

use distance_field::{DistanceField, Interpolation, QueryParams, Sample};
use glam::DVec3;
use kdop::Dop18;
use surface::{Anchor, Contact, RigidState, Stencil};

pub use self::scratch::FieldScratch;
pub use self::volume::Volume;
use crate::{BodyId, Scene, SceneError};

/// A bone's distance field, ready to be asked for contacts.
#[derive(Debug)]
pub struct FieldDetector<'a> {
    field: &'a DistanceField,
    margin: f64,
    volume: Cow<'a, Volume>,
}

/// A vertex or an edge of the body at the bone.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FieldContact {
    /// The contact, with particles numbered by [`Body::particles`](crate::Body::particles)
    /// and the bone for its anchor. Its gap is the field's value.
    pub contact: Contact,
    /// What touches.
    pub feature: FieldFeature,
    /// Length of the field's gradient: near 1 where the normal can be relied on,
    /// less where several parts of the bone are equally near. Where it is 0, the
    /// normal points away from the middle of the bone's box.
    pub steepness: f64,
}

/// What of the body touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum FieldFeature {
    /// A vertex, by its number in the body.
    Vertex(u32),
    /// The span of an edge, by its number in the body's surface, whose ends are
    /// both outside the margin.
    Edge(u32),
}

impl<'a> FieldDetector<'a> {
    /// Looks once at every node, for what bounds the bone and its slopes.
    ///
    /// Values of at most `margin` are contacts: 0 reports what is inside by the
    /// field; the error of the field, of which its report has a measure, reports
    /// also what may be.
    ///
    /// # Errors
    ///
    /// [`SceneError::Margin`] when the margin is negative or not finite.
    pub fn new(field: &'a DistanceField, margin: f64) -> Result<Self, SceneError> {
        if !(margin.is_finite() && margin >= 0.0) {
            return Err(SceneError::Margin { margin });
        }
        Ok(Self { field, margin, volume: Cow::Owned(Volume::of(field, margin)) })
    }

    /// Returns a detector with bounds that were computed before, for the same margin.
    #[must_use]
    pub fn with_volume(field: &'a DistanceField, margin: f64, volume: &'a Volume) -> Self {
        Self { field, margin, volume: Cow::Borrowed(volume) }
    }

    /// Values of at most this are contacts.
    pub(crate) fn margin(&self) -> f64 {
        self.margin
    }

    /// The most that a ball between others may be above the lowest of them: a
    /// twentieth of the spacing.
    #[must_use]
    pub fn ball_tolerance(&self) -> f64 {
        self.field.grid().spacing() / 20.0
    }

    /// The distance at a point of the world, or a bound below where the field does
    /// not tell it: outside of its grid, or where it is truncated.
    pub(crate) fn tell(&self, state: &RigidState, p: DVec3) -> Result<Sample, f64> {
        let query =
            QueryParams { interpolation: Interpolation::Smooth, offset: 0.0, pose: state.pose };
        match self.field.query(p, &query) {
            Some(sample) if sample.distance < self.volume.highest => Ok(sample),
            Some(_) => Err(self.volume.highest),
            // What is within the margin is in the box.
            None => {
                let p = state.pose.inverse_transform_point(p);
                Err(self.margin + p.distance(self.volume.clamp(p)))
            }
        }
    }

    /// The direction of a gradient at a point of the world; where there is none,
    /// that away from the middle of the bone's box.
    pub(crate) fn normal(&self, state: &RigidState, p: DVec3, gradient: DVec3) -> DVec3 {
        let away = || p - state.pose.transform_point(self.volume.middle());
        let normal = gradient.try_normalize().or_else(|| away().try_normalize());
        normal.unwrap_or(DVec3::Z)
    }

    /// Bounds in the world of all that may be within the margin; none where nothing is.
    pub(crate) fn bounds(&self, state: &RigidState) -> Option<Dop18> {
        let corners = self.volume.corners()?.map(|corner| state.pose.transform_point(corner));
        // Turning a point in and back may move it by rounding.
        let rounding = 1e-12 * corners.iter().fold(0.0, |most: f64, p| most.max(p.length()));
        Some(Dop18::from_points(&corners).inflated(rounding))
    }

    /// Whether a value within the margin may be in a box of the world, given by its
    /// lowest and highest corner: none is where the value in the middle is too
    /// high for the steepest slope to come down from.
    fn may_reach(&self, state: &RigidState, [lo, hi]: [DVec3; 2]) -> bool {
        let centre = 0.5 * (lo + hi);
        // Rounding may carry a point of the box outside the ball around it.
        let radius = 0.5 * lo.distance(hi) + 1e-12 * centre.length();
        let p = state.pose.inverse_transform_point(centre);
        let nearest = self.volume.clamp(p);
        if p.distance(nearest) > radius {
            return false;
        }
        let sample = self.field.evaluate(nearest, Interpolation::Trilinear);
        sample.is_none_or(|found| self.volume.may_sink((p, radius), found.distance))
    }

    /// A height for a point outside the grid: that of the nearest point of the box,
    /// which is no farther from whatever is within the margin. Infinite where that is within the margin.
    fn height_outside(&self, state: &RigidState, p: DVec3) -> f64 {
        let nearest = self.volume.clamp(state.pose.inverse_transform_point(p));
        let sample = self.field.evaluate(nearest, Interpolation::Trilinear);
        let height = sample.map_or(f64::INFINITY, |sample| sample.distance);
        if height > self.margin { height } else { f64::INFINITY }
    }

    fn contact(
        &self,
        state: &RigidState,
        (p, stencil, feature): (DVec3, Stencil, FieldFeature),
    ) -> Option<FieldContact> {
        let query =
            QueryParams { interpolation: Interpolation::Smooth, offset: 0.0, pose: state.pose };
        let Sample { distance: gap, gradient } = self.field.query(p, &query)?;
        let steepness = gradient.length();
        let normal = self.normal(state, p, gradient);
        let point = p - gap * normal;
        let velocity = state.velocity_at(point);
        let anchor = Some(Anchor { point, velocity, acceleration: DVec3::ZERO });
        let contact = Contact { stencil, anchor, normal, offset: 0.0, gap, time: None };
        Some(FieldContact { contact, feature, steepness })
    }
}

impl Scene {
    /// Contacts of a body with a bone that is known by its field: vertices
    /// within the margin, ascending, then edges that come within the margin between two
    /// ends that don't, ascending.
    ///
    /// The field is taken as it is: the vertices and edges that it has within the margin
    /// are reported, and no others. A bone that pokes through a face without
    /// touching its edges is not seen. Outside the field's grid nothing touches.
    ///
    /// ```
    /// use distance_field::{FieldParams, DistanceField, Pose};
    /// use scene::glam::{DQuat, DVec3};
    /// use surface::{RigidState, TriangleSurface, progress::Progress};
    /// use scene::{BodyKind, FieldDetector, FieldFeature, Scene};
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
    /// // The bone has moved, so that one corner of the muscle is 3 over its base.
    /// let state = RigidState::at_rest(Pose::new(DQuat::IDENTITY, DVec3::new(-5.0, -8.0, -3.0)));
    /// let detector = FieldDetector::new(&field, 0.0)?;
    /// let contacts = scene.field_contacts(muscle, &detector, &state)?;
    /// assert_eq!(contacts[0].feature, FieldFeature::Vertex(0));
    /// assert!((contacts[0].contact.gap + 3.0).abs() < 1e-4);
    /// assert!((contacts[0].contact.normal + DVec3::Z).length() < 1e-4);
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
        detector: &FieldDetector<'_>,
        state: &RigidState,
    ) -> Result<Vec<FieldContact>, SceneError> {
        self.get_mut(body)?.fit()?;
        let mut scratch = FieldScratch::default();
        let body = self.body(body);
        if let Some(tree) = body.tree() {
            scratch.look(detector, state, tree, body.contact_surface());
        }
        Ok(scratch.contacts)
    }
}
