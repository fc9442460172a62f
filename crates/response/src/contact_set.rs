//! Contacts of a step, grouped by pairs of bodies.

use std::ops::Range;

use glam::DVec3;
use surface::Contact;

use crate::{Material, RigidMotion};

/// Cosine of the angle up to which two normals of the same particles are of one contact.
const SAME_NORMAL: f64 = 0.99;

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

    /// Adds the contacts of another set that are not known yet, by their particles and normals, which
    /// they then are; returns their number.
    pub(crate) fn append_new(&mut self, other: &Self, known: &mut Vec<KnownContact>) -> usize {
        let before = self.contacts.len();
        for group in &other.groups {
            let start = self.contacts.len();
            for contact in &other.contacts[group.contacts.clone()] {
                let key = stencil_key(group.pair, contact);
                // Another normal is that of another face, or of the same after another move.
                if !normals_of(known, key).any(|normal| normal == contact.normal) {
                    let place = known.partition_point(|(other, _)| *other < key);
                    known.insert(place, (key, contact.normal));
                    self.contacts.push(*contact);
                }
            }
            let contacts = start..self.contacts.len();
            self.groups.push(ContactGroup { contacts, ..group.clone() });
        }
        self.contacts.len() - before
    }

    /// Adds contacts of another set that are not found again in this one, in which the same particles
    /// have contacts with other normals or none.
    pub(crate) fn append_unlike(&mut self, other: &Self, known: &mut Vec<KnownContact>) {
        // Sorted by their keys, as the search needs them.
        known.clear();
        for group in &self.groups {
            for contact in &self.contacts[group.contacts.clone()] {
                known.push((stencil_key(group.pair, contact), contact.normal));
            }
        }
        known.sort_unstable_by_key(|(key, _)| *key);

        for group in &other.groups {
            let start = self.contacts.len();
            for contact in &other.contacts[group.contacts.clone()] {
                let mut normals = normals_of(known, stencil_key(group.pair, contact));
                if !normals.any(|normal| normal.dot(contact.normal) > SAME_NORMAL) {
                    self.contacts.push(*contact);
                }
            }
            let contacts = start..self.contacts.len();
            self.groups.push(ContactGroup { contacts, ..group.clone() });
        }
    }

    /// Replaces all contacts by those of another set that fulfill a condition, by their numbers.
    pub(crate) fn copy_chosen(
        &mut self,
        other: &Self,
        is_chosen: impl Fn(usize, &Contact, &Material) -> bool,
    ) {
        self.clear();
        for group in &other.groups {
            let start = self.contacts.len();
            for number in group.contacts.clone() {
                let contact = &other.contacts[number];
                if is_chosen(number, contact, &group.material) {
                    self.contacts.push(*contact);
                }
            }
            let contacts = start..self.contacts.len();
            self.groups.push(ContactGroup { contacts, ..group.clone() });
        }
    }

    /// Brings gaps to present positions, along the same normals.
    pub(crate) fn follow(&mut self, x: &[DVec3]) {
        for contact in &mut self.contacts {
            let separation = contact.separation(|particle| x[particle as usize]);
            contact.gap = -separation.dot(contact.normal) - contact.offset;
        }
    }

    /// Keeps the contacts that fulfill a condition; returns the earliest time of these.
    pub(crate) fn retain_swept(
        &mut self,
        mut is_kept: impl FnMut(&Contact, &Material) -> bool,
    ) -> Option<f64> {
        let (mut kept, mut first) = (0, None);
        for group in &mut self.groups {
            let range = group.contacts.clone();
            group.contacts.start = kept;
            for number in range {
                let contact = self.contacts[number];
                if is_kept(&contact, &group.material) {
                    self.contacts[kept] = contact;
                    kept += 1;
                    let time = contact.time.unwrap_or(0.0);
                    first = Some(first.map_or(time, |first: f64| first.min(time)));
                }
            }
            group.contacts.end = kept;
        }
        self.contacts.truncate(kept);
        first
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

/// Pair of bodies and particles of a contact.
pub(crate) type StencilKey = (u64, [u32; 6]);

/// Contact that is known by its particles and its normal.
pub(crate) type KnownContact = (StencilKey, DVec3);

/// Returns the normals of the contacts, sorted by their keys, that have the same particles.
fn normals_of(known: &[KnownContact], key: StencilKey) -> impl Iterator<Item = DVec3> {
    let first = known.partition_point(|(other, _)| *other < key);
    let same = known[first..].iter().take_while(move |(other, _)| *other == key);
    same.map(|(_, normal)| *normal)
}

fn stencil_key(pair: u64, contact: &Contact) -> StencilKey {
    let mut particles = [u32::MAX; 6];
    for (slot, term) in particles.iter_mut().zip(contact.stencil.terms()) {
        *slot = term.particle;
    }
    (pair, particles)
}
