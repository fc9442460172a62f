//! Contact detector of a rigid body: its field with bounds for culling.

use std::sync::Arc;

use glam::DVec3;
use kdop::Dop18;
use surface::{Aabb, Anchor, Contact, ContactSide, Pose, RigidState, Term};

use super::bounds::FieldBounds;
use super::{FieldContact, FieldFeature};
use crate::error::check_not_negative;
use crate::{DistanceField, FieldError, Interpolation, QueryParams, Sample};

/// Contact detector of a rigid body that is given by its distance field.
#[derive(Clone, Debug)]
pub struct FieldDetector {
    field: Arc<DistanceField>,
    margin: f64,
    bounds: FieldBounds,
}

/// Distance of a point from a rigid body, as far as its field holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FieldDistance {
    /// The value of the field.
    Value {
        /// Signed distance, negative inside.
        distance: f64,
        /// Unit direction away from the body.
        normal: DVec3,
    },
    /// A lower bound, where the point is outside the grid or the field is truncated.
    AtLeast(f64),
}

/// Relative widening of bounds, more than rounding moves a point by a pose and back.
const ROUNDING: f64 = 1e-12;

impl FieldDetector {
    /// Builds the bounds of a field, in one pass over its nodes.
    ///
    /// Values of at most `margin` are contacts: 0 reports what is inside by the field; the
    /// error of the field reports also what may be inside.
    ///
    /// # Errors
    ///
    /// [`FieldError::InvalidParam`] when the margin is negative or not finite.
    pub fn new(field: impl Into<Arc<DistanceField>>, margin: f64) -> Result<Self, FieldError> {
        check_not_negative("margin", margin)?;
        let field = field.into();
        let bounds = FieldBounds::new(&field, margin);
        Ok(Self { field, margin, bounds })
    }

    /// Returns the field.
    #[must_use]
    pub fn field(&self) -> &DistanceField {
        &self.field
    }

    /// Returns the margin: values of at most this are contacts.
    #[must_use]
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// Returns the memory of the field and its bounds, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.field.bytes() + self.bounds.bytes()
    }

    /// Computes bounds on all points of the world within the margin; `None` where there is
    /// no such point.
    #[must_use]
    pub fn bounds(&self, pose: &Pose) -> Option<Dop18> {
        let mut corners = self.bounds.corners()?;
        let mut size = 0.0_f64;
        for corner in &mut corners {
            *corner = pose.transform_point(*corner);
            size = size.max(corner.length());
        }
        Some(Dop18::from_points(&corners).inflated(ROUNDING * size))
    }

    /// Computes the distance of a point of the world, by smooth interpolation.
    #[must_use]
    pub fn distance(&self, pose: &Pose, p: DVec3) -> FieldDistance {
        match self.sample(pose, p) {
            Some(Sample { distance, gradient }) if distance < self.bounds.max_value() => {
                FieldDistance::Value { distance, normal: self.normal(pose, p, gradient) }
            }
            Some(_) => FieldDistance::AtLeast(self.bounds.max_value()),
            None => {
                let local = pose.inverse_transform_point(p);
                FieldDistance::AtLeast(self.bounds.min_distance_outside(local))
            }
        }
    }

    /// Builds the contact of a point of the world, which `terms` combine. The point is in the grid,
    /// or rounding has moved it out.
    pub(super) fn contact(
        &self,
        state: &RigidState,
        p: DVec3,
        terms: &[Term],
        feature: FieldFeature,
    ) -> Option<FieldContact> {
        let found = self.sample(&state.pose, p).or_else(|| self.sample_border(&state.pose, p));
        let Sample { distance: gap, gradient } = found?;
        let normal = self.normal(&state.pose, p, gradient);

        // Of the foot on the rigid body, only its velocity at present matters.
        let point = p - gap * normal;
        let velocity = state.velocity_at(point);
        let anchor = ContactSide::Rigid(Anchor { point, velocity, acceleration: DVec3::ZERO });
        let contact = Contact::between(ContactSide::Particles(terms), anchor, normal, gap);
        Some(FieldContact { contact, feature, gradient_length: gradient.length() })
    }

    /// Returns true if a box of the world, given by its lower and upper corner, may contain
    /// a point within the margin.
    ///
    /// It contains none where the value at the center is too high for the gradient to
    /// descend from within the box.
    pub(super) fn may_contain_contact(&self, pose: &Pose, [min, max]: [DVec3; 2]) -> bool {
        let center = Aabb { min, max }.center();
        // Rounding may carry a point of the box out of the ball around it.
        let radius = 0.5 * min.distance(max) + ROUNDING * center.length();
        let local = pose.inverse_transform_point(center);
        let nearest = self.bounds.clamp(local);
        if local.distance(nearest) > radius {
            return false;
        }

        match self.field.evaluate(nearest, Interpolation::Trilinear) {
            Some(found) => self.bounds.may_descend(local, radius, found.distance),
            None => true,
        }
    }

    /// Returns a value that stands for a point of the world outside the grid: that of the
    /// nearest point of the box, or infinity where that is within the margin.
    ///
    /// The nearest point of the box is no farther from any point within the margin.
    pub(super) fn value_outside(&self, pose: &Pose, p: DVec3) -> f64 {
        let nearest = self.bounds.clamp(pose.inverse_transform_point(p));
        let sample = self.field.evaluate(nearest, Interpolation::Trilinear);
        let value = sample.map_or(f64::INFINITY, |sample| sample.distance);
        if value > self.margin { value } else { f64::INFINITY }
    }

    /// Returns the bounds of the field.
    pub(super) fn field_bounds(&self) -> &FieldBounds {
        &self.bounds
    }

    fn sample(&self, pose: &Pose, p: DVec3) -> Option<Sample> {
        let interpolation = Interpolation::Smooth;
        self.field.query(p, &QueryParams { interpolation, offset: 0.0, pose: *pose })
    }

    /// Evaluates the field at the point of the grid that is nearest to a point of the world.
    fn sample_border(&self, pose: &Pose, p: DVec3) -> Option<Sample> {
        let nearest = self.bounds.clamp_to_grid(pose.inverse_transform_point(p));
        let Sample { distance, gradient } = self.field.evaluate(nearest, Interpolation::Smooth)?;
        Some(Sample { distance, gradient: pose.rotation() * gradient })
    }

    /// Returns the direction of a gradient at a point of the world; where that is zero, the
    /// direction away from the center of the box.
    fn normal(&self, pose: &Pose, p: DVec3, gradient: DVec3) -> DVec3 {
        if let Some(normal) = gradient.try_normalize() {
            return normal;
        }
        (p - pose.transform_point(self.bounds.center())).normalize_or(DVec3::Z)
    }
}
