//! Materials of contacts: the constraints that a pair of bodies imposes at each level.

use glam::DVec3;
use surface::Contact;

use crate::{
    Constraint, ContactLaw, Friction, Margins, ResponseError, Restraint, SolveLevel, SpringDamper,
    StepLength, check,
};

/// Material of the contacts of one pair of bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Clearance and proximity distance.
    pub margins: Margins,
    /// Friction law.
    pub friction: Friction,
    /// Stiffness and damping of a soft contact; `None` for a hard one. A vertex of a reduced
    /// surface has as many springs as it stands for vertices, by the masses that
    /// [follow](crate::Followers) it: bodies sink in as far as with the whole surface.
    pub spring: Option<SpringDamper>,
    /// Part of the motion that a permanent contact restrains, pulling too; `None` for a
    /// contact that may open.
    pub permanent: Option<Restraint>,
}

impl Material {
    /// Returns the material of hard contacts without friction, which may open.
    #[must_use]
    pub fn hard(margins: Margins) -> Self {
        Self { margins, friction: Friction::NONE, spring: None, permanent: None }
    }

    /// Checks that the fields fit together: a sticking contact is hard, since a soft one
    /// needs its place ([`Constraint::Vector`] with a target by
    /// [`SpringDamper::vector_target`]).
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] with the stiffness.
    pub fn validate(&self) -> Result<(), ResponseError> {
        if let (Some(spring), Some(Restraint::Sticking)) = (self.spring, self.permanent) {
            let range = "absent from a sticking contact";
            check::parameter("stiffness", spring.stiffness(), range, false)?;
        }
        Ok(())
    }

    /// Returns true if contacts are hard.
    #[must_use]
    pub fn is_hard(&self) -> bool {
        self.spring.is_none()
    }

    /// Computes the depth of a contact over the clearance.
    pub(crate) fn depth(&self, contact: &Contact) -> f64 {
        self.margins.clearance() - contact.gap
    }

    /// Computes the depth that a correction of positions has to remove: none of soft contacts,
    /// and gaps too of permanent ones.
    pub(crate) fn hard_depth(&self, contact: &Contact) -> f64 {
        let depth = self.depth(contact);
        match (self.spring, self.permanent) {
            (Some(_), _) => 0.0,
            (None, Some(_)) => depth.abs(),
            (None, None) => depth.max(0.0),
        }
    }

    /// Computes the relative speed of a hard contact that a correction has to cancel, for the
    /// relative velocity V_c.
    pub(crate) fn forbidden_speed(&self, contact: &Contact, velocity: DVec3, h: StepLength) -> f64 {
        let approach = velocity.dot(contact.normal);
        if contact.time.is_some() {
            return (approach - self.closing_speed(contact, h)).max(0.0);
        }
        match self.permanent {
            Some(Restraint::Sticking) => velocity.length(),
            Some(Restraint::Sliding) => approach.abs(),
            None => {
                let lambda = self.margins.proximity_factor(self.depth(contact));
                let approach = approach.max(0.0);
                approach - ((1.0 - lambda) * approach).min(self.closing_speed(contact, h))
            }
        }
    }

    /// Computes the speed of approach at which the gap of a contact closes at the end of a step.
    pub(crate) fn closing_speed(&self, contact: &Contact, h: StepLength) -> f64 {
        (-self.depth(contact)).max(0.0) / h.get()
    }

    /// Returns the law and the constraint on displacements of a hard contact. Friction acts on
    /// velocities: taken back here too, the slip would count twice.
    pub(crate) fn position_row(
        &self,
        contact: &Contact,
    ) -> Result<(ContactLaw, Constraint), ResponseError> {
        // Permanent contacts close gaps, too.
        let depth = self.depth(contact);
        let constraint = match self.permanent {
            None => Constraint::Contact,
            Some(Restraint::Sliding) => Constraint::TwoSided(-depth),
            Some(Restraint::Sticking) => Constraint::Vector(-depth * contact.normal),
        };
        Ok((ContactLaw::new(self.margins, 0.0)?, constraint))
    }

    /// Returns the law and the constraint on velocities that move the particles for a step h.
    pub(crate) fn velocity_row(
        &self,
        contact: &Contact,
        h: StepLength,
    ) -> Result<(ContactLaw, Constraint), ResponseError> {
        // Hard: no approach, or no motion of the restrained part.
        let law = ContactLaw::new(self.margins, 0.0)?.with_friction(self.friction);

        // A contact that is met during the move: its gap may close by then.
        if contact.time.is_some() {
            return Ok((law, Constraint::OneSided(self.closing_speed(contact, h))));
        }
        let Some(spring) = self.spring else {
            // A gap may close, but not be passed, however fast the approach is.
            let constraint = match self.permanent {
                None => Constraint::Approach(self.closing_speed(contact, h)),
                Some(Restraint::Sliding) => Constraint::TwoSided(0.0),
                Some(Restraint::Sticking) => Constraint::Vector(DVec3::ZERO),
            };
            return Ok((law, constraint));
        };

        // A spring along the normal. An open gap may close first, without force or damping.
        let law = law.with_compliance(spring.compliance(h))?;
        let depth = self.depth(contact);
        let closed = spring.target(SolveLevel::Velocity, h, depth, 0.0);
        let constraint = match self.permanent {
            Some(_) => Constraint::TwoSided(closed),
            None if depth >= 0.0 => Constraint::OneSided(closed),
            None => Constraint::OneSided(self.closing_speed(contact, h)),
        };
        Ok((law, constraint))
    }
}
