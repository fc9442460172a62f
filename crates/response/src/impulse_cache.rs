//! Warm starting: impulses kept from one step to the next.

use glam::DVec3;
use surface::Contact;

use crate::{Impulse, ResponseError, check};

/// Cosine of the largest rotation of a normal at which a contact persists: 30°.
/// Contacts of one particle with two objects, or with the two sides of a groove, lie
/// further apart; a normal that slides over a ridge turns less in a step.
const SAME_NORMAL_COSINE: f64 = 0.866;

/// Contacts of the last step with the impulses they ended with.
///
/// ```
/// use glam::DVec3;
/// use response::{Impulse, ImpulseCache};
/// use surface::{Contact, Stencil};
///
/// let contact = |vertex, face| Contact {
///     stencil: Stencil::vertex_face(vertex, face, [0.2, 0.3, 0.5]),
///     anchor: None, normal: DVec3::Z, offset: 0.0, gap: 0.0, time: None,
/// };
/// let push = Impulse { normal: 2.0, tangent: DVec3::ZERO };
/// let mut cache = ImpulseCache::default();
/// cache.store(&[contact(7, [1, 2, 3])], vec![push])?;
///
/// // The vertex has slid to the next face; another one is new.
/// let contacts = [contact(8, [1, 2, 3]), contact(7, [2, 3, 4])];
/// assert_eq!(cache.warm_start(&contacts), [Impulse::default(), push]);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImpulseCache {
    contacts: Vec<Contact>,
    impulses: Vec<Impulse>,
}

impl ImpulseCache {
    /// Returns impulses for `contacts` to start from: the stored ones where a contact
    /// persists, else zero.
    ///
    /// A contact persists where the particles on the side of P are the same and
    /// the normal has turned by less than 30°; the nearest normal counts. Each stored
    /// impulse is used once.
    #[must_use]
    pub fn warm_start(&self, contacts: &[Contact]) -> Vec<Impulse> {
        // Stored contacts sorted by their particles, each used once.
        let mut by_key: Vec<(Key, usize)> = self.contacts.iter().map(key).zip(0..).collect();
        by_key.sort_unstable();
        let mut used = vec![false; self.contacts.len()];

        let mut start = Vec::with_capacity(contacts.len());
        for contact in contacts {
            let key = key(contact);
            let first = by_key.partition_point(|entry| entry.0 < key);
            let same_key = by_key[first..].iter().take_while(|entry| entry.0 == key);

            // The nearest normal; the later one of equally near normals.
            let (mut cosine, mut best) = (SAME_NORMAL_COSINE, None);
            for &(_, number) in same_key.filter(|entry| !used[entry.1]) {
                let turn = self.contacts[number].normal.dot(contact.normal);
                if turn > SAME_NORMAL_COSINE && turn >= cosine {
                    (cosine, best) = (turn, Some(number));
                }
            }
            start.push(best.map_or_else(Impulse::default, |number| self.impulses[number]));
            if let Some(number) = best {
                used[number] = true;
            }
        }
        start
    }

    /// Replaces the stored contacts and impulses.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`] unless there is one impulse per contact.
    pub fn store(
        &mut self,
        contacts: &[Contact],
        impulses: Vec<Impulse>,
    ) -> Result<(), ResponseError> {
        check::count("impulses", contacts.len(), impulses.len())?;
        self.contacts.clear();
        self.contacts.extend_from_slice(contacts);
        self.impulses = impulses;
        Ok(())
    }

    /// Computes the sum of the stored impulses on rigid objects, which are opposite to
    /// those on P.
    #[must_use]
    pub fn impulse_on_rigid(&self) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (contact, impulse) in self.contacts.iter().zip(&self.impulses) {
            if contact.anchor.is_some() {
                sum += -(impulse.normal * contact.normal + impulse.tangent);
            }
        }
        sum
    }
}

/// Particles on the side of P: one, two of an edge, three of a face.
type Key = [u32; 4];

fn key(contact: &Contact) -> Key {
    let mut key = [u32::MAX; 4];
    let of_p = contact.stencil.terms().iter().filter(|term| term.weight.is_sign_negative());
    for (slot, term) in key.iter_mut().zip(of_p) {
        *slot = term.particle;
    }
    key.sort_unstable();
    key
}
