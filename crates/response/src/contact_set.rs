//! Contacts of a step, grouped by pairs of bodies.

use std::ops::Range;

use surface::Contact;

use crate::{Material, RigidMotion};

/// Contacts of a step with the material and the identity of their pair of bodies.
///
/// ```
/// use glam::DVec3;
/// use response::{ContactSet, Margins, Material, RigidMotion};
/// use surface::{Contact, ContactSide, Term};
///
/// let particle = [Term { particle: 0, weight: 1.0 }];
/// let bone = ContactSide::at_rest(DVec3::X * 2.0);
/// let contact = Contact::between(ContactSide::Particles(&particle), bone, DVec3::Z, 0.0);
///
/// // The bone turns about z.
/// let motion = RigidMotion { spin: DVec3::Z * 3.0, ..RigidMotion::default() };
/// let mut contacts = ContactSet::default();
/// contacts.add(7, &Material::hard(Margins::new(0.0, 1.0)?), &motion, &[contact]);
/// let anchor = contacts.contacts()[0].anchor.ok_or("on a bone")?;
/// assert_eq!((anchor.velocity, anchor.acceleration), (DVec3::Y * 6.0, DVec3::X * -18.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactSet {
    contacts: Vec<Contact>,
    groups: Vec<ContactGroup>,
}

/// Consecutive contacts of one pair of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactGroup {
    /// Identity of the pair, by which impulses are found again in the next step.
    pub pair: u64,
    /// Material of its contacts.
    pub material: Material,
    /// Range of its contacts.
    pub contacts: Range<usize>,
}

impl ContactSet {
    /// Removes all contacts; the memory is kept.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.groups.clear();
    }

    /// Adds the contacts of a pair of bodies. Where one of them is rigid, `motion` is its
    /// motion, and sets velocity and acceleration of the contacts' anchors.
    pub fn add(
        &mut self,
        pair: u64,
        material: &Material,
        motion: &RigidMotion,
        contacts: &[Contact],
    ) {
        let start = self.contacts.len();
        self.contacts.extend_from_slice(contacts);

        // V_c and A_c of a bone in motion are those of its anchors.
        for contact in &mut self.contacts[start..] {
            contact.anchor = contact.anchor.map(|anchor| motion.at(anchor.point));
        }

        let contacts = start..self.contacts.len();
        self.groups.push(ContactGroup { pair, material: *material, contacts });
    }

    /// Returns all contacts, group after group.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Returns all contacts, to be changed in place.
    #[must_use]
    pub fn contacts_mut(&mut self) -> &mut [Contact] {
        &mut self.contacts
    }

    /// Returns the groups, in the order they were added.
    #[must_use]
    pub fn groups(&self) -> &[ContactGroup] {
        &self.groups
    }

    /// Returns each contact with its material.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&Contact, &Material)> {
        self.groups.iter().flat_map(|group| {
            self.contacts[group.contacts.clone()].iter().map(|contact| (contact, &group.material))
        })
    }
}
